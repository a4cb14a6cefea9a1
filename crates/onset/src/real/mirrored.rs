//! Second-order forward differentiation at states with mirror axes.

use super::Each;
use super::{Jet, Real, Side, Work};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Function of `F_11`, `F_22`, `F_12` and `F_21` with definite parity in `F_12`, `F_21`, with its first and second derivatives at `F_12 = F_21 = 0`.
///
/// A change of sign of `F_12` and `F_21` mirrors body and space together. Quantities that vanish by this symmetry are not computed: the value and the
/// first derivatives of one parity, and all second derivatives that mix parities. A function without definite parity is [`Mirrored::Neither`], so
/// that the result is never wrong.
///
/// ```
/// use onset::real::{Mirrored, Real};
/// let [f11, f12, f21, f22] = Mirrored::variables(1.5, 2.0);
/// // det F is even, C_12 is odd, and its square is even again.
/// let jacobian = f11 * f22 - f12 * f21;
/// let shear = f11 * f12 + f21 * f22;
/// let hessian = (jacobian + shear * shear).hessian().expect("even");
/// assert_eq!(hessian[0], [0.0, 0.0, 0.0, 1.0]);
/// assert_eq!(hessian[1], [0.0, 4.5, 5.0, 0.0]);
/// assert!((jacobian + shear).hessian().is_none());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mirrored<R = f64> {
    /// Zero for any state.
    Zero,
    /// Constant, equal for all states.
    Constant(f64),
    /// Even function of `F_12` and `F_21`.
    Even(Even<R>),
    /// Odd, with its derivatives with respect to `F_12` and `F_21`.
    Odd([R; 2]),
    /// Neither even nor odd, so that no derivatives are known.
    Neither,
}

/// Function that is even in `F_12` and `F_21`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Even<R = f64> {
    /// Value of the function.
    pub value: R,
    /// First derivatives with respect to `F_11` and `F_22`.
    pub gradient: [R; 2],
    /// Second derivatives with respect to `F_11`, `F_22`: `11`, `12`, `22`.
    pub along: [R; 3],
    /// Second derivatives with respect to `F_12`, `F_21`: `11`, `12`, `22`.
    pub across: [R; 3],
}

impl<R: Real> Even<R> {
    #[inline(always)]
    fn constant(value: R) -> Self {
        let zero = R::constant(0.0);
        Self {
            value,
            gradient: [zero; 2],
            along: [zero; 3],
            across: [zero; 3],
        }
    }

    #[inline(always)]
    fn scaled(&self, factor: f64) -> Self {
        let (u, v) = (&self.along, &self.across);
        Self {
            value: self.value * factor,
            gradient: [self.gradient[0] * factor, self.gradient[1] * factor],
            along: [u[0] * factor, u[1] * factor, u[2] * factor],
            across: [v[0] * factor, v[1] * factor, v[2] * factor],
        }
    }

    #[inline(always)]
    fn plus(&self, other: &Self) -> Self {
        let sum = |a: &[R; 3], b: &[R; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        Self {
            value: self.value + other.value,
            gradient: [
                self.gradient[0] + other.gradient[0],
                self.gradient[1] + other.gradient[1],
            ],
            along: sum(&self.along, &other.along),
            across: sum(&self.across, &other.across),
        }
    }

    #[inline(always)]
    fn times(&self, other: &Self) -> Self {
        let (x, y) = (self.value, other.value);
        let ([p, q], [r, s]) = (self.gradient, other.gradient);
        let sum = |a: &[R; 3], b: &[R; 3], n: usize| x * b[n] + y * a[n];
        let (u, v) = (&self.along, &other.along);
        Self {
            value: x * y,
            gradient: [p * y + x * r, q * y + x * s],
            along: [
                sum(u, v, 0) + p * r * 2.0,
                sum(u, v, 1) + (p * s + q * r),
                sum(u, v, 2) + q * s * 2.0,
            ],
            across: [
                sum(&self.across, &other.across, 0),
                sum(&self.across, &other.across, 1),
                sum(&self.across, &other.across, 2),
            ],
        }
    }

    /// Composition with a scalar function, given its value and derivatives.
    #[inline(always)]
    fn chain(&self, [value, first, second]: &[R; 3]) -> Self {
        let (first, second) = (*first, *second);
        let [p, q] = self.gradient;
        let (u, v) = (&self.along, &self.across);
        Self {
            value: *value,
            gradient: [first * p, first * q],
            along: [
                first * u[0] + second * (p * p),
                first * u[1] + second * (p * q),
                first * u[2] + second * (q * q),
            ],
            across: [first * v[0], first * v[1], first * v[2]],
        }
    }
}

/// Operation on even functions, which numbers with several lanes evaluate with vector instructions.
enum Operation<'a, R> {
    Scaled(&'a Even<R>, f64),
    Plus(&'a Even<R>, &'a Even<R>),
    Times(&'a Even<R>, &'a Even<R>),
    Chain(&'a Even<R>, &'a [R; 3]),
}

impl<R: Real> Work for Operation<'_, R> {
    type Output = Even<R>;

