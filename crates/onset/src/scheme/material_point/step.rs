//! One time step of the method on a periodic patch, as in a simulation: particles to grid, forces, grid to particles.

use super::functions::{MINIMUM_SECOND_MOMENT, Profile};
use super::point::State;
use super::{MaterialPoints, Transfer};
use crate::algebra::array_of;
use crate::lattice::Particle;
use crate::scheme::{NoForce, PatchForces, PatchTransfer, PeriodicPatch, PointsInMotion};
use nalgebra::{SMatrix, SVector};
use std::collections::BTreeMap;

/// Distance in cells at which a point counts as lost, because nodes are no longer distinct in floating point.
const LOST_DISTANCE: f64 = 1e9;

/// Material point of a patch.
pub(super) struct Carried<const D: usize> {
    /// Position in lattice coordinates of the grid.
    pub(super) place: SVector<f64, D>,
    pub(super) volume: f64,
    pub(super) mass: f64,
}

/// Periodic patch of the grid with its material points.
pub(super) struct Step<'a, const D: usize> {
    pub(super) state: State<'a, D>,
    pub(super) profile: &'a Profile,
    pub(super) nodes: PeriodicPatch<D>,
    pub(super) points: Vec<Carried<D>>,
    /// Whether the unknowns are the points instead of the nodes.
    moves_points: bool,
    /// Transfer of the time step; `None` if integrators step the equations.
    transfer: Option<Transfer>,
    /// Whether the points of a cell share the mean of their dilatations.
    shares_dilatation: bool,
}

/// Node whose function is nonzero at a position.
struct Sight<const D: usize> {
    number: usize,
    value: f64,
    /// Gradient of the function in the current configuration; 1/length.
    gradient: SVector<f64, D>,
    /// Derivatives of the function by lattice coordinates of the grid.
    slope: SVector<f64, D>,
    /// Vector from the position to the node, in lattice coordinates of the grid.
    apart: SVector<f64, D>,
}

/// Nodes whose functions are nonzero at a position.
type Seen<const D: usize> = Vec<Sight<D>>;

impl<'a, const D: usize> Step<'a, D> {
    /// Builds a patch of the given numbers of cells of the grid with their points.
    pub(super) fn new(
        state: State<'a, D>,
        method: &'a MaterialPoints<D>,
        cells: [usize; D],
    ) -> Self {
        let nodes = PeriodicPatch::new(&method.grid, cells);
        let of_cell = |node: &Particle<D>| {
            let origin = SVector::from(node.cell.map(f64::from));
            let carried = method.points.iter().map(|(place, volume)| Carried {
                place: origin + place,
                volume: *volume,
                mass: method.choices.density * volume,
            });
            carried.collect::<Vec<_>>()
        };
        Self {
            state,
            profile: &method.profile,
            points: nodes.particles().iter().flat_map(of_cell).collect(),
            nodes,
            moves_points: method.moves_points(),
            transfer: method.transfer_of_a_step().map(|(transfer, _)| transfer),
            shares_dilatation: method.shares_dilatation(),
        }
    }

    /// Nodes around a position, for a particle with the displacement gradient `L` since the homogeneous state.
    fn seen(&self, place: &SVector<f64, D>, l: &SMatrix<f64, D, D>) -> Seen<D> {
        let at: [f64; D] = (*place).into();
        let stretch = self.state.stretch(&rows(l));
        let node = |cell: [i32; D]| {
            let shape = self.profile.shape_of(&at, &cell, &stretch);
            Sight {
                number: self.nodes.number(&Particle { site: 0, cell }),
                value: shape.value,
                gradient: SVector::from(self.state.gradient(&shape.slope)),
                slope: shape.slope.into(),
                apart: SVector::from(cell.map(f64::from)) - place,
            }
        };
        let nodes = self.profile.nodes_around(&at, &stretch);
        nodes.into_iter().map(node).collect()
    }

