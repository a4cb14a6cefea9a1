//! First-order forward differentiation.

use super::{Real, Side};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value with its first derivatives in `N` variables: what a discrete force needs to become a stiffness.
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
pub struct Dual<const N: usize> {
    /// The value.
    pub value: f64,
    /// First derivatives.
    pub gradient: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// The `N` independent variables at a point.
    pub fn variables(point: [f64; N]) -> [Self; N] {
        std::array::from_fn(|i| Self::variable(point[i], i))
    }

    /// One of the independent variables.
    pub fn variable(value: f64, number: usize) -> Self {
        let mut variable = Self::constant(value);
        variable.gradient[number] = 1.0;
        variable
    }

    /// The composition with a scalar function, from its value and first derivative.
    #[inline(always)]
    fn chain(self, value: f64, first: f64) -> Self {
        Self {
            value,
            gradient: self.gradient.map(|slope| first * slope),
        }
    }

    #[inline(always)]
    fn with(self, other: Self, value: f64, own: f64, others: f64) -> Self {
        let slope = |i: usize| own * self.gradient[i] + others * other.gradient[i];
        Self {
            value,
            gradient: std::array::from_fn(slope),
        }
    }
}

impl<const N: usize> Real for Dual<N> {
    fn constant(value: f64) -> Self {
        Self {
            value,
            gradient: [0.0; N],
        }
    }
    fn value(self) -> f64 {
        self.value
    }
    fn side(self, threshold: f64) -> Option<Side> {
        self.value.side(threshold)
    }
    fn blended(self, _threshold: f64, _below: Self, _above: Self) -> Self {
        Self {
            value: f64::NAN,
            gradient: [f64::NAN; N],
        }
    }
    fn recip(self) -> Self {
        let r = self.value.recip();
        self.chain(r, -r * r)
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
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
        // The exponent is tested first: 0 * x^(n-1) must be 0 also at x = 0.
        let first = if exponent == 0 {
            0.0
        } else {
            f64::from(exponent) * self.value.powi(exponent - 1)
        };
        self.chain(self.value.powi(exponent), first)
    }
    fn powf(self, exponent: f64) -> Self {
        let power = self.value.powf(exponent);
        self.chain(power, power * exponent / self.value)
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(other, self.value + other.value, 1.0, 1.0)
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(other, self.value - other.value, 1.0, -1.0)
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(other, self.value * other.value, other.value, self.value)
    }
}

impl<const N: usize> Div for Dual<N> {
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

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, constant: f64) -> Self {
        self.chain(self.value + constant, 1.0)
    }
}

impl<const N: usize> Sub<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, constant: f64) -> Self {
        self.chain(self.value - constant, 1.0)
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self.chain(self.value * factor, factor)
    }
}

impl<const N: usize> Div<f64> for Dual<N> {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: f64) -> Self {
        self.chain(self.value / divisor, divisor.recip())
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
