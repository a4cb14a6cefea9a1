//! Answer of `onset screen`: the first cause of an instability in a run, with its evidence, its limits and the remedy.

use super::actual::Actual;
use super::checks::{Missing, is_on_lattice, layout, missing, points_per_side, recognized};
use super::course::{
    Course, ELLIPTIC_MARGIN, Event, Moment, Picture, Sink, StepLimit, crossing, follow, point,
};
use super::input::is_spaced;
use super::records::SoundFrames;
use super::remedy::{Remedy, controls, expected as expected_in, remedies};
use super::study::{command, study};
use super::{Frame, Question, Recording, Run, SAFETY_FACTOR, ScreenError};
use crate::answers::{Problem, StateAnswer, StateQuestion, notes};
use crate::brief::{Brief, Short};
use crate::csv::Table;
use crate::figure::{Axis, Figure, Line, Panel, Rule, palette};
use crate::json;
use crate::number::{counted, told, told_with};
use crate::output::{Files, picture, text};
use crate::settings::Effective;
use onset::kinematics::DeformationGradient;
use onset::verdict::Mechanism;
use serde::Serialize;
use std::fmt;

/// Relative error of the predicted limits; a step or a state closer to its limit counts as at the limit.
const LIMIT_TOLERANCE: f64 = 0.02;
/// Smallest growth exponent before the observation that explains short waves, even if they were expected later: strain gradients contribute to the
/// measured short waves, so that they may appear earlier.
const EXPLAINING_EXPONENT: f64 = 1.0;
/// Smallest growth exponent before the observation in a body that is then destroyed.
const DESTROYED_BODY_EXPONENT: f64 = 0.5;
/// Smallest amplitude of short waves that is not attributed to rounding of positions, in units of the last digit.
const ROUNDING_FACTOR: f64 = 2.0;
/// Ratio of short waves to the threshold at which a body is destroyed.
const DESTROYED_BODY_RATIO: f64 = 10.0;
/// Smallest growth ratio at which short waves below the threshold are considered to follow a prediction.
const RISE_RATIO: f64 = 10.0;
/// Largest delay of the predicted time after the observation, as a fraction of the time until the observation.
const LATENESS_FRACTION: f64 = 0.35;

/// Smallest length over which the strain varies by itself, in spacings, in a state that is homogeneous for the growing waves.
const VARIED_SPACINGS: f64 = 20.0;

/// Largest growth exponent between two frames at which times are interpolated reliably.
const LARGEST_INTERVAL_GROWTH: f64 = 2.0;

/// Smallest amplitude in the figure; spacings.
const SMALLEST_DRAWN_AMPLITUDE: f64 = 1e-8;

/// First cause of the instability of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cause {
    /// The material loses strong ellipticity.
    Physical,
    /// Waves of the discretization grow in a strongly elliptic material.
    Numerical,
    /// The time step exceeds the largest stable step.
    TimeStep,
    /// Short waves that no force resists.
    ZeroEnergy,
    /// Short waves that are not due to an instability: loads, contact, strain gradients.
    Forced,
    /// No short waves and no loss of ellipticity.
    None,
}

impl Cause {
    /// All causes, in the order of the numbers in output fields.
    pub const ALL: [Self; 6] = [
        Self::Physical,
        Self::Numerical,
        Self::TimeStep,
        Self::ZeroEnergy,
        Self::Forced,
        Self::None,
    ];

    /// Position in [`Cause::ALL`], as fields of output files contain it.
    pub(super) fn number(self) -> f64 {
        self as u8 as f64
    }

    /// Name in output documents and of `--fail-on`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Physical => "physical",
            Self::Numerical => "numerical",
            Self::TimeStep => "time-step",
            Self::ZeroEnergy => "zero-energy",
            Self::Forced => "forced",
            Self::None => "none",
        }
    }
}

