//! Patches of material points whose velocities pass through a grid once per step.
//!
//! The points move, with their deformation gradients and affine fields, by the time step of the method ([`PatchTransfer`]). The predictions are for
//! waves of nodes ([`TransferredWaves`]).
//! A wave starts as the interpolation of a wave of nodes to the points. It is measured by projection on this interpolation.

use super::equations::{Field, field_of, flat, in_space};
use super::patch::random_displacements;
use super::waves::waves_of;
use super::{Fault, Ground, PatchMotion, PatchState, PatchWave, Quantities, SteppedWave, Stepper};
use crate::algebra::{Complex, array_of};
use crate::kinematics::DeformationGradient;
use crate::lattice::Crystal;
use crate::material::Hyperelastic;
use crate::scheme::{NoForce, PatchTransfer, PeriodicPatch, PointsInMotion};
use crate::time_step::TransferredWaves;
use nalgebra::{DVector, SMatrix, SVector};
use std::f64::consts::TAU;

/// Waves count as invisible if their amplitude at the points is a smaller fraction of the amplitude at the nodes; also used for waves of points at the
/// nodes.
const INVISIBLE_AMPLITUDE: f64 = 1e-9;
/// Distance in spacings at which a point counts as lost.
const LOST_DISTANCE: f64 = 1e8;

/// Largest ratio of decay rates at which the faster solution can still be measured.
const MEASURABLE_DECAY_RATIO: f64 = 10.0;

/// Patch of material points in motion.
pub(super) struct TransferredPatch<'a, const D: usize> {
    material: &'a dyn Hyperelastic,
    f: DeformationGradient,
    transfer: &'a dyn PatchTransfer<D>,
    nodal: TransferredWaves<D>,
    nodes: PeriodicPatch<D>,
    waves: Vec<PatchWave>,
    /// Positions of the points in the reference configuration; length.
    positions: Field<D>,
    points: PointsInMotion<D>,
    count: u64,
}

impl<'a, const D: usize> TransferredPatch<'a, D> {
    pub(super) fn new(
        material: &'a dyn Hyperelastic,
        f: &DeformationGradient,
        cells: [usize; D],
        nodal: TransferredWaves<D>,
        transfer: &'a dyn PatchTransfer<D>,
    ) -> Self {
        let nodes = PeriodicPatch::new(nodal.system().crystal(), cells);
        let vectors = *nodal.system().crystal().lattice().vectors();
        let places = transfer.places();
        Self {
            waves: waves_of(nodal.system(), &nodes),
            points: PointsInMotion::at_rest(places.len()),
            positions: places.into_iter().map(|place| vectors * place).collect(),
            material,
            f: *f,
            transfer,
            nodal,
            nodes,
            count: 0,
        }
    }

    fn grid(&self) -> &Crystal<D> {
        self.nodal.system().crystal()
    }

    /// `omega^2` and displacements of a wave of the nodes.
    fn mode(&self, wave: &PatchWave) -> Option<(Complex, DVector<Complex>)> {
        let modes = self.nodal.system().modes(&wave.vector());
        modes.into_iter().nth(wave.branch - 1)
    }

    /// Field of a wave on the nodes, from its vectors at the node at the origin.
    fn on_nodes(&self, wave: &PatchWave, vector: &DVector<Complex>) -> Field<D> {
        let k = wave.vector::<D>();
        let at = |node| {
            let phase = k.dot(&self.grid().position(&node)) % TAU;
            let turn = Complex::new(0.0, phase).exp();
            SVector::from_fn(|i, _| (vector[i] * turn).re)
        };
        self.nodes.particles().into_iter().map(at).collect()
    }

    /// Interpolation to the points of a wave whose largest displacement is one; `None` if it vanishes at the points. A displacement gradient is
    /// converted to a displacement as for a wave of one spacing, in case only the strain is nonzero.
    fn on_points(
        &self,
        wave: &PatchWave,
        seed: &[DVector<Complex>; 2],
    ) -> Option<PointsInMotion<D>> {
        let [u, v] = seed.each_ref().map(|own| self.on_nodes(wave, own));
        let mut points = self.transfer.carried(&u, &v);
        let largest = self.largest(&points);
        if largest < INVISIBLE_AMPLITUDE * seed[0].norm() {
            return None;
        }
        scale(&mut points, largest.recip());
        Some(points)
    }

