//! Comparison of a run with its prediction.

use super::checkpoint::Progress;
use super::plan::{COLUMNS, Plan};
use super::{Question, Seeded};
use crate::answers::{Problem, notes_on_patch};
use crate::csv::Table;
use crate::number::{counted, told, told_of, vector};
use crate::settings::{Effective, Units};
use crate::verify::{Rate, compared, fitted, fitted_alone};
use nalgebra::{Matrix3, Vector3};
use onset::motion::PatchMotion;
use serde::Serialize;
use std::fmt;
use std::path::PathBuf;

pub use crate::verify::Outcome;

/// Measured rate of a wave.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Rate of the fitted solution; 1/time.
    pub rate: Rate,
    /// Difference from the predicted rate, relative to that rate; for a zero-energy mode, relative to the largest frequency of the patch.
    pub difference: f64,
    /// Uncertainty of the rate, relative to the scale of `difference`.
    pub uncertainty: f64,
    /// Root mean square of the residual, divided by the largest amplitude of the record.
    pub residual: f64,
    /// Number of samples in the record.
    pub samples: usize,
}

/// Results of a run against its prediction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SimulateAnswer {
    /// Outcome of the comparison.
    pub outcome: Outcome,
    /// Reason if undecided; empty otherwise.
    pub reason: String,
    /// Whether the run was interrupted.
    pub interrupted: bool,
    /// Kind of the initial perturbation: `wave`, `critical` or `noise`.
    pub mode: &'static str,
    /// Number of cells along each primitive vector.
    pub cells: Vec<usize>,
    /// Number of particles in the patch.
    pub particles: usize,
    /// Deformation gradient of the homogeneous state.
    pub deformation_gradient: [[f64; 3]; 3],
    /// Reference wave vector of the measured wave; 1/length.
    pub wave_vector: Vec<f64>,
    /// Branch of the measured wave, counted from 1 by increasing `omega^2`.
    pub branch: usize,
    /// `omega^2` of the linearized equations, real and imaginary part; 1/time^2.
    pub omega_squared: [f64; 2],
    /// Whether the wave is a zero-energy mode.
    pub has_zero_energy: bool,
    /// Name of the integrator.
    pub integrator: &'static str,
    /// Time step of the run; time.
    pub time_step: f64,
    /// Largest stable time step for the waves of the patch; time.
    pub critical_time_step: f64,
    /// Number of steps requested.
    pub steps: u64,
    /// Number of steps taken.
    pub steps_taken: u64,
    /// Rate in continuous time; 1/time.
    pub continuous: Rate,
    /// Rate in discrete time, as it appears in the record; 1/time.
    pub predicted: Rate,
    /// Measured rate, or `None` if the record does not determine one.
    pub measured: Option<Measured>,
    /// Largest relative difference that counts as agreement.
    pub tolerance: f64,
    /// Largest change of the energy in the history, divided by the largest sum of the magnitudes of kinetic and potential energy.
    pub energy_drift: f64,
    /// Largest displacement of a particle from the homogeneous state in the history; length.
    pub largest_displacement: f64,
    /// Notes on law and method.
    pub notes: Vec<String>,
    /// All settings in effect.
    pub settings: Effective,
    /// Paths of the files written.
    #[serde(skip)]
    pub files: Vec<PathBuf>,
    /// Times and amplitudes of the record.
    #[serde(skip)]
    pub(super) samples: Vec<[f64; 2]>,
}

