//! Quadrature points that stay with the material, as in finite elements and total-Lagrangian nodal integration.

use super::{Interaction, Motion, PointResponse, StrainOperator};
use crate::algebra::{Each, array_of};
use crate::bloch::BlochBlocks;
use crate::kinematics::DeformationGradient;
use crate::lattice::{Crystal, Particle};
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::real::Real;
use nalgebra::{SMatrix, SVector};
use std::collections::BTreeSet;

/// Quadrature point of a total-Lagrangian discretization, with the deformation gradient `F_q = F + sum_K u_K (x) b_K` and the forces
/// `f_K = -V P(F_q) c_K`.
///
/// The fixed vectors `b_K` are the gradients of the shape functions or averages of them. Forces with `c_K = b_K` derive from the energy `V W(F_q)`.
#[derive(Clone, Debug, PartialEq)]
pub struct LagrangianPoint<const D: usize> {
    particles: Vec<Particle<D>>,
    gradients: Vec<SVector<f64, D>>,
    /// Vectors `c_K`, if they are not the gradients.
    along: Option<Vec<SVector<f64, D>>>,
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
            along: None,
            volume,
        }
    }

    /// Replaces the vectors `c_K` of the forces, given in the order of the particles; 1/length. The forces then do not derive from an energy.
    pub(super) fn with_forces_along(self, along: Vec<SVector<f64, D>>) -> Self {
        Self {
            along: Some(along),
            ..self
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

    /// Vectors `c_K` of the forces in the order of the particles; 1/length.
    fn along(&self) -> &[SVector<f64, D>] {
        self.along.as_deref().unwrap_or(&self.gradients)
    }

    /// Second particle of a point that exerts two forces; `None` if the forces follow the gradients.
    pub(super) fn far_end(&self) -> Option<&Particle<D>> {
        let along = self.along.as_ref()?;
        let others = self.particles.iter().zip(along).skip(1);
        let mut loaded = others.filter(|(_, along)| along.norm_squared() > 0.0);
        loaded.next().map(|(particle, _)| particle)
    }

    /// Reference volume of the point; length^D.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Change `sum_K u_K (x) b_K` of the deformation gradient by displacements.
    pub(super) fn change<R: Real>(&self, displacements: &[[R; D]]) -> [[R; D]; D] {
        let mut change = [[R::constant(0.0); D]; D];
        for (u, b) in displacements.iter().zip(&self.gradients) {
            for i in 0..D {
                for j in 0..D {
                    change[i][j] = change[i][j] + u[i] * b[j];
                }
            }
        }
        change
    }

    /// Deformation gradient `F_q` after displacements from a homogeneous state `F`.
    pub(super) fn deformed<R: Real>(
        &self,
        base: &[[f64; D]; D],
        displacements: &[[R; D]],
    ) -> [[R; D]; D] {
        let change = self.change(displacements);
        array_of(|i| array_of(|j| change[i][j] + base[i][j]))
    }
}

/// Quadrature point with the response of its material.
#[derive(Clone)]
pub(super) struct Stressed<'a, const D: usize> {
    point: &'a LagrangianPoint<D>,
    response: PointResponse<'a, D>,
}

impl<const D: usize> Stressed<'_, D> {
    /// Deformation gradient of the homogeneous state.
    pub(super) fn base(&self) -> [[f64; D]; D] {
        self.response.leading()
    }

    /// Change of the deformation gradient by displacements.
    pub(super) fn change<R: Real>(&self, displacements: &[[R; D]]) -> [[R; D]; D] {
        self.point.change(displacements)
    }
}

impl<const D: usize> Interaction<D> for Stressed<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.point.particles
    }

    /// Returns the nodal forces `f_K = -V P(F_q) c_K`.
    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let f = self.point.deformed(&self.base(), motion.displacements);
        let stress = self.response.first_piola(&f);
        let force = |c: &SVector<f64, D>| {
            array_of(|i| {
                let mut sum = R::constant(0.0);
                for j in 0..D {
                    sum = sum - stress[i][j] * (self.point.volume * c[j]);
                }
                sum
            })
        };
        self.point.along().iter().map(force).collect()
    }

    /// Adds the blocks `K_iKkL = V c_KJ A_iJkM b_LM`.
    fn add_stiffness(&self, blocks: &mut BlochBlocks<D>) {
        let tangent = self.response.base_tangent();
        let mut sums = blocks.between(&self.point.particles);
        for (from, c) in self.point.along().iter().enumerate() {
            let half: [[[f64; D]; D]; D] = array_of(|i| {
                array_of(|k| {
                    array_of(|m| {
                        let entry = |j: usize| c[j] * tangent[i][j][k][m];
                        self.point.volume * (0..D).map(entry).sum::<f64>()
                    })
                })
            });
            for (to, b) in self.point.gradients.iter().enumerate() {
                let entry = |i: usize, k: usize| (0..D).map(|m| half[i][k][m] * b[m]).sum();
                sums.add(from, to, &SMatrix::from_fn(entry));
            }
        }
        sums.finish();
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
