//! Numbers that are loaded and stored one by one, or as many as a vector of the machine holds.
//!
//! Sums are not fused with products, so that the same bits come out of vectors of any width.

use pulp::Simd;

/// A number of each of some particles that follow each other, and what is done with them.
pub(super) trait Vectors: Copy {
    /// The numbers.
    type Numbers: Copy;
    /// How many particles.
    const WIDTH: usize;

    /// The same for all.
    fn splat(self, value: f64) -> Self::Numbers;
    /// Those from a place on.
    fn load(self, from: &[f64], place: usize) -> Self::Numbers;
    /// The first of them, as many as there is room for.
    fn store(self, numbers: Self::Numbers, to: &mut [f64]);
    /// `a + b`.
    fn add(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// `a - b`.
    fn sub(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// `a b`.
    fn mul(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// `a / b`.
    fn div(self, a: Self::Numbers, b: Self::Numbers) -> Self::Numbers;
    /// The square root.
    fn sqrt(self, a: Self::Numbers) -> Self::Numbers;
}

/// One particle.
#[derive(Clone, Copy)]
pub(super) struct Single;

impl Vectors for Single {
    type Numbers = f64;
    const WIDTH: usize = 1;

    #[inline(always)]
    fn splat(self, value: f64) -> f64 {
        value
    }
    #[inline(always)]
    fn load(self, from: &[f64], place: usize) -> f64 {
        from[place]
    }
    #[inline(always)]
    fn store(self, number: f64, to: &mut [f64]) {
        to[0] = number;
    }
    #[inline(always)]
    fn add(self, a: f64, b: f64) -> f64 {
        a + b
    }
    #[inline(always)]
    fn sub(self, a: f64, b: f64) -> f64 {
        a - b
    }
    #[inline(always)]
    fn mul(self, a: f64, b: f64) -> f64 {
        a * b
    }
    #[inline(always)]
    fn div(self, a: f64, b: f64) -> f64 {
        a / b
    }
    #[inline(always)]
    fn sqrt(self, a: f64) -> f64 {
        a.sqrt()
    }
}

/// As many particles as a vector of the machine holds.
#[derive(Clone, Copy)]
pub(super) struct Wide<S>(pub(super) S);

impl<S: Simd> Vectors for Wide<S> {
    type Numbers = S::f64s;
    const WIDTH: usize = S::F64_LANES;

    #[inline(always)]
    fn splat(self, value: f64) -> S::f64s {
        self.0.splat_f64s(value)
    }
    #[inline(always)]
    fn load(self, from: &[f64], place: usize) -> S::f64s {
        S::as_simd_f64s(&from[place..place + S::F64_LANES]).0[0]
    }
    #[inline(always)]
    fn store(self, numbers: S::f64s, to: &mut [f64]) {
        match to.len() >= S::F64_LANES {
            true => S::as_mut_simd_f64s(to).0[0] = numbers,
            false => self.0.partial_store_f64s(to, numbers),
        }
    }
    #[inline(always)]
    fn add(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.add_f64s(a, b)
    }
    #[inline(always)]
    fn sub(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.sub_f64s(a, b)
    }
    #[inline(always)]
    fn mul(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.mul_f64s(a, b)
    }
    #[inline(always)]
    fn div(self, a: S::f64s, b: S::f64s) -> S::f64s {
        self.0.div_f64s(a, b)
    }
    #[inline(always)]
    fn sqrt(self, a: S::f64s) -> S::f64s {
        self.0.sqrt_f64s(a)
    }
}
