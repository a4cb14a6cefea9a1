//! Keywords of LS-DYNA, compared with the energies in volume II of its Keyword User's Manual.

use crate::{agrees, bulk, chains, invariants, ogden, read, told};
use onset_study::settings::Program::LsDyna;
use onset_study::settings::law_from;

const GENERAL: &str = "*KEYWORD
$ a seal
*MAT_HYPERELASTIC_RUBBER_TITLE
seal, 60 Shore
$#     mid        ro        pr         n        nv         g      sigf       ref
         3   1.1E-09     0.495         0         0       0.0       0.0       0.0
$#     c10       c01       c11       c20       c02       c30    therml
       0.3       0.1     0.004     -0.01      0.02     1.E-3
*END
";

#[test]
fn general_rubber_is_a_polynomial_of_the_isochoric_invariants() {
    let long = "*MAT_077_H+\n                   3              1.1E-9              -0.495                   0\n\
                0,0,0,0,0,0,0,0\n                 0.3                 0.1               0.004               -0.01                0.02               1.E-3\n";
    let everywhere = long.replace("*MAT_077_H+", "*KEYWORD LONG=Y\n*mat_77_h");
    for deck in [GENERAL, long, &everywhere] {
        agrees(&*read(LsDyna, deck, &[]), |f| {
            let (i1, i2, j, _) = invariants(f);
            let (x, y) = (i1 - 3.0, i2 - 3.0);
            0.3 * x + 0.1 * y + 0.004 * x * y - 0.01 * x * x
                + 0.02 * y * y
                + 1e-3 * x.powi(3)
                + 0.5 * bulk(0.8, 0.495) * (j - 1.0).powi(2)
        });
    }
    let neo = "*MAT_077_H\n1, 1.1e-9, 0.49, 0\n0.5\n";
    let neo = law_from(LsDyna, "a deck", neo, &[]).expect("a law");
    assert_eq!(neo.assignments[0], "material.model=yeoh");
}

/// `sum mu/alpha (sum lbar^alpha - 3) + K (J - 1 - ln J)` with up to eight terms.
#[test]
fn ogden_rubber_has_moduli_divided_by_exponents_and_a_logarithmic_volumetric_term() {
    let deck = "*MAT_OGDEN_RUBBER\n7, 1.1e-9, 0.49, 0, 0, 500., 1.\n0.6178,0.001177,-0.009807\n1.3,5.0,-2.0\n0.05, 10.\n0.02, 100.\n";
    let shear = 0.5 * (0.6178 * 1.3 + 0.001177 * 5.0 + 0.009807 * 2.0);
    agrees(&*read(LsDyna, deck, &[]), |f| {
        let j = invariants(f).2;
        ogden(
            f,
            &[
                (0.6178 / 1.3, 1.3),
                (0.001177 / 5.0, 5.0),
                (0.009807 / 2.0, -2.0),
            ],
        ) + bulk(shear, 0.49) * (j - 1.0 - j.ln())
    });
    let notes = told(LsDyna, deck, None);
    for fact in [
        "G and SIGF (line 2)",
        "long-term",
        "LS-DYNA adds G1, G2",
        "1.16895 times",
        "is taken as kappa*(J - 1 - ln(J))",
    ] {
        assert!(notes.contains(fact), "{fact} is not in {notes}");
    }
    let eight = "*MAT_077_O\n7,1.,0.4\n.1,.1,.1,.1,.1,.1,.1,.1\n1.,2.,3.,4.,-1.,-2.,1.5,2.5";
    agrees(&*read(LsDyna, eight, &[]), |f| {
        let j = invariants(f).2;
        let exponents = [1.0, 2.0, 3.0, 4.0, -1.0, -2.0, 1.5, 2.5];
        let terms = exponents.map(|alpha| (0.1 / alpha, alpha));
        let shear = 0.05 * exponents.iter().sum::<f64>();
        ogden(f, &terms) + bulk(shear, 0.4) * (j - 1.0 - j.ln())
    });
}

/// The energy of the whole deformation has the shear modulus `2 (A + B)` and Poisson's ratio of the deck.
#[test]
fn mooney_rivlin_rubber_is_an_energy_of_the_whole_deformation() {
    let deck = "*MAT_MOONEY-RIVLIN_RUBBER\n         1    1.1E-9      0.48       0.3       0.1\n       0.0       0.0       0.0         0\n";
    let law = read(LsDyna, deck, &[]);
    let (a, b, nu) = (0.3, 0.1, 0.48);
    let (c, d) = (
        0.5 * a + b,
        (a * (5.0 * nu - 2.0) + b * (11.0 * nu - 5.0)) / (2.0 * (1.0 - 2.0 * nu)),
    );
    agrees(&*law, |f| {
        let i = f.invariants();
        a * (i.first - 3.0)
            + b * (i.second - 3.0)
            + c * (i.third.powi(-2) - 1.0)
            + d * (i.third - 1.0).powi(2)
    });
    let rest = law.undeformed().expect("a reference");
    assert!(rest.first_piola.amax() < 1e-14);
    let [lateral, shear] = [(0, 0, 1, 1), (0, 1, 0, 1)].map(|place| rest.tangent[place]);
    assert!((shear - 0.8).abs() < 1e-12, "{shear}");
    assert!((lateral / (2.0 * (lateral + shear)) - nu).abs() < 1e-12);
    let incompressible = "*MAT_027\n1,1.,0.5,0.3,0.1";
    let read = law_from(LsDyna, "a deck", incompressible, &[]).expect("a law");
    assert_eq!(
        read.assignments[0],
        "material.model=mooney-rivlin-isochoric"
    );
    let notes = told(LsDyna, incompressible, None);
    assert!(notes.contains("--incompressible"), "{notes}");
}

