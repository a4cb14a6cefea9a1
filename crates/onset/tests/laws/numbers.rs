//! Jets compared with the hyper-dual numbers of `num-dual` and with finite differences.

use crate::table::differentiated;
use num_dual::{DualNum, HyperDual64};
use onset::real::{Jet, Real};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Hyper-dual numbers as a number type of this crate.
#[derive(Clone, Copy, Debug)]
struct Oracle(HyperDual64);

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl $trait for Oracle {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self($trait::$method(self.0, other.0))
            }
        }
        impl $trait<f64> for Oracle {
            type Output = Self;
            fn $method(self, other: f64) -> Self {
                Self($trait::$method(self.0, other))
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl Neg for Oracle {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Real for Oracle {
    fn constant(value: f64) -> Self {
        Self(HyperDual64::from(value))
    }
    fn value(self) -> f64 {
        self.0.re
    }
    fn recip(self) -> Self {
        Self(self.0.recip())
    }
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    fn exp(self) -> Self {
        Self(self.0.exp())
    }
    fn ln(self) -> Self {
        Self(self.0.ln())
    }
    fn sin(self) -> Self {
        Self(self.0.sin())
    }
    fn cos(self) -> Self {
        Self(self.0.cos())
    }
    fn sinh(self) -> Self {
        Self(self.0.sinh())
    }
    fn cosh(self) -> Self {
        Self(self.0.cosh())
    }
    fn tanh(self) -> Self {
        Self(self.0.tanh())
    }
    fn powi(self, exponent: i32) -> Self {
        Self(self.0.powi(exponent))
    }
    fn powf(self, exponent: f64) -> Self {
        Self(self.0.powf(exponent))
    }
}

/// One instruction of a random program; operands are earlier results.
#[derive(Clone, Copy, Debug)]
struct Instruction {
    operation: usize,
    first: usize,
    second: usize,
    constant: f64,
}

const OPERATIONS: usize = 20;

fn applied<R: Real>(operation: usize, a: R, b: R, constant: f64) -> R {
    // Arguments of roots, logarithms and denominators are kept away from zero.
    let positive = |x: R| x * x + 0.5;
    match operation {
        0 => a + b,
        1 => a - b,
        2 => a * b,
        3 => a / positive(b),
        4 => -a,
        5 => a + constant,
        6 => a - constant,
        7 => a * constant,
        8 => a / (constant * constant + 0.5),
        9 => positive(a).recip(),
        10 => positive(a).sqrt(),
        11 => a.sin().exp(),
        12 => positive(a).ln(),
        13 => a.sin(),
        14 => a.cos(),
        15 => positive(a).powi((3.0 * constant) as i32),
        16 => a.sin().sinh(),
        17 => a.sin().cosh(),
        18 => a.tanh(),
        _ => positive(a).powf(constant),
    }
}

/// Runs a program on three variables.
fn run<R: Real>(program: &[Instruction], variables: [R; 3]) -> R {
    let mut results: Vec<R> = variables.to_vec();
    for step in program {
        let (a, b) = (
            results[step.first % results.len()],
            results[step.second % results.len()],
        );
        let result = applied(step.operation, a, b, step.constant);
        // Repeated squaring must not overflow.
        results.push(if result.value().abs() > 20.0 {
            result.sin()
        } else {
            result
        });
    }
    results[results.len() - 1]
}

fn instruction() -> impl Strategy<Value = Instruction> {
    (0..OPERATIONS, 0..64_usize, 0..64_usize, -2.0..2.0).prop_map(
        |(operation, first, second, constant)| Instruction {
            operation,
            first,
            second,
            constant,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 2000, failure_persistence: None, rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default()
    })]
    #[test]
    fn jets_of_random_compositions_equal_hyper_dual_numbers(
        program in prop::collection::vec(instruction(), 1..10),
        point in prop::array::uniform3(-1.5..1.5_f64),
    ) {
        let jet = run(&program, Jet::variables(point));
        let scale = jet.gradient.iter().chain(jet.hessian.as_flattened())
            .fold(1.0_f64, |scale, x| scale.max(x.abs()));
        prop_assert!((jet.value - run(&program, point)).abs() < 1e-12 * scale, "the plain value");
        for i in 0..3 {
            for j in 0..3 {
                prop_assert!((jet.hessian[i][j] - jet.hessian[j][i]).abs() < 1e-12 * scale, "symmetry");
                let along = |n: usize, axis: usize| if n == axis { 1.0 } else { 0.0 };
                let variables = std::array::from_fn(|n| {
                    Oracle(HyperDual64::new(point[n], along(n, i), along(n, j), 0.0))
                });
                let oracle = run(&program, variables).0;
                prop_assert!((jet.gradient[i] - oracle.eps1).abs() < 1e-9 * scale);
                prop_assert!((jet.hessian[i][j] - oracle.eps1eps2).abs() < 1e-9 * scale);
            }
        }
    }
}

#[test]
fn every_operation_has_the_finite_difference_derivatives() {
    for operation in 0..OPERATIONS {
        let program = [Instruction {
            operation,
            first: 0,
            second: 1,
            constant: 1.3,
        }];
        let point = [0.7, -0.4, 0.2];
        let jet = run(&program, Jet::variables(point));
        for i in 0..3 {
            let shifted = |t: f64| {
                let mut moved = point;
                moved[i] += t;
                moved
            };
            let value = |t: f64| run(&program, shifted(t));
            let gradient = |t: f64| run(&program, Jet::variables(shifted(t))).gradient;
            let first = differentiated(1e-3, value);
            assert!(
                (jet.gradient[i] - first).abs() < 1e-9,
                "operation {operation}, variable {i}"
            );
            for j in 0..3 {
                let second = differentiated(1e-3, |t| gradient(t)[j]);
                assert!(
                    (jet.hessian[i][j] - second).abs() < 1e-9,
                    "operation {operation}, {i} and {j}"
                );
            }
        }
    }
}

#[test]
fn integer_powers_have_derivatives_at_zero() {
    let [x] = Jet::variables([0.0]);
    for (exponent, expected) in [
        (0, [1.0, 0.0, 0.0]),
        (1, [0.0, 1.0, 0.0]),
        (2, [0.0, 0.0, 2.0]),
        (3, [0.0; 3]),
    ] {
        let power = x.powi(exponent);
        assert_eq!(
            [power.value, power.gradient[0], power.hessian[0][0]],
            expected,
            "x^{exponent} at 0"
        );
    }
}
