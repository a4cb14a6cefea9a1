//! Kernel Galerkin discretizations of any crystal: shape functions of moving particles, forces integrated at quadrature points.
//!
//! On Bravais lattices these are the methods of [`crate::method`], computed differently: the derivatives of the shape functions
//! with respect to the particles, for which [`crate::bloch::dynamical_matrix`] has closed forms, follow from dual numbers here.
//!
//! With several particles per cell the homogeneous state `F X` need not be in equilibrium: if a particle is not a center of
//! symmetry, stresses may leave a force on it. The waves are linearized about `F X`, held in place by dead loads if necessary.

mod forces;
mod point;
mod shape;

use super::lagrangian::{GradientProducts, LagrangianPoint, Stressed, response, strains, stressed};
use super::layout::{Layout, assert_planar, assert_positive};
use super::{
    Assembled, Discretization, Forced, Interaction, Motion, PatchForces, PeriodicPatch,
    PointResponse, StrainOperator, linearized, lumped_masses,
};
use crate::algebra::{Each, array_of};
use crate::approximation::Approximation;
use crate::bloch::{BlochBlocks, Mass, WaveSystem};
use crate::kernel::Kernel;
use crate::kinematics::DeformationGradient;
use crate::lattice::{Cell, Crystal, Fractional, Particle, cells_between};
use crate::material::Hyperelastic;
use crate::method::{Frame, KernelMethodChoices, MethodError, SupportSize};
use crate::real::Real;
use nalgebra::SVector;
use point::SpatialPoint;
use shape::{Shape, ShapeValues};

/// Largest distance from a particle, in lattice coordinates, of points that coincide with the particle.
const PARTICLE_TOLERANCE: f64 = 1e-12;

/// Choices that define a kernel Galerkin method, except lattice and quadrature.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct KernelChoices {
    /// Reference density; mass per reference volume.
    pub density: f64,
    /// Weight function of the shape functions.
    pub kernel: Kernel,
    /// Support radius in the reference configuration; length.
    pub radius: f64,
    /// Correction of the weights. Raw weights are multiplied by the particle volumes, corrected weights are not.
    pub approximation: Approximation,
    /// Coordinates of the kernel, material or current.
    pub frame: Frame,
    /// Size of the support in a deformed state, for Eulerian kernels.
    pub support_size: SupportSize,
}

impl Default for KernelChoices {
    fn default() -> Self {
        Self {
            density: 1.0,
            kernel: Kernel::QuarticSpline,
            radius: 2.0,
            approximation: Approximation::Shepard,
            frame: Frame::Lagrangian,
            support_size: SupportSize::Fixed,
        }
    }
}

impl KernelChoices {
    pub(super) fn of_method(choices: &KernelMethodChoices) -> Self {
        Self {
            density: choices.density,
            kernel: choices.kernel,
            radius: choices.support * choices.spacing,
            approximation: choices.approximation,
            frame: choices.frame,
            support_size: choices.support_size,
        }
    }
}

/// Points at which the forces are integrated.
#[derive(Clone, Debug, PartialEq)]
pub enum CrystalQuadrature<const D: usize> {
    /// The particles, with their volumes.
    Nodal,
    /// Points of the cell, given by lattice coordinates and reference volumes (length^D). A point at the position of a particle is identified with
    /// the particle and moves with it.
    Points(Vec<(Fractional<D>, f64)>),
}

/// Kernel Galerkin method on a crystal. Every quadrature point carries the imposed `F`, and the linearization is exact.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::lattice::{LatticeKind, Crystal};
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::scheme::{Discretization, kernel::{CrystalQuadrature, KernelChoices, KernelScheme}};
/// let honeycomb = Crystal::<2>::of(LatticeKind::Honeycomb, 1.0)?;
/// let choices = KernelChoices { radius: 2.5, ..KernelChoices::default() };
/// let scheme = KernelScheme::new(honeycomb, CrystalQuadrature::Nodal, choices)?;
/// let waves = scheme.waves(&ModifiedMooneyRivlin::default(), &DeformationGradient::identity())?;
/// assert_eq!(waves.size(), 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct KernelScheme<const D: usize> {
    crystal: Crystal<D>,
    choices: KernelChoices,
    points: Vec<Point<D>>,
    neighbors: f64,
}

#[derive(Clone, Debug)]
struct Point<const D: usize> {
    place: Fractional<D>,
    volume: f64,
    is_node: bool,
}

impl<const D: usize> Point<D> {
    fn kind(&self) -> &'static str {
        if self.is_node {
            "particle"
        } else {
            "stress point"
        }
    }
}

/// Neighbors and shape functions of a quadrature point in a homogeneous state.
struct Seen<const D: usize> {
    particles: Vec<Particle<D>>,
    /// Positions relative to the quadrature point.
    positions: Vec<[f64; D]>,
    volumes: Vec<f64>,
    shape: ShapeValues<f64, D>,
}

