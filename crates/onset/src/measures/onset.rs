//! Where stability ends along a loading, for the material and for the method.

use crate::kinematics::{DeformationGradient, KinematicsError};
use crate::method::MethodError;
use crate::verdict::change::{Knot, Narrowed, narrow};
use crate::verdict::{Phase, Probe, Survey, probe_material};

/// A homogeneous loading of a `D`-dimensional body; what is out of its dimensions is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Load {
    /// `F = diag(s, 1, 1)`, `s > 1`.
    UniaxialStrainTension,
    /// `F = diag(s, 1, 1)`, `s < 1`.
    UniaxialStrainCompression,
    /// `F = diag(s, s, 1)`, `s > 1`.
    EquibiaxialStrainTension,
    /// `F = diag(s, s, 1)`, `s < 1`.
    EquibiaxialStrainCompression,
}

impl Load {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::UniaxialStrainTension,
        Self::UniaxialStrainCompression,
        Self::EquibiaxialStrainTension,
        Self::EquibiaxialStrainCompression,
    ];

    /// The word used in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::UniaxialStrainTension => "uniaxial strain tension",
            Self::UniaxialStrainCompression => "uniaxial strain compression",
            Self::EquibiaxialStrainTension => "equibiaxial strain tension",
            Self::EquibiaxialStrainCompression => "equibiaxial strain compression",
        }
    }

    /// Its description in sentences and legends, in the given number of dimensions.
    pub fn title(self, dimension: usize) -> &'static str {
        match (self, dimension) {
            (Self::UniaxialStrainTension, 1) => "stretch along the chain",
            (Self::UniaxialStrainTension, 2) => "stretch along axis 1, the other held",
            (Self::UniaxialStrainTension, _) => "stretch along axis 1, the others held",
            (Self::UniaxialStrainCompression, 1) => "compression along the chain",
            (Self::UniaxialStrainCompression, 2) => "compression along axis 1, the other held",
            (Self::UniaxialStrainCompression, _) => "compression along axis 1, the others held",
            (Self::EquibiaxialStrainTension, 0..=2) => "equibiaxial stretch",
            (Self::EquibiaxialStrainTension, _) => "equibiaxial stretch, axis 3 held",
            (Self::EquibiaxialStrainCompression, 0..=2) => "equibiaxial compression",
            (Self::EquibiaxialStrainCompression, _) => "equibiaxial compression, axis 3 held",
        }
    }

    /// Whether stretches grow.
    pub fn is_tension(self) -> bool {
        matches!(
            self,
            Self::UniaxialStrainTension | Self::EquibiaxialStrainTension
        )
    }

    /// Whether a body of so many dimensions can be loaded like this.
    pub fn is_possible(self, dimension: usize) -> bool {
        let is_uniaxial = matches!(
            self,
            Self::UniaxialStrainTension | Self::UniaxialStrainCompression
        );
        is_uniaxial || dimension >= 2
    }

    /// The deformation at a stretch.
    ///
    /// # Errors
    /// [`KinematicsError`] when the stretch is not admissible.
    pub fn at(self, stretch: f64) -> Result<DeformationGradient, KinematicsError> {
        let second = match self {
            Self::UniaxialStrainTension | Self::UniaxialStrainCompression => 1.0,
            Self::EquibiaxialStrainTension | Self::EquibiaxialStrainCompression => stretch,
        };
        DeformationGradient::from_stretches([stretch, second, 1.0])
    }
}

/// Where stability ends.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum StretchOnset {
    /// The reference state is unstable already.
    AtRest,
    /// At this stretch; at 1 where the slightest strain is enough.
    At(f64),
    /// Not up to the last stretch that was looked at.
    NotBefore(f64),
    /// The method or the law is not defined from this stretch on.
    Undefined(f64),
}

