//! Plan of a run, fixed before the first step.

use super::SimulateError;
use super::run::Course;
use crate::answers::Problem;
use crate::number::{exact, told, vector};
use onset::algebra::Complex;
use onset::kinematics::DeformationGradient;
use onset::motion::{PatchMotion, PatchWave, SteppedWave, Stepper};
use serde_json::json;
use sha2::{Digest, Sha256};
use std::f64::consts::PI;

/// Initial perturbation of a patch.
#[derive(Clone, Debug, PartialEq)]
pub enum Seeded {
    /// One wave, given by its reference wave vector; 1/length.
    Wave(Vec<f64>),
    /// One wave, given by the number of wavelengths along each side of the patch.
    Turns(Vec<i64>),
    /// The wave of the patch with the smallest `omega^2`.
    Critical,
    /// Random displacements of all particles; the wave with the smallest `omega^2` is measured.
    Noise,
}

/// Duration of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Duration {
    /// Default duration for the wave: about a period, or four e-folding times.
    Natural,
    /// Number of time steps.
    Steps(u64),
    /// Simulated time, rounded to whole steps.
    Time(f64),
}

/// Duration, step size and output of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Duration of the run.
    pub duration: Duration,
    /// Ratio of the step to the largest stable step; `None` for one half, or less if the wave requires it.
    pub fraction: Option<f64>,
    /// Time step, in place of `fraction`; time. `None` to use `fraction`.
    pub time_step: Option<f64>,
    /// Whether a step above the largest stable step is intended.
    pub is_supercritical: bool,
    /// Number of steps between lines of the history; `None` for about four hundred lines.
    pub every: Option<u64>,
    /// Number of fields written, from the first step to the last.
    pub fields: u64,
}

/// Patch to be run, with its perturbation, time integration and duration.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// Deformation gradient of the homogeneous state.
    pub f: DeformationGradient,
    /// Number of cells along each primitive vector, or one number for all.
    pub cells: Vec<usize>,
    /// Initial perturbation of the patch.
    pub seeded: Seeded,
    /// Branch of the wave, counted from 1 by increasing `omega^2`.
    pub branch: usize,
    /// Largest displacement at the start, in particle spacings.
    pub amplitude: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// Duration, step size and output of the run.
    pub pace: Pace,
    /// Time integration; `None` for velocity Verlet. A transfer of material points replaces it.
    pub stepper: Option<Stepper>,
    /// Relative difference of rates that counts as agreement.
    pub tolerance: f64,
}

/// Columns of the history of a patch.
pub(super) const COLUMNS: &[(&str, &str)] = &[
    ("step", "1"),
    ("time", "time"),
    ("kinetic_energy", "energy"),
    ("potential_energy", "energy"),
    ("energy", "energy"),
    ("momentum_1", "momentum"),
    ("momentum_2", "momentum"),
    ("momentum_3", "momentum"),
    ("largest_displacement", "length"),
    ("amplitude", "length"),
];

/// Plan of the run of a patch.
pub(super) struct Plan {
    pub(super) course: Course,
    pub(super) stepper: Stepper,
    /// Name of the integrator.
    pub(super) integrator: &'static str,
    pub(super) cells: Vec<usize>,
    pub(super) seeding: &'static str,
    pub(super) tolerance: f64,
    pub(super) wave: SteppedWave,
}

/// Largest number of particles in a patch.
const MAX_PARTICLES: usize = 1_000_000;
/// Largest number of waves in a patch; all of them are computed.
const MAX_WAVES: usize = 200_000;
/// Largest number of displacements in a page with an animation.
pub(super) const MAX_ANIMATED_DISPLACEMENTS: usize = 100_000;
/// Default number of lines in a history.
const DEFAULT_LINES: u64 = 400;
/// Largest number of lines in a history.
const MAX_LINES: u64 = 1_000_000;
/// Largest number of steps.
const MAX_STEPS: u64 = 10_000_000_000;
/// Smallest number of steps if the duration is not given.
const MIN_STEPS: f64 = 160.0;
/// Number of steps of a zero-energy mode if the duration is not given.
const ZERO_ENERGY_STEPS: f64 = 1000.0;
/// Default ratio of the step to the largest stable step.
pub(super) const DEFAULT_STEP_FRACTION: f64 = 0.5;
/// Largest number of samples in a record.
const MAX_SAMPLES: u64 = 400;
/// Number of samples per period, and per e-folding time.
const SAMPLES_PER_PERIOD: f64 = 20.0;
const SAMPLES_PER_E_FOLDING: f64 = 40.0;
/// Number of e-folding times in a record; beyond them a growing wave is no longer small.
const E_FOLDINGS: f64 = 4.0;
/// Relative tolerance of a wave vector that fits the patch, in wavelengths; allows for the rounding of typed numbers.
const WAVE_VECTOR_TOLERANCE: f64 = 1e-6;

