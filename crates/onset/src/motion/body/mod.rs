//! Bodies: particles with a free surface, on an engine of their own.
//!
//! A body is cut out of the lattice of a method ([`Shape`]), or its particles are given one by one. Methods whose gradients stay with the material
//! say what a pair of particles has in common ([`PairLaw`](crate::scheme::PairLaw), a capability of [`Discretization`]); the engine adds up the same forces as
//! [`Discretization::with_forces`], the other way round: it gathers what each particle gets instead of scattering what each point gives, so that
//! particles can be worked on at the same time, several to a vector and on all cores, with one result to the last digit.
//!
//! With `a_IJ = V_J grad W_IJ` (one vector for a pair and its reverse when volumes are equal) and the correction `K_I = sum_J X_IJ (x) a_IJ`:
//!
//! `F_I = 1 + (sum_J (u_J - u_I) (x) a_IJ) K_I^-1`, `T_I = P(F_I) K_I^-T`, `f_I = V_I sum_J (T_I + T_J) a_IJ`,
//!
//! and the penalty along bonds takes `F_I + F_J` in the same way. Particles are numbered along the rows of the lattice, so that neighbors in space are mostly as far
//! away in that order from one particle as from the next: eight particles that follow each other are one group, which has for each kind of pair and each
//! distance in the order one entry, and a bit for every particle that has it. What a group sees is written once for all groups that see the same: a body with any
//! boundary keeps as little for a particle as one without, and particles that lie anywhere are groups with many entries of one bit.
//!
//! Methods whose kernels see current coordinates ([`Discretization::current_pairs`]) find neighbors again as particles move, and each particle carries its
//! deformation gradient. They gather in the same way, what a group sees being looked for in each step.
//!
//! Pieces of a body that do not see each other pass through each other, unless there is a [`Contact`] between them.
//!
//! Time is stepped by the leapfrog (central differences): one evaluation of the forces a step.
//!
//! [`Discretization`]: crate::scheme::Discretization
//! [`Discretization::current_pairs`]: crate::scheme::Discretization::current_pairs
//! [`Discretization::with_forces`]: crate::scheme::Discretization::with_forces

mod blocks;
mod contact;
mod current;
mod engine;
mod error;
mod grip;
mod lagrangian;
mod links;
mod moving;
mod neighborhoods;
mod neighbors;
mod parts;
mod quantities;
mod shape;
mod stability;
mod updated;
mod vectors;

pub(crate) use blocks::step_of_free_blocks;
pub use contact::Contact;
pub use error::BodyError;
pub use grip::Grip;
pub use moving::{BodyMotion, Start};
pub use quantities::BodyQuantities;
pub use shape::{BodyParticles, Notch, PlacedParticle, Shape};
pub(crate) use stability::critical_step;

use crate::material::Hyperelastic;
use crate::scheme::Discretization;
use lagrangian::with_lagrangian_body;
use updated::with_updated_body;

/// Does something with a body.
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
