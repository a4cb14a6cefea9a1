//! Number types for the evaluation of a law: floating point, second-order jets, and intervals.
//!
//! A strain energy is written once, generic over [`Real`]. With [`f64`] it gives the energy. With a [`Jet`] over the nine components of the
//! deformation gradient it gives the stress and the tangent in one pass, exact to rounding. With jets of [`Interval`]s it gives bounds that contain
//! them.

mod array;
mod dual;
mod interval;
mod jet;
mod lanes;
mod mirrored;

pub(crate) use array::{Each, array_of};
pub use dual::Dual;
pub use interval::Interval;
pub use jet::Jet;
pub use lanes::{LANES, Lanes};
pub use mirrored::{Even, Mirrored};

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Formats a number of a message as a user writes it: shortest digits, whole numbers without a decimal point.
pub(crate) fn plain(value: f64) -> String {
    let shortest = format!("{value:?}");
    shortest.strip_suffix(".0").unwrap_or(&shortest).to_owned()
}

/// Side of a threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The value is below the threshold.
    Below,
    /// The value equals or exceeds the threshold.
    Above,
}

/// Piece of numerical work that is small enough to be inlined by its caller.
pub trait Work {
    /// Type of the result.
    type Output;

    /// Performs the work and returns the result.
    fn done(self) -> Self::Output;
}

/// Number type for the evaluation of energies.
///
/// A branch in a law (for example between tension and compression) must use [`Real::switch`], which selects one formula for the value and for its
/// derivatives, and evaluates both if an interval does not decide.
pub trait Real:
    Copy
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
    + Div<f64, Output = Self>
{
    /// Number with a constant `value`.
    fn constant(value: f64) -> Self;

    /// Floating-point value without derivatives.
    fn value(self) -> f64;

    /// Floating-point number without derivatives; `None` for an interval and for lanes with different values, which represent several numbers.
    fn number(self) -> Option<f64> {
        Some(self.value())
    }

    /// Bounds of an interval without derivatives; `None` for other numbers.
    fn bounds(self) -> Option<Interval> {
        None
    }

    /// Side of the number relative to a threshold; `None` if an interval contains numbers on both sides, and for NaN.
    #[inline]
    fn side(self, threshold: f64) -> Option<Side> {
        let value = self.value();
        if value < threshold {
            Some(Side::Below)
        } else if value >= threshold {
            Some(Side::Above)
        } else {
            None
        }
    }

    /// Smallest interval that contains two intervals. A floating-point number is returned unchanged.
    fn hull(self, _other: Self) -> Self {
        self
    }

    /// Selects one formula below a threshold of this number, and another formula at and above the threshold.
    ///
    /// If an interval contains both sides, both formulas contribute. For NaN the result is NaN.
    ///
    /// ```
    /// use onset::real::{Interval, Real};
    /// let ramp = |x: Interval| x.switch(0.0, || Interval::ZERO, || x);
    /// assert_eq!(ramp(Interval::new(-2.0, -1.0)), Interval::ZERO);
    /// assert!(ramp(Interval::new(-1.0, 2.0)).contains(2.0));
    /// ```
    fn switch(
        self,
        threshold: f64,
        below: impl FnOnce() -> Self,
        above: impl FnOnce() -> Self,
    ) -> Self {
        match self.side(threshold) {
            Some(Side::Below) => below(),
            Some(Side::Above) => above(),
            None => self.blended(threshold, below(), above()),
        }
    }

    /// Combination of the values of both sides if the number lies on both: the hull of intervals, or lane by lane the value of its side. The result
    /// is NaN for a floating-point number without a side.
    fn blended(self, _threshold: f64, _below: Self, _above: Self) -> Self {
        Self::constant(f64::NAN)
    }

    /// Performs work in the way best for the number type: with the widest vectors of the machine for numbers with lanes.
    #[inline(always)]
    fn vectorized<W: Work>(work: W) -> W::Output {
        work.done()
    }

    /// Reciprocal `1 / x` of the number.
    fn recip(self) -> Self;

    /// Square root of the number.
    fn sqrt(self) -> Self;

    /// Exponential function of the number.
    fn exp(self) -> Self;

    /// Natural logarithm of the number.
    fn ln(self) -> Self;

    /// Sine of the number.
    fn sin(self) -> Self;

    /// Cosine of the number.
    fn cos(self) -> Self;

    /// Hyperbolic sine of the number.
    fn sinh(self) -> Self;

    /// Hyperbolic cosine of the number.
    fn cosh(self) -> Self;

    /// Hyperbolic tangent of the number.
    fn tanh(self) -> Self;

    /// Integer power of the number.
    fn powi(self, exponent: i32) -> Self;

    /// Real power of a positive number.
    fn powf(self, exponent: f64) -> Self;
}

impl Real for f64 {
    fn constant(value: f64) -> Self {
        value
    }
    fn value(self) -> f64 {
        self
    }
    fn recip(self) -> Self {
        f64::recip(self)
    }
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    fn exp(self) -> Self {
        f64::exp(self)
    }
    fn ln(self) -> Self {
        f64::ln(self)
    }
    fn sin(self) -> Self {
        f64::sin(self)
    }
    fn cos(self) -> Self {
        f64::cos(self)
    }
    fn sinh(self) -> Self {
        f64::sinh(self)
    }
    fn cosh(self) -> Self {
        f64::cosh(self)
    }
    fn tanh(self) -> Self {
        f64::tanh(self)
    }
    fn powi(self, exponent: i32) -> Self {
        f64::powi(self, exponent)
    }
    fn powf(self, exponent: f64) -> Self {
        f64::powf(self, exponent)
    }
}