pub(super) fn refused(what: impl Into<String>, hint: impl Into<String>) -> SimulateError {
    SimulateError::Refused {
        what: what.into(),
        hint: hint.into(),
    }
}

impl Question {
    /// Number of cells along each primitive vector, after checks.
    pub(super) fn patch(&self, problem: &Problem) -> Result<Vec<usize>, SimulateError> {
        let dimension = problem.dimension();
        let cells = match self.cells[..] {
            [all] => vec![all; dimension],
            _ => self.cells.clone(),
        };
        if cells.len() != dimension || cells.contains(&0) {
            return Err(refused(
                format!("--cells: expected one positive number, or {dimension}"),
                "for example --cells 8",
            ));
        }
        let count = cells
            .iter()
            .try_fold(problem.analysis.sites(), |all, own| all.checked_mul(*own));
        let waves = count.and_then(|count| count.checked_mul(dimension));
        if count.is_none_or(|count| count > MAX_PARTICLES)
            || waves.is_none_or(|waves| waves > 2 * MAX_WAVES)
        {
            return Err(refused(
                "--cells: the patch has too many particles",
                format!(
                    "at most {} particles are supported, because all waves of the patch are computed",
                    2 * MAX_WAVES / dimension
                ),
            ));
        }
        Ok(cells)
    }
}

impl Plan {
    /// Plans a run on its patch.
    pub(super) fn new(
        problem: &Problem,
        question: &Question,
        patch: &dyn PatchMotion,
        cells: Vec<usize>,
    ) -> Result<Self, SimulateError> {
        let (stepper, integrator) = stepped(problem, question)?;
        if stepper.goes_back() && problem.analysis.is_damped() {
            return Err(refused(
                format!(
                    "--integrator {} has backward substeps, in which damping amplifies",
                    stepper.name()
                ),
                "choose kick-drift-kick, or omit the viscosity",
            ));
        }
        let wave = chosen(problem, question, patch, &cells)?;
        let critical = patch.critical_time_step(stepper);
        let step = step(problem, question, critical, &wave)?;
        let wave = patch.stepped(&wave, stepper, step).ok_or_else(|| {
            refused(
                "the eigenvalues of this wave do not converge",
                "choose another --wave-vector",
            )
        })?;
        let steps = steps(question, &wave, step)?;
        let every = every(question.pace.every, steps)?;
        let (sampling, samples) = sampled(&wave, step, steps);
        let amplitude = question.amplitude * problem.analysis.spacing();
        let start = match question.seeded {
            Seeded::Noise => patch.noise(amplitude, question.seed),
            _ => patch.seed(&wave, amplitude),
        };
        let seeding = match question.seeded {
            Seeded::Noise => "noise",
            Seeded::Critical => "critical",
            Seeded::Wave(_) | Seeded::Turns(_) => "wave",
        };
        let fields = fields(question.pace.fields, steps);
        let decisive = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "settings": problem.settings.effective(),
            "state": question.f.components(),
            "cells": cells,
            "seeding": seeding,
            "seed": question.seed,
            "wave": wave.wave.wave_vector,
            "branch": wave.wave.branch,
            "amplitude": question.amplitude,
            "integrator": integrator,
            "step": step,
            "steps": steps,
            "every": every,
            "fields": fields,
        });
        let is_shown = fields.len() > 1
            && start.displacements.len() * fields.len() <= MAX_ANIMATED_DISPLACEMENTS;
        Ok(Self {
            course: Course {
                mark: mark(&decisive),
                step,
                critical,
                steps,
                every,
                sampling,
                samples,
                fields,
                is_shown,
                columns: COLUMNS,
                units: problem.settings.effective().units(),
                start,
                grown: "a growing wave has left the linear range, or --amplitude is large: choose fewer --steps or a smaller --amplitude",
            },
            stepper,
            integrator,
            cells,
            seeding,
            tolerance: question.tolerance,
            wave,
        })
    }

    /// Both rates of the wave as they appear in its record; for a traveling wave the rate with positive frequency comes first.
    pub(super) fn rates(&self) -> [Complex; 2] {
        let rates = self.wave.rates(self.course.step, self.course.sampling);
        match rates[0].im.abs() > 1e-9 * rates[0].norm() {
            true => {
                let first = Complex::new(rates[0].re, rates[0].im.abs());
                [first, first.conj()]
            }
            false => rates,
        }
    }
}

