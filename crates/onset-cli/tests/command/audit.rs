//! `onset audit`, run as a command.

use crate::{document, onset_line};

#[test]
fn built_in_laws_pass_under_every_name_of_their_tangent() {
    for model in ["blatz-ko", "modified-mooney-rivlin"] {
        let audit = document(&format!("audit --set material.model={model}"));
        assert_eq!(audit["consistent"], true, "{audit:#}");
        assert_eq!(audit["tangent"]["identified"]["convention"], "first-piola");
    }
    for convention in ["jaumann-kirchhoff", "truesdell", "nominal", "second-piola"] {
        let audit = document(&format!(
            "audit --as {convention} --set material.model=blatz-ko"
        ));
        assert_eq!(audit["consistent"], true, "{audit:#}");
        let identified = &audit["tangent"]["identified"];
        assert_eq!(identified["convention"], convention);
        assert!(
            identified["error"]
                .as_f64()
                .is_some_and(|error| error < 1e-8)
        );
    }
}

#[test]
fn an_unknown_convention_or_strain_is_refused_with_the_available_options() {
    let answer = onset_line("audit --as cauchy");
    assert_eq!(answer.code, Some(2));
    assert!(
        answer.stderr.contains("jaumann-kirchhoff"),
        "{}",
        answer.stderr
    );
    assert_eq!(onset_line("audit --strain 2").code, Some(2));
    assert_eq!(
        onset_line("audit --stretch 1.1,0.9 --strain 0.1").code,
        Some(2)
    );
}

#[cfg(unix)]
mod user {
    use crate::fortran::library;
    use crate::{document, number, onset_line};
    use serde_json::Value;

    fn set(source: &str, properties: &str) -> String {
        format!(
            "--set material.model=umat --set material.library={} --set material.properties={properties}",
            library(&[source]).display()
        )
    }

    fn audited(source: &str, properties: &str, more: &str) -> Value {
        document(&format!("audit {} {more}", set(source, properties)))
    }

