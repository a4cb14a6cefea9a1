//! A body that moves.

use super::BodyQuantities;
use crate::kinematics::DeformationGradient;
use crate::motion::{Fault, PatchState};

/// How a body starts.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// The homogeneous deformation that it is given about the origin.
    pub f: DeformationGradient,
    /// The largest random displacement along each axis; length.
    pub noise: f64,
    /// The seed of the random displacements.
    pub seed: u64,
}

/// A body in motion, whatever its dimension and method.
pub trait BodyMotion {
    /// The number of space dimensions.
    fn dimension(&self) -> usize;

    /// Where the particles are in the reference state; length.
    fn positions(&self) -> Vec<[f64; 3]>;

    /// Puts the body at its start, for steps of a given length.
    ///
    /// # Errors
    /// [`Fault`] where there are no forces.
    fn start(&mut self, start: &Start, step: f64) -> Result<(), Box<Fault>>;

    /// The state: velocities are those half a step before.
    fn state(&self) -> PatchState;

    /// Takes a state up; the stretches beyond the dimensions of the body are those of `f`.
    fn put(&mut self, state: &PatchState, f: &DeformationGradient);

    /// One step of the leapfrog: `v += a(u) dt`, grips apart, `u += v dt`.
    ///
    /// # Errors
    /// [`Fault`] where there are no forces, or no finite ones.
    fn advance(&mut self, step: f64) -> Result<(), Box<Fault>>;

    /// Energies and momenta. `step` is that of the run.
    ///
    /// # Errors
    /// [`Fault`] where there are no forces.
    fn quantities(&mut self, step: f64) -> Result<BodyQuantities, Box<Fault>>;

    /// `F_I` of every particle, of the last evaluation of the forces.
    fn deformations(&self) -> Vec<[[f64; 3]; 3]>;

    /// Largest stable step at the present displacements, `2 / omega`; with viscosity the root of `omega^2 dt^2 + 2 c dt = 4`, with the largest
    /// eigenvalues of stiffness and damping over mass: it is below the exact step by at most 3e-7 of it, of large bodies by at most some
    /// percent. Particles that a grip holds to the end do not move, the others are free. Time.
    ///
    /// The eigenvalues are bounded by a Krylov space and its residual, as holds for symmetric matrices; the penalty makes that of a body a little unsymmetric.
    ///
    /// # Errors
    /// [`Fault`] where there are no forces.
    fn critical_time_step(&mut self) -> Result<f64, Box<Fault>>;

    /// Accelerations at the present displacements, one vector after the other; length/time^2.
    ///
    /// # Errors
    /// [`Fault`] where there are no forces.
    fn accelerations(&mut self) -> Result<Vec<f64>, Box<Fault>>;

    /// What is kept for a particle; bytes.
    fn bytes_per_particle(&self) -> f64;
}