/// Returns true if the wave is a translation of the whole patch.
fn is_translation(wave: &PatchWave) -> bool {
    wave.has_zero_energy && wave.turns.iter().all(|turns| *turns == 0)
}

/// Wave that is seeded or measured.
fn chosen(
    problem: &Problem,
    question: &Question,
    patch: &dyn PatchMotion,
    cells: &[usize],
) -> Result<PatchWave, SimulateError> {
    let waves = patch.waves();
    let turns = match &question.seeded {
        Seeded::Wave(k) => turns_of(problem, k, cells)?,
        Seeded::Turns(turns) => turns.clone(),
        Seeded::Critical | Seeded::Noise => {
            if question.branch != 1 {
                return Err(refused(
                    "--branch has no effect if the wave is not given",
                    "give --wave-vector or --turns with it",
                ));
            }
            let mut moving: Vec<&PatchWave> =
                waves.iter().filter(|wave| !is_translation(wave)).collect();
            moving.sort_by(|a, b| a.omega_squared.re.total_cmp(&b.omega_squared.re));
            let softest = moving.into_iter().find(|wave| patch.sees(wave));
            return softest.cloned().ok_or_else(|| {
                refused(
                    "the only wave of the patch is its translation",
                    "choose more --cells",
                )
            });
        }
    };
    if turns.len() != cells.len() {
        return Err(refused(
            format!(
                "--turns has {} numbers; expected {}",
                turns.len(),
                cells.len()
            ),
            "one for each side of the patch, for example 1,0",
        ));
    }
    let folded = |sign: i64| -> Vec<usize> {
        let pairs = turns.iter().zip(cells);
        pairs
            .map(|(turns, n)| (sign * turns).rem_euclid(*n as i64) as usize)
            .collect()
    };
    let (own, opposite) = (folded(1), folded(-1));
    let of_it: Vec<&PatchWave> = waves
        .iter()
        .filter(|wave| wave.turns == own || wave.turns == opposite)
        .collect();
    let found = of_it.iter().find(|wave| wave.branch == question.branch);
    if found.is_some_and(|wave| is_translation(wave)) {
        return Err(refused(
            "with this wave vector the patch moves as a rigid body, or particles move without any force",
            "choose a finite wavelength: --turns 1,0 for example",
        ));
    }
    if found.is_some_and(|wave| !patch.sees(wave)) {
        return Err(refused(
            "this wave has no effect on material points: it moves nodes, but neither displaces nor strains a point",
            "choose another --wave-vector, or more points in a cell (discretization.points-per-side)",
        ));
    }
    found.map(|wave| (*wave).clone()).ok_or_else(|| {
        refused(
            format!("there is no branch {}", question.branch),
            format!(
                "branches are counted from 1 to {} by increasing omega^2",
                of_it.len()
            ),
        )
    })
}

