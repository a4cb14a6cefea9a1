//! Discretizations of any kind: the forces on the particles of a crystal.
//!
//! A [`Scheme`] is what all particle methods have in common: particles (or nodes) on a lattice with a basis, masses, and forces
//! that are a sum over small groups of them, the [`Interaction`]s: a quadrature point with its neighbors, a bond, an element.
//! Each interaction is written once, as the forces that its particles get when they are displaced, generic over the
//! numbers of [`crate::real`]. Evaluated with plain numbers these are the forces of a simulation; with first-order dual
//! numbers, in the same pass, their exact derivative, from which [`linearized`] makes the equations of plane waves.

mod classical;
pub mod conforming;
pub mod element;
pub mod kernel;
mod lagrangian;
mod layout;
mod linearized;
mod material_point;
mod patch;
mod peridynamics;
mod products;
mod response;
pub mod sph;
pub mod stabilization;
mod strain;

pub use lagrangian::LagrangianPoint;
pub use linearized::{Forced, linearized};
pub use material_point::{
    Formulation, GridFunctions, GridMass, MaterialPointChoices, MaterialPoints, PointLayout,
};
pub use patch::{PeriodicPatch, patch_forces};
pub use peridynamics::{
    BondModel, Calibration, Influence, PartialVolumes, Peridynamics, PeridynamicsChoices,
    ZeroEnergyControl,
};
pub use response::PointResponse;
pub use strain::{SeenForm, SeenPoint, StrainOperator};

use crate::bloch::WaveSystem;
use crate::kinematics::DeformationGradient;
use crate::lattice::{Crystal, Particle};
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::real::Real;
use nalgebra::SVector;
use std::fmt::Debug;

/// How the particles of an interaction have moved.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a, R, const D: usize> {
    /// Displacements from the homogeneous state, in the order of [`Interaction::particles`]; length.
    pub displacements: &'a [[R; D]],
    /// Velocities; zero in the homogeneous state. Length/time.
    pub velocities: &'a [[R; D]],
}

/// A group of particles that exert forces on each other.
pub trait Interaction<const D: usize> {
    /// The particles that it sees and acts on; none twice.
    fn particles(&self) -> &[Particle<D>];

    /// The force on each of them; force (in one and two dimensions per unit of the dimensions that are left out).
    ///
    /// The homogeneous state itself may leave a force on a particle: those of all interactions together vanish there.
    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]>;

    /// Whether the forces depend on the velocities.
    fn is_viscous(&self) -> bool {
        false
    }
}

/// A discretization of a solid by particles or nodes.
pub trait Scheme<const D: usize>: Debug + Send + Sync {
    /// The particles in the reference state.
    fn crystal(&self) -> &Crystal<D>;

    /// The reference density; mass/volume.
    fn density(&self) -> f64;

    /// The linearized equations of motion of a material at a homogeneous state.
    ///
    /// # Errors
    /// [`MethodError`] when the discretization or the material cannot be evaluated there.
    fn waves(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<WaveSystem<D>, MethodError>;

    /// What the discretization sees of a displacement of the undeformed body: its strains, and what its control of zero-energy modes
    /// sees besides, whatever the law.
    ///
    /// # Errors
    /// [`MethodError`] when the discretization cannot be evaluated there.
    fn strain(&self) -> Result<StrainOperator<D>, MethodError>;

    /// The forces on the particles of a periodic patch that are displaced from a homogeneous state, in the order of
    /// [`PeriodicPatch`]; the particles are at rest.
    ///
    /// # Errors
    /// [`MethodError`] when the discretization or the material cannot be evaluated there.
    fn forces(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
        patch: &PeriodicPatch<D>,
        displacements: &[SVector<f64, D>],
    ) -> Result<Vec<SVector<f64, D>>, MethodError>;

    /// The mean number of particles that an evaluation of the forces on one particle looks at in the reference state, itself
    /// included: a measure of cost.
    fn neighbors(&self) -> f64;
}

/// Particle masses `rho0 V` from the volumes of a crystal.
pub fn lumped_masses<const D: usize>(crystal: &Crystal<D>, density: f64) -> Vec<f64> {
    crystal.volumes().iter().map(|v| density * v).collect()
}