    #[inline(always)]
    fn done(self) -> Even<R> {
        match self {
            Self::Scaled(x, factor) => x.scaled(factor),
            Self::Plus(x, y) => x.plus(y),
            Self::Times(x, y) => x.times(y),
            Self::Chain(x, derivatives) => x.chain(derivatives),
        }
    }
}

impl<R: Real> Mirrored<R> {
    /// Variables `F_11`, `F_12`, `F_21`, `F_22` at a state with the given diagonal.
    pub fn variables(f11: R, f22: R) -> [Self; 4] {
        let (zero, one) = (R::constant(0.0), R::constant(1.0));
        let along = |value, gradient| {
            Self::Even(Even {
                gradient,
                ..Even::constant(value)
            })
        };
        [
            along(f11, [one, zero]),
            Self::Odd([one, zero]),
            Self::Odd([zero, one]),
            along(f22, [zero, one]),
        ]
    }

    /// Returns all second derivatives with respect to `F_11`, `F_12`, `F_21`, `F_22`; `None` unless the function is even.
    pub fn hessian(&self) -> Option<[[R; 4]; 4]> {
        let zero = R::constant(0.0);
        let Even { along, across, .. } = match self {
            Self::Zero | Self::Constant(_) => Even::constant(zero),
            Self::Even(even) => *even,
            Self::Odd(_) | Self::Neither => return None,
        };
        Some([
            [along[0], zero, zero, along[1]],
            [zero, across[0], across[1], zero],
            [zero, across[1], across[2], zero],
            [along[1], zero, zero, along[2]],
        ])
    }

    fn even(operation: Operation<'_, R>) -> Self {
        Self::Even(R::vectorized(operation))
    }

    /// Composition with a scalar function through a jet of one variable, which provides the derivatives.
    fn through(
        self,
        plain: impl FnOnce(f64) -> f64,
        function: impl FnOnce(Jet<1, R>) -> Jet<1, R>,
    ) -> Self {
        match &self {
            Self::Zero => Self::constant(plain(0.0)),
            Self::Constant(x) => Self::constant(plain(*x)),
            Self::Even(even) => {
                let [variable] = Jet::variables([even.value]);
                let jet = function(variable);
                let derivatives = [jet.value, jet.gradient[0], jet.hessian[0][0]];
                Self::even(Operation::Chain(even, &derivatives))
            }
            // An even function of an odd argument would be even, but no law needs it.
            Self::Odd(_) | Self::Neither => Self::Neither,
        }
    }
}

impl<R: Real> Real for Mirrored<R> {
    fn constant(value: f64) -> Self {
        if value == 0.0 {
            Self::Zero
        } else {
            Self::Constant(value)
        }
    }
    fn value(self) -> f64 {
        match self {
            Self::Zero | Self::Odd(_) => 0.0,
            Self::Constant(value) => value,
            Self::Even(even) => even.value.value(),
            Self::Neither => f64::NAN,
        }
    }
    fn number(self) -> Option<f64> {
        match self {
            Self::Even(even) => even.value.number(),
            Self::Neither => None,
            _ => Some(self.value()),
        }
    }
    fn side(self, threshold: f64) -> Option<Side> {
        match self {
            Self::Even(even) => even.value.side(threshold),
            _ => self.value().side(threshold),
        }
    }
    fn blended(self, threshold: f64, below: Self, above: Self) -> Self {
        let even = |number: Self| match number {
            Self::Zero => Some(Even::constant(R::constant(0.0))),
            Self::Constant(value) => Some(Even::constant(R::constant(value))),
            Self::Even(even) => Some(even),
            Self::Odd(_) | Self::Neither => None,
        };
        let Self::Even(decisive) = self else {
            return Self::Neither;
        };
        let blended = |x: R, y: R| decisive.value.blended(threshold, x, y);
        match (even(below), even(above), below, above) {
            (Some(x), Some(y), ..) => Self::Even(Even {
                value: blended(x.value, y.value),
                gradient: [0, 1].each(|a| blended(x.gradient[a], y.gradient[a])),
                along: [0, 1, 2].each(|a| blended(x.along[a], y.along[a])),
                across: [0, 1, 2].each(|a| blended(x.across[a], y.across[a])),
            }),
            (_, _, Self::Odd(x), Self::Odd(y)) => Self::Odd([0, 1].each(|a| blended(x[a], y[a]))),
            _ => Self::Neither,
        }
    }
    fn recip(self) -> Self {
        self.through(Real::recip, Real::recip)
    }
    fn sqrt(self) -> Self {
        self.through(Real::sqrt, Real::sqrt)
    }
    fn exp(self) -> Self {
        self.through(Real::exp, Real::exp)
    }
    fn ln(self) -> Self {
        self.through(Real::ln, Real::ln)
    }
    fn sin(self) -> Self {
        self.through(Real::sin, Real::sin)
    }
    fn cos(self) -> Self {
        self.through(Real::cos, Real::cos)
    }
    fn sinh(self) -> Self {
        self.through(Real::sinh, Real::sinh)
    }
    fn cosh(self) -> Self {
        self.through(Real::cosh, Real::cosh)
    }
    fn tanh(self) -> Self {
        self.through(Real::tanh, Real::tanh)
    }
    fn powi(self, exponent: i32) -> Self {
        match (self, exponent) {
            (Self::Odd(_), 0) => Self::Constant(1.0),
            (Self::Odd(_), 1) => self,
            (Self::Odd(_), 2) => self * self,
            // The square is even; higher powers vanish to second order.
            (Self::Odd(_), 3..) => Self::Zero,
            _ => self.through(|x| x.powi(exponent), |x| x.powi(exponent)),
        }
    }
    fn powf(self, exponent: f64) -> Self {
        self.through(|x| x.powf(exponent), |x| x.powf(exponent))
    }
}

