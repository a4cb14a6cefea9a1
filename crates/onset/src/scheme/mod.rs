//! Discretizations of any kind: the forces on the particles of a crystal.
//!
//! A [`Discretization`] is what all methods have in common, and all that the rest of the program knows of them: particles (or nodes) on
//! a lattice with a basis, masses, and forces that are a sum over small groups of them, the [`Interaction`]s: a quadrature point with its neighbors, a bond, an element.
//! Each interaction is written once, as the forces that its particles get when they are displaced, generic over the
//! numbers of [`crate::real`]. Evaluated with plain numbers these are the forces of a simulation; with first-order dual
//! numbers, in the same pass, their exact derivative, from which [`linearized`] makes the equations of plane waves.

mod choices;
mod classical;
pub mod conforming;
pub mod element;
pub mod kernel;
mod lagrangian;
mod layout;
mod linearized;
mod material_point;
mod pairs;
mod parts;
mod patch;
mod peridynamics;
mod products;
mod response;
pub mod sph;
pub mod stabilization;
mod strain;
mod strain_roots;
mod strain_rows;

pub use choices::MethodChoices;
pub use lagrangian::LagrangianPoint;
pub(crate) use layout::{Measure, Weighed};
pub use linearized::{Forced, linearized};
pub use material_point::{
    Formulation, GridFunctions, GridGradients, GridMass, MaterialPointChoices, MaterialPoints,
    PointLayout, Transfer,
};
pub use pairs::{Bond, PairLaw};
pub use parts::FiniteBodies;
pub use patch::{Assembled, NoForce, PatchForces, PatchTransfer, PeriodicPatch, PointsInMotion};
pub use peridynamics::{
    BondModel, Calibration, Influence, PartialVolumes, Peridynamics, PeridynamicsChoices,
    ZeroEnergyControl,
};
pub use response::PointResponse;
pub(crate) use response::{determinant, inverse};
pub use strain::{SeenForm, SeenPoint, StrainOperator};
pub(crate) use strain_roots::Singular;
pub(crate) use strain_rows::StrainRows;

use self::sph::CurrentPairs;
use crate::bloch::{BlochBlocks, DynamicalMatrix, GradientMoments, WaveSystem, ZoneSearch};
use crate::kinematics::DeformationGradient;
use crate::lattice::{Crystal, Particle};
use crate::material::Hyperelastic;
use crate::method::{Method, MethodError};
use crate::real::Real;
use crate::time_step::TransferredWaves;
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

    /// Adds minus the derivatives of the forces by the displacements: those of [`Interaction::forces`], unless the interaction takes them faster by the
    /// chain rule.
    fn add_stiffness(&self, blocks: &mut BlochBlocks<D>) {
        linearized::differentiated(self, false, blocks);
    }
}

/// Waves by what particles carry along, positions held.
#[derive(Clone, Debug)]
pub struct CarriedWaves<const D: usize> {
    /// All of it.
    pub all: WaveSystem<D>,
    /// What of it follows the density; nothing where there is none.
    pub density: Option<WaveSystem<D>>,
}

/// A discretization of a solid by particles or nodes.
///
/// The first methods define it. Those with a body are capabilities: what a discretization knows beyond that, by which the same questions
/// are answered faster or more sharply. Nobody asks which method it is.
pub trait Discretization<const D: usize>: Debug + Send + Sync {
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

    /// What the discretization sees of a displacement of the reference configuration: its strains, and what its control of zero-energy modes
    /// sees besides, whatever the law.
    ///
    /// # Errors
    /// [`MethodError`] when the discretization cannot be evaluated there.
    fn strain(&self) -> Result<StrainOperator<D>, MethodError>;