/// Number of wavelengths along each side of the patch.
fn turns_of(problem: &Problem, k: &[f64], cells: &[usize]) -> Result<Vec<i64>, SimulateError> {
    if k.len() != cells.len() {
        return Err(refused(
            format!(
                "--wave-vector has {} numbers; expected {}",
                k.len(),
                cells.len()
            ),
            "one for each dimension, for example 3.141592654,0",
        ));
    }
    let mut in_space = nalgebra::Vector3::zeros();
    in_space.iter_mut().zip(k).for_each(|(own, k)| *own = *k);
    let fractional = problem.analysis.fractional(&in_space);
    let turns: Vec<f64> = fractional
        .iter()
        .zip(cells)
        .map(|(own, n)| own * *n as f64)
        .collect();
    if turns
        .iter()
        .any(|turns| (turns - turns.round()).abs() > WAVE_VECTOR_TOLERANCE * turns.abs().max(1.0))
    {
        let reciprocal = problem.analysis.reciprocal();
        let mut nearest = nalgebra::Vector3::zeros();
        for ((turns, n), b) in turns.iter().zip(cells).zip(reciprocal) {
            nearest += b * (turns.round() / *n as f64);
        }
        return Err(refused(
            format!(
                "--wave-vector: the sides of the patch hold {} wavelengths, not whole numbers",
                vector(&turns)
            ),
            format!(
                "the nearest wave of a patch with these --cells is {}; or choose other --cells",
                nearest
                    .iter()
                    .take(cells.len())
                    .map(|x| exact(*x))
                    .collect::<Vec<_>>()
                    .join(",")
            ),
        ));
    }
    Ok(turns.iter().map(|turns| turns.round() as i64).collect())
}

/// Integrator of the question, or of the settings.
fn stepper_of(problem: &Problem, question: &Question) -> Result<Stepper, SimulateError> {
    match question.stepper {
        Some(stepper) => Ok(stepper),
        None => Ok(Stepper::of(problem.settings.explicit_integrator()?)),
    }
}

/// Time integration with its name.
fn stepped(
    problem: &Problem,
    question: &Question,
) -> Result<(Stepper, &'static str), SimulateError> {
    let stepper = stepper_of(problem, question)?;
    if !problem.analysis.is_transferred() {
        return Ok((stepper, stepper.name()));
    }
    let transfer = problem.settings.method.transfer.name();
    match question.stepper {
        None => Ok((stepper, transfer)),
        Some(_) => Err(refused(
            format!("--integrator has no effect: the {transfer} transfer defines the step"),
            "omit --integrator, or set discretization.transfer=continuous for equations in continuous time",
        )),
    }
}

fn step(
    problem: &Problem,
    question: &Question,
    critical: f64,
    wave: &PatchWave,
) -> Result<f64, SimulateError> {
    // Step of a transfer, as set by the study.
    let own = problem.settings.method.time_step;
    // A growing or traveling wave is resolved by at least `MIN_STEPS` steps.
    let resolved = natural(wave, wave.rate).map_or(f64::INFINITY, |time| time / MIN_STEPS);
    let step = match (question.pace.time_step, question.pace.fraction) {
        (Some(step), _) => step,
        (None, Some(fraction)) => fraction * critical,
        (None, None) if own > 0.0 => own,
        (None, None) => (DEFAULT_STEP_FRACTION * critical).min(resolved),
    };
    let stepper = stepper_of(problem, question)?;
    if critical == 0.0 && !(step > 0.0 && question.pace.is_supercritical) {
        return Err(refused(
            format!(
                "{} is unstable for every time step: waves without damping grow",
                stepper.name()
            ),
            "choose another --integrator; to see them grow, --time-step with --supercritical",
        ));
    }
    if !step.is_finite() {
        return Err(refused(
            "no wave of the patch oscillates, so that no largest stable step exists",
            "give --time-step",
        ));
    }
    stable(step, critical, question.pace.is_supercritical)
}

/// Returns the step, or an error if it is above the largest stable step without permission.
pub(super) fn stable(
    step: f64,
    critical: f64,
    is_supercritical: bool,
) -> Result<f64, SimulateError> {
    if step > critical * (1.0 + 1e-12) && !is_supercritical {
        return Err(refused(
            format!(
                "the step {} is {} of the largest stable step, {}: the fastest waves of the particles would grow for any material",
                told(step),
                told(step / critical),
                told(critical)
            ),
            "choose --fraction at most 1; to see them grow, --supercritical",
        ));
    }
    Ok(step)
}

