//! Verdicts on discretizations of any kind.

use super::{
    Assessment, MaterialAssessment, Phase, Probe, SurveyedState, decided, finite, speed_squared_of,
};
use crate::algebra::{Complex, eigenvalues};
use crate::bloch::{Mode, SpectrumSummary, Stability, WaveSystem, ZoneSearch};
use crate::continuum::Stiffness;
use crate::kinematics::DeformationGradient;
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::scheme::Scheme;
use crate::time_step::{Integrator, critical_time_step};

/// Modes whose scaled measure at rest is below this have no energy.
const ZERO: f64 = 1e-9;

/// A scheme and a material, ready to be asked about many states.
pub struct SchemeSurvey<'a, const D: usize> {
    scheme: &'a dyn Scheme<D>,
    material: &'a dyn Hyperelastic,
    search: ZoneSearch<D>,
    /// The undeformed state, in which modes without energy are told from unstable ones.
    reference: WaveSystem<D>,
    /// Whether all waves of the undeformed material have energy.
    is_elliptic_at_rest: bool,
    speed_squared: f64,
}

impl<'a, const D: usize> SchemeSurvey<'a, D> {
    /// Prepares a scheme.
    ///
    /// # Errors
    /// [`MethodError`] when material or scheme cannot be evaluated in the undeformed state.
    pub fn new(
        scheme: &'a dyn Scheme<D>,
        material: &'a dyn Hyperelastic,
    ) -> Result<Self, MethodError> {
        let identity = DeformationGradient::identity();
        let stiffness = Stiffness::<D>::at(material, &identity)?;
        let speed_squared = speed_squared_of(stiffness.maximum_eigenvalue(), scheme.density())?;
        Ok(Self {
            scheme,
            material,
            search: ZoneSearch::of_lattice(*scheme.crystal().lattice(), speed_squared),
            reference: scheme.waves(material, &identity)?,
            is_elliptic_at_rest: stiffness.is_strongly_elliptic(),
            speed_squared,
        })
    }

    /// The scheme.
    pub fn scheme(&self) -> &'a dyn Scheme<D> {
        self.scheme
    }

    /// The material.
    pub fn material(&self) -> &'a dyn Hyperelastic {
        self.material
    }

    /// The search over the zone.
    pub fn search(&self) -> &ZoneSearch<D> {
        &self.search
    }

    /// The equations of plane waves in the undeformed state.
    pub fn reference(&self) -> &WaveSystem<D> {
        &self.reference
    }

    /// The scale `c^2` of wave speeds: the largest acoustic eigenvalue of the undeformed material over the reference density.
    /// Length^2/time^2.
    pub fn speed_squared(&self) -> f64 {
        self.speed_squared
    }

    /// The extremes of the spectrum at a state.
    ///
    /// # Errors
    /// [`MethodError`] when scheme or material cannot be evaluated there.
    pub fn spectrum(&self, f: &DeformationGradient) -> Result<SpectrumSummary<D>, MethodError> {
        let system = self.scheme.waves(self.material, f)?;
        finite(self.search.summary_of(&system))
    }

    /// The largest stable time step of an integrator at a state, damping included. Time.
    ///
    /// # Errors
    /// [`MethodError`] when scheme or material cannot be evaluated there.
    pub fn critical_time_step(
        &self,
        f: &DeformationGradient,
        integrator: Integrator,
    ) -> Result<f64, MethodError> {
        let system = self.scheme.waves(self.material, f)?;
        Ok(critical_time_step(&system, integrator, &self.search))
    }

    /// Whether forces depend on velocities, so that integrators have different time steps.
    pub fn is_damped(&self) -> bool {
        self.reference.damping().is_some()
    }

    /// The verdict on a state, with numbers.
    ///
    /// # Errors
    /// [`MethodError`] when scheme or material cannot be evaluated there.
    pub fn state(&self, f: &DeformationGradient) -> Result<SurveyedState<D>, MethodError> {
        let continuum = MaterialAssessment::<D>::new(self.material, f)?;
        let spectrum = self.spectrum(f)?;
        Ok(SurveyedState::of_spectrum(
            continuum.minimum,
            &spectrum,
            self.has_zero_mode(&spectrum),
        ))
    }

    /// The verdict on a state with its evidence. In place of the norm of the discrete gradient stands the squared frequency of the softest
    /// mode in the undeformed body over that of the material's slowest wave: zero for a mode without energy.
    ///
    /// # Errors
    /// [`MethodError`] when scheme or material cannot be evaluated there.
    pub fn assess(&self, f: &DeformationGradient) -> Result<Assessment<D>, MethodError> {
        let material = MaterialAssessment::<D>::new(self.material, f)?;
        let spectrum = self.spectrum(f)?;
        let long_waves_grow = spectrum.long_wave.scaled < -spectrum.tolerance;
        let verdict = decided(
            material.ellipticity(),
            spectrum.is_stable(),
            self.has_zero_mode(&spectrum),
            long_waves_grow,
        );
        let gradient_norm = self.relative_frequency_squared(&spectrum.softest)?;
        Ok(Assessment {
            verdict,
            material,
            spectrum,
            gradient_norm,
        })
    }

    /// The squared frequency of the slowest wave at rest over that of the material, with the wave vector of a mode.
    fn relative_frequency_squared(&self, mode: &Mode<D>) -> Result<f64, MethodError> {
        if mode.is_long_wave {
            return Ok(1.0);
        }
        let stiffness = Stiffness::<D>::at(self.material, &DeformationGradient::identity())?;
        let tensor = stiffness.acoustic_tensor(&mode.wave_vector) / self.scheme.density();
        let exact = eigenvalues(&tensor.map(|entry| Complex::new(entry, 0.0)), 0.0)[0].re;
        Ok(self.reference.omega_squared(&mode.wave_vector)[0].re / exact)
    }

    /// The phase of the particles at a state, with the scaled measure of the softest wave.
    ///
    /// # Errors
    /// [`MethodError`] when the state cannot be evaluated for another reason than its support or the law's domain.
    pub fn probe(&self, f: &DeformationGradient) -> Result<Probe, MethodError> {
        let spectrum = match self.spectrum(f) {
            Err(error) if error.leaves_undefined() => return Ok((Phase::Undefined, f64::NAN)),
            other => other?,
        };
        let phase = match spectrum.stability() {
            Stability::Stable => Phase::Stable,
            Stability::Flutter => Phase::Flutter,
            Stability::Divergence => Phase::Unstable,
        };
        Ok((phase, spectrum.softest.scaled))
    }

    /// Whether the softest mode is a zero-energy mode: it has no energy at rest, where all waves of the material have. What resists it at
    /// the state, if anything does, is its stress.
    fn has_zero_mode(&self, spectrum: &SpectrumSummary<D>) -> bool {
        let softest = &spectrum.softest;
        if !self.is_elliptic_at_rest || softest.is_long_wave {
            return false;
        }
        let k = &softest.wave_vector;
        let lowest = self.reference.omega_squared(k)[0].re;
        let laplacian = self.scheme.crystal().lattice().laplacian(k);
        (lowest / (self.speed_squared * laplacian)).abs() <= ZERO
    }
}
