//! Random numbers that are the same in every run.

use nalgebra::{Matrix3, Rotation3, Vector3};

/// Numbers distributed evenly over `(-1, 1)`: a linear congruential generator (Knuth's constants).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        let mut random = Self(seed);
        // Similar seeds have similar first numbers, which are skipped.
        (0..8).for_each(|_| _ = random.number());
        random
    }

    pub fn number(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Rotation about a random axis.
    pub fn rotation(&mut self) -> Matrix3<f64> {
        let axis = Vector3::from_fn(|_, _| self.number());
        *Rotation3::new(axis * 3.0).matrix()
    }
}
