//! Stable? Why not? Material or method?
//!
//! A [`Verdict`] compares one state of the continuum with one of the discretization and is never
//! given without its evidence, the [`Assessment`].

pub mod boundary;
pub mod fidelity;

mod path;
mod probe;
mod scheme;
mod survey;

pub use path::{
    Crossing, Onset, PathError, PathScan, scan_discretization, scan_material, scan_scheme,
};
pub use probe::{DiscretizationProbe, Phase, Probe, probe_material};
pub use scheme::SchemeSurvey;
pub use survey::{Survey, SurveyedState};

use crate::bloch::{
    Mode, SpectrumSummary, Stability, ZERO_ENERGY, ZoneSearch, dynamical_matrix, gradient_norm,
};
use crate::continuum::{AcousticMinimum, Ellipticity, Stiffness};
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, MaterialError, Response};
use crate::method::{Frame, Method, MethodError};

/// To whom the first instability belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Verdict {
    /// The material's waves do not grow, and no mode of the discretization does.
    Stable,
    /// Ellipticity is lost, and the discretization says so for long waves too: a faithful answer.
    Material,
    /// No wave grows, but the method has zero-energy modes: the strains that it sees of its softest wave vanish, so that nothing but the
    /// stress of the state, if anything, resists it.
    RankDeficient,
    /// The method's own instability: modes grow although the material's waves do not, or although its
    /// long waves, where the material's instability would show, do not. Tensile or compressive by the sign
    /// of the mean stress.
    Kernel,
    /// Ellipticity is lost, but the discretization is stable: it misses the material's instability.
    Missed,
}

impl Verdict {
    /// All verdicts, in the order of the table in the book.
    pub const ALL: [Self; 5] = [
        Self::Stable,
        Self::Material,
        Self::RankDeficient,
        Self::Kernel,
        Self::Missed,
    ];

    /// The word used in files, on the command line and in legends.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Material => "material",
            Self::RankDeficient => "rank-deficient",
            Self::Kernel => "kernel",
            Self::Missed => "missed",
        }
    }
}

/// What the continuum does at a state.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialAssessment<const D: usize> {
    /// Energy, stress and tangent.
    pub response: Response,
    /// The smallest acoustic eigenvalue over all directions, which tells whether the state is strongly elliptic; units of stress.
    pub minimum: AcousticMinimum<D>,
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
        let response = material.response(f)?;
        let minimum = Stiffness::<D>::of(&response).minimum();
        Ok(Self { response, minimum })
    }

    /// Whether every acoustic tensor is positive definite.
    pub fn ellipticity(&self) -> Ellipticity {
        self.minimum.ellipticity()
    }

    /// The mean Cauchy stress within the `D` dimensions; positive in tension.
    pub fn mean_stress(&self) -> f64 {
        let cauchy = self.response.cauchy();
        (0..D).map(|i| cauchy[(i, i)]).sum::<f64>() / D as f64
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
    /// The squared norm of the discrete gradient of the softest mode over that of the exact gradient,
    /// `sum_q V_q |B_q|^2 / (V0 |k|^2)` with `k` in the coordinates of the kernel: near one for long waves, zero for a
    /// zero-energy mode.
    pub gradient_norm: f64,
}

