//! Family of a particle: all particles within its horizon.

use super::{Influence, PartialVolumes};
use crate::lattice::{Crystal, Particle};
use crate::method::{MAXIMUM_NEIGHBORS, MethodError};
use nalgebra::{DMatrix, SMatrix, SVector};

/// Largest ratio of the eigenvalues of the shape tensor that counts as singular.
const SINGULAR: f64 = 1e-12;
/// Relative rounding error of a distance that equals the horizon.
const RIM: f64 = 1e-9;

#[derive(Clone, Debug)]
pub(super) struct Neighbor<const D: usize> {
    pub(super) particle: Particle<D>,
    /// Reference bond `X_IJ`; length.
    pub(super) vector: SVector<f64, D>,
    /// Influence `w`. For some functions it is zero at the rim, where forces that are not weighted remain.
    pub(super) influence: f64,
    /// Part of the particle's volume that belongs to the family; length^D.
    pub(super) volume: f64,
    /// Fraction of the particle's volume that belongs to the family.
    pub(super) fraction: f64,
}

/// Family of a particle of the cell at the origin.
#[derive(Clone, Debug)]
pub(super) struct Family<const D: usize> {
    /// Particle of the family, followed by its neighbors.
    pub(super) particles: Vec<Particle<D>>,
    pub(super) volume: f64,
    pub(super) neighbors: Vec<Neighbor<D>>,
    /// Shape tensor of the family, `K = sum w X (x) X V`.
    pub(super) shape: SMatrix<f64, D, D>,
    pub(super) inverse_shape: SMatrix<f64, D, D>,
}

/// Bond of a pair, counted once.
pub(super) struct ReferenceBond<const D: usize> {
    pub(super) particles: [Particle<D>; 2],
    pub(super) vector: SVector<f64, D>,
    /// Weight `w V_I V_J`, times the fraction of the volume at the horizon.
    pub(super) weight: f64,
}

impl<const D: usize> Family<D> {
    pub(super) fn new(
        crystal: &Crystal<D>,
        site: usize,
        horizon: f64,
        influence: Influence,
        partial: PartialVolumes,
    ) -> Result<Self, MethodError> {
        let size = |site: usize| crystal.volumes()[site].powf(1.0 / D as f64);
        let largest = (0..crystal.sites().len()).map(size).fold(0.0, f64::max);
        let radius = match partial {
            PartialVolumes::Tapered => horizon + 0.5 * largest,
            PartialVolumes::Whole | PartialVolumes::Inside => horizon * (1.0 + RIM),
        };
        let unit_ball = [2.0, std::f64::consts::PI, 4.0 / 3.0 * std::f64::consts::PI][D - 1];
        let density = crystal.sites().len() as f64 / crystal.lattice().cell_volume();
        let expected = unit_ball * radius.powi(D as i32) * density;
        let is_small = expected <= MAXIMUM_NEIGHBORS as f64;
        if !is_small {
            return Err(MethodError::HorizonTooLarge {
                horizon,
                bonds: expected.min(f64::MAX),
                limit: MAXIMUM_NEIGHBORS,
            });
        }
        let home = Particle::home(site);
        let origin = crystal.position(&home);
        let near = crystal.within(&crystal.sites()[site], radius, &SMatrix::identity());
        let neighbors: Vec<Neighbor<D>> = near
            .into_iter()
            .filter(|particle| *particle != home)
            .filter_map(|particle| {
                let vector = crystal.position(&particle) - origin;
                // The mean size makes the bond the same from both of its ends.
                let h = 0.5 * (size(site) + size(particle.site));
                let fraction = fraction(partial, horizon, vector.norm(), h);
                (fraction > 0.0).then(|| Neighbor {
                    particle,
                    vector,
                    influence: influence.weight(vector.norm() / horizon),
                    volume: fraction * crystal.volumes()[particle.site],
                    fraction,
                })
            })
            .collect();
        Self::of_neighbors(home, crystal.volumes()[site], neighbors, horizon)
    }

    fn of_neighbors(
        home: Particle<D>,
        volume: f64,
        neighbors: Vec<Neighbor<D>>,
        horizon: f64,
    ) -> Result<Self, MethodError> {
        let shape: SMatrix<f64, D, D> = neighbors
            .iter()
            .map(|n| n.vector * n.vector.transpose() * (n.influence * n.volume))
            .sum();
        let too_small = MethodError::HorizonTooSmall {
            horizon,
            // Neighbors with zero influence do not contribute to the shape tensor.
            bonds: neighbors.iter().filter(|own| own.influence > 0.0).count(),
            dimension: D,
        };
        let inverse_shape = inverted(&shape).ok_or(too_small)?;
        let mut particles = vec![home];
        particles.extend(neighbors.iter().map(|neighbor| neighbor.particle));
        Ok(Self {
            particles,
            volume,
            neighbors,
            shape,
            inverse_shape,
        })
    }

