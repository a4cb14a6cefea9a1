//! Survey of the states of one discretization and one material.
//!
//! Results that do not depend on the state (wave speed, Brillouin zone, reference waves, zero-energy modes) are computed once and shared.

mod sampled;

use super::weakest::{Starts, WeakestSearch};
use super::{
    Assessment, MaterialAssessment, Phase, Probe, Unfolding, Verdict, WEAK_WAVE_RATIO, WeakestMode,
    ZeroEnergyWave, decided, finite,
};
use crate::algebra::Complex;
use crate::bloch::{
    GradientMoments, Judgment, Local, Mode, MomentExtremes, SpectrumSummary, Stability, StateWave,
    WaveSystem, ZERO_ENERGY, ZoneSearch,
};
use crate::continuum::{AcousticMinimum, Stiffness, plane_minimum};
use crate::cores::of_each;
use crate::kinematics::DeformationGradient;
use crate::lattice::BrillouinZone;
use crate::lattice::inverse_of;
use crate::material::{Hyperelastic, PlaneTangent, has_major_symmetry};
use crate::method::MethodError;
use crate::scheme::{DirectWaves, Discretization};
use crate::time_step::{Integrator, TransferredWaves, critical_time_step};
use crate::zero_energy::Strains;
use nalgebra::{DMatrix, SMatrix, SVector};
use std::sync::{Arc, OnceLock};

/// Largest scaled measure of a stable state whose softest mode is tested for zero energy: above it, the stress alone cannot provide the stiffness.
const ZERO_ENERGY_TEST_LIMIT: f64 = 0.05;

/// Squared frequencies below this fraction of the largest squared frequency are zero to rounding.
pub const ZERO_FREQUENCY_FRACTION: f64 = 1e-13;

/// Verdict on a state with the measures that are drawn in maps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurveyedState<const D: usize> {
    /// Verdict on the state.
    pub verdict: Verdict,
    /// Stability of the discretization: stable, or unstable by divergence or flutter.
    pub stability: Stability,
    /// Smallest acoustic eigenvalue of the material, with any complex eigenvalues. They determine whether plane waves of the material grow.
    pub acoustic: AcousticMinimum<D>,
    /// Smallest scaled measure `Re omega^2 / (c^2 |k|_h^2)`, long waves included; see [`SpectrumSummary::softest`].
    pub scaled_minimum: f64,
    /// Wave vector of the softest mode, 1/length; its unit direction if the mode is a long wave.
    pub wave_vector: SVector<f64, D>,
    /// Whether the softest mode is the long-wave limit.
    pub is_long_wave: bool,
    /// Smallest scaled measure in the long-wave limit `k -> 0`.
    pub long_wave_minimum: f64,
    /// Whether the long-wave limit is negative beyond rounding, or long waves flutter like waves of the material.
    pub long_waves_grow: bool,
    /// Smallest `Re omega^2`, at most zero because of the translations. 1/time^2.
    pub lowest_omega_squared: f64,
    /// Growth rate of the fastest growing mode, zero for a stable state. 1/time.
    pub growth_rate: f64,
    /// Largest frequency. 1/time.
    pub maximum_omega: f64,
}

impl<const D: usize> SurveyedState<D> {
    /// Critical time step of central differences without damping, `2 / omega_max`.
    pub fn critical_time_step(&self) -> f64 {
        2.0 / self.maximum_omega
    }
}

/// Verdict on a state without its evidence, as returned by [`Survey::judge_beside`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judged<const D: usize> {
    /// Verdict on the state.
    pub verdict: Verdict,
    /// Stability of the discretization: stable, or unstable by divergence or flutter.
    pub stability: Stability,
    /// Wave vector of a growing wave (`Re omega^2 < 0`), if one was found. It need not be the fastest growing wave. 1/length.
    pub witness: Option<SVector<f64, D>>,
}

/// Survey of the states of one discretization and one material.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::scheme::element::{ElementChoices, FiniteElements};
/// use onset::verdict::{Survey, Verdict};
/// let elements = FiniteElements::<2>::new(&ElementChoices::default())?;
/// let material = ModifiedMooneyRivlin::default();
/// let survey = Survey::new(&elements, &material)?;
/// let state = DeformationGradient::from_stretches([1.2, 0.9, 1.0])?;
/// assert_eq!(survey.state(&state)?.verdict, Verdict::Stable);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Survey<'a, const D: usize> {
    discretization: &'a dyn Discretization<D>,
    material: &'a dyn Hyperelastic,
    ground: Arc<Ground<D>>,
}