    /// Second moments `D_p` along the axes of the grid, in units of the squared grid spacing.
    fn moments(&self, place: &SVector<f64, D>) -> SVector<f64, D> {
        place.map(|x| self.profile.second_moment(x))
    }

    /// Position of a point after a displacement, in lattice coordinates of the grid.
    fn moved(&self, point: &Carried<D>, displacement: &SVector<f64, D>) -> SVector<f64, D> {
        point.place + self.state.to_grid * displacement
    }

    /// Ratios of the mean dilatation of each point, as in [`State::stress`], for positions and displacement gradients from the homogeneous state; `None`
    /// if the points do not share a dilatation.
    fn ratios<'l>(
        &self,
        places: impl Iterator<Item = &'l SVector<f64, D>>,
        gradients: &[SMatrix<f64, D, D>],
    ) -> Option<Vec<f64>> {
        if !self.shares_dilatation {
            return None;
        }
        let mut cells: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (n, place) in places.enumerate() {
            let cell = array_of(|i| place[i].floor() as i32);
            let number = self.nodes.number(&Particle { site: 0, cell });
            cells.entry(number).or_default().push(n);
        }
        let mut ratios = vec![1.0; gradients.len()];
        for members in cells.values() {
            let own: Vec<_> = members
                .iter()
                .map(|n| (self.points[*n].volume, rows(&gradients[*n])))
                .collect();
            for (n, ratio) in members.iter().zip(self.state.ratios(&own)) {
                ratios[*n] = ratio;
            }
        }
        Some(ratios)
    }

    /// Stresses `J sigma` of the points at displacement gradients from the homogeneous state.
    fn stresses<'l>(
        &self,
        places: impl Iterator<Item = &'l SVector<f64, D>>,
        gradients: &[SMatrix<f64, D, D>],
    ) -> Vec<SMatrix<f64, D, D>> {
        let ratios = self.ratios(places, gradients);
        let stress = |(n, l): (usize, &SMatrix<f64, D, D>)| {
            let ratio = ratios.as_ref().map(|all| all[n]);
            let stress = self.state.stress(&rows(l), ratio);
            SMatrix::from_fn(|i, j| stress[i][j])
        };
        gradients.iter().enumerate().map(stress).collect()
    }

    /// Forces on the nodes after a step that displaces them, and the nodes around each point at its new position.
    fn stepped(&self, displacements: &[SVector<f64, D>]) -> (Vec<SVector<f64, D>>, Vec<Seen<D>>) {
        let mut forces = vec![SVector::zeros(); self.nodes.len()];
        let mut seen = Vec::with_capacity(self.points.len());
        let mut shifts = Vec::with_capacity(self.points.len());
        let mut gradients = Vec::with_capacity(self.points.len());
        for point in &self.points {
            let (mut moved, mut l) = (SVector::zeros(), SMatrix::<f64, D, D>::zeros());
            for node in self.seen(&point.place, &SMatrix::zeros()) {
                moved += displacements[node.number] * node.value;
                l += displacements[node.number] * node.gradient.transpose();
            }
            shifts.push(moved);
            gradients.push(l);
        }
        let stresses = self.stresses(self.points.iter().map(|point| &point.place), &gradients);
        for (n, point) in self.points.iter().enumerate() {
            let stress = stresses[n];
            let at_end = self.seen(&self.moved(point, &shifts[n]), &gradients[n]);
            for node in &at_end {
                forces[node.number] -= stress * node.gradient * point.volume;
            }
            seen.push(at_end);
        }
        (forces, seen)
    }

    /// Forces on particles: mass times acceleration from the grid, `m_p sum_i N_ip f_i / m_i`, where the velocities of the grid have caused the
    /// displacements.
    fn particle_forces(&self, displacements: &[SVector<f64, D>]) -> Vec<SVector<f64, D>> {
        let at_rest = |point: &Carried<D>| self.seen(&point.place, &SMatrix::zeros());
        let before: Vec<Seen<D>> = self.points.iter().map(at_rest).collect();
        let masses = self.nodal_masses(&before);
        let mut nodal = vec![SVector::zeros(); self.nodes.len()];
        for ((point, seen), displacement) in self.points.iter().zip(&before).zip(displacements) {
            for node in seen {
                let share = point.mass * node.value / masses[node.number];
                nodal[node.number] += displacement * share;
            }
        }
        let (forces, after) = self.stepped(&nodal);
        let masses = self.nodal_masses(&after);
        let felt = |(point, seen): (&Carried<D>, &Seen<D>)| {
            let terms = seen.iter();
            let sum = terms.map(|node| forces[node.number] * (node.value / masses[node.number]));
            sum.sum::<SVector<f64, D>>() * point.mass
        };
        self.points.iter().zip(&after).map(felt).collect()
    }

    fn nodal_masses(&self, seen: &[Seen<D>]) -> Vec<f64> {
        let mut masses = vec![0.0; self.nodes.len()];
        for (point, seen) in self.points.iter().zip(seen) {
            for node in seen {
                masses[node.number] += point.mass * node.value;
            }
        }
        masses
    }
}