    /// Returns the part of the family within the horizon of another point.
    ///
    /// # Errors
    /// [`MethodError::HorizonTooSmall`] if the shape tensor of the part is singular.
    pub(super) fn near(&self, place: &SVector<f64, D>, horizon: f64) -> Result<Self, MethodError> {
        let is_near = |n: &&Neighbor<D>| (n.vector - place).norm() <= horizon * (1.0 + RIM);
        let neighbors = self.neighbors.iter().filter(is_near).cloned().collect();
        Self::of_neighbors(self.particles[0], self.volume, neighbors, horizon)
    }

    /// Gradients `b_J = w V_J K^-1 X_IJ` of the nonlocal deformation gradient and the vectors `X_IJ`, in the order of the particles. The gradient of
    /// the particle itself is the negative sum of the others.
    pub(super) fn gradients(&self) -> (Vec<SVector<f64, D>>, Vec<SVector<f64, D>>) {
        let gradient = |n: &Neighbor<D>| self.inverse_shape * n.vector * (n.influence * n.volume);
        let vectors = self.neighbors.iter().map(|n| n.vector);
        (
            balanced(self.neighbors.iter().map(gradient)),
            std::iter::once(SVector::zeros()).chain(vectors).collect(),
        )
    }

    /// Volume of the neighbors.
    pub(super) fn volume_of_neighbors(&self) -> f64 {
        self.neighbors.iter().map(|n| n.volume).sum()
    }

    /// Number of particles within the horizon, excluding the particle at its center.
    pub(super) fn len(&self) -> usize {
        self.neighbors.len()
    }

    /// Sum `sum w r V`, the discrete form of the integral of `w r`.
    pub(super) fn mean_length(&self) -> f64 {
        let term = |n: &Neighbor<D>| n.influence * n.volume * n.vector.norm();
        self.neighbors.iter().map(term).sum()
    }

    /// Bonds of the particle, one of each pair of opposite bonds.
    pub(super) fn bonds<'a>(
        &'a self,
        crystal: &'a Crystal<D>,
        site: usize,
    ) -> impl Iterator<Item = ReferenceBond<D>> + 'a {
        let home = Particle::home(site);
        let is_first =
            move |n: &&Neighbor<D>| (n.particle.cell, n.particle.site) > (home.cell, home.site);
        self.neighbors.iter().filter(is_first).map(move |n| {
            let volumes = self.volume * crystal.volumes()[n.particle.site];
            ReferenceBond {
                particles: [home, n.particle],
                vector: n.vector,
                weight: n.influence * n.fraction * volumes,
            }
        })
    }
}

/// Vectors of the particle itself and of its neighbors, which add up to zero.
pub(super) fn balanced<const D: usize>(
    others: impl Iterator<Item = SVector<f64, D>>,
) -> Vec<SVector<f64, D>> {
    let others: Vec<_> = others.collect();
    let own = -others.iter().sum::<SVector<f64, D>>();
    std::iter::once(own).chain(others).collect()
}

/// Fraction of a particle's volume that lies within the horizon, for a particle of size `h` at the distance `r`.
fn fraction(partial: PartialVolumes, horizon: f64, r: f64, h: f64) -> f64 {
    match partial {
        PartialVolumes::Whole => 1.0,
        PartialVolumes::Inside | PartialVolumes::Tapered => {
            (0.5 + (horizon - r) / h).clamp(0.0, 1.0)
        }
    }
}

/// Inverse of a shape tensor; `None` if it is singular.
fn inverted<const D: usize>(shape: &SMatrix<f64, D, D>) -> Option<SMatrix<f64, D, D>> {
    let dynamic = DMatrix::from_fn(D, D, |i, j| shape[(i, j)]);
    let values = dynamic.clone().symmetric_eigenvalues();
    let is_regular = values.min() > SINGULAR * values.max();
    let inverse = is_regular.then(|| dynamic.try_inverse()).flatten()?;
    Some(SMatrix::from_fn(|i, j| inverse[(i, j)]))
}
