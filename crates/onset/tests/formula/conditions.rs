//! Conditions, ramps and extremes: each side has separate derivatives, and an undecided interval contains both.

use onset::formula::{Formula, FormulaLaw};
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, StrainEnergy};
use onset::real::Interval;

fn law(formula: &str) -> FormulaLaw {
    let formula = Formula::parse(formula).unwrap_or_else(|error| panic!("{error}"));
    formula.with(&[]).unwrap_or_else(|error| panic!("{error}"))
}

/// Energy and its first two derivatives with respect to `F11` at `F = diag(x, 1, 1)`.
fn derivatives(law: &FormulaLaw, x: f64) -> [f64; 3] {
    let f = DeformationGradient::from_stretches([x, 1.0, 1.0]).expect("a state");
    let response = law.response(&f).expect("finite");
    [
        response.energy,
        response.first_piola[(0, 0)],
        response.tangent[(0, 0, 0, 0)],
    ]
}

#[test]
fn each_side_of_a_condition_has_separate_derivatives() {
    let ramped = law("5*macaulay(J - 1)^2 + 2*macaulay(1 - J)^3");
    let branched = law("if(J < 1, 2*(1 - J)^3, 5*(J - 1)^2)");
    for x in [0.4, 0.9, 0.999_999, 1.0, 1.000_001, 1.3, 2.0] {
        let d: f64 = x - 1.0;
        let expected = if x < 1.0 {
            [-2.0 * d.powi(3), -6.0 * d * d, -12.0 * d]
        } else {
            [5.0 * d * d, 10.0 * d, 10.0]
        };
        for law in [&ramped, &branched] {
            for (computed, expected) in derivatives(law, x).into_iter().zip(expected) {
                assert!(
                    (computed - expected).abs() < 1e-14,
                    "{computed}, {expected} at {x}"
                );
            }
        }
    }
}

#[test]
fn the_threshold_belongs_to_the_side_given_by_the_comparison() {
    for (comparison, at_one) in [
        ("J < 1", 7.0),
        ("J <= 1", 4.0),
        ("J > 1", 7.0),
        ("J >= 1", 4.0),
        ("1 > J", 7.0),
        ("1 >= J", 4.0),
        ("not J < 1", 4.0),
        ("not (J <= 1)", 7.0),
        ("heaviside(J - 1) < 0.5", 7.0),
    ] {
        let law = law(&format!("if({comparison}, 4*J, 7*J)"));
        let f = DeformationGradient::identity();
        assert_eq!(law.energy(&f), at_one, "{comparison}");
    }
}

#[test]
fn conditions_combine_by_boolean_logic() {
    type Logic = fn(bool, bool, bool) -> bool;
    let cases: [(&str, Logic); 8] = [
        ("a < b and b < c", |x, y, _| x && y),
        ("a < b or b < c", |x, y, _| x || y),
        ("a < b and b < c or c < a", |x, y, z| x && y || z),
        ("a < b or b < c and c < a", |x, y, z| x || y && z),
        ("(a < b or b < c) and c < a", |x, y, z| (x || y) && z),
        ("not a < b and b < c", |x, y, _| !x && y),
        ("not (a < b and b < c) or c < a", |x, y, z| !(x && y) || z),
        ("not not (a < b) and not (b < c or not c < a)", |x, y, z| {
            x && !y && z
        }),
    ];
    for (text, logic) in cases {
        let formula = Formula::parse(&format!("if({text}, 2*J, 3*J)"))
            .unwrap_or_else(|error| panic!("{error}"));
        // The test is repeated with variables in place of the parameters, because variables are not folded.
        let unfolded = text
            .replace('a', "F11")
            .replace('b', "F22")
            .replace('c', "F33");
        let unfolded = unfolded.replace("F11nd", "and");
        let unfolded = law(&format!("if({unfolded}, 2*J, 3*J)"));
        for n in 0..27 {
            let [a, b, c] = [n / 9, n / 3 % 3, n % 3].map(|n| 1.0 + 0.25 * f64::from(n));
            let expected = if logic(a < b, b < c, c < a) { 2.0 } else { 3.0 };
            let values = [("a", a), ("b", b), ("c", c)];
            let used: Vec<_> = values
                .into_iter()
                .filter(|(name, _)| formula.parameters().any(|known| known == *name))
                .collect();
            let folded = formula.with(&used).expect("values for all");
            assert_eq!(
                derivatives(&folded, 1.0)[0],
                expected,
                "{text} at {a}, {b}, {c}"
            );
            // If two of the three numbers are equal, the energy jumps.
            let f = DeformationGradient::from_stretches([a, b, c]).expect("a state");
            let expected = expected * f.jacobian();
            assert_eq!(unfolded.energy(&f), expected, "{text} at {a}, {b}, {c}");
        }
    }
}

#[test]
fn an_undecided_interval_contains_both_sides() {
    let laws = [
        law("5*macaulay(J - 1)^2 + 2*macaulay(1 - J)^3"),
        law("if(J < 1, 2*(1 - J)^3, 5*(J - 1)^2)"),
        law("if(J < 1 and I1 < 4, 2*(1 - J)^3, 5*(J - 1)^2)"),
        law("if(not (J > 1 or I1 > 4), 2*(1 - J)^3, 5*(J - 1)^2)"),
        law("macaulay(J - 1)^2 + abs(J - 1)^3 + if(I3 < 1, 1 - I3, 0)^2"),
    ];
    for law in laws {
        let one = Interval::point(1.0);
        let zero = Interval::ZERO;
        let around = Interval::new(0.9, 1.2);
        let wide = [[around, zero, zero], [zero, one, zero], [zero, zero, one]];
        let bounds = law.enclosure(&DeformationGradient::from_components(wide));
        for n in 0..=30 {
            let [energy, stress, tangent] = derivatives(&law, 0.9 + 0.01 * f64::from(n));
            assert!(bounds.energy.contains(energy));
            assert!(bounds.first_piola[0][0].contains(stress));
            assert!(bounds.tangent[0][0][0][0].contains(tangent));
        }
    }
}

#[test]
fn an_unselected_side_may_be_undefined() {
    // sqrt(J - 1) and its derivatives do not exist below one.
    let law = law("if(J > 1, sqrt(J - 1), 0) + I1/2");
    assert_eq!(derivatives(&law, 0.5)[1], 0.5);
    let limited = Formula::parse("if(k > 0, I1/k, I1)").expect("a formula");
    let law = limited
        .with(&[("k", 0.0)])
        .expect("the other side is taken");
    assert_eq!(derivatives(&law, 1.0)[0], 3.0);
}