    /// Largest displacement. For waves that strain points without moving them it follows from their strain.
    fn largest(&self, points: &PointsInMotion<D>) -> f64 {
        let displaced = points.displacements.iter().map(|u| u.norm());
        let length = self.grid().spacing() / TAU;
        let strained = points.gradients.iter().map(|l| length * l.norm());
        displaced.chain(strained).fold(0.0, f64::max)
    }

    /// Deformation gradient of a point.
    fn deformation(&self, point: usize) -> DeformationGradient {
        let base = self.f.leading::<D>();
        self.f
            .with_leading(&(base + self.points.gradients[point] * base))
    }

    fn fault(&self, none: NoForce, step: f64) -> Box<Fault> {
        let n = none.particle;
        let of = |field: &Field<D>| field[n].iter().copied().collect::<Vec<f64>>();
        let own = self.deformation(n).leading::<D>();
        let is_near = |u: &f64| u.abs() < LOST_DISTANCE * self.grid().spacing();
        let is_finite =
            own.iter().all(|x| x.is_finite()) && self.points.displacements[n].iter().all(is_near);
        Box::new(Fault {
            time: self.count as f64 * step,
            step: self.count,
            particle: n,
            position: of(&self.positions),
            displacement: of(&self.points.displacements),
            velocity: of(&self.points.velocities),
            deformation: own.transpose().iter().copied().collect(),
            ground: match (none.source, is_finite) {
                (Some(source), _) => Ground::Method(source),
                (None, false) => Ground::NotFinite,
                (None, true) => Ground::without_stress(self.material, &self.deformation(n)),
            },
        })
    }
}

fn scale<const D: usize>(points: &mut PointsInMotion<D>, factor: f64) {
    for field in [&mut points.displacements, &mut points.velocities] {
        field.iter_mut().for_each(|own| *own *= factor);
    }
    for field in [&mut points.gradients, &mut points.affine] {
        field.iter_mut().for_each(|own| *own *= factor);
    }
}

fn state_of<const D: usize>(points: &PointsInMotion<D>, step: u64) -> PatchState {
    let tensors = points.gradients.iter().chain(&points.affine);
    PatchState {
        step,
        displacements: flat(&points.displacements),
        velocities: flat(&points.velocities),
        deformations: tensors.flatten().copied().collect(),
        work: 0.0,
    }
}

