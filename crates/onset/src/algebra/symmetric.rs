//! Real symmetric matrices of a few rows: eigenvalues by Jacobi rotations, definiteness by elimination.

use crate::algebra::{Each, array_of};
use crate::real::{Real, Side};

/// Largest number of sweeps of rotations; six sweeps reach rounding accuracy.
const SWEEPS: usize = 12;

/// Eigenvalues in increasing order, and in row `n` the unit eigenvector of the `n`-th eigenvalue.
///
/// Jacobi's method: every error is of the order of rounding times the largest entry, including double eigenvalues, and the vectors are orthogonal to
/// rounding.
pub(crate) fn symmetric_eigen<const N: usize>(matrix: &[[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut a = *matrix;
    let mut vectors: [[f64; N]; N] = array_of(|i| array_of(|j| f64::from(u8::from(i == j))));
    let largest = matrix
        .as_flattened()
        .iter()
        .fold(0.0, |most: f64, x| most.max(x.abs()));
    let negligible = 0.1 * f64::EPSILON * largest;
    for _ in 0..SWEEPS {
        let mut is_diagonal = true;
        for p in 0..N {
            for q in p + 1..N {
                let off = a[p][q];
                if off.abs() <= negligible {
                    continue;
                }
                is_diagonal = false;
                rotate(&mut a, &mut vectors, p, q);
            }
        }
        if is_diagonal {
            break;
        }
    }
    let mut order: [usize; N] = array_of(|n| n);
    order.sort_by(|&m, &n| a[m][m].total_cmp(&a[n][n]));
    (order.each(|n| a[n][n]), order.each(|n| vectors[n]))
}

/// Rotation in the plane of `p` and `q` that eliminates their coupling.
fn rotate<const N: usize>(a: &mut [[f64; N]; N], vectors: &mut [[f64; N]; N], p: usize, q: usize) {
    let ratio = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    let tangent = 1.0_f64.copysign(ratio) / (ratio.abs() + (1.0 + ratio * ratio).sqrt());
    let cosine = 1.0 / (1.0 + tangent * tangent).sqrt();
    let sine = tangent * cosine;
    let off = a[p][q];
    a[p][p] -= tangent * off;
    a[q][q] += tangent * off;
    a[p][q] = 0.0;
    a[q][p] = 0.0;
    for k in (0..N).filter(|&k| k != p && k != q) {
        let (first, second) = (a[k][p], a[k][q]);
        a[k][p] = cosine * first - sine * second;
        a[k][q] = sine * first + cosine * second;
        a[p][k] = a[k][p];
        a[q][k] = a[k][q];
    }
    for k in 0..N {
        let (first, second) = (vectors[p][k], vectors[q][k]);
        vectors[p][k] = cosine * first - sine * second;
        vectors[q][k] = sine * first + cosine * second;
    }
}

/// Returns true if a symmetric matrix is positive definite: all pivots of the elimination are positive.
///
/// For intervals it returns true only if all symmetric matrices with entries in them are positive definite. Only the entries on and below the
/// diagonal are read.
pub(crate) fn is_positive_definite<R: Real, const N: usize>(matrix: &[[R; N]; N]) -> bool {
    let mut rest = *matrix;
    for k in 0..N {
        let pivot = rest[k][k];
        // The test fails for NaN.
        if pivot.side(f64::MIN_POSITIVE) != Some(Side::Above) || !pivot.value().is_finite() {
            return false;
        }
        for i in k + 1..N {
            let factor = rest[i][k] / pivot;
            for j in k + 1..=i {
                rest[i][j] = rest[i][j] - factor * rest[j][k];
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::{is_positive_definite, symmetric_eigen};

    fn matrix(seed: u64) -> [[f64; 5]; 5] {
        let mut state = seed;
        let mut random = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let mut a = [[0.0; 5]; 5];
        for i in 0..5 {
            for j in 0..=i {
                a[i][j] = random();
                a[j][i] = a[i][j];
            }
        }
        a
    }

    #[test]
    fn eigenpairs_satisfy_their_equation_even_for_double_eigenvalues() {
        for seed in 1..200 {
            let mut a = matrix(seed);
            if seed % 3 == 0 {
                // A unit matrix plus a rank-one matrix: four equal eigenvalues.
                let v = a[0];
                a = std::array::from_fn(|i| {
                    std::array::from_fn(|j| f64::from(u8::from(i == j)) + v[i] * v[j])
                });
            }
            let (values, vectors) = symmetric_eigen(&a);
            for (value, vector) in values.iter().zip(vectors) {
                for i in 0..5 {
                    let product: f64 = (0..5).map(|j| a[i][j] * vector[j]).sum();
                    assert!((product - value * vector[i]).abs() < 1e-14);
                }
            }
            assert!(values.is_sorted());
        }
    }

    #[test]
    fn a_matrix_is_positive_definite_when_its_smallest_eigenvalue_is_positive() {
        for seed in 1..200 {
            let a = matrix(seed);
            let least = symmetric_eigen(&a).0[0];
            let shifted = |shift: f64| {
                let mut b = a;
                (0..5).for_each(|i| b[i][i] -= shift);
                b
            };
            assert!(is_positive_definite(&shifted(least - 1e-12)));
            assert!(!is_positive_definite(&shifted(least + 1e-12)));
        }
        assert!(!is_positive_definite(&[[f64::NAN]]));
    }
}
