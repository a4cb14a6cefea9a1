//! One step of the method on a periodic patch, as a simulation does it: particles to grid, forces, grid to particles.

use super::functions::Profile;
use super::point::State;
use crate::algebra::array_of;
use crate::lattice::{Crystal, Particle};
use crate::scheme::{NoForce, PatchForces, PeriodicPatch};
use nalgebra::{SMatrix, SVector};

/// A material point of a patch.
pub(super) struct Carried<const D: usize> {
    /// In lattice coordinates of the grid.
    pub(super) place: SVector<f64, D>,
    pub(super) volume: f64,
    pub(super) mass: f64,
}

/// A patch of grid with its material points.
pub(super) struct Step<'a, const D: usize> {
    pub(super) state: State<'a, D>,
    pub(super) profile: &'a Profile,
    pub(super) nodes: PeriodicPatch<D>,
    pub(super) points: Vec<Carried<D>>,
    /// Whether the unknowns are the points, not the nodes.
    moves_points: bool,
}

/// The nodes that a place sees: their numbers, functions and gradients.
type Seen<const D: usize> = Vec<(usize, f64, SVector<f64, D>)>;

impl<'a, const D: usize> Step<'a, D> {
    /// `grid` has one node a cell, the points are those of one cell.
    pub(super) fn new(
        state: State<'a, D>,
        profile: &'a Profile,
        grid: &Crystal<D>,
        cells: [usize; D],
        points: &[(SVector<f64, D>, f64)],
        density: f64,
        moves_points: bool,
    ) -> Self {
        let nodes = PeriodicPatch::new(grid, cells);
        let of_cell = |node: &Particle<D>| {
            let origin = SVector::from(node.cell.map(f64::from));
            let carried = points.iter().map(|(place, volume)| Carried {
                place: origin + place,
                volume: *volume,
                mass: density * volume,
            });
            carried.collect::<Vec<_>>()
        };
        Self {
            state,
            profile,
            points: nodes.particles().iter().flat_map(of_cell).collect(),
            nodes,
            moves_points,
        }
    }

    fn seen(&self, place: &SVector<f64, D>) -> Seen<D> {
        let at: [f64; D] = (*place).into();
        let node = |cell: [i32; D]| {
            let shape = self.profile.shape(&at, &cell);
            let number = self.nodes.number(&Particle { site: 0, cell });
            (
                number,
                shape.value,
                SVector::from(self.state.gradient(&shape.slope)),
            )
        };
        self.profile.nodes(&at).into_iter().map(node).collect()
    }

    /// The forces on the nodes after a step that displaces them, and what the points see at their new places.
    fn stepped(&self, displacements: &[SVector<f64, D>]) -> (Vec<SVector<f64, D>>, Vec<Seen<D>>) {
        let mut forces = vec![SVector::zeros(); self.nodes.len()];
        let mut seen = Vec::with_capacity(self.points.len());
        for point in &self.points {
            let (mut moved, mut l) = (SVector::zeros(), SMatrix::<f64, D, D>::zeros());
            for (number, value, gradient) in self.seen(&point.place) {
                moved += displacements[number] * value;
                l += displacements[number] * gradient.transpose();
            }
            let place = point.place + self.state.to_grid * moved;
            let l = array_of(|i| array_of(|j| l[(i, j)]));
            let stress = self.state.stress(&l);
            let stress = SMatrix::<f64, D, D>::from_fn(|i, j| stress[i][j]);
            let at_end = self.seen(&place);
            for (number, _, gradient) in &at_end {
                forces[*number] -= stress * gradient * point.volume;
            }
            seen.push(at_end);
        }
        (forces, seen)
    }

    /// The forces on particles, mass times the acceleration that they get from the grid, whose velocities would have
    /// displaced them: `m_p sum_i N_ip f_i / m_i`.
    fn particle_forces(&self, displacements: &[SVector<f64, D>]) -> Vec<SVector<f64, D>> {
        let before: Vec<Seen<D>> = self.points.iter().map(|p| self.seen(&p.place)).collect();
        let masses = self.nodal_masses(&before);
        let mut nodal = vec![SVector::zeros(); self.nodes.len()];
        for ((point, seen), displacement) in self.points.iter().zip(&before).zip(displacements) {
            for (number, value, _) in seen {
                nodal[*number] += displacement * (point.mass * value / masses[*number]);
            }
        }
        let (forces, after) = self.stepped(&nodal);
        let masses = self.nodal_masses(&after);
        let felt = |(point, seen): (&Carried<D>, &Seen<D>)| {
            let terms = seen.iter();
            let sum = terms.map(|(number, value, _)| forces[*number] * (value / masses[*number]));
            sum.sum::<SVector<f64, D>>() * point.mass
        };
        self.points.iter().zip(&after).map(felt).collect()
    }

    fn nodal_masses(&self, seen: &[Seen<D>]) -> Vec<f64> {
        let mut masses = vec![0.0; self.nodes.len()];
        for (point, seen) in self.points.iter().zip(seen) {
            for (number, value, _) in seen {
                masses[*number] += point.mass * value;
            }
        }
        masses
    }
}

impl<const D: usize> PatchForces<D> for Step<'_, D> {
    /// On nodes that are displaced, or on particles.
    fn at(
        &self,
        displacements: &[SVector<f64, D>],
        _: &[SVector<f64, D>],
    ) -> Result<Vec<SVector<f64, D>>, NoForce> {
        // A place that is no number is in no cell.
        let lost = |all: &[SVector<f64, D>]| {
            all.iter()
                .position(|own| own.iter().any(|component| !component.is_finite()))
        };
        let none = |particle| NoForce {
            particle,
            source: None,
        };
        if let Some(particle) = lost(displacements) {
            return Err(none(particle));
        }
        let forces = match self.moves_points {
            true => self.particle_forces(displacements),
            false => self.stepped(displacements).0,
        };
        match lost(&forces) {
            Some(particle) => Err(none(particle)),
            None => Ok(forces),
        }
    }
}