    fn outcome<'a>(audit: &'a Value, name: &str) -> &'a str {
        let checks = audit["checks"].as_array().expect("checks");
        let check = checks.iter().find(|check| check["name"] == name);
        check
            .and_then(|check| check["outcome"].as_str())
            .expect("a check")
    }

    #[test]
    fn a_umat_with_the_tangent_of_abaqus_passes() {
        let audit = audited("fortran/blatz_ko.f90", "32", "");
        assert_eq!(audit["consistent"], true, "{audit:#}");
        assert_eq!(
            audit["tangent"]["identified"]["convention"],
            "jaumann-kirchhoff"
        );
        assert!(number(&audit, "/tangent/expected_error") < 1e-8);
        let line = format!("audit --strict {}", set("fortran/blatz_ko.f90", "32"));
        let text = onset_line(&line);
        assert_eq!(text.code, Some(0));
        assert!(text.stdout.starts_with("Consistent"), "{}", text.stdout);
    }

    #[test]
    fn every_mistaken_convention_of_a_umat_is_identified() {
        const CONVENTIONS: &str = "tests/fortran/conventions.f90";
        for (kind, name) in [
            "jaumann-kirchhoff",
            "jaumann-cauchy",
            "truesdell",
            "green-naghdi-cauchy",
            "green-naghdi-kirchhoff",
            "second-piola",
            "small-strain",
            "logarithmic-strain",
            "first-piola",
            "nominal",
            "reference",
        ]
        .into_iter()
        .enumerate()
        {
            let audit = audited(CONVENTIONS, &format!("32,{kind},0"), "");
            let identified = &audit["tangent"]["identified"];
            assert_eq!(identified["convention"], name, "{audit:#}");
            assert_eq!(audit["tangent"]["indistinguishable"], serde_json::json!([]));
            assert_eq!(audit["consistent"], kind == 0);
            // Only the tangent is at fault.
            for check in ["energy", "objectivity", "closed loops", "symmetry of dP/dF"] {
                assert_eq!(outcome(&audit, check), "passed");
            }
        }
    }

    #[test]
    fn common_mistakes_are_identified_together_with_the_convention() {
        const CONVENTIONS: &str = "tests/fortran/conventions.f90";
        for (kind, slip, key, value) in [
            // For a symmetric tangent transposition has no effect; the tangent of the Cauchy stress can show it.
            (1, 1, "transposed", Value::Bool(true)),
            (0, 2, "shear", "tensor".into()),
            (2, 4, "volume", "times-jacobian".into()),
            (0, 8, "order", "voigt".into()),
        ] {
            let audit = audited(CONVENTIONS, &format!("32,{kind},{slip}"), "");
            let identified = &audit["tangent"]["identified"];
            assert_eq!(identified[key], value, "{audit:#}");
            assert_eq!(audit["consistent"], false);
        }
        let line = format!("audit --strict {}", set(CONVENTIONS, "32,2,0"));
        let text = onset_line(&line);
        assert_eq!(text.code, Some(1));
        assert!(text.stdout.contains("Truesdell"), "{}", text.stdout);
    }

    #[test]
    fn a_corotational_update_with_a_small_strain_tangent_is_identified() {
        let history = "--set material.state-variables=1";
        let audit = audited("fortran/j2_plasticity.f90", "200e3,0.3,250,2e3", history);
        assert_eq!(outcome(&audit, "objectivity"), "passed");
        assert_eq!(outcome(&audit, "memory"), "passed");
        // In one increment, the tangent of the update: Cauchy stress per logarithmic strain.
        let identified = &audit["tangent"]["identified"];
        assert_eq!(identified["convention"], "logarithmic-strain", "{audit:#}");
        // In many increments, the tangent of the last increment: the Jaumann rate of the Cauchy stress, up to the size of the increment.
        let many = format!("{history} --set material.increments=10");
        let audit = audited("fortran/j2_plasticity.f90", "200e3,0.3,250,2e3", &many);
        let identified = &audit["tangent"]["identified"];
        assert_eq!(identified["convention"], "logarithmic-strain", "{audit:#}");
        let conventions = audit["tangent"]["conventions"].as_array().expect("a list");
        let error = |name: &str| {
            let found = conventions.iter().find(|found| found["convention"] == name);
            found
                .and_then(|found| found["error"].as_f64())
                .expect("an error")
        };
        assert!(error("jaumann-cauchy") < 1e-2 * error("jaumann-kirchhoff"));
        // The routine is consistent with its definition, which differs from the definition of a hyperelastic law.
        assert_eq!(audit["consistent"], true, "{audit:#}");
        assert_eq!(outcome(&audit, "tangent"), "noted");
        assert!(number(&audit, "/tangent/small_strain_update") > 0.01);
        let verdict = audit["verdict"].as_str().expect("a verdict");
        assert!(
            verdict.contains("small-strain update") && verdict.contains("sigma_ij delta_kl"),
            "{verdict}"
        );
    }

    fn planted(kind: usize, part: usize, factor: f64, more: &str) -> Value {
        let properties = format!("1,2,{kind},{part},{factor}");
        audited("tests/fortran/planted.f90", &properties, more)
    }

    /// Number of kinds of states at which the routine is incorrect; it is correct at all others.
    const KINDS: usize = 28;

    #[test]
    fn a_tangent_that_is_wrong_at_one_kind_of_state_is_detected() {
        let audit = planted(0, 1, 0.9, "");
        assert_eq!(audit["consistent"], true, "{audit:#}");
        for (kind, position) in [
            (1, "undeformed"),
            (3, "pure dilation"),
            (7, "two equal stretches"),
            (16, "along the axes, J = 1"),
        ] {
            let audit = planted(kind, 2, 0.5, "");
            assert_eq!(outcome(&audit, "tangent"), "failed", "{audit:#}");
            let in_part = &audit["tangent"]["in_part"];
            assert_eq!(in_part["convention"], "jaumann-kirchhoff");
            assert_eq!(in_part["transposed"], false);
            let fails = in_part["fails"].as_array().expect("a list");
            assert!(!fails.is_empty());
            for state in fails {
                let told = state["position"].as_str().expect("words");
                assert!(told.contains(position), "{told} is not {position}");
                assert!(state["deformation_gradient"][2][2].is_number());
            }
            let verdict = audit["verdict"].as_str().expect("a verdict");
            assert!(
                verdict.contains(position) && verdict.contains("(F = "),
                "{verdict}"
            );
            assert!(!verdict.contains("transposed"), "{verdict}");
        }
    }

    /// Neither the tangent nor differences of the stress show a jump of the stress at a state; one-sided limits do, with or without an energy.
    #[test]
    fn a_stress_that_jumps_at_a_state_is_detected() {
        for kind in [3, 10] {
            let audit = planted(kind, 4, 1.2, "");
            assert_eq!(outcome(&audit, "continuity"), "failed", "{audit:#}");
            assert_eq!(outcome(&audit, "energy"), "failed", "{audit:#}");
        }
    }

    #[test]
    fn a_secant_stiffness_is_identified_and_a_convention_is_named_only_if_clearly_nearest() {
        let audit = audited("tests/fortran/secant.f90", "2,1,0.01,1", "--strain 0.001");
        assert_eq!(outcome(&audit, "tangent"), "failed");
        assert!(number(&audit, "/tangent/secant") < 1e-3);
        assert_eq!(audit["tangent"]["nearest"], Value::Null);
        let verdict = audit["verdict"].as_str().expect("a verdict");
        assert!(verdict.contains("secant stiffness"), "{verdict}");
    }

    /// Faults of random size in a random part, at states of a random kind; `cargo xtask hunt audits` draws more of them.
    #[test]
    fn planted_faults_are_detected_at_every_kind_of_state() {
        let (seed, cases) = crate::hunt::hunted(12);
        let mut random = crate::Random::new(seed);
        for case in 0..cases {
            let kind = match case {
                0 => 0,
                _ => 1 + random.below(KINDS),
            };
            let part = 1 + random.below(5);
            let factor = 1.0 + 10f64.powf(-3.0 * random.below(1000) as f64 / 1000.0);
            let strain = format!("--strain {}", [0.01, 0.05, 0.1, 0.25, 0.5][random.below(5)]);
            let audit = planted(kind, part, factor, &strain);
            // A state without stress and energy hides a factor on them.
            let is_hidden = kind == 0 || (part >= 4 && kind <= 2);
            assert_eq!(
                audit["consistent"], is_hidden,
                "kind {kind}, part {part}, factor {factor}, {strain}: {audit:#}"
            );
        }
    }

    /// `SSE` per current volume, as Abaqus defines it, and per reference volume: both are the energy of the stress.
    #[test]
    fn both_readings_of_sse_are_accepted_and_reported() {
        const CONVENTIONS: &str = "tests/fortran/conventions.f90";
        for (slips, reading) in [("0", "per current volume"), ("16", "per reference volume")] {
            let audit = audited(CONVENTIONS, &format!("32,0,{slips}"), "");
            assert_eq!(outcome(&audit, "energy"), "passed", "{audit:#}");
            let checks = audit["checks"].as_array().expect("a list");
            let energy = checks.iter().find(|check| check["name"] == "energy");
            let finding = energy.expect("the check")["finding"].to_string();
            assert!(finding.contains(&format!("SSE is {reading}")), "{finding}");
            assert_eq!(audit["consistent"], true);
        }
    }

    /// Yield is at a strain of 0.00125, within the range of the differences.
    #[test]
    fn near_yield_the_tangent_is_undetermined_and_not_wrong() {
        let near = "--set material.state-variables=1 --strain 0.001";
        let audit = audited("fortran/j2_plasticity.f90", "200e3,0.3,250,2e3", near);
        assert_eq!(outcome(&audit, "tangent"), "undetermined", "{audit:#}");
        let checks = audit["checks"].as_array().expect("a list");
        assert!(
            checks.iter().all(|check| check["outcome"] != "failed"),
            "{audit:#}"
        );
        let verdict = audit["verdict"].as_str().expect("a verdict");
        assert!(verdict.starts_with("Undetermined: "), "{verdict}");
    }

    #[test]
    fn data_kept_between_calls_are_detected() {
        let audit = audited("tests/fortran/hostile.f90", "10,4,9", "");
        assert_eq!(outcome(&audit, "memory"), "failed");
        // A stress that changes between calls has no derivative, so that the tangent is not assessed.
        assert_eq!(audit["tangent"]["identified"], Value::Null);
        let audit = audited("tests/fortran/hostile.f90", "10,4,0", "");
        assert_eq!(outcome(&audit, "memory"), "passed");
        assert_eq!(outcome(&audit, "energy"), "noted", "no energy is reported");
        // A Cauchy stress linear in the logarithmic strain has no energy, as is usual for a small-strain update.
        assert_eq!(outcome(&audit, "closed loops"), "noted");
    }

    #[test]
    fn a_crash_during_an_audit_is_reported_and_the_convention_of_a_umat_cannot_be_chosen() {
        let line = format!("audit {}", set("tests/fortran/hostile.f90", "10,4,1"));
        let answer = onset_line(&line);
        assert_eq!(answer.code, Some(2));
        assert!(answer.stderr.contains("signal 11"), "{}", answer.stderr);
        let line = format!("audit --as truesdell {}", set("fortran/blatz_ko.f90", "32"));
        let answer = onset_line(&line);
        assert_eq!(answer.code, Some(2));
        assert!(answer.stderr.contains("--as"), "{}", answer.stderr);
    }
}
