//! A case: one wave of one state, with all data needed to read its output.

use super::prediction::{mode, predicted};
use super::{Block, Code, Deck, Prediction, VerifyError};
use crate::answers::{Problem, ProblemError};
use crate::csv::Table;
use crate::input;
use crate::json;
use crate::number::{exact, vector};
use crate::output::{Files, text};
use crate::settings::{Family, Settings, Units};
use onset::algebra::Complex;
use onset::kinematics::DeformationGradient;
use onset::time_step::{Integrator, Stepping};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::f64::consts::TAU;
use std::fmt;
use std::path::Path;

/// Name of the case file, written next to the deck.
pub const CASE_FILE: &str = "case.json";

/// Name and version of the file format, written to case files.
const FORMAT: &str = "onset verify 1";

/// Wave to be run, and the duration of the run.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// Stretches along the axes.
    pub stretches: [f64; 3],
    /// Reference wave vector; 1/length.
    pub wave_vector: Vec<f64>,
    /// Branch, counted from 1 by increasing `omega^2`.
    pub branch: usize,
    /// Time step; `None` for a default step that resolves the wave and its neighbors.
    pub time_step: Option<f64>,
    /// Number of time steps; `None` for one period or four e-folding times.
    pub steps: Option<usize>,
    /// Relative difference of rates that counts as agreement; `None` for the tolerance of the code.
    pub tolerance: Option<f64>,
    /// Time integration, for codes whose integrator is known only to the user.
    pub stepping: Option<Stepping>,
}

/// One plane wave of one homogeneous state, to be run in a code.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Name and version of the file format.
    pub format: String,
    /// Identifier in decks and outputs: the first twelve digits of the SHA-256 sum of the file with an empty identifier.
    pub id: String,
    /// Name of the code.
    pub code: String,
    /// Stretches of the homogeneous state along the axes.
    pub stretches: [f64; 3],
    /// Reference wave vector; 1/length.
    pub wave_vector: Vec<f64>,
    /// Reference density; mass/volume.
    pub density: f64,
    /// Block of particles in the deck.
    pub block: Block,
    /// Whether the block is periodic; otherwise its rim is held.
    pub is_periodic: bool,
    /// Interaction range at the state; length.
    pub reach: f64,
    /// Largest velocity of the seed; length/time.
    pub speed: f64,
    /// Time step of the run; time.
    pub time_step: f64,
    /// Number of time steps of the run.
    pub steps: usize,
    /// Number of time steps between frames.
    pub every: usize,
    /// Predicted rates and polarization.
    pub prediction: Prediction,
    /// Relative difference of rates that counts as agreement.
    pub tolerance: f64,
    /// All settings in effect.
    pub settings: serde_json::Value,
}

/// Largest number of particles in a deck.
const MAX_PARTICLES: usize = 40_000;
/// Largest number of frames in an output.
const MAX_FRAMES: usize = 400;
/// Smallest number of time steps if the program chooses the step.
const MIN_STEPS_RESOLVED: f64 = 160.0;
/// Smallest number of time steps if the user sets the step. With more steps a growing wave would leave the linear range.
const MIN_STEPS_GIVEN: f64 = 48.0;
/// Relative tolerance of a wave vector that fits a periodic block, in units of the reciprocal vector; allows for the rounding of typed numbers.
const WAVE_VECTOR_TOLERANCE: f64 = 1e-6;
/// Half the width of the measured core, in particle spacings.
const HALF_CORE_SPACINGS: f64 = 9.0;
/// Safety factor on the speed of the fastest wave, for signals from the rim.
const SPEED_SAFETY_FACTOR: f64 = 2.0;