impl SimulateAnswer {
    pub(super) fn new(
        problem: &Problem,
        question: &Question,
        plan: &Plan,
        patch: &dyn PatchMotion,
        progress: &Progress,
    ) -> Self {
        let wave = &plan.wave.wave;
        let rates = plan.rates();
        let (outcome, reason, measured) = match (wave.has_zero_energy, &question.seeded) {
            (true, Seeded::Noise) => undecided(
                "the wave has zero energy, and the noise excites it through the other waves; omit --mode noise to seed it alone".to_owned(),
            ),
            (true, _) => standing(plan, patch, progress),
            (false, _) => moving(plan, progress),
        };
        let largest = |all: &mut dyn Iterator<Item = f64>| all.fold(0.0_f64, f64::max);
        let lines = || progress.history.chunks_exact(COLUMNS.len());
        let displacement = largest(&mut lines().map(|line| line[8]));
        let (outcome, reason) = match outcome {
            Outcome::Agrees => (outcome, reason),
            _ => {
                let moved = displacement / problem.analysis.spacing();
                let is_noise = question.seeded == Seeded::Noise
                    && measured
                        .as_ref()
                        .is_some_and(|own| own.difference < NOISE_RATE_TOLERANCE);
                explained((outcome, reason), plan, patch, moved, is_noise)
            }
        };
        let energies = lines().map(|line| line[4]);
        let first = lines().next().map_or(0.0, |line| line[4]);
        let size = largest(&mut lines().map(|line| line[2].abs() + line[3].abs()));
        let changed = largest(&mut energies.map(|energy| (energy - first).abs()));
        let mut continuous = Rate::from(wave.rate);
        if wave.has_zero_energy {
            continuous = Rate::default();
        }
        Self {
            outcome,
            reason,
            interrupted: false,
            mode: plan.seeding,
            cells: plan.cells.clone(),
            particles: patch.positions().len(),
            deformation_gradient: *problem.found(&question.f).components(),
            wave_vector: wave.wave_vector.clone(),
            branch: wave.branch,
            omega_squared: [wave.omega_squared.re, wave.omega_squared.im],
            has_zero_energy: wave.has_zero_energy,
            integrator: plan.integrator,
            time_step: plan.course.step,
            critical_time_step: plan.course.critical,
            steps: plan.course.steps,
            steps_taken: progress.state.step,
            continuous,
            predicted: match wave.has_zero_energy {
                true => Rate::default(),
                false => rates[0].into(),
            },
            measured,
            tolerance: plan.tolerance,
            energy_drift: if size > 0.0 { changed / size } else { 0.0 },
            largest_displacement: displacement,
            notes: notes_on_patch(&problem.settings, &*problem.material),
            settings: problem.settings.effective(),
            files: Vec::new(),
            samples: progress.samples.clone(),
        }
    }
}

/// Largest displacement in the range of the linearized equations, in particle spacings.
const SMALL_DISPLACEMENT_SPACINGS: f64 = 0.01;
/// Largest relative difference of a rate measured in noise that can be attributed to the other waves.
const NOISE_RATE_TOLERANCE: f64 = 0.01;
/// Smallest number of samples in a record.
const MIN_SAMPLES: usize = 16;

type Verdict = (Outcome, String, Option<Measured>);

fn undecided(reason: String) -> Verdict {
    (Outcome::Undecided, reason, None)
}

/// Replaces disagreement by an undecided outcome if the run does not test the linearized equations.
///
/// The linearized equations are not tested if displacements are large, if the perturbation is noise, or if faster growing waves dominate the measured
/// wave.
fn explained(
    (outcome, reason): (Outcome, String),
    plan: &Plan,
    patch: &dyn PatchMotion,
    displacement: f64,
    is_noise: bool,
) -> (Outcome, String) {
    let rate = plan.wave.wave.rate.re;
    let others = patch.waves().iter().filter(|wave| !wave.has_zero_energy);
    let others = others.map(|wave| wave.rate.re);
    let fastest = others.fold(0.0, f64::max);
    let overrun = match fastest > rate + 1e-6 * fastest {
        true => format!(
            "; other waves of the patch grow at up to {} and dominate it: choose a shorter --time",
            told(fastest)
        ),
        false => String::new(),
    };
    if displacement > SMALL_DISPLACEMENT_SPACINGS {
        return (
            Outcome::Undecided,
            format!(
                "the particles have moved by up to {} spacings, beyond the linear range: choose a smaller --amplitude or --time{overrun}",
                told(displacement)
            ),
        );
    }
    match outcome {
        Outcome::Differs if is_noise => (
            Outcome::Undecided,
            format!(
                "with noise the record also contains other waves of the patch: choose a longer --time, or seed the wave alone{overrun}"
            ),
        ),
        _ if reason.is_empty() => (outcome, reason),
        _ => (outcome, reason + &overrun),
    }
}

/// Outcome for a wave that travels, grows or decays: compares its fitted rates with the prediction.
fn moving(plan: &Plan, progress: &Progress) -> Verdict {
    let rates = plan.rates();
    let samples: Vec<(f64, f64)> = progress.samples.iter().map(|[t, y]| (*t, *y)).collect();
    if (samples.len() as u64) < plan.course.samples {
        return undecided("the run ended before the end of the record".to_owned());
    }
    if samples.len() < MIN_SAMPLES {
        return undecided(format!(
            "the record has {}, too few to fit a rate: run more steps, or smaller steps",
            counted(samples.len(), "sample")
        ));
    }
    let fit = match plan.wave.is_alone {
        true => fitted_alone(&samples, rates[0].re),
        false => fitted(&samples, rates, &[]),
    };
    let fit = match fit {
        Ok(fit) => fit,
        Err(error) => return undecided(error.to_string()),
    };
    let scale = rates[0].norm();
    let measured = Measured {
        rate: fit.rate.into(),
        difference: (fit.rate - rates[0]).norm() / scale,
        uncertainty: fit.uncertainty / scale,
        residual: fit.residual,
        samples: samples.len(),
    };
    let (outcome, reason) = compared(
        fit.residual,
        measured.difference,
        measured.uncertainty,
        plan.tolerance,
    );
    (outcome, reason, Some(measured))
}

