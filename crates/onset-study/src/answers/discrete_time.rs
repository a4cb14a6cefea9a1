//! Waves in discrete time, in the answer about a state, for methods that define their time step.

use super::finite_body::LATTICE_NOTE;
use super::problem::{Problem, ProblemError};
use super::state::{ComplexNumber, list};
use crate::number::{told, told_of, vector};
use crate::settings::{Units, Velocities};
use nalgebra::SVector;
use onset::algebra::Complex;
use onset::kinematics::DeformationGradient;
use serde::Serialize;
use std::f64::consts::TAU;

/// Length of the longitudinal wave whose damping is reported, in grid cells.
const DAMPED_WAVELENGTH: f64 = 8.0;

/// Waves of a state in discrete time. Solutions are `exp(s t)` at whole steps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DiscreteTimeAnswer {
    /// The transfer of velocities.
    pub transfer: Velocities,
    /// Largest stable step, time; in an unstable state, for the waves that do not grow at any step. `null` if no wave oscillates.
    pub largest_time_step: Option<f64>,
    /// Largest stable step of an isolated, unstressed material point, time; `null` for laws with stress at `F = 1`.
    pub isolated_point_time_step: Option<f64>,
    /// Time step for which growth rate and frequency are given: `discretization.time-step`, or half of the largest step; time. `null` if neither exists.
    pub time_step: Option<f64>,
    /// Largest growth rate over the zone, 1/time; zero if no wave grows, `null` without a time step.
    pub growth_rate: Option<f64>,
    /// Frequency of the fastest growing wave; 1/time. `null` without a time step.
    pub frequency: Option<f64>,
    /// Reference wave vector of the fastest growing wave, zero if no wave grows; 1/length.
    pub wave_vector: Vec<f64>,
    /// Wave vector of the fastest growing wave in the deformed lattice; 1/length.
    pub spatial_wave_vector: Vec<f64>,
    /// Whether the user set the step.
    #[serde(skip)]
    is_step_set: bool,
    /// Complex rate `s` of the wave of wavelength eight grid cells along axis 1 on the highest branch (longitudinal in most materials), the less damped of its
    /// two solutions; 1/time. The damping is `-Re s`. `null` without a time step.
    pub longitudinal_wave: Option<ComplexNumber>,
}

impl DiscreteTimeAnswer {
    /// Returns `None` for methods without a transfer, whose step the integrator defines.
    pub(super) fn new(
        problem: &Problem,
        f: &DeformationGradient,
    ) -> Result<Option<Self>, ProblemError> {
        let analysis = &*problem.analysis;
        let Some(waves) = analysis.transferred(f)? else {
            return Ok(None);
        };
        let method = &problem.settings.method;
        let largest = Some(waves.critical_time_step()).filter(|step| step.is_finite());
        let time_step = method.step_of_rates(largest);
        let fastest = time_step.map(|step| waves.fastest(step));
        let k = fastest.as_ref().map_or_else(Vec::new, |(_, k)| k.clone());
        let k = SVector::from_fn(|i, _| k.get(i).copied().unwrap_or(0.0));
        let dimension = analysis.dimension();
        let rate = fastest.map(|(rate, _)| rate);
        Ok(Some(Self {
            transfer: method.transfer,
            largest_time_step: largest,
            isolated_point_time_step: waves.isolated_point(),
            time_step,
            is_step_set: method.time_step > 0.0,
            growth_rate: rate.map(|rate| rate.re),
            frequency: rate.map(|rate| rate.im.abs()),
            wave_vector: list(dimension, &k),
            spatial_wave_vector: list(dimension, &analysis.spatial(f, &k)),
            longitudinal_wave: time_step.and_then(|step| {
                let mut along = vec![0.0; dimension];
                along[0] = TAU / (DAMPED_WAVELENGTH * problem.settings.discretization.spacing);
                // The fastest wave is the last; the less damped of its two solutions is used.
                let rates = waves.rates(&along, step);
                let last = rates.iter().rev().take(2);
                let slowest = last.max_by(|a, b| {
                    (a.re, a.im)
                        .partial_cmp(&(b.re, b.im))
                        .unwrap_or(std::cmp::Ordering::Equal)
                });
                slowest.map(|rate| Complex::new(rate.re, rate.im.abs()).into())
            }),
        }))
    }