impl Case {
    /// Writes a case and the files of its deck.
    ///
    /// # Errors
    /// [`VerifyError`] for a problem beyond the capabilities of the code, or a wave that cannot be measured.
    pub fn new(
        code: &dyn Code,
        settings: Settings,
        question: &Question,
    ) -> Result<(Self, Files), VerifyError> {
        settings.material.check_moves()?;
        let problem = Problem::new(settings)?;
        let f = DeformationGradient::from_stretches(question.stretches)?;
        if problem.analysis.is_transferred() {
            return Err(VerifyError::Wave {
                what: "discretization.transfer: predictions are for waves of the nodes, and decks would place particles".to_owned(),
                hint: "omit discretization.transfer, or evaluate the method with `onset state`".to_owned(),
            });
        }
        let dimension = problem.dimension();
        if question.wave_vector.len() != dimension {
            return Err(VerifyError::Problem(ProblemError::Numbers {
                what: "--wave-vector",
                hint: String::new(),
                given: question.wave_vector.len(),
                expected: dimension.to_string(),
            }));
        }
        let stepping = match question.stepping {
            Some(stepping) => stepping,
            None => code.stepping(&problem, &f)?,
        };
        let sides = sides(code, &problem)?;
        let reach = reach(&problem.settings, question.stretches);
        let critical = problem
            .analysis
            .critical_time_step(&f, Integrator::KickDriftKick)?;
        let typed = mode(
            &problem,
            &f,
            &question.wave_vector,
            question.branch,
            critical,
        )?;
        let rate = typed.omega_squared.abs().sqrt();
        let is_growing = typed.omega_squared < 0.0;
        let (time_step, steps) = steps(question, rate, is_growing, critical)?;
        let duration = time_step * steps as f64;
        let rim = code.rim(&problem, &f)?;
        let (block, k) = match rim {
            None => periodic(&sides, question, reach)?,
            Some(width) => {
                // The larger of the speed of sound and the speed of the shortest waves, which is half their frequency times the spacing.
                let sound = sound(&problem, &f, &sides)?;
                let fastest = sound.max(problem.analysis.spacing() / critical);
                let apart = SPEED_SAFETY_FACTOR * fastest * duration + 2.0 * reach;
                (
                    held(&sides, apart, width * reach),
                    question.wave_vector.clone(),
                )
            }
        };
        if block.particles() > MAX_PARTICLES {
            return Err(VerifyError::Wave {
                what: format!(
                    "the block has {} particles, more than {MAX_PARTICLES}: waves from its rim must not arrive before the end",
                    block.particles()
                ),
                hint: "choose fewer --steps, or a smaller --time-step".to_owned(),
            });
        }
        let wave = mode(&problem, &f, &k, question.branch, critical)?;
        let prediction = predicted(&problem, &f, &k, wave, stepping, time_step)?;
        let amplitude = if is_growing { 1e-7 } else { 1e-6 };
        let settings = serde_json::to_value(problem.settings.effective());
        let mut case = Self {
            format: FORMAT.to_owned(),
            id: String::new(),
            code: code.name().to_owned(),
            stretches: question.stretches,
            wave_vector: k,
            density: problem.settings.discretization.density,
            block,
            is_periodic: rim.is_none(),
            reach,
            speed: amplitude * rate * problem.analysis.spacing(),
            time_step,
            steps,
            every: steps.div_ceil(MAX_FRAMES),
            prediction,
            tolerance: question.tolerance.unwrap_or(code.tolerance()),
            settings: settings.unwrap_or_default(),
        };
        case.id = mark(&case.document());
        let mut files = code.deck(&Deck {
            case: &case,
            problem: &problem,
            f: &f,
        })?;
        files.push(text(CASE_FILE, case.document()));
        Ok((case, files))
    }

    /// Reads a case file.
    ///
    /// # Errors
    /// [`VerifyError`] if the file cannot be read, is not a case, or was changed since it was written.
    pub fn of_file(path: &Path) -> Result<Self, VerifyError> {
        let text =
            input::text(path, input::MOST_TEXT).map_err(|source| VerifyError::Unreadable {
                path: path.to_owned(),
                source,
            })?;
        let wrong = |what: String| VerifyError::Case {
            path: path.to_owned(),
            what,
        };
        let case: Self = serde_json::from_str(&text).map_err(|error| {
            wrong(format!(
                "this is not a case of `onset verify`: line {}",
                error.line()
            ))
        })?;
        if case.format != FORMAT {
            return Err(wrong(format!(
                "the format is {}; expected {FORMAT}",
                onset_frames::cut(&case.format)
            )));
        }
        let unmarked = text.replacen(&format!("\"{}\"", case.id), "\"\"", 1);
        if mark(&unmarked) != case.id {
            return Err(wrong(
                "the case has changed since its deck was written".to_owned(),
            ));
        }
        Ok(case)
    }

    fn document(&self) -> String {
        json::document(self).unwrap_or_default()
    }

