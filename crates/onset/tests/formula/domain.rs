//! States without a value or a stress are errors for all number types.

use onset::certificate::certify_3d;
use onset::formula::{Formula, FormulaLaw, StateError, Trouble};
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, MaterialError, ResponseEnclosure, StrainEnergy};
use onset::real::Interval;

fn law(formula: &str) -> FormulaLaw {
    let formula = Formula::parse(formula).unwrap_or_else(|error| panic!("{error}"));
    formula.with(&[]).unwrap_or_else(|error| panic!("{error}"))
}

fn state(stretches: [f64; 3]) -> DeformationGradient {
    DeformationGradient::from_stretches(stretches).expect("a state")
}

fn exactly(f: &DeformationGradient) -> DeformationGradient<Interval> {
    DeformationGradient::from_components(f.components().map(|row| row.map(Interval::point)))
}

/// Reason why a state has no stress; all ways of evaluating the state must agree.
pub fn refusal(law: &FormulaLaw, f: &DeformationGradient) -> Option<StateError> {
    let error = |result: Result<(), MaterialError>| match result {
        Ok(()) => None,
        Err(MaterialError::Formula(error)) => Some(*error),
        Err(other) => panic!("{other}: {law:?}"),
    };
    let refused = error(law.response(f).map(drop));
    assert_eq!(error(law.plane_tangent(f).map(drop)), refused);
    assert_eq!(error(law.plane_response(f).map(drop)), refused);
    let beside = state([1.07, 1.01, 1.0]);
    for tangent in law.plane_tangents(&[*f, beside, *f]).into_iter().step_by(2) {
        assert_eq!(error(tangent.map(drop)), refused);
    }
    if refused.is_some() {
        assert_eq!(law.enclosure(&exactly(f)), ResponseEnclosure::ENTIRE);
    }
    refused
}

fn trouble(text: &str, stretches: [f64; 3]) -> Option<(Trouble, usize)> {
    refusal(&law(text), &state(stretches)).map(|error| (error.trouble, error.place.column))
}

/// Simple rubber energy, for formulas with additional parts.
const RUBBER: &str = "10*(I1 - 3 - 2*ln(J))";

#[test]
fn an_undefined_part_is_an_error_in_any_order() {
    // At this state I1 is 4.13, and E23 and C12 are zero.
    let at = [1.3, 1.2, 1.0];
    for part in [
        "max(0, sqrt(3 - I1))",
        "max(sqrt(3 - I1), 0)",
        "min(0, sqrt(3 - I1))",
        "min(sqrt(3 - I1), 0)",
        "max(1, J, sqrt(3 - I1))",
        "max(J, sqrt(3 - I1), 1)",
        "heaviside(sqrt(3 - I1))",
        "macaulay(ln(3 - I1))",
        "abs(ln(3 - I1))",
        "0*sqrt(3 - I1)",
        "sqrt(3 - I1)*0",
        "sqrt(3 - I1)^0",
        "0*(J + sqrt(3 - I1))",
        "if(sqrt(3 - I1) < 1, 1, 2)",
        "if(1 > sqrt(3 - I1), 1, 2)",
        "if(sqrt(3 - I1) < 1, 2, 2)",
        "if(J < 9 and sqrt(3 - I1) < 1, 1, 2)",
        "if(J < 9, sqrt(3 - I1), 2)",
        "min(-10*(I1 - 3), E23^E23)",
        "min(E23^E23, -10*(I1 - 3))",
        "exp(-1/E23^2)",
        "1/ln(C12)",
        "tanh(1/C12)",
        "0/C12",
        // These parts are evaluated on the boundary of their domain.
        "max(0, sqrt(E23))*max(0, sqrt(E23))",
        "max(sqrt(E23), 0)*max(sqrt(E23), 0)",
        "max(1, sqrt(C12))",
    ] {
        let text = format!("{RUBBER} + {part}");
        let found = trouble(&text, at).map(|(trouble, _)| trouble);
        assert_eq!(found, Some(Trouble::Undefined), "{text}");
    }
    // Where the root exists, the energy exists too.
    let text = format!("{RUBBER} + max(0, sqrt(3 - I1))");
    assert_eq!(trouble(&text, [0.7, 0.8, 0.9]), None);
    // The energy in floating point reports the error by NaN.
    assert!(law(&text).energy(&state(at)).is_nan());
}

