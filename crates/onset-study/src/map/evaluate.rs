//! Evaluation of one state of a map.

use super::record::{Finding, Proof, Record};
use crate::answers::{Problem, ProblemError};
use crate::settings::{MapSettings, Settings};
use nalgebra::SVector;
use onset::analysis::Analysis;
use onset::certificate::{Certainty, Certificate};
use onset::continuum::AcousticMinimum;
use onset::kinematics::DeformationGradient;
use onset::material::Hyperelastic;
use onset::method::MethodError;
use onset::time_step::Integrator;
use onset::verdict::{Mechanism, SurveyedState, Verdict};
use std::sync::Arc;

/// Material and discretization, prepared for the evaluation of states.
pub struct Evaluator {
    settings: Settings,
    /// Analysis, or `None` if the support holds too few or too many particles in the reference configuration.
    analysis: Option<Box<dyn Analysis>>,
    /// Analysis for stiffer increments, whose waves limit the time step of a law that yields or relaxes; `None` for other laws.
    stiffer: Option<Box<dyn Analysis>>,
    /// `rho c^2`, the scale of acoustic eigenvalues; stress.
    stiffness: f64,
    /// Largest magnitude of a measure near zero; `None` if no proofs are requested.
    tolerance: Option<f64>,
    /// Integrator whose critical time step is stored.
    integrator: Integrator,
    is_damped: bool,
    /// Whether the method defines its time step.
    is_transferred: bool,
    /// Law of the problem, for the mean stress that names a mechanism.
    material: Option<Arc<dyn Hyperelastic>>,
    /// Whether mechanisms are named, and the time steps of damped waves omitted.
    is_for_verdicts: bool,
    /// Number of wave vectors along each reciprocal vector; `None` for a search over the zone.
    waves: Option<usize>,
}

impl Evaluator {
    /// Prepares the evaluation for the settings; the setup takes a few milliseconds longer if `many` states will follow.
    ///
    /// A method whose support holds too few or too many particles in the reference configuration is accepted: all its states are undefined.
    ///
    /// # Errors
    /// [`ProblemError`] if the settings are not admissible.
    pub fn new(settings: Settings, map: &MapSettings, many: bool) -> Result<Self, ProblemError> {
        let prepared = |analysis: Box<dyn Analysis>| match many {
            true => analysis.for_many_states(),
            false => Ok(analysis),
        };
        let (mut stiffer, mut material) = (None, None);
        let analysis = match Problem::new(settings.clone()) {
            Ok(problem) => {
                material = Some(Arc::clone(&problem.material));
                if settings.material.has_stiffer_increments() {
                    stiffer = Some(prepared(problem.stiffer()?.analysis)?);
                }
                Some(problem.analysis)
            }
            Err(ProblemError::Method { source }) if source.is_about_support() => None,
            Err(error) => return Err(error),
        };
        let integrator = settings.explicit_integrator()?;
        let mut evaluator = Self {
            settings,
            analysis: None,
            stiffer,
            stiffness: f64::NAN,
            tolerance: map.certify.then_some(map.tolerance),
            integrator,
            is_damped: false,
            is_transferred: false,
            material,
            is_for_verdicts: false,
            waves: None,
        };
        let Some(analysis) = analysis else {
            return Ok(evaluator);
        };
        evaluator.stiffness = analysis.speed_squared()? * evaluator.settings.discretization.density;
        evaluator.is_damped = analysis.is_damped();
        evaluator.is_transferred = analysis.is_transferred();
        evaluator.analysis = Some(prepared(analysis)?);
        Ok(evaluator)
    }

    /// Names the mechanism of each numerical instability, and omits the time steps of damped waves, whose search takes most of the time.
    pub fn for_verdicts(self) -> Self {
        Self {
            is_for_verdicts: true,
            ..self
        }
    }

    /// Samples `waves` wave vectors along each reciprocal vector instead of searching the zone.
    pub fn sampled(self, waves: usize) -> Self {
        Self {
            waves: Some(waves),
            ..self
        }
    }

    /// States of an analysis, searched or sampled.
    fn surveyed_states(
        &self,
        analysis: &dyn Analysis,
        states: &[DeformationGradient],
    ) -> Vec<Result<SurveyedState<3>, MethodError>> {
        match self.waves {
            Some(count) => analysis.sampled_states(states, count),
            None => analysis.states(states),
        }
    }

    /// Mechanism of a numerical instability, as [`Assessment::mechanism`](onset::verdict::Assessment::mechanism).
    fn mechanism(&self, f: &DeformationGradient, state: &SurveyedState<3>) -> Option<Mechanism> {
        let material = self.material.as_ref()?;
        let response = material.response(f).ok()?;
        let mean = response.mean_stress(self.settings.dimension());
        Some(Mechanism::of(state.stability, state.long_waves_grow, mean))
    }

    /// Returns the record of each state, in order. The record of a state does not depend on the other states.
    ///
    /// # Errors
    /// [`ProblemError`] if material or method cannot be evaluated at a state. The record is undefined instead if the law is not defined there, or if the
    /// support holds too few or too many particles.
    pub fn records(&self, states: &[DeformationGradient]) -> Vec<Result<Record, ProblemError>> {
        let Some(analysis) = self.analysis.as_deref() else {
            return states.iter().map(|_| Ok(Record::UNDEFINED)).collect();
        };
        let stiffer = self.stiffer.as_deref();
        let mut stiffer = stiffer.map(|own| (own, self.surveyed_states(own, states).into_iter()));
        let surveyed = self.surveyed_states(analysis, states);
        let records = states.iter().zip(surveyed);
        records
            .map(|(f, surveyed)| {
                // Taken first, so that an error of a state leaves the others in step.
                let faster = stiffer
                    .as_mut()
                    .and_then(|(own, states)| Some((*own, states.next()?)));
                let mut record = self.record(analysis, f, surveyed)?;
                if let Some((own, Ok(state))) = faster {
                    let step = match self.is_transferred {
                        true => own.transferred(f)?.map(|waves| waves.critical_time_step()),
                        false => Some(self.time_step(own, f, &state)?),
                    };
                    // An undefined step is NaN, which the minimum ignores.
                    let step = step.unwrap_or(f64::INFINITY).min(record.critical_time_step);
                    record.critical_time_step = if step.is_finite() { step } else { f64::NAN };
                }
                Ok(record)
            })
            .collect()
    }

