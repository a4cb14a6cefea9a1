//! Materials of FEBio, compared with the energies in its manuals, or with the stresses of its sources.

use crate::{STATES, agrees, chains, invariants, ogden, read, told};
use nalgebra::Matrix3;
use onset::kinematics::DeformationGradient;
use onset_study::settings::{Program::Febio, law_from};

/// File with a material.
fn file(kind: &str, parameters: &str) -> String {
    format!(
        "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>\n<!-- a file -->\n<febio_spec version=\"4.0\">\n<Material>\n\
         <material id=\"1\" name=\"rubber\" type=\"{kind}\">\n<density>1</density>\n{parameters}\n</material>\n</Material>\n</febio_spec>\n"
    )
}

#[test]
fn materials_of_the_whole_deformation_have_the_energies_of_the_manual() {
    let law = read(Febio, &file("neo-Hookean", "<E>1.3</E><v>0.3</v>"), &[]);
    agrees(&*law, |f| {
        let (i, ln) = (f.invariants(), f.jacobian().ln());
        0.5 * (0.5 * (i.first - 3.0) - ln) + 0.5 * 0.75 * ln * ln
    });
    let text = file("coupled Mooney-Rivlin", "<c1>0.4</c1><c2>0.1</c2><k>2</k>");
    agrees(&*read(Febio, &text, &[]), |f| {
        let (i, ln) = (f.invariants(), f.jacobian().ln());
        0.4 * (i.first - 3.0) + 0.1 * (i.second - 3.0) - 2.0 * 0.6 * ln + ln * ln
    });
    let text = file(
        "Ogden unconstrained",
        "<cp>5</cp><c1>0.6</c1><m1>1.5</m1><c2>0.2</c2><m2>-2</m2>",
    );
    agrees(&*read(Febio, &text, &[]), |f| {
        let (_, _, j, stretches) = invariants(f);
        let term = |c: f64, m: f64| {
            let sum: f64 = stretches.iter().map(|l| l.powf(m)).sum();
            c / (m * m) * (sum - 3.0 - m * j.ln())
        };
        term(0.6, 1.5) + term(0.2, -2.0) + 2.5 * (j - 1.0).powi(2)
    });
}

#[test]
fn uncoupled_materials_have_the_energies_of_the_manual_and_a_pressure_model() {
    type Volume = fn(f64) -> f64;
    let volumes: [(&str, Volume); 5] = [
        ("", |j| j.ln().powi(2) / 2.0),
        ("<pressure_model>default</pressure_model>", |j| {
            j.ln().powi(2) / 2.0
        }),
        ("<pressure_model>NIKE3D</pressure_model>", |j| {
            (j * j - 2.0 * j.ln() - 1.0) / 4.0
        }),
        ("<pressure_model>2</pressure_model>", |j| {
            (j - 1.0).powi(2) / 2.0
        }),
        ("<pressure_model>Abaqus (GOH)</pressure_model>", |j| {
            ((j * j - 1.0) / 2.0 - j.ln()) / 2.0
        }),
    ];
    for (model, volume) in volumes {
        let of = |kind: &str, parameters: &str| {
            read(
                Febio,
                &file(kind, &format!("{parameters}<k>20</k>{model}")),
                &[],
            )
        };
        let u = |f: &DeformationGradient| 20.0 * volume(f.jacobian());
        agrees(&*of("incomp neo-Hookean", "<G>0.7</G>"), |f| {
            0.35 * (invariants(f).0 - 3.0) + u(f)
        });
        agrees(&*of("Mooney-Rivlin", "<c1>0.4</c1><c2>0.1</c2>"), |f| {
            let (i1, i2, _, _) = invariants(f);
            0.4 * (i1 - 3.0) + 0.1 * (i2 - 3.0) + u(f)
        });
        agrees(
            &*of("Ogden", "<c1>0.6</c1><m1>1.3</m1><c3>0.1</c3><m3>-2</m3>"),
            |f| ogden(f, &[(0.6 / 1.69, 1.3), (0.1 / 4.0, -2.0)]) + u(f),
        );
        agrees(&*of("Gent", "<G>0.3</G><Jm>50</Jm>"), |f| {
            -0.15 * 50.0 * (1.0 - (invariants(f).0 - 3.0) / 50.0).ln() + u(f)
        });
    }
    let text = file(
        "polynomial",
        "<c10>0.2</c10><c01>0.05</c01><c11>-0.003</c11><c22>0.001</c22><D1>10</D1><D2>3</D2>",
    );
    agrees(&*read(Febio, &text, &[]), |f| {
        let (i1, i2, j, _) = invariants(f);
        let (x, y) = (i1 - 3.0, i2 - 3.0);
        0.2 * x + 0.05 * y - 0.003 * x * y
            + 1e-3 * (x * y).powi(2)
            + 10.0 * (j - 1.0).powi(2)
            + 3.0 * (j - 1.0).powi(4)
    });
}