impl<const D: usize> PatchForces<D> for Step<'_, D> {
    /// Forces on displaced nodes or particles.
    fn at(
        &self,
        displacements: &[SVector<f64, D>],
        _: &[SVector<f64, D>],
    ) -> Result<Vec<SVector<f64, D>>, NoForce> {
        // A NaN position belongs to no cell.
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

    fn transfer(&self) -> Option<&dyn PatchTransfer<D>> {
        match self.transfer {
            Some(_) => Some(self),
            None => None,
        }
    }
}

fn rows<const D: usize>(l: &SMatrix<f64, D, D>) -> [[f64; D]; D] {
    array_of(|i| array_of(|j| l[(i, j)]))
}

/// Field of the nodes sampled at a point.
struct Sampled<const D: usize> {
    /// Value `sum_i N_ip w_i` of the field.
    value: SVector<f64, D>,
    /// Gradient `sum_i w_i (x) grad N_ip` of the field.
    gradient: SMatrix<f64, D, D>,
    /// Derivatives with respect to lattice coordinates of the grid.
    slope: SMatrix<f64, D, D>,
    /// First moment `sum_i N_ip w_i (x) (x_i - x_p)`, in lattice coordinates.
    moment: SMatrix<f64, D, D>,
}

/// Velocities of the nodes in a step.
struct OnTheGrid<const D: usize> {
    /// Velocities transferred from the points.
    before: Vec<SVector<f64, D>>,
    /// Velocities after the forces have acted.
    after: Vec<SVector<f64, D>>,
    masses: Vec<f64>,
}

