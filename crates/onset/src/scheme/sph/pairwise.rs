//! Shear forces between pairs of particles, without zero-energy modes (Wu, Tang, Zhu and Hu 2023).

use super::super::moduli::Moduli;
use super::super::response::{determinant, inverse};
use super::super::{Interaction, LagrangianPoint, Motion, PointResponse};
use super::neighborhood::Neighborhood;
use crate::algebra::array_of;
use crate::lattice::Particle;
use crate::real::Real;
use nalgebra::SVector;

/// Particle of total-Lagrangian SPH whose shear acts along the current vectors to its neighbors.
///
/// The stress `P` of the law has the part `zeta mu a F`, with `a = J^(-2/D)` and the shear modulus `mu` of the reference state. Its divergence is computed as a
/// Laplacian of the positions over pairs. The remaining part `S = P - mu a (F + (zeta - 1) tr(F F^T)/D F^-T)` acts along uncorrected gradients.
/// For neo-Hookean laws `S` is the published stress.
#[derive(Clone)]
pub(super) struct PairwiseShear<'a, const D: usize> {
    point: &'a LagrangianPoint<D>,
    response: PointResponse<'a, D>,
    /// Uncorrected gradients of the remaining stress.
    along: &'a [SVector<f64, D>],
    /// Vectors `F X_IJ` to the neighbors in the homogeneous state; length.
    vectors: Vec<[f64; D]>,
    /// Factors `-V_J dW/dr / r` of the pair forces, the particle itself included with zero; 1/length^2.
    weights: Vec<f64>,
    shear: f64,
    coefficient: f64,
}

impl<'a, const D: usize> PairwiseShear<'a, D> {
    pub(super) fn new(
        point: &'a LagrangianPoint<D>,
        along: &'a [SVector<f64, D>],
        neighborhood: &Neighborhood<D>,
        response: PointResponse<'a, D>,
        moduli: Moduli,
        coefficient: f64,
    ) -> Self {
        let f = response.leading::<f64>();
        let current = |x: &[f64; D]| array_of(|i| (0..D).map(|j| f[i][j] * x[j]).sum());
        let weights = neighborhood.vectors.iter().zip(along).enumerate();
        let weight = |(number, (x, along)): (usize, (&[f64; D], &SVector<f64, D>))| match number {
            0 => 0.0,
            // The gradient along the vector is V_J dW/dr x/r with the opposite sign.
            _ => along.dot(&SVector::from(*x)) / SVector::from(*x).norm_squared(),
        };
        Self {
            vectors: neighborhood.vectors.iter().map(current).collect(),
            weights: weights.map(weight).collect(),
            point,
            response,
            along,
            shear: moduli.shear,
            coefficient,
        }
    }
}

impl<const D: usize> Interaction<D> for PairwiseShear<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        self.point.particles()
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let base = self.response.leading();
        let f = self.point.deformed(&base, motion.displacements);
        let scale = determinant(&f).powf(-2.0 / D as f64) * self.shear;
        let mut squares = R::constant(0.0);
        for entry in f.iter().flatten() {
            squares = squares + *entry * *entry;
        }
        let spherical = scale * squares * ((self.coefficient - 1.0) / D as f64);
        let (stress, inverse) = (self.response.first_piola(&f), inverse(&f));
        let remaining: [[R; D]; D] =
            array_of(|i| array_of(|j| stress[i][j] - scale * f[i][j] - spherical * inverse[j][i]));
        let own = motion.displacements[0];
        let mut forces = vec![[R::constant(0.0); D]; self.vectors.len()];
        for (number, along) in self.along.iter().enumerate() {
            let u = motion.displacements[number];
            let pair = scale * (self.coefficient * self.weights[number] * self.point.volume());
            let pull: [R; D] = array_of(|i| (u[i] - own[i] + self.vectors[number][i]) * pair);
            let stressed: [R; D] = array_of(|i| {
                (0..D).fold(R::constant(0.0), |sum, j| {
                    sum + remaining[i][j] * (along[j] * self.point.volume())
                })
            });
            forces[number] = array_of(|i| forces[number][i] - stressed[i] - pull[i]);
            forces[0] = array_of(|i| forces[0][i] + pull[i]);
        }
        forces
    }
}
