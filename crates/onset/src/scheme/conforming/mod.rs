//! Stabilized conforming nodal integration and related methods: nodal integration with gradients averaged over a region around each node.
//!
//! By the divergence theorem the mean gradient of a shape function depends only on its values at the boundary, `b_K = (1/V_I) int phi_K n dS`.
//! With linearly complete shape functions and regions that fill space (Voronoi cells) linear fields are integrated exactly: `sum_K X_K (x) b_K = 1`
//! at each node, and `sum_I V_I b_K = 0` for each particle.
//! Source: Chen, Wu, Yoon, You, Int. J. Numer. Meth. Engng. 50 (2001) 435.

mod region;

use super::lagrangian::{
    GradientProducts, LagrangianPoint, mean_neighbors, response, strains, stressed,
};
use super::{
    Assembled, Discretization, Forced, PatchForces, PeriodicPatch, StrainOperator, lumped_masses,
};
use crate::approximation::{Approximation, Order};
use crate::bloch::{Mass, WaveSystem};
use crate::kernel::Kernel;
use crate::kinematics::DeformationGradient;
use crate::lattice::{Crystal, Fractional, Particle};
use crate::material::Hyperelastic;
use crate::method::{MAXIMUM_NEIGHBORS, MethodError};
use nalgebra::{SMatrix, SVector};
use region::Region;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;

/// Admissible number of Gauss points along an edge. With more points results no longer change.
const BOUNDARY_POINTS: RangeInclusive<usize> = 1..=16;

/// Region over which the gradients at a node are averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum SmoothingDomain {
    /// The Voronoi cells: stabilized conforming nodal integration (SCNI).
    Voronoi,
    /// Boxes along the axes with the volumes of the Voronoi cells: stabilized non-conforming nodal integration (SNNI; Guan et al. 2009).
    /// The boxes overlap and leave gaps unless the particles form a square or cubic lattice. On irregular lattices the homogeneous state is then not
    /// in equilibrium.
    Boxes,
}

/// Choices that define conforming nodal integration on a crystal; by default SCNI with moving least squares.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(rename_all = "kebab-case", default, deny_unknown_fields)
)]
pub struct ConformingChoices {
    /// Reference density; mass per reference volume.
    pub density: f64,
    /// Weight function of the shape functions.
    pub kernel: Kernel,
    /// Support radius in the reference configuration; length.
    pub radius: f64,
    /// Correction of the weights. Raw weights are multiplied by the particle volumes, corrected weights are not.
    /// Approximations that correct only gradients contribute only their functions, which are Shepard's.
    pub approximation: Approximation,
    /// Region over which gradients are averaged.
    pub domain: SmoothingDomain,
    /// Gauss points along each edge of a region; in 3D, along both directions of each triangle of a face.
    pub boundary_points: usize,
    /// Coefficient `c` of the modification of Puso, Chen, Zywicz and Elmer, Int. J. Numer. Meth. Engng. 74 (2008) 416, from 0 (none) to 1.
    /// The energy of a node is `(1 - c) V W(F_I) + c sum_s V_s W(F_s)`, with the sum over the pyramids between the node and the faces of its region.
    /// For a material with a constant tangent `A` this is the published term `c/2 sum_s V_s (F_s - F_I) : A : (F_s - F_I)`, because the mean of the
    /// `F_s` is `F_I`.
    pub modification: f64,
}

impl Default for ConformingChoices {
    fn default() -> Self {
        Self {
            density: 1.0,
            kernel: Kernel::QuarticSpline,
            radius: 2.0,
            approximation: Approximation::Mls,
            domain: SmoothingDomain::Voronoi,
            boundary_points: 2,
            modification: 0.0,
        }
    }
}