/// The scale `c^2` of wave speeds: the largest acoustic eigenvalue of the undeformed material over the
/// reference density. Length^2/time^2.
///
/// # Errors
/// [`MaterialError`] when the response of the undeformed material is not finite, or carries no waves.
pub fn speed_squared<const D: usize>(
    method: &Method<D>,
    material: &dyn Hyperelastic,
) -> Result<f64, MaterialError> {
    let reference = material.undeformed()?;
    let eigenvalue = Stiffness::<D>::of(&reference).maximum_eigenvalue();
    speed_squared_of(eigenvalue, method.discretization().density)
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

/// Assesses a material and a method at a homogeneous state.
///
/// # Errors
/// [`MethodError`] when one of them cannot be evaluated there.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::method::{Discretization, Frame, Method};
/// use onset::verdict::{Verdict, assess};
///
/// let material = ModifiedMooneyRivlin::default();
/// let state = DeformationGradient::from_stretches([1.2, 1.0, 1.0])?;
/// let lagrangian = Method::<2>::new(Discretization::default())?;
/// assert_eq!(assess(&lagrangian, &material, &state)?.verdict, Verdict::Stable);
///
/// let sph = Discretization { frame: Frame::Eulerian, ..Discretization::default() };
/// let eulerian = Method::<2>::new(sph)?;
/// assert_eq!(assess(&eulerian, &material, &state)?.verdict, Verdict::Kernel);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn assess<const D: usize>(
    method: &Method<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<Assessment<D>, MethodError> {
    let continuum = MaterialAssessment::new(material, f)?;
    let search = zone_search(method, material, f)?;
    let spectrum = finite(search.summary(&dynamical_matrix(method, material, f)?))?;

    let softest = &spectrum.softest;
    let gradient_norm = gradient_norm_of(method, f, &search, softest)?;
    let has_zero_mode = is_zero_energy(gradient_norm);
    let long_waves_grow = spectrum.long_wave.scaled < -spectrum.tolerance;
    let verdict = decided(
        continuum.ellipticity(),
        spectrum.is_stable(),
        has_zero_mode,
        long_waves_grow,
    );
    Ok(Assessment {
        verdict,
        material: continuum,
        spectrum,
        gradient_norm,
    })
}

/// Whether a mode strains no point of the discretization, by the squared norm of its discrete gradient over that of the exact one. In a
/// stressed state its `omega^2` need not vanish: forces of the stress can resist it, but no stiffness does, and a state with other
/// stresses lets it go.
fn is_zero_energy(gradient_norm: f64) -> bool {
    gradient_norm <= ZERO_ENERGY
}

/// The squared norm of the discrete gradient of a mode over that of the exact gradient.
fn gradient_norm_of<const D: usize>(
    method: &Method<D>,
    f: &DeformationGradient,
    search: &ZoneSearch<D>,
    mode: &Mode<D>,
) -> Result<f64, MethodError> {
    let norm = gradient_norm(method, f)?;
    let discrete = if mode.is_long_wave {
        norm.long_wave_stiffness()
            .acoustic_tensor(&mode.wave_vector)[(0, 0)]
    } else {
        norm.at(&mode.wave_vector)[(0, 0)].re
    };
    let k = search.kernel_wave_vector(&mode.wave_vector);
    Ok(discrete / k.norm_squared())
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
    ellipticity: Ellipticity,
    is_stable: bool,
    has_zero_mode: bool,
    long_waves_grow: bool,
) -> Verdict {
    // A material at the margin has no wave that grows: there is none to miss or to follow.
    match (ellipticity.is_lost(), is_stable) {
        (false, true) if has_zero_mode => Verdict::RankDeficient,
        (false, true) => Verdict::Stable,
        (true, true) => Verdict::Missed,
        (true, false) if long_waves_grow => Verdict::Material,
        _ => Verdict::Kernel,
    }
}

/// The verdict on a state and how perturbations of the discretization develop, without the evidence: the same as
/// [`assess`] says, several times faster where one witness of an instability is enough.
///
/// # Errors
/// [`MethodError`] when the method or the material cannot be evaluated there.
pub fn judge<const D: usize>(
    method: &Method<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<(Verdict, Stability), MethodError> {
    let ellipticity = Stiffness::<D>::at(material, f)?.ellipticity();
    let search = zone_search(method, material, f)?;
    let matrix = dynamical_matrix(method, material, f)?;
    let (stability, measure) = search.stability(&matrix);
    let is_stable = stability == Stability::Stable;
    // A zero-energy mode of a Lagrangian kernel has the measure zero; on an Eulerian one the stress acts too.
    let is_zero = measure <= search.tolerance(&matrix);
    let is_eulerian = method.discretization().frame == Frame::Eulerian;
    if is_stable && !ellipticity.is_lost() && (is_zero || is_eulerian) {
        // Whether a mode has no energy takes the mode itself.
        return Ok((assess(method, material, f)?.verdict, stability));
    }
    // Only where both are unstable do the long waves tell to whom it belongs.
    let long_waves_grow = ellipticity.is_lost() && !is_stable && search.long_waves_grow(&matrix);
    Ok((
        decided(ellipticity, is_stable, false, long_waves_grow),
        stability,
    ))
}

/// The zone search of a method at a state, with the material's scale of wave speeds.
///
/// # Errors
/// [`MethodError`] when the undeformed material or the deformed lattice is not finite.
pub fn zone_search<const D: usize>(
    method: &Method<D>,
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<ZoneSearch<D>, MethodError> {
    let speed_squared = speed_squared(method, material)?;
    ZoneSearch::new(method, f, speed_squared).ok_or(MethodError::NotFinite)
}