/// Data that all states of a discretization and a material share.
///
/// A [`Survey`] computes them before its first state. They borrow nothing and can be kept where a survey cannot; see [`Survey::on`].
#[derive(Clone)]
pub struct Ground<const D: usize> {
    speed_squared: f64,
    /// Search over the Brillouin zone of the reference lattice.
    search: ZoneSearch<D>,
    moments: Option<Arc<GradientMoments<D>>>,
    /// Plane waves in the reference configuration. They distinguish zero-energy modes from unstable modes.
    reference: OnceLock<Result<WaveSystem<D>, MethodError>>,
    /// Strains of plane waves; independent of the material.
    strains: OnceLock<Result<Strains<D>, MethodError>>,
    /// Starts of the search for the weakest wave, in the reference configuration.
    starts: OnceLock<Starts<D>>,
    weakest: OnceLock<Option<WeakestMode<D>>>,
}

/// Wave vector, with the ratio of the discrete to the exact gradient norm.
type GradientNorm<const D: usize> = (SVector<f64, D>, f64);

/// Equations of plane waves at a state, with the search over their Brillouin zone.
#[derive(Clone, Debug)]
pub enum StateWaves<const D: usize> {
    /// Waves of lattices with one particle per cell, from [`Discretization::direct_waves`].
    Direct(Box<DirectWaves<D>>),
    /// Waves of cells with any number of particles, with the search over the zone of their wave vectors.
    System(Box<(WaveSystem<D>, ZoneSearch<D>)>),
}

impl<const D: usize> StateWaves<D> {
    /// Creates the waves of a discretization and a material; `zone` returns the search over the zone of the reference lattice.
    ///
    /// # Errors
    /// [`MethodError`] when discretization or material cannot be evaluated there.
    pub fn of(
        discretization: &dyn Discretization<D>,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
        speed_squared: f64,
        zone: impl FnOnce() -> ZoneSearch<D>,
    ) -> Result<Self, MethodError> {
        if let Some(waves) = discretization.direct_waves(material, f, speed_squared)? {
            return Ok(Self::Direct(Box::new(waves)));
        }
        let waves = discretization.waves(material, f)?;
        Ok(Self::System(Box::new((waves, zone()))))
    }

    /// Dynamical matrix `D(k)`; its eigenvalues are `omega^2` without damping. 1/time^2.
    pub fn dynamical_matrix_at(&self, k: &SVector<f64, D>) -> DMatrix<Complex> {
        match self {
            Self::Direct(waves) => {
                let d = waves.matrix.at(k);
                DMatrix::from_fn(D, D, |i, j| d[(i, j)])
            }
            Self::System(waves) => waves.0.dynamical_matrix_at(k),
        }
    }

    /// All `omega^2` of a wave vector without damping, by increasing real part. 1/time^2.
    pub fn omega_squared(&self, k: &SVector<f64, D>) -> Vec<Complex> {
        match self {
            Self::Direct(waves) => waves.matrix.omega_squared(k).to_vec(),
            Self::System(waves) => waves.0.omega_squared(k),
        }
    }

    /// Returns true if all modes of a wave vector except translations have frequencies that exceed the rounding error of the largest frequency.
    fn resist(&self, k: &SVector<f64, D>, maximum_omega: f64) -> bool {
        let values = self.omega_squared(k).into_iter();
        let mut sizes: Vec<f64> = values.map(|value| value.norm()).collect();
        sizes.sort_by(f64::total_cmp);
        let translations = if k.norm() == 0.0 { D } else { 0 };
        let rounding = ZERO_FREQUENCY_FRACTION * maximum_omega * maximum_omega;
        sizes.get(translations).is_none_or(|size| *size > rounding)
    }

    /// All `omega` of a wave vector, damping included. Without damping, `omega` and `-omega` are both listed. 1/time.
    pub fn frequencies(&self, k: &SVector<f64, D>) -> Vec<Complex> {
        match self {
            Self::Direct(waves) => {
                let roots = waves.matrix.omega_squared(k).map(Complex::sqrt);
                roots.into_iter().flat_map(|root| [root, -root]).collect()
            }
            Self::System(waves) => waves.0.frequencies(k),
        }
    }

