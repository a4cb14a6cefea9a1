//! Consequences of the waves of a state for implicit and static solvers.

use crate::number::{told_above, told_below};
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
    /// Largest steps for which the fastest growing wave grows in discrete time, by integrator; time. Empty if no wave grows, or if this wave flutters.
    ///
    /// Integrators are omitted if the wave grows for every step. Slower waves grow in longer steps too.
    pub growing_steps: BTreeMap<&'static str, f64>,
}

impl ImplicitAnswer {
    /// Describes the implicit integrators, or one of them alone.
    pub(super) fn new(spectrum: &SpectrumSummary<3>, only: Option<ImplicitIntegrator>) -> Self {
        let softest = spectrum.softest.scaled;
        let lowest = spectrum.lowest.omega_squared.re;
        let fastest = spectrum.fastest_growing.omega_squared;
        // Waves that flutter have complex factors, which reach -1 for no step.
        let rate = match fastest.im == 0.0 {
            true => spectrum.growth_rate(),
            false => 0.0,
        };
        let of = |step: &dyn Fn(ImplicitIntegrator) -> f64| {
            let meant = ImplicitIntegrator::ALL.into_iter();
            let meant = meant.filter(|own| only.is_none_or(|only| only == *own));
            let steps = meant.map(|own| (own.name(), step(own)));
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
                "without damping Newton's matrix has only positive eigenvalues for steps below {}",
                steps(&self.largest_steps, &told_below)
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
        lines
    }
}
