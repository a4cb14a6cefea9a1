//! Numbers that are loaded and stored one by one, or as many as a vector holds.

use crate::real::{LANES, Lanes, Real};

/// A number of each of some particles that follow each other.
pub(super) trait Chunk: Real {
    /// How many particles.
    const WIDTH: usize;

    /// Those from a place on.
    fn load(from: &[f64], place: usize) -> Self;

    /// The first of them, as many as there is room for.
    fn store(self, to: &mut [f64]);
}

impl Chunk for f64 {
    const WIDTH: usize = 1;

    #[inline(always)]
    fn load(from: &[f64], place: usize) -> Self {
        from[place]
    }

    #[inline(always)]
    fn store(self, to: &mut [f64]) {
        to[0] = self;
    }
}

impl Chunk for Lanes {
    const WIDTH: usize = LANES;

    #[inline(always)]
    fn load(from: &[f64], place: usize) -> Self {
        let mut lanes = [0.0; LANES];
        lanes.copy_from_slice(&from[place..place + LANES]);
        Self(lanes)
    }

    #[inline(always)]
    fn store(self, to: &mut [f64]) {
        match to.len() >= LANES {
            true => to[..LANES].copy_from_slice(&self.0),
            false => to.copy_from_slice(&self.0[..to.len()]),
        }
    }
}