impl StretchOnset {
    /// The stretch, where there is one.
    pub fn stretch(self) -> Option<f64> {
        match self {
            Self::At(stretch) => Some(stretch),
            Self::AtRest => Some(1.0),
            Self::NotBefore(_) | Self::Undefined(_) => None,
        }
    }
}

/// The first instability along a loading, of material and method.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct OnsetPair {
    /// The loading.
    pub load: Load,
    /// Of the continuum: loss of strong ellipticity.
    pub material: StretchOnset,
    /// Of the discretization: the first growing wave.
    pub method: StretchOnset,
}

impl OnsetPair {
    /// The strain `s - 1` at which the method loses stability over that at which the material does: one for a faithful method,
    /// less for one that is falsely unstable. Not a number where the material stays stable and the method does not, or the
    /// other way round; one where both stay stable.
    pub fn ratio(&self) -> f64 {
        match (self.material, self.method) {
            (StretchOnset::At(material), StretchOnset::At(method)) => {
                (method - 1.0) / (material - 1.0)
            }
            (StretchOnset::At(_) | StretchOnset::NotBefore(_), StretchOnset::AtRest) => 0.0,
            (StretchOnset::NotBefore(_), StretchOnset::NotBefore(_)) => 1.0,
            _ => f64::NAN,
        }
    }
}

/// How near to each other the stretches on both sides of the end of stability are.
const CLOSE: f64 = 1e-10;
/// Steps in which a loading is looked at before the first change is refined.
const STEPS: usize = 64;

/// The first instability along a loading up to the stretch `end`, of material and method, each to `1e-10`.
///
/// Between the states that are looked at (64 of them) a return to stability can pass unseen; along paths see
/// [`crate::verdict::scan_discretization`].
///
/// # Errors
/// [`MethodError`] when a state cannot be evaluated for another reason than its support or the law's domain.
pub fn onset<const D: usize>(
    survey: &Survey<'_, D>,
    load: Load,
    end: f64,
) -> Result<OnsetPair, MethodError> {
    let material = first(end, |stretch| {
        Ok(probe_material::<D>(survey.material(), &load.at(stretch)?)?)
    })?;
    let method = first(end, |stretch| survey.probe(&load.at(stretch)?))?;
    Ok(OnsetPair {
        load,
        material,
        method,
    })
}

fn first(
    end: f64,
    probe: impl Fn(f64) -> Result<Probe, MethodError>,
) -> Result<StretchOnset, MethodError> {
    let stretch = |n: usize| 1.0 + (end - 1.0) * n as f64 / STEPS as f64;
    // The reference state itself is at the limit where modes have no energy: looked at are states beside it.
    let beside = 1.0 + 1e-6 * (end - 1.0);
    let mut before = (beside, probe(beside)?);
    match before.1.0 {
        Phase::Stable => {}
        Phase::Undefined => return Ok(StretchOnset::Undefined(1.0)),
        _ if probe(1.0)?.0 == Phase::Stable => return Ok(StretchOnset::At(1.0)),
        _ => return Ok(StretchOnset::AtRest),
    }
    for n in 1..=STEPS {
        let behind = (stretch(n), probe(stretch(n))?);
        if behind.1.0 != Phase::Stable {
            return end_of_stability(before, behind, &probe);
        }
        before = behind;
    }
    Ok(StretchOnset::NotBefore(end))
}

/// Where stability ends between a stable state and another one.
fn end_of_stability(
    stable: Knot,
    other: Knot,
    probe: &dyn Fn(f64) -> Result<Probe, MethodError>,
) -> Result<StretchOnset, MethodError> {
    match narrow(probe, (stable, other), CLOSE)? {
        Narrowed::Change(_, (stretch, (Phase::Undefined, _))) => {
            Ok(StretchOnset::Undefined(stretch))
        }
        Narrowed::Change(_, (stretch, _)) => Ok(StretchOnset::At(stretch)),
        Narrowed::Third(between) => end_of_stability(stable, between, probe),
    }
}