impl<const D: usize> Step<'_, D> {
    fn sampled(seen: &Seen<D>, field: &[SVector<f64, D>]) -> Sampled<D> {
        let mut sampled = Sampled {
            value: SVector::zeros(),
            gradient: SMatrix::zeros(),
            slope: SMatrix::zeros(),
            moment: SMatrix::zeros(),
        };
        for node in seen {
            let own = field[node.number];
            sampled.value += own * node.value;
            sampled.gradient += own * node.gradient.transpose();
            sampled.slope += own * node.slope.transpose();
            sampled.moment += own * node.apart.transpose() * node.value;
        }
        sampled
    }

    /// Affine field of a point from the first moment of its velocities, or from the slope on a node of linear functions; zero for transfers without
    /// affine fields.
    fn affine(&self, place: &SVector<f64, D>, sampled: &Sampled<D>) -> SMatrix<f64, D, D> {
        let mut affine = SMatrix::zeros();
        if self.transfer != Some(Transfer::Affine) {
            return affine;
        }
        for (axis, moment) in self.moments(place).iter().enumerate() {
            let own = match *moment > MINIMUM_SECOND_MOMENT {
                true => sampled.moment.column(axis) / *moment,
                false => sampled.slope.column(axis).into_owned(),
            };
            affine.set_column(axis, &own);
        }
        affine
    }

    /// Transfers velocities to the nodes, `v_i = sum_p m_p N_ip (v_p + C_p (x_i - x_p)) / m_i`, and applies the forces, `v_i' = v_i + dt f_i / m_i`.
    fn to_the_grid(
        &self,
        points: &PointsInMotion<D>,
        places: &[SVector<f64, D>],
        seen: &[Seen<D>],
        dt: f64,
    ) -> Result<OnTheGrid<D>, NoForce> {
        let zero = vec![SVector::zeros(); self.nodes.len()];
        let (mut momenta, mut forces) = (zero.clone(), zero);
        let stresses = self.stresses(places.iter(), &points.gradients);
        for (number, (point, seen)) in self.points.iter().zip(seen).enumerate() {
            let stress = stresses[number];
            if !stress.iter().all(|component| component.is_finite()) {
                return Err(NoForce {
                    particle: number,
                    source: None,
                });
            }
            for node in seen {
                let velocity = points.velocities[number] + points.affine[number] * node.apart;
                momenta[node.number] += velocity * (point.mass * node.value);
                forces[node.number] -= stress * node.gradient * point.volume;
            }
        }
        let masses = self.nodal_masses(seen);
        // A node at which all functions are zero has no mass and moves nothing.
        let over = |vector: &SVector<f64, D>, mass: &f64| match *mass > 0.0 {
            true => vector / *mass,
            false => SVector::zeros(),
        };
        let both = momenta.iter().zip(&masses);
        let before: Vec<SVector<f64, D>> = both.map(|(p, mass)| over(p, mass)).collect();
        let kicks = forces
            .iter()
            .zip(&masses)
            .map(|(f, mass)| over(f, mass) * dt);
        let after = before.iter().zip(kicks).map(|(v, kick)| v + kick).collect();
        Ok(OnTheGrid {
            before,
            after,
            masses,
        })
    }

    /// Velocities `(1 + A + ... + A^(k-1)) v` of the nodes, `A = 1 - S+ S`, with the interpolation `S` to the points and the transfer `S+` back: an
    /// approximation of the full mass matrix of order `k` in place of the lumped masses.
    fn with_full_mass(
        &self,
        velocities: &[SVector<f64, D>],
        seen: &[Seen<D>],
        masses: &[f64],
        order: u32,
    ) -> Vec<SVector<f64, D>> {
        let (mut sum, mut increment) = (velocities.to_vec(), velocities.to_vec());
        for _ in 1..order {
            let mut back = vec![SVector::<f64, D>::zeros(); masses.len()];
            for (point, seen) in self.points.iter().zip(seen) {
                let terms = seen.iter().map(|node| increment[node.number] * node.value);
                let own = terms.sum::<SVector<f64, D>>() * point.mass;
                for node in seen {
                    back[node.number] += own * node.value;
                }
            }
            for (n, mass) in masses.iter().enumerate().filter(|(_, mass)| **mass > 0.0) {
                increment[n] -= back[n] / *mass;
                sum[n] += increment[n];
            }
        }
        sum
    }
}