/// Answer of `onset screen`: the first cause of an instability in a run, with its evidence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScreenAnswer {
    /// First cause of the instability.
    pub cause: Cause,
    /// Mechanism of a numerical instability; `None` for other causes.
    pub mechanism: Option<Mechanism>,
    /// Sentence with cause, time, position, numbers and remedy.
    pub sentence: String,
    /// Whether a change of the limit by 2 % would change the cause.
    pub at_the_limit: bool,
    #[serde(skip)]
    is_law_at_limit: bool,
    /// Position and time at which the cause begins; for a time step, at which it exceeds the largest stable step. `null` without a cause.
    pub first: Option<Event>,
    /// Time at which short waves are expected to become visible; `null` if they are not expected.
    pub expected: Option<f64>,
    /// First short waves above the threshold in the positions; `null` if all short waves stay below it.
    pub observed: Option<Event>,
    /// Wavelength of the fastest-growing wave in the reference configuration, in spacings; `null` unless the cause is numerical.
    pub wavelength: Option<f64>,
    /// Growth rate of the fastest-growing wave or oscillation; 1/time. `null` unless the cause is numerical or the time step.
    pub growth: Option<f64>,
    /// Facts that support the cause.
    pub evidence: Vec<String>,
    /// Suggested changes, and commands that examine the decisive state.
    pub remedy: Vec<String>,
    /// Changes of the discretization, with the time at which growing waves would then become visible.
    pub changes: Vec<Remedy>,
    /// Limits of the theory in this run.
    pub limits: Vec<String>,
    /// Number of limits, at the beginning, that concern the sentence itself.
    #[serde(skip)]
    decisive: usize,
    /// Lowest modes of the body in one frame; `null` if they were not requested.
    pub actual: Option<Actual>,
    /// Largest stable time steps; `null` for runs whose step is not assessed.
    pub time_step: Option<StepLimit>,
    /// Smallest amplitude of observed short waves; spacings.
    pub threshold: f64,
    /// Amplitude of the short waves when growth begins; spacings.
    pub seed: f64,
    /// Width of the bins of stretch.
    pub bin: f64,
    /// Time at which growth is expected to become visible with bins of twice the width; `null` unless the cause is numerical.
    pub expected_in_wide_bins: Option<f64>,
    /// Number of states that were evaluated.
    pub states: usize,
    /// Particle spacing of the settings; length.
    pub spacing: f64,
    /// Recognized contents of the files; `None` for arrays.
    pub recording: Option<Recording>,
    /// Predictions and measurements of each frame.
    pub moments: Vec<Moment>,
    /// Particles at the time of the first event.
    #[serde(skip)]
    picture: Option<Picture>,
    /// Number of points near held particles, which are not assessed.
    #[serde(skip)]
    unassessed: usize,
    /// Whether later frames of arrays are skipped.
    #[serde(skip)]
    is_cut_short: bool,
    /// Lattice of the particles.
    #[serde(skip)]
    particles: String,
    /// Study of the decisive state.
    #[serde(skip)]
    study: Option<String>,
    /// Notes on the files, followed by notes on law and method.
    pub notes: Vec<String>,
    /// Number of notes on law and method.
    #[serde(skip)]
    general: usize,
    /// All settings in effect.
    pub settings: Effective,
}

fn place(event: &Event, dimension: usize) -> String {
    let particle = event.particle;
    let particle = particle.map_or(String::new(), |number| format!("particle {number} at "));
    format!("near {particle}{}", point(&event.place, dimension))
}

impl ScreenAnswer {
    /// Screens a run. `sink` receives the fields of each frame.
    ///
    /// # Errors
    /// [`ScreenError`] if a frame cannot be read, or if law or method cannot be evaluated.
    pub fn new(
        problem: &Problem,
        question: &Question,
        run: &Run,
        recording: Option<&Recording>,
        frames: &mut dyn Iterator<Item = Result<Frame, ScreenError>>,
        sink: Sink<'_>,
    ) -> Result<Self, ScreenError> {
        if run.reference.is_empty() {
            return Err(super::input::no_particles("the run"));
        }
        let spacing = problem.analysis.spacing();
        let measured = || run.spacing(problem.dimension());
        let found = recording.map_or_else(measured, |own| own.spacing);
        let per_side = points_per_side(problem);
        let is_near = |expected: f64| found / expected > 0.8 && found / expected < 1.25;
        if !is_near(spacing) && !is_near(spacing / per_side) {
            return Err(ScreenError::Run {
                what: format!(
                    "the spacing of the particles is {} in the file and {} in the settings",
                    told(found),
                    told(spacing / per_side)
                ),
                hint: match per_side > 1.0 {
                    true => format!(
                        "set discretization.spacing={}, the side of a grid cell, or another discretization.points-per-side",
                        told(per_side * found)
                    ),
                    false => format!("set discretization.spacing={}", told(found)),
                },
            });
        }
        if let Some(region) = &run.region {
            region.check("region", &run.reference, problem.dimension())?;
        }
        // Rounding of positions has the form of short waves.
        let rounding = run.rounding / spacing;
        let floor = ROUNDING_FACTOR * rounding;
        let is_coarse = floor > question.threshold;
        let question = &Question {
            threshold: question.threshold.max(floor),
            ..question.clone()
        };
        let mut frames = SoundFrames::new(frames, problem.dimension(), recording.is_none());
        let mut course = follow(problem, question, run, &mut frames, sink)
            .map_err(|error| error.because(frames.fault()))?;
        course.is_cut_short = frames.fault().is_some();
        let mut answer = Self::of(problem, question, recording, course);
        answer.notes.splice(0..0, frames.notes());
        answer.particles = layout(run, problem.dimension(), found);
        let missing = missing(&problem.settings);
        answer.notes.splice(0..0, missing.iter().map(Missing::told));
        if !is_on_lattice(problem, run, found) {
            answer.notes.insert(
                0,
                "particles of the file are not on the lattice of the settings, so that the predicted waves belong to another lattice: set discretization.lattice"
                    .to_owned(),
            );
        }
        if is_coarse {
            answer.notes.insert(
                0,
                format!(
                    "positions are rounded to {} spacings, so that the threshold of short waves is {}; with more digits, or positions near the origin, it is lower",
                    told(rounding),
                    told(floor)
                ),
            );
        }
        Ok(answer)
    }

