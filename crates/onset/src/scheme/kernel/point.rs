//! Quadrature points of methods with kernels in current coordinates.

use super::super::products::{displacement_gradient, times_transpose, times_vector, transported};
use super::super::{Interaction, Motion, PointResponse};
use super::shape::Shape;
use crate::algebra::{Each, array_of};
use crate::lattice::Particle;
use crate::real::Real;

/// Quadrature point that moves relative to its neighbors, with the forces `f_K = -V_q P(F_q) F_q^T grad phi_K(x_q)`.
///
/// The forces are the Cauchy stress times the current volume.
///
/// `F_q = (1 + sum_K u_K (x) grad phi_K^0) F` is one step of `Fdot = L F` from the homogeneous state. The gradients `grad phi_K` are evaluated for
/// the displaced particles at the displaced point.
pub(super) struct SpatialPoint<'a, const D: usize> {
    pub(super) particles: Vec<Particle<D>>,
    /// Positions relative to the point in the homogeneous state; length.
    pub(super) positions: Vec<[f64; D]>,
    /// Volumes of the particles in the homogeneous state; length^D.
    pub(super) volumes: Vec<f64>,
    /// Whether the point coincides with the first particle. If not, it moves with the interpolated displacement.
    pub(super) is_node: bool,
    /// Shape functions `phi_K^0` in the homogeneous state.
    pub(super) values: Vec<f64>,
    /// Gradients `grad phi_K^0` in the homogeneous state; 1/length.
    pub(super) gradients: Vec<[f64; D]>,
    /// Reference volume `V_q`; length^D.
    pub(super) volume: f64,
    pub(super) shape: &'a Shape<D>,
    pub(super) response: &'a PointResponse<'a, D>,
}

impl<const D: usize> SpatialPoint<'_, D> {
    /// Displacement of the point.
    fn shift<R: Real>(&self, displacements: &[[R; D]]) -> [R; D] {
        if self.is_node {
            return displacements[0];
        }
        let both = displacements.iter().zip(&self.values);
        both.fold([R::constant(0.0); D], |sum, (u, value)| {
            array_of(|i| sum[i] + u[i] * *value)
        })
    }
}

impl<const D: usize> Interaction<D> for SpatialPoint<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.particles
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let shift = self.shift(motion.displacements);
        let both = self.positions.iter().zip(motion.displacements);
        let positions: Vec<[R; D]> = both
            .map(|(x, u)| array_of(|i| u[i] - shift[i] + x[i]))
            .collect();
        let Some(shape) = self.shape.at(&positions, &self.volumes, self.is_node) else {
            return vec![[R::constant(f64::NAN); D]; self.particles.len()];
        };
        let step = displacement_gradient(motion.displacements, &self.gradients);
        let f = transported(&step, &self.response.leading());
        let stress = times_transpose(&self.response.first_piola(&f), &f);
        let force = |gradient: &[R; D]| {
            times_vector(&stress, gradient).each(|component| component * -self.volume)
        };
        shape.gradients.iter().map(force).collect()
    }
}
