//! Points that see the deformation through fixed gradients.

use super::{Interaction, Motion, PointResponse};
use crate::lattice::Particle;
use crate::real::Real;

/// A point of a total-Lagrangian discretization: `F_q = F + sum_K u_K (x) g_K` with gradients `g_K` in the reference state, and
/// forces `f_K = -V_q P(F_q) g_K`, minus the derivatives of the energy `V_q W(F_q)`.
pub(super) struct GradientPoint<'a, const D: usize> {
    pub(super) particles: Vec<Particle<D>>,
    /// `g_K`; 1/length.
    pub(super) gradients: Vec<[f64; D]>,
    /// `V_q`; length^D.
    pub(super) volume: f64,
    pub(super) response: &'a PointResponse<'a, D>,
}

impl<const D: usize> Interaction<D> for GradientPoint<'_, D> {
    fn particles(&self) -> &[Particle<D>] {
        &self.particles
    }

    fn forces<R: Real>(&self, motion: Motion<'_, R, D>) -> Vec<[R; D]> {
        let change = displacement_gradient(motion.displacements, &self.gradients);
        let base = self.response.leading::<R>();
        let f = std::array::from_fn(|i| std::array::from_fn(|j| base[i][j] + change[i][j]));
        let stress = self.response.first_piola(&f);
        let force = |gradient: &[f64; D]| -> [R; D] {
            std::array::from_fn(|i| {
                (0..D).fold(R::constant(0.0), |sum, j| {
                    sum - stress[i][j] * (gradient[j] * self.volume)
                })
            })
        };
        self.gradients.iter().map(force).collect()
    }
}

/// `sum_K u_K (x) g_K`.
pub(super) fn displacement_gradient<R: Real, const D: usize>(
    displacements: &[[R; D]],
    gradients: &[[f64; D]],
) -> [[R; D]; D] {
    let mut sum = [[R::constant(0.0); D]; D];
    for (u, g) in displacements.iter().zip(gradients) {
        for i in 0..D {
            for j in 0..D {
                sum[i][j] = sum[i][j] + u[i] * g[j];
            }
        }
    }
    sum
}

/// `(1 + h) F`: the deformation gradient that a point carries after a step with the spatial displacement gradient `h`.
pub(super) fn transported<R: Real, const D: usize>(
    h: &[[R; D]; D],
    f: &[[R; D]; D],
) -> [[R; D]; D] {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| (0..D).fold(f[i][j], |sum, m| sum + h[i][m] * f[m][j]))
    })
}

/// `A B^T`.
pub(super) fn times_transpose<R: Real, const D: usize>(
    a: &[[R; D]; D],
    b: &[[R; D]; D],
) -> [[R; D]; D] {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| (0..D).fold(R::constant(0.0), |sum, m| sum + a[i][m] * b[j][m]))
    })
}

/// `A v`.
pub(super) fn times_vector<R: Real, const D: usize>(a: &[[R; D]; D], v: &[R; D]) -> [R; D] {
    std::array::from_fn(|i| (0..D).fold(R::constant(0.0), |sum, j| sum + a[i][j] * v[j]))
}