    /// Extremes of the spectrum over the zone, without damping.
    ///
    /// # Errors
    /// [`MethodError::NotFinite`] when they over- or underflow.
    pub fn spectrum(&self) -> Result<SpectrumSummary<D>, MethodError> {
        finite(match self {
            Self::Direct(waves) => waves.search.summary(&waves.matrix),
            Self::System(waves) => {
                waves.0.check_mass()?;
                waves.1.summary_of(&waves.0)
            }
        })
    }

    /// Like [`Self::spectrum`], except that flutter which grows more slowly than the divergence of a state may be omitted.
    ///
    /// Slow flutter of long waves is then also omitted, unless `asks_about_long_waves` requests it.
    fn extremes(&self, asks_about_long_waves: bool) -> Result<SpectrumSummary<D>, MethodError> {
        finite(match self {
            Self::Direct(waves) => waves.search.extremes(&waves.matrix, asks_about_long_waves),
            Self::System(waves) => {
                waves.0.check_mass()?;
                waves.1.extremes_of(&waves.0, asks_about_long_waves)
            }
        })
    }

    /// Like [`Self::spectrum`], with a lower bound of the scaled measure for all equations that allow one.
    ///
    /// # Errors
    /// [`MethodError::NotFinite`] when they over- or underflow.
    pub fn bounded_spectrum(&self) -> Result<SpectrumSummary<D>, MethodError> {
        finite(match self {
            Self::Direct(waves) => waves.search.bounded_summary(&waves.matrix),
            Self::System(waves) => {
                waves.0.check_mass()?;
                waves.1.bounded_summary_of(&waves.0)
            }
        })
    }

    /// Returns the search over the Brillouin zone.
    pub fn search(&self) -> &ZoneSearch<D> {
        match self {
            Self::Direct(waves) => &waves.search,
            Self::System(waves) => &waves.1,
        }
    }

    /// Replaces the extreme waves by the representatives of all waves with equal measures.
    ///
    /// `to_spatial` maps reference wave vectors to the deformed lattice. `zero_modes` returns all zero-energy modes if a wave is one of them.
    fn represented(
        &self,
        found: SpectrumSummary<D>,
        to_spatial: SMatrix<f64, D, D>,
        zero_modes: &dyn Fn(&SVector<f64, D>) -> Vec<SVector<f64, D>>,
    ) -> SpectrumSummary<D> {
        let long_waves = || match self {
            Self::Direct(waves) => waves.matrix.long_wave_stiffness(),
            Self::System(waves) => waves.0.reduced().unwrap_or(&waves.0).long_wave_stiffness(),
        };
        let waves = StateWave {
            omega_squared: &|k| self.omega_squared(k),
            matrix: &|k| self.dynamical_matrix_at(k),
            long_waves: &long_waves,
            size: match self {
                Self::Direct(_) => D,
                Self::System(waves) => waves.0.size(),
            },
            to_spatial,
            zero_modes,
        };
        self.search().represented(&waves, found)
    }

    /// Returns whether a mode grows, and by divergence or flutter, with a measure whose sign decides stability.
    ///
    /// For an unstable state it is the measure of a witness. For a stable state the softest mode is returned if its measure is at most `soft`. The
    /// argument `beside` contains witnesses of neighboring states, which are tried first.
    ///
    /// # Errors
    /// [`MethodError::NotFinite`] when frequencies over- or underflow.
    fn judgment(
        &self,
        soft: f64,
        beside: Option<&[SVector<f64, D>]>,
    ) -> Result<Judgment<D>, MethodError> {
        match self {
            Self::Direct(waves) => Ok(waves.search.judgment(&waves.matrix, soft, beside)),
            Self::System(waves) => {
                waves.0.check_mass()?;
                let judgment = waves.1.judgment_of(&waves.0, soft, beside);
                // The measure is NaN if frequencies over- or underflow.
                match judgment.measure.is_nan() {
                    true => Err(MethodError::NotFinite),
                    false => Ok(judgment),
                }
            }
        }
    }

