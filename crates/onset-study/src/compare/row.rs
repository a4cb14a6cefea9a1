//! Measures of one method.

use crate::answers::{BodyStepAnswer, LATTICE_NOTE, Problem, ProblemError};
use crate::settings::{CompareSettings, Effective, Settings};
use onset::kinematics::DeformationGradient;
use onset::material::Hyperelastic;
use onset::measures::{DispersionError, Extent, Fidelity, Load, OnsetPair, StateWindow};
use onset::motion::BodyError;
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};
use std::sync::Arc;

/// Wavelengths at which frequencies are compared, in particle spacings.
pub const WAVELENGTHS: [f64; 3] = [4.0, 8.0, 16.0];
/// Wavelength in the short table, in particle spacings.
pub(super) const SHORT_WAVELENGTH: f64 = 8.0;

/// Method of a comparison with its settings and measures.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Name of the method.
    pub name: String,
    /// All settings in effect.
    pub settings: Effective,
    /// Notes on the method.
    pub notes: Vec<String>,
    /// Measures, or the reason why the method cannot be evaluated.
    #[serde(flatten, serialize_with = "outcome")]
    pub measured: Result<Measured, String>,
}

/// Serializes the measures as `measured`, or the reason why they are missing as `note`.
pub(crate) fn outcome<S: Serializer>(
    measured: &Result<Measured, String>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut fields = serializer.serialize_struct("Outcome", 2)?;
    fields.serialize_field("measured", &measured.as_ref().ok())?;
    fields.serialize_field("note", &measured.as_ref().err())?;
    fields.end()
}

/// Measures of a method, in the reference configuration unless stated otherwise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Number of wave vectors with zero-energy modes. `k` and `-k` count once, and so does each connected line or surface.
    pub zero_modes: usize,
    /// Largest extent of the zero-energy modes; `None` without such modes.
    pub zero_extent: Option<Extent>,
    /// Whether all zero-energy modes have been found.
    pub zero_modes_complete: bool,
    /// Number of weakly controlled modes: minima of the relative frequency below its limit.
    pub weak_modes: usize,
    /// Smallest ratio of a wave's frequency to the frequency of the slowest material wave with the same wave vector.
    ///
    /// 0 with zero-energy modes, 1 if no wave is slower than in the material, NaN if nothing can be compared.
    pub weakest: f64,
    /// Errors of frequencies for each wavelength.
    pub dispersion: Vec<DispersionError>,
    /// Largest error of a component of the long-wavelength moduli.
    pub long_wave_error: f64,
    /// Onsets of instability for each loading.
    pub onsets: Vec<OnsetPair>,
    /// Verdicts over the window of states.
    pub fidelity: Fidelity,
    /// Critical time step; time.
    pub critical_time_step: f64,
    /// Range of validity of the critical time step: the infinite lattice.
    pub critical_time_step_of: &'static str,
    /// Critical time step of the body in the study, in the reference state; omitted for methods without bodies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<BodyStepAnswer>,
    /// Courant number: critical time step times the speed of sound divided by the particle spacing.
    pub courant: f64,
    /// Courant number of the body in the study; `null` without a body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body_courant: Option<f64>,
    /// Number of particles visited by an evaluation of the forces on one particle.
    pub neighbors: f64,
}

impl Measured {
    /// Returns true if a wave is slower than the given fraction of the slowest material wave.
    pub(crate) fn is_weak(&self, share: f64) -> bool {
        self.weakest < share
    }

    /// Evaluates all measures of a method; the material may be shared.
    ///
    /// # Errors
    /// [`ProblemError`] if the method is not admissible, or cannot be evaluated at a state for any reason other than its support or the domain of the
    /// law.
    pub fn of(
        settings: &Settings,
        material: Arc<dyn Hyperelastic>,
        options: &CompareSettings,
    ) -> Result<Self, ProblemError> {
        let problem = Problem::with_law(settings.clone(), material)?;
        let analysis = &problem.analysis;
        let spurious = analysis.spurious_modes(options.weak)?;
        let zero_modes = spurious.modes.iter().filter(|mode| mode.is_zero()).count();
        let onsets = Load::ALL
            .into_iter()
            .filter(|load| load.is_possible(analysis.dimension()))
            .map(|load| {
                let end = if load.is_tension() {
                    options.tension
                } else {
                    options.compression
                };
                analysis.onset(load, end)
            })
            .collect::<Result<_, _>>()?;
        let window = StateWindow {
            stretches: options.stretches,
            states: options.states,
        };
        let rest = DeformationGradient::identity();
        let stiffer = problem.stiffer_at(&rest)?;
        let fastest = stiffer.as_ref().unwrap_or(&problem);
        let integrator = settings.explicit_integrator()?;
        let step = fastest.analysis.critical_time_step(&rest, integrator)?;
        let passage = analysis.speed_squared()?.sqrt() / analysis.spacing();
        let body = match BodyStepAnswer::new(fastest, &rest, integrator) {
            Err(ProblemError::Body {
                source: BodyError::NoBodies,
            }) => None,
            found => found?,
        };
        Ok(Self {
            zero_modes,
            zero_extent: spurious.zero_extent,
            zero_modes_complete: spurious.is_complete,
            weak_modes: spurious.modes.len() - zero_modes,
            weakest: spurious.weakest.unwrap_or(f64::NAN),
            dispersion: analysis.dispersion_errors(&WAVELENGTHS)?,
            long_wave_error: analysis.long_wave_error()?,
            onsets,
            fidelity: analysis.fidelity(&window)?,
            critical_time_step: step,
            critical_time_step_of: LATTICE_NOTE,
            body,
            courant: step * passage,
            body_courant: body
                .and_then(|body| body.time_step)
                .map(|step| step * passage),
            neighbors: analysis.neighbors(),
        })
    }

    /// Error of the frequencies at a wavelength; NaN if it was not computed.
    pub fn dispersion_at(&self, particles: f64) -> f64 {
        let mut known = self.dispersion.iter();
        known
            .find(|error| error.particles_per_wavelength == particles)
            .map_or(f64::NAN, |error| error.error)
    }

    /// Cost of simulating a given time, `neighbors / courant`.
    ///
    /// Number of particles visited while sound travels one spacing.
    pub fn cost(&self) -> f64 {
        self.neighbors / self.courant
    }
}
