//! Second-order forward differentiation at states with mirror axes.

use super::{Jet, Real, Side};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A function of `F_11`, `F_22`, `F_12` and `F_21` with its first and second derivatives where `F_12 = F_21 = 0`, as long as it
/// is even or odd under a change of sign of the latter two, which mirrors body and space alike.
///
/// What such a symmetry makes vanish is never computed: the value and the first derivatives of one parity, and all second
/// derivatives that mix parities. A function without it is [`Mirrored::Neither`], and says so instead of being wrong.
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
pub enum Mirrored {
    /// Zero for any state.
    Zero,
    /// The same for any state.
    Constant(f64),
    /// Even.
    Even(Even),
    /// Odd, with its derivatives by `F_12` and `F_21`.
    Odd([f64; 2]),
    /// Neither even nor odd: nothing is known.
    Neither,
}

/// A function that is even in `F_12` and `F_21`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Even {
    /// The value.
    pub value: f64,
    /// Derivatives by `F_11`, `F_22`.
    pub gradient: [f64; 2],
    /// Second derivatives by `F_11`, `F_22`: `11`, `12`, `22`.
    pub along: [f64; 3],
    /// Second derivatives by `F_12`, `F_21`, likewise.
    pub across: [f64; 3],
}

impl Even {
    const ZERO: Self = Self {
        value: 0.0,
        gradient: [0.0; 2],
        along: [0.0; 3],
        across: [0.0; 3],
    };

    #[inline]
    fn scaled(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            gradient: self.gradient.map(|x| x * factor),
            along: self.along.map(|x| x * factor),
            across: self.across.map(|x| x * factor),
        }
    }

    #[inline]
    fn plus(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            gradient: [0, 1].map(|a| self.gradient[a] + other.gradient[a]),
            along: [0, 1, 2].map(|a| self.along[a] + other.along[a]),
            across: [0, 1, 2].map(|a| self.across[a] + other.across[a]),
        }
    }

    #[inline]
    fn times(self, other: Self) -> Self {
        let (x, y) = (self.value, other.value);
        let [p, q] = self.gradient;
        let [r, s] = other.gradient;
        let cross = [2.0 * p * r, p * s + q * r, 2.0 * q * s];
        Self {
            value: x * y,
            gradient: [p * y + x * r, q * y + x * s],
            along: [0, 1, 2].map(|a| x * other.along[a] + y * self.along[a] + cross[a]),
            across: [0, 1, 2].map(|a| x * other.across[a] + y * self.across[a]),
        }
    }

    /// The composition with a scalar function of which value and derivatives are given.
    #[inline]
    fn chain(self, value: f64, first: f64, second: f64) -> Self {
        let [p, q] = self.gradient;
        let cross = [p * p, p * q, q * q];
        Self {
            value,
            gradient: [first * p, first * q],
            along: [0, 1, 2].map(|a| first * self.along[a] + second * cross[a]),
            across: self.across.map(|x| first * x),
        }
    }
}

impl Mirrored {
    /// `F_11`, `F_12`, `F_21`, `F_22` at a state with the given diagonal.
    pub fn variables(f11: f64, f22: f64) -> [Self; 4] {
        let along = |value, gradient| {
            Self::Even(Even {
                value,
                gradient,
                ..Even::ZERO
            })
        };
        [
            along(f11, [1.0, 0.0]),
            Self::Odd([1.0, 0.0]),
            Self::Odd([0.0, 1.0]),
            along(f22, [0.0, 1.0]),
        ]
    }

    /// All second derivatives by `F_11`, `F_12`, `F_21`, `F_22`, unless the function is not even.
    pub fn hessian(&self) -> Option<[[f64; 4]; 4]> {
        let Even { along, across, .. } = match self {
            Self::Zero | Self::Constant(_) => Even::ZERO,
            Self::Even(even) => *even,
            Self::Odd(_) | Self::Neither => return None,
        };
        Some([
            [along[0], 0.0, 0.0, along[1]],
            [0.0, across[0], across[1], 0.0],
            [0.0, across[1], across[2], 0.0],
            [along[1], 0.0, 0.0, along[2]],
        ])
    }

    /// The composition with a scalar function, which gives value and derivatives at a value.
    #[inline]
    fn composed(self, function: impl FnOnce(f64) -> [f64; 3]) -> Self {
        match self {
            Self::Zero => Self::constant(function(0.0)[0]),
            Self::Constant(x) => Self::constant(function(x)[0]),
            Self::Even(even) => {
                let [value, first, second] = function(even.value);
                Self::Even(even.chain(value, first, second))
            }
            // An even function of it could be told, but no law needs it.
            Self::Odd(_) | Self::Neither => Self::Neither,
        }
    }

