//! Consequences of the waves of a state for implicit and static solvers.

use crate::number::told_below;
use crate::settings::Units;
use onset::time_step::ImplicitIntegrator;
use onset::verdict::{Assessment, Verdict};
use serde::Serialize;
use std::collections::BTreeMap;

/// Tangent of the discrete system at a state, and the steps of implicit integrators, for an infinite lattice.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImplicitAnswer {
    /// Eigenvalues of the tangent for waves: `positive`, `zero` for a method with zero-energy modes, or `negative`.
    pub tangent: &'static str,
    /// Largest steps for which all eigenvalues of Newton's matrix are positive, by integrator; time. Empty if they are positive for every step.
    pub largest_steps: BTreeMap<&'static str, f64>,
    /// Largest steps for which the fastest growing wave grows in discrete time, by integrator; time. Empty without growth.
    ///
    /// Integrators with growth for every step are left out.
    pub hiding_steps: BTreeMap<&'static str, f64>,
}

impl ImplicitAnswer {
    /// Returns `None` for a state that flutters: the symmetric part of its tangent does not decide.
    pub(super) fn new(assessment: &Assessment<3>) -> Option<Self> {
        let spectrum = &assessment.spectrum;
        if spectrum.flutters {
            return None;
        }
        let grows = !spectrum.is_stable();
        let of = |step: &dyn Fn(ImplicitIntegrator) -> f64| {
            let all = ImplicitIntegrator::ALL.into_iter().filter(|_| grows);
            let steps = all.map(|own| (own.name(), step(own)));
            steps.filter(|(_, step)| step.is_finite()).collect()
        };
        let lowest = spectrum.lowest.omega_squared.re;
        let rate = spectrum.growth_rate();
        Some(Self {
            tangent: match (grows, assessment.verdict) {
                (true, _) => "negative",
                (false, Verdict::ZeroEnergy) => "zero",
                (false, _) => "positive",
            },
            largest_steps: of(&|own| own.largest_definite_step(lowest)),
            hiding_steps: of(&|own| own.shortest_hiding_step(rate)),
        })
    }

    /// Names and texts of the lines of an answer.
    pub(super) fn lines(&self, units: Units) -> Vec<(&'static str, String)> {
        let steps = |steps: &BTreeMap<&'static str, f64>| {
            let one = |(name, step): (&&str, &f64)| {
                format!("{} ({name})", units.of(told_below(*step), "s"))
            };
            steps.iter().map(one).collect::<Vec<_>>().join(", ")
        };
        let tangent = match self.tangent {
            "positive" => {
                "the tangent, and with it Newton's matrix for every step, has only positive eigenvalues"
            }
            "zero" => {
                "the tangent is singular: zero-energy modes, which a static solver needs a control for"
            }
            _ => {
                "the tangent has negative eigenvalues: static equilibrium at this state is not stable, and Newton's method may diverge"
            }
        };
        let mut lines = vec![("implicit solvers", tangent.to_owned())];
        if !self.largest_steps.is_empty() {
            let text = format!(
                "Newton's matrix has only positive eigenvalues for steps below {}",
                steps(&self.largest_steps)
            );
            lines.push(("", text));
        }
        if !self.hiding_steps.is_empty() {
            let text = format!(
                "growth is hidden, the growing mode decays, with steps beyond {}",
                steps(&self.hiding_steps)
            );
            lines.push(("", text));
        }
        lines
    }
}