/// Outcome for a zero-energy mode, whose amplitude stays constant.
///
/// A rate `s` would give the record curvature: `y = y0 (1 + s^2 t^2 / 2)`. Rates are in units of the largest frequency of the patch.
fn standing(plan: &Plan, patch: &dyn PatchMotion, progress: &Progress) -> Verdict {
    let samples = &progress.samples;
    let (Some([_, first]), Some([end, _])) = (samples.first(), samples.last()) else {
        return undecided("there is no record".to_owned());
    };
    if samples.len() < MIN_SAMPLES || *first == 0.0 {
        return undecided("the record is too short, or nothing moves".to_owned());
    }
    let row = |t: f64| Vector3::new(1.0, t / end, (t / end).powi(2));
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for [t, y] in samples {
        normal += row(*t) * row(*t).transpose();
        right += row(*t) * (y / first);
    }
    let Some(inverse) = normal.try_inverse() else {
        return undecided("the record does not determine a rate".to_owned());
    };
    let found = inverse * right;
    let left = samples
        .iter()
        .map(|[t, y]| (y / first - row(*t).dot(&found)).powi(2));
    let variance = left.sum::<f64>() / (samples.len() - 3) as f64;
    let waves = patch.waves().iter();
    let fastest = waves
        .map(|wave| wave.omega_squared.norm())
        .fold(0.0, f64::max)
        .sqrt();
    let of = |square: f64| (2.0 * square.abs()).sqrt() / end;
    let rate = of(found[2]);
    let measured = Measured {
        rate: Rate {
            growth: if found[2] > 0.0 { rate } else { 0.0 },
            frequency: if found[2] > 0.0 { 0.0 } else { rate },
        },
        difference: rate / fastest,
        uncertainty: of(4.0 * (variance * inverse[(2, 2)]).sqrt()) / fastest,
        residual: variance.sqrt(),
        samples: samples.len(),
    };
    let (outcome, reason) = compared(
        measured.residual,
        measured.difference,
        measured.uncertainty,
        plan.tolerance,
    );
    (outcome, reason, Some(measured))
}

/// Formats a rate; growth below the given fraction of the rate is printed as zero.
pub(super) fn rate_in_words(rate: &Rate, share: f64, units: Units) -> String {
    let size = rate.growth.hypot(rate.frequency);
    let growth = || {
        let growth = match rate.growth.abs() <= share * size {
            true => 0.0,
            false => rate.growth,
        };
        units.of(told_of(growth, size), "1/s")
    };
    match rate.is_growth() {
        _ if *rate == Rate::default() => "zero".to_owned(),
        true => format!("growth rate {}", growth()),
        false => format!(
            "frequency {}, growth rate {}",
            units.of(told(rate.frequency), "rad/s"),
            growth()
        ),
    }
}

/// Formats a relative error; rounding errors are printed as zero.
fn size(error: f64) -> String {
    match error <= 4.0 * f64::EPSILON {
        true => "0".to_owned(),
        false => format!("{error:.1e}"),
    }
}

/// Formats a deformation gradient as stretches, or as rows if it is not diagonal.
fn state(f: &[[f64; 3]; 3]) -> String {
    let is_diagonal = (0..3).all(|i| (0..3).all(|j| i == j || f[i][j] == 0.0));
    match is_diagonal {
        true => format!("stretches {}", vector(&[f[0][0], f[1][1], f[2][2]])),
        false => format!("F = [{}]", f.map(|row| vector(&row)).join(", ")),
    }
}

impl SimulateAnswer {
    /// Amplitude of the wave over time as CSV.
    pub fn amplitude_csv(&self) -> String {
        Table::new(&self.samples, self.settings.units())
            .with("time", "time", |[time, _]| *time)
            .with("amplitude", "length", |[_, amplitude]| *amplitude)
            .to_string()
    }