    /// Critical time step of the integrator for the waves of a state; infinite if nothing oscillates.
    fn time_step(
        &self,
        analysis: &dyn Analysis,
        f: &DeformationGradient,
        state: &SurveyedState<3>,
    ) -> Result<f64, MethodError> {
        if self.is_damped && self.is_for_verdicts {
            return Ok(f64::NAN);
        }
        if self.is_damped {
            return analysis.critical_time_step(f, self.integrator);
        }
        // The state holds the time step of central differences.
        let reach = Integrator::CentralDifferences.undamped_reach();
        Ok(state.critical_time_step() * (self.integrator.undamped_reach() / reach))
    }

    fn record(
        &self,
        analysis: &dyn Analysis,
        f: &DeformationGradient,
        surveyed: Result<SurveyedState<3>, MethodError>,
    ) -> Result<Record, ProblemError> {
        match surveyed {
            Ok(state) => {
                let mut record = self.surveyed(&state);
                if self.is_for_verdicts && state.verdict == Verdict::Numerical {
                    record.mechanism = self.mechanism(f, &state);
                }
                let step = self.time_step(analysis, f, &state)?;
                record.critical_time_step = if step.is_finite() { step } else { f64::NAN };
                if self.is_transferred {
                    record = self.in_discrete_time(analysis, f, record)?;
                }
                match self.tolerance {
                    Some(tolerance) => {
                        let certificate = analysis.certify(f, tolerance)?;
                        Ok(self.certified(record, &state, &certificate))
                    }
                    None => Ok(record),
                }
            }
            Err(error) if error.is_about_support() => {
                let minimum = analysis.acoustic_minimum(f).map_err(MethodError::from)?;
                Ok(self.with_continuum(&minimum, Record::UNDEFINED))
            }
            Err(error) if error.is_outside_domain() => Ok(Record::UNDEFINED),
            Err(error) => Err(error.into()),
        }
    }

    /// Time step and growth rate of a method that defines its time step.
    fn in_discrete_time(
        &self,
        analysis: &dyn Analysis,
        f: &DeformationGradient,
        record: Record,
    ) -> Result<Record, MethodError> {
        let Some(waves) = analysis.transferred(f)? else {
            return Ok(record);
        };
        let largest = Some(waves.critical_time_step()).filter(|step| step.is_finite());
        let step = self.settings.method.step_of_rates(largest);
        let growth = step.map(|step| waves.fastest(step).0.re);
        Ok(Record {
            critical_time_step: largest.unwrap_or(f64::NAN),
            growth_rate: growth.unwrap_or(record.growth_rate),
            ..record
        })
    }

    fn surveyed(&self, state: &SurveyedState<3>) -> Record {
        let record = Record {
            finding: Finding {
                verdict: Some(state.verdict),
                stability: Some(state.stability),
            },
            scaled_minimum: state.scaled_minimum,
            wave_vector: self.components(&state.wave_vector),
            is_long_wave: Some(state.is_long_wave),
            lowest_omega_squared: state.lowest_omega_squared,
            growth_rate: state.growth_rate,
            measures: [f64::NAN, state.scaled_minimum, state.long_wave_minimum],
            ..Record::UNDEFINED
        };
        self.with_continuum(&state.acoustic, record)
    }

    /// Record corrected by a certificate: proofs take precedence over the search.
    fn certified(
        &self,
        record: Record,
        state: &SurveyedState<3>,
        certificate: &Certificate<3>,
    ) -> Record {
        let (verdict, stability) = certificate.corrected(state);
        let finding = Finding {
            verdict: Some(verdict),
            stability: Some(stability),
        };
        let growth_rate = match &certificate.discretization {
            Certainty::Stable { .. } | Certainty::ZeroEnergy { .. } => 0.0,
            Certainty::Unstable { witness } => {
                let discretization = &self.settings.discretization;
                let speed = (self.stiffness / discretization.density).sqrt();
                let proved = witness.growth_rate * speed / discretization.spacing;
                record.growth_rate.max(proved)
            }
            Certainty::Undecided { .. } => record.growth_rate,
        };
        Record {
            finding,
            growth_rate,
            proof: Proof::of(certificate, finding != record.finding),
            ..record
        }
    }

    fn with_continuum(&self, minimum: &AcousticMinimum<3>, record: Record) -> Record {
        let [_, scaled, long_wave] = record.measures;
        Record {
            acoustic_minimum: minimum.significant(),
            acoustic_direction: self.components(&minimum.direction),
            measures: [minimum.significant() / self.stiffness, scaled, long_wave],
            ..record
        }
    }
    /// Components of a vector; those beyond the number of dimensions are NaN.
    fn components(&self, vector: &SVector<f64, 3>) -> [f64; 3] {
        let dimension = self
            .analysis
            .as_ref()
            .map_or(3, |analysis| analysis.dimension());
        std::array::from_fn(|i| if i < dimension { vector[i] } else { f64::NAN })
    }
}
