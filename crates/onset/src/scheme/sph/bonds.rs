//! Deformation gradients of total-Lagrangian SPH from the bonds of a particle, after Wiragunarsa and others (2024).

use super::super::lagrangian::{LagrangianPoint, add_gradients_of_bond};
use super::super::layout::{Layout, Weighed};
use super::neighborhood::Neighborhood;
use crate::lattice::{Crystal, Particle};
use nalgebra::SVector;
use std::collections::BTreeMap;

/// Deformation gradient of a particle of total-Lagrangian SPH.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum ParticleGradient {
    /// The gradient `F_I` by the kernel.
    Kernel,
    /// Mean `sum_J V_J W_IJ F_IJ / sum_J V_J W_IJ` of the deformation gradients of bonds, including the bond of the particle with itself, `F_II = F_I`.
    ///
    /// The gradient of a bond with `X = X_J - X_I` and `x = x_J - x_I` is the mean `F = (F_I + F_J) / 2` made exact along the bond, `F_IJ = F + (x - F X) (x) X / |X|^2`.
    /// With corrected `F_I` it is exact for linear fields, and so is every mean with weights that add up to one: the weights need no correction at
    /// faces. The energy is `sum_I V_I W` of the mean, and the forces are its negative derivatives.
    ///
    /// Source: the idea of Wiragunarsa, Zuhal, Dirgantara, Putra and Febrianto, arXiv 2407.04021, from its abstract; the equations are derived here.
    Bonds,
}

/// Replaces the gradients of the particles of a cell by the means over their bonds.
///
/// The neighborhoods grow by the neighbors of neighbors, which come last and have no weight.
pub(super) fn smoothed<const D: usize>(
    crystal: &Crystal<D>,
    layout: &Layout<D>,
    neighborhoods: Vec<Neighborhood<D>>,
    points: Vec<LagrangianPoint<D>>,
) -> (Vec<Neighborhood<D>>, Vec<LagrangianPoint<D>>) {
    let mean = |(site, mut neighborhood): (usize, Neighborhood<D>)| {
        let Neighborhood {
            particles,
            vectors,
            weights,
        } = &mut neighborhood;
        let (home, own) = (particles[0], &points[site]);
        let volume = |particle: &Particle<D>| crystal.volumes()[particle.site];
        let shares = particles.iter().zip(weights.iter());
        let shares: Vec<f64> = shares.map(|(p, weight)| volume(p) * weight.value).collect();
        let total: f64 = shares.iter().sum();
        let with_itself = own.gradients().iter().map(|b| b * (shares[0] / total));
        let with_itself = own.particles().iter().copied().zip(with_itself);
        let mut seen: BTreeMap<Particle<D>, SVector<f64, D>> = with_itself.collect();
        let bonds = particles.iter().zip(vectors.iter()).zip(&shares).skip(1);
        for ((end, vector), share) in bonds.filter(|bond| *bond.1 > 0.0) {
            let ends = [(&home, own), (end, &points[end.site])];
            add_gradients_of_bond(ends, &SVector::from(*vector), share / total, &mut seen);
        }
        let near = particles
            .iter()
            .map(|particle| (*particle, seen.remove(particle)));
        let near = near.map(|(particle, own)| (particle, own.unwrap_or_else(SVector::zeros)));
        let gradients: Vec<_> = near.collect();
        let place = &crystal.sites()[site];
        for particle in seen.keys() {
            particles.push(*particle);
            vectors.push(layout.vector(crystal, place, particle));
            weights.push(Weighed {
                value: 0.0,
                gradient: [0.0; D],
            });
        }
        let point = LagrangianPoint::new(gradients.into_iter().chain(seen), own.volume());
        (neighborhood, point)
    };
    neighborhoods.into_iter().enumerate().map(mean).unzip()
}
