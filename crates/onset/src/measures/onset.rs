//! Loss of stability along a loading, for material and method.

use crate::kinematics::{DeformationGradient, KinematicsError};
use crate::method::MethodError;
use crate::verdict::change::{Knot, Narrowed, narrow};
use crate::verdict::{Phase, Probe, Survey, probe_material};

/// Homogeneous loading of a `D`-dimensional body. Directions outside its dimensions are held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Load {
    /// Uniaxial strain in tension: `F = diag(s, 1, 1)`, `s > 1`.
    UniaxialStrainTension,
    /// Uniaxial strain in compression: `F = diag(s, 1, 1)`, `s < 1`.
    UniaxialStrainCompression,
    /// Equibiaxial strain in tension: `F = diag(s, s, 1)`, `s > 1`.
    EquibiaxialStrainTension,
    /// Equibiaxial strain in compression: `F = diag(s, s, 1)`, `s < 1`.
    EquibiaxialStrainCompression,
}

impl Load {
    /// All loadings, in the order of tables.
    pub const ALL: [Self; 4] = [
        Self::UniaxialStrainTension,
        Self::UniaxialStrainCompression,
        Self::EquibiaxialStrainTension,
        Self::EquibiaxialStrainCompression,
    ];

    /// Name of the loading in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::UniaxialStrainTension => "uniaxial strain tension",
            Self::UniaxialStrainCompression => "uniaxial strain compression",
            Self::EquibiaxialStrainTension => "equibiaxial strain tension",
            Self::EquibiaxialStrainCompression => "equibiaxial strain compression",
        }
    }

    /// Description of the loading in sentences and legends, for the given number of dimensions.
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

    /// Returns true if the loading increases stretches.
    pub fn is_tension(self) -> bool {
        matches!(
            self,
            Self::UniaxialStrainTension | Self::EquibiaxialStrainTension
        )
    }

    /// Returns true if a body of the given dimension can be loaded in this way.
    pub fn is_possible(self, dimension: usize) -> bool {
        let is_uniaxial = matches!(
            self,
            Self::UniaxialStrainTension | Self::UniaxialStrainCompression
        );
        is_uniaxial || dimension >= 2
    }

    /// Deformation gradient at a stretch.
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

/// End of stability along a loading.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum StretchOnset {
    /// The reference state is unstable.
    AtRest,
    /// Stability is lost at this stretch; 1 if any strain is sufficient.
    At(f64),
    /// Stability is retained up to this stretch, the last stretch evaluated.
    NotBefore(f64),
    /// The method or the law is not defined from this stretch on.
    Undefined(f64),
}

impl StretchOnset {
    /// Stretch at the loss of stability, or `None` if stability is not lost.
    pub fn stretch(self) -> Option<f64> {
        match self {
            Self::At(stretch) => Some(stretch),
            Self::AtRest => Some(1.0),
            Self::NotBefore(_) | Self::Undefined(_) => None,
        }
    }
}

/// First instability of material and method along a loading.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct OnsetPair {
    /// Loading of the body.
    pub load: Load,
    /// Loss of strong ellipticity of the material.
    pub material: StretchOnset,
    /// First growing wave of the discretization.
    pub method: StretchOnset,
}

impl OnsetPair {
    /// Ratio of the onset strains `s - 1`, method over material.
    ///
    /// It is one for a faithful method, and less than one for a method that is falsely unstable. If neither loses stability, or both lose it without
    /// strain, it is one; if only one of them loses stability, it is NaN. For a method that is unstable in the reference state it is zero.
    pub fn ratio(&self) -> f64 {
        match (self.material, self.method) {
            (StretchOnset::At(material), StretchOnset::At(method)) if material != 1.0 => {
                (method - 1.0) / (material - 1.0)
            }
            (StretchOnset::At(_) | StretchOnset::NotBefore(_), StretchOnset::AtRest) => 0.0,
            (StretchOnset::At(_), StretchOnset::At(1.0))
            | (StretchOnset::AtRest, StretchOnset::AtRest)
            | (StretchOnset::NotBefore(_), StretchOnset::NotBefore(_)) => 1.0,
            _ => f64::NAN,
        }
    }
}

/// Length of the bracket around the end of stability, in stretch.
const ONSET_BRACKET: f64 = 1e-10;
/// Number of steps in which a loading is sampled before the first change is refined.
const SAMPLING_STEPS: usize = 64;

/// Computes the first instability of material and method along a loading up to the stretch `end`, each to `1e-10`.
///
/// A return to stability between the 64 sampled states can be missed; [`crate::verdict::scan_discretization`] is more thorough.
///
/// # Errors
/// [`MethodError`] when a state cannot be evaluated. Lack of support and states outside the domain of the law are not errors, but
/// [`StretchOnset::Undefined`].
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
    let stretch = |n: usize| 1.0 + (end - 1.0) * n as f64 / SAMPLING_STEPS as f64;
    // With zero-energy modes the reference state is marginal; a state close to it is evaluated instead.
    let beside = 1.0 + 1e-6 * (end - 1.0);
    let mut before = (beside, probe(beside)?);
    match before.1.0 {
        Phase::Stable => {}
        Phase::Undefined => return Ok(StretchOnset::Undefined(1.0)),
        _ if probe(1.0)?.0 == Phase::Stable => return Ok(StretchOnset::At(1.0)),
        _ => return Ok(StretchOnset::AtRest),
    }
    for n in 1..=SAMPLING_STEPS {
        let behind = (stretch(n), probe(stretch(n))?);
        if behind.1.0 != Phase::Stable {
            return end_of_stability(before, behind, &probe);
        }
        before = behind;
    }
    Ok(StretchOnset::NotBefore(end))
}

/// Narrows the end of stability between a stable state and a state of another phase.
fn end_of_stability(
    stable: Knot,
    other: Knot,
    probe: &dyn Fn(f64) -> Result<Probe, MethodError>,
) -> Result<StretchOnset, MethodError> {
    match narrow(probe, (stable, other), ONSET_BRACKET)? {
        Narrowed::Change(_, (stretch, (Phase::Undefined, _))) => {
            Ok(StretchOnset::Undefined(stretch))
        }
        Narrowed::Change(_, (stretch, _)) => Ok(StretchOnset::At(stretch)),
        Narrowed::Third(between) => end_of_stability(stable, between, probe),
    }
}
