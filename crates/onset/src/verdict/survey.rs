//! Many states of one method and material: what depends on neither state nor wave vector is computed once.

use super::{
    Assessment, Verdict, decided, finite, gradient_norm_of, is_zero_energy, speed_squared,
};
use crate::bloch::{
    GradientMoments, Local, MomentExtremes, SpectrumSummary, Stability, ZoneSearch,
    dynamical_matrix, dynamical_matrix_with,
};
use crate::continuum::{AcousticMinimum, plane_minimum};
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, MaterialError, PlaneTangent};
use crate::method::{Background, Method, MethodError};
use nalgebra::SVector;

/// What a map shows of a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurveyedState<const D: usize> {
    /// The verdict.
    pub verdict: Verdict,
    /// How perturbations of the discretization develop.
    pub stability: Stability,
    /// The smallest acoustic eigenvalue of the material, which tells whether it is strongly elliptic.
    pub acoustic: AcousticMinimum<D>,
    /// The smallest scaled measure `Re omega^2 / (c^2 |k|_h^2)`, long waves included; see [`SpectrumSummary::softest`].
    pub scaled_minimum: f64,
    /// Its wave vector; the unit direction for long waves. 1/length.
    pub wave_vector: SVector<f64, D>,
    /// Whether it is the limit of long waves.
    pub is_long_wave: bool,
    /// The smallest limit of long waves.
    pub long_wave_minimum: f64,
    /// Whether the limit is negative beyond rounding.
    pub long_waves_grow: bool,
    /// The smallest `Re omega^2`, zero (the translation) where none is below. 1/time^2.
    pub lowest_omega_squared: f64,
    /// The growth rate of the fastest growing mode, zero when stable. 1/time.
    pub growth_rate: f64,
    /// The largest frequency. 1/time.
    pub maximum_omega: f64,
}

impl<const D: usize> SurveyedState<D> {
    /// The critical time step of central differences without damping, `2 / omega_max`.
    pub fn critical_time_step(&self) -> f64 {
        2.0 / self.maximum_omega
    }
}

/// A method and a material, prepared for many states.
pub struct Survey<const D: usize> {
    method: Method<D>,
    material: Box<dyn Hyperelastic>,
    speed_squared: f64,
    moments: Option<GradientMoments<D>>,
}

impl<const D: usize> Survey<D> {
    /// For some states.
    ///
    /// # Errors
    /// [`MaterialError`] when the response of the undeformed material is not finite.
    pub fn new(method: Method<D>, material: Box<dyn Hyperelastic>) -> Result<Self, MaterialError> {
        Ok(Self {
            speed_squared: speed_squared(&method, &*material)?,
            method,
            material,
            moments: None,
        })
    }

    /// For so many states that a preparation of some hundredths of a second pays. With Lagrangian kernels in the plane a state
    /// then costs about two microseconds in the company of others, see [`Survey::states`]; with others it changes nothing.
    ///
    /// ```
    /// use onset::kinematics::DeformationGradient;
    /// use onset::material::ModifiedMooneyRivlin;
    /// use onset::method::{Discretization, Method};
    /// use onset::verdict::{Survey, Verdict, assess};
    /// let method = Method::<2>::new(Discretization::default())?;
    /// let survey = Survey::new(method.clone(), Box::new(ModifiedMooneyRivlin::default()))?.for_many_states()?;
    /// let state = DeformationGradient::from_stretches([1.2, 0.9, 1.0])?;
    /// let surveyed = survey.state(&state)?;
    /// assert_eq!(surveyed.verdict, Verdict::Stable);
    /// let assessed = assess(&method, &ModifiedMooneyRivlin::default(), &state)?;
    /// assert!((surveyed.scaled_minimum - assessed.spectrum.softest.scaled).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`MethodError`] when the method cannot be evaluated.
    pub fn for_many_states(mut self) -> Result<Self, MethodError> {
        self.moments = GradientMoments::new(&self.method, self.speed_squared)?;
        Ok(self)
    }

    /// The method.
    pub fn method(&self) -> &Method<D> {
        &self.method
    }

    /// The material.
    pub fn material(&self) -> &dyn Hyperelastic {
        &*self.material
    }

    /// The scale `c^2` of wave speeds. Length^2/time^2.
    pub fn speed_squared(&self) -> f64 {
        self.speed_squared
    }

    /// What a map shows of a state: as [`super::assess`] says.
    ///
    /// # Errors
    /// [`MethodError`] when the method or the material cannot be evaluated there.
    pub fn state(&self, f: &DeformationGradient) -> Result<SurveyedState<D>, MethodError> {
        match &self.moments {
            Some(_) if f.is_block_diagonal::<D>() => self
                .states(std::slice::from_ref(f))
                .pop()
                .unwrap_or(Err(MethodError::NotFinite)),
            _ => self.searched(f),
        }
    }

