//! The one place at which a map computes a state.

use super::record::{Finding, Proof, Record};
use crate::answers::ProblemError;
use crate::methods::Discretized;
use crate::settings::{MapSettings, Settings};
use nalgebra::SVector;
use onset::certificate::{Certainty, Certificate, Certifier, Foundation};
use onset::continuum::AcousticMinimum;
use onset::kinematics::DeformationGradient;
use onset::material::Hyperelastic;
use onset::method::MethodError;
use onset::scheme::Scheme;
use onset::time_step::Integrator;
use onset::verdict::{MaterialAssessment, SchemeSurvey, Survey, SurveyedState};

/// Material and discretization, ready to be asked about states.
pub struct Evaluator {
    settings: Settings,
    method: Option<AnyMethod>,
    /// `rho c^2`, the scale of acoustic eigenvalues; stress.
    stiffness: f64,
    tolerance: f64,
    /// Whose critical time step is told.
    integrator: Integrator,
}

enum AnyMethod {
    Chain(Box<Prepared<1>>),
    Planar(Box<Prepared<2>>),
    Spatial(Box<Prepared<3>>),
}

/// Method and material.
#[expect(
    clippy::large_enum_variant,
    reason = "always kept behind a box, once a study"
)]
enum Prepared<const D: usize> {
    /// A kernel method, with what is proved before any state if proofs are asked for.
    Kernel {
        survey: Survey<D>,
        foundation: Option<Foundation<D>>,
    },
    /// Any other method.
    Scheme {
        scheme: Box<dyn Scheme<D>>,
        material: Box<dyn Hyperelastic>,
    },
}

impl Evaluator {
    /// Prepares settings, for `many` states if it pays to spend some milliseconds before the first. A method whose support
    /// holds too few or too many particles in the undeformed state is admitted: all its states are undefined.
    ///
    /// # Errors
    /// [`ProblemError`] when the settings are not admissible.
    pub fn new(settings: Settings, map: &MapSettings, many: bool) -> Result<Self, ProblemError> {
        let (method, stiffness) = match settings.dimension() {
            1 => {
                let (prepared, stiffness) = prepared::<1>(&settings, map, many)?;
                (prepared.map(AnyMethod::Chain), stiffness)
            }
            2 => {
                let (prepared, stiffness) = prepared::<2>(&settings, map, many)?;
                (prepared.map(AnyMethod::Planar), stiffness)
            }
            _ => {
                let (prepared, stiffness) = prepared::<3>(&settings, map, many)?;
                (prepared.map(AnyMethod::Spatial), stiffness)
            }
        };
        Ok(Self {
            settings,
            method,
            stiffness,
            tolerance: map.tolerance,
            integrator: map.integrator,
        })
    }

    /// Computes states, each as it would be computed alone.
    ///
    /// # Errors
    /// [`ProblemError`] when the material or the method cannot be evaluated at one for another reason than its support.
    pub fn records(&self, states: &[DeformationGradient]) -> Vec<Result<Record, ProblemError>> {
        match &self.method {
            None => states.iter().map(|_| Ok(Record::UNDEFINED)).collect(),
            Some(AnyMethod::Chain(method)) => self.evaluate(method, states),
            Some(AnyMethod::Planar(method)) => self.evaluate(method, states),
            Some(AnyMethod::Spatial(method)) => self.evaluate(method, states),
        }
    }

    fn evaluate<const D: usize>(
        &self,
        prepared: &Prepared<D>,
        states: &[DeformationGradient],
    ) -> Vec<Result<Record, ProblemError>> {
        match prepared {
            Prepared::Kernel { survey, foundation } => {
                let (method, material) = (survey.method(), survey.material());
                let certifier = foundation.map(|foundation| {
                    Certifier::founded(foundation, method, material, self.tolerance)
                });
                let records = states.iter().zip(survey.states(states));
                records
                    .map(|(f, surveyed)| self.record(material, certifier.as_ref(), f, surveyed))
                    .collect()
            }
            Prepared::Scheme { scheme, material } => {
                let survey = SchemeSurvey::new(&**scheme, &**material);
                let state = |f: &DeformationGradient| {
                    let surveyed = match &survey {
                        Ok(survey) => survey.state(f),
                        Err(error) => Err(error.clone()),
                    };
                    let record = self.record::<D>(&**material, None, f, surveyed)?;
                    match &survey {
                        Ok(survey) if survey.is_damped() && record.finding.verdict.is_some() => {
                            let step = survey.critical_time_step(f, self.integrator)?;
                            Ok(Record {
                                critical_time_step: if step.is_finite() { step } else { f64::NAN },
                                ..record
                            })
                        }
                        _ => Ok(record),
                    }
                };
                states.iter().map(state).collect()
            }
        }
    }

