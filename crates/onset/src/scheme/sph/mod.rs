//! Smoothed particle hydrodynamics (SPH) for solids: total Lagrangian, and with kernels in current coordinates.
//!
//! Both evaluate the stress only at the particles. [`TotalLagrangianSph`] derives from an energy, keeps its reference neighbors, and has no tensile
//! instability. [`UpdatedSph`] is SPH as first published: forces between pairs of particles along the gradient of a kernel that moves with them.
//! These forces have one of several forms, which are equivalent in the continuum but not in the discretization. Neighbors are determined in the
//! homogeneous state: particles close to the support, which might enter it, have zero weight there.

mod bonds;
mod chain;
mod current;
mod interaction;
mod neighborhood;
mod pairwise;
mod springs;
mod stress;
mod total;
mod updated;

pub use bonds::ParticleGradient;
pub use current::CurrentPairs;
pub(crate) use current::Laden;
pub(crate) use neighborhood::correction;
pub use total::{ShearForces, TotalLagrangianChoices, TotalLagrangianSph};
pub use updated::{DensityEvolution, MomentumForm, UpdatedSph, UpdatedSphChoices};
