//! Behaviors with the generic interface of MFront.

use crate::laws::{difference, states};
use crate::{general, settings};
use onset::material::{BlatzKo, Hyperelastic};
use onset_umat::{Interface, Umat, UmatError, UmatSettings};

fn behavior(source: &str, name: Option<&str>) -> UmatSettings {
    UmatSettings {
        interface: Interface::Mfront,
        behavior: name.map(str::to_owned),
        ..settings(&[source], &[32.0])
    }
}

#[test]
fn a_behavior_responds_like_the_built_in_law() {
    let law = BlatzKo::default();
    for (source, name) in [
        ("tests/c/mfront_one.c", None),
        ("tests/c/mfront_several.c", Some("BlatzKo")),
    ] {
        for increments in [1, 3] {
            let own = UmatSettings {
                increments,
                ..behavior(source, name)
            };
            let routine = Umat::new(own).expect("a behavior");
            for f in states() {
                let (a, b) = (law.response(&f), routine.response(&f));
                let error = difference(&a.expect("finite"), &b.expect("finite"));
                assert!(error < 1e-13, "{error:e}");
            }
        }
    }
}

#[test]
fn the_library_states_the_number_of_state_variables_and_they_are_kept() {
    let own = UmatSettings {
        increments: 4,
        ..behavior("tests/c/mfront_one.c", None)
    };
    let routine = Umat::new(own).expect("a behavior");
    assert_eq!(routine.settings().state_variables, 7);
    let path = routine.path(&general()).expect("a path");
    let outcome = routine.along(path).expect("an outcome");
    let f = general().matrix();
    let c = f.transpose() * f;
    assert!((outcome.state_variables[0] - c[(0, 0)]).abs() < 1e-14);
    assert!((outcome.state_variables[4] - 2.0_f64.sqrt() * c[(0, 2)]).abs() < 1e-14);
    assert_eq!(outcome.state_variables[6], 4.0);
    // The behavior dissipates 1 per reference volume in the unit of time.
    let dissipation = outcome.plastic_dissipation * f.determinant();
    assert!((dissipation - 1.0).abs() < 1e-14, "{dissipation}");
}

#[test]
fn behaviors_that_cannot_be_used_are_refused_with_the_reason() {
    let several = |name: Option<&str>| behavior("tests/c/mfront_several.c", name);
    let all = "Abaqus, BlatzKo, Diverges, Irradiated, Overruns, PlaneStrain, Shortens, SmallStrain";
    let two = UmatSettings {
        properties: vec![32.0, 1.0],
        ..several(Some("BlatzKo"))
    };
    for (settings, reasons) in [
        (several(None), ["it has several behaviors", all]),
        (several(Some("Blatz")), ["no behavior `Blatz`", all]),
        (
            several(Some("Abaqus")),
            ["has the interface Abaqus", "--interface=generic"],
        ),
        (
            several(Some("SmallStrain")),
            ["not a law of finite strain", "@StrainMeasure Hencky"],
        ),
        (
            several(Some("PlaneStrain")),
            ["hypothesis Tridimensional", "@ModellingHypothesis"],
        ),
        (several(Some("Irradiated")), ["`Flux`", "293.15 K"]),
        (
            two,
            ["1 material properties, and 2 are given", "ShearModulus"],
        ),
    ] {
        let error = Umat::new(settings).err().expect("a refusal");
        assert!(matches!(error, UmatError::Unsuitable { .. }), "{error}");
        for reason in reasons {
            assert!(error.to_string().contains(reason), "{error}");
        }
    }
    let error = Umat::new(behavior("c/blatz_ko_law.c", None))
        .err()
        .expect("no behavior");
    assert!(matches!(error, UmatError::NoRoutine { .. }), "{error}");
}

#[test]
fn failures_of_a_behavior_are_reported_with_its_message_and_the_state() {
    let asked = |name: &str| {
        let settings = behavior("tests/c/mfront_several.c", Some(name));
        let routine = Umat::new(settings).expect("a behavior");
        let error = routine.response(&general()).expect_err("a failure");
        error.to_string()
    };
    let error = asked("Diverges");
    assert!(
        error.contains("no convergence after 100 iterations"),
        "{error}"
    );
    assert!(error.contains("at F = [1.2, 0.3, -0.1;"), "{error}");
    let error = asked("Shortens");
    assert!(
        error.contains("smaller increment (0.25 times increment 1 of 1)"),
        "{error}"
    );
    assert!(asked("Overruns").contains("s1.internal_state_variables"));
}
