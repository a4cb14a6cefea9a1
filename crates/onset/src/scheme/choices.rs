//! Choices that define a discretization, for every family of methods in one, two and three dimensions.

use super::conforming::{ConformingChoices, ConformingIntegration};
use super::element::{ElementChoices, FiniteElements};
use super::kernel::{CrystalQuadrature, KernelChoices, KernelScheme};
use super::sph::{TotalLagrangianChoices, TotalLagrangianSph, UpdatedSph, UpdatedSphChoices};
use super::{
    Discretization, MaterialPointChoices, MaterialPoints, Peridynamics, PeridynamicsChoices,
};
use crate::approximation::Approximation;
use crate::lattice::{Crystal, delaunay_centers, voronoi_volumes};
use crate::method::{
    Background, CellKind, Frame, KernelMethodChoices, Linearization, Method, MethodCell,
    MethodError,
};
use crate::quadrature::Quadrature;

/// Choices that define a discretization of any family. For methods with particles on a lattice the first entry gives the lattice.
/// Its remaining choices apply to kernel methods only.
#[derive(Clone, Debug, PartialEq)]
pub enum MethodChoices {
    /// Kernel Galerkin methods with explicit quadrature.
    Kernel(Box<KernelMethodChoices>),
    /// Smoothed particle hydrodynamics (SPH) with kernels in material coordinates.
    TotalLagrangianSph(Box<KernelMethodChoices>, TotalLagrangianChoices),
    /// Smoothed particle hydrodynamics (SPH) with kernels in current coordinates. The particle spacing replaces the spacing of the artificial stress.
    UpdatedSph(Box<KernelMethodChoices>, UpdatedSphChoices),
    /// Finite elements with linear shape functions.
    FiniteElements(ElementChoices),
    /// Conforming nodal integration, with gradients averaged over a region around each node.
    Conforming(Box<KernelMethodChoices>, ConformingChoices),
    /// Bond-based or correspondence peridynamics.
    Peridynamics(Box<KernelMethodChoices>, PeridynamicsChoices),
    /// The material point method.
    MaterialPoints(Box<KernelMethodChoices>, MaterialPointChoices),
}

impl MethodChoices {
    /// Number of space dimensions.
    pub fn dimension(&self) -> usize {
        match self {
            Self::FiniteElements(choices) => choices.mesh.dimension(),
            Self::Kernel(particles)
            | Self::TotalLagrangianSph(particles, _)
            | Self::UpdatedSph(particles, _)
            | Self::Conforming(particles, _)
            | Self::Peridynamics(particles, _)
            | Self::MaterialPoints(particles, _) => particles.lattice.dimension(),
        }
    }

    /// Returns the discretization, reduced to the primitive cell of its particles and quadrature points. Results therefore do not depend on the
    /// choice of the cell.
    ///
    /// ```
    /// use onset::method::KernelMethodChoices;
    /// use onset::scheme::{MethodChoices, element::ElementChoices};
    /// let kernels = MethodChoices::Kernel(Box::new(KernelMethodChoices::default()));
    /// assert_eq!(kernels.discretization::<2>()?.crystal().sites().len(), 1);
    /// let elements = MethodChoices::FiniteElements(ElementChoices::default());
    /// assert_eq!(elements.discretization::<2>()?.neighbors(), 9.0);
    /// # Ok::<(), onset::method::MethodError>(())
    /// ```
    ///
    /// # Errors
    /// [`MethodError`] if a number is out of range, or if the number of dimensions is not `D`.
    pub fn discretization<const D: usize>(
        &self,
    ) -> Result<Box<dyn Discretization<D>>, MethodError> {
        self.in_cell(CellKind::Primitive)
    }

    /// Returns the discretization in the cell of the choices, for use on patches.
    ///
    /// # Errors
    /// The errors are listed under [`MethodChoices::discretization`].
    pub fn described<const D: usize>(&self) -> Result<Box<dyn Discretization<D>>, MethodError> {
        self.in_cell(CellKind::Described)
    }

    /// Returns the discretization of given particles; `None` for methods whose particles have no forces at arbitrary
    /// positions: finite elements, conforming integration, material points, and quadrature points other than the particles.
    ///
    /// # Errors
    /// [`MethodError`] if the method cannot be set up for these particles.
    pub fn of_particles<const D: usize>(
        &self,
        crystal: Crystal<D>,
    ) -> Result<Option<Box<dyn Discretization<D>>>, MethodError> {
        let nodal = |choices: &KernelMethodChoices| {
            choices.quadrature == Quadrature::Nodal && choices.background == Background::Imposed
        };
        Ok(Some(match self {
            Self::Kernel(choices) if nodal(choices) => {
                let kernel = KernelChoices::of_method(choices);
                Box::new(KernelScheme::new(
                    crystal,
                    CrystalQuadrature::Nodal,
                    kernel,
                )?)
            }
            Self::TotalLagrangianSph(_, choices) => {
                Box::new(TotalLagrangianSph::new(crystal, choices.clone())?)
            }
            Self::UpdatedSph(_, choices) => Box::new(updated(crystal, choices)?),
            Self::Peridynamics(_, choices) => {
                Box::new(Peridynamics::new(crystal, choices.clone())?)
            }
            Self::Kernel(_)
            | Self::FiniteElements(_)
            | Self::Conforming(..)
            | Self::MaterialPoints(..) => return Ok(None),
        }))
    }