    fn of(
        problem: &Problem,
        question: &Question,
        recording: Option<&Recording>,
        mut course: Course,
    ) -> Self {
        let number = |row: usize| recording.and_then(|own| own.particle(row));
        // Short waves are observed at particles; states belong to the elements if the run has elements.
        let has_elements = recording.is_some_and(|own| own.elements > 0);
        let grown = course.grown.as_mut().map(|(event, _)| event);
        let of_states = grown.into_iter().chain(course.lost.as_mut());
        let of_states = of_states.filter(|_| !has_elements);
        for event in of_states.chain(course.observed.as_mut()) {
            event.particle = number(event.point);
        }
        let threshold = question.threshold;
        let observed = course.observed.as_ref().map(|event| event.time);
        let start = course.moments.first().map_or(0.0, |moment| moment.time);
        let end = course.moments.last().map_or(0.0, |moment| moment.time);
        let crosses = |pair: &[Moment]| {
            let [from, to] = [&pair[0], &pair[1]];
            (to.predicted_by_step > threshold).then(|| {
                let share = crossing(from.predicted_by_step, to.predicted_by_step, threshold);
                from.time + share.clamp(0.0, 1.0) * (to.time - from.time)
            })
        };
        let by_step = course.moments.windows(2).find_map(crosses);
        let grown = course.grown.as_ref().map(|(event, _)| event.time);
        let lost = course.lost.as_ref().map(|event| event.time);
        // An instability that is predicted long after the first short waves is not their cause.
        let last = course.moments.last();
        let is_rising = last.is_some_and(|last| last.observed_mean > RISE_RATIO * course.seed);
        let is_in_time = |time: f64| match observed {
            Some(observed) => time <= observed + LATENESS_FRACTION * (observed - start),
            None => is_rising,
        };
        let causes = [
            (
                Cause::Physical,
                lost.filter(|time| observed.is_none() || is_in_time(*time)),
            ),
            (Cause::TimeStep, by_step.filter(|time| is_in_time(*time))),
            (Cause::Numerical, grown.filter(|time| is_in_time(*time))),
        ];
        let first = causes
            .into_iter()
            .filter_map(|(cause, time)| Some((cause, time?)))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let weakest = || {
            let weakest = problem.analysis.weakest().ok().flatten();
            weakest.map_or(1.0, |mode| mode.relative_frequency())
        };
        // Noise of another origin can come before the growth that then destroys the body.
        let most = course.moments.iter().map(|moment| moment.observed);
        let is_destroyed = most.fold(0.0, f64::max) > DESTROYED_BODY_RATIO * threshold;
        let exceeded = course.step.as_ref().and_then(|limit| limit.exceeded);
        let by_growth = course.grown_until_observed > EXPLAINING_EXPONENT
            || is_destroyed
                && grown.is_some()
                && course.grown_until_observed > DESTROYED_BODY_EXPONENT;
        let by_excess = exceeded.filter(|_| is_destroyed).and(by_step.or(observed));
        let (cause, expected) = match (first, observed) {
            (Some((cause, time)), _) => (cause, Some(time)),
            (None, Some(_)) if by_excess.is_some() => (Cause::TimeStep, by_excess),
            (None, Some(_)) if by_growth => (Cause::Numerical, grown),
            (None, Some(_)) if weakest() < question.weak => (Cause::ZeroEnergy, None),
            (None, Some(_)) => (Cause::Forced, None),
            (None, None) => (Cause::None, None),
        };
        let step = question.time_step;
        let at_limit_of_step = course.step.as_ref().zip(step).is_some_and(|(limit, step)| {
            matches!(cause, Cause::None | Cause::TimeStep | Cause::Forced)
                && (step / limit.decisive() - 1.0).abs() < LIMIT_TOLERANCE
        });
        // Short waves distort the gradients.
        let until = observed.unwrap_or(f64::INFINITY);
        let least = course
            .moments
            .iter()
            .filter(|moment| moment.time <= until)
            .filter_map(|moment| moment.acoustic)
            .fold(f64::INFINITY, f64::min);
        let at_limit_of_law = matches!(cause, Cause::None) && least < ELLIPTIC_MARGIN;
        let event = match cause {
            Cause::Physical => course.lost.clone(),
            Cause::Numerical => {
                let grown = course.grown.as_ref().map(|(event, _)| event.clone());
                grown.or_else(|| course.observed.clone())
            }
            Cause::TimeStep => course.step.as_ref().map(|limit| {
                let time = limit.exceeded.unwrap_or(start);
                let point = limit.particle.unwrap_or(0);
                Event {
                    time,
                    window: [time, time],
                    point,
                    particle: limit.particle.and_then(number),
                    place: limit.place.unwrap_or_default(),
                    f: *DeformationGradient::identity().components(),
                }
            }),
            Cause::ZeroEnergy | Cause::Forced => course.observed.clone(),
            Cause::None => None,
        };
        let changes = match (cause, expected) {
            (Cause::Numerical, Some(time)) => remedies(problem, question, &course, time),
            (Cause::ZeroEnergy, _) => controls(problem, question, &course),
            _ => Vec::new(),
        };
        let decisive = match cause {
            Cause::Physical | Cause::Numerical | Cause::ZeroEnergy => event.as_ref(),
            _ => None,
        };
        let state = decisive.and_then(|event| {
            let f = DeformationGradient::new(event.f).ok()?;
            StateAnswer::asked(
                problem,
                &f.given_in(problem.dimension()).into(),
                &StateQuestion {
                    weak: question.weak,
                    ..StateQuestion::default()
                },
            )
            .ok()
        });
        let rates = course.grown.as_ref().map(|(_, rates)| rates);
        let rates = rates.or(course.growing.as_ref());
        let rates = rates.filter(|_| cause == Cause::Numerical);
        let wave = rates.map_or_else(Vec::new, |rates| rates.wave.clone());
        let spacing = problem.analysis.spacing();
        // The map shows the first short waves, otherwise the first event.
        let time = course.observed.as_ref().or(event.as_ref());
        let time = time.map(|event| event.window[1]);
        let mut pictures = course.pictures.iter();
        let picture = pictures.find(|own| Some(own.time) == time).cloned();
        let general = notes(&problem.settings, &*problem.material);
        let mut answer = Self {
            cause,
            mechanism: state.as_ref().and_then(|state| state.mechanism),
            sentence: String::new(),
            at_the_limit: at_limit_of_step || at_limit_of_law,
            is_law_at_limit: at_limit_of_law,
            first: event,
            expected,
            observed: course.observed.clone(),
            wavelength: rates.map(|rates| {
                let k: f64 = rates.wave.iter().map(|k| k * k).sum();
                std::f64::consts::TAU / k.sqrt() / spacing
            }),
            growth: match cause {
                Cause::TimeStep => course.step.as_ref().map(|limit| limit.growth),
                _ => rates.map(|rates| rates.growth),
            },
            evidence: Vec::new(),
            remedy: Vec::new(),
            changes,
            limits: Vec::new(),
            decisive: 0,
            time_step: course.step.clone(),
            threshold,
            seed: course.seed,
            bin: question.bin,
            expected_in_wide_bins: expected
                .filter(|_| cause == Cause::Numerical)
                .and_then(|_| expected_in(problem, question, &course, 2.0 * question.bin)?),
            states: course.states,
            spacing,
            recording: recording.cloned(),
            moments: course.moments,
            actual: course.actual,
            picture,
            unassessed: course.points[1],
            is_cut_short: course.is_cut_short,
            particles: String::new(),
            study: None,
            general: general.len(),
            notes: [course.notes, general].concat(),
            settings: problem.settings.effective(),
        };
        if let (Cause::Numerical, Some(event), Some(growth)) = (cause, &answer.first, answer.growth)
        {
            let interval = event.window[1] - event.window[0];
            if growth * interval > LARGEST_INTERVAL_GROWTH {
                answer.notes.insert(0, format!(
                    "waves grow by e^{:.1} from one frame to the next, so that times are known to within an interval of {}: write more frames",
                    growth * interval,
                    told(interval)
                ));
            }
        }
        answer.evidence = answer.evidence_of(
            problem,
            question,
            least,
            [grown, by_step],
            course.lost.as_ref(),
        );
        answer.remedy = answer.remedy_of(problem, state.as_ref());
        let limits = answer.limits_of(problem, course.cut, course.points, end);
        let varied = answer.variation_of(problem, course.variation);
        answer.decisive = varied.len();
        answer.limits = [varied, course.lacking, limits].concat();
        answer.sentence = answer.in_words(problem, question);
        answer.study = study(&answer, problem, question, &wave);
        answer
    }

