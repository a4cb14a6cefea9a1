//! Consequences of the waves of a state for implicit and static solvers.

use super::mode::finite_wave_vector;
use super::state::list;
use crate::number::{told, told_above, told_below, told_with, vector};
use crate::settings::Units;
use onset::bloch::SpectrumSummary;
use onset::time_step::ImplicitIntegrator;
use serde::Serialize;
use std::collections::BTreeMap;

/// Tangent of the discrete system at a state, and the steps of implicit integrators without damping, for an infinite lattice.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImplicitAnswer {
    /// Sign of the smallest real part of the eigenvalues of the tangent for waves: `positive`, `zero` or `negative`.
    pub tangent: &'static str,
    /// Largest steps for which all eigenvalues of Newton's matrix have positive real parts, by integrator; time. Empty if they do for every step.
    pub largest_steps: BTreeMap<&'static str, f64>,
    /// Wave with the lowest `omega^2`, which makes Newton's matrix indefinite first: reference wave vector, zero for a long wave. 1/length.
    pub wave_vector: Vec<f64>,
    /// Accuracy of the integrators for oscillations, by name.
    pub accuracy: BTreeMap<&'static str, Accuracy>,
    /// Largest steps for which the fastest growing wave grows in discrete time, by integrator; time. Empty if no wave grows, or if this wave flutters.
    ///
    /// Integrators are omitted if the wave grows for every step. Slower waves grow in longer steps too.
    pub growing_steps: BTreeMap<&'static str, f64>,
}

/// Accuracy of an implicit integrator for undamped oscillations. It has no largest stable step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Accuracy {
    /// Spectral radius for oscillations that are fast compared with the step; 1 for no numerical damping, 0 for none left after a step.
    pub spectral_radius_at_infinity: f64,
    /// Relative error of the period with 20 steps a period, positive if it is too long.
    pub period_error: f64,
    /// Fraction of the amplitude that is lost in a period of 20 steps.
    pub amplitude_loss: f64,
}

/// Steps per period for which the accuracy is given.
const STEPS_PER_PERIOD: f64 = 20.0;

impl Accuracy {
    fn of(integrator: ImplicitIntegrator) -> Self {
        let phase = std::f64::consts::TAU / STEPS_PER_PERIOD;
        let radius = integrator.spectral_radius(phase);
        Self {
            spectral_radius_at_infinity: integrator.spectral_radius_at_infinity(),
            period_error: integrator.period_error(phase),
            // A smaller loss is rounding.
            amplitude_loss: Some(1.0 - radius.powf(STEPS_PER_PERIOD))
                .filter(|loss| *loss > 1e-12)
                .unwrap_or(0.0),
        }
    }
}

impl ImplicitAnswer {
    /// Describes the implicit integrators, or one of them alone.
    pub(super) fn new(
        spectrum: &SpectrumSummary<3>,
        dimension: usize,
        only: Option<ImplicitIntegrator>,
    ) -> Self {
        let meant = |own: &ImplicitIntegrator| only.is_none_or(|only| only == *own);
        let meant = ImplicitIntegrator::ALL.into_iter().filter(meant);
        let softest = spectrum.softest.scaled;
        let lowest = spectrum.lowest.omega_squared.re;
        let fastest = spectrum.fastest_growing.omega_squared;
        // Waves that flutter have complex factors, which reach -1 for no step.
        let rate = match fastest.im == 0.0 {
            true => spectrum.growth_rate(),
            false => 0.0,
        };
        let of = |step: &dyn Fn(ImplicitIntegrator) -> f64| {
            let steps = meant.clone().map(|own| (own.name(), step(own)));
            let finite = steps.filter(|(_, step)| step.is_finite());
            finite.collect::<BTreeMap<_, _>>()
        };
        let (tangent, largest_steps) = if softest < -spectrum.tolerance {
            ("negative", of(&|own| own.largest_definite_step(lowest)))
        } else if softest > spectrum.tolerance {
            ("positive", BTreeMap::new())
        } else {
            ("zero", BTreeMap::new())
        };
        Self {
            tangent,
            largest_steps,
            wave_vector: list(dimension, &finite_wave_vector(&spectrum.lowest)),
            accuracy: meant
                .clone()
                .map(|own| (own.name(), Accuracy::of(own)))
                .collect(),
            growing_steps: of(&|own| own.largest_growing_step(rate)),
        }
    }

    /// Names and texts of the lines of an answer.
    pub(super) fn lines(&self, units: Units) -> Vec<(&'static str, String)> {
        let steps = |steps: &BTreeMap<&'static str, f64>, told: &dyn Fn(f64) -> String| {
            let one =
                |(name, step): (&&str, &f64)| format!("{} ({name})", units.of(told(*step), "s"));
            steps.iter().map(one).collect::<Vec<_>>().join(", ")
        };
        let tangent = match self.tangent {
            "positive" => {
                "the tangent, and with it Newton's matrix for every step, has only positive eigenvalues"
            }
            "zero" => "the tangent is singular: some waves have no stiffness",
            _ => {
                "the tangent has negative eigenvalues: static equilibrium is not stable, and Newton's method may diverge"
            }
        };
        let mut lines = vec![("implicit solvers", tangent.to_owned())];
        if !self.largest_steps.is_empty() {
            let text = format!(
                "without damping Newton's matrix has only positive eigenvalues for steps below {}; the first wave without is k = {}",
                steps(&self.largest_steps, &told_below),
                units.of(vector(&self.wave_vector), "1/m")
            );
            lines.push(("", text));
        }
        if !self.growing_steps.is_empty() {
            let text = format!(
                "the fastest growing wave decays for steps above {}; slower waves still grow",
                steps(&self.growing_steps, &told_above)
            );
            lines.push(("", text));
        }
        let accuracy = self.accuracy.iter().map(|(name, own)| {
            format!(
                "{name}: periods {} % too long, {} % of the amplitude lost in a period of 20 steps, spectral radius {} for fast waves",
                told_with(100.0 * own.period_error, 2),
                told_with(100.0 * own.amplitude_loss, 2),
                told(own.spectral_radius_at_infinity)
            )
        });
        lines.extend(accuracy.map(|text| ("", text)));
        lines
    }
}
