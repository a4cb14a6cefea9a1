//! Kernel methods with one particle per cell: lattice, kernel, approximation, quadrature and frame.
//!
//! For a homogeneous deformation a method determines its quadrature points, their neighbors and shape functions, and the deformation gradient of each
//! point. It is independent of the material.

mod configuration;
mod mesh_error;

pub(crate) use configuration::support;
pub use configuration::{Configuration, ConfiguredPoint};
pub use mesh_error::MeshError;

use crate::approximation::{Approximation, Order, SingularMoment};
use crate::kernel::Kernel;
use crate::kinematics::{DeformationGradient, KinematicsError};
use crate::lattice::{
    Ball, BravaisLattice, Cell, Crystal, Fractional, LatticeError, LatticeKind, Reduced, WaveGrids,
    cells_between,
};
use crate::material::MaterialError;
use crate::quadrature::{CellRule, Quadrature, QuadratureError, QuadraturePoint};
use crate::real::plain;
use nalgebra::SVector;
use std::sync::Arc;
use thiserror::Error;

/// Largest admissible number of neighbors of a quadrature point. The cost grows with the square of this number, and common methods have far fewer
/// neighbors.
pub const MAXIMUM_NEIGHBORS: usize = 400;
/// Largest admissible number of particles in a cell; beyond it the matrices of one wave would fill the memory.
const MAXIMUM_PARTICLES: f64 = 1e3;
/// Admissible spacings. Their powers in volumes and in second derivatives of weights neither overflow nor underflow.
const SPACINGS: std::ops::RangeInclusive<f64> = 1e-30..=1e30;
/// Largest admissible lattice coordinate.
const COORDINATES: f64 = 1e6;
/// Largest number of lattice sites that may be examined for each admissible neighbor.
const MAX_SITES_PER_NEIGHBOR: f64 = 25.0;
/// Largest sum of gradients, times the support radius, that is zero to rounding.
const TRANSLATION: f64 = 1e-9;

/// Coordinates of the kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Frame {
    /// Kernels in material coordinates, `W(X - X_I)`: neighbors never change.
    Lagrangian,
    /// Kernels in current coordinates, `W(x - x_I(t))`, as in smoothed particle hydrodynamics.
    Eulerian,
}

/// Deformation gradient of the quadrature points in the homogeneous state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Background {
    /// The imposed `F` at every point, as in the paper.
    Imposed,
    /// Interpolation of the displacements of the particles by the shape functions. The reference configuration stays free of stress.
    ///
    /// Lagrangian kernels: `F_q = 1 + (F - 1) M_q`, `M_q = sum_K X_K (x) grad phi_K(X_q)`. Eulerian kernels: `F_q^-1 = 1 - (1 - F^-1) m_q`
    /// with the same sum `m_q` in the current lattice. `X_K` is measured from the point; the origin does not matter if the gradients add up to zero.
    Interpolated,
}

/// Positions of the particles in the homogeneous state, for Eulerian kernels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum CurrentLattice {
    /// Deformed positions `F X` of the particles.
    Convected,
    /// Reference positions, with the stress of `F` (the paper's "letting the current configuration be the reference configuration").
    Regular,
}

/// Size of the support in the homogeneous state, for Eulerian kernels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum SupportSize {
    /// Constant radius `R0` in the current configuration, independent of the deformation.
    Fixed,
    /// Radius `R0 J^(1/D)`, with a constant mean number of neighbors.
    Scaled,
    /// Reference sphere convected with the particles to an ellipsoid, `|F^-1 x| < R0`. Equal to `Fixed` on the regular lattice, where the particles
    /// have not moved.
    Convected,
}

