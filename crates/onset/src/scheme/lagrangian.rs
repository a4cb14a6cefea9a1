//! Quadrature points that stay with the material, as in finite elements and total-Lagrangian nodal integration.

use super::{Interaction, Motion, PointResponse, StrainOperator};
use crate::algebra::{Each, array_of};
use crate::bloch::BlochBlocks;
use crate::cancel::checkpoint;
use crate::kinematics::DeformationGradient;
use crate::lattice::{Crystal, Particle};
use crate::material::Hyperelastic;
use crate::method::MethodError;
use crate::real::Real;
use nalgebra::{SMatrix, SVector};
use std::collections::{BTreeMap, BTreeSet};

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
}

/// Sums `sum_q V_q c_K (x) b_L` over quadrature points for all pairs of particles: the stiffness of a homogeneous state without its tangent. They depend on
/// the points alone and serve all states.
#[derive(Clone, Debug)]
pub(super) struct GradientProducts<const D: usize>(BlochBlocks<D>);

impl<const D: usize> GradientProducts<D> {
    /// Sums over the points of a cell; length^(D-2).
    pub(super) fn of(points: &[LagrangianPoint<D>]) -> Self {
        let mut products = BlochBlocks::new();
        for point in points {
            checkpoint();
            let mut sums = products.between(&point.particles);
            for (from, c) in point.along().iter().enumerate() {
                let weighted = c * point.volume;
                for (to, b) in point.gradients.iter().enumerate() {
                    sums.add(from, to, &(weighted * b.transpose()));
                }
            }
            sums.finish();
        }
        Self(products)
    }

    /// Stiffness `K_iKkL = A_iJkM sum_q V_q c_KJ b_LM` of a material in a homogeneous state.
    pub(super) fn stiffness(&self, response: &PointResponse<'_, D>) -> BlochBlocks<D> {
        let tangent = response.base_tangent();
        self.0.each(|product| {
            SMatrix::from_fn(|i, k| {
                let mut sum = 0.0;
                for j in 0..D {
                    for m in 0..D {
                        sum += tangent[i][j][k][m] * product[(j, m)];
                    }
                }
                sum
            })
        })
    }
}

/// Adds the gradients of a bond between two particles, each given with the point that has its deformation gradient, times a factor.
///
/// The deformation gradient of the bond is the mean of its ends, made exact along the bond: `F_IJ = F + (y - F X) (x) X / |X|^2`, `F = (F_I + F_J) / 2`
/// (Breitzman and Dayal 2018).
pub(super) fn add_gradients_of_bond<const D: usize>(
    ends: [(&Particle<D>, &LagrangianPoint<D>); 2],
    vector: &SVector<f64, D>,
    factor: f64,
    seen: &mut BTreeMap<Particle<D>, SVector<f64, D>>,
) {
    let along = vector / vector.norm_squared();
    let across = (SMatrix::identity() - vector * along.transpose()) * (0.5 * factor);
    for ((end, point), sign) in ends.into_iter().zip([-factor, factor]) {
        for (particle, gradient) in point.particles.iter().zip(&point.gradients) {
            let own = seen.entry(particle.moved(&end.cell));
            *own.or_insert_with(SVector::zeros) += across * gradient;
        }
        *seen.entry(*end).or_insert_with(SVector::zeros) += along * sign;
    }
}

/// Returns the response of a material in a homogeneous state.
///
/// # Errors
/// [`MethodError`] if the state does not have `D` dimensions, or if the material cannot be evaluated there.
pub(super) fn response<'a, const D: usize>(
    material: &'a dyn Hyperelastic,
    f: &DeformationGradient,
) -> Result<PointResponse<'a, D>, MethodError> {
    match f.is_block_diagonal::<D>() {
        true => Ok(PointResponse::new(material, f)?),
        false => Err(MethodError::NotPlanar { dimension: D }),
    }
}

/// Returns quadrature points with the response of a material in a homogeneous state.
pub(super) fn stressed<'a, const D: usize>(
    points: &'a [LagrangianPoint<D>],
    response: PointResponse<'a, D>,
) -> Vec<Stressed<'a, D>> {
    let with_response = |point| Stressed { point, response };
    points.iter().map(with_response).collect()
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
