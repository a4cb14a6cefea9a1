//! The states of a study, asked one by one.

use crate::answers::{Problem, ProblemError};
use crate::settings::Study;
use nalgebra::Matrix3;
use onset::kinematics::DeformationGradient;
use onset::method::{Method, MethodError};
use onset::verdict::{DiscretizationProbe, Probe, probe_material};

/// What all states of a study share: nothing when an axis varies material or discretization.
pub(super) struct Setup<'s, const D: usize> {
    study: &'s Study,
    shared: Option<(Problem, Method<D>)>,
}

/// The questions.
pub(super) struct Probes<'a, const D: usize> {
    study: &'a Study,
    shared: Option<(&'a Problem, DiscretizationProbe<'a, D>)>,
}

impl<'s, const D: usize> Setup<'s, D> {
    pub(super) fn new(study: &'s Study) -> Result<Self, ProblemError> {
        let shared = if study.varies_settings() {
            None
        } else {
            let problem = Problem::new(study.settings.clone())?;
            let method = problem.method()?;
            Some((problem, method))
        };
        Ok(Self { study, shared })
    }

    pub(super) fn probes(&self) -> Result<Probes<'_, D>, ProblemError> {
        let shared = match &self.shared {
            Some((problem, method)) => Some((problem, probe(problem, method)?)),
            None => None,
        };
        Ok(Probes {
            study: self.study,
            shared,
        })
    }
}

fn probe<'a, const D: usize>(
    problem: &'a Problem,
    method: &'a Method<D>,
) -> Result<DiscretizationProbe<'a, D>, ProblemError> {
    Ok(DiscretizationProbe::new(method, &*problem.material).map_err(MethodError::from)?)
}

impl<const D: usize> Probes<'_, D> {
    fn state(&self, at: [f64; 2]) -> Result<DeformationGradient, ProblemError> {
        Ok(self.study.deformation_at(&at)?)
    }

    /// Asks with the problem of a state.
    fn with_problem<T>(
        &self,
        at: [f64; 2],
        ask: impl FnOnce(&Problem) -> Result<T, ProblemError>,
    ) -> Result<T, ProblemError> {
        match &self.shared {
            Some((problem, _)) => ask(problem),
            None => ask(&Problem::new(self.study.settings_at(&at)?)?),
        }
    }

    /// Strong ellipticity.
    pub(super) fn material(&self, at: [f64; 2]) -> Result<Probe, ProblemError> {
        let f = self.state(at)?;
        self.with_problem(at, |problem| {
            Ok(probe_material::<D>(&*problem.material, &f).map_err(MethodError::from)?)
        })
    }

    /// The stability of the particles.
    pub(super) fn discretization(&self, at: [f64; 2]) -> Result<Probe, ProblemError> {
        let f = self.state(at)?;
        if let Some((_, shared)) = &self.shared {
            return Ok(shared.at(&f)?);
        }
        self.with_problem(at, |problem| {
            let method = problem.method::<D>()?;
            Ok(probe(problem, &method)?.at(&f)?)
        })
    }

    /// The Cauchy stress.
    pub(super) fn cauchy(&self, at: [f64; 2]) -> Result<Matrix3<f64>, ProblemError> {
        let f = self.state(at)?;
        self.with_problem(at, |problem| {
            let response = problem.material.response(&f).map_err(MethodError::from)?;
            Ok(response.cauchy())
        })
    }
}
