//! Numbers a law can be evaluated with: plain floating point, second-order jets, and intervals.
//!
//! A strain energy is written once, generic over [`Real`]. Evaluated with [`f64`] it gives the
//! energy; evaluated with a [`Jet`] over the nine components of the deformation gradient it gives,
//! in the same pass, the stress and the tangent, exact to rounding; with jets of [`Interval`]s, bounds that hold them.

mod dual;
mod interval;
mod jet;
mod lanes;
mod mirrored;

pub use dual::Dual;
pub use interval::Interval;
pub use jet::Jet;
pub use lanes::{LANES, Lanes};
pub use mirrored::{Even, Mirrored};

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

/// A piece of work on numbers, small enough to be inlined where they want it done.
pub trait Work {
    /// What comes of it.
    type Output;

    /// Does it.
    fn done(self) -> Self::Output;
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

    /// The floating-point number that this is, derivatives apart; `None` of an interval and of lanes that differ, which stand for many.
    fn number(self) -> Option<f64> {
        Some(self.value())
    }

    /// The bounds of an interval, derivatives apart; `None` of what is not one.
    fn bounds(self) -> Option<Interval> {
        None
    }

    /// On which side of a threshold the number is; `None` where an interval holds numbers of both, and where there is no number.
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

    /// A number that stands for both: the smallest interval that holds two intervals. Of plain numbers, which stand for
    /// themselves alone, the number itself.
    fn hull(self, _other: Self) -> Self {
        self
    }

    /// One formula below a threshold of this number, another at it and above; both where that is not decided, and no number where
    /// this is none.
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

    /// What stands for the numbers of both sides where this number is on both: the hull of intervals, lane by lane the one
    /// of its side. A plain number without a side is none, and no formula has a value there.
    fn blended(self, _threshold: f64, _below: Self, _above: Self) -> Self {
        Self::constant(f64::NAN)
    }

    /// Does work in the way that is best for such numbers: in the widest vectors of the machine for those with lanes.
    #[inline(always)]
    fn vectorized<W: Work>(work: W) -> W::Output {
        work.done()
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

    /// The hyperbolic sine.
    fn sinh(self) -> Self;

    /// The hyperbolic cosine.
    fn cosh(self) -> Self;

    /// The hyperbolic tangent.
    fn tanh(self) -> Self;

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