impl<const D: usize> PatchMotion for TransferredPatch<'_, D> {
    fn dimension(&self) -> usize {
        D
    }

    fn positions(&self) -> Vec<[f64; 3]> {
        in_space(&self.positions)
    }

    fn state(&self) -> PatchState {
        state_of(&self.points, self.count)
    }

    fn put(&mut self, state: &PatchState) {
        let count = self.positions.len();
        let tensors = state.deformations.chunks_exact(D * D);
        let mut tensors = tensors.map(SMatrix::<f64, D, D>::from_column_slice);
        let mut next = || {
            let mut own: Vec<_> = tensors.by_ref().take(count).collect();
            own.resize(count, SMatrix::zeros());
            own
        };
        self.points = PointsInMotion {
            displacements: field_of(&state.displacements, count),
            velocities: field_of(&state.velocities, count),
            gradients: next(),
            affine: next(),
        };
        self.count = state.step;
    }

    fn advance(&mut self, _: Stepper, step: f64) -> Result<(), Box<Fault>> {
        let done = self.transfer.advance(&mut self.points, step);
        done.map_err(|none| self.fault(none, step))?;
        self.count += 1;
        let points = &self.points;
        let lost = (0..self.positions.len()).find(|n| {
            let vectors = [&points.displacements[*n], &points.velocities[*n]];
            let tensors = [&points.gradients[*n], &points.affine[*n]];
            let numbers = vectors.into_iter().flatten();
            !numbers
                .chain(tensors.into_iter().flatten())
                .all(|x| x.is_finite())
        });
        match lost {
            None => Ok(()),
            Some(particle) => Err(self.fault(
                NoForce {
                    particle,
                    source: None,
                },
                step,
            )),
        }
    }

    fn quantities(&self, _: Stepper, step: f64) -> Result<Quantities, Box<Fault>> {
        let momentum = self.transfer.momentum(&self.points);
        let potential = self.transfer.strain_energy(&self.points);
        if !potential.is_finite() {
            let energy = |n: usize| Some(self.material.response(&self.deformation(n)).ok()?.energy);
            let is_lost = |n: &usize| !energy(*n).is_some_and(f64::is_finite);
            let particle = (0..self.positions.len()).find(is_lost).unwrap_or(0);
            let source = None;
            return Err(self.fault(NoForce { particle, source }, step));
        }
        Ok(Quantities {
            kinetic: self.transfer.kinetic_energy(&self.points),
            potential,
            momentum: array_of(|i| momentum.get(i).copied().unwrap_or(0.0)),
            largest: self.largest(&self.points),
        })
    }

    fn waves(&self) -> &[PatchWave] {
        &self.waves
    }

    fn sees(&self, wave: &PatchWave) -> bool {
        self.mode(wave).is_some_and(|(_, mode)| {
            let seed = [real_at_the_origin(&mode), DVector::zeros(D)];
            self.on_points(wave, &seed).is_some()
        })
    }

    fn critical_time_step(&self, _: Stepper) -> f64 {
        let each = self.waves.iter().filter(|wave| wave.branch == 1);
        let steps = each.map(|wave| self.nodal.critical_time_step_at(&wave.vector()));
        steps.fold(f64::INFINITY, f64::min)
    }

    fn stepped(&self, wave: &PatchWave, _: Stepper, step: f64) -> Option<SteppedWave> {
        let k = wave.vector();
        let (omega_squared, mode) = self.mode(wave)?;
        let mut factors = *self.nodal.factors(&k, step).get(wave.branch - 1)?;
        // Points that a wave strains without moving them transfer no velocity to the nodes: u' = (1 - q omega^2 dt^2) u.
        let is_at_rest = 1.0 - self.nodal.lost(&k) < INVISIBLE_AMPLITUDE;
        if is_at_rest {
            let square = omega_squared * (self.nodal.mobility(&k) * step * step);
            factors = [1.0 - square, Complex::new(0.0, 0.0)];
        }
        let speed = |z: Complex| {
            let speed = self.nodal.speed(&k, omega_squared, z, step);
            // The velocity is zero if the nodal velocities are lost, or if the wave does not move.
            match speed.is_finite() && !wave.has_zero_energy && !is_at_rest {
                true => speed,
                false => Complex::new(0.0, 0.0),
            }
        };
        let travels = factors[0].im != 0.0;
        let [change, other] = factors.map(|z| z.norm().ln().abs());
        let is_alone = !travels && other > MEASURABLE_DECAY_RATIO * change;
        let speed = match travels || is_alone {
            true => speed(factors[0]),
            // Seeds both solutions, because a short record of one alone does not separate it from the other.
            false => (speed(factors[0]) + speed(factors[1])) * 0.5,
        };
        let mode = real_at_the_origin(&mode);
        let seed = [mode.clone(), mode * speed];
        Some(SteppedWave {
            wave: wave.clone(),
            factors,
            is_alone,
            projector: seed[0].clone(),
            seed,
        })
    }

    fn seed(&self, wave: &SteppedWave, amplitude: f64) -> PatchState {
        let points = self.on_points(&wave.wave, &wave.seed);
        let mut points = points.unwrap_or_else(|| PointsInMotion::at_rest(self.positions.len()));
        scale(&mut points, amplitude);
        state_of(&points, 0)
    }

    fn noise(&self, amplitude: f64, seed: u64) -> PatchState {
        let nodes = random_displacements(self.nodes.len(), amplitude, seed);
        let at_rest = vec![SVector::zeros(); nodes.len()];
        state_of(&self.transfer.carried(&nodes, &at_rest), 0)
    }

    fn amplitude(&self, wave: &SteppedWave) -> f64 {
        let Some(own) = self.on_points(&wave.wave, &wave.seed) else {
            return 0.0;
        };
        let length = self.grid().spacing();
        let product = |a: &PointsInMotion<D>, b: &PointsInMotion<D>| -> f64 {
            let displaced = a.displacements.iter().zip(&b.displacements);
            let strained = a.gradients.iter().zip(&b.gradients);
            displaced.map(|(a, b)| a.dot(b)).sum::<f64>()
                + strained
                    .map(|(a, b)| length * length * a.dot(b))
                    .sum::<f64>()
        };
        product(&own, &self.points) / product(&own, &own)
    }
}

/// Vector scaled so that its largest component is one.
fn real_at_the_origin(vector: &DVector<Complex>) -> DVector<Complex> {
    let by_size = |a: &&Complex, b: &&Complex| a.norm().total_cmp(&b.norm());
    match vector.iter().max_by(by_size) {
        Some(largest) if largest.norm() > 0.0 => vector * largest.inv(),
        _ => vector.clone(),
    }
}
