//! Periodic patches in motion.

use super::equations::{Equations, Field, field_of, flat, in_space};
use super::transfer::TransferredPatch;
use super::waves::{critical_time_step, stepped, waves_of};
use super::{Fault, Ground, PatchWave, SteppedWave, Stepper};
use crate::algebra::{Complex, array_of, uniform};
use crate::bloch::WaveSystem;
use crate::cancel::checkpoint;
use crate::kinematics::DeformationGradient;
use crate::lattice::determinant;
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::scheme::{Discretization, NoForce, PatchForces, PeriodicPatch};
use crate::time_step::Integrator;
use nalgebra::{SMatrix, SVector};
use std::f64::consts::TAU;

/// Displacements and velocities of the particles of a patch or body, vector by vector.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchState {
    /// Number of steps taken.
    pub step: u64,
    /// Displacements from the homogeneous state; length.
    pub displacements: Vec<f64>,
    /// Velocities as stored by the integrator; length/time. For central differences they are half a step before the displacements.
    pub velocities: Vec<f64>,
    /// Deformation carried by the particles, if it does not follow from the displacements; empty otherwise, and for a homogeneously deformed body.
    ///
    /// Particles of a body carry deformation gradients, row by row. Material points with a transfer carry displacement gradients from the homogeneous
    /// state and affine velocity fields, column by column.
    pub deformations: Vec<f64>,
    /// External work on the particles; energy. Zero for patches.
    pub work: f64,
}

/// Global quantities of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantities {
    /// Kinetic energy `v.M v / 2`; energy (in 2D per unit thickness, in 1D per unit cross-section).
    pub kinetic: f64,
    /// Work against the forces along the straight path from the homogeneous state; this is the potential energy if the forces have a potential.
    pub potential: f64,
    /// Linear momentum `sum M v`; mass length/time.
    pub momentum: [f64; 3],
    /// Largest displacement of a particle from the homogeneous state; length.
    ///
    /// A wave can strain material points with a transfer without moving them. For such waves the value is at least the displacement of a wave of one
    /// spacing with the same strain.
    pub largest: f64,
}

/// Patch of particles in motion, for any dimension and method.
pub trait PatchMotion {
    /// Number of space dimensions.
    fn dimension(&self) -> usize;

    /// Positions of the particles in the reference configuration; length.
    fn positions(&self) -> Vec<[f64; 3]>;

    /// Returns the current state.
    fn state(&self) -> PatchState;

    /// Continues from a state.
    fn put(&mut self, state: &PatchState);

    /// Advances by one time step.
    ///
    /// # Errors
    /// [`Fault`] if forces are undefined or not finite.
    fn advance(&mut self, stepper: Stepper, step: f64) -> Result<(), Box<Fault>>;

    /// Returns energies and momentum. `step` is the time step of the run.
    ///
    /// # Errors
    /// [`Fault`] if forces are undefined.
    fn quantities(&self, stepper: Stepper, step: f64) -> Result<Quantities, Box<Fault>>;

    /// Plane waves that fit into the patch, one of each pair of opposite waves. The first waves have the wave vector zero; their number is the number
    /// of degrees of freedom of a cell.
    fn waves(&self) -> &[PatchWave];

    /// Largest stable step for these waves; time.
    fn critical_time_step(&self, stepper: Stepper) -> f64;

    /// Returns a wave in discrete time, or `None` if its eigenvalues do not converge.
    fn stepped(&self, wave: &PatchWave, stepper: Stepper, step: f64) -> Option<SteppedWave>;

    /// Returns true if the wave moves or strains particles of the patch. A wave of grid nodes can vanish at all points.
    fn sees(&self, _: &PatchWave) -> bool {
        true
    }

    /// Returns random displacements with zero mean, where `amplitude` is the largest displacement along an axis; length.
    ///
    /// For material points with a transfer the nodes are displaced, and the displacements are interpolated to the points.
    fn noise(&self, amplitude: f64, seed: u64) -> PatchState;

    /// Returns a single wave with the given amplitude; length. The amplitude is the largest component of the displacement, or for material points
    /// with a transfer the largest displacement.
    fn seed(&self, wave: &SteppedWave, amplitude: f64) -> PatchState;

    /// Amplitude of a wave in the current displacements; length.
    fn amplitude(&self, wave: &SteppedWave) -> f64;
}