/// Discretization by nodal integration with smoothed gradients; total Lagrangian, with the masses `rho V_I`.
///
/// ```
/// use nalgebra::Vector1;
/// use onset::kinematics::DeformationGradient;
/// use onset::lattice::{LatticeKind, Crystal};
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::scheme::Discretization;
/// use onset::scheme::conforming::{ConformingChoices, ConformingIntegration};
/// let chain = Crystal::of_lattice(LatticeKind::Chain.lattice::<1>(1.0)?);
/// let scheme = ConformingIntegration::new(chain, &ConformingChoices::default())?;
/// let waves = scheme.waves(&ModifiedMooneyRivlin::default(), &DeformationGradient::identity())?;
/// // The shortest wave of the chain is the same on both sides of each node: no mean gradient, no stiffness.
/// assert!(waves.omega_squared(&Vector1::new(std::f64::consts::PI))[0].norm() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ConformingIntegration<const D: usize> {
    crystal: Crystal<D>,
    choices: ConformingChoices,
    /// Region around each particle of the cell.
    regions: Vec<Region<D>>,
    points: Vec<LagrangianPoint<D>>,
    products: GradientProducts<D>,
}

impl<const D: usize> ConformingIntegration<D> {
    /// Builds the method on a crystal.
    ///
    /// # Errors
    /// [`MethodError`] if a number is out of its range, or if the support is too small or too large.
    pub fn new(crystal: Crystal<D>, choices: &ConformingChoices) -> Result<Self, MethodError> {
        MethodError::positive("density", choices.density)?;
        MethodError::positive("support", choices.radius)?;
        let c = choices.modification;
        MethodError::require(
            (0.0..=1.0).contains(&c),
            "modification",
            c,
            "a number from 0 to 1",
        )?;
        let count = choices.boundary_points;
        MethodError::require(
            BOUNDARY_POINTS.contains(&count),
            "boundary-points",
            count as f64,
            "a whole number from 1 to 16",
        )?;
        let volumes = crystal.volumes().iter().enumerate();
        let regions = volumes.map(|(site, volume)| match choices.domain {
            SmoothingDomain::Voronoi => Region::voronoi(&crystal, site),
            SmoothingDomain::Boxes => Region::cube(*volume),
        });
        let regions = regions.collect();
        Self::over(regions, crystal, choices)
    }

    /// Builds the method with given regions, in the order of the sites; a crystal of several cells repeats them.
    fn over(
        regions: Vec<Region<D>>,
        crystal: Crystal<D>,
        choices: &ConformingChoices,
    ) -> Result<Self, MethodError> {
        let c = choices.modification;
        let functions = Functions::new(&crystal, choices)?;
        let mut points = Vec::new();
        for site in 0..crystal.sites().len() {
            let region = &regions[site % regions.len()];
            if c < 1.0 {
                points.push(functions.smoothed(site, region, 1.0 - c)?);
            }
            if c > 0.0 {
                for pyramid in region.pyramids() {
                    points.push(functions.smoothed(site, &pyramid, c)?);
                }
            }
        }
        Ok(Self {
            crystal,
            choices: choices.clone(),
            regions,
            products: GradientProducts::of(&points),
            points,
        })
    }

    /// Integration points of a cell. For each particle they are the node with the mean gradients of its region, unless the modification is 1, and the
    /// pyramids, unless it is 0.
    pub fn points(&self) -> &[LagrangianPoint<D>] {
        &self.points
    }
}

impl<const D: usize> Discretization<D> for ConformingIntegration<D> {
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
        let stiffness = self.products.stiffness(&response(material, f)?);
        Forced::from(stiffness).waves(&self.crystal, mass)
    }

    fn strain(&self) -> Result<StrainOperator<D>, MethodError> {
        Ok(strains(&self.points))
    }

    fn with_forces(
        &self,
        material: &dyn Hyperelastic,
        f: &DeformationGradient,
        patch: &PeriodicPatch<D>,
        work: &mut dyn FnMut(&dyn PatchForces<D>),
    ) -> Result<(), MethodError> {
        let points = stressed(&self.points, response(material, f)?);
        work(&Assembled::new(patch, &points));
        Ok(())
    }

    fn on_block(
        &self,
        cells: [usize; D],
        origin: &Fractional<D>,
    ) -> Result<Option<Box<dyn Discretization<D>>>, MethodError> {
        // Regions at the faces of a block equal those inside the lattice.
        let block = self.crystal.block(cells, origin)?;
        let block = Self::over(self.regions.clone(), block, &self.choices)?;
        Ok(Some(Box::new(block)))
    }

    /// Mean number of particles that share an integration point with a particle.
    fn neighbors(&self) -> f64 {
        mean_neighbors(&self.points, &self.crystal)
    }
}

