//! Stability phase of a state, with a measure of its distance from the next phase.

use crate::continuum::Stiffness;
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, MaterialError};

/// Stability phase of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Phase {
    /// No perturbation grows.
    Stable,
    /// Some perturbations oscillate with growing amplitude, and no `Re omega^2` is negative.
    Flutter,
    /// Some perturbation diverges: `Re omega^2 < 0`.
    Unstable,
    /// The method cannot be evaluated, because particles have too few or too many neighbors in the support, or the law is not defined in this state.
    Undefined,
}

impl Phase {
    /// Returns true if some perturbation grows.
    pub fn is_unstable(self) -> bool {
        matches!(self, Self::Flutter | Self::Unstable)
    }

    /// Name of the phase in files and legends.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Flutter => "flutter",
            Self::Unstable => "unstable",
            Self::Undefined => "undefined",
        }
    }
}

/// Phase of a state with a stability measure: positive if stable, negative if unstable, NaN if undefined.
///
/// Flutter may have no measure of this sign. The measure is continuous where the method and its critical wave are continuous.
pub type Probe = (Phase, f64);

/// Phase of a material at a state, for perturbations in `D` dimensions, with its smallest acoustic eigenvalue over all directions; units of stress.
///
/// If the eigenvalue is zero to rounding, as in a fluid, no wave grows. If waves grow for complex eigenvalues only, the phase is flutter.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::verdict::{Phase, probe_material};
/// let f = DeformationGradient::from_stretches([0.8, 0.7, 1.0])?;
/// let (phase, measure) = probe_material::<2>(&ModifiedMooneyRivlin::default(), &f)?;
/// assert_eq!(phase, Phase::Stable);
/// assert!((measure - 0.13572).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`MaterialError`] when the response is not finite.
pub fn probe_material<const D: usize>(
    material: &dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<Probe, MaterialError> {
    let stiffness = match Stiffness::<D>::at(material, f) {
        Err(error) if error.leaves_undefined() => return Ok((Phase::Undefined, f64::NAN)),
        other => other?,
    };
    let minimum = stiffness.minimum();
    let phase = if minimum.ellipticity().is_lost() {
        Phase::Unstable
    } else if minimum.only_flutters() {
        Phase::Flutter
    } else {
        Phase::Stable
    };
    Ok((phase, minimum.significant()))
}
