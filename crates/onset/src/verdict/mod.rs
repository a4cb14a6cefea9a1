//! Origin of instability at a state: the material or the discretization.
//!
//! A [`Verdict`] compares the stability of continuum and discretization at one state. [`assess`] returns it with the evidence, an [`Assessment`].

pub mod boundary;
pub mod fidelity;

pub(crate) mod change;
mod mechanism;
mod path;
mod probe;
mod survey;
mod unfolding;
mod weakest;

pub use mechanism::Mechanism;
pub use path::{Crossing, Onset, PathError, PathScan, scan_discretization, scan_material};
pub use probe::{Phase, Probe, probe_material};
pub use survey::{Ground, Judged, StateWaves, Survey, SurveyedState, ZERO_FREQUENCY_FRACTION};
pub(crate) use unfolding::{Slowest, Unfolding, continuum};
pub(crate) use weakest::{Bottom, WeakestSearch};

use crate::bloch::{SpectrumSummary, Stability};
use crate::continuum::{AcousticMinimum, Ellipticity, Stiffness};
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, MaterialError, Response};
use crate::method::MethodError;
use crate::scheme::Discretization;
use nalgebra::SVector;

/// Origin of the first instability.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Verdict {
    /// All `omega^2` of the discretization are nonnegative, and the material has not lost ellipticity.
    Stable,
    /// Ellipticity is lost, and the long waves of the discretization grow too: the instability is the material's.
    Physical,
    /// No wave grows, but the method has zero-energy modes: the softest wave or a wave of alternating neighbors has no strain. Only the stress of the
    /// state can resist it.
    ZeroEnergy,
    /// Instability of the discretization. Modes grow although the material has not lost ellipticity, or although the long waves, which would show an
    /// instability of the material, do not grow. The cause is given by [`Mechanism`].
    Numerical,
    /// Ellipticity is lost, but the discretization is stable: it suppresses the material instability.
    Suppressed,
}

impl Verdict {
    /// All verdicts, in the order of the table in the book.
    pub const ALL: [Self; 5] = [
        Self::Stable,
        Self::Physical,
        Self::ZeroEnergy,
        Self::Numerical,
        Self::Suppressed,
    ];

    /// Title of the verdict in sentences and tables.
    pub fn title(self) -> &'static str {
        match self {
            Self::ZeroEnergy => "zero-energy modes",
            other => other.name(),
        }
    }

    /// Name of the verdict in files, in legends and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Physical => "physical",
            Self::ZeroEnergy => "zero-energy",
            Self::Numerical => "numerical",
            Self::Suppressed => "suppressed",
        }
    }
}

/// Response and ellipticity of the continuum at a state.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialAssessment<const D: usize> {
    /// Energy density, stress and tangent.
    pub response: Response,
    /// Smallest acoustic eigenvalue over all directions, with any complex eigenvalues; units of stress. They decide whether waves grow.
    pub minimum: AcousticMinimum<D>,
    /// Whether the state is strongly elliptic. For tangents with major symmetry this is the sign of the smallest eigenvalue; for other tangents
    /// strong ellipticity can be lost although no wave grows.
    pub ellipticity: Ellipticity,
    /// Mean Cauchy stress within the `D` dimensions; positive in tension.
    pub mean_stress: f64,
}

impl<const D: usize> MaterialAssessment<D> {
    /// Assesses the continuum for perturbations in the first `D` dimensions.
    ///
    /// # Errors
    /// [`MaterialError`] when the response over- or underflows.
    pub fn new(
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<Self, MaterialError> {
        Ok(Self::of(material.response(f)?))
    }

    /// Assesses the continuum with a known response.
    pub fn of(response: Response) -> Self {
        let stiffness = Stiffness::<D>::of(&response);
        let minimum = stiffness.minimum();
        let ellipticity = match stiffness.has_major_symmetry() {
            true => minimum.ellipticity(),
            false => stiffness.strong_ellipticity(),
        };
        Self {
            mean_stress: response.mean_stress(D),
            response,
            minimum,
            ellipticity,
        }
    }
}

/// Verdict on a state with its evidence.
#[derive(Clone, Debug, PartialEq)]
pub struct Assessment<const D: usize> {
    /// Verdict on the state.
    pub verdict: Verdict,
    /// Response and ellipticity of the continuum.
    pub material: MaterialAssessment<D>,
    /// Spectrum of the discretization.
    pub spectrum: SpectrumSummary<D>,
    /// Zero-energy mode of the verdict [`Verdict::ZeroEnergy`]; `None` for other verdicts.
    pub zero_energy: Option<ZeroEnergyWave>,
    /// Ratio of squared gradient norms, discrete over exact, of the softest mode: `sum_q V_q |B_q|^2 / (V0 |k|^2)` with `k` in the coordinates of the
    /// kernel.
    ///
    /// It is near one for long waves, and zero for a zero-energy mode. `None` if the discretization has no such gradient.
    pub gradient_norm: Option<f64>,
}

/// Zero-energy mode of a stable state: a wave without strain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZeroEnergyWave {
    /// Softest mode of the state.
    Softest,
    /// Mode of alternating neighbors that is not the softest mode.
    Alternating {
        /// Number of wave vectors of alternating neighbors with a zero-energy mode.
        count: usize,
        /// Number of these wave vectors at which the stress of the state resists all modes.
        resisted: usize,
    },
}