/// Linearization of the forces in perturbations of the particles, for Eulerian kernels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Linearization {
    /// Exact derivative of the discrete forces. Stress points move with the interpolated displacement, and all particles change the normalization.
    Exact,
    /// Equation (49): `d(phi_I,j)(x_q) = phi_I,jt (u_q - u_I)`. It omits the motion of the other particles in the normalization.
    /// A stress point moves with the plane wave itself, which makes the dynamical matrix non-periodic.
    Paper,
    /// Like `Exact`, with stress points that move with the plane wave.
    ExactPlaneWave,
    /// Like `Paper`, with stress points that move with the interpolated displacement.
    PaperInterpolated,
    /// Like `Paper`, with the second derivative of the weight alone and its normalization held fixed.
    FrozenNormalization,
}

impl Linearization {
    /// Name in study files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Paper => "paper",
            Self::ExactPlaneWave => "exact-plane-wave",
            Self::PaperInterpolated => "paper-interpolated",
            Self::FrozenNormalization => "frozen-normalization",
        }
    }

    /// Returns true if a stress point moves with the plane wave instead of the interpolated displacement.
    pub fn moves_points_with_plane_wave(self) -> bool {
        matches!(
            self,
            Self::Paper | Self::ExactPlaneWave | Self::FrozenNormalization
        )
    }

    /// Returns true if the motion of all particles is included in the normalization.
    pub fn is_exact_in_kernel(self) -> bool {
        matches!(self, Self::Exact | Self::ExactPlaneWave)
    }
}

/// Choices that define a kernel method. The default is the paper's Lagrangian method with stress points on the hexagonal lattice, `D_mx = 2`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct KernelMethodChoices {
    /// Lattice of the particles.
    pub lattice: LatticeKind,
    /// Rectangular lattice: ratio of the second to the first side.
    pub aspect: f64,
    /// Oblique and triclinic lattices: components of the primitive vectors in units of the spacing, one vector after the other.
    pub vectors: Vec<f64>,
    /// Lattice coordinates of the particles of a cell other than the particle at the origin, particle by particle. They replace the basis of the lattice.
    pub basis: Vec<f64>,
    /// Number of cells along each primitive vector that form a supercell, whose particles can differ.
    pub cells: u32,
    /// Largest random offset of a particle along each axis, in units of the spacing.
    pub perturbation: f64,
    /// Seed of the random offsets, which are reproducible on every machine.
    pub seed: u32,
    /// Distance of nearest neighbors; length. It is the first side of rectangular lattices and the unit of `vectors` of oblique and triclinic
    /// lattices.
    pub spacing: f64,
    /// Reference density; mass per reference volume.
    pub density: f64,
    /// Weight function of the particles.
    pub kernel: Kernel,
    /// Support radius in units of the spacing, `D_mx = R0 / spacing`.
    pub support: f64,
    /// Correction of the weights.
    pub approximation: Approximation,
    /// Type of quadrature points.
    pub quadrature: Quadrature,
    /// Stress points: fraction of the cell's volume at the stress points, in place of Voronoi volumes; `None` for Voronoi volumes.
    pub stress_point_weight: Option<f64>,
    /// Gauss quadrature: points per direction.
    pub gauss_points: u32,
    /// User-defined points: for each point, its lattice coordinates and its fraction of the cell's volume.
    pub points: Vec<f64>,
    /// Coordinates of the kernel.
    pub frame: Frame,
    /// Deformation gradient of the quadrature points.
    pub background: Background,
    /// Eulerian kernels: positions of the particles.
    pub current_lattice: CurrentLattice,
    /// Eulerian kernels: size of the support.
    pub support_size: SupportSize,
    /// Eulerian kernels: linearization of the forces.
    pub linearization: Linearization,
}

impl Default for KernelMethodChoices {
    fn default() -> Self {
        Self {
            lattice: LatticeKind::Hexagonal,
            aspect: 1.0,
            vectors: Vec::new(),
            basis: Vec::new(),
            cells: 1,
            perturbation: 0.0,
            seed: 1,
            spacing: 1.0,
            density: 1.0,
            kernel: Kernel::QuarticSpline,
            support: 2.0,
            approximation: Approximation::Shepard,
            quadrature: Quadrature::StressPoints,
            stress_point_weight: None,
            gauss_points: 2,
            points: Vec::new(),
            frame: Frame::Lagrangian,
            background: Background::Imposed,
            current_lattice: CurrentLattice::Convected,
            support_size: SupportSize::Fixed,
            linearization: Linearization::Exact,
        }
    }
}

