//! XSPH: particles that move with a smoothed velocity.

use crate::bloch::{BlochBlocks, BlochSum};
use crate::lattice::{Crystal, Particle};
use nalgebra::SMatrix;

/// `T` in `du/dt = T v`: `du_I/dt = v_I + epsilon sum_J m_J / rho_IJ (v_J - v_I) W_IJ` with the mean density of the two; densities
/// and weights are those of the homogeneous state. Each pair is given from both of its ends.
///
/// What follows the displacements, the deformation that the particles carry included, follows the smoothed velocity.
///
/// Source: Monaghan, J. Comput. Phys. 82 (1989) 1.
pub(in super::super) fn smoothed_velocities<const D: usize>(
    crystal: &Crystal<D>,
    epsilon: f64,
    masses: &[f64],
    densities: &[f64],
    pairs: impl Iterator<Item = ([Particle<D>; 2], f64)>,
) -> BlochSum<D> {
    let one = SMatrix::<f64, D, D>::identity();
    let mut blocks = BlochBlocks::new();
    for site in 0..crystal.sites().len() {
        blocks.add(&Particle::home(site), &Particle::home(site), &one);
    }
    for ([own, other], weight) in pairs {
        let density = 0.5 * (densities[own.site] + densities[other.site]);
        let share = one * (epsilon * masses[other.site] / density * weight);
        blocks.add(&own, &other, &share);
        blocks.add(&own, &own, &-share);
    }
    blocks.sum(crystal)
}
