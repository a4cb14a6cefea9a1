//! Second-order forward differentiation.

use super::Real;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value with its gradient and Hessian in `N` variables: the Taylor expansion to second order.
///
/// ```
/// use onset::real::{Jet, Real};
/// // x^2 y at (3, 5)
/// let [x, y] = Jet::variables([3.0, 5.0]);
/// let f = x * x * y;
/// assert_eq!(f.value(), 45.0);
/// assert_eq!(f.gradient, [30.0, 9.0]);
/// assert_eq!(f.hessian, [[10.0, 6.0], [6.0, 0.0]]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<const N: usize> {
    /// The value.
    pub value: f64,
    /// First derivatives.
    pub gradient: [f64; N],
    /// Second derivatives; always symmetric.
    pub hessian: [[f64; N]; N],
}

impl<const N: usize> Jet<N> {
    /// The `N` independent variables at a point: unit gradients, zero Hessians.
    pub fn variables(point: [f64; N]) -> [Self; N] {
        std::array::from_fn(|i| {
            let mut variable = Self::constant(point[i]);
            variable.gradient[i] = 1.0;
            variable
        })
    }

    /// The composition `h(x)` of a scalar function with this jet, from `h`, `h'` and `h''` at the
    /// value: `grad = h' g`, `Hess = h' H + h'' g (x) g`.
    fn chain(self, value: f64, first: f64, second: f64) -> Self {
        let mut result = self;
        result.value = value;
        for i in 0..N {
            for j in 0..N {
                let product = self.gradient[i] * self.gradient[j];
                result.hessian[i][j] = first * self.hessian[i][j] + second * product;
            }
            result.gradient[i] = first * self.gradient[i];
        }
        result
    }

    /// Applies the same linear operation to value, gradient and Hessian.
    fn zip(self, other: Self, operation: impl Fn(f64, f64) -> f64) -> Self {
        let mut result = self;
        result.value = operation(self.value, other.value);
        for i in 0..N {
            result.gradient[i] = operation(self.gradient[i], other.gradient[i]);
            for j in 0..N {
                result.hessian[i][j] = operation(self.hessian[i][j], other.hessian[i][j]);
            }
        }
        result
    }
}

impl<const N: usize> Real for Jet<N> {
    fn constant(value: f64) -> Self {
        Self {
            value,
            gradient: [0.0; N],
            hessian: [[0.0; N]; N],
        }
    }
    fn value(self) -> f64 {
        self.value
    }
    fn recip(self) -> Self {
        let r = self.value.recip();
        self.chain(r, -r * r, 2.0 * r * r * r)
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root, -0.25 / (root * self.value))
    }
    fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e, e)
    }
    fn ln(self) -> Self {
        let r = self.value.recip();
        self.chain(self.value.ln(), r, -r * r)
    }
    fn sin(self) -> Self {
        let (s, c) = self.value.sin_cos();
        self.chain(s, c, -s)
    }
    fn cos(self) -> Self {
        let (s, c) = self.value.sin_cos();
        self.chain(c, -s, -c)
    }
    fn powi(self, exponent: i32) -> Self {
        let n = f64::from(exponent);
        // The coefficient is tested first: 0 * x^(n-1) must be 0 also at x = 0.
        let term = |coefficient: f64, power: i32| {
            if coefficient == 0.0 {
                0.0
            } else {
                coefficient * self.value.powi(power)
            }
        };
        self.chain(
            self.value.powi(exponent),
            term(n, exponent - 1),
            term(n * (n - 1.0), exponent - 2),
        )
    }
    fn powf(self, exponent: f64) -> Self {
        let p = self.value.powf(exponent);
        let first = exponent * p / self.value;
        self.chain(p, first, (exponent - 1.0) * first / self.value)
    }
}

impl<const N: usize> Add for Jet<N> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<const N: usize> Sub for Jet<N> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<const N: usize> Mul for Jet<N> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let mut result = Self::constant(self.value * other.value);
        for i in 0..N {
            result.gradient[i] = self.value * other.gradient[i] + other.value * self.gradient[i];
            for j in 0..=i {
                let second = self.value * other.hessian[i][j]
                    + other.value * self.hessian[i][j]
                    + self.gradient[i] * other.gradient[j]
                    + other.gradient[i] * self.gradient[j];
                // Mirrored, so that the Hessian is symmetric to the last digit.
                result.hessian[i][j] = second;
                result.hessian[j][i] = second;
            }
        }
        result
    }
}

#[allow(
    clippy::suspicious_arithmetic_impl,
    reason = "a quotient is a product with the reciprocal"
)]
impl<const N: usize> Div for Jet<N> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        self * other.recip()
    }
}

impl<const N: usize> Neg for Jet<N> {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<const N: usize> Add<f64> for Jet<N> {
    type Output = Self;
    fn add(mut self, constant: f64) -> Self {
        self.value += constant;
        self
    }
}

impl<const N: usize> Sub<f64> for Jet<N> {
    type Output = Self;
    fn sub(self, constant: f64) -> Self {
        self + -constant
    }
}

impl<const N: usize> Mul<f64> for Jet<N> {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        self.chain(self.value * factor, factor, 0.0)
    }
}

impl<const N: usize> Div<f64> for Jet<N> {
    type Output = Self;
    fn div(self, divisor: f64) -> Self {
        self.chain(self.value / divisor, divisor.recip(), 0.0)
    }
}
