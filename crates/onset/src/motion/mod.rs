//! Nonlinear motion of a periodic patch of particles: the discrete equations of motion, integrated in time.
//!
//! The particles of a patch are displaced by `u` from a homogeneous state and obey `M dv/dt = f(u, v) - f(0, 0)`, `du/dt = T v` with the forces of
//! the method ([`Discretization::with_forces`]). The waves are computed from the derivatives of these forces.
//! Forces of the homogeneous state on particles that are not centers of symmetry are subtracted, as dead loads that hold the state.
//!
//! Methods that integrate the deformation from velocities perform a single step from the homogeneous state, with the neighbors of that state. Kernels
//! in material coordinates have no such limit.
//!
//! A [`Stepper`] advances the time. [`PatchWave`]s are the plane waves that fit into the patch, with their rates in discrete time from the
//! eigenvalues of the amplification matrix of a step.
//! Prediction and motion therefore share only the forces of the method: one differentiates them, the other adds them up.
//!
//! Material points whose velocities pass through a grid once per step use this step, and their waves are waves of the nodes.
//!
//! Finite systems with free surfaces and grips are in [body].
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
    ActualBody, ActualMode, ActualModes, BodyError, BodyMode, BodyMotion, BodyParticles,
    BodyQuantities, Contact, Grip, Notch, PlacedParticle, Shape, Start,
};
pub use fault::{Fault, Ground};
pub use patch::{MovingPatch, PatchMotion, PatchState, Quantities};
pub use stepper::Stepper;
pub use waves::{PatchWave, SteppedWave};

pub(crate) use body::{fastest_mode, lowest_modes, oscillation_of_free_blocks, with_body};
pub(crate) use patch::with_motion;