/// Error in the setup of a method or in its evaluation in a state.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum MethodError {
    /// A setting is outside its admissible range.
    #[error("discretization.{name} is {}; expected {expected}", plain(*value))]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// Value of the setting.
        value: f64,
        /// Description of the admissible values.
        expected: &'static str,
    },
    /// Two choices are incompatible.
    #[error("{choice} is not supported with {other}; {hint}")]
    Incompatible {
        /// One of the two choices.
        choice: &'static str,
        /// The choice that it conflicts with.
        other: &'static str,
        /// Alternatives to the two choices.
        hint: &'static str,
    },
    /// A quadrature point has too few neighbors to determine a gradient.
    #[error(
        "a {point} has {neighbors} particle(s) within the support radius {} (in units of length); \
         its shape functions in {dimension}D need at least {needed}",
        length(*radius)
    )]
    SupportTooSmall {
        /// Kind of point, `particle` or `stress point`.
        point: &'static str,
        /// Support radius of the kernel; length.
        radius: f64,
        /// Number of neighbors of the point.
        neighbors: usize,
        /// Number of neighbors needed.
        needed: usize,
        /// Number of space dimensions.
        dimension: usize,
    },
    /// The support holds more particles than admissible.
    #[error(
        "the support radius {} holds about {neighbors:.1e} particles; at most {limit} are allowed",
        length(*radius)
    )]
    SupportTooLarge {
        /// Support radius of the kernel; length.
        radius: f64,
        /// Estimated number of particles in the support.
        neighbors: f64,
        /// Largest admissible number of particles.
        limit: usize,
    },
    /// The bonds of a particle do not determine a deformation gradient.
    #[error(
        "a particle has {bonds} bond(s) within the horizon {} (in units of length); \
         its shape tensor in {dimension}D needs at least {dimension} that are linearly independent",
        length(*horizon)
    )]
    HorizonTooSmall {
        /// Horizon of the family; length.
        horizon: f64,
        /// Number of bonds of the particle.
        bonds: usize,
        /// Number of space dimensions.
        dimension: usize,
    },
    /// The horizon holds more particles than admissible.
    #[error(
        "the horizon {} holds about {bonds:.1e} particles; at most {limit} are allowed",
        length(*horizon)
    )]
    HorizonTooLarge {
        /// Horizon of the family; length.
        horizon: f64,
        /// Estimated number of particles in the horizon.
        bonds: f64,
        /// Largest admissible number of particles.
        limit: usize,
    },
    /// The neighbors of a quadrature point do not span space.
    #[error(
        "the {neighbors} neighbors of a {point} do not determine its shape functions: {source}"
    )]
    SingularMoment {
        /// Kind of point, `particle` or `stress point`.
        point: &'static str,
        /// Number of neighbors of the point.
        neighbors: usize,
        /// Condition of the moment matrix.
        source: SingularMoment,
    },
    /// The deformation couples the directions of the discretization to the remaining directions.
    #[error(
        "the deformation gradient couples the {dimension} dimension(s) of the lattice to the others; \
         expected plane strain (2D) or uniaxial strain (1D)"
    )]
    NotPlanar {
        /// Number of space dimensions.
        dimension: usize,
    },
    /// The interpolated homogeneous state is not an admissible deformation gradient.
    #[error("the interpolated deformation gradient is not admissible: {0}")]
    Background(#[source] KinematicsError),
    /// The deformation gradient is not admissible.
    #[error(transparent)]
    Deformation(#[from] KinematicsError),
    /// The cell holds several particles where one is expected.
    #[error(
        "the cell holds {particles} particles; kernel methods in closed form need exactly one; use \
         `scheme::kernel::KernelScheme` for several"
    )]
    SeveralParticles {
        /// Number of particles in the cell.
        particles: usize,
    },
    /// The equations of a linearization are not derivatives of forces.
    #[error(
        "the linearization `{linearization}` is not the derivative of the forces of particles: it omits part of their motion, or moves \
         stress points with the plane wave itself; choose discretization.linearization = \"exact\""
    )]
    NotOfForces {
        /// Name of the linearization.
        linearization: &'static str,
    },
    /// The consistent mass vanishes for some waves, which have no equation of motion.
    #[error(
        "the consistent mass matrix is singular: the wave with the phases {phases:?} from node to node vanishes at all points of \
         the quadrature\n  hint: choose discretization.grid-mass = \"lumped\", or more points in a cell"
    )]
    SingularMass {
        /// Phases of the wave along the axes, in units of pi.
        phases: Vec<u8>,
    },
    /// The dynamical matrix overflows or underflows.
    #[error("the dynamical matrix is not finite at this state")]
    NotFinite,
    /// The mesh of the elements is not valid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Natural stabilization expands the strain in material coordinates and needs Lagrangian kernels.
    #[error(
        "discretization.quadrature \"nodal-stabilized\" expands the strain over the reference cells of the particles and \
         needs discretization.frame = \"lagrangian\""
    )]
    StabilizedEulerian,
    /// The quadrature points are not admissible.
    #[error(transparent)]
    Quadrature(#[from] QuadratureError),
    /// The lattice is not admissible.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// The material cannot be evaluated.
    #[error(transparent)]
    Material(#[from] MaterialError),
}

/// Length without the rounding errors of the particle spacing.
fn length(value: f64) -> String {
    let rounded = format!("{value:.12e}").parse().unwrap_or(value);
    plain(rounded)
}

impl MethodError {
    /// Checks that a number is positive and finite.
    pub(crate) fn positive(name: &'static str, value: f64) -> Result<(), Self> {
        let is_admitted = value > 0.0 && value.is_finite();
        Self::require(is_admitted, name, value, "a positive finite number")
    }

    /// Checks that a number is zero, or positive and finite.
    pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<(), Self> {
        let is_admitted = value >= 0.0 && value.is_finite();
        let expected = "zero or a positive finite number";
        Self::require(is_admitted, name, value, expected)
    }

    /// Checks a condition on a setting.
    pub(crate) fn require(
        is_admitted: bool,
        name: &'static str,
        value: f64,
        expected: &'static str,
    ) -> Result<(), Self> {
        let refused = Self::Setting {
            name,
            value,
            expected,
        };
        is_admitted.then_some(()).ok_or(refused)
    }

    /// Rejects a support with too many particles, before memory is allocated for it.
    pub(crate) fn assert_few<const D: usize>(
        ball: &Ball<D>,
        radius: f64,
        sites: usize,
    ) -> Result<(), Self> {
        let sites = sites as f64;
        let limit = MAXIMUM_NEIGHBORS;
        let (neighbors, places) = (sites * ball.mean_count(), sites * ball.places());
        // The ball of a thin cell can cover many sites although it holds few particles.
        if neighbors <= limit as f64 && places <= MAX_SITES_PER_NEIGHBOR * limit as f64 {
            return Ok(());
        }
        Err(Self::SupportTooLarge {
            radius,
            neighbors: neighbors.max(places / MAX_SITES_PER_NEIGHBOR).min(f64::MAX),
            limit,
        })
    }

    /// Rejects a support that holds far more particles than expected from its volume, as across thin cells.
    pub(crate) fn assert_not_crowded(neighbors: usize, radius: f64) -> Result<(), Self> {
        if neighbors <= 2 * MAXIMUM_NEIGHBORS {
            return Ok(());
        }
        Err(Self::SupportTooLarge {
            radius,
            neighbors: neighbors as f64,
            limit: MAXIMUM_NEIGHBORS,
        })
    }

    /// Returns true if the support or the horizon holds too few or too many particles, so that the discretization does not exist in the state.
    pub fn is_about_support(&self) -> bool {
        matches!(
            self,
            Self::SupportTooSmall { .. }
                | Self::SupportTooLarge { .. }
                | Self::HorizonTooSmall { .. }
                | Self::HorizonTooLarge { .. }
                | Self::SingularMoment { .. }
                | Self::Lattice(LatticeError::Sheared { .. })
        )
    }

    /// Returns true if the law of the material is not defined in the state, as beyond the locking stretch of its chains, or has no stress there, as
    /// at a kink.
    pub fn is_outside_domain(&self) -> bool {
        matches!(self, Self::Material(error) if error.leaves_undefined())
    }

    /// Returns true if the state has no result although other states have, because of the support or the law.
    pub fn leaves_undefined(&self) -> bool {
        self.is_about_support() || self.is_outside_domain()
    }
}

impl KernelMethodChoices {
    /// Bravais lattice in the basis used for computations, with this basis. Given primitive vectors are reduced to the shortest vectors, so that
    /// results do not depend on the basis in which the lattice is given.
    fn lattice<const D: usize>(&self) -> Result<(BravaisLattice<D>, Reduced<D>), MethodError> {
        let given = self
            .lattice
            .lattice_with(self.spacing, self.aspect, &self.vectors)?;
        let reduced = match self.lattice.takes_vectors() {
            true => Reduced::unique(given.vectors())?,
            false => Reduced::canonical(given.vectors())?,
        };
        if reduced.is_given() {
            return Ok((given, reduced));
        }
        let short =
            BravaisLattice::new(reduced.vectors).ok_or_else(|| LatticeError::Dependent {
                vectors: self.vectors.clone(),
            })?;
        Ok((short, reduced))
    }

    /// Returns the rule for quadrature points in a cell of the basis used for computations.
    ///
    /// # Errors
    /// [`MethodError`] if the lattice does not exist.
    pub fn cell_rule<const D: usize>(&self) -> Result<CellRule, MethodError> {
        let (_, basis) = self.lattice::<D>()?;
        assert_near("points", &self.points)?;
        let mut points = self.points.clone();
        if !basis.is_given() && points.len().is_multiple_of(D + 1) {
            for point in points.chunks_exact_mut(D + 1) {
                let place = basis.inverse * SVector::<f64, D>::from_column_slice(&point[..D]);
                point[..D].copy_from_slice(place.as_slice());
            }
        }
        Ok(CellRule {
            stress_point_weight: self.stress_point_weight,
            gauss_points: self.gauss_points,
            points,
        })
    }

    /// Returns the described particles in the reference configuration: the lattice with its basis, supercells and offsets. Cells have the shortest
    /// primitive vectors, independent of the given vectors.
    ///
    /// # Errors
    /// [`MethodError`] if a number is out of range, or if particles coincide.
    pub fn crystal<const D: usize>(&self) -> Result<Crystal<D>, MethodError> {
        let crystal = self.regular_crystal::<D>()?;
        let crystal = match self.cells {
            0 | 1 => crystal,
            cells => crystal.supercell([cells as usize; D])?,
        };
        if self.perturbation == 0.0 {
            return Ok(crystal);
        }
        // With a single particle in a cell there is no relative displacement.
        MethodError::require(
            crystal.sites().len() > 1,
            "perturbation",
            self.perturbation,
            "0 with one particle in a cell: set discretization.cells to 2 or more",
        )?;
        Ok(crystal.perturbed(self.perturbation * self.spacing, u64::from(self.seed))?)
    }

    /// Returns the cell used for computations: the described cell, or the primitive cell of its particles and quadrature points. A perturbed lattice
    /// has no smaller cell.
    ///
    /// `integrates` states whether the method uses the quadrature of the choices.
    ///
    /// # Errors
    /// The errors of [`KernelMethodChoices::crystal`], and [`MethodError`] if the quadrature is rejected.
    pub(crate) fn cell<const D: usize>(
        &self,
        kind: CellKind,
        integrates: bool,
    ) -> Result<MethodCell<D>, MethodError> {
        let is_listed = matches!(self.quadrature, Quadrature::Gauss | Quadrature::Points);
        let regular = self.regular_crystal::<D>()?;
        let listed = match integrates && is_listed {
            true => Some(self.listed_points(regular.lattice())?),
            false => None,
        };
        if kind == CellKind::Primitive && self.perturbation == 0.0 {
            let cell = Cell::new(&regular, listed.clone().unwrap_or_default()).primitive();
            let smaller = cell.and_then(|cell| Some((cell.crystal()?, cell.points)));
            return Ok(match smaller {
                Some((crystal, points)) => MethodCell {
                    crystal: crystal.with_spacing(regular.spacing()),
                    points: listed.map(|_| points),
                },
                None => MethodCell {
                    crystal: regular,
                    points: listed,
                },
            });
        }
        let count = f64::from(self.cells.max(1));
        let cells = cells_between(&[0; D], &[self.cells.max(1) as i32 - 1; D]);
        let repeated = |points: Vec<(Fractional<D>, f64)>| {
            let of_cell = |cell: [i32; D]| {
                let cell = SVector::from(cell.map(f64::from));
                let points = points.iter();
                let moved = points.map(|(place, volume)| ((place + cell) / count, *volume));
                moved.collect::<Vec<_>>()
            };
            cells.iter().copied().flat_map(of_cell).collect()
        };
        Ok(MethodCell {
            crystal: self.crystal()?,
            points: listed.map(repeated),
        })
    }

    /// Quadrature points of a rule or list in one described cell.
    fn listed_points<const D: usize>(
        &self,
        lattice: &BravaisLattice<D>,
    ) -> Result<Vec<(Fractional<D>, f64)>, MethodError> {
        let points = self.quadrature.points(lattice, &self.cell_rule::<D>()?)?;
        Ok(points
            .into_iter()
            .map(|own| (own.place, own.volume))
            .collect())
    }

    /// Number of particles in the described cell.
    pub(crate) fn sites(&self) -> usize {
        let dimension = self.lattice.dimension();
        let of_lattice = match self.basis.len() / dimension {
            0 => self.lattice.sites::<3>().len(),
            others => 1 + others,
        };
        of_lattice * (self.cells.max(1) as usize).pow(dimension as u32)
    }

    /// Particles of one described cell without offsets.
    fn regular_crystal<const D: usize>(&self) -> Result<Crystal<D>, MethodError> {
        MethodError::positive("spacing", self.spacing)?;
        MethodError::require(
            SPACINGS.contains(&self.spacing),
            "spacing",
            self.spacing,
            "a number from 1e-30 to 1e30: choose another unit of length",
        )?;
        let (lattice, basis) = self.lattice::<D>()?;
        if !self.basis.len().is_multiple_of(D) {
            return Err(MethodError::Setting {
                name: "basis",
                value: self.basis.len() as f64,
                expected: "a list whose length is a multiple of the number of dimensions",
            });
        }
        assert_near("basis", &self.basis)?;
        let own = self.basis.chunks_exact(D).map(SVector::from_column_slice);
        let own = own.map(|place| basis.inverse * place);
        let others = (!self.basis.is_empty())
            .then(|| std::iter::once(SVector::zeros()).chain(own).collect());
        let crystal = Crystal::arranged(self.lattice, lattice, others)?;
        let particles = crystal.sites().len() as f64 * f64::from(self.cells).powi(D as i32);
        MethodError::require(
            particles <= MAXIMUM_PARTICLES,
            "cells",
            f64::from(self.cells),
            "a number of cells that gives at most 1000 particles",
        )?;
        if !(0.0..=0.5).contains(&self.perturbation) {
            return Err(MethodError::Setting {
                name: "perturbation",
                value: self.perturbation,
                expected: "a number from 0 to 0.5, in units of the spacing",
            });
        }
        Ok(crystal)
    }
}

/// Cell used for computations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CellKind {
    /// The primitive cell, which is the smallest.
    Primitive,
    /// The cell described by the choices.
    Described,
}

