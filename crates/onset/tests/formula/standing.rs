//! Standing checks of laws given as formulas: `cargo xtask hunt formulas-agree`.

use crate::domain::refusal;
use crate::hunt::hunted;
use crate::random::Random;
use crate::states::of;
use dashu_float::FBig;
use dashu_float::round::mode::HalfEven;
use nalgebra::{Matrix3, Vector2, Vector3};
use onset::certificate::{Certainty, certify_3d};
use onset::continuum::{AcousticMinimum, Ellipticity, Stiffness};
use onset::formula::{Formula, FormulaLaw, Trouble};
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, MaterialError, StrainEnergy};
use onset::real::{Jet, Real};
use std::cell::RefCell;
use std::ops::{Add, Div, Mul, Neg, Sub};

// A formula as a tree, and its value computed from the leaves.

#[derive(Clone, Debug)]
enum Tree {
    Number(f64),
    Name(&'static str),
    Binary(&'static str, Box<Tree>, Box<Tree>),
    Call(&'static str, Vec<Tree>),
    If(Box<[Tree; 4]>),
}

const NAMES: [&str; 7] = ["I1", "J", "C11", "C12", "E11", "E23", "F22"];

impl Random {
    fn below(&mut self, count: usize) -> usize {
        ((0.5 * (self.number() + 1.0) * count as f64) as usize).min(count - 1)
    }

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    fn tree(&mut self, depth: usize) -> Tree {
        let leaf = depth == 0 || self.number() > 0.7;
        if leaf {
            return match self.below(3) {
                0 => Tree::Number(self.one(&[0.0, 1.0, 2.0, 3.0, 0.5, 3.125])),
                _ => Tree::Name(self.one(&NAMES)),
            };
        }
        let mut part = || Box::new(self.tree(depth - 1));
        let (a, b) = (part(), part());
        match self.below(8) {
            0 | 1 => Tree::Binary(self.one(&["+", "-"]), a, b),
            2 => Tree::Binary("*", a, b),
            3 => Tree::Binary("/", a, b),
            4 => Tree::Call(self.one(&["sqrt", "ln"]), vec![*a]),
            5 => Tree::Call(self.one(&["abs", "macaulay", "heaviside", "exp"]), vec![*a]),
            6 => Tree::Call(self.one(&["min", "max"]), vec![*a, *b]),
            _ => {
                let (c, d) = (self.tree(depth - 1), self.tree(depth - 1));
                Tree::If(Box::new([*a, *b, c, d]))
            }
        }
    }
}

/// A number with a bound of its rounding error, undefined, or too close to a boundary to decide.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Value {
    Number(f64, f64),
    Nothing,
    Unclear,
}

impl Value {
    fn of(value: f64, error: f64) -> Self {
        let error = 2.0 * error + 1e-15 * (1.0 + value.abs());
        if value.is_nan() {
            Self::Nothing
        } else if value.abs() < 1e6 && error < 1e-4 {
            Self::Number(value, error)
        } else {
            Self::Unclear
        }
    }

    /// Returns the value, unless another number is too close to zero.
    fn away_from_zero((x, error): (f64, f64), value: f64, slope: f64) -> Self {
        if x.abs() < 1e3 * error + 1e-9 {
            Self::Unclear
        } else {
            Self::of(value, error * slope.abs())
        }
    }
}

/// Function that computes a value from numbers with their errors.
type Function<'f> = dyn Fn(&[(f64, f64)]) -> Value + 'f;

fn evaluated(tree: &Tree, leaf: &impl Fn(&str) -> f64) -> Value {
    let with = |parts: &[&Tree], then: &Function<'_>| {
        let values: Vec<Value> = parts.iter().map(|part| evaluated(part, leaf)).collect();
        if values.contains(&Value::Unclear) {
            return Value::Unclear;
        }
        let number = |value: &Value| match value {
            Value::Number(number, error) => Some((*number, *error)),
            _ => None,
        };
        let numbers: Option<Vec<_>> = values.iter().map(number).collect();
        numbers.map_or(Value::Nothing, |numbers| then(&numbers))
    };
    let away = Value::away_from_zero;
    match tree {
        Tree::Number(value) => Value::Number(*value, 0.0),
        Tree::Name(name) => Value::Number(leaf(name), 1e-14 * (1.0 + leaf(name).abs())),
        Tree::Binary(operator, a, b) => with(&[a, b], &|x| {
            let ([x, y], [ex, ey]) = ([x[0].0, x[1].0], [x[0].1, x[1].1]);
            match *operator {
                "+" => Value::of(x + y, ex + ey),
                "-" => Value::of(x - y, ex + ey),
                "*" => Value::of(x * y, ex * y.abs() + ey * x.abs() + ex * ey),
                _ if y == 0.0 && is_exact(b) => Value::Nothing,
                _ => match away((y, ey), x / y, x / (y * y)) {
                    Value::Number(value, error) => Value::of(value, error + ex / y.abs()),
                    other => other,
                },
            }
        }),
        Tree::Call(name, parts) => {
            let parts: Vec<&Tree> = parts.iter().collect();
            with(&parts, &|x| {
                let (a, error) = x[0];
                let difference = || (a - x[1].0, error + x[1].1);
                match *name {
                    "sqrt" => away(x[0], a.sqrt(), 1.0 / a.abs().sqrt()),
                    "ln" => away(x[0], a.ln(), 2.0 / a),
                    "exp" => Value::of(a.exp(), 2.0 * error * a.exp()),
                    "abs" => away(x[0], a.abs(), 1.0),
                    "macaulay" => away(x[0], a.max(0.0), 1.0),
                    "heaviside" => away(x[0], if a < 0.0 { 0.0 } else { 1.0 }, 0.0),
                    "min" => away(difference(), a.min(x[1].0), 1.0),
                    _ => away(difference(), a.max(x[1].0), 1.0),
                }
            })
        }
        Tree::If(parts) => {
            let [a, b, holds, fails] = &**parts;
            let difference = with(&[a, b], &|x| {
                let difference = (x[0].0 - x[1].0, x[0].1 + x[1].1);
                away(difference, difference.0, 1.0)
            });
            match difference {
                Value::Number(difference, _) if difference < 0.0 => evaluated(holds, leaf),
                Value::Number(..) => evaluated(fails, leaf),
                other => other,
            }
        }
    }
}

/// Returns true if a part is exactly zero at every planar state.
fn is_exact(tree: &Tree) -> bool {
    matches!(tree, Tree::Name("E23") | Tree::Number(_))
}

/// Text of the tree, optionally with the arguments of sums, products and extremes swapped.
fn written(tree: &Tree, is_turned: bool) -> String {
    let text = |tree: &Tree| written(tree, is_turned);
    match tree {
        Tree::Number(value) => format!("{value}"),
        Tree::Name(name) => (*name).to_owned(),
        Tree::Binary(operator @ ("+" | "*"), a, b) if is_turned => {
            format!("({} {operator} {})", text(b), text(a))
        }
        Tree::Binary(operator, a, b) => format!("({} {operator} {})", text(a), text(b)),
        Tree::Call(name, parts) => {
            let mut parts: Vec<String> = parts.iter().map(text).collect();
            if is_turned {
                parts.reverse();
            }
            format!("{name}({})", parts.join(", "))
        }
        Tree::If(parts) => {
            let [a, b, holds, fails] = [0, 1, 2, 3].map(|n| text(&parts[n]));
            if is_turned {
                format!("if({a} >= {b}, {fails}, {holds})")
            } else {
                format!("if({a} < {b}, {holds}, {fails})")
            }
        }
    }
}

/// Planar state, often with stretches that make tests vanish.
fn planar(random: &mut Random) -> DeformationGradient {
    let stretch = |random: &mut Random| match random.below(3) {
        0 => random.one(&[0.5, 1.0, 2.0]),
        _ => 1.5_f64.powf(random.number()),
    };
    let [a, b] = [0, 1].map(|_| stretch(random));
    let shear = if random.number() > 0.3 {
        0.4 * random.number()
    } else {
        0.0
    };
    DeformationGradient::plane_strain([[a, shear], [0.0, b]], 1.0).expect("a state")
}

fn leaf_of(f: &DeformationGradient, name: &str) -> f64 {
    let m = f.matrix();
    let c = m.transpose() * m;
    match name {
        "I1" => c.trace(),
        "J" => f.jacobian(),
        "C11" => c[(0, 0)],
        "C12" => c[(0, 1)],
        "E11" => 0.5 * (c[(0, 0)] - 1.0),
        "E23" => 0.5 * c[(1, 2)],
        _ => m[(1, 1)],
    }
}

/// The law, unless the formula is rejected at every state.
fn law(text: &str) -> Option<FormulaLaw> {
    Formula::parse(text).expect("a formula").with(&[]).ok()
}

#[derive(Default, Debug)]
struct Seen {
    defined: usize,
    undefined: usize,
    rough: usize,
    proved: usize,
}

fn check_tree(random: &mut Random, seen: &mut Seen) {
    let tree = random.tree(4);
    let [text, turned] = [false, true]
        .map(|is_turned| format!("10*(I1 - 3 - 2*ln(J)) + {}", written(&tree, is_turned)));
    let (Some(typed), Some(other)) = (law(&text), law(&turned)) else {
        return;
    };
    let f = planar(random);
    let is_finite = !matches!(typed.response(&f), Err(MaterialError::NotFinite { .. }));
    if !is_finite {
        // An unbounded slope: no stress, and no statement on the value.
        assert!(other.response(&f).is_err(), "{text} at {f:?}");
        return;
    }
    let [found, exchanged] =
        [&typed, &other].map(|law| refusal(law, &f).map(|error| error.trouble));
    assert_eq!(
        found.is_some(),
        exchanged.is_some(),
        "{text} and in another order at {f:?}: {found:?}, {exchanged:?}"
    );
    match evaluated(&tree, &|name| leaf_of(&f, name)) {
        Value::Unclear => {}
        Value::Nothing => {
            assert_eq!(found, Some(Trouble::Undefined), "{text} at {f:?}");
            seen.undefined += 1;
        }
        Value::Number(value, error) => {
            assert_eq!(found, None, "{text} at {f:?}");
            let base = 10.0 * (leaf_of(&f, "I1") - 3.0 - 2.0 * f.jacobian().ln());
            let scale = error + 1e-12 * (1.0 + value.abs() + base.abs());
            assert!(
                (typed.energy(&f) - base - value).abs() < scale,
                "{text} at {f:?}"
            );
            seen.defined += 1;
        }
    }
    seen.rough += usize::from(matches!(found, Some(Trouble::Kink | Trouble::Jump)));
    check_proof(random, &typed, &f, &text, seen);
}

/// Compares a proof of ellipticity with densely sampled directions and with fine laminates.
fn check_proof(
    random: &mut Random,
    law: &FormulaLaw,
    f: &DeformationGradient,
    text: &str,
    seen: &mut Seen,
) {
    let Ok(proof) = certify_3d(law, f, 1e-6) else {
        return;
    };
    let Certainty::Stable { bound } = proof.certainty else {
        return;
    };
    seen.proved += 1;
    let response = law
        .response(f)
        .unwrap_or_else(|error| panic!("proved, but {error}: {text}"));
    let stiffness = Stiffness::<3>::of(&response);
    let scale = Stiffness::<3>::of(&law.undeformed().expect("a scale")).maximum_eigenvalue();
    let slack = 1e-9 * stiffness.maximum_eigenvalue();
    for _ in 0..20 {
        let n = Vector3::from_fn(|_, _| random.number()).normalize();
        let q = stiffness.acoustic_tensor(&n);
        let (low, polarization) = lowest(&q);
        assert!(
            low >= bound * scale - slack,
            "{text} at {f:?}: {low} below {bound}"
        );
        // Alternating layers `F + jump` and `F - jump` with a small jump must have more energy than `F`.
        let change = |size: f64| {
            let jump = polarization * n.transpose() * size;
            let energy = |sign: f64| law.energy(&of(&(f.matrix() + jump * sign)));
            let change = (energy(1.0) + energy(-1.0) - 2.0 * energy(0.0)) / (size * size);
            let noise = 1e-13 * (1.0 + energy(0.0).abs()) / (size * size);
            (change, change < -noise - 0.1 * scale)
        };
        let all_gain = |sizes: &[f64]| sizes.iter().all(|size| change(*size).1);
        // Only larger jumps cross a kink near the state; the relative decrease of energy grows as they become smaller.
        let is_kink = change(1e-5).0 < 5.0 * change(1e-4).0;
        let gains = all_gain(&[1e-4, 1e-5, 1e-6, 1e-7])
            && (!is_kink || all_gain(&[1e-8, 1e-9, 1e-10, 1e-11]));
        assert!(!gains, "{text} at {f:?} along {n:?}");
    }
}

fn lowest(q: &Matrix3<f64>) -> (f64, Vector3<f64>) {
    let eigen = q.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    (
        eigen.eigenvalues[least],
        eigen.eigenvectors.column(least).into(),
    )
}

// Arithmetic with sixty digits.

type Digits = FBig<HalfEven, 2>;
const BITS: usize = 220;

thread_local! {
    static NUMBERS: RefCell<Vec<Digits>> = const { RefCell::new(Vec::new()) };
}

/// Number with sixty digits, stored in a separate table because laws copy their numbers.
#[derive(Clone, Copy, Debug)]
struct Exact(usize);

impl Exact {
    fn keep(number: Digits) -> Self {
        NUMBERS.with_borrow_mut(|numbers| {
            numbers.push(number.with_precision(BITS).value());
            Self(numbers.len() - 1)
        })
    }

