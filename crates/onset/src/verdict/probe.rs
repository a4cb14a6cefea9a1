//! One question, asked of many states: which phase, and how far from the next one?

use super::speed_squared;
use crate::bloch::{Stability, ZoneSearch, dynamical_matrix};
use crate::continuum::Stiffness;
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, MaterialError};
use crate::method::{Method, MethodError};

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
/// eigenvalue over all directions; units of stress. Where that is zero to rounding none grows, as in a fluid.
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
    } else {
        Phase::Stable
    };
    Ok((phase, minimum.significant()))
}

/// Asks a discretization about many states: what they share is computed once.
#[derive(Clone, Copy)]
pub struct DiscretizationProbe<'a, const D: usize> {
    method: &'a Method<D>,
    material: &'a dyn Hyperelastic,
    speed_squared: f64,
}

impl<'a, const D: usize> DiscretizationProbe<'a, D> {
    /// A method with its material.
    ///
    /// # Errors
    /// [`MaterialError`] when the response of the undeformed material is not finite.
    pub fn new(
        method: &'a Method<D>,
        material: &'a dyn Hyperelastic,
    ) -> Result<Self, MaterialError> {
        Ok(Self {
            method,
            material,
            speed_squared: speed_squared(method, material)?,
        })
    }

    /// The phase of the particles at a state, with the scaled measure `Re omega^2 / (c^2 |k|_h^2)` of the softest wave
    /// (of an unstable state that of a witness). Dimensionless.
    ///
    /// # Errors
    /// [`MethodError`] when the state cannot be evaluated for another reason than its support, which is
    /// [`Phase::Undefined`].
    pub fn at(&self, f: &DeformationGradient) -> Result<Probe, MethodError> {
        match self.stability(f) {
            Ok((Stability::Stable, measure)) => Ok((Phase::Stable, measure)),
            Ok((Stability::Flutter, measure)) => Ok((Phase::Flutter, measure)),
            Ok((Stability::Divergence, measure)) => Ok((Phase::Unstable, measure)),
            Err(error) if error.leaves_undefined() => Ok((Phase::Undefined, f64::NAN)),
            Err(error) => Err(error),
        }
    }

    fn stability(&self, f: &DeformationGradient) -> Result<(Stability, f64), MethodError> {
        let search =
            ZoneSearch::new(self.method, f, self.speed_squared).ok_or(MethodError::NotFinite)?;
        let matrix = dynamical_matrix(self.method, self.material, f)?;
        Ok(search.stability(&matrix))
    }
}
