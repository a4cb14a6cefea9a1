//! Laws written for other programs and read back.

use crate::read;
use onset::criteria::{Mode, Range};
use onset::kinematics::DeformationGradient;
use onset::material::Hyperelastic;
use onset_study::criteria::Question;
use onset_study::settings::Program::{
    self, Abaqus, Ansys, Calculix, Febio, Felupe, Hyperelastic as Package, LsDyna, Radioss,
};
use onset_study::settings::{MaterialSettings, WriteError, law_from, law_written};

type Parameters = Vec<(&'static str, f64)>;

/// Law with its parameters, and the programs that lack it.
struct Case {
    law: &'static str,
    parameters: Parameters,
    lacking: Vec<Program>,
}

fn cases() -> Vec<Case> {
    let case = |law, parameters: &[(&'static str, f64)], lacking: &[Program]| Case {
        law,
        parameters: parameters.to_vec(),
        lacking: lacking.to_vec(),
    };
    let mut cases = vec![
        case("neo-hooke-isochoric", &[("mu", 0.7), ("kappa", 35.0)], &[]),
        case(
            "mooney-rivlin-isochoric",
            &[("c10", 0.4), ("c01", 0.1), ("kappa", 40.0)],
            &[],
        ),
        case(
            "yeoh",
            &[
                ("c10", 0.51),
                ("c20", -0.0123),
                ("c30", 1.1e-3),
                ("kappa", 1.0 / 0.03),
            ],
            &[],
        ),
        case(
            "arruda-boyce",
            &[("mu", 0.27), ("locking", 2.7), ("kappa", 20.0)],
            &[Febio, Package],
        ),
        case(
            "gent",
            &[("mu", 1.0 / 3.0), ("jm", 97.2), ("kappa", 20.0)],
            &[Abaqus, Calculix, LsDyna, Radioss, Felupe, Package],
        ),
        case(
            "polynomial",
            &[
                ("c10", 0.2),
                ("c01", 0.05),
                ("c20", 0.01),
                ("c11", -0.003),
                ("c02", 0.002),
                ("kappa", 20.0),
            ],
            &[Felupe, Package],
        ),
        case(
            "polynomial",
            &[
                ("c10", 0.2),
                ("c01", 0.05),
                ("c20", 0.01),
                ("c11", -0.003),
                ("c30", 1e-3),
                ("kappa", 20.0),
            ],
            &[Febio],
        ),
        case(
            "polynomial",
            &[
                ("c03", 4e-3),
                ("c10", 0.2),
                ("c01", 0.05),
                ("c20", 0.01),
                ("c11", -0.003),
                ("c02", 0.002),
                ("c30", 1e-3),
                ("c21", 2e-3),
                ("c12", 3e-3),
                ("kappa", 20.0),
            ],
            &[LsDyna, Febio, Felupe, Package],
        ),
        case(
            "polynomial",
            &[("c10", 0.2), ("c20", -1e-3), ("c50", 1e-7), ("kappa", 20.0)],
            &[Calculix, LsDyna, Radioss, Felupe, Package],
        ),
    ];
    let terms = [
        ("mu1", "alpha1", 0.6178, 1.3),
        ("mu2", "alpha2", 0.001_177, 5.0),
        ("mu3", "alpha3", -0.009_807, -2.0),
        ("mu4", "alpha4", 0.1 / 3.0, 1.7),
        ("mu5", "alpha5", -0.02, -1.1),
        ("mu6", "alpha6", 1e-4, 7.3),
    ];
    let foam = [
        [("mu1", 1.85), ("alpha1", 4.5), ("beta1", 0.92)],
        [("mu2", 0.2), ("alpha2", -2.0), ("beta2", 0.92)],
        [("mu3", 0.3), ("alpha3", 2.2), ("beta3", 0.92)],
    ];
    for count in 1..=6 {
        let own = terms[..count]
            .iter()
            .flat_map(|(mu, alpha, a, b)| [(*mu, *a), (*alpha, *b)]);
        let own: Parameters = own.chain([("kappa", 25.0)]).collect();
        let lacking: &[Program] = if count > 3 { &[Calculix] } else { &[] };
        cases.push(case("ogden", &own, lacking));
        if count <= 3 {
            let own = foam[..count].concat();
            cases.push(case("hyperfoam", &own, &[Febio, Package]));
        }
    }
    cases
}

/// Settings of the law in the library.
fn own(case: &Case) -> MaterialSettings {
    let mut assignments = vec![format!("material.model={}", case.law)];
    if case.law == "polynomial" {
        let terms = case.parameters.iter().filter(|(name, _)| *name != "kappa");
        let terms: Vec<String> = terms
            .map(|(name, _)| {
                format!(
                    "{name}*(I1bar - 3)^{}*(I2bar - 3)^{}",
                    &name[1..2],
                    &name[2..3]
                )
            })
            .collect();
        assignments = vec![
            "material.model=formula".to_owned(),
            format!("material.energy={} + kappa/2*(J - 1)^2", terms.join(" + ")),
        ];
    }
    if ["ogden", "hyperfoam"].contains(&case.law) {
        let zeros = ["mu1", "mu2", "mu3"].into_iter();
        let missing = zeros.filter(|name| !case.parameters.iter().any(|(own, _)| own == name));
        assignments.extend(missing.map(|name| format!("material.{name}=0")));
    }
    let own = case.parameters.iter();
    assignments.extend(own.map(|(name, value)| format!("material.{name}={value}")));
    MaterialSettings::of_file("", "", &assignments).expect("settings")
}

/// Twenty states with stretches up to about 2, from a fixed sequence.
fn states() -> Vec<DeformationGradient> {
    let mut seed = 7_u64;
    let mut next = || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let states = std::iter::repeat_with(|| {
        let mut state = [[0.0; 3]; 3];
        for (i, row) in state.iter_mut().enumerate() {
            for (j, own) in row.iter_mut().enumerate() {
                *own = next() + if i == j { 1.1 } else { 0.0 };
            }
        }
        DeformationGradient::new(state)
    });
    states.flatten().take(20).collect()
}

/// Same state at constant volume.
fn isochoric(f: &DeformationGradient) -> DeformationGradient {
    let scaled = f.matrix() / f.jacobian().cbrt();
    DeformationGradient::new(std::array::from_fn(|i| {
        std::array::from_fn(|j| scaled[(i, j)])
    }))
    .expect("a state")
}

fn equal_stresses(
    one: &dyn Hyperelastic,
    other: &dyn Hyperelastic,
    f: &DeformationGradient,
    what: &str,
) {
    let [one, other] = [one, other].map(|law| law.response(f).expect("finite").first_piola);
    let error = (one - other).amax() / one.amax();
    assert!(error < 1e-12, "{what}: {error:e}");
}

#[test]
fn written_blocks_read_back_as_the_same_law() {
    for case in cases() {
        let law = own(&case).build().expect("a law");
        for program in Program::ALL {
            let what = format!(
                "{} {:?} for {}",
                case.law,
                case.parameters.len(),
                program.title()
            );
            let written = match law_written(program, case.law, &case.parameters) {
                Err(WriteError::Lacks { others, .. }) => {
                    assert!(case.lacking.contains(&program), "{what} is lacking");
                    let having = Program::ALL
                        .into_iter()
                        .filter(|own| !case.lacking.contains(own));
                    assert!(others.into_iter().eq(having), "{what}");
                    continue;
                }
                written => written.expect(&what),
            };
            assert!(!case.lacking.contains(&program), "{what}: {}", written.text);
            assert!(
                written.text.contains("stresses in the units of the input"),
                "{}",
                written.text
            );
            for note in &written.notes {
                assert!(written.text.contains(note.as_str()), "{what}: {note}");
            }
            let found = read(program, &written.text, &[]);
            let has_other_volume = written
                .notes
                .iter()
                .any(|note| note.starts_with("volumetric energy"));
            for f in states() {
                let f = if has_other_volume { isochoric(&f) } else { f };
                equal_stresses(&*law, &*found, &f, &what);
            }
            let [one, other] =
                [&law, &found].map(|law| law.undeformed().expect("a reference").tangent);
            for place in [(0, 0, 0, 0), (0, 0, 1, 1), (0, 1, 0, 1)] {
                assert!((one[place] / other[place] - 1.0).abs() < 1e-9, "{what}");
            }
        }
    }
}

/// Limits of the incompressible response, which no volumetric function changes.
#[test]
fn written_blocks_read_back_with_equal_limits() {
    let limits = |settings: &MaterialSettings| {
        let range = Range::new(0.3, 4.0).expect("a range");
        let question = Question::new(settings, range, &[Mode::Equibiaxial]).expect("a question");
        let card = question.incompressible().expect("an isotropic law").card();
        let loadings = card.expect("a card").loadings.into_iter();
        let criteria = loadings.flat_map(|loading| loading.criteria);
        let limits = criteria.flat_map(|own| [own.compression, own.tension]);
        let limits = limits.map(|limit| limit.map(|limit| limit.imposed));
        limits.collect::<Vec<Option<f64>>>()
    };
    let mut count = 0;
    for law in ["mooney-rivlin-isochoric", "polynomial", "ogden"] {
        let case = cases()
            .into_iter()
            .find(|case| case.law == law)
            .expect("a case");
        let expected = limits(&own(&case));
        let having = Program::ALL
            .into_iter()
            .filter(|own| !case.lacking.contains(own));
        for program in having {
            let written = law_written(program, law, &case.parameters).expect("a block");
            let reading = law_from(program, "a deck", &written.text, &[]).expect("a law");
            let settings =
                MaterialSettings::of_file("", "", &reading.assignments).expect("settings");
            for (found, expected) in limits(&settings).into_iter().zip(&expected) {
                let equal = match (found, expected) {
                    (Some(found), Some(expected)) => (found / expected - 1.0).abs() < 1e-8,
                    (found, expected) => found == *expected,
                };
                assert!(equal, "{law} {}: {found:?} {expected:?}", program.title());
                count += usize::from(found.is_some());
            }
        }
    }
    assert!(count > 30, "{count} limits");
}

/// Blocks as written in the manuals, with constants converted by hand.
#[test]
fn written_blocks_use_the_constants_of_the_manuals() {
    let ogden = [
        ("mu1", 0.6),
        ("alpha1", 1.3),
        ("mu2", -0.01),
        ("alpha2", -2.0),
        ("kappa", 50.0),
    ];
    let mooney = [("c10", 0.4), ("c01", 0.1), ("kappa", 50.0)];
    let foam = [("mu1", 2.0), ("alpha1", 4.0), ("beta1", 0.5)];
    for (program, law, parameters, block) in [
        (
            Abaqus,
            "ogden",
            &ogden[..],
            "*HYPERELASTIC, OGDEN, N=2\n0.39, 1.3, 0.01, -2.0, 0.04, 0.0\n",
        ),
        (
            Abaqus,
            "mooney-rivlin-isochoric",
            &mooney,
            "*HYPERELASTIC, MOONEY-RIVLIN\n0.4, 0.1, 0.04\n",
        ),
        (
            Abaqus,
            "hyperfoam",
            &foam,
            "*HYPERFOAM, N=1\n2.0, 4.0, 0.25\n",
        ),
        (
            Calculix,
            "ogden",
            &ogden,
            "*HYPERELASTIC, OGDEN, N=2\n0.39, 1.3, 0.01, -2.0, 0.04, 4e18\n",
        ),
        (
            Ansys,
            "ogden",
            &ogden,
            "TB,HYPER,1,,2,OGDEN\nTBDATA,1,0.6, 1.3, -0.01, -2.0, 0.04, 0.0\n",
        ),
        (
            Ansys,
            "hyperfoam",
            &foam,
            "TB,HYPER,1,,1,FOAM\nTBDATA,1,1.0, 4.0, 0.5\n",
        ),
        (
            LsDyna,
            "mooney-rivlin-isochoric",
            &mooney,
            "*MAT_HYPERELASTIC_RUBBER+\n                   1                 1.0  0.4900662251655629                 0.0\n                 0.4                 0.1                 0.0                 0.0                 0.0                 0.0\n",
        ),
        (
            Radioss,
            "mooney-rivlin-isochoric",
            &mooney,
            "/MAT/LAW42/1\nlaw\n                 1.0\n  0.4900662251655629\n                 0.8                -0.2\n\n                 2.0                -2.0\n\n",
        ),
        (
            Febio,
            "ogden",
            &ogden,
            "<material id=\"1\" name=\"law\" type=\"Ogden\">\n  <density>1</density>\n  <c1>0.78</c1>\n  <m1>1.3</m1>\n  <c2>0.02</c2>\n  <m2>-2</m2>\n  <k>50</k>\n  <pressure_model>2</pressure_model>\n</material>\n",
        ),
        (
            Felupe,
            "ogden",
            &ogden,
            "umat = fem.Hyperelastic(fem.ogden, mu=[0.39, 0.01], alpha=[1.3, -2.0]) & fem.Volumetric(bulk=50.0)\n",
        ),
    ] {
        let written = law_written(program, law, parameters).expect("a block");
        assert!(written.text.ends_with(block), "{}", written.text);
        assert!(
            written
                .text
                .contains(&format!("law {law}; stresses in the units of the input")),
            "{}",
            written.text
        );
    }
}

#[test]
fn laws_and_constants_that_cannot_be_written_are_refused_with_a_reason() {
    let kappa = ("kappa", 1.0);
    for (program, law, parameters, fact) in [
        (
            Abaqus,
            "yeo",
            &[kappa][..],
            "yeo cannot be written for other programs; laws that can: neo-hooke-isochoric,",
        ),
        (Abaqus, "yeo", &[kappa], "did you mean `yeoh`?"),
        (
            Abaqus,
            "gent",
            &[("mu", 1.0), ("jm", 9.0)],
            "Abaqus has no gent of this form; programs that have it: ANSYS, FEBio",
        ),
        (
            Abaqus,
            "yeoh",
            &[("c10", 1.0), ("c20", 0.0)],
            "yeoh: c30 is missing",
        ),
        (
            Abaqus,
            "polynomial",
            &[("c10", 1.0), ("d1", 0.1)],
            "polynomial: there is no parameter `d1`; expected c10",
        ),
        (
            Abaqus,
            "ogden",
            &[("mu1", 1.0), ("alpha1", 2.0), ("beta1", 1.0)],
            "ogden: there is no parameter `beta1`",
        ),
        (
            Abaqus,
            "ogden",
            &[("mu1", 1.0), ("alpha1", 0.0)],
            "ogden: an exponent alpha is 0",
        ),
        (
            Abaqus,
            "ogden",
            &[("mu1", 1.0), ("alpha1", -2.0)],
            "ogden: the shear modulus is -1",
        ),
        (
            Abaqus,
            "gent",
            &[("mu", f64::NAN), ("jm", 9.0)],
            "gent: mu is NaN",
        ),
        (
            Abaqus,
            "gent",
            &[("mu", 1.0), ("jm", 9.0), ("kappa", 0.0)],
            "gent: kappa is 0",
        ),
        (
            LsDyna,
            "ogden",
            &[("mu1", 1.0), ("alpha1", 2.0)],
            "LS-DYNA: a block needs the bulk modulus; add kappa",
        ),
        (
            LsDyna,
            "ogden",
            &[("mu1", 1.0), ("alpha1", 2.0), ("kappa", 1e20)],
            "LS-DYNA: the bulk modulus",
        ),
        (
            LsDyna,
            "hyperfoam",
            &[
                ("mu1", 1.0),
                ("alpha1", 2.0),
                ("beta1", 1.0),
                ("mu2", 1.0),
                ("alpha2", 3.0),
                ("beta2", 2.0),
            ],
            "LS-DYNA: *MAT_HILL_FOAM has one volumetric exponent",
        ),
        (
            Radioss,
            "hyperfoam",
            &[("mu1", 1.0), ("alpha1", 2.0), ("beta1", 1e4)],
            "Radioss: LAW62 allows Poisson's ratios up to 0.499",
        ),
        (
            Calculix,
            "ogden",
            &[("mu1", 1e6), ("alpha1", 2.0), ("kappa", 1e12)],
            "CalculiX: D1 = 2/kappa = 0.000000000002 is below 1e-10",
        ),
    ] {
        let error = law_written(program, law, parameters)
            .expect_err(fact)
            .to_string();
        assert!(error.contains(fact), "{error}");
    }
    let incompressible = [("mu1", 1.0), ("alpha1", 2.0)];
    for program in [Abaqus, Ansys, Felupe, Package] {
        let text = law_written(program, "ogden", &incompressible)
            .expect("a block")
            .text;
        let notes = law_from(program, "a deck", &text, &[])
            .expect("a law")
            .notes;
        assert!(
            notes.iter().any(|note| note.contains("--incompressible")),
            "{notes:?}"
        );
    }
}