    /// What a map shows of many states, each as [`Survey::state`] says: to the last digit the same in any company, and with
    /// Lagrangian kernels in the plane many times faster than one by one.
    pub fn states(
        &self,
        states: &[DeformationGradient],
    ) -> Vec<Result<SurveyedState<D>, MethodError>> {
        let Some(moments) = &self.moments else {
            return states.iter().map(|f| self.searched(f)).collect();
        };
        let mut surveyed = Vec::with_capacity(states.len());
        let mut rest = states;
        while let Some(first) = rest.first() {
            let is_planar = first.is_block_diagonal::<D>();
            let alike = |f: &&DeformationGradient| f.is_block_diagonal::<D>() == is_planar;
            let (run, others) = rest.split_at(rest.iter().take_while(alike).count());
            if is_planar {
                self.contracted(moments, run, &mut surveyed);
            } else {
                surveyed.extend(run.iter().map(|f| self.searched(f)));
            }
            rest = others;
        }
        surveyed
    }

    fn contracted(
        &self,
        moments: &GradientMoments<D>,
        states: &[DeformationGradient],
        surveyed: &mut Vec<Result<SurveyedState<D>, MethodError>>,
    ) {
        let tangents = self.material.plane_tangents(states);
        let known: Vec<PlaneTangent> = tangents
            .iter()
            .filter_map(|tangent| tangent.as_ref().ok().copied())
            .collect();
        let mut extremes = moments.extremes(&known).into_iter();
        surveyed.extend(tangents.into_iter().map(|tangent| {
            let tangent = tangent.map_err(MethodError::from)?;
            let extremes = extremes.next().ok_or(MethodError::NotFinite)?;
            Ok(SurveyedState::of_extremes(&tangent, &extremes))
        }));
    }

    fn searched(&self, f: &DeformationGradient) -> Result<SurveyedState<D>, MethodError> {
        let local = Local::new(&*self.material, f)?;
        let stiffness = local.stiffness();
        let search =
            ZoneSearch::new(&self.method, f, self.speed_squared).ok_or(MethodError::NotFinite)?;
        let matrix = match self.method.discretization().background {
            Background::Imposed => dynamical_matrix_with(&self.method, &local, f)?,
            Background::Interpolated => dynamical_matrix(&self.method, &*self.material, f)?,
        };
        let spectrum = finite(search.summary(&matrix))?;
        let softest = &spectrum.softest;
        let has_zero_mode = spectrum.is_stable()
            && is_zero_energy(gradient_norm_of(&self.method, f, &search, softest)?);
        Ok(SurveyedState::of_spectrum(
            stiffness.minimum(),
            &spectrum,
            has_zero_mode,
        ))
    }
}

impl<const D: usize> SurveyedState<D> {
    fn of_extremes(tangent: &PlaneTangent, extremes: &MomentExtremes<D>) -> Self {
        let tolerance = extremes.tolerance;
        let is_stable = extremes.scaled_minimum >= -tolerance;
        let acoustic = plane_minimum(tangent);
        let long_waves_grow = extremes.long_wave_minimum < -tolerance;
        let has_zero_mode = extremes.has_zero_mode;
        Self {
            verdict: decided(
                acoustic.ellipticity(),
                is_stable,
                has_zero_mode,
                long_waves_grow,
            ),
            stability: if is_stable {
                Stability::Stable
            } else {
                Stability::Divergence
            },
            acoustic,
            scaled_minimum: extremes.scaled_minimum,
            wave_vector: extremes.wave_vector,
            is_long_wave: extremes.is_long_wave,
            long_wave_minimum: extremes.long_wave_minimum,
            long_waves_grow,
            lowest_omega_squared: extremes.lowest,
            growth_rate: (-extremes.lowest).max(0.0).sqrt(),
            maximum_omega: extremes.highest.max(0.0).sqrt(),
        }
    }

    pub(super) fn of_spectrum(
        acoustic: AcousticMinimum<D>,
        spectrum: &SpectrumSummary<D>,
        has_zero_mode: bool,
    ) -> Self {
        let is_stable = spectrum.is_stable();
        let long_waves_grow = spectrum.long_wave.scaled < -spectrum.tolerance;
        Self {
            verdict: decided(
                acoustic.ellipticity(),
                is_stable,
                has_zero_mode,
                long_waves_grow,
            ),
            stability: spectrum.stability(),
            acoustic,
            scaled_minimum: spectrum.softest.scaled,
            wave_vector: spectrum.softest.wave_vector,
            is_long_wave: spectrum.softest.is_long_wave,
            long_wave_minimum: spectrum.long_wave.scaled,
            long_waves_grow,
            lowest_omega_squared: spectrum.lowest.omega_squared.re,
            growth_rate: spectrum.growth_rate(),
            maximum_omega: spectrum.maximum_omega,
        }
    }
}

impl<const D: usize> From<&Assessment<D>> for SurveyedState<D> {
    fn from(assessment: &Assessment<D>) -> Self {
        let has_zero_mode = assessment.verdict == Verdict::RankDeficient;
        let material = &assessment.material;
        Self::of_spectrum(material.minimum, &assessment.spectrum, has_zero_mode)
    }
}
