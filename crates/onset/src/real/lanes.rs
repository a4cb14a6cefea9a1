//! Several numbers at once.

use super::{Real, Side, Work};
use crate::algebra::{Each, array_of};
use pulp::{Arch, NullaryFnOnce};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// How many numbers.
pub const LANES: usize = 8;

/// As many numbers as the widest vectors hold; all operations are lane by lane, and give in each lane what they give for
/// its number alone.
///
/// ```
/// use onset::real::{Lanes, Real};
/// let x = Lanes([-2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
/// let ramp = x.switch(0.0, || Lanes::constant(0.0), || x * x);
/// assert_eq!(ramp.0, [0.0, 0.0, 0.0, 1.0, 4.0, 9.0, 16.0, 25.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(64))]
pub struct Lanes(pub [f64; LANES]);

/// Work for the widest vectors of the machine.
struct InVectors<W>(W);

impl<W: Work> NullaryFnOnce for InVectors<W> {
    type Output = W::Output;

    #[inline(always)]
    fn call(self) -> W::Output {
        self.0.done()
    }
}

impl Lanes {
    /// The first ones of some numbers.
    pub(crate) fn of(numbers: &[f64]) -> Self {
        let mut lanes = [0.0; LANES];
        lanes.copy_from_slice(&numbers[..LANES]);
        Self(lanes)
    }

    #[inline(always)]
    fn map(mut self, function: impl Fn(f64) -> f64) -> Self {
        for lane in &mut self.0 {
            *lane = function(*lane);
        }
        self
    }
}

impl Real for Lanes {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self([value; LANES])
    }

    /// The value that all lanes have; no number where they differ.
    fn value(self) -> f64 {
        let [first, ..] = self.0;
        if self.0 == [first; LANES] {
            first
        } else {
            f64::NAN
        }
    }

    fn number(self) -> Option<f64> {
        Some(self.value()).filter(|value| !value.is_nan())
    }

    fn side(self, threshold: f64) -> Option<Side> {
        let [first, ..] = self.0.each(|lane| lane.side(threshold));
        let agree = self.0.iter().all(|lane| lane.side(threshold) == first);
        first.filter(|_| agree)
    }

    fn blended(self, threshold: f64, below: Self, above: Self) -> Self {
        Self(array_of(|n| match self.0[n].side(threshold) {
            Some(Side::Below) => below.0[n],
            Some(Side::Above) => above.0[n],
            None => f64::NAN,
        }))
    }

    fn vectorized<W: Work>(work: W) -> W::Output {
        Arch::new().dispatch(InVectors(work))
    }

    fn recip(self) -> Self {
        self.map(f64::recip)
    }
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }
    fn exp(self) -> Self {
        self.map(f64::exp)
    }
    fn ln(self) -> Self {
        self.map(f64::ln)
    }
    fn sin(self) -> Self {
        self.map(f64::sin)
    }
    fn cos(self) -> Self {
        self.map(f64::cos)
    }
    fn sinh(self) -> Self {
        self.map(f64::sinh)
    }
    fn cosh(self) -> Self {
        self.map(f64::cosh)
    }
    fn tanh(self) -> Self {
        self.map(f64::tanh)
    }
    fn powi(self, exponent: i32) -> Self {
        self.map(|x| x.powi(exponent))
    }
    fn powf(self, exponent: f64) -> Self {
        self.map(|x| x.powf(exponent))
    }
}

macro_rules! operation {
    ($operation:ident, $method:ident, $assign:tt) => {
        impl $operation for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for n in 0..LANES {
                    self.0[n] $assign other.0[n];
                }
                self
            }
        }

        impl $operation<f64> for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: f64) -> Self {
                for lane in &mut self.0 {
                    *lane $assign other;
                }
                self
            }
        }
    };
}

operation!(Add, add, +=);
operation!(Sub, sub, -=);
operation!(Mul, mul, *=);
operation!(Div, div, /=);

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|lane| -lane)
    }
}
