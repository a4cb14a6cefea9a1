//! Numbers a law can be evaluated with: plain floating point, second-order jets, and intervals.
//!
//! A strain energy is written once, generic over [`Real`]. Evaluated with [`f64`] it gives the
//! energy; evaluated with a [`Jet`] over the nine components of the deformation gradient it gives,
//! in the same pass, the stress and the tangent, exact to rounding; with jets of [`Interval`]s, bounds that hold them.

mod interval;
mod jet;

pub use interval::Interval;
pub use jet::Jet;

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A side of a threshold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Less than the threshold.
    Below,
    /// The threshold itself, or more.
    Above,
}

/// A number that an energy can be written with.
///
/// A branch in a law (a switch between tension and compression, say) is made with [`Real::switch`], which selects the same
/// formula for the value and for its derivatives, and takes both where an interval does not decide.
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
    /// The constant `value`.
    fn constant(value: f64) -> Self;

    /// The floating-point value, without derivatives.
    fn value(self) -> f64;

    /// The floating-point number that this is, derivatives apart; `None` of an interval, which stands for many.
    fn number(self) -> Option<f64> {
        Some(self.value())
    }

    /// On which side of a threshold the number is; `None` where an interval holds numbers of both.
    fn side(self, threshold: f64) -> Option<Side> {
        Some(if self.value() < threshold {
            Side::Below
        } else {
            Side::Above
        })
    }

    /// A number that stands for both: the smallest interval that holds two intervals. Of numbers whose [`Real::side`]
    /// is always known it is never asked.
    fn hull(self, _other: Self) -> Self {
        self
    }

    /// One formula below a threshold of this number, another at it and above; both where that is not decided.
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
            None => below().hull(above()),
        }
    }

    /// The reciprocal, `1 / x`.
    fn recip(self) -> Self;

    /// The square root.
    fn sqrt(self) -> Self;

    /// The exponential function.
    fn exp(self) -> Self;

    /// The natural logarithm.
    fn ln(self) -> Self;

    /// The sine.
    fn sin(self) -> Self;

    /// The cosine.
    fn cos(self) -> Self;

    /// An integer power.
    fn powi(self, exponent: i32) -> Self;

    /// A real power of a positive number.
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
    fn powi(self, exponent: i32) -> Self {
        f64::powi(self, exponent)
    }
    fn powf(self, exponent: f64) -> Self {
        f64::powf(self, exponent)
    }
}