    /// Smallest particle spacing in the reference configuration; length.
    pub fn spacing(&self) -> f64 {
        self.block
            .sides
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min)
    }

    /// Position of a particle in the homogeneous state; length.
    pub fn place(&self, index: usize) -> [f64; 3] {
        let reference = self.block.reference(index);
        std::array::from_fn(|i| reference[i] * self.stretches[i])
    }

    /// Edge lengths of the periodic block at the state.
    pub fn lengths(&self) -> Vec<f64> {
        let axes = self.block.counts.iter().zip(&self.block.sides);
        let lengths = axes.zip(self.stretches);
        lengths
            .map(|((count, side), stretch)| *count as f64 * side * stretch)
            .collect()
    }

    /// Wave amplitude `cos(k.X)` at a particle.
    pub fn phase(&self, index: usize) -> f64 {
        let reference = self.block.reference(index);
        let along = self.wave_vector.iter().zip(reference);
        along.map(|(k, x)| k * x).sum::<f64>().cos()
    }

    /// Velocity of a particle that seeds the wave; length/time.
    pub fn seed(&self, index: usize) -> [f64; 3] {
        let size = self.speed * self.phase(index);
        let mut velocity = [0.0; 3];
        for (own, g) in velocity.iter_mut().zip(&self.prediction.polarization) {
            *own = size * g;
        }
        velocity
    }

    /// Displacement of a particle from its homogeneous position, to the nearest image in a periodic block; length.
    pub fn displacement(&self, index: usize, position: &[f64; 3]) -> Vec<f64> {
        let place = self.place(index);
        let lengths = self.lengths();
        let along = |axis: usize| {
            let apart = position[axis] - place[axis];
            match self.is_periodic {
                true => apart - lengths[axis] * (apart / lengths[axis]).round(),
                false => apart,
            }
        };
        (0..self.block.dimension()).map(along).collect()
    }

    /// Rate of the solution with the larger growth, or with positive frequency.
    pub fn rate(&self) -> Complex {
        self.prediction.rates[0].into()
    }

    /// Number of frames of a complete output.
    pub fn frames(&self) -> usize {
        self.steps / self.every + 1
    }
}

impl Case {
    /// The case as CSV, in one row.
    pub fn csv(&self) -> String {
        Table::new(std::slice::from_ref(self), Units::Own)
            .with("case", "1", |own| own.id.as_str())
            .with("code", "1", |own| own.code.as_str())
            .each("stretch", 3, "1", |own, n| own.stretches[n])
            .each(
                "wave_vector",
                self.wave_vector.len(),
                "1/length",
                |own, n| own.wave_vector[n],
            )
            .with("omega_squared", "1/time^2", |own| {
                own.prediction.omega_squared
            })
            .with("growth", "1/time", |own| own.prediction.rates[0].growth)
            .with("frequency", "1/time", |own| {
                own.prediction.rates[0].frequency
            })
            .with("time_step", "time", |own| own.time_step)
            .with("steps", "1", |own| own.steps)
            .with("every", "1", |own| own.every)
            .to_string()
    }
}

impl fmt::Display for Case {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, second] = &self.prediction.rates;
        writeln!(formatter, "code         {}, case {}", self.code, self.id)?;
        writeln!(
            formatter,
            "wave         k = {}, polarization {}, stretches {}",
            vector(&self.wave_vector),
            vector(&self.prediction.polarization),
            vector(&self.stretches)
        )?;
        writeln!(
            formatter,
            "omega^2      {:.9}",
            self.prediction.omega_squared
        )?;
        match first.is_growth() {
            true => writeln!(
                formatter,
                "predicted    growth rates {:.9} and {:.9}",
                first.growth, second.growth
            )?,
            false => writeln!(
                formatter,
                "predicted    frequency {:.9}, growth rate {:+.3e}",
                first.frequency, first.growth
            )?,
        }
        let counts: Vec<String> = self.block.counts.iter().map(usize::to_string).collect();
        let rim = if self.is_periodic {
            "periodic"
        } else {
            "with a held rim"
        };
        writeln!(
            formatter,
            "block        {} particles, {rim}",
            counts.join(" x ")
        )?;
        write!(
            formatter,
            "run          {} steps of {} ({})",
            self.steps,
            exact(self.time_step),
            self.prediction.stepping.name()
        )
    }
}