#[test]
fn an_unselected_side_needs_no_value() {
    let at = [1.3, 1.2, 1.0];
    for part in [
        "if(I1 < 3, sqrt(3 - I1), 0)",
        "if(J > 0, ln(J), sqrt(3 - I1))",
        "if(J < 9, 1, max(0, sqrt(3 - I1)))",
        "if(J < 9 or sqrt(3 - I1) < 1, 1, 2)",
        "if(I1 < 3, 0*sqrt(3 - I1), 0)",
    ] {
        assert_eq!(trouble(&format!("{RUBBER} + {part}"), at), None, "{part}");
    }
}

#[test]
fn errors_contain_the_position_of_the_undefined_part() {
    let error = refusal(&law("I1 + max(0, sqrt(3 - I1))"), &state([1.3, 1.2, 1.0]));
    let text = error.expect("not defined").to_string();
    assert!(
        text.contains("I1 + max(0, sqrt(3 - I1))\n                ^^^^^^^^^^^^"),
        "{text}"
    );
    let error = refusal(&law("I1 + J*abs(J - 1)"), &state([2.0, 0.5, 1.0]));
    let text = error.expect("a kink").to_string();
    assert!(
        text.contains("I1 + J*abs(J - 1)\n           ^^^^^^^^^^"),
        "{text}"
    );
    assert!(text.contains("kink") && text.contains("hint"), "{text}");
}

#[test]
fn a_state_on_a_kink_or_a_jump_has_no_stress() {
    for (part, expected) in [
        ("-5*abs(J - 1)", Trouble::Kink),
        ("5*abs(J - 1)", Trouble::Kink),
        ("5*min(J, 2 - J)", Trouble::Kink),
        ("5*min(2 - J, J)", Trouble::Kink),
        ("max(J, 1)", Trouble::Kink),
        ("min(J, J^2, 1)", Trouble::Kink),
        ("macaulay(I3 - 1)", Trouble::Kink),
        ("abs(J - 1)*if(J < 2, 3, 4)", Trouble::Kink),
        ("if(J < 1, J^2, 2*J - 1 + (J - 1)/9)", Trouble::Kink),
        ("heaviside(1 - J)", Trouble::Jump),
        ("heaviside(J - 1)", Trouble::Jump),
        ("if(J < 1, 1, 2)", Trouble::Jump),
        ("if(J <= 1 and I1 > 3, J, 2*J)", Trouble::Jump),
        (
            "(1 - heaviside(J - 1))*(1 - heaviside(J^2 - 1))*J",
            Trouble::Jump,
        ),
    ] {
        let text = format!("{RUBBER} + {part}");
        let found = trouble(&text, [2.0, 0.5, 1.0]);
        assert_eq!(found.map(|found| found.0), Some(expected), "{text}");
        // The product of these stretches is one only to rounding.
        let (a, b) = (1.1, 1.0 / 1.1);
        let found = trouble(&text, [a, b, 1.0]);
        assert_eq!(found.map(|found| found.0), Some(expected), "{text}");
        // Any state next to the kink has a stress.
        assert_eq!(
            trouble(&text, [2.0, 0.5 * (1.0 + 1e-12), 1.0]),
            None,
            "{text}"
        );
    }
}

#[test]
fn a_test_of_exactly_zero_selects_no_side() {
    let at = [2.0, 0.7, 1.0];
    let rough = |part: &str| trouble(&format!("{RUBBER} + {part}"), at).map(|found| found.0);
    assert_eq!(rough("abs(C12)"), Some(Trouble::Kink));
    assert_eq!(rough("macaulay(F12)"), Some(Trouble::Kink));
    assert_eq!(rough("heaviside(E12)"), Some(Trouble::Jump));
    assert_eq!(rough("macaulay(C12)^2"), None);
    assert_eq!(rough("abs(E12*E23)*E12"), None);
}