    fn evidence_of(
        &self,
        problem: &Problem,
        question: &Question,
        least: f64,
        [grown, by_step]: [Option<f64>; 2],
        lost: Option<&Event>,
    ) -> Vec<String> {
        let mut evidence = Vec::new();
        if least.is_finite() {
            evidence.push(match self.cause {
                Cause::Physical => {
                    "the smallest acoustic eigenvalue of the law is not positive there".to_owned()
                }
                _ => format!(
                    "smallest acoustic eigenvalue of the law{}: {} of its modulus",
                    match self.observed {
                        Some(_) => " before the first short waves",
                        None => " in the run",
                    },
                    told(least)
                ),
            });
        }
        let moment = |time: f64| self.moments.iter().find(|moment| moment.time >= time);
        if self.cause == Cause::Numerical {
            // Growth from the beginning of the exponential part to the time at which it is observed.
            let begun = self
                .moments
                .iter()
                .find(|own| own.predicted > 1.5 * self.seed);
            let shown = self.observed.as_ref().and_then(|event| moment(event.time));
            if let (Some(begun), Some(shown)) = (begun, shown)
                && begun.observed_mean > 0.0
                && shown.time > begun.time
            {
                evidence.push(format!(
                    "short waves grew by e^{:.1} from t = {} to {}, predicted e^{:.1}",
                    (shown.observed_mean / begun.observed_mean).ln(),
                    told(begun.time),
                    told(shown.time),
                    (shown.predicted / begun.predicted).ln()
                ));
            }
            if let (Some(fine), Some(wide)) = (self.expected, self.expected_in_wide_bins) {
                evidence.push(format!(
                    "expected at t = {} with bins of stretch of {}, at {} with {}",
                    told(fine),
                    told(self.bin),
                    told(wide),
                    told(2.0 * self.bin)
                ));
            }
        }
        if let (Some(limit), Some(step)) = (&self.time_step, question.time_step) {
            let of_body = match limit.body {
                Some(body) => format!(
                    "{} of this body, {} of the infinite lattice",
                    told(body),
                    told(limit.lattice)
                ),
                None => format!(
                    "{} of the infinite lattice (a body can have a shorter one with this method)",
                    told(limit.lattice)
                ),
            };
            evidence.push(format!(
                "time step {}; largest stable step in {}: {of_body}, and at least {} during the run",
                told(step),
                question.stepping.name(),
                told(limit.least)
            ));
        }
        if self.cause != Cause::Numerical
            && let Some(time) = grown
        {
            evidence.push(format!(
                "growing waves of the discretization are expected to become visible at t = {}",
                told(time)
            ));
        }
        if self.cause != Cause::TimeStep
            && let Some(time) = by_step
        {
            evidence.push(format!(
                "oscillations caused by the time step are expected to become visible at t = {}",
                told(time)
            ));
        }
        if self.observed.is_none() {
            let most = self
                .moments
                .iter()
                .map(|moment| moment.observed)
                .fold(0.0, f64::max);
            evidence.push(format!(
                "short waves in the positions stay below {} spacings (threshold {})",
                told(most),
                told(self.threshold)
            ));
        }
        if let Some(event) = lost.filter(|_| self.cause != Cause::Physical) {
            evidence.push(format!(
                "the law loses strong ellipticity {} at t = {}, after the first short waves",
                place(event, problem.dimension()),
                told_with(event.time, 4)
            ));
        }
        evidence
    }

