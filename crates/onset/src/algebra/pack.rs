//! Packs of numbers that fill a vector register of the machine.
//!
//! Computations with packs must run inside [`pulp::Simd::vectorize`] and be inlined there; closures are not.

use pulp::Simd;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Numbers that fill a register. All operations act lane by lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pack<S: Simd> {
    simd: S,
    values: S::f64s,
}

/// Truth value for each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mask<S: Simd> {
    simd: S,
    values: S::m64s,
}

/// Largest number of lanes of any machine: columns are padded to a multiple of it.
pub(crate) const LARGEST_LANES: usize = 8;

impl<S: Simd> Pack<S> {
    /// Copies a number to all lanes.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f64) -> Self {
        Self {
            simd,
            values: simd.splat_f64s(value),
        }
    }

    /// Loads a group of a column whose length is a multiple of the number of lanes.
    #[inline(always)]
    pub(crate) fn of(simd: S, column: &[f64], group: usize) -> Self {
        Self {
            simd,
            values: S::as_simd_f64s(column).0[group],
        }
    }

    /// Stores the numbers to a group of a column.
    #[inline(always)]
    pub(crate) fn write(self, column: &mut [f64], group: usize) {
        S::as_mut_simd_f64s(column).0[group] = self.values;
    }

    #[inline(always)]
    fn with(self, values: S::f64s) -> Self {
        Self {
            simd: self.simd,
            values,
        }
    }

    #[inline(always)]
    fn mask(self, values: S::m64s) -> Mask<S> {
        Mask {
            simd: self.simd,
            values,
        }
    }

    /// Copies a number to all lanes.
    #[inline(always)]
    pub(crate) fn constant(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    /// Computes `self * factor + term`, rounded once if the machine supports it.
    #[inline(always)]
    pub(crate) fn times_plus(self, factor: Self, term: Self) -> Self {
        self.with(
            self.simd
                .mul_add_e_f64s(self.values, factor.values, term.values),
        )
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        self.with(self.simd.sqrt_f64s(self.values))
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        // The library function takes a step that is not always inlined.
        let but_sign = self.simd.splat_f64s(f64::from_bits(!(1 << 63)));
        self.with(self.simd.and_f64s(but_sign, self.values))
    }

    /// Larger number of each lane; if one is NaN, the other.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        self.with(self.simd.max_f64s(self.values, other.values))
    }

    /// Smaller number of each lane.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        self.with(self.simd.min_f64s(self.values, other.values))
    }

    #[inline(always)]
    pub(crate) fn is_below(self, other: Self) -> Mask<S> {
        self.mask(self.simd.less_than_f64s(self.values, other.values))
    }

    #[inline(always)]
    pub(crate) fn is_at_most(self, other: Self) -> Mask<S> {
        self.mask(self.simd.less_than_or_equal_f64s(self.values, other.values))
    }
}

impl<S: Simd> Mask<S> {
    #[inline(always)]
    pub(crate) fn select(self, yes: Pack<S>, no: Pack<S>) -> Pack<S> {
        yes.with(self.simd.select_f64s(self.values, yes.values, no.values))
    }

    #[inline(always)]
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            values: self.simd.and_m64s(self.values, other.values),
            ..self
        }
    }

    #[inline(always)]
    pub(crate) fn or(self, other: Self) -> Self {
        Self {
            values: self.simd.or_m64s(self.values, other.values),
            ..self
        }
    }

    #[inline(always)]
    pub(crate) fn not(self) -> Self {
        Self {
            values: self.simd.not_m64s(self.values),
            ..self
        }
    }

    #[inline(always)]
    pub(crate) fn any(self) -> bool {
        // The mask of a single lane is a byte whose leading bits are counted.
        let none = if S::IS_SCALAR { 8 } else { S::F64_LANES };
        self.simd.first_true_m64s(self.values) < none
    }
}

macro_rules! operation {
    ($operation:ident, $method:ident, $of_lanes:ident) => {
        impl<S: Simd> $operation for Pack<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.with(self.simd.$of_lanes(self.values, other.values))
            }
        }
    };
}

operation!(Add, add, add_f64s);
operation!(Sub, sub, sub_f64s);
operation!(Mul, mul, mul_f64s);
operation!(Div, div, div_f64s);

impl<S: Simd> Neg for Pack<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.with(self.simd.neg_f64s(self.values))
    }
}
