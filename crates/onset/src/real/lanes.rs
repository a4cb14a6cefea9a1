//! Several numbers in parallel.

use super::array_of;
use super::{Real, Side, Work};
use pulp::{Arch, NullaryFnOnce};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Number of parallel numbers.
pub const LANES: usize = 8;

/// Numbers that fill the widest vector registers. All operations act lane by lane; each lane has the result of the scalar operation.
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

/// Work compiled for the widest vectors of the machine.
struct InVectors<W>(W);

impl<W: Work> NullaryFnOnce for InVectors<W> {
    type Output = W::Output;

    #[inline(always)]
    fn call(self) -> W::Output {
        self.0.done()
    }
}

impl Lanes {
    /// Loads the first numbers of a slice.
    #[inline(always)]
    pub(crate) fn of(numbers: &[f64]) -> Self {
        let mut lanes = [0.0; LANES];
        lanes.copy_from_slice(&numbers[..LANES]);
        Self(lanes)
    }

    /// Loads the numbers starting at an index; lanes beyond the end are filled with `beyond`.
    #[inline(always)]
    pub(crate) fn at(numbers: &[f64], place: usize, beyond: f64) -> Self {
        // Select an index rather than numbers, which would pass through memory.
        let partly;
        Self::of(match numbers.get(place..place.wrapping_add(LANES)) {
            Some(own) => own,
            None => {
                partly = Self::partly(numbers, place, beyond);
                &partly
            }
        })
    }

    #[cold]
    #[inline(never)]
    fn partly(numbers: &[f64], place: usize, beyond: f64) -> [f64; LANES] {
        let one = |lane| numbers.get(place.wrapping_add(lane)).copied();
        array_of(|lane| one(lane).unwrap_or(beyond))
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

    /// Common value of all lanes; NaN if they differ.
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

    // No early return, so that all lanes are compared together.
    #[inline(always)]
    fn side(self, threshold: f64) -> Option<Side> {
        let (mut below, mut above) = (true, true);
        for lane in self.0 {
            below &= lane < threshold;
            above &= lane >= threshold;
        }
        match (below, above) {
            (true, _) => Some(Side::Below),
            (_, true) => Some(Side::Above),
            _ => None,
        }
    }

    #[inline(always)]
    fn blended(self, threshold: f64, below: Self, above: Self) -> Self {
        let either = |n: usize| match self.0[n] < threshold {
            true => below.0[n],
            false => above.0[n],
        };
        Self(array_of(|n| match self.0[n].is_nan() {
            true => f64::NAN,
            false => either(n),
        }))
    }

    fn vectorized<W: Work>(work: W) -> W::Output {
        Arch::new().dispatch(InVectors(work))
    }

    #[inline(always)]
    fn recip(self) -> Self {
        self.map(f64::recip)
    }
    #[inline(always)]
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
    /// Power by repeated squaring, as for a single number.
    #[inline(always)]
    fn powi(self, exponent: i32) -> Self {
        let (mut left, mut square) = (exponent.unsigned_abs(), self);
        let mut power = Self([1.0; LANES]);
        loop {
            if left & 1 == 1 {
                power = power * square;
            }
            left /= 2;
            if left == 0 {
                break;
            }
            square = square * square;
        }
        if exponent < 0 { power.recip() } else { power }
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
