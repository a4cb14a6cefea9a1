//! Time step of a run with another code, compared with the largest stable steps of its scheme.

use super::finite_body::FiniteBodyAnswer;
use super::problem::{Problem, ProblemError};
use crate::number::{told, told_below};
use crate::screen::{BIN, States, without_rotation};
use crate::settings::{RunStep, Units};
use nalgebra::Matrix3;
use onset::bloch::SpectrumSummary;
use onset::kinematics::DeformationGradient;
use onset::method::MethodError;
use onset::time_step::Stepping;
use serde::Serialize;

/// Time step of a run, and the largest stable steps of its scheme at the state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RunStepAnswer {
    /// Time step of the run; time.
    pub time_step: f64,
    /// Time stepping scheme of the code.
    pub stepping: &'static str,
    /// Largest stable step of the infinite lattice; time.
    pub lattice: f64,
    /// Step that is stable for finite bodies: the step of central differences, reduced by the largest factor of the scheme. `null` if it is unknown. Time.
    pub finite_bodies: Option<f64>,
    /// Body for which the step is too large: `lattice` for every body, `finite-bodies` for some; `null` for none.
    pub too_large_for: Option<&'static str>,
}

impl RunStepAnswer {
    /// Compares the step of the settings with the largest stable steps at a state; `None` without a step. `bodies` is the step of central differences for
    /// finite bodies.
    pub(super) fn new(
        problem: &Problem,
        f: &DeformationGradient,
        spectrum: &SpectrumSummary<3>,
        bodies: Option<&FiniteBodyAnswer>,
    ) -> Result<Option<Self>, ProblemError> {
        let RunStep { step, stepping } = problem.settings.run;
        if step == 0.0 || problem.analysis.is_transferred() {
            return Ok(None);
        }
        let is_plain = stepping == Stepping::VelocityVerlet && !problem.analysis.is_damped();
        let squared = match is_plain {
            true => spectrum.maximum_omega * spectrum.maximum_omega,
            false => {
                let components = f.components();
                let f = Matrix3::from_fn(|i, j| components[i][j]);
                let states = States::new(problem, Some((stepping, step)), BIN);
                let rates = without_rotation(&f).and_then(|u| states.evaluate(&u));
                rates.ok_or(MethodError::NotFinite)?.squared
            }
        };
        let lattice = stepping.critical_step(squared, 0.0);
        let factor = stepping.weights().into_iter().fold(1.0, f64::max);
        let of_body = |own: &FiniteBodyAnswer| {
            stepping.critical_step(factor * (2.0 / own.time_step).powi(2), 0.0)
        };
        let finite_bodies = bodies.map(of_body);
        Ok(Some(Self {
            time_step: step,
            stepping: stepping.name(),
            lattice,
            finite_bodies,
            too_large_for: match finite_bodies {
                _ if step > lattice => Some("lattice"),
                Some(bodies) if step > bodies => Some("finite-bodies"),
                _ => None,
            },
        }))
    }

    /// Description of the step and its limits.
    pub(super) fn words(&self, units: Units) -> String {
        let time = |step: f64| units.of(told_below(step), "s");
        let bodies = self.finite_bodies.map_or_else(String::new, |step| {
            format!(", below {} for all finite bodies", time(step))
        });
        let verdict = match self.too_large_for {
            Some("lattice") => "too large",
            Some(_) => "too large for some bodies",
            None => "stable",
        };
        format!(
            "{}, {verdict}: {} is stable below {} in an infinite lattice{bodies}",
            units.of(told(self.time_step), "s"),
            self.stepping,
            time(self.lattice)
        )
    }

    /// Sentence on a step that is too large, before the sentence on the state.
    pub(super) fn sentence(&self, units: Units, of_state: &str) -> Option<String> {
        let time = |step: f64| units.of(told_below(step), "s");
        let step = units.of(told(self.time_step), "s");
        let stepping = self.stepping;
        let cause = match (self.too_large_for?, self.finite_bodies) {
            ("finite-bodies", Some(limit)) => format!(
                "The time step {step} of the run is too large for some bodies: with {stepping} all finite bodies are stable below {} only.",
                time(limit)
            ),
            _ => format!(
                "Unstable by the time step {step} of the run: the largest stable step of {stepping} is {} in an infinite lattice.",
                time(self.lattice)
            ),
        };
        let mut letters = of_state.chars();
        let first: String = letters
            .next()
            .into_iter()
            .flat_map(char::to_lowercase)
            .collect();
        Some(format!(
            "{cause} In continuous time the state is {first}{}",
            letters.as_str()
        ))
    }
}