impl<const D: usize> KernelScheme<D> {
    /// Builds the method on a crystal.
    ///
    /// # Errors
    /// [`MethodError`] if a number is not positive and finite, or if a point has too few or too many neighbors in the reference configuration.
    pub fn new(
        crystal: Crystal<D>,
        quadrature: CrystalQuadrature<D>,
        choices: KernelChoices,
    ) -> Result<Self, MethodError> {
        assert_positive(&[("density", choices.density), ("support", choices.radius)])?;
        let points = points_of(&crystal, quadrature)?;
        let mut scheme = Self {
            crystal,
            choices,
            points,
            neighbors: 0.0,
        };
        let seen = scheme.seen(&scheme.reference_layout())?;
        let total: usize = seen.iter().map(|seen| seen.particles.len()).sum();
        scheme.neighbors = total as f64 / scheme.crystal.sites().len() as f64;
        Ok(scheme)
    }

    /// Builds the method on a free block of a crystal, as [`Discretization::on_block`] does, from the quadrature points of a cell. Points beyond the
    /// outermost particles are omitted.
    ///
    /// # Errors
    /// [`MethodError`] if a point has too few neighbors in the block.
    pub(super) fn of_block(
        crystal: &Crystal<D>,
        points: impl Iterator<Item = (Fractional<D>, f64)>,
        choices: KernelChoices,
        (cells, origin): ([usize; D], &Fractional<D>),
    ) -> Result<Self, MethodError> {
        let cell = Cell::new(crystal, points.collect()).reduced(origin)?;
        let block = crystal.block(cells, origin)?;
        let end = |i: usize, worse: fn(f64, f64) -> f64| {
            let along = block.sites().iter().map(|site| site[i]);
            along.reduce(worse).unwrap_or(0.0)
        };
        let ends: [[f64; 2]; D] = array_of(|i| [end(i, f64::min), end(i, f64::max)]);
        let is_inside = |place: &Fractional<D>| {
            let mut along = ends.iter().zip(place.iter());
            along.all(|([low, high], x)| {
                (low - PARTICLE_TOLERANCE..=high + PARTICLE_TOLERANCE).contains(x)
            })
        };
        let origins = cells_between(&[0; D], &cells.each(|n| n as i32 - 1));
        let repeated = |(place, volume): (Fractional<D>, f64)| {
            let at = move |cell: &[i32; D]| {
                let place =
                    SVector::from_fn(|i, _| (place[i] + f64::from(cell[i])) / cells[i] as f64);
                (place, volume)
            };
            origins.iter().map(at).collect::<Vec<_>>()
        };
        let mut points: Vec<_> = cell.points.into_iter().flat_map(repeated).collect();
        points.retain(|(place, _)| is_inside(place));
        Self::new(block, CrystalQuadrature::Points(points), choices)
    }

    /// Choices that define the method.
    pub fn choices(&self) -> &KernelChoices {
        &self.choices
    }

    fn reference_layout(&self) -> Layout<D> {
        Layout::reference(self.choices.kernel, self.choices.radius)
    }

    fn layout(&self, f: &DeformationGradient) -> Result<Layout<D>, MethodError> {
        assert_planar::<D>(f)?;
        let KernelChoices {
            kernel,
            radius,
            frame,
            support_size,
            ..
        } = self.choices;
        match frame {
            Frame::Lagrangian => Ok(self.reference_layout()),
            Frame::Eulerian => Layout::current(kernel, radius, support_size, f),
        }
    }

    fn shape(&self, layout: &Layout<D>) -> Shape<D> {
        Shape::new(self.choices.approximation, *layout.weight())
    }

    fn seen(&self, layout: &Layout<D>) -> Result<Vec<Seen<D>>, MethodError> {
        let shape = self.shape(layout);
        let seen = self.points.iter().map(|p| self.seen_by(p, layout, &shape));
        seen.collect()
    }

    fn seen_by(
        &self,
        point: &Point<D>,
        layout: &Layout<D>,
        shape: &Shape<D>,
    ) -> Result<Seen<D>, MethodError> {
        let needed = self.choices.approximation.neighbors_needed(D);
        let particles = layout.neighbors(&self.crystal, &point.place, point.kind(), needed)?;
        let vector = |particle| layout.vector(&self.crystal, &point.place, particle);
        let positions: Vec<[f64; D]> = particles.iter().map(vector).collect();
        let volume = |particle: &Particle<D>| self.crystal.volumes()[particle.site];
        let volumes: Vec<f64> = particles
            .iter()
            .map(|particle| layout.jacobian() * volume(particle))
            .collect();
        let singular = |source| MethodError::SingularMoment {
            point: point.kind(),
            neighbors: particles.len(),
            source,
        };
        shape
            .assert_regular(&positions, point.is_node)
            .map_err(singular)?;
        let shape = shape
            .at(&positions, &volumes, point.is_node)
            .ok_or(MethodError::NotFinite)?;
        Ok(Seen {
            particles,
            positions,
            volumes,
            shape,
        })
    }

    /// Quadrature points of kernels in material coordinates.
    fn fixed(&self, layout: &Layout<D>) -> Result<Vec<LagrangianPoint<D>>, MethodError> {
        let seen = self.points.iter().zip(self.seen(layout)?);
        Ok(seen.map(Seen::fixed).collect())
    }