#[test]
fn arruda_boyce_has_a_number_of_links_and_hill_foam_one_volumetric_exponent() {
    let deck = "*MAT_127\n1,1.1e-9,50.,0.27,26.5\n0,0,6\n";
    agrees(&*read(LsDyna, deck, &[]), |f| {
        0.27 * chains(f, 26.5) + 25.0 * (invariants(f).2 - 1.0).powi(2)
    });
    let deck = "*MAT_HILL_FOAM\n1,1.1e-10,10.,0.92,0.05,0,1\n1.85,-9.2\n4.5,-4.5\n";
    agrees(&*read(LsDyna, deck, &[]), |f| {
        let (_, _, j, stretches) = invariants(f);
        let term = |c: f64, b: f64| {
            let sum: f64 = stretches.iter().map(|l| l.powf(b)).sum();
            c / b * (sum - 3.0 + (j.powf(-0.92 * b) - 1.0) / 0.92)
        };
        term(1.85, 4.5) + term(-9.2, -4.5)
    });
    let four = "*MAT_177\n1,1.,1.,0.\n1.,1.,1.,1.\n1.,2.,3.,4.\n";
    agrees(&*read(LsDyna, four, &[]), |f| {
        let (_, _, j, stretches) = invariants(f);
        let term = |b: f64| {
            let sum: f64 = stretches.iter().map(|l| l.powf(b)).sum();
            (sum - 3.0 - b * j.ln()) / b
        };
        (1..=4).map(|b| term(f64::from(b))).sum()
    });
}

#[test]
fn materials_are_chosen_by_number() {
    let two = format!(
        "{}*MAT_ADD_EROSION\n4,1.\n*MAT_027\n4,1.,0.49,0.3,0.1\n",
        GENERAL.replace("*END\n", "")
    );
    let first = told(LsDyna, &two, None);
    assert!(first.contains("material 3 (1 of 2; --material "), "{first}");
    let second = told(LsDyna, &two, Some("4"));
    assert!(second.contains("*MAT_027 of LS-DYNA"), "{second}");
    assert!(second.contains("*MAT_ADD_EROSION (line 9)"), "{second}");
    assert!(
        told(LsDyna, &two, Some("5"))
            .contains("no material 5 has a hyperelastic law; materials with a law: 3, 4")
    );
}

#[test]
fn decks_without_constants_are_refused_with_their_line() {
    for (deck, fact) in [
        (
            "*MAT_077_H\n1,1.,0.49,2\n1.,1.,1.,5\n",
            "a deck:2:1: N = 2: LS-DYNA fits",
        ),
        (
            "*MAT_077_O\n1,1.,0.49,-1\n1\n2\n",
            "a deck:2:1: N = -1: the constants are curves",
        ),
        (
            "*MAT_077_H\n1,1.,,0\n0.5\n",
            "a deck:2:1: PR, Poisson's ratio, is missing",
        ),
        ("*MAT_077_H\n1,1.,0.6,0\n0.5\n", "a deck:2:1: PR is 0.6"),
        (
            "*MAT_077_H\n1,1.,-0.49,0\n0,0,0,0,0,0.1\n0.5\n",
            "a deck:3:1: D1, D2 or D3 is set",
        ),
        (
            "*MAT_077_H\n1,1.,0.49,0\n",
            "a deck:1:1: *MAT_077_H has 1 data lines; line 2 is missing",
        ),
        (
            "*MAT_077_H\n1,1.,0.49,0\n&c10\n",
            "a deck:3:1: `&c10` is not a number",
        ),
        (
            "*MAT_077_O\n1,1.,0.49,0\n1.,2.\n1.,0.\n",
            "a deck:3:1: an exponent alpha is 0",
        ),
        (
            "*MAT_027\n1,1.,0.49\n1.,1.,1.,5\n",
            "a deck:2:1: A = B = 0: LS-DYNA fits",
        ),
        (
            "*MAT_177\n1,1.,1.,0.,0.,9\n",
            "a deck:2:1: LCID = 9: LS-DYNA fits",
        ),
        (
            "*MAT_127\n1,1.,0.,1.,8.\n",
            "a deck:2:1: K is 0, G is 1 and N is 8",
        ),
        (
            "$\n*MAT_181\n1,1.\n",
            "a deck:2:1: *MAT_181 is a table of tests",
        ),
        (
            "*MAT_RIGID\n1,1.,210.,0.3\n",
            "a deck:1:1: *MAT_RIGID is not supported",
        ),
        (
            "*NODE\n1,0.,0.,0.\n",
            "there is no hyperelastic law of LS-DYNA",
        ),
    ] {
        let error = told(LsDyna, deck, None);
        assert!(error.contains(fact), "{deck}: {error}");
    }
}
