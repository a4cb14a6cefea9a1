//! Motion: the discrete equations of motion of a periodic patch of particles, nonlinear, step by step.
//!
//! The particles of a patch are displaced by `u` from a homogeneous state, and obey `M dv/dt = f(u, v) - f(0, 0)`, `du/dt = T v` with the
//! forces of the method itself: those whose derivatives the waves are made of ([`Discretization::with_forces`]). What the homogeneous state leaves
//! on particles that are no centers of symmetry is taken off, as dead loads that hold it. Methods that follow the deformation by
//! velocities have one step of it from the homogeneous state, and the neighbors that particles have there; kernels of material coordinates have
//! no such limit.
//!
//! A [`Stepper`] takes steps of time; [`PatchWave`]s are the plane waves that fit into the patch, with their rates in discrete time, the eigenvalues of
//! the matrix by which a step multiplies them. So what is predicted and what moves share the forces of the method, and nothing else: the one
//! differentiates them, the other adds them up.
//!
//! Material points whose velocities go through a grid once a step are moved by that step, as far as they go, beside waves of the nodes.
//!
//! What is finite, with a free surface and grips, is a [body].
//!
//! [`Discretization::with_forces`]: crate::scheme::Discretization::with_forces

pub mod body;
mod equations;
mod fault;
mod patch;
mod stepper;
mod transfer;
mod waves;

pub use body::{
    BodyError, BodyMotion, BodyParticles, BodyQuantities, Contact, Grip, Notch, PlacedParticle,
    Shape, Start,
};
pub use fault::{Fault, Ground};
pub use patch::{MovingPatch, PatchMotion, PatchState, Quantities};
pub use stepper::Stepper;
pub use waves::{PatchWave, SteppedWave};

pub(crate) use body::{critical_step, step_of_free_blocks, with_body};
pub(crate) use patch::with_motion;
