//! What is measured of one method.

use crate::answers::{BodyStepAnswer, OF_LATTICE, Problem, ProblemError};
use crate::settings::{CompareSettings, Effective, Settings};
use onset::kinematics::DeformationGradient;
use onset::material::Hyperelastic;
use onset::measures::{DispersionError, Extent, Fidelity, Load, OnsetPair, StateWindow};
use onset::motion::BodyError;
use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};
use std::sync::Arc;

/// Wavelengths, in particle spacings, at which frequencies are compared.
pub const WAVELENGTHS: [f64; 3] = [4.0, 8.0, 16.0];

/// A method of a comparison.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// How it is called.
    pub name: String,
    /// Every choice in effect.
    pub settings: Effective,
    /// What a reader must know of the method.
    pub notes: Vec<String>,
    /// What is measured, or why nothing is.
    #[serde(flatten, serialize_with = "outcome")]
    pub measured: Result<Measured, String>,
}

/// What is measured as `measured`, or why nothing is as `note`.
pub(crate) fn outcome<S: Serializer>(
    measured: &Result<Measured, String>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut fields = serializer.serialize_struct("Outcome", 2)?;
    fields.serialize_field("measured", &measured.as_ref().ok())?;
    fields.serialize_field("note", &measured.as_ref().err())?;
    fields.end()
}

/// What is measured of a method; of the reference configuration unless said otherwise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Wave vectors with zero-energy modes, of `k` and `-k` one; of lines and surfaces of them that are connected one.
    pub zero_modes: usize,
    /// How far zero-energy modes extend at most; `None` where there are none.
    pub zero_extent: Option<Extent>,
    /// Whether all of them have been found.
    pub zero_modes_complete: bool,
    /// Minima of the relative frequency below the limit of weakness.
    pub weak_modes: usize,
    /// The lowest frequency of a wave over that of the material's slowest wave with the same wave vector; 0 with zero-energy
    /// modes, 1 where no wave is slower than the material's, no number where nothing can be compared.
    pub weakest: f64,
    /// Errors of frequencies.
    pub dispersion: Vec<DispersionError>,
    /// The largest error of a component of the long-wavelength moduli.
    pub long_wave_error: f64,
    /// Where stability ends.
    pub onsets: Vec<OnsetPair>,
    /// Verdicts over the window of states.
    pub fidelity: Fidelity,
    /// The critical time step; time.
    pub critical_time_step: f64,
    /// The body whose critical time step that is.
    pub critical_time_step_of: &'static str,
    /// The body of the study, in the reference state; left out of methods without bodies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<BodyStepAnswer>,
    /// The same times the speed of sound over the particle spacing.
    pub courant: f64,
    /// The same of the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body_courant: Option<f64>,
    /// Particles that an evaluation of the forces on one particle looks at.
    pub neighbors: f64,
}

impl Measured {
    /// Whether a wave is slower than a share of the material's slowest.
    pub(crate) fn is_weak(&self, share: f64) -> bool {
        self.weakest < share
    }

    /// Asks a method everything, of a material that may be shared.
    ///
    /// # Errors
    /// [`ProblemError`] when the method is not admissible, or cannot be evaluated at a state for another reason than its support or
    /// the law's domain.
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
        let step = analysis.critical_time_step(&rest, options.integrator)?;
        let passage = analysis.speed_squared()?.sqrt() / analysis.spacing();
        let body = match BodyStepAnswer::new(&problem, &rest) {
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
            critical_time_step_of: OF_LATTICE,
            body,
            courant: step * passage,
            body_courant: body
                .and_then(|body| body.time_step)
                .map(|step| step * passage),
            neighbors: analysis.neighbors(),
        })
    }

    /// The error of the frequencies at a wavelength; not a number when it has not been asked for.
    pub fn dispersion_at(&self, particles: f64) -> f64 {
        let mut known = self.dispersion.iter();
        known
            .find(|error| error.particles_per_wavelength == particles)
            .map_or(f64::NAN, |error| error.error)
    }

    /// A number to compare the cost of simulating a given time: particles looked at for every speed-of-sound passage
    /// of a spacing, `neighbors / courant`.
    pub fn cost(&self) -> f64 {
        self.neighbors / self.courant
    }
}
