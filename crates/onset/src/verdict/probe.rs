//! Which phase, and how far from the next one?

use crate::continuum::Stiffness;
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, MaterialError};

/// Stable, unstable, or not defined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Phase {
    /// No perturbation grows.
    Stable,
    /// Some perturbations oscillate with growing amplitude; `Re omega^2` is nowhere negative.
    Flutter,
    /// Some perturbation grows without bound in one direction, `Re omega^2 < 0`.
    Unstable,
    /// The method cannot be evaluated: too few (or too many) neighbors in the support; or the law is not defined there.
    Undefined,
}

impl Phase {
    /// Whether some perturbation grows.
    pub fn is_unstable(self) -> bool {
        matches!(self, Self::Flutter | Self::Unstable)
    }

    /// The word used in files and in legends.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Flutter => "flutter",
            Self::Unstable => "unstable",
            Self::Undefined => "undefined",
        }
    }
}

/// A phase with a measure whose sign it is, where there is one: positive when stable, negative when unstable, not a
/// number when undefined. It is continuous where the method and its critical wave are.
pub type Probe = (Phase, f64);

/// Whether waves of a material grow at a state for perturbations in `D` dimensions, with the smallest acoustic
/// eigenvalue over all directions; units of stress. Where that is zero to rounding none grows, as in a fluid; where complex ones grow and no others, it is
/// flutter.
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
