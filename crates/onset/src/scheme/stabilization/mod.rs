//! Terms that stabilize particle methods, each with its coefficient.
//!
//!  term | effect | purpose |
//! |---|---|---|
//!  penalty (Ganzenmueller) | springs along bonds that the deformation gradient misses | against zero-energy modes of total-Lagrangian SPH |
//!  artificial viscosity (Monaghan) | dashpots along bonds | against noise behind shocks; damps waves, leaves the onset unchanged |
//!  artificial stress (Gray, Monaghan, Swift) | a repulsion of near particles in tension | against the tensile instability |
//!  upwinding (Lee, Gil, Ghavamian, Bonet) | dissipation of an acoustic Riemann solver between pairs | against noise; damps waves, leaves the onset unchanged |
//!  XSPH (Monaghan) | particles move with a smoothed velocity | against disorder; slows short waves |

mod artificial_stress;
mod penalty;
mod upwinding;
mod velocity_smoothing;
mod viscosity;

pub use artificial_stress::ArtificialStress;
pub use viscosity::{ArtificialViscosity, ViscositySwitch};

pub(super) use artificial_stress::Repulsion;
pub use penalty::PenaltyForm;
pub(super) use penalty::{BondPenalty, Compliance};
pub(super) use upwinding::RiemannPairs;
pub use upwinding::Upwinding;
pub use velocity_smoothing::SmoothedMotion;
pub(super) use velocity_smoothing::{smoothed_velocities, smoothing_share};
pub(super) use viscosity::{Dashpot, Slope, ViscousBond, ViscousScales, viscous_bonds};

use crate::method::MethodError;

/// Rejects coefficients that are negative or not finite.
pub(super) fn assert_coefficients(given: &[(&'static str, f64)]) -> Result<(), MethodError> {
    given
        .iter()
        .try_for_each(|(name, value)| MethodError::not_negative(name, *value))
}
