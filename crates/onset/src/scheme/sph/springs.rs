//! Forces along pairs of particles that accumulate with their velocities (Zhang and others 2024).

use super::super::products::{displacement_gradient, times_vector};
use super::super::{Interaction, Motion};
use super::neighborhood::Neighborhood;
use crate::bloch::BlochBlocks;
use crate::lattice::Particle;
use crate::real::Real;
use nalgebra::SVector;

/// Forces along the pairs of a particle from accelerations that accumulate with the velocities, here of particles near a homogeneous state.
///
/// `da_I/dt = c G / rho_I sum_J V_J [(v_IJ - (L_I + L_J)/2 x_IJ) . e] e W'(r) / r`, with `v_IJ = v_I - v_J`, `x_IJ = x_I - x_J = r e` and the shear modulus
/// `G`. The penalty has `c = xi`. Shear forces between pairs have `c = 2 zeta`, and nothing is predicted, `L = 0`.
///
/// Nothing is accumulated in a homogeneous state, where pair terms cancel. The rotation of the accumulated acceleration with the spin and the motion
/// of `e`, `r` and volumes are thus of second order, and displacements replace velocities. Each end of a pair adds half of the force, computed with the `L`
/// of this end.
pub(super) struct PairSprings<const D: usize> {
    particles: Vec<Particle<D>>,
    /// Vectors `x_J - x_I` in the homogeneous state, starting with the particle itself; length.
    vectors: Vec<[f64; D]>,
    /// Stiffness `-c G V_I V_J W' / (2 r)` of each pair; force/length.
    stiffness: Vec<f64>,
    /// Gradients of the displacement gradient that predicts the motion of pairs, 1/length; empty if nothing is predicted.
    gradients: Vec<[f64; D]>,
}

impl<const D: usize> PairSprings<D> {
    /// Builds the forces from the factor `c G`, the current volumes of the sites, and the gradients of the prediction.
    pub(super) fn new(
        neighborhood: &Neighborhood<D>,
        factor: f64,
        volumes: &[f64],
        gradients: Vec<[f64; D]>,
    ) -> Self {
        let own = volumes[neighborhood.particles[0].site];
        let pairs = neighborhood.particles.iter().zip(&neighborhood.vectors);
        let pairs = pairs.zip(&neighborhood.weights).enumerate();
        let stiffness = pairs.map(|(number, ((other, x), weight))| match number {
            0 => 0.0,
            _ => {
                let slope: f64 = (0..D).map(|i| weight.gradient[i] * x[i]).sum();
                let squared: f64 = x.iter().map(|x| x * x).sum();
                -0.5 * factor * own * volumes[other.site] * slope / squared
            }
        });
        Self {
            stiffness: stiffness.collect(),
            particles: neighborhood.particles.clone(),
            vectors: neighborhood.vectors.clone(),
            gradients,
        }
    }
}

impl<const D: usize> Interaction<D> for PairSprings<D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.particles
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let u = motion.displacements;
        let change = displacement_gradient(u, &self.gradients);
        let mut forces = vec![[R::constant(0.0); D]; u.len()];
        for (j, x) in self.vectors.iter().enumerate().skip(1) {
            let predicted = times_vector(&change, &x.map(R::constant));
            let squared: f64 = x.iter().map(|x| x * x).sum();
            let along = (0..D).fold(R::constant(0.0), |sum, i| {
                sum + (u[j][i] - u[0][i] - predicted[i]) * (x[i] / squared)
            });
            for i in 0..D {
                let force = along * (x[i] * self.stiffness[j]);
                forces[0][i] = forces[0][i] + force;
                forces[j][i] = forces[j][i] - force;
            }
        }
        forces
    }

    fn add_stiffness(&self, blocks: &mut BlochBlocks<D>) {
        let mut sums = blocks.between(&self.particles);
        for (j, x) in self.vectors.iter().enumerate().skip(1) {
            let x = SVector::from(*x);
            let along = x * x.transpose() * (self.stiffness[j] / x.norm_squared());
            for k in 0..self.particles.len() {
                let predicted = self.gradients.get(k).map_or(0.0, |g| x.dot(&(*g).into()));
                let share = f64::from(u8::from(k == j)) - f64::from(u8::from(k == 0)) - predicted;
                if share != 0.0 {
                    sums.add(0, k, &(along * -share));
                    sums.add(j, k, &(along * share));
                }
            }
        }
        sums.finish();
    }
}
