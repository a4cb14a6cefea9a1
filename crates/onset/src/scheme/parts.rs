//! Bounds for finite bodies from their parts, which are elements or material points.
//!
//! A finite body is a sum of parts, each with its stiffness and its share of the masses: `K = sum K_e`, `M = sum M_e`. Therefore `u.K u / u.M u` is
//! at most the largest of `u.K_e u / u.M_e u`, and no eigenvalue of `M^-1 K` has a larger real part than the largest eigenvalue of `M_e^-1 (K_e +
//! K_e^T)/2`, for any composition of the body and any supports. A body of a single part attains the bound.

use super::Interaction;
use super::linearized::derivatives;
use crate::lattice::Particle;
use nalgebra::{DMatrix, SymmetricEigen};

/// Bound that holds for every finite body of a discretization in a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FiniteBodies {
    /// Largest eigenvalues of stiffness and damping over mass of a single part, which bound the eigenvalues of any body; 1/time^2, 1/time.
    Parts {
        /// Bound of `omega^2` from the stiffness.
        squared: f64,
        /// Bound of the damping rate.
        damping: f64,
    },
    /// The body is the infinite lattice without some positive semidefinite interactions, so that its frequencies do not exceed the frequencies of the
    /// lattice.
    Lattice,
}

/// Element or material point with its masses.
pub(super) struct Part<const D: usize> {
    particles: Vec<Particle<D>>,
    /// Mass matrix `M_ab`, the same in all directions; mass.
    mass: DMatrix<f64>,
    stiffness: DMatrix<f64>,
    damping: DMatrix<f64>,
}

impl<const D: usize> Part<D> {
    pub(super) fn new(particles: &[Particle<D>], mass: DMatrix<f64>) -> Self {
        let unknowns = D * particles.len();
        Self {
            particles: particles.to_vec(),
            mass,
            stiffness: DMatrix::zeros(unknowns, unknowns),
            damping: DMatrix::zeros(unknowns, unknowns),
        }
    }

    /// Adds an interaction between particles of the part.
    pub(super) fn add<I: Interaction<D>>(&mut self, interaction: &I) {
        let own = interaction.particles().iter();
        let places: Vec<Option<usize>> = own
            .map(|particle| self.particles.iter().position(|own| own == particle))
            .collect();
        for (is_viscous, matrix) in [(false, &mut self.stiffness), (true, &mut self.damping)] {
            if is_viscous && !interaction.is_viscous() {
                continue;
            }
            let at_rest = vec![[0.0; D]; places.len()];
            derivatives(interaction, &at_rest, is_viscous, &mut |from, to, block| {
                let (Some(from), Some(to)) = (places[from], places[to]) else {
                    return;
                };
                for i in 0..D {
                    for j in 0..D {
                        matrix[(D * from + i, D * to + j)] += block[(i, j)];
                    }
                }
            });
        }
    }

    /// Smallest and largest eigenvalue of the symmetric part of the stiffness; force/length.
    pub(super) fn stiffnesses(&self) -> [f64; 2] {
        let values = symmetric(&self.stiffness).symmetric_eigenvalues();
        [values.min(), values.max()]
    }

    /// Largest eigenvalues of stiffness and damping over mass. `None` if forces act on a particle without mass, or if a number is not finite.
    fn largest(&self) -> Option<[f64; 2]> {
        let has_mass = |a: &usize| self.mass[(*a, *a)] > 0.0;
        let massive: Vec<usize> = (0..self.particles.len()).filter(has_mass).collect();
        let unknown = |n: usize| D * massive[n / D] + n % D;
        let count = D * massive.len();
        let mass = DMatrix::from_fn(count, count, |i, j| match i % D == j % D {
            true => self.mass[(massive[i / D], massive[j / D])],
            false => 0.0,
        });
        let factor = mass.cholesky()?.l();
        let over_mass = |matrix: &DMatrix<f64>| {
            let own = DMatrix::from_fn(count, count, |i, j| matrix[(unknown(i), unknown(j))]);
            // Particles without mass must be free of forces.
            let left_out = matrix.norm_squared() - own.norm_squared();
            if left_out.is_nan() || left_out.abs() > 1e-12 * matrix.norm_squared() {
                return None;
            }
            let half = factor.solve_lower_triangular(&symmetric(&own))?;
            let whole = factor.solve_lower_triangular(&half.transpose())?;
            Some(SymmetricEigen::new(symmetric(&whole)).eigenvalues.max())
        };
        Some([over_mass(&self.stiffness)?, over_mass(&self.damping)?])
    }

    /// Bound for all bodies that consist of these parts.
    pub(super) fn bound(parts: impl IntoIterator<Item = Self>) -> Option<FiniteBodies> {
        let mut most = [0.0_f64; 2];
        for part in parts {
            let own = part.largest()?;
            most = [most[0].max(own[0]), most[1].max(own[1])];
        }
        let [squared, damping] = most;
        Some(FiniteBodies::Parts { squared, damping })
    }
}

fn symmetric(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    (matrix + matrix.transpose()) * 0.5
}