/// Particles of a cell, with its quadrature points if they are given by a rule or a list.
#[derive(Clone, Debug)]
pub(crate) struct MethodCell<const D: usize> {
    pub(crate) crystal: Crystal<D>,
    /// Positions and volumes of the quadrature points.
    pub(crate) points: Option<Vec<(Fractional<D>, f64)>>,
}

/// Kernel method on its lattice, ready to be evaluated in any state.
#[derive(Clone, Debug)]
pub struct Method<const D: usize> {
    choices: KernelMethodChoices,
    crystal: Crystal<D>,
    points: Vec<QuadraturePoint<D>>,
    /// One of each pair of points that inversion exchanges, with the volume of both points; `None` unless every point has an opposite.
    halves: Option<Vec<QuadraturePoint<D>>>,
    wave_grids: Arc<WaveGrids<D>>,
}

impl<const D: usize> Method<D> {
    /// Builds the method on its lattice.
    ///
    /// # Errors
    /// [`MethodError`] if a setting is out of range, or if `D` is not the dimension of the lattice.
    pub fn new(choices: KernelMethodChoices) -> Result<Self, MethodError> {
        let KernelMethodChoices {
            spacing,
            density,
            support,
            quadrature,
            frame,
            ..
        } = choices;
        for (name, value) in [
            ("spacing", spacing),
            ("density", density),
            ("support", support),
        ] {
            MethodError::positive(name, value)?;
        }
        if quadrature == Quadrature::NodalStabilized && frame == Frame::Eulerian {
            return Err(MethodError::StabilizedEulerian);
        }
        let cell = choices.cell::<D>(CellKind::Primitive, true)?;
        if cell.crystal.sites().len() > 1 {
            return Err(MethodError::SeveralParticles {
                particles: cell.crystal.sites().len(),
            });
        }
        let lattice = *cell.crystal.lattice();
        let points = match cell.points {
            Some(points) => {
                let point = |(place, volume)| QuadraturePoint::new(place, volume);
                points.into_iter().map(point).collect()
            }
            None => quadrature.points(&lattice, &choices.cell_rule::<D>()?)?,
        };
        let method = Self {
            choices,
            crystal: Crystal::of_lattice(lattice),
            halves: halves_of(&points),
            points,
            wave_grids: Arc::new(WaveGrids::new(lattice)),
        };
        method.assert_background()?;
        Ok(method)
    }

