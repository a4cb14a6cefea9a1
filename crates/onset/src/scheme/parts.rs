//! Bounds for finite bodies from their parts.
//!
//! A finite body is a sum of parts, elements or material points, each with its stiffness and its share of the masses: `K = sum K_e`, `M = sum M_e`. So
//! `u.K u / u.M u` is at most the largest of `u.K_e u / u.M_e u`, and no eigenvalue of `M^-1 K` has a larger real part than the largest
//! eigenvalue of `M_e^-1 (K_e + K_e^T)/2`, whatever the body is made of and wherever it is held. A body of one part attains it.

use super::Interaction;
use super::linearized::derivatives;
use crate::lattice::Particle;
use nalgebra::{DMatrix, SymmetricEigen};

/// What holds for every finite body of a discretization at a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FiniteBodies {
    /// The largest eigenvalues of stiffness and damping over mass of single parts bound those of any body of them; 1/time^2, 1/time.
    Parts {
        /// `omega^2`.
        squared: f64,
        /// Damping rate.
        damping: f64,
    },
    /// A body is the infinite lattice without some positive semidefinite interactions, so that no body is faster.
    Lattice,
}

/// Element or material point with its masses.
pub(super) struct Part<const D: usize> {
    particles: Vec<Particle<D>>,
    /// `M_ab`, the same in all directions; mass.
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

    /// Adds an interaction of particles of the part.
    pub(super) fn add<I: Interaction<D>>(&mut self, interaction: &I) {
        let own = interaction.particles().iter();
        let places: Vec<Option<usize>> = own
            .map(|particle| self.particles.iter().position(|own| own == particle))
            .collect();
        for (is_viscous, matrix) in [(false, &mut self.stiffness), (true, &mut self.damping)] {
            if is_viscous && !interaction.is_viscous() {
                continue;
            }
            derivatives(interaction, is_viscous, &mut |from, to, block| {
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

    /// The smallest and the largest eigenvalue of the symmetric part of the stiffness; force/length.
    pub(super) fn stiffnesses(&self) -> [f64; 2] {
        let values = symmetric(&self.stiffness).symmetric_eigenvalues();
        [values.min(), values.max()]
    }

    /// The largest eigenvalues of stiffness and damping over mass; `None` where a particle without mass is moved, or a number is not finite.
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
            // Particles without mass must not be moved.
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

    /// The bound of all bodies of some parts.
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