impl<R: Real> Add for Mirrored<R> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        // By reference, because these numbers are large.
        match (&self, &other) {
            (Self::Neither, _) | (_, Self::Neither) => Self::Neither,
            (Self::Zero, x) | (x, Self::Zero) => *x,
            (Self::Even(x), Self::Even(y)) => Self::even(Operation::Plus(x, y)),
            (Self::Odd(x), Self::Odd(y)) => Self::Odd([x[0] + y[0], x[1] + y[1]]),
            (Self::Constant(c), Self::Constant(d)) => Self::Constant(c + d),
            (Self::Constant(c), Self::Even(x)) | (Self::Even(x), Self::Constant(c)) => {
                Self::Even(Even {
                    value: x.value + *c,
                    ..*x
                })
            }
            _ => Self::Neither,
        }
    }
}

impl<R: Real> Mul for Mirrored<R> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        match (&self, &other) {
            (Self::Neither, _) | (_, Self::Neither) => Self::Neither,
            (Self::Zero, _) | (_, Self::Zero) => Self::Zero,
            (Self::Even(x), Self::Even(y)) => Self::even(Operation::Times(x, y)),
            (Self::Constant(c), x) | (x, Self::Constant(c)) => *x * *c,
            (Self::Even(x), Self::Odd(y)) | (Self::Odd(y), Self::Even(x)) => {
                Self::Odd([x.value * y[0], x.value * y[1]])
            }
            (Self::Odd(x), Self::Odd(y)) => Self::Even(Even {
                across: [
                    x[0] * y[0] * 2.0,
                    x[0] * y[1] + x[1] * y[0],
                    x[1] * y[1] * 2.0,
                ],
                ..Even::constant(R::constant(0.0))
            }),
        }
    }
}

impl<R: Real> Sub for Mirrored<R> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

#[allow(
    clippy::suspicious_arithmetic_impl,
    reason = "a quotient is a product with the reciprocal"
)]
impl<R: Real> Div for Mirrored<R> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        self * other.recip()
    }
}

impl<R: Real> Neg for Mirrored<R> {
    type Output = Self;
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl<R: Real> Add<f64> for Mirrored<R> {
    type Output = Self;
    fn add(self, constant: f64) -> Self {
        self + Self::constant(constant)
    }
}

impl<R: Real> Sub<f64> for Mirrored<R> {
    type Output = Self;
    fn sub(self, constant: f64) -> Self {
        self + Self::constant(-constant)
    }
}

impl<R: Real> Mul<f64> for Mirrored<R> {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        match &self {
            // A term that does not contribute to a sum does not affect its parity.
            _ if factor == 0.0 => Self::Zero,
            Self::Constant(c) => Self::Constant(c * factor),
            Self::Even(x) => Self::even(Operation::Scaled(x, factor)),
            Self::Odd(slopes) => Self::Odd([slopes[0] * factor, slopes[1] * factor]),
            Self::Zero | Self::Neither => self,
        }
    }
}

impl<R: Real> Div<f64> for Mirrored<R> {
    type Output = Self;
    fn div(self, divisor: f64) -> Self {
        self * (1.0 / divisor)
    }
}