    /// Fit of a law that stays elliptic at the stretches of the cause; `None` for laws that are not fitted to tests of rubber or foam.
    fn fit_of(&self, problem: &Problem) -> Option<String> {
        let law = &problem.settings.material;
        let model = law.model;
        if law.is_handed() || law.is_library() || model.is_in_rate_form() || model.yields() {
            return None;
        }
        let f = DeformationGradient::new(self.first.as_ref()?.f).ok()?;
        let stretches = f.principal_stretches();
        let low = stretches.iter().copied().fold(1.0, f64::min);
        let high = stretches.iter().copied().fold(1.0, f64::max);
        Some(format!(
            "if its constants were fitted to tests: onset fit TESTS.csv --stable box={},{} fits laws that are stable there",
            told_with(low, 2),
            told_with(high, 3)
        ))
    }

    fn remedy_of(&self, problem: &Problem, state: Option<&StateAnswer>) -> Vec<String> {
        let mut remedy = Vec::new();
        match self.cause {
            Cause::TimeStep => {
                if let Some(limit) = &self.time_step {
                    let safe = told_with(SAFETY_FACTOR * limit.least, 2);
                    remedy.push(format!("a time step of {safe}"));
                }
            }
            Cause::Physical => {
                remedy.push(
                    "results no longer converge under refinement beyond this state: use a law that stays elliptic there, or a regularized law with an internal length".to_owned(),
                );
                remedy.extend(self.fit_of(problem));
            }
            Cause::Numerical | Cause::ZeroEnergy => {
                remedy.extend(self.changes.iter().map(|own| own.told(self.cause)));
            }
            Cause::Forced => {
                remedy.push("examine loads, contact and gradients of strain there".to_owned())
            }
            Cause::None => {}
        }
        if let Some(state) = state {
            remedy.extend(state.next.iter().cloned());
        }
        let decisive = matches!(self.cause, Cause::Physical | Cause::Numerical);
        let event = self.first.as_ref().filter(|_| decisive);
        remedy.extend(event.and_then(|event| command(problem, &event.f)));
        remedy
    }

    /// Limit of the theory of homogeneous states at the cause, where the state varies within few spacings.
    fn variation_of(&self, problem: &Problem, variation: Option<f64>) -> Vec<String> {
        let event = self
            .first
            .as_ref()
            .filter(|_| self.cause == Cause::Physical);
        let Some((event, length)) = event.zip(variation.filter(|own| *own < VARIED_SPACINGS))
        else {
            return Vec::new();
        };
        vec![format!(
            "the strain {} varies by {:.0} % per spacing: the theory of homogeneous states holds there for waves much shorter than {:.0} spacings. A neck or a buckle is longer, and grows while the law is still elliptic; `--actual {}` finds the modes of the body",
            place(event, problem.dimension()),
            100.0 / length,
            length,
            told_with(event.window[0], 4)
        )]
    }

