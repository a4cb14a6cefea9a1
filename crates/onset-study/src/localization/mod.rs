//! Plasticity and localization: the first state of a loading path at which a band forms in a plastic material, and the band.

mod answer;
mod figure;
mod parameters;

pub use answer::{BandAnswer, DirectionAnswer, LocalizationAnswer, PointAnswer};
pub use parameters::{PARAMETERS, Parameter, PlasticLaw, PlasticSettings, models};

use crate::settings::SettingError;
use onset::material::MaterialError;
use onset::plasticity::PlasticityError;
use thiserror::Error;

/// Reasons why there is no answer; all reasons are errors in the input.
#[derive(Debug, Error)]
pub enum LocalizationError {
    /// A setting is invalid.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The law is invalid or fails on the path.
    #[error("{source}{}", hint(source))]
    Plasticity {
        /// Cause of the failure.
        #[from]
        source: PlasticityError,
    },
}

/// Hint for an error of the law or the path.
fn hint(error: &PlasticityError) -> String {
    let hint = match error {
        PlasticityError::Parameter { name, .. }
        | PlasticityError::Law(MaterialError::Parameter { name, .. }) => format!("set it with --set material.{name}=..."),
        PlasticityError::SnapBack { .. } => {
            "reduce the softening (material.hardening-modulus, a larger material.reference-slip or reference-strain), or raise the stiffness"
                .to_owned()
        }
        PlasticityError::NeverYields { .. } => {
            "pressure outgrows the strength on this path: lower material.friction, or take another path; for a user routine, check with `onset audit` whether DDSDDE is the tangent of plastic flow".to_owned()
        }
        PlasticityError::Confinement { .. } => {
            "choose a material.confinement within the yield surface: with cam-clay above 0 and below material.preconsolidation; with other laws a lower one, or a larger material.strength".to_owned()
        }
        PlasticityError::ElasticNotElliptic => {
            "the strength is of the order of the stiffness: raise material.mu, or for a user routine the modulus in material.properties".to_owned()
        }
        PlasticityError::NoDeviator | PlasticityError::Apex => {
            "the path leads to the apex of the yield cone; add material.confinement".to_owned()
        }
        PlasticityError::Corner => return String::new(),
        PlasticityError::NotASheet => {
            "use --path uniaxial-stress or sheet-stretch without confinement, or set plasticity.bands=bulk".to_owned()
        }
        PlasticityError::NoElasticRange => {
            "if the law has no strength without pressure, add plasticity.confinement; laws without an elastic range are not supported".to_owned()
        }
        PlasticityError::NoBalance => {
            "check with `onset audit` whether DDSDDE is the tangent of the stress; choose another path or a plasticity.confinement".to_owned()
        }
        PlasticityError::NotAlongAxes => {
            "align the axes of the material with the path; `onset path` gives the ellipticity of other laws along a path".to_owned()
        }
        PlasticityError::SeveralMechanisms | PlasticityError::Unloads => {
            "`onset path` gives the ellipticity of any user material along a path".to_owned()
        }
        PlasticityError::Exhausted { .. }
        | PlasticityError::NotFinite
        | PlasticityError::Law(_) => return String::new(),
    };
    format!("\n  hint: {hint}")
}
