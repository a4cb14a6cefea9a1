//! Materials of Radioss, compared with the energies in its Reference Guide.

use crate::{agrees, bulk, chains, invariants, ogden, read, told};
use onset_study::settings::Program::Radioss;

const OGDEN: &str = "#RADIOSS STARTER
/MAT/LAW42/5/1
rubber of Treloar
#              RHO_I
              1.1E-9                   0
#                 Nu           sigma_cut           funIDbulk         Fscale_bulk         M    I_form
                .495                 100                   0                   0         2         0
#               Mu_1                Mu_2                Mu_3                Mu_4                Mu_5
              0.6178            0.001177           -0.009807
#
                 0.1
#            alpha_1             alpha_2             alpha_3             alpha_4             alpha_5
                 1.3                   5                  -2
                 2.5
#
                 0.1                0.05
                   1                  10
/END
";

#[test]
fn law_42_has_moduli_divided_by_exponents_on_two_lines() {
    let shear = 0.5 * (0.6178 * 1.3 + 0.001177 * 5.0 + 0.009807 * 2.0 + 0.1 * 2.5);
    let isochoric = [
        (0.6178 / 1.3, 1.3),
        (0.001177 / 5.0, 5.0),
        (0.009807 / 2.0, -2.0),
        (0.04, 2.5),
    ];
    agrees(&*read(Radioss, OGDEN, &[]), |f| {
        ogden(f, &isochoric) + 0.5 * bulk(shear, 0.495) * (invariants(f).2 - 1.0).powi(2)
    });
    let modified = OGDEN
        .replace("2         0\n", "2         2\n")
        .replace("/MAT/LAW42", "/MAT/OGDEN")
        .replace(".495", "0.0 ");
    agrees(&*read(Radioss, &modified, &[]), |f| {
        let j = invariants(f).2;
        ogden(f, &isochoric) + bulk(shear, 0.495) * (j - 1.0 - j.ln())
    });
    let notes = told(Radioss, OGDEN, None);
    for fact in [
        "/MAT/LAW42 of Radioss",
        "sigma_cut (line 7)",
        "a Prony series",
        "long-term",
        "Radioss adds the viscous moduli",
    ] {
        assert!(notes.contains(fact), "{fact} is not in {notes}");
    }
}

#[test]
fn law_82_has_shear_moduli_and_powers_of_the_volume() {
    let deck = |nu: &str| {
        format!(
            "/MAT/LAW82/1\nfoam\n#\n                1E-9\n         2          {nu:>20}\n                 0.4                0.01\n                 1.3                 5.0\n                0.02                 0.3\n"
        )
    };
    let isochoric = [(0.8 / 1.69, 1.3), (0.02 / 25.0, 5.0)];
    agrees(&*read(Radioss, &deck("0"), &[]), |f| {
        let j = invariants(f).2 - 1.0;
        ogden(f, &isochoric) + j.powi(2) / 0.02 + j.powi(4) / 0.3
    });
    agrees(&*read(Radioss, &deck(".48"), &[]), |f| {
        let j = invariants(f).2 - 1.0;
        ogden(f, &isochoric) + 0.5 * bulk(0.41, 0.48) * j.powi(2) + j.powi(4) / 0.3
    });
}

#[test]
fn law_92_is_the_series_of_arruda_and_boyce() {
    let deck = |d: &str| {
        format!(
            "/MAT/LAW92/1\nrubber\n                1E-9\n                0.27{d:>20}                 5.0\n         0         0                 0.0\n"
        )
    };
    let volume = |f: &_| {
        let j: f64 = invariants(f).2;
        (j * j - 1.0) / 2.0 - j.ln()
    };
    agrees(&*read(Radioss, &deck("0.04"), &[]), |f| {
        0.27 * chains(f, 25.0) + volume(f) / 0.04
    });
    let x: f64 = 1.0 / 25.0;
    let shear = 0.27
        * (1.0
            + 3.0 / 5.0 * x
            + 99.0 / 175.0 * x.powi(2)
            + 513.0 / 875.0 * x.powi(3)
            + 42039.0 / 67375.0 * x.powi(4));
    agrees(&*read(Radioss, &deck("0"), &[]), |f| {
        0.27 * chains(f, 25.0) + 0.5 * bulk(shear, 0.495) * volume(f)
    });
}

