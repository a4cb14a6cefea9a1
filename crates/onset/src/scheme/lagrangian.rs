//! Quadrature points that stay with the material, as in finite elements and total-Lagrangian nodal integration.

use super::{Interaction, Motion, PointResponse, StrainOperator};
use crate::algebra::{Each, array_of};
use crate::kinematics::DeformationGradient;
use crate::lattice::{Crystal, Particle};
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::real::Real;
use nalgebra::SVector;
use std::collections::BTreeSet;

/// Quadrature point of a total-Lagrangian discretization, with the energy `V W(F + sum_K u_K (x) b_K)`.
///
/// The fixed vectors `b_K` are the gradients of the shape functions or averages of them.
#[derive(Clone, Debug, PartialEq)]
pub struct LagrangianPoint<const D: usize> {
    particles: Vec<Particle<D>>,
    gradients: Vec<SVector<f64, D>>,
    volume: f64,
}

impl<const D: usize> LagrangianPoint<D> {
    /// Builds a point from its neighbors, each with its `b_K` (1/length), and its reference volume (length^D).
    pub fn new(
        seen: impl IntoIterator<Item = (Particle<D>, SVector<f64, D>)>,
        volume: f64,
    ) -> Self {
        let (particles, gradients) = seen.into_iter().unzip();
        Self {
            particles,
            gradients,
            volume,
        }
    }

    /// Particles whose displacements strain the point.
    pub fn particles(&self) -> &[Particle<D>] {
        &self.particles
    }

    /// Vectors `b_K` in the order of the particles; 1/length.
    pub fn gradients(&self) -> &[SVector<f64, D>] {
        &self.gradients
    }

    /// Reference volume of the point; length^D.
    pub fn volume(&self) -> f64 {
        self.volume
    }
}

/// Quadrature point with the response of its material.
pub(super) struct Stressed<'a, const D: usize> {
    point: &'a LagrangianPoint<D>,
    response: PointResponse<'a, D>,
}

impl<const D: usize> Interaction<D> for Stressed<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.point.particles
    }

    /// Returns the nodal forces `f_K = -V P(F_q) b_K`.
    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let mut f = self.response.leading::<R>();
        for (u, b) in motion.displacements.iter().zip(&self.point.gradients) {
            for i in 0..D {
                for j in 0..D {
                    f[i][j] = f[i][j] + u[i] * b[j];
                }
            }
        }
        let stress = self.response.first_piola(&f);
        let force = |b: &SVector<f64, D>| {
            array_of(|i| {
                let mut sum = R::constant(0.0);
                for j in 0..D {
                    sum = sum - stress[i][j] * (self.point.volume * b[j]);
                }
                sum
            })
        };
        self.point.gradients.iter().map(force).collect()
    }
}

/// Returns quadrature points with the response of a material in a homogeneous state.
///
/// # Errors
/// [`MethodError`] if the state does not have `D` dimensions, or if the material cannot be evaluated there.
pub(super) fn stressed<'a, const D: usize>(
    points: &'a [LagrangianPoint<D>],
    material: &'a dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<Vec<Stressed<'a, D>>, MethodError> {
    if !f.is_block_diagonal::<D>() {
        return Err(MethodError::NotPlanar { dimension: D });
    }
    let response = PointResponse::new(material, f)?;
    let with_response = |point| Stressed { point, response };
    Ok(points.iter().map(with_response).collect())
}

/// Strain operator of the quadrature points.
pub(super) fn strains<const D: usize>(points: &[LagrangianPoint<D>]) -> StrainOperator<D> {
    let mut strain = StrainOperator::new();
    for point in points {
        strain.add_strain(&point.particles, point.gradients.clone());
    }
    strain
}

/// Mean number of particles that share a point with a particle, the particle itself included.
pub(super) fn mean_neighbors<const D: usize>(
    points: &[LagrangianPoint<D>],
    crystal: &Crystal<D>,
) -> f64 {
    let mut pairs: BTreeSet<(usize, Particle<D>)> = BTreeSet::new();
    for point in points {
        for from in &point.particles {
            let back = from.cell.each(|n| -n);
            let to = point.particles.iter().map(|to| to.moved(&back));
            pairs.extend(to.map(|to| (from.site, to)));
        }
    }
    pairs.len() as f64 / crystal.sites().len() as f64
}