/// Largest frequency of weakly controlled waves, relative to the material's slowest wave with the same wave vector, in the reference configuration.
pub const WEAK_WAVE_RATIO: f64 = 0.1;

/// Mode of the reference configuration that is slow compared with the wave of the material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeakestMode<const D: usize> {
    /// Wave vector of the material wave; 1/length. The discretization determines it up to reciprocal vectors.
    pub wave_vector: SVector<f64, D>,
    /// Squared frequency, divided by the squared frequency of the material wave.
    pub relative_frequency_squared: f64,
}

impl<const D: usize> WeakestMode<D> {
    /// Frequency relative to the material's slowest wave, from 0 (zero-energy or growing mode) to 1 (not slower).
    pub fn relative_frequency(&self) -> f64 {
        self.relative_frequency_squared.clamp(0.0, 1.0).sqrt()
    }
}

/// Squared wave speed `c^2` of the scaled measures, length^2/time^2.
///
/// It is the largest acoustic eigenvalue of the material in the reference state, divided by the reference density.
///
/// # Errors
/// [`MaterialError`] when the response of the material in the reference state is not finite, or its largest acoustic eigenvalue is not positive.
pub fn speed_squared<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
) -> Result<f64, MaterialError> {
    let reference = material.undeformed()?;
    let eigenvalue = Stiffness::<D>::of(&reference).maximum_eigenvalue();
    speed_squared_of(eigenvalue, discretization.density())
}

/// Range of `c^2` whose powers neither overflow nor underflow.
const SPEED_SQUARED: [f64; 2] = [1e-200, 1e200];

/// Squared wave speed from the largest acoustic eigenvalue and the density.
fn speed_squared_of(eigenvalue: f64, density: f64) -> Result<f64, MaterialError> {
    let speed_squared = eigenvalue / density;
    if eigenvalue.is_nan() || eigenvalue <= 0.0 {
        Err(MaterialError::NoWaves { eigenvalue })
    } else if (SPEED_SQUARED[0]..=SPEED_SQUARED[1]).contains(&speed_squared) {
        Ok(speed_squared)
    } else {
        Err(MaterialError::WaveSpeed {
            stiffness: eigenvalue,
            density,
            range: SPEED_SQUARED,
        })
    }
}

/// Assesses a material and a discretization at a homogeneous state: [`Survey::assess`] for one state.
///
/// # Errors
/// [`MethodError`] when the material or the discretization cannot be evaluated there.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::method::{KernelMethodChoices, Frame, Method};
/// use onset::verdict::{Verdict, assess};
///
/// let material = ModifiedMooneyRivlin::default();
/// let state = DeformationGradient::from_stretches([1.2, 1.0, 1.0])?;
/// let lagrangian = Method::<2>::new(KernelMethodChoices::default())?;
/// assert_eq!(assess(&lagrangian, &material, &state)?.verdict, Verdict::Stable);
///
/// let sph = KernelMethodChoices { frame: Frame::Eulerian, ..KernelMethodChoices::default() };
/// let eulerian = Method::<2>::new(sph)?;
/// assert_eq!(assess(&eulerian, &material, &state)?.verdict, Verdict::Numerical);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn assess<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<Assessment<D>, MethodError> {
    Survey::new(discretization, material)?.assess(f)
}

/// Returns the spectrum, or an error if its scaled measures overflow or underflow.
fn finite<const D: usize>(spectrum: SpectrumSummary<D>) -> Result<SpectrumSummary<D>, MethodError> {
    let scaled = [spectrum.softest.scaled, spectrum.long_wave.scaled];
    if scaled.iter().any(|measure| measure.is_nan()) {
        Err(MethodError::NotFinite)
    } else {
        Ok(spectrum)
    }
}

/// Verdict from the stability of the material and of the discretization.
pub(crate) fn decided(
    material_grows: bool,
    is_stable: bool,
    has_zero_mode: bool,
    long_waves_grow: bool,
) -> Verdict {
    // A material at the margin of ellipticity has no growing wave that the discretization could suppress or share.
    match (material_grows, is_stable) {
        (false, true) if has_zero_mode => Verdict::ZeroEnergy,
        (false, true) => Verdict::Stable,
        (true, true) => Verdict::Suppressed,
        (true, false) if long_waves_grow => Verdict::Physical,
        _ => Verdict::Numerical,
    }
}

/// Returns the verdict and the stability at a state: [`Survey::judge`] for one state.
///
/// # Errors
/// [`MethodError`] when the discretization or the material cannot be evaluated there.
pub fn judge<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<(Verdict, Stability), MethodError> {
    Survey::new(discretization, material)?.judge(f)
}