#[test]
fn laws_94_and_100_are_polynomials() {
    let deck = "/MAT/YEOH/1\nrubber\n                1E-9\n\n                 0.4               -0.01               0.001\n                0.02                 0.3\n";
    agrees(&*read(Radioss, deck, &[]), |f| {
        let (i1, _, j, _) = invariants(f);
        let x = i1 - 3.0;
        0.4 * x - 0.01 * x * x
            + 1e-3 * x.powi(3)
            + (j - 1.0).powi(2) / 0.02
            + (j - 1.0).powi(4) / 0.3
    });
    let deck = "/MAT/LAW100/1\nrubber\n                1E-9\n         0         1         0\n                 0.2                0.05                0.01              -0.003               0.002\n\
                1E-3                2E-3                3E-3                4E-3\n                 0.1\n"
        .replace("\n1E-3", "\n                1E-3");
    agrees(&*read(Radioss, &deck, &[]), |f| {
        let (i1, i2, j, _) = invariants(f);
        let (x, y) = (i1 - 3.0, i2 - 3.0);
        0.2 * x + 0.05 * y + 0.01 * x * x - 0.003 * x * y
            + 0.002 * y * y
            + 1e-3 * x.powi(3)
            + 2e-3 * x * x * y
            + 3e-3 * x * y * y
            + 4e-3 * y.powi(3)
            + (j - 1.0).powi(2) / 0.1
    });
    let deck = "/MAT/MNF/1\nrubber\n                1E-9\n         1         4         0\n                 0.2                0.05                 0.0\n";
    agrees(&*read(Radioss, deck, &[]), |f| {
        let (i1, i2, j, _) = invariants(f);
        0.2 * (i1 - 3.0) + 0.05 * (i2 - 3.0) + 0.5 * bulk(0.5, 0.495) * (j - 1.0).powi(2)
    });
    assert!(told(Radioss, deck, None).contains("N_net (line 4)"));
}

#[test]
fn law_62_is_a_foam_with_one_ratio_or_one_for_each_term() {
    let deck = |ratios: &str, rigid: u8| {
        format!(
            "/MAT/LAW62/1\nfoam\n                1E-9\n                0.25         2         1                   0         0{rigid:>10}\n                1.85                 0.2\n                 4.5                -2.0\n                 0.2\n                  10\n{ratios}"
        )
    };
    let foam = |f: &_, mu: f64, alpha: f64, nu: f64| {
        let (_, _, j, stretches) = invariants(f);
        let beta = nu / (1.0 - 2.0 * nu);
        let sum: f64 = stretches.iter().map(|l| l.powf(alpha)).sum();
        2.0 * mu / (alpha * alpha) * (sum - 3.0 + (j.powf(-alpha * beta) - 1.0) / beta)
    };
    // Before any relaxation the constants are the moduli.
    let fast = ["material.loading=fast"];
    agrees(&*read(Radioss, &deck("", 0), &fast), |f| {
        foam(f, 1.85, 4.5, 0.25) + foam(f, 0.2, -2.0, 0.25)
    });
    let ratios = "                 0.1                 0.3\n";
    agrees(&*read(Radioss, &deck(ratios, 2), &fast), |f| {
        (foam(f, 1.85, 4.5, 0.1) + foam(f, 0.2, -2.0, 0.3)) / 0.8
    });
    let notes = told(Radioss, &deck("", 0), None);
    assert!(
        notes.contains("instantaneous") && notes.contains("1.64"),
        "{notes}"
    );
}

#[test]
fn materials_that_need_functions_are_refused_with_their_line() {
    for (deck, fact) in [
        (
            "#\n/MAT/LAW69/1\nrubber\n                1E-9\n",
            "a deck:2:1: the Starter fits the constants of /MAT/LAW69 to a curve",
        ),
        (
            "/MAT/LAW42/1\nrubber\n1E-9\n                .495                   0                   9\n",
            "a deck:4:1: funIDbulk = 9: the law depends on a function",
        ),
        (
            "/MAT/LAW42/1\nrubber\n1E-9\n                 0.5\n",
            "a deck:4:1: Nu is 0.5",
        ),
        (
            "/MAT/LAW42/1\nrubber\n1E-9\n                .495\n1\n",
            "a deck:1:1: /MAT/LAW42 has 3 lines after its title; line 4 is missing",
        ),
        (
            "/MAT/LAW42/1\nrubber\n1E-9\n                .495\n\n\n2\n\n",
            "a deck:5:1: all moduli are 0",
        ),
        (
            "/MAT/LAW92/1\nrubber\n1E-9\n                0.27\n         1         7\n",
            "a deck:5:1: fct_ID = 7: the law depends on a function",
        ),
        (
            "/MAT/LAW100/1\nrubber\n1E-9\n         0        13         0\n",
            "a deck:4:1: Flag_HE is 13",
        ),
        (
            "/MAT/LAW82/1\nrubber\n1E-9\n       2.5\n",
            "a deck:4:1: N is 2.5",
        ),
        (
            "/MAT/ELAST/1\nsteel\n",
            "a deck:1:1: /MAT/ELAST is not supported",
        ),
        ("/NODE\n", "there is no hyperelastic law of Radioss"),
    ] {
        let error = told(Radioss, deck, None);
        assert!(error.contains(fact), "{deck}: {error}");
    }
    let two = format!(
        "{}/MAT/YEOH/8\nsecond\n1E-9\n\n                 0.4\n                0.02\n",
        OGDEN.replace("/END\n", "")
    );
    assert!(told(Radioss, &two, None).contains("material 5 (1 of 2; --material "));
    assert!(told(Radioss, &two, Some("8")).contains("material 8 (2 of 2"));
    assert!(
        told(Radioss, &two, Some("9"))
            .contains("no material 9 has a hyperelastic law; materials with a law: 5, 8")
    );
}
