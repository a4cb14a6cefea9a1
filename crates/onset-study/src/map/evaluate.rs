//! The one place at which a map computes a state.

use super::record::{Certainty, Finding, Record};
use crate::answers::{Problem, ProblemError};
use crate::settings::{MapSettings, Settings};
use nalgebra::SVector;
use onset::continuum::AcousticMinimum;
use onset::kinematics::DeformationGradient;
use onset::method::{Method, MethodError};
use onset::verdict::{Assessment, MaterialAssessment, assess, speed_squared};

/// Material and discretization, ready to be asked about states.
pub struct Evaluator {
    problem: Problem,
    method: Option<AnyMethod>,
    /// `rho c^2`, the scale of acoustic eigenvalues; stress.
    stiffness: f64,
    certify: bool,
}

enum AnyMethod {
    Chain(Method<1>),
    Planar(Method<2>),
}

impl Evaluator {
    /// Prepares settings. A method whose support holds too few or too many particles in the undeformed state is admitted:
    /// all its states are undefined.
    ///
    /// # Errors
    /// [`ProblemError`] when the settings are not admissible.
    pub fn new(settings: Settings, map: &MapSettings) -> Result<Self, ProblemError> {
        let material = settings.material.build().map_err(MethodError::from)?;
        let problem = Problem { settings, material };
        let (method, stiffness) = match problem.dimension() {
            1 => {
                let (method, stiffness) = prepared::<1>(&problem)?;
                (method.map(AnyMethod::Chain), stiffness)
            }
            _ => {
                let (method, stiffness) = prepared::<2>(&problem)?;
                (method.map(AnyMethod::Planar), stiffness)
            }
        };
        Ok(Self {
            problem,
            method,
            stiffness,
            certify: map.certify,
        })
    }

    /// Computes a state.
    ///
    /// # Errors
    /// [`ProblemError`] when the material or the method cannot be evaluated there for another reason than its support.
    pub fn record(&self, f: &DeformationGradient) -> Result<Record, ProblemError> {
        match &self.method {
            None => Ok(Record::UNDEFINED),
            Some(AnyMethod::Chain(method)) => self.evaluate(method, f),
            Some(AnyMethod::Planar(method)) => self.evaluate(method, f),
        }
    }

    fn evaluate<const D: usize>(
        &self,
        method: &Method<D>,
        f: &DeformationGradient,
    ) -> Result<Record, ProblemError> {
        let material = &*self.problem.material;
        match assess(method, material, f) {
            Ok(assessment) => Ok(self.assessed(&assessment)),
            Err(error) if error.is_about_support() => {
                let minimum = MaterialAssessment::<D>::new(material, f)
                    .map_err(MethodError::from)?
                    .minimum;
                Ok(self.with_continuum(&minimum, Record::UNDEFINED))
            }
            Err(error) => Err(error.into()),
        }
    }

    fn assessed<const D: usize>(&self, assessment: &Assessment<D>) -> Record {
        let spectrum = &assessment.spectrum;
        let finite = |value: f64| if value.is_finite() { value } else { f64::NAN };
        let record = Record {
            finding: Finding {
                verdict: Some(assessment.verdict),
                stability: Some(spectrum.stability()),
            },
            scaled_minimum: spectrum.softest.scaled,
            wave_vector: components(&spectrum.softest.wave_vector),
            is_long_wave: Some(spectrum.softest.is_long_wave),
            lowest_omega_squared: spectrum.lowest.omega_squared.re,
            growth_rate: spectrum.growth_rate(),
            critical_time_step: finite(spectrum.critical_time_step()),
            measures: [f64::NAN, spectrum.softest.scaled, spectrum.long_wave.scaled],
            certainty: if self.certify {
                Certainty::Undecided
            } else {
                Certainty::NotAsked
            },
            ..Record::UNDEFINED
        };
        self.with_continuum(&assessment.material.minimum, record)
    }

    fn with_continuum<const D: usize>(
        &self,
        minimum: &AcousticMinimum<D>,
        record: Record,
    ) -> Record {
        let [_, scaled, long_wave] = record.measures;
        Record {
            acoustic_minimum: minimum.eigenvalue.re,
            acoustic_direction: components(&minimum.direction),
            measures: [minimum.eigenvalue.re / self.stiffness, scaled, long_wave],
            ..record
        }
    }
}

/// The method, unless its support is at fault, and the scale of acoustic eigenvalues.
fn prepared<const D: usize>(problem: &Problem) -> Result<(Option<Method<D>>, f64), ProblemError> {
    let density = problem.settings.discretization.density;
    match Method::<D>::new(problem.settings.discretization) {
        Ok(method) => {
            let stiffness =
                speed_squared(&method, &*problem.material).map_err(MethodError::from)? * density;
            Ok((Some(method), stiffness))
        }
        Err(error) if error.is_about_support() => Ok((None, f64::NAN)),
        Err(error) => Err(error.into()),
    }
}

fn components<const D: usize>(vector: &SVector<f64, D>) -> [f64; 3] {
    std::array::from_fn(|i| vector.get(i).copied().unwrap_or(f64::NAN))
}
