//! XSPH: particles move with a smoothed velocity.

use crate::bloch::{BlochBlocks, BlochSum};
use crate::lattice::{Crystal, Particle};
use crate::real::Real;
use nalgebra::SMatrix;

/// Quantities that follow the smoothed velocity.
///
/// The velocity itself obeys the forces in both cases. With the smoothing operator `T`, positions move by `T w` if velocities alone would move them
/// by `w`. The deformation and the density of a particle follow `T w` for `Everything` and `w` for `Positions`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum SmoothedMotion {
    /// Positions, deformations and densities.
    Everything,
    /// Positions alone, as in codes that integrate stress and density with the unsmoothed velocity. Without stress, shifted kernel positions cause no
    /// force, and smoothing changes no wave.
    ///
    /// Source: Monaghan, Annu. Rev. Astron. Astrophys. 30 (1992) 543; PySPH, `XSPHCorrection`, `SolidMechStep`.
    Positions,
}

/// Weight of the velocity of a neighbor, `epsilon m_J / rho_IJ W_IJ`, with the mean density of the two particles.
pub(in super::super) fn smoothing_share<R: Real>(
    epsilon: f64,
    mass: R,
    densities: [R; 2],
    weight: R,
) -> R {
    mass * epsilon / ((densities[0] + densities[1]) * 0.5) * weight
}

/// Smoothing operator `T` in `du/dt = T v`: `du_I/dt = v_I + epsilon sum_J m_J / rho_IJ (v_J - v_I) W_IJ` with the mean density of the two particles.
///
/// Densities and weights refer to the homogeneous state. Each pair is given from both of its ends.
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
        let between = [densities[own.site], densities[other.site]];
        let share = one * smoothing_share(epsilon, masses[other.site], between, weight);
        blocks.add(&own, &other, &share);
        blocks.add(&own, &own, &-share);
    }
    blocks.sum(crystal)
}