    /// Rejects an interpolated background if a translation of all particles strains a point, `sum_K grad phi_K != 0`.
    ///
    /// The strain of such a point under the displacements `(F - 1) X` depends on its distance from the origin, so that no homogeneous state exists.
    /// This occurs with raw weights at points that no symmetry of the reference lattice fixes.
    fn assert_background(&self) -> Result<(), MethodError> {
        let KernelMethodChoices {
            background,
            approximation,
            ..
        } = self.choices;
        if background == Background::Imposed || approximation != Approximation::Raw {
            return Ok(());
        }
        let reference = self.configuration(&DeformationGradient::identity(), Order::First);
        // A support that is too small or too large is rejected later, when a state is evaluated.
        let points = reference.map_or_else(|_| Vec::new(), |reference| reference.points);
        let strained = points.iter().any(|point| {
            let sum: SVector<f64, D> = point.shape.gradients.iter().sum();
            sum.norm() * self.support_radius() > TRANSLATION
        });
        if strained {
            return Err(MethodError::Incompatible {
                choice: "the interpolated background",
                other: "raw weights at points where a translation of all particles causes a strain",
                hint: "choose discretization.background = \"imposed\", an approximation that is exact for constants, or the quadrature \
                       nodal or stress-points",
            });
        }
        Ok(())
    }