/// Patch of `D` dimensions in motion.
pub struct MovingPatch<'a, const D: usize> {
    discretization: &'a dyn Discretization<D>,
    material: &'a dyn Hyperelastic,
    f: DeformationGradient,
    patch: PeriodicPatch<D>,
    system: WaveSystem<D>,
    waves: Vec<PatchWave>,
    positions: Field<D>,
    equations: Equations<'a, D>,
    u: Field<D>,
    v: Field<D>,
    count: u64,
}

/// Calls a function with a patch of cells in motion about a homogeneous state.
pub(crate) fn with_motion<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
    cells: [usize; D],
    work: &mut dyn FnMut(&mut dyn PatchMotion),
) -> Result<(), MethodError> {
    let system = discretization.waves(material, f)?;
    system.check_mass()?;
    let patch = PeriodicPatch::new(discretization.crystal(), cells);
    let transferred = discretization.transferred(material, f)?;
    let mut result = Ok(());
    discretization.with_forces(material, f, &patch, &mut |forces| {
        if let Some((waves, transfer)) = transferred.as_ref().zip(forces.transfer()) {
            let waves = waves.clone();
            return work(&mut TransferredPatch::new(
                material, f, cells, waves, transfer,
            ));
        }
        let moving = MovingPatch::new(discretization, material, f, patch, system.clone(), forces);
        match moving {
            Ok(mut patch) => work(&mut patch),
            Err(none) => result = Err(none.source.unwrap_or(MethodError::NotFinite)),
        }
    })?;
    result
}

/// Random displacements of `count` particles with zero mean; length.
pub(super) fn random_displacements<const D: usize>(
    count: usize,
    amplitude: f64,
    seed: u64,
) -> Field<D> {
    let mut random = seed;
    let mut one = || amplitude * (2.0 * uniform(&mut random) - 1.0);
    let mut field: Field<D> = (0..count).map(|_| SVector::from_fn(|_, _| one())).collect();
    let mean = field.iter().sum::<SVector<f64, D>>() / count as f64;
    field.iter_mut().for_each(|u| *u -= mean);
    field
}

impl<'a, const D: usize> MovingPatch<'a, D> {
    fn new(
        discretization: &'a dyn Discretization<D>,
        material: &'a dyn Hyperelastic,
        f: &DeformationGradient,
        patch: PeriodicPatch<D>,
        system: WaveSystem<D>,
        forces: &'a dyn PatchForces<D>,
    ) -> Result<Self, NoForce> {
        let crystal = discretization.crystal();
        let particles = patch.particles();
        let at_rest = vec![SVector::zeros(); patch.len()];
        Ok(Self {
            positions: particles.iter().map(|own| crystal.position(own)).collect(),
            waves: waves_of(&system, &patch),
            equations: Equations::new(&patch, &system, forces)?,
            u: at_rest.clone(),
            v: at_rest,
            count: 0,
            discretization,
            material,
            f: *f,
            patch,
            system,
        })
    }

    fn kick(&mut self, at: Option<[&Field<D>; 2]>, dt: f64) -> Result<(), NoForce> {
        let [u, v] = at.unwrap_or([&self.u, &self.v]);
        let acceleration = self.equations.acceleration(u, v)?;
        add(&mut self.v, &acceleration, dt);
        Ok(())
    }

    fn move_by(&mut self, velocities: &Field<D>, dt: f64) {
        let drift = self.equations.drift(velocities);
        add(&mut self.u, &drift, dt);
    }

