//! Numbers a law can be evaluated with: plain floating point and second-order jets.
//!
//! A strain energy is written once, generic over [`Real`]. Evaluated with [`f64`] it gives the
//! energy; evaluated with a [`Jet`] over the nine components of the deformation gradient it gives,
//! in the same pass, the stress and the tangent, exact to rounding.

mod jet;

pub use jet::Jet;

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number that an energy can be written with.
///
/// Comparisons are made on [`Real::value`], so that a branch in a law (a switch between tension
/// and compression, say) selects the same formula for the value and for its derivatives.
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