    /// Replaces `discretization.quadrature` by user-defined quadrature points. Their volumes are used without changes.
    pub fn with_quadrature_points(mut self, points: Vec<QuadraturePoint<D>>) -> Self {
        self.halves = halves_of(&points);
        self.points = points;
        self
    }

    /// Choices that define the method.
    pub fn choices(&self) -> &KernelMethodChoices {
        &self.choices
    }

    /// Particles in the reference configuration.
    pub fn crystal(&self) -> &Crystal<D> {
        &self.crystal
    }

    /// Quadrature points of a cell.
    pub(crate) fn points(&self) -> &[QuadraturePoint<D>] {
        &self.points
    }

    /// Reference lattice of the particles.
    pub fn lattice(&self) -> &BravaisLattice<D> {
        self.crystal.lattice()
    }

    /// Quadrature points of one cell.
    pub fn quadrature_points(&self) -> &[QuadraturePoint<D>] {
        &self.points
    }

    /// Returns true if strain is expanded over the cell of some quadrature point, which needs second derivatives.
    pub fn is_naturally_stabilized(&self) -> bool {
        self.points
            .iter()
            .any(|point| point.second_moments.is_some())
    }

    /// Wave vectors of the reference lattice, shared by all states.
    pub fn wave_grids(&self) -> &Arc<WaveGrids<D>> {
        &self.wave_grids
    }