    /// Applies one step of an integrator.
    fn part(&mut self, integrator: Integrator, dt: f64) -> Result<(), NoForce> {
        match integrator {
            Integrator::CentralDifferences => {
                self.kick(None, dt)?;
                self.move_by(&self.v.clone(), dt);
            }
            Integrator::KickDriftKick => {
                self.kick(None, 0.5 * dt)?;
                self.move_by(&self.v.clone(), dt);
                self.kick(None, 0.5 * dt)?;
            }
            Integrator::PredictorCorrector => {
                let (u, v) = (self.u.clone(), self.v.clone());
                self.kick(None, 0.5 * dt)?;
                let predicted_v = std::mem::replace(&mut self.v, v.clone());
                self.move_by(&v, 0.5 * dt);
                let predicted_u = std::mem::replace(&mut self.u, u);
                self.kick(Some([&predicted_u, &predicted_v]), dt)?;
                let middle = v.iter().zip(&self.v).map(|(a, b)| (a + b) * 0.5).collect();
                self.move_by(&middle, dt);
            }
            _ => {
                let (u, v) = (self.u.clone(), self.v.clone());
                let mut rates: Vec<[Field<D>; 2]> = Vec::new();
                let rows = integrator.tableau().unwrap_or_default();
                for row in &rows {
                    (self.u, self.v) = (u.clone(), v.clone());
                    for (factor, [drift, acceleration]) in row.iter().zip(&rates) {
                        add(&mut self.u, drift, factor * dt);
                        add(&mut self.v, acceleration, factor * dt);
                    }
                    if rates.len() + 1 < rows.len() {
                        let acceleration = self.equations.acceleration(&self.u, &self.v)?;
                        rates.push([self.equations.drift(&self.v), acceleration]);
                    }
                }
            }
        }
        Ok(())
    }

    /// Velocities at the time of the displacements.
    fn velocities_now(&self, stepper: Stepper, step: f64) -> Result<Field<D>, NoForce> {
        if stepper.integrator() != Integrator::CentralDifferences {
            return Ok(self.v.clone());
        }
        let acceleration = self.equations.acceleration(&self.u, &self.v)?;
        let both = self.v.iter().zip(acceleration);
        Ok(both.map(|(v, a)| v + a * (0.5 * step)).collect())
    }

    /// Deformation gradient with the smallest determinant among the points around a particle.
    fn most_compressed(&self, particle: usize) -> Option<(f64, Vec<f64>)> {
        let strain = self.discretization.strain().ok()?;
        let mut worst: Option<(f64, Vec<f64>)> = None;
        for point in strain.points() {
            let form = point.forms.first()?;
            for origin in self.patch.origins() {
                let numbers = point.particles.iter();
                let numbers: Vec<usize> = numbers
                    .map(|own| self.patch.number(&own.moved(&origin)))
                    .collect();
                if !numbers.contains(&particle) || form.vectors().len() != numbers.len() {
                    continue;
                }
                let mut own = self.f.leading::<D>();
                for (number, b) in numbers.iter().zip(form.vectors()) {
                    own += self.u[*number] * b.transpose();
                }
                let volume = determinant(&own);
                if worst.as_ref().is_none_or(|(least, _)| volume < *least) {
                    worst = Some((volume, own.transpose().iter().copied().collect()));
                }
            }
        }
        worst
    }

    fn fault(&self, none: NoForce, step: f64) -> Box<Fault> {
        let particle = none.particle;
        let of = |field: &Field<D>| field[particle].iter().copied().collect::<Vec<f64>>();
        let compressed = self.most_compressed(particle);
        let is_finite =
            |field: &Field<D>| field.iter().all(|own| own.iter().all(|x| x.is_finite()));
        let ground = match (none.source, &compressed) {
            _ if !is_finite(&self.u) || !is_finite(&self.v) => Ground::NotFinite,
            (Some(source), _) => Ground::Method(source),
            (None, Some((_, own))) => {
                let own = SMatrix::<f64, D, D>::from_row_slice(own);
                Ground::without_stress(self.material, &self.f.with_leading(&own))
            }
            (None, None) => Ground::OutsideDomain,
        };
        Box::new(Fault {
            time: self.count as f64 * step,
            step: self.count,
            particle,
            position: of(&self.positions),
            displacement: of(&self.u),
            velocity: of(&self.v),
            deformation: compressed.map_or_else(Vec::new, |(_, f)| f),
            ground,
        })
    }
}

/// Adds a rate times a time step to a field.
fn add<const D: usize>(field: &mut Field<D>, rate: &Field<D>, dt: f64) {
    field
        .iter_mut()
        .zip(rate)
        .for_each(|(own, rate)| *own += rate * dt);
}