    fn limits_of(&self, problem: &Problem, cut: f64, points: [usize; 2], end: f64) -> Vec<String> {
        let mut limits = vec![
            "states are taken as homogeneous: regions smaller than half of the growing wavelength are not assessed".to_owned(),
        ];
        if cut > 0.0 {
            limits.push(format!(
                "{:.0} % of the particles have cut neighborhoods, at faces; their waves are taken from the inside",
                (100.0 * cut).max(1.0)
            ));
        }
        if points[1] > 0 {
            limits.push(format!(
                "{} near held particles are not assessed",
                counted(points[1], "point")
            ));
        }
        if let Some(event) = &self.observed
            && event.time < end
        {
            limits.push(format!(
                "after t = {} the neighbors differ from the neighbors in the reference configuration",
                told(event.time)
            ));
        }
        let own = &problem.settings.method;
        let slowed = [
            own.viscosity,
            own.hourglass_viscosity,
            own.velocity_smoothing,
        ];
        if self.actual.is_some() && slowed.iter().any(|coefficient| *coefficient != 0.0) {
            limits.push(
                "growth rates of modes are computed without viscosity and velocity smoothing"
                    .to_owned(),
            );
        }
        if problem.material.is_path_dependent() {
            limits.push("each state is reached on a proportional path".to_owned());
        }
        let spacing = problem.analysis.spacing();
        let is_on_neither = |own: &Recording| {
            [spacing, spacing / points_per_side(problem)]
                .iter()
                .all(|expected| !is_spaced(own.spacing, *expected))
        };
        if self.recording.as_ref().is_some_and(is_on_neither) {
            limits.push("particles of the file are not on the lattice of the settings".to_owned());
        }
        limits
    }

    /// Returns true if short waves are expected to have grown clearly at the end.
    fn rises(&self) -> bool {
        let last = self.moments.last();
        last.is_some_and(|last| last.predicted > RISE_RATIO * self.seed)
    }

    fn in_words(&self, problem: &Problem, question: &Question) -> String {
        let dimension = problem.dimension();
        let at = self
            .first
            .as_ref()
            .map_or(String::new(), |event| place(event, dimension));
        let short = |value: f64| told_with(value, 4);
        let observed = match &self.observed {
            Some(event) if event.window[1] > event.window[0] => format!(
                "observed at t = {} (frames {} to {})",
                short(event.time),
                short(event.window[0]),
                short(event.window[1])
            ),
            Some(event) => format!(
                "observed from the first frame on, t = {}",
                short(event.time)
            ),
            None => format!("still below {} spacings at the end", short(self.threshold)),
        };
        let expectation = match self.expected {
            Some(time) => format!(
                "They are expected to become visible at t = {}, and are {observed}",
                short(time)
            ),
            None => format!("They are {observed}, earlier than expected"),
        };
        let expected = self.expected.map_or("?".to_owned(), short);
        let step = question.time_step.zip(self.time_step.as_ref());
        let above = step.filter(|(_, limit)| limit.exceeded.is_some());
        let is_step_at_limit = self.at_the_limit && !self.is_law_at_limit;
        let limit = match (is_step_at_limit, self.cause, above) {
            (false, Cause::None | Cause::Forced, Some((step, limit))) => format!(
                " The time step {} exceeds the largest stable step, {}{}.",
                told(step),
                short(limit.decisive()),
                match self.cause {
                    Cause::None => ", although the positions show nothing yet",
                    _ => ", too",
                }
            ),
            (false, Cause::None, _) if self.rises() => format!(
                " But waves of the discretization grow: an amplitude of {} spacings is expected at the end.",
                short(self.moments.last().map_or(0.0, |last| last.predicted))
            ),
            _ if self.is_law_at_limit => {
                " The law is at the limit of ellipticity: a change of 2 % in its modulus would change the verdict."
                    .to_owned()
            }
            // Without the time step, weakly controlled modes and loads cannot be distinguished from a step that is too large.
            (_, Cause::ZeroEnergy | Cause::Forced, _) if question.time_step.is_none() => {
                " The time step is not known, and may be too large: give --time-step.".to_owned()
            }
            (false, ..) => String::new(),
            (true, ..) => " The time step is at the limit: a change of 2 % would change the verdict.".to_owned(),
        };
        let assessed = self.recording.as_ref().filter(|own| own.skipped > 0);
        let end = self.moments.last().map_or(0.0, |last| last.time);
        let until = (assessed.is_some() || self.is_cut_short).then_some(end);
        let rest = match assessed {
            _ if until.is_none() => String::new(),
            Some(own) => format!(
                " Only the first {} of {} frames are assessed; the others are skipped for the reason in the note.",
                own.frames,
                own.frames + own.skipped
            ),
            None => format!(
                " Only the frames until t = {} are assessed; the others are skipped for the reason in the note.",
                short(end)
            ),
        };
        let sentence = match self.cause {
            Cause::Physical => format!(
                "First cause: the material. It loses strong ellipticity {at} at t = {}; short waves are {observed}.",
                self.first.as_ref().map_or("?".to_owned(), |event| format!(
                    "{} (frames {} to {})",
                    short(event.time),
                    short(event.window[0]),
                    short(event.window[1])
                ))
            ),
            Cause::Numerical => format!(
                "First cause: the discretization{}. Waves of {} spacings grow at the rate {} {at}, although the material is strongly elliptic there. {expectation}.",
                self.mechanism.map_or(String::new(), |mechanism| format!(
                    " ({} instability)",
                    mechanism.name()
                )),
                self.wavelength.map_or("?".to_owned(), short),
                self.growth.map_or("?".to_owned(), short),
            ),
            Cause::TimeStep => {
                let step = question.time_step.unwrap_or_default();
                let limit = self.time_step.as_ref();
                let critical = limit.map_or(0.0, StepLimit::decisive);
                let least = limit.map_or(0.0, |limit| limit.least);
                let scheme = question.stepping.name();
                let of = match limit.and_then(|limit| limit.body) {
                    Some(_) => format!(
                        "the largest stable step of this body with {scheme}, set by the particles {at}"
                    ),
                    None => format!("the largest stable step of the lattice with {scheme}"),
                };
                let from = self.first.as_ref();
                format!(
                    "First cause: the time step. From t = {} on, the step {} exceeds {}, {of}. Oscillations are expected to become visible at t = {expected}, and are {observed}. A step of {} is safe.",
                    from.map_or("?".to_owned(), |event| short(event.time)),
                    told(step),
                    short(critical),
                    told_with(SAFETY_FACTOR * least, 2)
                )
            }
            Cause::ZeroEnergy => format!(
                "First cause: zero-energy or weakly controlled modes of the discretization. Short waves are {observed} {at}. Forces resist them little, and no state of the run makes them grow."
            ),
            Cause::Forced => format!(
                "No instability explains the short waves {at}, {observed}: material and discretization are stable in the states of this run. Loads, contact or gradients of strain force them."
            ),
            Cause::None => format!(
                "No instability{}: short waves stay below the threshold, and the material stays strongly elliptic{}.",
                until.map_or(String::new(), |time| format!(" until t = {}", short(time))),
                match self.unassessed {
                    0 => String::new(),
                    count => format!(
                        " except near held particles, where {} are not assessed",
                        counted(count, "point")
                    ),
                }
            ),
        };
        sentence + &rest + &limit
    }