    fn record<const D: usize>(
        &self,
        material: &dyn Hyperelastic,
        certifier: Option<&Certifier<'_, D>>,
        f: &DeformationGradient,
        surveyed: Result<SurveyedState<D>, MethodError>,
    ) -> Result<Record, ProblemError> {
        match surveyed {
            Ok(state) => {
                let record = self.surveyed(&state);
                match certifier {
                    Some(certifier) => Ok(self.certified(record, &state, &certifier.certify(f)?)),
                    None => Ok(record),
                }
            }
            Err(error) if error.is_about_support() => {
                let minimum = MaterialAssessment::<D>::new(material, f)
                    .map_err(MethodError::from)?
                    .minimum;
                Ok(self.with_continuum(&minimum, Record::UNDEFINED))
            }
            Err(error) if error.is_outside_domain() => Ok(Record::UNDEFINED),
            Err(error) => Err(error.into()),
        }
    }

    fn surveyed<const D: usize>(&self, state: &SurveyedState<D>) -> Record {
        let step = state.critical_time_step();
        let record = Record {
            finding: Finding {
                verdict: Some(state.verdict),
                stability: Some(state.stability),
            },
            scaled_minimum: state.scaled_minimum,
            wave_vector: components(&state.wave_vector),
            is_long_wave: Some(state.is_long_wave),
            lowest_omega_squared: state.lowest_omega_squared,
            growth_rate: state.growth_rate,
            critical_time_step: if step.is_finite() { step } else { f64::NAN },
            measures: [f64::NAN, state.scaled_minimum, state.long_wave_minimum],
            ..Record::UNDEFINED
        };
        self.with_continuum(&state.acoustic, record)
    }

    /// What is proved goes before what the search has found.
    fn certified<const D: usize>(
        &self,
        record: Record,
        state: &SurveyedState<D>,
        certificate: &Certificate<D>,
    ) -> Record {
        let (verdict, stability) = certificate.corrected(state);
        let finding = Finding {
            verdict: Some(verdict),
            stability: Some(stability),
        };
        let growth_rate = match &certificate.discretization {
            Certainty::Stable { .. } | Certainty::RankDeficient { .. } => 0.0,
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

    fn with_continuum<const D: usize>(
        &self,
        minimum: &AcousticMinimum<D>,
        record: Record,
    ) -> Record {
        let [_, scaled, long_wave] = record.measures;
        Record {
            acoustic_minimum: minimum.significant(),
            acoustic_direction: components(&minimum.direction),
            measures: [minimum.significant() / self.stiffness, scaled, long_wave],
            ..record
        }
    }
}

/// The survey, unless the method's support is at fault, and the scale of acoustic eigenvalues.
fn prepared<const D: usize>(
    settings: &Settings,
    map: &MapSettings,
    many: bool,
) -> Result<(Option<Box<Prepared<D>>>, f64), ProblemError> {
    let density = settings.discretization.density;
    let material = settings.material.build().map_err(MethodError::from)?;
    let prepared = match Discretized::<D>::new(settings) {
        Ok(Discretized::Kernel(method)) => {
            let mut survey = Survey::new(*method, material).map_err(MethodError::from)?;
            let stiffness = survey.speed_squared() * density;
            if many {
                survey = survey.for_many_states()?;
            }
            let foundation = if map.certify {
                let certifier = Certifier::new(survey.method(), survey.material(), map.tolerance)?;
                Some(certifier.foundation())
            } else {
                None
            };
            return Ok((
                Some(Box::new(Prepared::Kernel { survey, foundation })),
                stiffness,
            ));
        }
        Ok(Discretized::Scheme(_)) if map.certify => {
            return Err(MethodError::Incompatible {
                choice: "map.certify",
                other: "a method other than a kernel method with one particle in a cell",
                hint: "leave it out; the search over the zone answers for all methods",
            }
            .into());
        }
        Ok(Discretized::Scheme(scheme)) => Prepared::Scheme { scheme, material },
        Err(error) if error.is_about_support() => return Ok((None, f64::NAN)),
        Err(error) => return Err(error.into()),
    };
    let stiffness = match &prepared {
        Prepared::Scheme { scheme, material } => {
            SchemeSurvey::new(&**scheme, &**material)?.speed_squared() * density
        }
        Prepared::Kernel { survey, .. } => survey.speed_squared() * density,
    };
    Ok((Some(Box::new(prepared)), stiffness))
}

fn components<const D: usize>(vector: &SVector<f64, D>) -> [f64; 3] {
    std::array::from_fn(|i| vector.get(i).copied().unwrap_or(f64::NAN))
}
