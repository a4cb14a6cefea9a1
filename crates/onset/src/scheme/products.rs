//! Discrete displacement gradients and small matrix products in plain or dual numbers.

use crate::algebra::array_of;
use crate::real::Real;

/// Returns the displacement gradient `sum_K u_K (x) g_K`.
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

/// Deformation gradient `(1 + h) F` of a point after a step with the spatial displacement gradient `h`.
pub(super) fn transported<R: Real, const D: usize>(
    h: &[[R; D]; D],
    f: &[[R; D]; D],
) -> [[R; D]; D] {
    array_of(|i| array_of(|j| (0..D).fold(f[i][j], |sum, m| sum + h[i][m] * f[m][j])))
}

/// Returns the product `A B^T`.
pub(super) fn times_transpose<R: Real, const D: usize>(
    a: &[[R; D]; D],
    b: &[[R; D]; D],
) -> [[R; D]; D] {
    array_of(|i| array_of(|j| (0..D).fold(R::constant(0.0), |sum, m| sum + a[i][m] * b[j][m])))
}

/// Returns the product `A v`.
#[inline(always)]
pub(super) fn times_vector<R: Real, const D: usize>(a: &[[R; D]; D], v: &[R; D]) -> [R; D] {
    let mut product = [R::constant(0.0); D];
    for i in 0..D {
        for j in 0..D {
            product[i] = product[i] + a[i][j] * v[j];
        }
    }
    product
}