    /// Support radius in the reference configuration, `R0 = D_mx spacing`; length.
    pub fn support_radius(&self) -> f64 {
        self.choices.support * self.choices.spacing
    }

    /// Mass of a particle, `m = rho0 V0` (not `rho0 V_q`).
    pub fn particle_mass(&self) -> f64 {
        self.choices.density * self.lattice().cell_volume()
    }

    /// Returns true if the dynamical matrix is periodic in the wave vector. The exceptions are methods with stress points that move with the plane wave itself.
    pub fn is_periodic(&self) -> bool {
        let KernelMethodChoices {
            frame,
            linearization,
            ..
        } = self.choices;
        frame == Frame::Lagrangian
            || self.points.iter().all(|point| point.is_node)
            || !linearization.moves_points_with_plane_wave()
    }

    /// Linear map from the reference lattice to the lattice whose Brillouin zone is searched: `F` for Eulerian kernels on the convected lattice,
    /// otherwise the identity.
    pub fn home_map(&self, f: &DeformationGradient) -> nalgebra::SMatrix<f64, D, D> {
        let KernelMethodChoices {
            frame,
            current_lattice: lattice,
            ..
        } = self.choices;
        match (frame, lattice) {
            (Frame::Eulerian, CurrentLattice::Convected) => f.leading(),
            _ => nalgebra::SMatrix::identity(),
        }
    }
}

