//! Bodies: particles with free surfaces, computed by a dedicated engine.
//!
//! A body is cut out of the lattice of a method ([`Shape`]), or its particles are given individually. Methods whose gradients stay with the material
//! provide their pair forces ([`PairLaw`](crate::scheme::PairLaw), a capability of [`Discretization`]).
//! The engine computes the same forces as [`Discretization::with_forces`], but gathers the contributions to each particle instead of scattering the
//! contributions of each point.
//! Particles can therefore be computed in parallel, several in a vector register and on all cores, with bitwise identical results.
//!
//! With `a_IJ = V_J grad W_IJ` (one vector for a pair and its reverse when volumes are equal) and the correction `K_I = sum_J X_IJ (x) a_IJ`:
//!
//! `F_I = 1 + (sum_J (u_J - u_I) (x) a_IJ) K_I^-1`, `T_I = P(F_I) K_I^-T`, `f_I = V_I sum_J (T_I + T_J) a_IJ`,
//!
//! and the penalty along bonds uses `F_I + F_J` in the same way. Particles are numbered along the rows of the lattice, so that most neighbors have
//! the same offset in this order from one particle to the next. Eight consecutive particles form a group. For each kind of pair and each offset the
//! group has one entry with a bit for every particle that has this pair. Groups with the same neighbors share one entry list: a body with any
//! boundary needs as little memory per particle as the infinite lattice. Particles at arbitrary positions form groups with many entries of one bit.
//!
//! Methods with kernels in current coordinates ([`Discretization::current_pairs`]) update the neighbors as particles move, and each particle carries
//! its deformation gradient. The sums are gathered in the same way, with the neighbors of a group determined in each step.
//!
//! Pieces of a body that are not neighbors of each other pass through each other, unless a [`Contact`] between them is defined.
//!
//! Time integration uses the leapfrog scheme (central differences), with one evaluation of the forces per step.
//!
//! [`Discretization`]: crate::scheme::Discretization
//! [`Discretization::current_pairs`]: crate::scheme::Discretization::current_pairs
//! [`Discretization::with_forces`]: crate::scheme::Discretization::with_forces

mod actual;
mod blocks;
mod contact;
mod current;
mod engine;
mod error;
mod factor;
mod grip;
mod lagrangian;
mod links;
mod moving;
mod neighborhoods;
mod neighbors;
mod operator;
mod parts;
mod quantities;
mod shape;
mod stability;
mod updated;
mod vectors;

pub(crate) use actual::lowest_modes;
pub use actual::{ActualBody, ActualMode, ActualModes};
pub(crate) use blocks::oscillation_of_free_blocks;
pub use contact::Contact;
pub use error::BodyError;
pub use grip::Grip;
pub use moving::{BodyMotion, Start};
pub use operator::BodyMode;
pub(crate) use operator::fastest_mode;
pub use quantities::BodyQuantities;
pub use shape::{BodyParticles, Notch, PlacedParticle, Shape};

use crate::material::Hyperelastic;
use crate::scheme::Discretization;
use lagrangian::with_lagrangian_body;
use updated::with_updated_body;

/// Calls a function with a body.
pub(crate) fn with_body<const D: usize>(
    discretization: &dyn Discretization<D>,
    material: &dyn Hyperelastic,
    particles: &BodyParticles,
    grips: &[Grip],
    contact: Option<Contact>,
    work: &mut dyn FnMut(&mut dyn BodyMotion),
) -> Result<(), BodyError> {
    match discretization.pairs(material)? {
        Some(law) => {
            let crystal = discretization.crystal();
            with_lagrangian_body(&*law, crystal, material, particles, grips, contact, work)
        }
        None => with_updated_body(discretization, material, particles, grips, contact, work),
    }
}
