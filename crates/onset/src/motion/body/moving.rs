//! Interface of bodies in motion.

use super::BodyQuantities;
use crate::kinematics::DeformationGradient;
use crate::motion::{Fault, PatchState};
use crate::time_step::{Oscillation, Stepping};

/// Initial state of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Start {
    /// Homogeneous deformation about the origin.
    pub f: DeformationGradient,
    /// Largest random displacement along each axis; length.
    pub noise: f64,
    /// Seed of the random displacements.
    pub seed: u64,
}

/// Body in motion, for any dimension and method.
pub trait BodyMotion {
    /// Number of space dimensions.
    fn dimension(&self) -> usize;

    /// Positions of the particles in the reference configuration; length.
    fn positions(&self) -> Vec<[f64; 3]>;

    /// Sets the initial state, for steps of a given length.
    ///
    /// # Errors
    /// [`Fault`] if forces are undefined.
    fn start(&mut self, start: &Start, step: f64) -> Result<(), Box<Fault>>;

    /// Returns the state, with velocities half a step before the displacements.
    fn state(&self) -> PatchState;

    /// Continues from a state. `f` provides the stretches beyond the dimensions of the body.
    fn put(&mut self, state: &PatchState, f: &DeformationGradient);

    /// Advances by one leapfrog step: `v += a(u) dt`, except for gripped particles, `u += v dt`.
    ///
    /// # Errors
    /// [`Fault`] if forces are undefined or not finite.
    fn advance(&mut self, step: f64) -> Result<(), Box<Fault>>;

    /// Returns energies and momenta. `step` is the time step of the run.
    ///
    /// # Errors
    /// [`Fault`] if forces are undefined.
    fn quantities(&mut self, step: f64) -> Result<BodyQuantities, Box<Fault>>;

    /// Deformation gradients `F_I` of all particles, from the last evaluation of the forces.
    fn deformations(&self) -> Vec<[[f64; 3]; 3]>;

    /// Returns the largest stable step of central differences at the current displacements; time. Without viscosity it is `2 / omega`.
    ///
    /// With viscosity it is the root of `omega^2 dt^2 + 2 c dt = 4`, with the largest eigenvalues of stiffness and damping over mass. The result is
    /// below the exact step by a fraction of at most 3e-7, or by a few percent for large bodies. Particles of permanent grips are fixed, all others
    /// are free.
    ///
    /// The eigenvalues are bounded by a Krylov space and its residual, which is valid for symmetric matrices. The penalty makes the matrix of a body
    /// slightly unsymmetric.
    ///
    /// # Errors
    /// [`Fault`] if forces are undefined.
    fn critical_time_step(&mut self) -> Result<f64, Box<Fault>> {
        let Oscillation { squared, damping } = self.fastest_oscillation(Oscillation::NONE)?;
        Ok(Stepping::VelocityVerlet.critical_step(squared, damping))
    }

    /// Returns the largest eigenvalues of stiffness and damping, as for [`Self::critical_time_step`].
    ///
    /// An eigenvalue that is estimated to lie below the known eigenvalue is not computed further: the estimate is returned, which takes a fraction of the
    /// time.
    ///
    /// # Errors
    /// [`Fault`] if forces are undefined.
    fn fastest_oscillation(&mut self, known: Oscillation) -> Result<Oscillation, Box<Fault>>;

    /// Returns the accelerations at the current displacements, vector by vector; length/time^2.
    ///
    /// # Errors
    /// [`Fault`] if forces are undefined.
    fn accelerations(&mut self) -> Result<Vec<f64>, Box<Fault>>;

    /// Memory per particle; bytes.
    fn bytes_per_particle(&self) -> f64;
}
