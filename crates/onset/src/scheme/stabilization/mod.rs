//! What is added to particle methods to keep them stable, each with its coefficient.
//!
//! | remedy | what it adds | against |
//! |---|---|---|
//! | penalty (Ganzenmueller) | springs along bonds that the deformation gradient misses | zero-energy modes of total-Lagrangian SPH |
//! | artificial viscosity (Monaghan) | dashpots along bonds | noise behind shocks; it damps, and moves no onset |
//! | artificial stress (Gray, Monaghan, Swift) | a repulsion of near particles in tension | the tensile instability |
//! | XSPH (Monaghan) | a smoothed velocity that moves the particles | disorder; it slows short waves |

mod artificial_stress;
mod penalty;
mod velocity_smoothing;
mod viscosity;

pub use artificial_stress::ArtificialStress;
pub use viscosity::{ArtificialViscosity, ViscositySwitch};

pub(super) use artificial_stress::Repulsion;
pub use penalty::PenaltyForm;
pub(super) use penalty::{BondPenalty, Compliance};
pub use velocity_smoothing::SmoothedMotion;
pub(super) use velocity_smoothing::{smoothed_velocities, smoothing_share};
pub(super) use viscosity::{Dashpot, Slope, ViscousBond, ViscousScales, viscous_bonds};

use crate::method::MethodError;

/// Refuses coefficients that are negative or not finite.
pub(super) fn assert_coefficients(given: &[(&'static str, f64)]) -> Result<(), MethodError> {
    given
        .iter()
        .try_for_each(|(name, value)| MethodError::not_negative(name, *value))
}
