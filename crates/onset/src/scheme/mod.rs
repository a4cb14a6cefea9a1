//! Discretizations of any kind: the forces on the particles of a crystal.
//!
//! A [`Discretization`] is the common interface of all methods: particles (or nodes) on a lattice with a basis, masses, and forces.
//! The forces are a sum over small groups of particles, the [`Interaction`]s: a quadrature point with its neighbors, a bond, an element.
//!
//! Each interaction is written once, as the forces on its particles in a displaced state, generic over the numbers of [`crate::real`].
//! Plain numbers give the forces of a simulation. First-order dual numbers give their exact derivatives in the same pass, and [`linearized`]
//! assembles these to the equations of plane waves.

mod choices;
mod classical;
pub mod conforming;
pub mod element;
pub mod kernel;
mod lagrangian;
mod layout;
mod linearized;
mod material_point;
mod moduli;
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
pub(crate) use choices::updated;
pub use lagrangian::LagrangianPoint;
pub(crate) use layout::{Measure, Weighed};
pub use linearized::{Forced, linearized};
pub use material_point::{
    Formulation, GridFunctions, GridGradients, GridMass, MaterialPointChoices, MaterialPoints,
    PointDilatation, PointLayout, Transfer,
};
pub use pairs::{Bond, PairLaw};
pub use parts::FiniteBodies;
pub use patch::{Assembled, NoForce, PatchForces, PatchTransfer, PeriodicPatch, PointsInMotion};
pub use peridynamics::{
    BondForm, BondModel, Calibration, Influence, PartialVolumes, Peridynamics, PeridynamicsChoices,
    ZeroEnergyControl,
};
pub use response::PointResponse;
pub(crate) use response::{Afresh, determinant, inverse};
pub use strain::{SeenForm, SeenPoint, StrainOperator};
pub(crate) use strain_roots::Singular;
pub(crate) use strain_rows::StrainRows;

use self::sph::CurrentPairs;
use crate::bloch::{
    BlochBlocks, DynamicalMatrix, GradientMoments, TransferredWaves, WaveSystem, ZoneSearch,
};
use crate::kinematics::DeformationGradient;
use crate::lattice::{Crystal, Fractional, Particle};
use crate::material::Hyperelastic;
use crate::method::{Method, MethodError};
use crate::real::Real;
use nalgebra::SVector;
use std::fmt::Debug;

/// Displacements and velocities of the particles of an interaction.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a, R, const D: usize> {
    /// Displacements from the homogeneous state, in the order of [`Interaction::particles`]; length.
    pub displacements: &'a [[R; D]],
    /// Velocities, which are zero in the homogeneous state; length/time.
    pub velocities: &'a [[R; D]],
}

/// Group of particles that exert forces on each other.
pub trait Interaction<const D: usize> {
    /// Particles of the group, each listed once. The forces depend only on their motion and act only on them.
    fn particles(&self) -> &[Particle<D>];

    /// Returns the force on each particle; force (in 2D per unit thickness, in 1D per unit cross-section).
    ///
    /// An interaction may exert a force on a particle in the homogeneous state. The sum over all interactions vanishes there.
    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]>;

    /// Returns true if the forces depend on the velocities.
    fn is_viscous(&self) -> bool {
        false
    }

    /// Adds the negative derivatives of the forces with respect to the displacements. The default differentiates [`Interaction::forces`]; an
    /// interaction may replace it by the faster chain rule.
    fn add_stiffness(&self, blocks: &mut BlochBlocks<D>) {
        linearized::differentiated(self, false, blocks);
    }
}

/// Waves caused by the quantities that particles carry, with positions held fixed.
#[derive(Clone, Debug)]
pub struct CarriedWaves<const D: usize> {
    /// Waves of all carried quantities.
    pub all: WaveSystem<D>,
    /// Part that follows the density; `None` if no carried quantity follows it.
    pub density: Option<WaveSystem<D>>,
}