struct Functions<'a, const D: usize> {
    crystal: &'a Crystal<D>,
    choices: &'a ConformingChoices,
    /// The approximation without corrections of its gradients.
    functions: Approximation,
    /// Maps a vector to lattice coordinates.
    to_fractional: SMatrix<f64, D, D>,
    /// Reciprocal of the integral of the kernel; 1/length^D.
    normalization: f64,
}

impl<'a, const D: usize> Functions<'a, D> {
    fn new(crystal: &'a Crystal<D>, choices: &'a ConformingChoices) -> Result<Self, MethodError> {
        let radius = choices.radius;
        let volume = crystal.lattice().cell_volume() / crystal.sites().len() as f64;
        let ball = [2.0, PI, 4.0 / 3.0 * PI][D - 1] * radius.powi(D as i32);
        let neighbors = ball / volume;
        if neighbors > MAXIMUM_NEIGHBORS as f64 {
            return Err(MethodError::SupportTooLarge {
                radius,
                neighbors,
                limit: MAXIMUM_NEIGHBORS,
            });
        }
        Ok(Self {
            crystal,
            choices,
            functions: match choices.approximation {
                Approximation::RandlesLibersky | Approximation::KrongauzBelytschko => {
                    Approximation::Shepard
                }
                other => other,
            },
            to_fractional: crystal.lattice().reciprocal().transpose() / TAU,
            normalization: choices.kernel.integral::<D>(radius).recip(),
        })
    }

    /// Integration point with the mean gradients over a region around a node and a part of the node's volume.
    fn smoothed(
        &self,
        site: usize,
        region: &Region<D>,
        part: f64,
    ) -> Result<LagrangianPoint<D>, MethodError> {
        let mut means: BTreeMap<Particle<D>, SVector<f64, D>> = BTreeMap::new();
        for facet in &region.facets {
            for (point, weight) in facet.points(self.choices.boundary_points) {
                let place = self.crystal.sites()[site] + self.to_fractional * point;
                for (particle, value) in self.at(&place)? {
                    let flux = facet.normal * (value * weight / region.volume);
                    *means.entry(particle).or_insert_with(SVector::zeros) += flux;
                }
            }
        }
        Ok(LagrangianPoint::new(means, part * region.volume))
    }

    /// Shape functions at a point in lattice coordinates: each particle `K` with `phi_K`.
    fn at(&self, place: &SVector<f64, D>) -> Result<Vec<(Particle<D>, f64)>, MethodError> {
        const POINT: &str = "point of a cell's boundary";
        let (one, radius) = (SMatrix::identity(), self.choices.radius);
        let approximation = self.functions;
        let (mut seen, mut positions, mut weights) = (Vec::new(), Vec::new(), Vec::new());
        let ball = self.crystal.ball(radius, &one)?;
        MethodError::assert_few(&ball, radius, self.crystal.sites().len())?;
        for particle in self.crystal.within_ball(place, radius, &one, &ball) {
            let apart = self.crystal.place(&particle) - place;
            let position = self.crystal.lattice().vectors() * apart;
            if let Some(weight) = self.choices.kernel.weight(&position, radius, &one) {
                seen.push(particle);
                positions.push(position);
                weights.push(weight);
            }
        }
        // Constants need one neighbor, polynomials one for each coefficient.
        let needed = match approximation.degree() {
            None | Some(0) => 1,
            _ => approximation.neighbors_needed(D),
        };
        if seen.len() < needed {
            return Err(MethodError::SupportTooSmall {
                point: POINT,
                radius,
                neighbors: seen.len(),
                needed,
                dimension: D,
            });
        }
        let functions = approximation.shape_functions(
            &positions,
            &weights,
            self.normalization,
            radius,
            Order::First,
        );
        let functions = functions.map_err(|source| MethodError::SingularMoment {
            point: POINT,
            neighbors: seen.len(),
            source,
        })?;
        let volume = |particle: &Particle<D>| match approximation {
            Approximation::Raw => self.crystal.volumes()[particle.site],
            _ => 1.0,
        };
        let values = seen.into_iter().zip(functions.values);
        Ok(values
            .map(|(particle, value)| (particle, value * volume(&particle)))
            .collect())
    }
}
