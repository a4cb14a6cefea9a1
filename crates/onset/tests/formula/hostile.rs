//! Hostile input: no panic, no stack overflow, no unbounded work.

use onset::formula::{Formula, Problem};
use onset::kinematics::DeformationGradient;
use onset::material::Hyperelastic;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn problem(text: &str) -> Problem {
    match Formula::parse(text) {
        Err(error) => error.problem,
        Ok(_) => panic!("not refused"),
    }
}

#[test]
fn unbounded_nesting_is_rejected_before_the_stack_overflows() {
    for count in [200, 9_000] {
        for (open, close) in [
            ("(", ")"),
            ("-", ""),
            ("sqrt(", ")"),
            ("2^", ""),
            ("1 + (", ")"),
            ("if(J < 1, 0, ", ")"),
            ("max(J, ", ")"),
        ] {
            let count = count.min(19_000 / (open.len() + close.len()));
            let text = format!("{}J{}", open.repeat(count), close.repeat(count));
            assert!(matches!(problem(&text), Problem::TooDeep { .. }), "{open}");
            // The closing part may be missing too.
            assert!(matches!(
                problem(&open.repeat(count)),
                Problem::TooDeep { .. }
            ));
        }
        let text = format!("if({} J < 1, 0, J)", "not ".repeat(count.min(4_000)));
        assert!(matches!(problem(&text), Problem::TooDeep { .. }));
    }
    for count in [100_000, 10_000_000] {
        assert!(matches!(
            problem(&"(".repeat(count)),
            Problem::TooLong { .. }
        ));
    }
}

#[test]
fn the_depth_limit_suffices_for_realistic_laws() {
    let text = format!("{}I1{}", "(".repeat(90), ")".repeat(90));
    assert!(Formula::parse(&text).is_ok());
}

#[test]
fn chains_of_maximal_length_are_read_and_evaluated() {
    let identity = DeformationGradient::identity();
    for (link, value) in [("+J", 4_501.0), ("-J", -4_499.0), ("*J", 1.0), ("/J", 1.0)] {
        let law = Formula::parse(&format!("J{}", link.repeat(4_500))).expect("a formula");
        let law = law.with(&[]).expect("no parameters");
        assert_eq!(
            law.response(&identity).map(|response| response.energy),
            Ok(value)
        );
    }
    let sum: String = (0..1_000).map(|n| format!("+{n}*F11")).collect();
    let law = Formula::parse(&format!("J{sum}")).expect("a formula");
    let energy = law.with(&[]).expect("no parameters").response(&identity);
    assert_eq!(energy.map(|response| response.energy), Ok(499_501.0));
    let conditions = "J < 2 and ".repeat(1_500);
    let law = Formula::parse(&format!("if({conditions} J < 3, 5*J, 0)")).expect("a formula");
    let energy = law.with(&[]).expect("no parameters").response(&identity);
    assert_eq!(energy.map(|response| response.energy), Ok(5.0));
}

#[test]
fn a_formula_with_more_live_results_than_stack_registers_is_evaluated() {
    // 200 helpers that are all needed at the end.
    let helpers: String = (0..200)
        .map(|n| format!("let h{n} = sin({n}*J); "))
        .collect();
    let sum: Vec<String> = (0..200)
        .rev()
        .map(|n| format!("h{n}*h{}", 199 - n))
        .collect();
    let law = Formula::parse(&format!("{helpers}{}", sum.join(" + "))).expect("a formula");
    let law = law.with(&[]).expect("no parameters");
    let expected: f64 = (0..200)
        .map(|n| f64::from(n).sin() * f64::from(199 - n).sin())
        .sum();
    let response = law
        .response(&DeformationGradient::identity())
        .expect("finite");
    assert!((response.energy - expected).abs() < 1e-11);
}

#[test]
fn too_many_operations_are_rejected() {
    // 26 characters each, seven operations each.
    let term = |n: usize| format!("+sin({n}*F11)*cos({n}*F22)");
    let text: String = (0..750).map(term).collect();
    assert!(matches!(problem(&text), Problem::TooManyOperations { .. }));
}

const PIECES: &[&str] = &[
    "I1",
    "I2",
    "I3",
    "J",
    "I1bar",
    "I4",
    "I7",
    "lambda1",
    "C12",
    "E33",
    "F21",
    "F14",
    "mu",
    "k",
    "pi",
    "let",
    "and",
    "or",
    "not",
    "if",
    "sqrt",
    "exp",
    "ln",
    "tanh",
    "min",
    "pow",
    "macaulay",
    "foo",
    "0",
    "1",
    "2.5",
    ".5",
    "1e-3",
    "1e999",
    "1.2.3",
    "2mu",
    "+",
    "-",
    "*",
    "/",
    "^",
    "**",
    "(",
    ")",
    "(",
    ")",
    ",",
    ";",
    "=",
    "<",
    "<=",
    ">",
    ">=",
    "==",
    " ",
    "\n",
    "\t",
    "$",
    "\u{3bb}",
    "\u{b2}",
    "\u{0}",
    "let a =",
    "a",
    "if(J < 1,",
    "(J",
    "I1)",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, rng_seed: RngSeed::Fixed(5), ..ProptestConfig::default() })]

    #[test]
    fn no_text_makes_the_parser_panic(pieces in prop::collection::vec(prop::sample::select(PIECES), 0..25)) {
        survives(&pieces.concat());
        survives(&pieces.join(" "));
    }

    #[test]
    fn no_characters_make_the_parser_panic(text in "\\PC{0,60}") {
        survives(&text);
    }
}

/// Reads a formula, assigns every parameter and evaluates it; the results are ignored.
fn survives(text: &str) {
    match Formula::parse(text) {
        Err(error) => {
            assert!(!error.to_string().is_empty());
            if let Some(place) = error.place {
                assert!(place.column <= text.chars().count() + 1);
            }
        }
        Ok(formula) => {
            let values: Vec<(String, f64)> = formula
                .parameters()
                .map(|name| (name.to_owned(), 0.7))
                .collect();
            let values: Vec<(&str, f64)> = values
                .iter()
                .map(|(name, value)| (name.as_str(), *value))
                .collect();
            if let Ok(law) = formula.with(&values) {
                let f = [[1.1, 0.2, 0.0], [-0.1, 0.9, 0.1], [0.0, 0.3, 1.2]];
                let f = DeformationGradient::new(f).expect("a state");
                let _ = law.response(&f);
                let _ = law.plane_tangent(&f);
            }
        }
    }
}
