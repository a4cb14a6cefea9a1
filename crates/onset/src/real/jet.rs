//! Second-order forward differentiation.

use super::array_of;
use super::{Interval, Real, Side};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Value with its gradient and Hessian in `N` variables: the Taylor expansion to second order, over the numbers `R`.
///
/// Jets of [`Interval`](super::Interval)s enclose values and derivatives.
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
pub struct Jet<const N: usize, R = f64> {
    /// Value of the function.
    pub value: R,
    /// First derivatives of the function.
    pub gradient: [R; N],
    /// Second derivatives; always symmetric.
    pub hessian: [[R; N]; N],
}

impl<const N: usize, R: Real> Jet<N, R> {
    /// Number with zero derivatives.
    pub(crate) fn fixed(value: R) -> Self {
        let zero = R::constant(0.0);
        Self {
            value,
            gradient: [zero; N],
            hessian: [[zero; N]; N],
        }
    }

    /// Independent variables at a point: unit gradients, zero Hessians.
    pub fn variables(point: [R; N]) -> [Self; N] {
        array_of(|i| {
            let mut variable = Self::fixed(point[i]);
            variable.gradient[i] = R::constant(1.0);
            variable
        })
    }

    /// Composition `h(x)` of a scalar function with this jet, from `h`, `h'` and `h''` at the value: `grad = h' g`, `Hess = h' H + h'' g (x) g`.
    fn chain(self, value: R, first: R, second: R) -> Self {
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

    /// Applies a linear operation to value, gradient and Hessian.
    fn zip(self, other: Self, operation: impl Fn(R, R) -> R) -> Self {
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

impl<const N: usize, R: Real> Real for Jet<N, R> {
    fn constant(value: f64) -> Self {
        Self::fixed(R::constant(value))
    }
    fn value(self) -> f64 {
        self.value.value()
    }
    fn number(self) -> Option<f64> {
        self.value.number()
    }
    fn bounds(self) -> Option<Interval> {
        self.value.bounds()
    }
    fn side(self, threshold: f64) -> Option<Side> {
        self.value.side(threshold)
    }
    fn hull(self, other: Self) -> Self {
        self.zip(other, R::hull)
    }
    fn blended(self, threshold: f64, below: Self, above: Self) -> Self {
        below.zip(above, |x, y| self.value.blended(threshold, x, y))
    }
    fn recip(self) -> Self {
        let r = self.value.recip();
        self.chain(r, -r * r, r * r * r * 2.0)
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        let second = (root * self.value).recip() * -0.25;
        self.chain(root, root.recip() * 0.5, second)
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
        let (s, c) = (self.value.sin(), self.value.cos());
        self.chain(s, c, -s)
    }
    fn cos(self) -> Self {
        let (s, c) = (self.value.sin(), self.value.cos());
        self.chain(c, -s, -c)
    }
    fn sinh(self) -> Self {
        let (s, c) = (self.value.sinh(), self.value.cosh());
        self.chain(s, c, s)
    }
    fn cosh(self) -> Self {
        let (s, c) = (self.value.sinh(), self.value.cosh());
        self.chain(c, s, c)
    }
    fn tanh(self) -> Self {
        let t = self.value.tanh();
        // tanh' = 1 - t^2 = 1 / cosh^2, which keeps its digits where t is close to one.
        let first = self.value.cosh().powi(-2);
        self.chain(t, first, t * first * -2.0)
    }
    fn powi(self, exponent: i32) -> Self {
        let n = f64::from(exponent);
        // Test the coefficient first: 0 * x^(n-1) must be 0 at x = 0 too.
        let term = |coefficient: f64, power: i32| {
            if coefficient == 0.0 {
                R::constant(0.0)
            } else {
                self.value.powi(power) * coefficient
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
        let first = p * exponent / self.value;
        self.chain(p, first, first * (R::constant(exponent) - 1.0) / self.value)
    }
}

impl<const N: usize, R: Real> Add for Jet<N, R> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<const N: usize, R: Real> Sub for Jet<N, R> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<const N: usize, R: Real> Mul for Jet<N, R> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let mut result = Self::fixed(self.value * other.value);
        for i in 0..N {
            result.gradient[i] = self.value * other.gradient[i] + other.value * self.gradient[i];
            for j in 0..=i {
                let second = self.value * other.hessian[i][j]
                    + other.value * self.hessian[i][j]
                    + self.gradient[i] * other.gradient[j]
                    + other.gradient[i] * self.gradient[j];
                // Set both entries, so that the Hessian is symmetric to the last digit.
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
impl<const N: usize, R: Real> Div for Jet<N, R> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        self * other.recip()
    }
}

impl<const N: usize, R: Real> Neg for Jet<N, R> {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<const N: usize, R: Real> Add<f64> for Jet<N, R> {
    type Output = Self;
    fn add(mut self, constant: f64) -> Self {
        self.value = self.value + constant;
        self
    }
}

impl<const N: usize, R: Real> Sub<f64> for Jet<N, R> {
    type Output = Self;
    fn sub(self, constant: f64) -> Self {
        self + -constant
    }
}

impl<const N: usize, R: Real> Mul<f64> for Jet<N, R> {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        self.chain(self.value * factor, R::constant(factor), R::constant(0.0))
    }
}

impl<const N: usize, R: Real> Div<f64> for Jet<N, R> {
    type Output = Self;
    fn div(self, divisor: f64) -> Self {
        let inverse = R::constant(divisor).recip();
        self.chain(self.value / divisor, inverse, R::constant(0.0))
    }
}