    /// Table of the frames.
    pub fn csv(&self) -> String {
        Table::new(&self.moments, self.settings.units())
            .with("time", "time", |own| own.time)
            .with("predicted", "1", |own| own.predicted)
            .with("predicted_by_step", "1", |own| own.predicted_by_step)
            .with("observed", "1", |own| own.observed)
            .with("observed_mean", "1", |own| own.observed_mean)
            .with("acoustic", "1", |own| own.acoustic)
            .with("growth", "1/time", |own| own.growth)
            .with("step_ratio", "1", |own| own.step_ratio)
            .with("undefined", "1", |own| own.undefined)
            .to_string()
    }

    /// Table, document, study and figure.
    pub fn files(&self) -> Files {
        let document = json::document(self).unwrap_or_default();
        let mut files = vec![
            text("screen.csv", self.csv()),
            text("screen.json", document + "\n"),
        ];
        let actual = self.actual.iter();
        files.extend(actual.map(|actual| text("modes.vtu", actual.vtu())));
        let study = self.study.iter();
        files.extend(study.map(|study| text("first.toml", study.as_str())));
        files.push(picture("screen", self.figure()));
        files
    }

    /// Amplitudes over time, and below them the smallest acoustic eigenvalue and the ratio of the steps.
    fn figure(&self) -> Figure {
        let of = |value: &dyn Fn(&Moment) -> Option<f64>| -> Vec<(f64, f64)> {
            let all = self.moments.iter();
            all.filter_map(|own| Some((own.time, value(own)?)))
                .collect()
        };
        let floor = SMALLEST_DRAWN_AMPLITUDE;
        let amplitude =
            |value: &dyn Fn(&Moment) -> f64| of(&|own| Some(value(own).clamp(floor, 10.0)));
        let times = || self.moments.iter().map(|own| own.time);
        let axis = || Axis::linear("time", (0.0, 1.0)).covering(times());
        let least = self
            .moments
            .iter()
            .map(|own| own.observed_mean.max(floor))
            .fold(self.seed.max(floor), f64::min);
        let mut upper = Panel::new(
            "",
            axis(),
            Axis::log("amplitude of short waves / spacing", (0.3 * least, 3.0)),
        )
        .with(
            Line::new(amplitude(&|own| own.observed))
                .named("observed, largest")
                .color(palette::BLACK),
        )
        .with(
            Line::new(amplitude(&|own| own.observed_mean))
                .named("observed, mean")
                .color(palette::GREY),
        )
        .with(
            Line::new(amplitude(&|own| own.predicted))
                .named("predicted, growing waves")
                .color(palette::VERMILION),
        )
        .with(Rule::horizontal(self.threshold).dotted());
        if self.time_step.is_some() {
            upper = upper.with(
                Line::new(amplitude(&|own| own.predicted_by_step))
                    .named("predicted, time step")
                    .color(palette::BLUE)
                    .dashed(),
            );
        }
        let ratios = of(&|own| own.step_ratio);
        let acoustic = of(&|own| own.acoustic.map(|value| value.clamp(-1.0, 2.0)));
        let shown = acoustic
            .iter()
            .chain(&ratios)
            .map(|(_, value)| value.min(2.0));
        let y = Axis::linear("share of the limit", (0.0, 1.05)).covering(shown);
        let mut lower = Panel::new("", axis(), y).with(
            Line::new(acoustic)
                .named("smallest acoustic eigenvalue / modulus")
                .color(palette::GREEN),
        );
        if !ratios.is_empty() {
            let ratios = ratios
                .into_iter()
                .map(|(time, ratio)| (time, ratio.min(2.0)))
                .collect();
            lower = lower
                .with(
                    Line::new(ratios)
                        .named("time step / largest stable step")
                        .color(palette::BLUE),
                )
                .with(Rule::horizontal(1.0).dotted());
        }
        if let Some(event) = &self.first {
            let rule = || Rule::vertical(event.time).dashed().color(palette::PURPLE);
            (upper, lower) = (
                upper.with(rule().named(format!("first cause: {}", self.cause.name()))),
                lower.with(rule()),
            );
        }
        let figure = Figure::new("").caption(self.sentence.clone()).with(upper);
        match &self.picture {
            Some(picture) => figure.columns(3).with(lower).with(self.map(picture)),
            None => figure.columns(2).with(lower),
        }
    }

