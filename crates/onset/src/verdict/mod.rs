//! Stable? Why not? Material or method?
//!
//! A [`Verdict`] compares one state of the continuum with one of the discretization and is never
//! given without its evidence, the [`Assessment`].

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
pub use survey::{Ground, Judged, StateWaves, Survey, SurveyedState};
pub(crate) use unfolding::{Displacements, Slowest, Unfolding, continuum, is_first};
pub(crate) use weakest::{Bottom, WeakestSearch};

use crate::bloch::{SpectrumSummary, Stability};
use crate::continuum::{AcousticMinimum, Ellipticity, Stiffness};
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, MaterialError, Response};
use crate::method::MethodError;
use crate::scheme::Discretization;
use nalgebra::SVector;

/// The origin of the first instability.
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
    /// No wave grows, but the method has zero-energy modes: the strains that it sees of its softest wave, or of one of alternating neighbors,
    /// vanish, so that nothing but the stress of the state, if anything, resists it.
    ZeroEnergy,
    /// An instability of the discretization: modes grow although the material has not lost
    /// ellipticity, or although the long waves, where the material's instability would show, do not.
    /// Its [`Mechanism`] tells how.
    Numerical,
    /// Ellipticity is lost, but the discretization is stable: it suppresses the material's instability.
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

    /// The verdict in words.
    pub fn title(self) -> &'static str {
        match self {
            Self::ZeroEnergy => "zero-energy modes",
            other => other.name(),
        }
    }

    /// The word used in files, on the command line and in legends.
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

/// What the continuum does at a state.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialAssessment<const D: usize> {
    /// Energy, stress and tangent.
    pub response: Response,
    /// The smallest acoustic eigenvalue over all directions, and complex ones: whether waves grow; units of stress.
    pub minimum: AcousticMinimum<D>,
    /// Whether the state is strongly elliptic. Where the tangent has major symmetry it is the sign of the smallest eigenvalue; elsewhere strong
    /// ellipticity can be lost without a wave that grows.
    pub ellipticity: Ellipticity,
    /// The mean Cauchy stress within the `D` dimensions; positive in tension.
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

    /// The same of a response.
    pub fn of(response: Response) -> Self {
        let stiffness = Stiffness::<D>::of(&response);
        let minimum = stiffness.minimum();
        let ellipticity = match stiffness.has_major_symmetry() {
            true => minimum.ellipticity(),
            false => stiffness.strong_ellipticity(),
        };
        let cauchy = response.cauchy();
        Self {
            response,
            minimum,
            ellipticity,
            mean_stress: (0..D).map(|i| cauchy[(i, i)]).sum::<f64>() / D as f64,
        }
    }
}

/// A verdict with its evidence.
#[derive(Clone, Debug, PartialEq)]
pub struct Assessment<const D: usize> {
    /// The verdict.
    pub verdict: Verdict,
    /// The continuum.
    pub material: MaterialAssessment<D>,
    /// The discretization.
    pub spectrum: SpectrumSummary<D>,
    /// Of the verdict [`Verdict::ZeroEnergy`]: which wave it is that strains nothing.
    pub zero_energy: Option<ZeroEnergyWave>,
    /// The squared norm of the discrete gradient of the softest mode over that of the exact gradient,
    /// `sum_q V_q |B_q|^2 / (V0 |k|^2)` with `k` in the coordinates of the kernel: near one for long waves, zero for a
    /// zero-energy mode. `None` where the discretization has no such gradient.
    pub gradient_norm: Option<f64>,
}

/// The wave of a stable state that strains nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZeroEnergyWave {
    /// The softest one.
    Softest,
    /// One of alternating neighbors, another than the softest.
    Alternating {
        /// How many wave vectors of alternating neighbors strain nothing.
        count: usize,
        /// At how many of them the stress of the state resists all modes.
        resisted: usize,
    },
}

/// Limit of weakly controlled waves: frequency relative to the material's slowest wave with the same wave vector, in the reference configuration.
pub const WEAK: f64 = 0.1;

/// A mode of the reference configuration that is slow beside the material's wave that it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeakestMode<const D: usize> {
    /// The wave vector of that wave; 1/length. The discretization knows it up to reciprocal vectors.
    pub wave_vector: SVector<f64, D>,
    /// Its squared frequency over that of the material.
    pub relative_frequency_squared: f64,
}

impl<const D: usize> WeakestMode<D> {
    /// Frequency relative to the material's slowest wave, from 0 (no energy, or growing) to 1 (not slower).
    pub fn relative_frequency(&self) -> f64 {
        self.relative_frequency_squared.clamp(0.0, 1.0).sqrt()
    }
}

/// The scale `c^2` of wave speeds: the largest acoustic eigenvalue of the material in the reference state over the
/// reference density. Length^2/time^2.
///
/// # Errors
/// [`MaterialError`] when the response of the material in the reference state is not finite, or carries no waves.
pub fn speed_squared<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
) -> Result<f64, MaterialError> {
    let reference = material.undeformed()?;
    let eigenvalue = Stiffness::<D>::of(&reference).maximum_eigenvalue();
    speed_squared_of(eigenvalue, discretization.density())
}

/// `c^2` of which powers neither over- nor underflow.
const SPEED_SQUARED: [f64; 2] = [1e-200, 1e200];

/// The scale of wave speeds from the largest acoustic eigenvalue and the density.
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
/// [`MethodError`] when one of them cannot be evaluated there.
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

/// A spectrum, unless its numbers over- or underflow.
fn finite<const D: usize>(spectrum: SpectrumSummary<D>) -> Result<SpectrumSummary<D>, MethodError> {
    let scaled = [spectrum.softest.scaled, spectrum.long_wave.scaled];
    if scaled.iter().any(|measure| measure.is_nan()) {
        Err(MethodError::NotFinite)
    } else {
        Ok(spectrum)
    }
}

/// The verdict on what is known of material and particles.
pub(crate) fn decided(
    material_grows: bool,
    is_stable: bool,
    has_zero_mode: bool,
    long_waves_grow: bool,
) -> Verdict {
    // A material at the margin has no wave that grows: there is none to miss or to follow.
    match (material_grows, is_stable) {
        (false, true) if has_zero_mode => Verdict::ZeroEnergy,
        (false, true) => Verdict::Stable,
        (true, true) => Verdict::Suppressed,
        (true, false) if long_waves_grow => Verdict::Physical,
        _ => Verdict::Numerical,
    }
}

/// The verdict on a state and how perturbations of the discretization develop: [`Survey::judge`] for one state.
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