/// Cauchy stress `2/J dev(W1 bbar) + k ln J/J` as in the sources, with `W1 = sum c_i x^(i - 1)` and `W1 = mu sum i a_i (I1bar/N)^(i - 1)`, `a = 1/2,
/// 1/10, 11/350, 19/1750, 519/134750`.
#[test]
fn yeoh_and_arruda_boyce_have_the_stresses_of_the_sources() {
    let yeoh = "<c1>0.4</c1><c2>-0.02</c2><c3>0.003</c3><k>20</k>";
    let chain = "<mu>0.27</mu><N>8</N><k>20</k>";
    let factors = [0.5, 0.1, 11.0 / 350.0, 19.0 / 1750.0, 519.0 / 134_750.0];
    type Slope<'f> = &'f dyn Fn(f64) -> f64;
    let slopes: [(&str, &str, Slope<'_>); 2] = [
        ("Yeoh", yeoh, &|i1| {
            0.4 - 0.02 * (i1 - 3.0) + 0.003 * (i1 - 3.0).powi(2)
        }),
        ("Arruda-Boyce", chain, &|i1| {
            let terms = (1..=5).zip(factors);
            0.27 * terms
                .map(|(i, a)| f64::from(i) * a * (i1 / 8.0).powi(i - 1))
                .sum::<f64>()
        }),
    ];
    for (kind, parameters, slope) in slopes {
        let law = read(Febio, &file(kind, parameters), &[]);
        for state in STATES {
            let f = DeformationGradient::new(state).expect("a state");
            let (i1, _, j, _) = invariants(&f);
            let found = law.response(&f).expect("finite").first_piola * f.matrix().transpose() / j;
            let b = f.matrix() * f.matrix().transpose() * j.powf(-2.0 / 3.0);
            let deviator = b - Matrix3::identity() * (b.trace() / 3.0);
            let stress =
                deviator * (2.0 / j * slope(i1)) + Matrix3::identity() * (20.0 * j.ln() / j);
            assert!((found - stress).amax() < 1e-11, "{kind}: {found} {stress}");
        }
        assert!(
            told(Febio, &file(kind, parameters), None)
                .contains("onset reads the law that FEBio evaluates")
        );
    }
    // With many links the first two terms agree with the series.
    let f = DeformationGradient::new(STATES[0]).expect("a state");
    let law = read(
        Febio,
        &file("Arruda-Boyce", "<mu>0.27</mu><N>1e9</N><k>1e-9</k>"),
        &[],
    );
    assert!((law.response(&f).expect("finite").energy - 0.27 * chains(&f, 1e9)).abs() < 1e-9);
}

#[test]
fn a_law_inside_a_viscoelastic_material_is_found() {
    let text = "<material id=\"2\" name=\"skin\" type=\"uncoupled viscoelastic\">\n<g1>0.5</g1>\n<t1>10</t1>\n<k>30</k>\n\
                <elastic type=\"Ogden\">\n<c1>0.6</c1>\n<m1>2</m1>\n</elastic>\n</material>\n<material id=\"3\" type=\"neo-Hookean\"><E>1</E><v>0</v></material>";
    agrees(&*read(Febio, text, &[]), |f| {
        ogden(f, &[(0.15, 2.0)]) + 15.0 * f.jacobian().ln().powi(2)
    });
    let notes = told(Febio, text, None);
    for fact in [
        "material skin (1 of 2; --material ",
        "with a Prony series of 1 term",
        "1.5 times",
    ] {
        assert!(notes.contains(fact), "{fact} is not in {notes}");
    }
    for name in ["2", "skin"] {
        assert!(told(Febio, text, Some(name)).contains("Ogden of FEBio"));
    }
    assert!(told(Febio, text, Some("3")).contains("neo-Hookean of FEBio"));
    assert!(
        told(Febio, text, Some("bone"))
            .contains("no material bone has a hyperelastic law; materials with a law: skin, 3")
    );
}

#[test]
fn parameters_that_the_law_lacks_are_listed_with_their_line() {
    let text = "<material id=\"1\" type=\"Mooney-Rivlin\"><density>1</density><c1>1</c1>\n<c2>0.1</c2><c3>9</c3>\n<k>100</k></material>";
    let notes = told(Febio, text, None);
    assert!(notes.contains("not read: <c3> (line 2)"), "{notes}");
    let plain = told(Febio, &text.replace("<c3>9</c3>", ""), None);
    assert!(!plain.contains("not read"), "{plain}");
}

#[test]
fn unsupported_materials_are_refused_with_their_line() {
    for (text, fact) in [
        (
            file("Ogden", "<c1>1</c1><m1>2</m1>"),
            "a deck:5:1: the material Ogden has no <k>",
        ),
        (
            file("Ogden", "<k>1</k>"),
            "a deck:5:1: the material Ogden has no <c1> other than 0",
        ),
        (
            file("Mooney-Rivlin", "<c1>1</c1><k>0</k>"),
            "a deck:5:1: k is 0",
        ),
        (
            file(
                "Mooney-Rivlin",
                "<c1>1</c1><k>9</k><pressure_model>7</pressure_model>",
            ),
            "a deck:5:1: pressure_model is 7",
        ),
        (
            file("neo-Hookean", "<E>1</E><v>0.5</v>"),
            "a deck:5:1: E is 1 and v is 0.5",
        ),
        (
            file("neo-Hookean", "<E lc=\"1\">1</E><v>0.3</v>"),
            "a deck:7:1: <E> is multiplied by a load curve",
        ),
        (
            file("neo-Hookean", "\n<E type=\"math\">1+X</E><v>0.3</v>"),
            "a deck:8:1: <E> is given by type=\"math\"",
        ),
        (
            file("neo-Hookean", "<E>soft</E><v>0.3</v>"),
            "a deck:7:1: `soft` is not a number",
        ),
        (
            file("Fung orthotropic", "<E1>1</E1>"),
            "a deck:5:1: the type \"Fung orthotropic\" is not supported",
        ),
        (
            "<material id=\"1\" type=\"Ogden\">\n<c1>1</c2>\n</material>".to_owned(),
            "a deck:2:1: the text is not XML",
        ),
        (
            "<Mesh/>".to_owned(),
            "there is no hyperelastic law of FEBio",
        ),
    ] {
        let error = told(Febio, &text, None);
        assert!(error.contains(fact), "{text}: {error}");
    }
}

#[test]
fn the_time_to_read_a_file_is_linear_in_the_number_of_materials() {
    let one =
        "<material id=\"1\" name=\"a\" type=\"neo-Hookean\">\n<E>1</E><v>0.3</v></material>\n";
    let begin = std::time::Instant::now();
    let law = law_from(Febio, "a deck", &one.repeat(20_000), &[]).expect("a law");
    assert_eq!(law.assignments[0], "material.model=neo-hooke");
    // Quadratic work took half a minute in a release build.
    assert!(begin.elapsed().as_secs() < 10, "{:?}", begin.elapsed());
}