    /// Predicted and measured rate as CSV, in one row.
    pub fn csv(&self) -> String {
        let measured = |own: &Self, value: fn(&Measured) -> f64| own.measured.as_ref().map(value);
        Table::new(std::slice::from_ref(self), self.settings.units())
            .with("outcome", "1", |own| own.outcome.name())
            .with("particles", "1", |own| own.particles)
            .tensor("F", "1", |own| &own.deformation_gradient)
            .each(
                "wave_vector",
                self.wave_vector.len(),
                "1/length",
                |own, n| own.wave_vector[n],
            )
            .with("branch", "1", |own| own.branch)
            .with("omega_squared_re", "1/time^2", |own| own.omega_squared[0])
            .with("omega_squared_im", "1/time^2", |own| own.omega_squared[1])
            .with("time_step", "time", |own| own.time_step)
            .with("critical_time_step", "time", |own| own.critical_time_step)
            .with("steps_taken", "1", |own| own.steps_taken)
            .with("predicted_growth", "1/time", |own| own.predicted.growth)
            .with("predicted_frequency", "1/time", |own| {
                own.predicted.frequency
            })
            .with("measured_growth", "1/time", move |own| {
                measured(own, |found| found.rate.growth)
            })
            .with("measured_frequency", "1/time", move |own| {
                measured(own, |found| found.rate.frequency)
            })
            .with("difference", "1", move |own| {
                measured(own, |found| found.difference)
            })
            .with("uncertainty", "1", move |own| {
                measured(own, |found| found.uncertainty)
            })
            .with("energy_drift", "1", |own| own.energy_drift)
            .with("largest_displacement", "length", |own| {
                own.largest_displacement
            })
            .to_string()
    }
}

impl fmt::Display for SimulateAnswer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let units = self.settings.units();
        writeln!(formatter, "outcome      {}", self.outcome.name())?;
        if !self.reason.is_empty() {
            writeln!(formatter, "             {}", self.reason)?;
        }
        writeln!(
            formatter,
            "state        {}",
            state(&self.deformation_gradient)
        )?;
        let cells: Vec<String> = self.cells.iter().map(usize::to_string).collect();
        writeln!(
            formatter,
            "patch        {} cells, {}, periodic; seeded: {}",
            cells.join(" x "),
            counted(self.particles, "particle"),
            self.mode
        )?;
        let [real, imaginary] = match self.has_zero_energy {
            true => [0.0; 2],
            false => self.omega_squared,
        };
        let imaginary = match told_of(imaginary, real) {
            zero if zero == "0" => String::new(),
            _ => format!(
                " {} {} i",
                if imaginary < 0.0 { "-" } else { "+" },
                told(imaginary.abs())
            ),
        };
        writeln!(
            formatter,
            "wave         k = {}, branch {}, omega^2 = {}",
            units.of(vector(&self.wave_vector), "1/m"),
            self.branch,
            units.of(format!("{}{imaginary}", told(real)), "1/s^2")
        )?;
        let share = match self.critical_time_step {
            0.0 => "no step is stable".to_owned(),
            critical => format!(
                "{} of the largest stable step",
                told(self.time_step / critical)
            ),
        };
        writeln!(
            formatter,
            "run          {} of {} steps of {} ({share}), {}",
            self.steps_taken,
            self.steps,
            units.of(told(self.time_step), "s"),
            self.integrator
        )?;
        writeln!(
            formatter,
            "linearized   {}",
            rate_in_words(&self.continuous, 0.0, units)
        )?;
        writeln!(
            formatter,
            "predicted    {}, in discrete time",
            rate_in_words(&self.predicted, 0.0, units)
        )?;
        if let Some(measured) = &self.measured {
            let is_standing = self.has_zero_energy && measured.difference <= measured.uncertainty;
            writeln!(
                formatter,
                "measured     {}",
                match (is_standing, self.has_zero_energy) {
                    (true, _) => "zero".to_owned(),
                    (_, true) => rate_in_words(&measured.rate, 0.0, units),
                    (_, false) => rate_in_words(&measured.rate, measured.uncertainty, units),
                }
            )?;
            writeln!(
                formatter,
                "difference   {} of the {}, uncertain by {}; tolerance {}",
                size(measured.difference),
                match self.has_zero_energy {
                    true => "largest frequency",
                    false => "rate",
                },
                size(measured.uncertainty),
                size(self.tolerance)
            )?;
        }
        writeln!(
            formatter,
            "energy       changes by the fraction {}; largest displacement {}",
            size(self.energy_drift),
            units.of(told(self.largest_displacement), "m")
        )?;
        for note in &self.notes {
            writeln!(formatter, "\nnote: {note}")?;
        }
        write!(formatter, "\n{}", self.settings)
    }
}
