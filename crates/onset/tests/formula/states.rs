//! Random states, reproducible in every run.

pub use crate::random::Random;
use nalgebra::{Matrix3, Vector3};
use onset::kinematics::DeformationGradient;

impl Random {
    /// Full, strongly deformed state, rotated on both sides.
    pub fn state(&mut self) -> DeformationGradient {
        let stretches = Vector3::from_fn(|_, _| 1.6_f64.powf(self.number()));
        of(&(self.rotation() * Matrix3::from_diagonal(&stretches) * self.rotation()))
    }
}

/// State with a matrix of components.
pub fn of(f: &Matrix3<f64>) -> DeformationGradient {
    DeformationGradient::new(std::array::from_fn(|i| std::array::from_fn(|j| f[(i, j)])))
        .expect("an admissible state")
}