    /// Calls `work` with the quadrature points of a state.
    fn with_points<T>(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
        work: impl FnOnce(&[KernelPoint<'_, D>]) -> T,
    ) -> Result<T, MethodError> {
        let layout = self.layout(f)?;
        if self.choices.frame == Frame::Lagrangian {
            let points = self.fixed(&layout)?;
            let points = stressed(&points, response(material, f)?);
            let points: Vec<_> = points.into_iter().map(KernelPoint::Material).collect();
            return Ok(work(&points));
        }
        let seen = self.points.iter().zip(self.seen(&layout)?);
        let shape = self.shape(&layout);
        let response = PointResponse::new(material, f)?;
        let moving = |(point, seen): (&Point<D>, Seen<D>)| {
            KernelPoint::Spatial(SpatialPoint {
                is_node: point.is_node,
                particles: seen.particles,
                positions: seen.positions,
                volumes: seen.volumes,
                values: seen.shape.values,
                gradients: seen.shape.gradients,
                volume: point.volume,
                shape: &shape,
                response: &response,
            })
        };
        let points: Vec<_> = seen.map(moving).collect();
        Ok(work(&points))
    }
}

impl<const D: usize> Seen<D> {
    /// Converts to a quadrature point that stays with the material.
    fn fixed((point, seen): (&Point<D>, Self)) -> LagrangianPoint<D> {
        let gradients = seen.shape.gradients.into_iter().map(SVector::from);
        LagrangianPoint::new(seen.particles.into_iter().zip(gradients), point.volume)
    }
}

/// Quadrature point in a homogeneous state, for kernels in material or current coordinates.
enum KernelPoint<'a, const D: usize> {
    Material(Stressed<'a, D>),
    Spatial(SpatialPoint<'a, D>),
}

impl<const D: usize> Interaction<D> for KernelPoint<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        match self {
            Self::Material(point) => point.particles(),
            Self::Spatial(point) => point.particles(),
        }
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        match self {
            Self::Material(point) => point.forces(motion),
            Self::Spatial(point) => point.forces(motion),
        }
    }

    fn add_stiffness(&self, blocks: &mut BlochBlocks<D>) {
        match self {
            Self::Material(point) => point.add_stiffness(blocks),
            Self::Spatial(point) => point.add_stiffness(blocks),
        }
    }
}

impl<const D: usize> Discretization<D> for KernelScheme<D> {
    fn crystal(&self) -> &Crystal<D> {
        &self.crystal
    }

    fn density(&self) -> f64 {
        self.choices.density
    }

    fn waves(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
    ) -> Result<WaveSystem<D>, MethodError> {
        let mass = Mass::Lumped(lumped_masses(&self.crystal, self.choices.density));
        if self.choices.frame == Frame::Lagrangian {
            let products = GradientProducts::of(&self.fixed(&self.layout(f)?)?);
            let stiffness = products.stiffness(&response(material, f)?);
            return Forced::from(stiffness).waves(&self.crystal, mass);
        }
        self.with_points(material, f, |points| {
            linearized(&self.crystal, mass, points)
        })?
    }

    fn strain(&self) -> Result<StrainOperator<D>, MethodError> {
        Ok(strains(&self.fixed(&self.reference_layout())?))
    }

    fn with_forces(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
        patch: &PeriodicPatch<D>,
        work: &mut dyn FnMut(&dyn PatchForces<D>),
    ) -> Result<(), MethodError> {
        self.with_points(material, f, |points| work(&Assembled::new(patch, points)))
    }

    fn on_block(
        &self,
        cells: [usize; D],
        origin: &Fractional<D>,
    ) -> Result<Option<Box<dyn Discretization<D>>>, MethodError> {
        let points = self.points.iter().map(|point| (point.place, point.volume));
        let block = Self::of_block(&self.crystal, points, self.choices.clone(), (cells, origin))?;
        Ok(Some(Box::new(block)))
    }

    fn neighbors(&self) -> f64 {
        self.neighbors
    }
}

/// Quadrature points of a cell. Points that coincide with a particle are replaced by that particle.
fn points_of<const D: usize>(
    crystal: &Crystal<D>,
    quadrature: CrystalQuadrature<D>,
) -> Result<Vec<Point<D>>, MethodError> {
    let points = match quadrature {
        CrystalQuadrature::Nodal => {
            let volumes = crystal.volumes().iter().copied();
            crystal.sites().iter().copied().zip(volumes).collect()
        }
        CrystalQuadrature::Points(points) => points,
    };
    let named: Vec<_> = points.iter().map(|(_, v)| ("points.volume", *v)).collect();
    assert_positive(&named)?;
    let is_node = |place: &Fractional<D>| {
        crystal.sites().iter().any(|site| {
            let apart = place - site;
            (apart - apart.map(f64::round)).amax() < PARTICLE_TOLERANCE
        })
    };
    let point = |(place, volume)| Point {
        is_node: is_node(&place),
        place,
        volume,
    };
    Ok(points.into_iter().map(point).collect())
}
