//! Random formulas, compared with a separate evaluator: plain recursion over a tree, with a bound of its rounding errors.

use onset::formula::Formula;
use onset::kinematics::DeformationGradient;
use onset::material::StrainEnergy;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Formula as a tree.
#[derive(Clone, Debug)]
enum Tree {
    Number(f64),
    Name(&'static str),
    Sign(Box<Tree>),
    Binary(char, Box<Tree>, Box<Tree>),
    Power(Box<Tree>, i32),
    Call(&'static str, Box<Tree>),
    If(Box<[Tree; 4]>, bool),
}

/// Deformation gradient `F = 1.3 0.2 / -0.4 0.9 / 1.1` and two parameters.
const NAMES: [(&str, f64); 7] = [
    ("F11", 1.3),
    ("F12", 0.2),
    ("F21", -0.4),
    ("F22", 0.9),
    ("F33", 1.1),
    ("mu", 0.7),
    ("k_2", -1.9),
];

fn tree() -> impl Strategy<Value = Tree> {
    let leaf = prop_oneof![
        prop::sample::select(vec![0.0, 1.0, 2.0, 0.5, 3.25, 10.0, 1e-3]).prop_map(Tree::Number),
        (0..NAMES.len()).prop_map(|n| Tree::Name(NAMES[n].0)),
    ];
    leaf.prop_recursive(7, 60, 4, |inner| {
        let boxed = || inner.clone().prop_map(Box::new);
        prop_oneof![
            1 => boxed().prop_map(Tree::Sign),
            6 => (prop::sample::select(vec!['+', '-', '*', '/']), boxed(), boxed())
                .prop_map(|(operator, a, b)| Tree::Binary(operator, a, b)),
            1 => (boxed(), prop::sample::select(vec![-1, 2, 3])).prop_map(|(a, n)| Tree::Power(a, n)),
            2 => (prop::sample::select(vec!["sin", "cos", "tanh", "abs", "macaulay"]), boxed())
                .prop_map(|(name, a)| Tree::Call(name, a)),
            1 => (prop::array::uniform4(inner.clone()), any::<bool>())
                .prop_map(|(parts, is_below)| Tree::If(Box::new(parts), is_below)),
        ]
    })
}

/// Value with a bound of its rounding error; `None` if a comparison or a pole is too close to decide.
type Value = Option<(f64, f64)>;

fn evaluated(tree: &Tree) -> Value {
    let unit = 4.0 * f64::EPSILON;
    let rounded = |value: f64, error: f64| {
        let error = error + unit * value.abs();
        (value.abs() < 1e12 && error < 1e-4).then_some((value, error))
    };
    match tree {
        Tree::Number(value) => Some((*value, 0.0)),
        Tree::Name(name) => NAMES
            .iter()
            .find(|(known, _)| known == name)
            .map(|(_, x)| (*x, 0.0)),
        Tree::Sign(a) => evaluated(a).map(|(a, error)| (-a, error)),
        Tree::Binary(operator, a, b) => {
            let ((a, ea), (b, eb)) = (evaluated(a)?, evaluated(b)?);
            match operator {
                '+' => rounded(a + b, ea + eb),
                '-' => rounded(a - b, ea + eb),
                '*' => rounded(a * b, ea * b.abs() + eb * a.abs() + ea * eb),
                _ if b.abs() < 1e-3 => None,
                _ => rounded(a / b, 2.0 * (ea + eb * (a / b).abs()) / b.abs()),
            }
        }
        Tree::Power(a, exponent) => {
            let (a, error) = evaluated(a)?;
            if *exponent < 0 && a.abs() < 1e-3 {
                return None;
            }
            let slope = f64::from(*exponent).abs() * (a.abs() + error).powi(exponent - 1);
            rounded(a.powi(*exponent), 2.0 * error * slope)
        }
        Tree::Call(name, a) => {
            let (a, error) = evaluated(a)?;
            // Each of these functions has slopes of at most one.
            let value = match *name {
                "sin" => a.sin(),
                "cos" => a.cos(),
                "tanh" => a.tanh(),
                "abs" => a.abs(),
                _ => a.max(0.0),
            };
            rounded(value, error)
        }
        Tree::If(parts, is_below) => {
            let [a, b, holds, fails] = &**parts;
            let ((a, ea), (b, eb)) = (evaluated(a)?, evaluated(b)?);
            let error = ea + eb;
            if (a - b).abs() <= error && error > 0.0 {
                return None;
            }
            let condition = if *is_below { a < b } else { a >= b };
            evaluated(if condition { holds } else { fails })
        }
    }
}

/// Text with as few parentheses as possible, depending on the strength of the surrounding operator.
fn sparse(tree: &Tree, least: u8) -> String {
    let (text, strength) = match tree {
        Tree::Number(value) => (format!("{value}"), 9),
        Tree::Name(name) => ((*name).to_owned(), 9),
        Tree::Sign(a) => (format!("-{}", sparse(a, 7)), 7),
        Tree::Binary(operator, a, b) => {
            let strength = if matches!(operator, '+' | '-') { 5 } else { 6 };
            let (a, b) = (sparse(a, strength), sparse(b, strength + 1));
            (format!("{a} {operator} {b}"), strength)
        }
        Tree::Power(a, exponent) => (format!("{}^{exponent}", sparse(a, 9)), 8),
        Tree::Call(name, a) => (format!("{name}({})", sparse(a, 0)), 9),
        Tree::If(parts, is_below) => {
            let [a, b, holds, fails] = [0, 1, 2, 3].map(|n| sparse(&parts[n], 5));
            let sign = if *is_below { "<" } else { ">=" };
            (format!("if({a} {sign} {b}, {holds}, {fails})"), 9)
        }
    };
    if strength < least {
        format!("({text})")
    } else {
        text
    }
}

/// Text with parentheses and spaces everywhere.
fn full(tree: &Tree) -> String {
    match tree {
        Tree::Number(value) => format!("( {value:?} )"),
        Tree::Name(name) => format!("({name})"),
        Tree::Sign(a) => format!("\n( - {} )", full(a)),
        Tree::Binary(operator, a, b) => format!("({}\t{operator}  {})", full(a), full(b)),
        Tree::Power(a, exponent) => format!("pow({} , {exponent})", full(a)),
        Tree::Call(name, a) => format!("({name} ({}))", full(a)),
        Tree::If(parts, is_below) => {
            let [a, b, holds, fails] = [0, 1, 2, 3].map(|n| full(&parts[n]));
            // An equivalent condition: the negation of the reversed comparison.
            let sign = if *is_below { "<=" } else { ">" };
            format!("if(not ({b} {sign} {a}), {holds}, {fails})")
        }
    }
}

/// Energy of a formula; `None` if it is rejected as constant or undefined.
fn computed(text: &str) -> Option<f64> {
    let formula = Formula::parse(text).unwrap_or_else(|error| panic!("{error}"));
    let used: Vec<(&str, f64)> = NAMES
        .into_iter()
        .filter(|(name, _)| formula.parameters().any(|known| known == *name))
        .collect();
    let law = formula.with(&used).ok()?;
    let f = [[1.3, 0.2, 0.0], [-0.4, 0.9, 0.0], [0.0, 0.0, 1.1]];
    Some(law.energy(&DeformationGradient::from_components(f)))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, rng_seed: RngSeed::Fixed(6), ..ProptestConfig::default() })]

    #[test]
    fn a_formula_has_the_value_of_its_syntax_tree_in_every_notation(tree in tree()) {
        // A varying term, so that the formula is a law.
        let tree = Tree::Binary('+', Box::new(Tree::Name("F33")), Box::new(tree));
        let texts = [sparse(&tree, 0), full(&tree)];
        let values = texts.each_ref().map(|text| computed(text));
        prop_assert_eq!(
            values[0].map(f64::to_bits), values[1].map(f64::to_bits),
            "{} and {}", &texts[0], &texts[1]
        );
        if let (Some(value), Some((expected, error))) = (values[0], evaluated(&tree)) {
            prop_assert!(
                (value - expected).abs() <= 2.0 * error + 1e-13,
                "{}: {} is not {} within {:e}", &texts[0], value, expected, error
            );
        }
    }
}