    /// The composition with a scalar function through the jet of one variable, which knows the derivatives.
    #[inline]
    fn through(self, function: impl FnOnce(Jet<1>) -> Jet<1>) -> Self {
        self.composed(|x| {
            let [variable] = Jet::variables([x]);
            let jet = function(variable);
            [jet.value, jet.gradient[0], jet.hessian[0][0]]
        })
    }
}

impl Real for Mirrored {
    #[inline]
    fn constant(value: f64) -> Self {
        if value == 0.0 {
            Self::Zero
        } else {
            Self::Constant(value)
        }
    }
    #[inline]
    fn value(self) -> f64 {
        match self {
            Self::Zero | Self::Odd(_) => 0.0,
            Self::Constant(value) => value,
            Self::Even(even) => even.value,
            Self::Neither => f64::NAN,
        }
    }
    #[inline]
    fn side(self, threshold: f64) -> Option<Side> {
        self.value().side(threshold)
    }
    #[inline]
    fn recip(self) -> Self {
        self.through(Real::recip)
    }
    #[inline]
    fn sqrt(self) -> Self {
        self.through(Real::sqrt)
    }
    #[inline]
    fn exp(self) -> Self {
        self.through(Real::exp)
    }
    #[inline]
    fn ln(self) -> Self {
        self.through(Real::ln)
    }
    #[inline]
    fn sin(self) -> Self {
        self.through(Real::sin)
    }
    #[inline]
    fn cos(self) -> Self {
        self.through(Real::cos)
    }
    #[inline]
    fn powi(self, exponent: i32) -> Self {
        match (self, exponent) {
            (Self::Odd(_), 0) => Self::Constant(1.0),
            (Self::Odd(_), 1) => self,
            (Self::Odd(_), 2) => self * self,
            // To second order.
            (Self::Odd(_), 3..) => Self::Zero,
            _ => self.through(|x| x.powi(exponent)),
        }
    }
    #[inline]
    fn powf(self, exponent: f64) -> Self {
        self.through(|x| x.powf(exponent))
    }
}

impl Add for Mirrored {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        match (self, other) {
            (Self::Neither, _) | (_, Self::Neither) => Self::Neither,
            (Self::Zero, x) | (x, Self::Zero) => x,
            (Self::Even(x), Self::Even(y)) => Self::Even(x.plus(y)),
            (Self::Odd(x), Self::Odd(y)) => Self::Odd([x[0] + y[0], x[1] + y[1]]),
            (Self::Constant(c), Self::Constant(d)) => Self::Constant(c + d),
            (Self::Constant(c), Self::Even(x)) | (Self::Even(x), Self::Constant(c)) => {
                Self::Even(Even {
                    value: x.value + c,
                    ..x
                })
            }
            _ => Self::Neither,
        }
    }
}

impl Mul for Mirrored {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        match (self, other) {
            (Self::Neither, _) | (_, Self::Neither) => Self::Neither,
            (Self::Zero, _) | (_, Self::Zero) => Self::Zero,
            (Self::Even(x), Self::Even(y)) => Self::Even(x.times(y)),
            (Self::Constant(c), x) | (x, Self::Constant(c)) => x * c,
            (Self::Even(x), Self::Odd(y)) | (Self::Odd(y), Self::Even(x)) => {
                Self::Odd(y.map(|slope| x.value * slope))
            }
            (Self::Odd(x), Self::Odd(y)) => Self::Even(Even {
                across: [
                    2.0 * x[0] * y[0],
                    x[0] * y[1] + x[1] * y[0],
                    2.0 * x[1] * y[1],
                ],
                ..Even::ZERO
            }),
        }
    }
}

impl Sub for Mirrored {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

#[allow(
    clippy::suspicious_arithmetic_impl,
    reason = "a quotient is a product with the reciprocal"
)]
impl Div for Mirrored {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        self * other.recip()
    }
}

impl Neg for Mirrored {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Add<f64> for Mirrored {
    type Output = Self;
    #[inline]
    fn add(self, constant: f64) -> Self {
        self + Self::constant(constant)
    }
}

impl Sub<f64> for Mirrored {
    type Output = Self;
    #[inline]
    fn sub(self, constant: f64) -> Self {
        self + Self::constant(-constant)
    }
}

impl Mul<f64> for Mirrored {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        match self {
            Self::Constant(c) => Self::Constant(c * factor),
            Self::Even(x) => Self::Even(x.scaled(factor)),
            Self::Odd(slopes) => Self::Odd(slopes.map(|slope| slope * factor)),
            Self::Zero | Self::Neither => self,
        }
    }
}

impl Div<f64> for Mirrored {
    type Output = Self;
    #[inline]
    fn div(self, divisor: f64) -> Self {
        self * (1.0 / divisor)
    }
}