impl<const D: usize> PatchTransfer<D> for Step<'_, D> {
    fn places(&self) -> Vec<SVector<f64, D>> {
        self.points.iter().map(|point| point.place).collect()
    }

    fn advance(&self, points: &mut PointsInMotion<D>, dt: f64) -> Result<(), NoForce> {
        let Some(transfer) = self.transfer else {
            return Ok(());
        };
        let moved = self.points.iter().zip(&points.displacements);
        let places: Vec<SVector<f64, D>> = moved.map(|(p, u)| self.moved(p, u)).collect();
        let is_lost = |place: &SVector<f64, D>| !place.iter().all(|x| x.abs() < LOST_DISTANCE);
        if let Some(particle) = places.iter().position(is_lost) {
            return Err(NoForce {
                particle,
                source: None,
            });
        }
        let both = places.iter().zip(&points.gradients);
        let seen: Vec<Seen<D>> = both.map(|(place, l)| self.seen(place, l)).collect();
        let mut grid = self.to_the_grid(points, &places, &seen, dt)?;
        // Velocities of the nodes that XPIC adds to those after the forces.
        let mut beyond = Vec::new();
        match transfer {
            Transfer::FullMass { order } => {
                grid.after = self.with_full_mass(&grid.after, &seen, &grid.masses, order);
            }
            Transfer::Extended { order } => {
                beyond = self.with_full_mass(&grid.before, &seen, &grid.masses, order);
                let both = beyond.iter_mut().zip(&grid.before);
                both.for_each(|(own, before)| *own -= before);
            }
            _ => {}
        }
        for (p, (seen, place)) in seen.iter().zip(&places).enumerate() {
            let new = Self::sampled(seen, &grid.after);
            let kept = match transfer {
                Transfer::Blended { flip } => {
                    (points.velocities[p] - Self::sampled(seen, &grid.before).value) * flip
                }
                Transfer::Extended { .. } => Self::sampled(seen, &beyond).value,
                _ => SVector::zeros(),
            };
            points.velocities[p] = new.value + kept;
            points.affine[p] = self.affine(place, &new);
            points.displacements[p] += new.value * dt;
            let own = points.gradients[p];
            points.gradients[p] = own + (new.gradient + new.gradient * own) * dt;
        }
        Ok(())
    }

    fn carried(
        &self,
        displacements: &[SVector<f64, D>],
        velocities: &[SVector<f64, D>],
    ) -> PointsInMotion<D> {
        let mut points = PointsInMotion::at_rest(self.points.len());
        for (p, point) in self.points.iter().enumerate() {
            let seen = self.seen(&point.place, &SMatrix::zeros());
            let moving = Self::sampled(&seen, displacements);
            points.displacements[p] = moving.value;
            points.gradients[p] = moving.gradient;
            let moving = Self::sampled(&seen, velocities);
            points.velocities[p] = moving.value;
            points.affine[p] = self.affine(&point.place, &moving);
        }
        points
    }

    fn kinetic_energy(&self, points: &PointsInMotion<D>) -> f64 {
        let own = |(p, point): (usize, &Carried<D>)| {
            let place = self.moved(point, &points.displacements[p]);
            let moments = self.moments(&place);
            let columns = points.affine[p].column_iter().zip(moments.iter());
            let affine: f64 = columns
                .map(|(column, m)| column.norm_squared() * m.max(0.0))
                .sum();
            0.5 * point.mass * (points.velocities[p].norm_squared() + affine)
        };
        self.points.iter().enumerate().map(own).sum()
    }

    fn strain_energy(&self, points: &PointsInMotion<D>) -> f64 {
        let moved = self.points.iter().zip(&points.displacements);
        let places: Vec<SVector<f64, D>> = moved.map(|(p, u)| self.moved(p, u)).collect();
        let ratios = self.ratios(places.iter(), &points.gradients);
        let at_rest = self.state.energy(&rows(&SMatrix::zeros()), 1.0);
        let of = |(n, (point, l)): (usize, (&Carried<D>, &SMatrix<f64, D, D>))| {
            let ratio = ratios.as_ref().map_or(1.0, |all| all[n]);
            point.volume * (self.state.energy(&rows(l), ratio) - at_rest)
        };
        let both = self.points.iter().zip(&points.gradients);
        both.enumerate().map(of).sum()
    }

    fn momentum(&self, points: &PointsInMotion<D>) -> SVector<f64, D> {
        let both = self.points.iter().zip(&points.velocities);
        both.map(|(point, v)| v * point.mass).sum()
    }
}