    /// Does something with the forces on the particles of a periodic patch near a homogeneous state: those whose derivatives
    /// [`waves`](Self::waves) has, at any displacements and velocities.
    ///
    /// # Errors
    /// [`MethodError`] when the discretization or the material cannot be evaluated there.
    fn with_forces(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
        patch: &PeriodicPatch<D>,
        work: &mut dyn FnMut(&dyn PatchForces<D>),
    ) -> Result<(), MethodError>;

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
    ) -> Result<Vec<SVector<f64, D>>, MethodError> {
        let at_rest = vec![SVector::zeros(); patch.len()];
        let mut forces = Ok(Vec::new());
        self.with_forces(material, f, patch, &mut |own| {
            forces = own.at(displacements, &at_rest);
        })?;
        forces.map_err(|none| none.source.unwrap_or(MethodError::NotFinite))
    }

    /// The mean number of particles that an evaluation of the forces on one particle looks at in the reference state, itself
    /// included: a measure of cost.
    fn neighbors(&self) -> f64;

    /// The waves of a state by a shorter way than [`waves`](Self::waves), with the zone that holds their wave vectors: closed-form force
    /// constants of one particle a cell. `speed_squared` is the `c^2` of the scaled measure.
    ///
    /// # Errors
    /// [`MethodError`] when the discretization or the material cannot be evaluated there.
    fn direct_waves(
        &self,
        _material: &dyn Hyperelastic,
        _f: &DeformationGradient,
        _speed_squared: f64,
    ) -> Result<Option<DirectWaves<D>>, MethodError> {
        Ok(None)
    }

    /// The moments of discrete gradients that all states share, from which the extremes of the spectrum follow without a search.
    ///
    /// # Errors
    /// [`MethodError`] when the discretization cannot be evaluated.
    fn gradient_moments(
        &self,
        _speed_squared: f64,
    ) -> Result<Option<GradientMoments<D>>, MethodError> {
        Ok(None)
    }

    /// The squared norm of the discrete gradient of each wave over that of the exact gradient, `sum_q V_q |B_q|^2 / (V0 |k|^2)` with `k` in
    /// the coordinates of the kernel, where that is defined. A wave is a wave vector, or the limit of long waves along one.
    ///
    /// # Errors
    /// [`MethodError`] when the discretization cannot be evaluated there.
    fn gradient_norms(
        &self,
        _f: &DeformationGradient,
        _waves: &[(SVector<f64, D>, bool)],
    ) -> Result<Option<Vec<f64>>, MethodError> {
        Ok(None)
    }

    /// The part of the waves at a state by what particles carry along with them: deformation gradients and densities follow the wave,
    /// positions are held. A law in rate form has a stress that is integrated and a pressure that follows the density; of others all follows one of both. Codes that integrate stress or density in time follow this part by velocities and the rest of it by
    /// positions, which differ once time is discrete; see [`Stepping`](crate::time_step::Stepping). `None` where the method does
    /// not tell the two apart.
    ///
    /// # Errors
    /// [`MethodError`] when the discretization or the material cannot be evaluated there.
    fn carried(
        &self,
        _material: &dyn Hyperelastic,
        _f: &DeformationGradient,
    ) -> Result<Option<CarriedWaves<D>>, MethodError> {
        Ok(None)
    }

    /// The waves of a state in steps of time, where a step of the method itself filters velocities, so that no equations of motion in
    /// continuous time have its damping; see [`TransferredWaves`]. `None` where integrators step the equations of
    /// [`waves`](Self::waves).
    ///
    /// # Errors
    /// [`MethodError`] when the discretization or the material cannot be evaluated there.
    fn transferred(
        &self,
        _material: &dyn Hyperelastic,
        _f: &DeformationGradient,
    ) -> Result<Option<TransferredWaves<D>>, MethodError> {
        Ok(None)
    }

    /// What bounds the frequencies of finite bodies that are made of whole parts of the lattice: elements, material points, bonds. `None` where
    /// nothing does.
    ///
    /// # Errors
    /// [`MethodError`] when the discretization or the material cannot be evaluated there.
    fn finite_bodies(
        &self,
        _material: &dyn Hyperelastic,
        _f: &DeformationGradient,
    ) -> Result<Option<FiniteBodies>, MethodError> {
        Ok(None)
    }

    /// How particles act on each other in pairs whose vectors stay with the material, so that [bodies](crate::motion::body) of them can be run.
    ///
    /// # Errors
    /// [`MethodError`] when the material cannot be evaluated in the reference state.
    fn pairs(
        &self,
        _material: &dyn Hyperelastic,
    ) -> Result<Option<Box<dyn PairLaw<D>>>, MethodError> {
        Ok(None)
    }

    /// How particles act on each other in pairs whose neighbors are found again as they move, with the kernels of a homogeneous state, so that
    /// [bodies](crate::motion::body) of them can be run.
    ///
    /// # Errors
    /// [`MethodError`] when the discretization or the material cannot be evaluated there.
    fn current_pairs(
        &self,
        _material: &dyn Hyperelastic,
        _f: &DeformationGradient,
    ) -> Result<Option<CurrentPairs<D>>, MethodError> {
        Ok(None)
    }

    /// Whether forces never depend on velocities.
    fn is_undamped(&self) -> bool {
        false
    }

    /// Whether particles that have not moved stand for deformed ones, so that wave vectors are those of the deformed lattice.
    fn is_regular(&self) -> bool {
        false
    }

    /// The kernel method of which force constants can be enclosed in intervals, so that proofs speak of its waves.
    fn enclosed(&self) -> Option<&Method<D>> {
        None
    }
}

/// The dynamical matrix of one particle a cell, and the zone that holds its wave vectors.
#[derive(Clone, Debug)]
pub struct DirectWaves<const D: usize> {
    /// The zone.
    pub search: ZoneSearch<D>,
    /// The dynamical matrix.
    pub matrix: DynamicalMatrix<D>,
}

/// Particle masses `rho0 V` from the volumes of a crystal.
pub fn lumped_masses<const D: usize>(crystal: &Crystal<D>, density: f64) -> Vec<f64> {
    crystal.volumes().iter().map(|v| density * v).collect()
}
