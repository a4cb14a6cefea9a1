//! Neighbors of the particles of a cell in a homogeneous state.

use super::super::layout::{Layout, Weighed};
use super::super::response::{determinant, inverse};
use crate::algebra::{Each, array_of};
use crate::approximation::{MAXIMUM_CONDITION, SingularMoment};
use crate::lattice::{Crystal, Particle};
use crate::method::MethodError;

/// Particle with its neighbors.
#[derive(Clone, Debug)]
pub(super) struct Neighborhood<const D: usize> {
    /// The particle itself, then its neighbors, nearest first.
    pub(super) particles: Vec<Particle<D>>,
    /// Vectors `x_J - x_I` to the particles; length.
    pub(super) vectors: Vec<[f64; D]>,
    /// Weight `W_IJ` with its gradient along `x_J - x_I`, which is the negative of the gradient with respect to `x_I`.
    pub(super) weights: Vec<Weighed<f64, D>>,
}

/// Neighborhoods of the particles of a cell; weights have unit integral.
pub(super) fn neighborhoods<const D: usize>(
    crystal: &Crystal<D>,
    layout: &Layout<D>,
) -> Result<Vec<Neighborhood<D>>, MethodError> {
    let weight = layout.weight().normalized();
    let of_site = |place| {
        let particles = layout.neighbors(crystal, place, "particle", D + 1)?;
        let vectors: Vec<[f64; D]> = particles
            .iter()
            .map(|particle| layout.vector(crystal, place, particle))
            .collect();
        Ok(Neighborhood {
            weights: vectors.iter().map(|x| weight.at(x)).collect(),
            particles,
            vectors,
        })
    };
    crystal.sites().iter().map(of_site).collect()
}

/// Mean number of particles in a neighborhood.
pub(super) fn mean_size<const D: usize>(neighborhoods: &[Neighborhood<D>]) -> f64 {
    let total: usize = neighborhoods.iter().map(|n| n.particles.len()).sum();
    total as f64 / neighborhoods.len() as f64
}

impl<const D: usize> Neighborhood<D> {
    /// Neighbors with a weight, with their vectors and weights.
    pub(super) fn bonds(
        &self,
    ) -> impl Iterator<Item = (&Particle<D>, &[f64; D], &Weighed<f64, D>)> {
        let others = self.particles.iter().zip(&self.vectors);
        let others = others.zip(&self.weights).skip(1);
        let others = others.filter(|(_, weight)| weight.value > 0.0);
        others.map(|((particle, vector), weight)| (particle, vector, weight))
    }

    /// Pairs of the particle with its neighbors, with their weights.
    pub(super) fn pairs(&self) -> impl Iterator<Item = ([Particle<D>; 2], f64)> {
        let home = self.particles[0];
        self.bonds()
            .map(move |(other, _, weight)| ([home, *other], weight.value))
    }

    /// Density `sum_J m_J W_IJ`, including the particle itself, from the masses of the sites.
    pub(super) fn summed_density(&self, masses: &[f64]) -> f64 {
        let pairs = self.particles.iter().zip(&self.weights);
        pairs
            .map(|(particle, weight)| masses[particle.site] * weight.value)
            .sum()
    }

    /// Gradients `g_J` of the discrete displacement gradient `sum_J u_J (x) g_J`, the particle itself included, from the volumes of the sites.
    ///
    /// `g_J = V_J K^-T grad W_IJ`, `g_I = -sum_J g_J`, with `K = sum_J V_J (x_J - x_I) (x) grad W_IJ` if gradients are corrected to be exact for
    /// linear fields, and `K = 1` if not.
    pub(super) fn gradients(
        &self,
        volumes: &[f64],
        is_corrected: bool,
    ) -> Result<Vec<[f64; D]>, MethodError> {
        let pairs = self.particles.iter().zip(&self.weights);
        let mut gradients: Vec<[f64; D]> = pairs
            .map(|(particle, weight)| {
                weight
                    .gradient
                    .each(|slope| -slope * volumes[particle.site])
            })
            .collect();
        if is_corrected {
            let inverse = self.correction(&gradients)?;
            for g in &mut gradients {
                let plain = *g;
                *g = array_of(|i| (0..D).map(|j| inverse[j][i] * plain[j]).sum());
            }
        }
        gradients[0] = [0.0; D];
        gradients[0] = array_of(|i| -gradients.iter().map(|g| g[i]).sum::<f64>());
        Ok(gradients)
    }

    /// Correction matrix `K^-1` of the gradients.
    fn correction(&self, gradients: &[[f64; D]]) -> Result<[[f64; D]; D], MethodError> {
        let mut matrix = [[0.0; D]; D];
        for (x, g) in self.vectors.iter().zip(gradients) {
            for i in 0..D {
                for j in 0..D {
                    matrix[i][j] += x[i] * g[j];
                }
            }
        }
        correction(&matrix).map_err(|condition| MethodError::SingularMoment {
            point: "particle",
            neighbors: self.particles.len(),
            source: SingularMoment { condition },
        })
    }
}

/// Matrix `K^-1` that corrects gradients, for `K = sum_J X_IJ (x) a_IJ`.
///
/// # Errors
/// The condition number of `K`, possibly NaN, if rounding errors would dominate the gradients.
pub(crate) fn correction<const D: usize>(moment: &[[f64; D]; D]) -> Result<[[f64; D]; D], f64> {
    let largest = |m: &[[f64; D]; D]| {
        m.iter()
            .flatten()
            .fold(0.0, |most: f64, x| most.max(x.abs()))
    };
    let inverse = inverse(moment);
    let condition = largest(&inverse) * largest(moment);
    let is_regular = determinant(moment) != 0.0 && condition < MAXIMUM_CONDITION;
    match is_regular {
        true => Ok(inverse),
        false => Err(condition),
    }
}