    /// Returns true if long waves of an unstable state grow like waves of the material.
    fn long_waves_grow(&self, stability: Stability, material: &AcousticMinimum<D>) -> bool {
        match self {
            Self::Direct(waves) => waves.search.long_waves_grow(&waves.matrix, material),
            Self::System(waves) => waves.1.long_waves_grow_of(&waves.0, stability, material),
        }
    }
}

impl<'a, const D: usize> Survey<'a, D> {
    /// Creates the survey of a discretization and a material.
    ///
    /// # Errors
    /// [`MethodError`] when the response of the material in the reference state is not finite, or its largest acoustic eigenvalue is not positive.
    pub fn new(
        discretization: &'a dyn Discretization<D>,
        material: &'a dyn Hyperelastic,
    ) -> Result<Self, MethodError> {
        let speed_squared = super::speed_squared(discretization, material)?;
        let lattice = *discretization.crystal().lattice();
        Ok(Self {
            discretization,
            material,
            ground: Arc::new(Ground {
                speed_squared,
                search: ZoneSearch::of_lattice(lattice, speed_squared),
                moments: None,
                reference: OnceLock::new(),
                strains: OnceLock::new(),
                starts: OnceLock::new(),
                weakest: OnceLock::new(),
            }),
        })
    }

    /// Creates a survey from the shared data of another survey, which must have the same discretization and material.
    pub fn on(
        ground: Arc<Ground<D>>,
        discretization: &'a dyn Discretization<D>,
        material: &'a dyn Hyperelastic,
    ) -> Self {
        Self {
            discretization,
            material,
            ground,
        }
    }

    /// Returns the data that all states share.
    pub fn ground(&self) -> Arc<Ground<D>> {
        Arc::clone(&self.ground)
    }

    /// Prepares the survey for many states, in about 0.05 s.
    ///
    /// For Lagrangian kernels in the plane, [`Survey::states`] then takes a few microseconds per state. Other discretizations need no preparation and
    /// are returned unchanged.
    ///
    /// ```
    /// use onset::kinematics::DeformationGradient;
    /// use onset::material::ModifiedMooneyRivlin;
    /// use onset::method::{KernelMethodChoices, Method};
    /// use onset::verdict::{Survey, Verdict};
    /// let method = Method::<2>::new(KernelMethodChoices::default())?;
    /// let material = ModifiedMooneyRivlin::default();
    /// let survey = Survey::new(&method, &material)?;
    /// let state = DeformationGradient::from_stretches([1.2, 0.9, 1.0])?;
    /// let assessed = survey.assess(&state)?;
    /// let surveyed = survey.for_many_states()?.state(&state)?;
    /// assert_eq!(surveyed.verdict, Verdict::Stable);
    /// assert!((surveyed.scaled_minimum - assessed.spectrum.softest.scaled).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`MethodError`] when the method cannot be evaluated.
    pub fn for_many_states(mut self) -> Result<Self, MethodError> {
        let moments = self.discretization.gradient_moments(self.speed_squared())?;
        Arc::make_mut(&mut self.ground).moments = moments.map(Arc::new);
        Ok(self)
    }