impl<const D: usize> PatchMotion for MovingPatch<'_, D> {
    fn dimension(&self) -> usize {
        D
    }

    fn positions(&self) -> Vec<[f64; 3]> {
        in_space(&self.positions)
    }

    fn state(&self) -> PatchState {
        PatchState {
            step: self.count,
            displacements: flat(&self.u),
            velocities: flat(&self.v),
            deformations: Vec::new(),
            work: 0.0,
        }
    }

    fn put(&mut self, state: &PatchState) {
        self.u = field_of(&state.displacements, self.patch.len());
        self.v = field_of(&state.velocities, self.patch.len());
        self.count = state.step;
    }

    fn advance(&mut self, stepper: Stepper, step: f64) -> Result<(), Box<Fault>> {
        checkpoint();
        for part in stepper.parts() {
            self.part(stepper.integrator(), part * step)
                .map_err(|none| self.fault(none, step))?;
        }
        self.count += 1;
        let lost = self.u.iter().zip(&self.v).position(|(u, v)| {
            !(u.iter().all(|x| x.is_finite()) && v.iter().all(|x| x.is_finite()))
        });
        match lost {
            Some(particle) => Err(self.fault(
                NoForce {
                    particle,
                    source: None,
                },
                step,
            )),
            None => Ok(()),
        }
    }

    fn quantities(&self, stepper: Stepper, step: f64) -> Result<Quantities, Box<Fault>> {
        let failed = |none| self.fault(none, step);
        let velocities = self.velocities_now(stepper, step).map_err(failed)?;
        let momentum = self.equations.momentum(&velocities);
        Ok(Quantities {
            kinetic: self.equations.kinetic_energy(&velocities),
            potential: self.equations.work(&self.u).map_err(failed)?,
            momentum: array_of(|i| momentum.get(i).copied().unwrap_or(0.0)),
            largest: self.u.iter().map(|u| u.norm()).fold(0.0, f64::max),
        })
    }

    fn waves(&self) -> &[PatchWave] {
        &self.waves
    }

    fn critical_time_step(&self, stepper: Stepper) -> f64 {
        critical_time_step(&self.system, &self.waves, stepper)
    }

    fn stepped(&self, wave: &PatchWave, stepper: Stepper, step: f64) -> Option<SteppedWave> {
        stepped(&self.system, wave, stepper, step)
    }

    fn seed(&self, wave: &SteppedWave, amplitude: f64) -> PatchState {
        let sites = self.discretization.crystal().sites().len();
        let field = |vector: &nalgebra::DVector<Complex>| {
            let of = |(number, x): (usize, &SVector<f64, D>)| {
                let turn = Complex::new(0.0, phase(wave, x)).exp() * amplitude;
                let site = number % sites;
                (0..D)
                    .map(move |i| (D * site + i, turn))
                    .collect::<Vec<_>>()
            };
            let all = self.positions.iter().enumerate().flat_map(of);
            all.map(|(row, turn)| (vector[row] * turn).re).collect()
        };
        PatchState {
            step: 0,
            displacements: field(&wave.seed[0]),
            velocities: field(&wave.seed[1]),
            deformations: Vec::new(),
            work: 0.0,
        }
    }

    fn noise(&self, amplitude: f64, seed: u64) -> PatchState {
        let displacements: Field<D> = random_displacements(self.patch.len(), amplitude, seed);
        PatchState {
            velocities: vec![0.0; D * displacements.len()],
            displacements: flat(&displacements),
            ..PatchState::default()
        }
    }

    fn amplitude(&self, wave: &SteppedWave) -> f64 {
        let sites = self.discretization.crystal().sites().len();
        let mut sum = Complex::new(0.0, 0.0);
        for (number, (u, x)) in self.u.iter().zip(&self.positions).enumerate() {
            let turn = Complex::new(0.0, -phase(wave, x)).exp();
            let site = number % sites;
            for i in 0..D {
                sum += wave.projector[D * site + i].conj() * turn * u[i];
            }
        }
        let cells = self.patch.cells();
        // A real field contains half of a wave and half of its opposite, unless both are equal.
        let turns = wave.wave.turns.iter().zip(cells);
        let is_own_opposite = turns
            .into_iter()
            .all(|(turns, cells)| (2 * turns).is_multiple_of(cells));
        let share = if is_own_opposite { 1.0 } else { 2.0 };
        let norm = wave.projector.dotc(&wave.seed[0]) * cells.iter().product::<usize>() as f64;
        (sum * share / norm).re
    }
}

/// Phase `k.X` of a wave vector that fits into the patch.
fn phase<const D: usize>(wave: &SteppedWave, x: &SVector<f64, D>) -> f64 {
    let along = wave.wave.wave_vector.iter().zip(x.iter());
    along.map(|(k, x)| k * x).sum::<f64>() % TAU
}