    /// Particles at one time, colored by the amplitude of their short waves.
    fn map(&self, picture: &Picture) -> Panel {
        let places: Vec<(f64, f64)> = picture.x.iter().map(|x| (x[0], x[1])).collect();
        let x = Axis::linear("x₁", (0.0, 1.0)).covering(places.iter().map(|place| place.0));
        let y = Axis::linear("x₂", (0.0, 1.0)).covering(places.iter().map(|place| place.1));
        let logs: Vec<f64> = picture
            .observed
            .iter()
            .map(|observed| observed.max(SMALLEST_DRAWN_AMPLITUDE).log10())
            .collect();
        let most = logs.iter().copied().fold(self.threshold.log10(), f64::max);
        let least = logs.iter().copied().fold(f64::INFINITY, f64::min);
        let range = (least.min(most - 1.0), most);
        Panel::new(format!("short waves at t = {}", told(picture.time)), x, y)
            .equal_aspect()
            .with_particles(&places, &logs, range, "log₁₀ of short waves / spacing")
    }
}

impl Brief for ScreenAnswer {
    fn brief(&self) -> Short {
        let mut short = Short::new(self.sentence.clone());
        for (rank, evidence) in self.evidence.iter().enumerate() {
            short = short.row(
                1 + rank as u8,
                if rank == 0 { "evidence" } else { "" },
                evidence.clone(),
            );
        }
        for (rank, remedy) in self.remedy.iter().enumerate() {
            short = short.row(
                rank as u8,
                if rank == 0 { "remedy" } else { "" },
                remedy.clone(),
            );
        }
        let modes = self.actual.iter().flat_map(Actual::told);
        for (rank, mode) in modes.enumerate() {
            short = short.row(1, if rank == 0 { "modes" } else { "" }, mode);
        }
        for (rank, limit) in self.limits.iter().enumerate() {
            // A limit of the sentence itself belongs to the answer, by its first sentence.
            let (kept, text) = match rank < self.decisive {
                true => (
                    0,
                    limit.split_once(". ").map_or(limit.as_str(), |own| own.0),
                ),
                false => (6 + rank as u8, limit.as_str()),
            };
            short = short.row(kept, if rank == 0 { "limits" } else { "" }, text);
        }
        let notes: Vec<String> = self
            .recording
            .iter()
            .flat_map(|own| own.notes.clone())
            .chain(
                self.notes[..self.notes.len() - self.general]
                    .iter()
                    .cloned(),
            )
            .collect();
        short
            .notes(&notes)
            .settings("settings", self.settings.caption())
    }
}

impl fmt::Display for ScreenAnswer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(formatter, "{}", self.sentence)?;
        let modes = self.actual.iter().flat_map(Actual::told).collect();
        for (title, lines) in [
            ("evidence", &self.evidence),
            ("remedy", &self.remedy),
            ("modes", &modes),
            ("limits", &self.limits),
        ] {
            if !lines.is_empty() {
                writeln!(formatter, "\n{title}")?;
            }
            for line in lines {
                writeln!(formatter, "  {line}")?;
            }
        }
        writeln!(
            formatter,
            "\nWaves grow from an amplitude of {} spacings; {} in bins of stretch of {}.",
            told(self.seed),
            counted(self.states, "state"),
            told(self.bin)
        )?;
        if let Some(recording) = &self.recording {
            let checks = recognized(recording, self.spacing, &self.particles);
            writeln!(formatter, "\n{checks}")?;
        }
        let of_files = self.recording.iter().flat_map(|own| &own.notes);
        for note in of_files.chain(&self.notes) {
            writeln!(formatter, "\nnote: {note}")?;
        }
        write!(formatter, "\n{}", self.settings)
    }
}