    /// Discretization of the survey.
    pub fn discretization(&self) -> &'a dyn Discretization<D> {
        self.discretization
    }

    /// Material of the survey.
    pub fn material(&self) -> &'a dyn Hyperelastic {
        self.material
    }

    /// Search over the zone of the reference lattice.
    pub fn search(&self) -> &ZoneSearch<D> {
        &self.ground.search
    }

    /// Equations of plane waves in the reference configuration.
    ///
    /// # Errors
    /// [`MethodError`] when material or discretization cannot be evaluated there.
    pub fn reference(&self) -> Result<&WaveSystem<D>, MethodError> {
        let evaluated = || {
            let rest = DeformationGradient::identity();
            self.discretization.waves(self.material, &rest)
        };
        let reference = self.ground.reference.get_or_init(evaluated);
        reference.as_ref().map_err(Clone::clone)
    }

    /// Squared wave speed `c^2` of the scaled measures: the largest acoustic eigenvalue of the material in the reference state, divided by the
    /// reference density. Length^2/time^2.
    pub fn speed_squared(&self) -> f64 {
        self.ground.speed_squared
    }

    /// Plane waves at a state, with their search.
    ///
    /// # Errors
    /// [`MethodError`] when discretization or material cannot be evaluated there.
    pub fn waves(&self, f: &DeformationGradient) -> Result<StateWaves<D>, MethodError> {
        let zone = || self.search().clone();
        let speed_squared = self.speed_squared();
        StateWaves::of(self.discretization, self.material, f, speed_squared, zone)
    }

    /// Extremes of the spectrum at a state, without damping.
    ///
    /// # Errors
    /// [`MethodError`] when discretization or material cannot be evaluated there.
    pub fn spectrum(&self, f: &DeformationGradient) -> Result<SpectrumSummary<D>, MethodError> {
        let waves = self.waves(f)?;
        Ok(self.represented(&waves, waves.spectrum()?, f))
    }

    /// Replaces the extreme waves of a state by the representatives of all waves with equal measures.
    fn represented(
        &self,
        waves: &StateWaves<D>,
        found: SpectrumSummary<D>,
        f: &DeformationGradient,
    ) -> SpectrumSummary<D> {
        let zero_modes = |k: &SVector<f64, D>| {
            let strains = self.strains();
            strains.map_or_else(|_| Vec::new(), |own| own.modes_if_unstrained(k))
        };
        waves.represented(found, self.to_spatial(f), &zero_modes)
    }

    /// Map from reference wave vectors to the deformed lattice, `F^-T`; the identity if the wave vectors already belong to the deformed lattice.
    fn to_spatial(&self, f: &DeformationGradient) -> SMatrix<f64, D, D> {
        let inverse = match self.discretization.is_regular() {
            true => None,
            false => inverse_of(&f.leading::<D>().transpose()),
        };
        inverse.unwrap_or_else(SMatrix::identity)
    }

    /// Returns the waves of a state in discrete time, or `None` if the discretization does not define a time step; see
    /// [`Discretization::transferred`].
    ///
    /// # Errors
    /// [`MethodError`] when discretization or material cannot be evaluated there.
    pub fn transferred(
        &self,
        f: &DeformationGradient,
    ) -> Result<Option<TransferredWaves<D>>, MethodError> {
        self.discretization.transferred(self.material, f)
    }

    /// Returns true if the discretization defines its time stepping, so that no integrator applies.
    pub fn is_transferred(&self) -> bool {
        let rest = DeformationGradient::identity();
        self.transferred(&rest).is_ok_and(|waves| waves.is_some())
    }

    /// Largest stable time step of an integrator at a state, damping included. Time.
    ///
    /// For discretizations that define their time stepping, it is the critical time step of this scheme, for any integrator.
    ///
    /// # Errors
    /// [`MethodError`] when discretization or material cannot be evaluated there.
    pub fn critical_time_step(
        &self,
        f: &DeformationGradient,
        integrator: Integrator,
    ) -> Result<f64, MethodError> {
        if let Some(waves) = self.transferred(f)? {
            return Ok(waves.critical_time_step());
        }
        let system = self.discretization.waves(self.material, f)?;
        Ok(critical_time_step(&system, integrator, self.search()))
    }

    /// Returns true if forces depend on velocities. The critical time steps of the integrators then differ.
    pub fn is_damped(&self) -> bool {
        let is_damped = |waves: &WaveSystem<D>| waves.damping().is_some();
        !self.discretization.is_undamped() && self.reference().is_ok_and(is_damped)
    }

    /// Largest stable time steps of all integrators at a state; empty without damping.
    ///
    /// # Errors
    /// [`MethodError`] when material or discretization cannot be evaluated there.
    pub fn damped_time_steps(
        &self,
        f: &DeformationGradient,
    ) -> Result<Vec<(Integrator, f64)>, MethodError> {
        if !self.is_damped() {
            return Ok(Vec::new());
        }
        let system = self.discretization.waves(self.material, f)?;
        let search = self.search();
        let step = |integrator| (integrator, critical_time_step(&system, integrator, search));
        Ok(of_each(Integrator::ALL.to_vec(), step))
    }

    /// Assesses a state: the verdict with its evidence.
    ///
    /// # Errors
    /// [`MethodError`] when discretization or material cannot be evaluated there.
    pub fn assess(&self, f: &DeformationGradient) -> Result<Assessment<D>, MethodError> {
        let material = MaterialAssessment::<D>::new(self.material, f)?;
        let waves = self.waves(f)?;
        let spectrum = waves.bounded_spectrum()?;
        let spectrum = self.represented(&waves, spectrum, f);
        let norms = self.gradient_norms(f, Some(&spectrum.softest))?;
        let zero_energy = match spectrum.is_stable() {
            true => self.zero_energy_wave(norms.as_deref(), &waves, &spectrum)?,
            false => None,
        };
        let verdict = decided(
            material.minimum.has_growing_waves(),
            spectrum.is_stable(),
            zero_energy.is_some(),
            spectrum.long_waves_grow(&material.minimum),
        );
        Ok(Assessment {
            verdict,
            material,
            zero_energy: zero_energy.filter(|_| verdict == Verdict::ZeroEnergy),
            gradient_norm: norms.and_then(|norms| Some(norms.first()?.1)),
            spectrum,
        })
    }

    /// Returns the verdict and the stability of a state, without the evidence.
    ///
    /// The result agrees with [`Survey::assess`]. It is several times cheaper if one witness of an instability is enough.
    ///
    /// # Errors
    /// [`MethodError`] when discretization or material cannot be evaluated there.
    pub fn judge(&self, f: &DeformationGradient) -> Result<(Verdict, Stability), MethodError> {
        let judged = self.judge_beside(f, None)?;
        Ok((judged.verdict, judged.stability))
    }

    /// Like [`Survey::judge`], with the witnesses of neighboring states, if known.
    ///
    /// If one of them is also a witness of this state, the search is skipped.
    ///
    /// # Errors
    /// As for [`Survey::judge`].
    pub fn judge_beside(
        &self,
        f: &DeformationGradient,
        beside: Option<&[SVector<f64, D>]>,
    ) -> Result<Judged<D>, MethodError> {
        let acoustic = Stiffness::<D>::at(self.material, f)?.minimum();
        let material_grows = acoustic.has_growing_waves();
        let waves = self.waves(f)?;
        // The test for zero energy needs the mode.
        let soft = match (material_grows, &waves) {
            (true, _) => f64::NEG_INFINITY,
            (false, StateWaves::Direct(waves)) => {
                ZERO_ENERGY_TEST_LIMIT.max(waves.search.tolerance(&waves.matrix))
            }
            (false, StateWaves::System(_)) => f64::INFINITY,
        };
        let Judgment {
            stability,
            witness,
            softest,
            ..
        } = waves.judgment(soft, beside)?;
        let is_stable = stability == Stability::Stable;
        // Long waves decide the origin of the instability only if material and discretization are both unstable.
        let long_waves_grow =
            material_grows && !is_stable && waves.long_waves_grow(stability, &acoustic);
        let has_zero_mode =
            is_stable && !material_grows && self.has_zero_mode(f, softest.as_ref())?;
        Ok(Judged {
            verdict: decided(material_grows, is_stable, has_zero_mode, long_waves_grow),
            stability,
            witness,
        })
    }

    /// Returns the phase of the discretization at a state, with the scaled measure `Re omega^2 / (c^2 |k|_h^2)` of the softest wave. Dimensionless.
    ///
    /// For an unstable state it is the measure of a witness.
    ///
    /// # Errors
    /// [`MethodError`] when the state cannot be evaluated. Lack of support and states outside the domain of the law are not errors, but
    /// [`Phase::Undefined`].
    pub fn probe(&self, f: &DeformationGradient) -> Result<Probe, MethodError> {
        let waves = self.waves(f);
        let judgment = match waves.and_then(|waves| waves.judgment(f64::NEG_INFINITY, None)) {
            Ok(judgment) => judgment,
            Err(error) if error.leaves_undefined() => return Ok((Phase::Undefined, f64::NAN)),
            Err(error) => return Err(error),
        };
        let phase = match judgment.stability {
            Stability::Stable => Phase::Stable,
            Stability::Flutter => Phase::Flutter,
            Stability::Divergence => Phase::Unstable,
        };
        Ok((phase, judgment.measure))
    }

    /// Returns the verdict on a state and the measures that are drawn in maps, identical to the results of [`Survey::assess`].
    ///
    /// # Errors
    /// [`MethodError`] when the discretization or the material cannot be evaluated there.
    pub fn state(&self, f: &DeformationGradient) -> Result<SurveyedState<D>, MethodError> {
        match &self.ground.moments {
            Some(_) if f.is_block_diagonal::<D>() => self
                .states(std::slice::from_ref(f))
                .pop()
                .unwrap_or(Err(MethodError::NotFinite)),
            _ => self.searched(f),
        }
    }

    /// Returns the result of [`Survey::state`] for each state, identical to the last digit.
    ///
    /// With Lagrangian kernels in the plane it is many times faster than separate calls.
    pub fn states(
        &self,
        states: &[DeformationGradient],
    ) -> Vec<Result<SurveyedState<D>, MethodError>> {
        let Some(moments) = &self.ground.moments else {
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
        // The moments determine the waves only if the tangent has major symmetry.
        let known: Vec<PlaneTangent> = tangents
            .iter()
            .filter_map(|tangent| tangent.as_ref().ok().copied())
            .filter(has_major_symmetry)
            .collect();
        let mut extremes = moments.extremes(&known).into_iter();
        surveyed.extend(states.iter().zip(tangents).map(|(f, tangent)| {
            let tangent = tangent.map_err(MethodError::from)?;
            if !has_major_symmetry(&tangent) {
                return self.searched(f);
            }
            let extremes = extremes.next().ok_or(MethodError::NotFinite)?;
            Ok(SurveyedState::of_extremes(&tangent, &extremes))
        }));
    }

    fn searched(&self, f: &DeformationGradient) -> Result<SurveyedState<D>, MethodError> {
        let acoustic = Local::new(self.material, f)?.stiffness().minimum();
        let waves = self.waves(f)?;
        let spectrum = waves.extremes(acoustic.only_flutters())?;
        let spectrum = self.represented(&waves, spectrum, f);
        self.surveyed(f, acoustic, &spectrum)
    }

    fn surveyed(
        &self,
        f: &DeformationGradient,
        acoustic: AcousticMinimum<D>,
        spectrum: &SpectrumSummary<D>,
    ) -> Result<SurveyedState<D>, MethodError> {
        Ok(SurveyedState::of_spectrum(
            acoustic,
            spectrum,
            spectrum.is_stable() && self.has_zero_mode(f, Some(&spectrum.softest))?,
        ))
    }

    /// Returns true if the softest mode of a stable state or a mode of alternating neighbors is a zero-energy mode: a mode without strain.
    ///
    /// Only the stress of the state can resist such a mode. It can cause another wave nearby to be the softest.
    fn has_zero_mode(
        &self,
        f: &DeformationGradient,
        softest: Option<&Mode<D>>,
    ) -> Result<bool, MethodError> {
        if let Some(norms) = self.gradient_norms(f, softest)? {
            return Ok(norms.into_iter().any(|(_, norm)| norm <= ZERO_ENERGY));
        }
        let strains = self.strains()?;
        let is_softest = || softest.is_some_and(|mode| misses(strains, mode));
        Ok(!strains.alternating.is_empty() || is_softest())
    }

    /// Zero-energy mode of a stable state: its softest mode, or modes of alternating neighbors. `norms` are the gradient norms of
    /// [`Self::gradient_norms`].
    fn zero_energy_wave(
        &self,
        norms: Option<&[GradientNorm<D>]>,
        waves: &StateWaves<D>,
        spectrum: &SpectrumSummary<D>,
    ) -> Result<Option<ZeroEnergyWave>, MethodError> {
        let is_unseen = |(_, norm): &&GradientNorm<D>| *norm <= ZERO_ENERGY;
        let (is_softest, alternating) = match norms {
            Some(norms) => {
                let (softest, others) = norms.split_at(1.min(norms.len()));
                let unseen = others.iter().filter(is_unseen).map(|(k, _)| *k);
                (softest.iter().any(|own| is_unseen(&own)), unseen.collect())
            }
            None => {
                let strains = self.strains()?;
                let is_softest = misses(strains, &spectrum.softest);
                (is_softest, strains.alternating.clone())
            }
        };
        if is_softest {
            return Ok(Some(ZeroEnergyWave::Softest));
        }
        let is_resisted = |k: &&SVector<f64, D>| waves.resist(k, spectrum.maximum_omega);
        let wave = ZeroEnergyWave::Alternating {
            count: alternating.len(),
            resisted: alternating.iter().filter(is_resisted).count(),
        };
        Ok((!alternating.is_empty()).then_some(wave))
    }

    /// Gradient norms of the softest mode, if given, and of alternating neighbors, with their wave vectors; `None` if the discretization has no such
    /// gradients.
    fn gradient_norms(
        &self,
        f: &DeformationGradient,
        softest: Option<&Mode<D>>,
    ) -> Result<Option<Vec<GradientNorm<D>>>, MethodError> {
        let known = softest.map(|mode| (mode.wave_vector, mode.is_long_wave));
        let alternating = self.discretization.crystal().lattice().alternating();
        let alternating = alternating.map(|k| (k, false));
        let waves: Vec<_> = known.into_iter().chain(alternating).collect();
        let norms = self.discretization.gradient_norms(f, &waves)?;
        let vectors = waves.into_iter().map(|(k, _)| k);
        Ok(norms.map(|norms| vectors.zip(norms).collect()))
    }

    /// Returns true if a wave with this wave vector has zero strain at every quadrature point, for any material.
    ///
    /// # Errors
    /// [`MethodError`] when the discretization cannot be evaluated there.
    pub fn has_unstrained_wave(
        &self,
        f: &DeformationGradient,
        k: &SVector<f64, D>,
    ) -> Result<bool, MethodError> {
        match self.discretization.gradient_norms(f, &[(*k, false)])? {
            Some(norms) => Ok(norms.iter().any(|norm| *norm <= ZERO_ENERGY)),
            None => Ok(self.strains()?.rows.zero_mode_near(k).is_some()),
        }
    }

    fn strains(&self) -> Result<&Strains<D>, MethodError> {
        let evaluated = || {
            let strain = self.discretization.strain()?;
            Ok(Strains::new(self.discretization.crystal(), &strain))
        };
        let strains = self.ground.strains.get_or_init(evaluated);
        strains.as_ref().map_err(Clone::clone)
    }

    /// Returns the weakest wave of the reference configuration: the wave with the lowest frequency relative to the material's slowest wave with the
    /// same wave vector, zero-energy modes included. `None` if the slowest waves of the material have frequency zero (shear waves of a fluid), or if
    /// the law is not differentiable in the reference configuration.
    ///
    /// The weakest wave depends only on method and law; it is computed once for all states.
    pub fn weakest(&self) -> Option<WeakestMode<D>> {
        let searched = || {
            let search = self.weakest_search().ok()?;
            search.weakest(WEAK_WAVE_RATIO * WEAK_WAVE_RATIO)
        };
        *self.ground.weakest.get_or_init(searched)
    }

    /// Search for the weakest waves.
    ///
    /// # Errors
    /// [`MethodError`] when the material or the discretization cannot be evaluated.
    pub(crate) fn weakest_search(&self) -> Result<WeakestSearch<'_, D>, MethodError> {
        Ok(WeakestSearch {
            unfolding: Unfolding::new(self.discretization, self.material, self.reference()?)?,
            zone: BrillouinZone::new(*self.discretization.crystal().lattice()),
            strains: self.strains()?,
            starts: &self.ground.starts,
        })
    }
}

/// Returns true if a strain-free mode exists at or near the wave vector of a mode.
fn misses<const D: usize>(strains: &Strains<D>, mode: &Mode<D>) -> bool {
    !mode.is_long_wave && strains.rows.zero_mode_near(&mode.wave_vector).is_some()
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
                acoustic.has_growing_waves(),
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

    fn of_spectrum(
        acoustic: AcousticMinimum<D>,
        spectrum: &SpectrumSummary<D>,
        has_zero_mode: bool,
    ) -> Self {
        let is_stable = spectrum.is_stable();
        let long_waves_grow = spectrum.long_waves_grow(&acoustic);
        Self {
            verdict: decided(
                acoustic.has_growing_waves(),
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
        let has_zero_mode = assessment.verdict == Verdict::ZeroEnergy;
        let material = &assessment.material;
        Self::of_spectrum(material.minimum, &assessment.spectrum, has_zero_mode)
    }
}
