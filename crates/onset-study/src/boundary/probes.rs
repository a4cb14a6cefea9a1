//! Evaluation of single states of a study.

use crate::answers::{Problem, ProblemError, notes, zero_energy};
use crate::settings::Study;
use nalgebra::Matrix3;
use onset::analysis::probe_material_in;
use onset::kinematics::DeformationGradient;
use onset::method::MethodError;
use onset::verdict::{Probe, Verdict};

/// Probes of a study; the problem is shared unless an axis varies material or discretization.
pub(super) struct Probes<'s> {
    study: &'s Study,
    shared: Option<Problem>,
}

impl<'s> Probes<'s> {
    pub(super) fn new(study: &'s Study) -> Result<Self, ProblemError> {
        let shared = match study.varies_settings() {
            true => None,
            false => Some(Problem::new(study.settings.clone())?),
        };
        Ok(Self { study, shared })
    }

    /// Evaluates a function at a state with its problem.
    fn asked<T>(
        &self,
        at: [f64; 2],
        ask: impl FnOnce(&Problem, &DeformationGradient) -> Result<T, MethodError>,
    ) -> Result<T, ProblemError> {
        let f = self.study.deformation_at(&at)?;
        Ok(match &self.shared {
            Some(problem) => ask(problem, &f)?,
            None => ask(&Problem::new(self.study.settings_at(&at)?)?, &f)?,
        })
    }

    /// Notes on law, method and zero-energy modes in the reference configuration; empty if an axis varies them.
    pub(super) fn notes(&self) -> Vec<String> {
        let Some(problem) = &self.shared else {
            return Vec::new();
        };
        let mut notes = notes(&problem.settings, &*problem.material);
        // A law without a response in the reference configuration is reported elsewhere.
        let judged = problem
            .analysis
            .judge(&DeformationGradient::identity(), None);
        if judged.is_ok_and(|judged| judged.verdict == Verdict::ZeroEnergy) {
            notes.push(zero_energy(
                "in the reference configuration the particles have",
                "here",
            ));
        }
        notes
    }

    /// Phase and measure for strong ellipticity.
    pub(super) fn material(&self, at: [f64; 2]) -> Result<Probe, ProblemError> {
        self.asked(at, |problem, f| {
            let material = &*problem.material;
            Ok(probe_material_in(problem.dimension(), material, f)?)
        })
    }

    /// Phase and measure for the stability of the particles.
    pub(super) fn discretization(&self, at: [f64; 2]) -> Result<Probe, ProblemError> {
        self.asked(at, |problem, f| problem.analysis.probe(f))
    }

    /// Cauchy stress at a state.
    pub(super) fn cauchy(&self, at: [f64; 2]) -> Result<Matrix3<f64>, ProblemError> {
        self.asked(at, |problem, f| Ok(problem.material.response(f)?.cauchy()))
    }
}