    fn digits(self) -> Digits {
        NUMBERS.with_borrow(|numbers| numbers[self.0].clone())
    }

    fn forget() {
        NUMBERS.with_borrow_mut(Vec::clear);
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $sign:tt) => {
        impl $trait for Exact {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self::keep(self.digits() $sign other.digits())
            }
        }
        impl $trait<f64> for Exact {
            type Output = Self;
            fn $method(self, other: f64) -> Self {
                Self::keep(self.digits() $sign Self::constant(other).digits())
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl Neg for Exact {
    type Output = Self;
    fn neg(self) -> Self {
        Self::keep(-self.digits())
    }
}

impl Real for Exact {
    fn constant(value: f64) -> Self {
        let number = Digits::try_from(value).expect("finite");
        Self::keep(number.with_precision(BITS).value())
    }
    fn value(self) -> f64 {
        self.digits().to_f64().value()
    }
    fn recip(self) -> Self {
        Self::constant(1.0) / self
    }
    fn sqrt(self) -> Self {
        Self::keep(self.digits().sqrt())
    }
    fn exp(self) -> Self {
        Self::keep(self.digits().exp())
    }
    fn ln(self) -> Self {
        Self::keep(self.digits().ln())
    }
    fn sin(self) -> Self {
        unreachable!("no law here has a sine")
    }
    fn cos(self) -> Self {
        unreachable!("no law here has a cosine")
    }
    fn sinh(self) -> Self {
        unreachable!("no law here has one")
    }
    fn cosh(self) -> Self {
        unreachable!("no law here has one")
    }
    fn tanh(self) -> Self {
        unreachable!("no law here has one")
    }
    fn powi(self, exponent: i32) -> Self {
        let count = exponent.unsigned_abs();
        let power = (0..count).fold(Self::constant(1.0), |power, _| power * self);
        if exponent < 0 { power.recip() } else { power }
    }
    fn powf(self, exponent: f64) -> Self {
        (self.ln() * exponent).exp()
    }
}

/// Smallest acoustic eigenvalue for a direction in the plane, from the law with sixty digits.
fn exact_eigenvalue(tangent: &[[Exact; 4]; 4], n: &Vector2<f64>) -> Digits {
    let n = [0, 1].map(|i| Exact::constant(n[i]));
    let length = n[0] * n[0] + n[1] * n[1];
    let q = |i: usize, k: usize| {
        let mut sum = Exact::constant(0.0);
        for (j, l) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            sum = sum + tangent[2 * i + j][2 * k + l] * n[j] * n[l];
        }
        sum / length
    };
    let (half, coupling) = ((q(0, 0) - q(1, 1)) * 0.5, q(0, 1));
    let root = (half * half + coupling * coupling).sqrt();
    ((q(0, 0) + q(1, 1)) * 0.5 - root).digits()
}

const LAWS: [&str; 12] = [
    "mu/2*(I1 - 3) - mu*ln(J) + kappa/2*ln(J)^2",
    "mu/2*(I1bar - 3) + kappa/2*(J - 1)^2",
    "mu/2*(I1bar - 3) + kappa/2*((J^2 - 1)/2 - ln(J))",
    "mu/2*(I2/I3 + 2*sqrt(I3) - 5) + 0*kappa",
    "mu/2*I1 + mu/9*I2 - 3/2*mu*I3^(1/3) - mu/3*I3^(2/3) + kappa/4*ln(I3)^2",
    "-mu*40*ln(1 - (I1bar - 3)/80) + kappa/2*(J - 1)^2",
    "mu/(2*0.7)*(exp(0.7*(I1bar - 3)) - 1) + kappa/2*(J - 1)^2",
    "kappa/2*(J - 1)^2 + 0*mu",
    "kappa*J^2 + 0*mu",
    "kappa*(J - 1 - ln(J)) + 0*mu",
    "mu*(E11^2 + E22^2 + E33^2 + 2*(E12^2 + E13^2 + E23^2)) + kappa/2*(E11 + E22 + E33)^2",
    "mu/2*(I1 - 3) - mu*ln(J) + kappa/2*(C11 - 1)^2",
];

fn check_ellipticity(random: &mut Random, seen: &mut [usize; 3]) {
    Exact::forget();
    let text = random.one(&LAWS);
    let kappa = 10.0_f64.powf(10.0 + 10.0 * random.number());
    let kappa = if random.number() > 0.0 {
        kappa
    } else {
        5.0 * (1.0 + random.number())
    };
    let formula = Formula::parse(text).expect("a formula");
    let law = formula
        .with(&[("mu", 1.0 + 0.9 * random.number()), ("kappa", kappa)])
        .expect("a law");
    let reach: f64 = random.one(&[1.2, 2.0, 5.0]);
    let [a, b] = [0, 1].map(|_| reach.powf(random.number()));
    let size = 0.3 * random.number();
    let shear = random.one(&[0.0, size]);
    let f = DeformationGradient::plane_strain([[a, shear], [0.5 * shear, b]], 1.0);
    let Some(f) = f.ok().filter(|f| law.response(f).is_ok()) else {
        return;
    };
    let components = f.components();
    let variables = Jet::<4, Exact>::variables(std::array::from_fn(|n| {
        Exact::constant(components[n / 2][n % 2])
    }));
    let energy = law.energy(&DeformationGradient::from_components(std::array::from_fn(
        |i| {
            std::array::from_fn(|j| match (i, j) {
                (0 | 1, 0 | 1) => variables[2 * i + j],
                _ => Jet::constant(components[i][j]),
            })
        },
    )));
    let minimum: AcousticMinimum<2> =
        Stiffness::of(&law.response(&f).expect("a response")).minimum();
    // Error of the minimum, evaluated at its direction.
    let truth = exact_eigenvalue(&energy.hessian, &minimum.direction);
    let error = (truth.clone() - Exact::constant(minimum.eigenvalue.re).digits())
        .to_f64()
        .value();
    assert!(
        error.abs() <= minimum.rounding,
        "{text}, kappa {kappa:e} at {f:?}: {error:e} of {:e}",
        minimum.rounding
    );
    let zero = Exact::constant(0.0).digits();
    let word = minimum.ellipticity();
    seen[word as usize] += 1;
    match word {
        Ellipticity::Lost => assert!(truth < zero, "{text}, kappa {kappa:e} at {f:?}"),
        Ellipticity::Elliptic => {
            for n in 0..16 {
                let (y, x) = (f64::from(n) * std::f64::consts::PI / 16.0).sin_cos();
                let here = exact_eigenvalue(&energy.hessian, &Vector2::new(x, y));
                assert!(here > zero, "{text}, kappa {kappa:e} at {f:?}");
            }
        }
        Ellipticity::Undecided => assert!(truth.to_f64().value().abs() <= 2.0 * minimum.rounding),
    }
    // The verdict agrees with the value.
    let number = minimum.significant();
    let of_number = if number > 0.0 {
        Ellipticity::Elliptic
    } else if number < 0.0 {
        Ellipticity::Lost
    } else {
        Ellipticity::Undecided
    };
    assert_eq!(of_number, word);
}

#[test]
fn equivalent_formulas_have_equal_domains_and_proofs_are_never_contradicted() {
    let (seed, cases) = hunted(3000);
    let mut random = Random::new(seed);
    let mut seen = Seen::default();
    for _ in 0..cases {
        check_tree(&mut random, &mut seen);
    }
    if cases >= 3000 {
        let least = seen
            .defined
            .min(seen.undefined)
            .min(seen.rough)
            .min(seen.proved);
        assert!(least > cases / 300, "{seen:?}");
    }
}

#[test]
fn the_verdict_on_ellipticity_agrees_with_sixty_digit_arithmetic() {
    let (seed, cases) = hunted(150);
    let mut random = Random::new(seed);
    let mut seen = [0; 3];
    for _ in 0..cases {
        check_ellipticity(&mut random, &mut seen);
    }
    if cases >= 150 {
        assert!(seen.iter().all(|count| *count > cases / 30), "{seen:?}");
    }
}