/// Discretization of a solid by particles or nodes.
///
/// The methods without a default body define the discretization. The others are capabilities: a discretization that implements them gives the same
/// results faster or with sharper bounds. Callers do not depend on the type of the discretization.
pub trait Discretization<const D: usize>: Debug + Send + Sync {
    /// Particles in the reference configuration.
    fn crystal(&self) -> &Crystal<D>;

    /// Reference density; mass per reference volume.
    fn density(&self) -> f64;

    /// Masses of the particles of a cell, for consistent mass matrices the row sums; mass (in 2D per unit thickness, in 1D per unit cross-section).
    fn masses(&self) -> Vec<f64> {
        lumped_masses(self.crystal(), self.density())
    }

    /// Returns the linearized equations of motion of a material in a homogeneous state.
    ///
    /// # Errors
    /// [`MethodError`] if the discretization or the material cannot be evaluated there.
    fn waves(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<WaveSystem<D>, MethodError>;

    /// Strain operator in the reference configuration: the strains of a displacement, and the forms that the control of zero-energy modes resists. It
    /// is independent of the material.
    ///
    /// # Errors
    /// [`MethodError`] if the discretization cannot be evaluated there.
    fn strain(&self) -> Result<StrainOperator<D>, MethodError>;

    /// Calls a function with the forces on the particles of a periodic patch near a homogeneous state.
    ///
    /// The forces accept any displacements and velocities. [`waves`](Self::waves) uses their derivatives in the homogeneous state.
    ///
    /// # Errors
    /// [`MethodError`] if the discretization or the material cannot be evaluated there.
    fn with_forces(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
        patch: &PeriodicPatch<D>,
        work: &mut dyn FnMut(&dyn PatchForces<D>),
    ) -> Result<(), MethodError>;

    /// Returns the forces on the particles of a periodic patch after displacements from a homogeneous state, in the order of [`PeriodicPatch`]. All
    /// velocities are zero.
    ///
    /// # Errors
    /// [`MethodError`] if the discretization or the material cannot be evaluated there.
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

    /// Mean number of particles that contribute directly to the force on one particle in the reference configuration, including the particle itself.
    /// For kernel methods and material points: number of pairs of a point and a particle or node in its support, per particle or node. A measure of
    /// cost.
    fn neighbors(&self) -> f64;

    /// Returns the waves of a state by a faster method than [`waves`](Self::waves), with the zone of their wave vectors: closed-form force constants
    /// for one particle per cell. `speed_squared` is the `c^2` of the scaled measure.
    ///
    /// # Errors
    /// [`MethodError`] if the discretization or the material cannot be evaluated there.
    fn direct_waves(
        &self,
        _material: &dyn Hyperelastic,
        _f: &DeformationGradient,
        _speed_squared: f64,
    ) -> Result<Option<DirectWaves<D>>, MethodError> {
        Ok(None)
    }

    /// Returns the moments of discrete gradients that all states share. They give the extremes of the spectrum without a search.
    ///
    /// # Errors
    /// [`MethodError`] if the discretization cannot be evaluated.
    fn gradient_moments(
        &self,
        _speed_squared: f64,
    ) -> Result<Option<GradientMoments<D>>, MethodError> {
        Ok(None)
    }

    /// Returns the squared ratio of the discrete to the exact gradient norm of each wave, `sum_q V_q |B_q|^2 / (V0 |k|^2)`, if the method defines it.
    ///
    /// The wave vector `k` is in the coordinates of the kernel. A wave is given by a wave vector, or as the long-wave limit along a wave vector.
    ///
    /// # Errors
    /// [`MethodError`] if the discretization cannot be evaluated there.
    fn gradient_norms(
        &self,
        _f: &DeformationGradient,
        _waves: &[(SVector<f64, D>, bool)],
    ) -> Result<Option<Vec<f64>>, MethodError> {
        Ok(None)
    }

    /// Returns the part of the waves of a state that is caused by the quantities that particles carry.
    ///
    /// Deformation gradients and densities change with the wave while positions are held. A law in rate form has a stress that is integrated in time and a
    /// pressure that follows the density; in other laws the whole stress follows one of these two quantities. Codes that integrate stress or density
    /// in time compute this part from velocities and the remaining part from positions, which differ in discrete time; see
    /// [`Stepping`](crate::time_step::Stepping). `None` if the method does not separate the two parts.
    ///
    /// # Errors
    /// [`MethodError`] if the discretization or the material cannot be evaluated there.
    fn carried(
        &self,
        _material: &dyn Hyperelastic,
        _f: &DeformationGradient,
    ) -> Result<Option<CarriedWaves<D>>, MethodError> {
        Ok(None)
    }

    /// Returns the waves of a state in discrete time, for methods whose own step filters velocities. No equations of motion in continuous time have
    /// this damping; see [`TransferredWaves`]. `None` if integrators step the equations of [`waves`](Self::waves).
    ///
    /// # Errors
    /// [`MethodError`] if the discretization or the material cannot be evaluated there.
    fn transferred(
        &self,
        _material: &dyn Hyperelastic,
        _f: &DeformationGradient,
    ) -> Result<Option<TransferredWaves<D>>, MethodError> {
        Ok(None)
    }

    /// Returns bounds of the frequencies of finite bodies that consist of whole elements, material points or bonds. `None` if there is no bound.
    ///
    /// # Errors
    /// [`MethodError`] if the discretization or the material cannot be evaluated there.
    fn finite_bodies(
        &self,
        _material: &dyn Hyperelastic,
        _f: &DeformationGradient,
    ) -> Result<Option<FiniteBodies>, MethodError> {
        Ok(None)
    }

    /// Returns the method on the particles of a free block cut out of the crystal, with the given numbers of cells along the vectors of the canonical
    /// basis. The block begins at an origin in lattice coordinates of this basis relative to the first particle. `None` if the method has no forces on such
    /// particles, or if it has [bodies](crate::motion::body).
    ///
    /// # Errors
    /// [`MethodError`] if particles of the block have too few neighbors.
    fn on_block(
        &self,
        _cells: [usize; D],
        _origin: &Fractional<D>,
    ) -> Result<Option<Box<dyn Discretization<D>>>, MethodError> {
        Ok(None)
    }

    /// Returns the pair forces of particles whose neighbors are fixed in the reference configuration, for the simulation of
    /// [bodies](crate::motion::body). `None` if the method has no such forces.
    ///
    /// # Errors
    /// [`MethodError`] if the material cannot be evaluated in the reference state.
    fn pairs(
        &self,
        _material: &dyn Hyperelastic,
    ) -> Result<Option<Box<dyn PairLaw<D>>>, MethodError> {
        Ok(None)
    }

    /// Returns the pair forces of particles with changing neighbors, for the simulation of [bodies](crate::motion::body). The kernels belong to a
    /// homogeneous state. `None` if the method has no such forces.
    ///
    /// # Errors
    /// [`MethodError`] if the discretization or the material cannot be evaluated there.
    fn current_pairs(
        &self,
        _material: &dyn Hyperelastic,
        _f: &DeformationGradient,
    ) -> Result<Option<CurrentPairs<D>>, MethodError> {
        Ok(None)
    }

    /// Returns true if forces never depend on velocities.
    fn is_undamped(&self) -> bool {
        false
    }

    /// Returns true if undisplaced particles represent deformed states, so that wave vectors belong to the deformed lattice.
    fn is_regular(&self) -> bool {
        false
    }

    /// Returns the kernel method if interval arithmetic can enclose its force constants, so that results can be proved for its waves.
    fn enclosed(&self) -> Option<&Method<D>> {
        None
    }
}

/// Dynamical matrix of a method with one particle per cell, and the zone of its wave vectors.
#[derive(Clone, Debug)]
pub struct DirectWaves<const D: usize> {
    /// Search over the Brillouin zone.
    pub search: ZoneSearch<D>,
    /// Dynamical matrix in closed form.
    pub matrix: DynamicalMatrix<D>,
}

/// Returns the particle masses `rho0 V` from the volumes of a crystal.
pub fn lumped_masses<const D: usize>(crystal: &Crystal<D>, density: f64) -> Vec<f64> {
    crystal.volumes().iter().map(|v| density * v).collect()
}
