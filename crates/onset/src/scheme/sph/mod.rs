//! Smoothed particle hydrodynamics for solids: total-Lagrangian, and with kernels of current coordinates.
//!
//! Both take stress at the particles only. [`TotalLagrangianSph`] derives from an energy, sees fixed neighbors, and has no tensile
//! instability; [`UpdatedSph`] is what the name first meant: forces between pairs of particles along the gradient of a kernel
//! that moves with them, in one of several forms that are the same in the continuum and differ here. Neighbors are those of
//! the homogeneous state: what is near enough to come in has no weight there.

mod chain;
mod current;
mod interaction;
mod neighborhood;
mod stress;
mod total;
mod updated;

pub use current::CurrentPairs;
pub(crate) use current::Laden;
pub(crate) use neighborhood::correction;
pub use total::{TotalLagrangianChoices, TotalLagrangianSph};
pub use updated::{DensityEvolution, MomentumForm, UpdatedSph, UpdatedSphChoices};
