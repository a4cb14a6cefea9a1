//! Tests of `onset_study::audit` on laws with known answers.

use onset::kinematics::DeformationGradient;
use onset_study::audit::{Audit, Outcome, states};
use onset_study::settings::{MaterialSettings, Model, Settings};

fn of_energy(energy: &str, states: &[DeformationGradient]) -> Audit {
    let assignments = [
        "material.model=formula".to_owned(),
        format!("material.energy={energy}"),
    ];
    let settings = Settings::from_assignments(&assignments).expect("a law");
    Audit::of_material(&settings.material, None, states).expect("an audit")
}

fn outcome(audit: &Audit, name: &str) -> Outcome {
    let check = audit.checks.iter().find(|check| check.name == name);
    check.expect("a check").outcome
}

fn assert_finite(audit: &Audit) {
    for check in &audit.checks {
        assert!(check.error.is_none_or(f64::is_finite), "{check:?}");
    }
}

#[test]
fn every_law_of_the_library_is_consistent() {
    let states = states(0.1).expect("states");
    let laws: Vec<Model> = Model::all()
        .filter(|model| matches!(model, Model::Law(_)) && !model.is_in_rate_form())
        .collect();
    assert!(laws.len() >= 25);
    for model in laws {
        let audit = Audit::of_material(&MaterialSettings::new(model, &[]), None, &states);
        let audit = audit.expect("an audit");
        assert!(audit.consistent, "{audit}");
        assert_finite(&audit);
    }
}

#[test]
fn errors_at_a_stress_free_state_are_relative_to_the_stiffness() {
    let undeformed = [DeformationGradient::identity()];
    for model in ["blatz-ko", "modified-mooney-rivlin"] {
        let model = Model::named(model).expect("a law");
        let audit = Audit::of_material(&MaterialSettings::new(model, &[]), None, &undeformed)
            .expect("an audit");
        assert!(audit.consistent, "{audit}");
        assert_finite(&audit);
        assert_eq!(outcome(&audit, "energy"), Outcome::Passed);
        let symmetry = audit.checks.iter().find(|c| c.name == "material symmetry");
        assert_eq!(symmetry.expect("a check").finding, "isotropic");
    }
    // Dependence on the observer is also found at a stress-free state.
    let audit = of_energy("(F11-1)^2+(F22-1)^2+(F33-1)^2+F12^2", &undeformed);
    assert_eq!(outcome(&audit, "objectivity"), Outcome::Failed);
    assert_finite(&audit);
}

#[test]
fn a_kink_is_not_mistaken_for_a_missing_energy() {
    let states = states(0.1).expect("states");
    for energy in [
        "I1-3-2*ln(J)+abs(I1-3.0123)",
        "F11^2+F22^2+F33^2+F12^2-2*ln(J)",
    ] {
        let audit = of_energy(energy, &states);
        assert_eq!(outcome(&audit, "energy"), Outcome::Passed, "{audit}");
        assert_ne!(outcome(&audit, "closed loops"), Outcome::Failed, "{audit}");
        assert_finite(&audit);
    }
}

/// A law that is consistent at small strains can fail beyond them, so that the answer has the range of its states.
#[test]
fn an_audit_has_the_range_of_its_stretches() {
    let states = states(0.2).expect("states");
    let audit = of_energy("(I1 - 3)/2 - ln(J) + ln(J)^2", &states);
    let all = states.iter().flat_map(|f| f.principal_stretches());
    let (low, high) = all.fold((1.0_f64, 1.0_f64), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    assert_eq!(audit.stretches, [low, high]);
    assert!(
        (audit.jacobians[0] - 0.8_f64.powi(3)).abs() < 1e-12,
        "{audit:?}"
    );
    let text = audit.to_string();
    assert!(text.contains("principal stretches 0.6944 to "), "{text}");
    assert!(text.contains("not tested beyond (--strain)"), "{text}");
}
