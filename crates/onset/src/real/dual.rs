//! First-order forward differentiation.

use super::array_of;
use super::{Real, Side, Work};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Value with its first derivatives in `N` variables, over the numbers `R`.
///
/// It differentiates a discrete force to a stiffness, and an energy to a stress.
///
/// ```
/// use onset::real::{Dual, Real};
/// // sqrt(x) y at (4, 3)
/// let [x, y] = Dual::variables([4.0, 3.0]);
/// let f = x.sqrt() * y;
/// assert_eq!(f.value, 6.0);
/// assert_eq!(f.gradient, [0.75, 2.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize, R = f64> {
    /// Value of the function.
    pub value: R,
    /// First derivatives of the function.
    pub gradient: [R; N],
}

/// Linear combination of gradients, which numbers with several lanes evaluate with vector instructions.
enum Combined<'a, const N: usize, R> {
    Scaled(&'a [R; N], R),
    Both(&'a [R; N], R, &'a [R; N], R),
}

impl<const N: usize, R: Real> Work for Combined<'_, N, R> {
    type Output = [R; N];

    #[inline(always)]
    fn done(self) -> [R; N] {
        match self {
            Self::Scaled(x, factor) => array_of(|i| x[i] * factor),
            Self::Both(x, a, y, b) => array_of(|i| x[i] * a + y[i] * b),
        }
    }
}

impl<const N: usize, R: Real> Dual<N, R> {
    /// Number with zero derivatives.
    #[inline(always)]
    pub(crate) fn fixed(value: R) -> Self {
        Self {
            value,
            gradient: [R::constant(0.0); N],
        }
    }

    /// Independent variables at a point.
    pub fn variables(point: [R; N]) -> [Self; N] {
        array_of(|i| Self::variable(point[i], i))
    }

    /// One of the independent variables.
    pub fn variable(value: R, number: usize) -> Self {
        let mut variable = Self::fixed(value);
        variable.gradient[number] = R::constant(1.0);
        variable
    }

    /// Composition with a scalar function, from its value and first derivative.
    #[inline(always)]
    fn chain(self, value: R, first: R) -> Self {
        Self {
            value,
            gradient: R::vectorized(Combined::Scaled(&self.gradient, first)),
        }
    }

    #[inline(always)]
    fn with(self, other: Self, value: R, own: R, others: R) -> Self {
        let combined = Combined::Both(&self.gradient, own, &other.gradient, others);
        Self {
            value,
            gradient: R::vectorized(combined),
        }
    }
}

impl<const N: usize, R: Real> Real for Dual<N, R> {
    fn constant(value: f64) -> Self {
        Self::fixed(R::constant(value))
    }
    fn value(self) -> f64 {
        self.value.value()
    }
    fn number(self) -> Option<f64> {
        self.value.number()
    }
    fn side(self, threshold: f64) -> Option<Side> {
        self.value.side(threshold)
    }
    fn blended(self, threshold: f64, below: Self, above: Self) -> Self {
        let blended = |x: R, y: R| self.value.blended(threshold, x, y);
        Self {
            value: blended(below.value, above.value),
            gradient: array_of(|i| blended(below.gradient[i], above.gradient[i])),
        }
    }
    fn recip(self) -> Self {
        let r = self.value.recip();
        self.chain(r, -r * r)
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, R::constant(0.5) / root)
    }
    fn exp(self) -> Self {
        let e = self.value.exp();
        self.chain(e, e)
    }
    fn ln(self) -> Self {
        self.chain(self.value.ln(), self.value.recip())
    }
    fn sin(self) -> Self {
        self.chain(self.value.sin(), self.value.cos())
    }
    fn cos(self) -> Self {
        self.chain(self.value.cos(), -self.value.sin())
    }
    fn sinh(self) -> Self {
        self.chain(self.value.sinh(), self.value.cosh())
    }
    fn cosh(self) -> Self {
        self.chain(self.value.cosh(), self.value.sinh())
    }
    fn tanh(self) -> Self {
        self.chain(self.value.tanh(), self.value.cosh().powi(-2))
    }
    fn powi(self, exponent: i32) -> Self {
        // Test the exponent first: 0 * x^(n-1) must be 0 at x = 0 too.
        let first = if exponent == 0 {
            R::constant(0.0)
        } else {
            self.value.powi(exponent - 1) * f64::from(exponent)
        };
        self.chain(self.value.powi(exponent), first)
    }
    fn powf(self, exponent: f64) -> Self {
        let power = self.value.powf(exponent);
        self.chain(power, power * exponent / self.value)
    }
}

impl<const N: usize, R: Real> Add for Dual<N, R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(
            other,
            self.value + other.value,
            R::constant(1.0),
            R::constant(1.0),
        )
    }
}

impl<const N: usize, R: Real> Sub for Dual<N, R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(
            other,
            self.value - other.value,
            R::constant(1.0),
            R::constant(-1.0),
        )
    }
}

impl<const N: usize, R: Real> Mul for Dual<N, R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(other, self.value * other.value, other.value, self.value)
    }
}

impl<const N: usize, R: Real> Div for Dual<N, R> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let quotient = self.value / other.value;
        self.with(
            other,
            quotient,
            other.value.recip(),
            -quotient / other.value,
        )
    }
}

impl<const N: usize, R: Real> Neg for Dual<N, R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.chain(-self.value, R::constant(-1.0))
    }
}

impl<const N: usize, R: Real> Add<f64> for Dual<N, R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, constant: f64) -> Self {
        Self {
            value: self.value + constant,
            ..self
        }
    }
}

impl<const N: usize, R: Real> Sub<f64> for Dual<N, R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, constant: f64) -> Self {
        Self {
            value: self.value - constant,
            ..self
        }
    }
}

impl<const N: usize, R: Real> Mul<f64> for Dual<N, R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self.chain(self.value * factor, R::constant(factor))
    }
}

impl<const N: usize, R: Real> Div<f64> for Dual<N, R> {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: f64) -> Self {
        self.chain(self.value / divisor, R::constant(divisor.recip()))
    }
}

#[cfg(test)]
mod tests {
    use super::Dual;
    use crate::real::{Jet, Real};

    fn expression<R: Real>(x: R, y: R) -> R {
        let a = (x * y).sin() + x.ln() / y - y.powf(1.7) * 0.5;
        let b = (x - y).tanh() * x.powi(3) + (-y).exp() * x.cosh() / 3.0;
        a * b.cos() + (x * x + y * y + 1.0).sqrt() - x.sinh() * y.recip() - 0.25
    }

    #[test]
    fn a_dual_has_the_value_and_the_gradient_of_the_jet() {
        let [x, y] = Dual::variables([1.3, 0.8]);
        let dual = expression(x, y);
        let [x, y] = Jet::<2>::variables([1.3, 0.8]);
        let jet = expression(x, y);
        assert!((dual.value - jet.value).abs() < 1e-14);
        for i in 0..2 {
            assert!((dual.gradient[i] - jet.gradient[i]).abs() < 1e-13);
        }
    }
}