    /// Takes the smaller largest steps of two answers.
    pub(super) fn limited_by(
        mut self,
        other: Result<Option<Self>, ProblemError>,
    ) -> Result<Self, ProblemError> {
        if let Some(other) = other? {
            let least = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::min);
            self.largest_time_step = least(self.largest_time_step, other.largest_time_step);
            self.isolated_point_time_step = least(
                self.isolated_point_time_step,
                other.isolated_point_time_step,
            );
        }
        Ok(self)
    }

    fn is_too_long(&self) -> bool {
        let both = self.time_step.zip(self.largest_time_step);
        both.is_some_and(|(step, largest)| step > largest)
    }

    fn is_too_long_for_an_isolated_point(&self) -> bool {
        let both = self.time_step.zip(self.isolated_point_time_step);
        self.is_step_set && both.is_some_and(|(step, alone)| step > alone)
    }

    /// Lines of the text output: name and value.
    pub(super) fn lines(&self, units: Units) -> Vec<(&'static str, String)> {
        let mut lines = Vec::new();
        let time = |step: f64| units.of(told(step), "s");
        let rate = |rate: f64| units.of(told(rate), "1/s");
        let name = self.transfer.name();
        if let Some(largest) = self.largest_time_step {
            lines.push((
                "largest time step",
                format!(
                    "the {name} transfer is stable for steps below {} ({LATTICE_NOTE})",
                    time(largest)
                ),
            ));
        }
        if let Some(alone) = self.isolated_point_time_step {
            lines.push((
                "of an isolated point",
                format!(
                    "{}: unstressed, at its lattice position, without neighbors on the grid",
                    time(alone)
                ),
            ));
        }
        if let Some((step, growth)) = self.time_step.zip(self.growth_rate) {
            let frequency = self.frequency.unwrap_or(0.0);
            let growth = match growth > 0.0 {
                true => format!(
                    "a wave grows at the rate {}, with the frequency {} and the reference wave vector {}",
                    rate(growth),
                    rate(frequency),
                    units.of(vector(&self.wave_vector), "1/m")
                ),
                false => "no wave grows".to_owned(),
            };
            lines.push(("with the time step", format!("{}: {growth}", time(step))));
        }
        if let Some(sound) = self.longitudinal_wave {
            lines.push((
                "longitudinal wave",
                format!(
                    "8 cells long: damped at {}, with the frequency {}",
                    units.of(told_of(-sound.re, sound.im), "1/s"),
                    rate(sound.im)
                ),
            ));
        }
        lines
    }
}

/// Note for states whose stability in discrete time differs from the verdict.
pub(super) fn note(own: &DiscreteTimeAnswer, is_stable: bool, units: Units) -> Option<String> {
    let step = units.of(told(own.time_step?), "s");
    let growth = own.growth_rate?;
    let rate = units.of(told(growth), "1/s");
    let transfer = own.transfer.name();
    match (is_stable, growth > 0.0) {
        (true, true) if own.is_too_long() => Some(format!(
            "the step {step} is longer than the largest stable step of the {transfer} transfer, {}: a wave grows at the rate {rate}, although none grows in continuous time",
            units.of(told(own.largest_time_step?), "s")
        )),
        (true, false) if own.is_too_long_for_an_isolated_point() => Some(format!(
            "the step {step} is longer than the largest stable step of an isolated material point, {}: points without neighbors are unstable by \
             themselves although the body is stable",
            units.of(told(own.isolated_point_time_step?), "s")
        )),
        (false, true) => Some(format!(
            "with the step {step} the {transfer} transfer reduces the growth rate to {rate}{}",
            match own.transfer {
                // The velocities that the points keep are not filtered.
                Velocities::Flip => "",
                _ => "; shorter steps filter more often",
            }
        )),
        (false, false) => Some(format!(
            "with the step {step} the filter of the {transfer} transfer suppresses the waves that would grow without it"
        )),
        _ => None,
    }
}