#[test]
fn equal_stresses_on_both_sides_are_not_a_kink() {
    for part in [
        "macaulay(J - 1)^2",
        "abs(J - 1)^3",
        "abs(J - 1)*(J - 1)",
        "heaviside(J - 1)*(J - 1)^2",
        "if(J < 1, 2*(J - 1)^2, 5*(1 - J)^2)",
        "exp(macaulay(I3 - 1)^2) - 1",
        // In these formulas the smoothness follows from the values, not from the form.
        "if(J < 1, J - 1 - ln(J), (J^2 - 1)/2 - ln(J))",
        "if(J < 1, J^2 - 2*J + 1, 0)",
        "(max(J, 1) - 1)^2",
        "if(J < 1, -1, 1)*if(1 - J < 0, 1, -1)*J",
    ] {
        let text = format!("{RUBBER} + {part}");
        for at in [[2.0, 0.5, 1.0], [1.1, 1.0 / 1.1, 1.0]] {
            assert_eq!(trouble(&text, at), None, "{text} at {at:?}");
        }
    }
}

#[test]
fn an_enclosure_across_a_kink_is_unbounded_and_across_a_smooth_change_contains_both_sides() {
    let around = Interval::new(0.9, 1.2);
    let one = Interval::point(1.0);
    let zero = Interval::ZERO;
    let wide = DeformationGradient::from_components([
        [around, zero, zero],
        [zero, one, zero],
        [zero, zero, one],
    ]);
    for part in [
        "abs(J - 1)",
        "min(J, 2 - J)",
        "heaviside(J - 1)",
        "max(0, sqrt(J - 1))",
    ] {
        let law = law(&format!("{RUBBER} + {part}"));
        assert_eq!(law.enclosure(&wide), ResponseEnclosure::ENTIRE, "{part}");
    }
    for part in ["macaulay(J - 1)^2", "if(J < 1, 2*(J - 1)^2, 5*(1 - J)^2)"] {
        let bounds = law(&format!("{RUBBER} + {part}")).enclosure(&wide);
        assert!(bounds.energy.is_finite(), "{part}");
    }
}

#[test]
fn nothing_is_proved_at_a_kink_and_a_laminate_there_has_less_energy() {
    for part in ["- 5*abs(J - 1)", "+ 5*min(J, 2 - J)"] {
        let law = law(&format!("10*(I1 - 3 - 2*ln(J)) {part}"));
        let f = state([2.0, 0.5, 1.0]);
        let proof = certify_3d(&law, &f, 1e-6).expect("a scale");
        assert!(!proof.certainty.is_decided(), "{part}: {proof:?}");
        // Layers on both sides of the kink have less energy than the state.
        let energy = |shift: f64| law.energy(&state([2.0 + shift, 0.5, 1.0]));
        assert!(energy(1e-3) + energy(-1e-3) < 2.0 * energy(0.0), "{part}");
        // Away from the kink the proof succeeds.
        let beside = state([2.0, 0.51, 1.0]);
        let proof = certify_3d(&law, &beside, 1e-6).expect("a scale");
        assert!(proof.certainty.is_decided(), "{part}: {proof:?}");
    }
}

#[test]
fn a_law_with_a_kink_at_f_equal_to_one_has_a_wave_speed_but_no_stress() {
    let law = law(&format!("{RUBBER} - 5*abs(J - 1)"));
    assert!(law.undeformed().is_ok());
    assert_eq!(
        refusal(&law, &DeformationGradient::identity()).map(|error| error.trouble),
        Some(Trouble::Kink)
    );
}

#[test]
fn canceling_terms_in_stretches_must_still_be_defined() {
    let text = "lambda1^2 + lambda2^2 + lambda3^2 - 2*ln(J) \
                + ln(3.5 - lambda1 - lambda2 - lambda3) - ln(3.5 - lambda1 - lambda2 - lambda3)";
    assert_eq!(trouble(text, [1.1, 1.1, 1.0]), None);
    let found = trouble(text, [1.3, 1.2, 1.1]);
    assert_eq!(found.map(|found| found.0), Some(Trouble::Undefined));
}
