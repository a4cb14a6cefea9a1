//! Forces on a periodic patch of particles.

use super::{Interaction, Motion};
use crate::lattice::{Crystal, Particle, cells_between};
use nalgebra::SVector;

/// A periodic patch of `cells` cells along each primitive vector. Its particles are numbered cell by cell, the first
/// coordinate running fastest, in each cell in the order of the sites.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PeriodicPatch<const D: usize> {
    cells: [usize; D],
    sites: usize,
}

impl<const D: usize> PeriodicPatch<D> {
    /// A patch of a crystal; at least one cell along each vector.
    pub fn new(crystal: &Crystal<D>, cells: [usize; D]) -> Self {
        Self {
            cells: cells.map(|n| n.max(1)),
            sites: crystal.sites().len(),
        }
    }

    /// The numbers of cells along the primitive vectors.
    pub fn cells(&self) -> [usize; D] {
        self.cells
    }

    /// The number of particles.
    pub fn len(&self) -> usize {
        self.sites * self.cells.iter().product::<usize>()
    }

    /// Whether there is no particle: never.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The particles, in the order of their numbers.
    pub fn particles(&self) -> Vec<Particle<D>> {
        let high = self.cells.map(|n| n as i32 - 1);
        let cells = cells_between(&[0; D], &high).into_iter();
        let of_cell = |cell| (0..self.sites).map(move |site| Particle { site, cell });
        cells.flat_map(of_cell).collect()
    }

    /// The number of a particle, or of the one of which it is an image.
    pub fn number(&self, particle: &Particle<D>) -> usize {
        let folded = |i: usize| particle.cell[i].rem_euclid(self.cells[i] as i32) as usize;
        let cell = (0..D)
            .rev()
            .fold(0, |sum, i| sum * self.cells[i] + folded(i));
        cell * self.sites + particle.site
    }

    /// The origins of the cells.
    pub(crate) fn origins(&self) -> Vec<[i32; D]> {
        let high = self.cells.map(|n| n as i32 - 1);
        cells_between(&[0; D], &high)
    }
}

/// The forces on the particles of a patch that are displaced and move, from the interactions of one cell.
pub fn patch_forces<'i, I: Interaction<D> + 'i, const D: usize>(
    patch: &PeriodicPatch<D>,
    interactions: impl IntoIterator<Item = &'i I>,
    displacements: &[SVector<f64, D>],
    velocities: &[SVector<f64, D>],
) -> Vec<SVector<f64, D>> {
    let mut forces = vec![SVector::zeros(); patch.len()];
    let origins = patch.origins();
    for interaction in interactions {
        for origin in &origins {
            let numbers: Vec<usize> = interaction
                .particles()
                .iter()
                .map(|particle| patch.number(&particle.moved(origin)))
                .collect();
            let gathered = |values: &[SVector<f64, D>]| -> Vec<[f64; D]> {
                numbers.iter().map(|n| values[*n].into()).collect()
            };
            let motion = Motion {
                displacements: &gathered(displacements),
                velocities: &gathered(velocities),
            };
            for (number, force) in numbers.iter().zip(interaction.forces(motion)) {
                forces[*number] += SVector::from(force);
            }
        }
    }
    forces
}