/// Rejects lattice coordinates with too few digits after the decimal point. Coordinates are periodic with period one.
fn assert_near(name: &'static str, coordinates: &[f64]) -> Result<(), MethodError> {
    coordinates.iter().try_for_each(|value| {
        MethodError::require(
            value.abs() <= COORDINATES,
            name,
            *value,
            "lattice coordinates from -1e6 to 1e6; equivalent positions in other cells differ by whole numbers",
        )
    })
}

/// One of each pair of points that inversion exchanges, with the volume of both points.
fn halves_of<const D: usize>(points: &[QuadraturePoint<D>]) -> Option<Vec<QuadraturePoint<D>>> {
    let is_lattice_vector = |x: SVector<f64, D>| (x - x.map(f64::round)).amax() < 1e-12;
    let are_opposite = |a: &QuadraturePoint<D>, b: &QuadraturePoint<D>| {
        let is_alike = a.is_node == b.is_node
            && (a.volume - b.volume).abs() <= 1e-14 * a.volume.abs()
            && a.second_moments == b.second_moments;
        is_alike && is_lattice_vector(a.place + b.place)
    };
    let mut halves: Vec<QuadraturePoint<D>> = Vec::new();
    let mut taken = vec![false; points.len()];
    for n in 0..points.len() {
        if taken[n] {
            continue;
        }
        let opposite =
            (n..points.len()).find(|m| !taken[*m] && are_opposite(&points[n], &points[*m]))?;
        taken[n] = true;
        taken[opposite] = true;
        let multiplicity = if opposite == n { 1.0 } else { 2.0 };
        halves.push(QuadraturePoint {
            volume: multiplicity * points[n].volume,
            second_moments: points[n]
                .second_moments
                .map(|moments| moments * multiplicity),
            ..points[n]
        });
    }
    Some(halves)
}