/// Identifier of a case, computed from its unmarked text.
fn mark(unmarked: &str) -> String {
    let sum = Sha256::digest(unmarked.as_bytes());
    sum.iter()
        .take(6)
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

/// Sides of the lattice cell, which must be orthogonal with one particle.
fn sides(code: &dyn Code, problem: &Problem) -> Result<Vec<f64>, VerifyError> {
    let reciprocal = problem.analysis.reciprocal();
    let is_orthogonal = reciprocal.iter().enumerate().all(|(i, b)| {
        let along = b[i];
        along > 0.0 && (0..3).all(|j| j == i || b[j].abs() <= 1e-12 * along)
    });
    if !is_orthogonal || problem.analysis.sites() != 1 {
        return Err(VerifyError::Refused {
            code: code.name(),
            what: format!(
                "decks are blocks of a lattice along the axes, not {}",
                problem.settings.zone().name()
            ),
            hint: "set discretization.lattice to chain, square, rectangular or simple-cubic, without basis and perturbation"
                .to_owned(),
        });
    }
    Ok(reciprocal
        .iter()
        .enumerate()
        .map(|(i, b)| TAU / b[i])
        .collect())
}

/// Largest speed of sound along the axes, in the reference configuration or at a state; length/time.
fn sound(problem: &Problem, f: &DeformationGradient, sides: &[f64]) -> Result<f64, VerifyError> {
    let mut fastest = 0.0_f64;
    for state in [DeformationGradient::identity(), *f] {
        let waves = problem.analysis.waves(&state)?;
        for (axis, side) in sides.iter().enumerate() {
            let mut k = vec![0.0; sides.len()];
            k[axis] = side.recip();
            let squares = waves.continuum_omega_squared(&k).into_iter();
            let largest = squares.fold(0.0, f64::max);
            fastest = fastest.max(largest.sqrt() * side);
        }
    }
    Ok(fastest)
}

/// Interaction range at a state; length.
fn reach(settings: &Settings, stretches: [f64; 3]) -> f64 {
    let spacing = settings.discretization.spacing;
    let stretch = stretches.iter().copied().fold(1.0, f64::max);
    match settings.method.method {
        Family::Peridynamics => stretch * spacing * (settings.method.horizon + 0.5),
        Family::UpdatedSph => spacing * settings.discretization.support,
        _ => stretch * spacing * settings.discretization.support,
    }
}

/// Time step and number of steps; the duration is slightly less than a period, or four e-folding times.
///
/// # Errors
/// [`VerifyError::Wave`] for a number of steps that are not stable.
fn steps(
    question: &Question,
    rate: f64,
    is_growing: bool,
    critical: f64,
) -> Result<(f64, usize), VerifyError> {
    let duration = if is_growing { 4.0 } else { 5.0 } / rate;
    Ok(match (question.time_step, question.steps) {
        (Some(step), Some(count)) => (step, count),
        (Some(step), None) => (step, (duration / step).ceil().max(MIN_STEPS_GIVEN) as usize),
        (None, count) => {
            let fewest = (duration / (0.1 * critical)).ceil().max(MIN_STEPS_RESOLVED) as usize;
            let count = count.unwrap_or(fewest);
            let step = duration / count as f64;
            if step >= critical {
                return Err(VerifyError::Wave {
                    what: format!(
                        "--steps {count}: a run of {} in {count} steps is unstable, because the critical step is {}",
                        exact(duration),
                        exact(critical)
                    ),
                    hint: format!("omit --steps for {fewest} steps, or set --time-step"),
                });
            }
            (step, count)
        }
    })
}

/// Smallest periodic block that contains a whole number of wavelengths, with the wave vector that fits it.
fn periodic(
    sides: &[f64],
    question: &Question,
    reach: f64,
) -> Result<(Block, Vec<f64>), VerifyError> {
    let most = [4096, 128, 24][sides.len() - 1];
    let mut fitted = question.wave_vector.clone();
    let mut counts = Vec::new();
    for (axis, side) in sides.iter().enumerate() {
        let current = side * question.stretches[axis];
        let fewest = ((2.2 * reach / current).ceil() as usize + 1).max(8);
        let turns = |count: usize| question.wave_vector[axis] * side * count as f64 / TAU;
        let fits = |count: &usize| {
            let turns = turns(*count);
            (turns - turns.round()).abs() <= WAVE_VECTOR_TOLERANCE * *count as f64
        };
        let Some(count) = (fewest..=most).find(fits) else {
            return Err(VerifyError::Wave {
                what: format!(
                    "no periodic block of {fewest} to {most} particles along axis {} holds a whole number of wavelengths",
                    axis + 1
                ),
                hint: format!(
                    "choose a component that is a fraction of {:.9}, such as {:.9}",
                    TAU / side,
                    TAU / side / 5.0
                ),
            });
        };
        fitted[axis] = turns(count).round() * TAU / (side * count as f64);
        counts.push(count);
    }
    let block = Block {
        measured: counts.iter().map(|count| [0, *count]).collect(),
        sides: sides.to_vec(),
        counts,
    };
    Ok((block, fitted))
}

/// Block with a rim so wide that signals from it do not reach the core during the run.
fn held(sides: &[f64], apart: f64, reach: f64) -> Block {
    let mut block = Block {
        counts: Vec::new(),
        sides: sides.to_vec(),
        measured: Vec::new(),
    };
    let smallest = sides.iter().copied().fold(f64::INFINITY, f64::min);
    for side in sides {
        let core = (2.0 * HALF_CORE_SPACINGS * smallest / side).round() as usize;
        let margin = ((apart + reach) / side).ceil() as usize + 1;
        block.counts.push(core + 2 * margin);
        block.measured.push([margin, margin + core]);
    }
    block
}