    /// Numbers of particles in the described cell and in the primitive cell. `None` if the cell is not described by particles, or if the particles
    /// are rejected.
    pub(crate) fn sites<const D: usize>(&self) -> Option<[usize; 2]> {
        let (particles, integrates) = match self {
            Self::Kernel(particles) => (particles, true),
            Self::TotalLagrangianSph(particles, _)
            | Self::UpdatedSph(particles, _)
            | Self::Conforming(particles, _)
            | Self::Peridynamics(particles, _) => (particles, false),
            Self::FiniteElements(_) | Self::MaterialPoints(..) => return None,
        };
        let primitive = particles.cell::<D>(CellKind::Primitive, integrates).ok()?;
        Some([particles.sites(), primitive.crystal.sites().len()])
    }

    fn in_cell<const D: usize>(
        &self,
        kind: CellKind,
    ) -> Result<Box<dyn Discretization<D>>, MethodError> {
        let crystal = |particles: &KernelMethodChoices| -> Result<Crystal<D>, MethodError> {
            Ok(particles.cell(kind, false)?.crystal)
        };
        Ok(match self {
            Self::Kernel(choices) => return kernel(choices, kind),
            Self::TotalLagrangianSph(particles, choices) => Box::new(TotalLagrangianSph::new(
                crystal(particles)?,
                choices.clone(),
            )?),
            Self::UpdatedSph(particles, choices) => {
                Box::new(updated(crystal(particles)?, choices)?)
            }
            Self::FiniteElements(choices) => Box::new(FiniteElements::<D>::new(choices)?),
            Self::Conforming(particles, choices) => {
                if matches!(
                    choices.approximation,
                    Approximation::RandlesLibersky | Approximation::KrongauzBelytschko
                ) {
                    return Err(MethodError::Incompatible {
                        choice: "an approximation that corrects only gradients",
                        other: "conforming integration, which takes its gradients from functions",
                        hint: "choose \"shepard\", whose functions these approximations have, or \"mls\"",
                    });
                }
                Box::new(ConformingIntegration::new(crystal(particles)?, choices)?)
            }
            Self::Peridynamics(particles, choices) => {
                Box::new(Peridynamics::new(crystal(particles)?, choices.clone())?)
            }
            Self::MaterialPoints(_, choices) => {
                Box::new(MaterialPoints::<D>::new(choices.clone())?)
            }
        })
    }
}

/// Builds updated-Lagrangian SPH with the artificial stress of the spacing of its particles.
pub(crate) fn updated<const D: usize>(
    crystal: Crystal<D>,
    choices: &UpdatedSphChoices,
) -> Result<UpdatedSph<D>, MethodError> {
    let mut choices = choices.clone();
    if let Some(stress) = &mut choices.artificial_stress {
        stress.spacing = crystal.spacing();
    }
    UpdatedSph::new(crystal, choices)
}

/// Builds a kernel method: in closed form for one particle per cell, by differentiation of its forces for several.
fn kernel<const D: usize>(
    choices: &KernelMethodChoices,
    kind: CellKind,
) -> Result<Box<dyn Discretization<D>>, MethodError> {
    let cell = choices.cell::<D>(kind, true)?;
    if cell.crystal.sites().len() == 1 {
        return Ok(Box::new(Method::new(choices.clone())?));
    }
    let refused = |choice, hint| MethodError::Incompatible {
        choice,
        other: "several particles in a cell",
        hint,
    };
    if choices.background != Background::Imposed {
        return Err(refused("the interpolated background", "choose \"imposed\""));
    }
    if choices.frame == Frame::Eulerian && choices.linearization != Linearization::Exact {
        return Err(MethodError::NotOfForces {
            linearization: choices.linearization.name(),
        });
    }
    let MethodCell { crystal, points } = cell;
    let quadrature = match points {
        Some(points) => CrystalQuadrature::Points(points),
        None => quadrature(choices, &crystal)?,
    };
    let kernel = KernelChoices::of_method(choices);
    Ok(Box::new(KernelScheme::new(crystal, quadrature, kernel)?))
}

/// Quadrature points of a cell with several particles, unless given by a rule or a list: the particles and the centers of the Delaunay cells.
fn quadrature<const D: usize>(
    choices: &KernelMethodChoices,
    crystal: &Crystal<D>,
) -> Result<CrystalQuadrature<D>, MethodError> {
    let lattice = crystal.lattice();
    let centers = || delaunay_centers(lattice, crystal.sites());
    let places = match choices.quadrature {
        Quadrature::Nodal => return Ok(CrystalQuadrature::Nodal),
        Quadrature::StressPoints if choices.stress_point_weight.is_none() => {
            crystal.sites().iter().copied().chain(centers()?).collect()
        }
        Quadrature::StressPointsOnly => centers()?,
        Quadrature::StressPoints
        | Quadrature::NodalStabilized
        | Quadrature::Gauss
        | Quadrature::Points => {
            return Err(MethodError::Incompatible {
                choice: "this quadrature (nodal-stabilized, or a stress-point-weight)",
                other: "several particles in a cell",
                hint: "choose nodal, stress-points, stress-points-only, gauss or points",
            });
        }
    };
    let volumes = voronoi_volumes(lattice, &places)?;
    Ok(CrystalQuadrature::Points(
        places.into_iter().zip(volumes).collect(),
    ))
}
