//! Random states, the same in every run.

use nalgebra::{Matrix3, Rotation3, Vector3};
use onset::kinematics::DeformationGradient;

/// Numbers spread evenly over `(-1, 1)`: a linear congruential generator (Knuth's constants).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        let mut random = Self(seed);
        // The first numbers of near seeds are near.
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

    pub fn rotation(&mut self) -> Matrix3<f64> {
        *Rotation3::new(Vector3::from_fn(|_, _| self.number()) * 3.0).matrix()
    }

    /// A full, strongly deformed state, rotated on both sides.
    pub fn state(&mut self) -> DeformationGradient {
        let stretches = Vector3::from_fn(|_, _| 1.6_f64.powf(self.number()));
        of(&(self.rotation() * Matrix3::from_diagonal(&stretches) * self.rotation()))
    }
}

/// The state with a matrix of components.
pub fn of(f: &Matrix3<f64>) -> DeformationGradient {
    DeformationGradient::new(std::array::from_fn(|i| std::array::from_fn(|j| f[(i, j)])))
        .expect("an admissible state")
}