/// Identifier of the checkpoints of a run: the first twelve digits of the SHA-256 sum of all its inputs.
pub(super) fn mark(decisive: &serde_json::Value) -> String {
    let sum = Sha256::digest(decisive.to_string().as_bytes());
    let digits = sum.iter().take(6).map(|byte| format!("{byte:02x}"));
    digits.collect()
}

/// Number of steps between lines of the history.
pub(super) fn every(asked: Option<u64>, steps: u64) -> Result<u64, SimulateError> {
    let every = asked.unwrap_or(steps.div_ceil(DEFAULT_LINES)).max(1);
    if steps / every > MAX_LINES {
        return Err(refused(
            format!("the history would have {} lines", steps / every),
            format!(
                "at most {MAX_LINES} are kept: choose --every {}",
                steps.div_ceil(MAX_LINES)
            ),
        ));
    }
    Ok(every)
}

/// Steps after which the given number of fields is written.
pub(super) fn fields(count: u64, steps: u64) -> Vec<u64> {
    let last = count.saturating_sub(1).max(1);
    let mut fields: Vec<u64> = (0..count)
        .map(|n| (u128::from(steps) * u128::from(n) / u128::from(last)) as u64)
        .collect();
    fields.dedup();
    fields
}

/// Default duration for a wave: a period, some e-folding times of growth, or one e-folding time of decay without oscillation.
///
/// `None` for zero-energy modes, which have no time scale. Time.
fn natural(wave: &PatchWave, rate: Complex) -> Option<f64> {
    let size = rate.norm();
    if size == 0.0 {
        return None;
    }
    let decays = rate.re < 0.0 && rate.im.abs() <= 1e-9 * size;
    match (wave.has_zero_energy, rate.re > 1e-9 * size) {
        (true, _) => None,
        (false, true) => Some(E_FOLDINGS / rate.re),
        (false, false) if decays => Some(-rate.re.recip()),
        (false, false) => Some(2.0 * PI / size),
    }
}

fn steps(question: &Question, wave: &SteppedWave, step: f64) -> Result<u64, SimulateError> {
    let count = match question.pace.duration {
        Duration::Steps(count) => return checked(count as f64, step),
        Duration::Time(time) => (time / step).round(),
        Duration::Natural => match natural(&wave.wave, wave.rates(step, 1)[0]) {
            Some(time) => (time / step).ceil().max(MIN_STEPS),
            None => ZERO_ENERGY_STEPS,
        },
    };
    checked(count, step)
}

/// Checked number of steps: at least one, and at most the limit.
pub(super) fn checked(count: f64, step: f64) -> Result<u64, SimulateError> {
    match count >= 1.0 && count <= MAX_STEPS as f64 {
        true => Ok(count as u64),
        false => Err(refused(
            format!("the run would take {count:e} steps of {step:e}"),
            format!(
                "choose --steps from 1 to {MAX_STEPS}, or another --time; stiff laws, penalties and contacts make steps small"
            ),
        )),
    }
}

/// Number of steps between samples, and number of samples.
fn sampled(wave: &SteppedWave, step: f64, steps: u64) -> (u32, u64) {
    let whole = |every: f64| every.floor().clamp(1.0, 1e9) as u32;
    if wave.wave.has_zero_energy {
        let every = whole(steps as f64 / MAX_SAMPLES as f64);
        return (every, (steps / u64::from(every)).min(MAX_SAMPLES));
    }
    let phase = wave.factors[0].arg().abs();
    let growth = wave.factors[0].norm().ln().abs();
    // A wave whose phase advances by more than a quarter period per step is sampled in every second step.
    let every = match (phase > 0.5 * PI, phase > growth) {
        (true, _) => 2,
        (false, true) => whole(2.0 * PI / (SAMPLES_PER_PERIOD * phase)),
        (false, false) => whole(1.0 / (SAMPLES_PER_E_FOLDING * growth)),
    };
    let rate = wave.rates(step, every)[0];
    let samples = (steps / u64::from(every)).min(MAX_SAMPLES);
    if rate.re <= rate.im.abs() {
        return (every, samples);
    }
    let grown = (E_FOLDINGS / (rate.re * step * f64::from(every))).ceil();
    (every, samples.min(grown as u64))
}
