//! Cholesky factor of Hermitian matrices.

use super::Complex;
use nalgebra::DMatrix;

/// Overwrites the lower triangle of a Hermitian matrix `L L*` with its Cholesky factor `L`. Returns true if the matrix is positive definite.
///
/// Only the lower triangle is read. nalgebra rejects negative pivots of real matrices only; for complex matrices it takes the imaginary root.
pub(crate) fn factorize(matrix: &mut DMatrix<Complex>) -> bool {
    let size = matrix.nrows();
    for j in 0..size {
        let mut pivot = matrix[(j, j)].re;
        for k in 0..j {
            pivot -= matrix[(j, k)].norm_sqr();
        }
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        let root = pivot.sqrt();
        matrix[(j, j)] = Complex::new(root, 0.0);
        for i in j + 1..size {
            let mut entry = matrix[(i, j)];
            for k in 0..j {
                entry -= matrix[(i, k)] * matrix[(j, k)].conj();
            }
            matrix[(i, j)] = entry / root;
        }
    }
    true
}

/// Cholesky factor `L` of a positive definite matrix `L L*`; `None` otherwise.
pub(crate) fn cholesky_factor(mut matrix: DMatrix<Complex>) -> Option<DMatrix<Complex>> {
    factorize(&mut matrix).then(|| matrix.lower_triangle())
}

#[cfg(test)]
mod tests {
    use super::cholesky_factor;
    use crate::algebra::{Complex, uniform};
    use nalgebra::DMatrix;

    #[test]
    fn positive_definite_matrices_have_a_cholesky_factor() {
        let mut state = 5;
        let mut number = || 2.0 * uniform(&mut state) - 1.0;
        let random = DMatrix::from_fn(5, 5, |_, _| Complex::new(number(), number()));
        let gram = random.ad_mul(&random);
        let lower = cholesky_factor(gram.clone()).expect("a positive definite matrix");
        assert!((&lower * lower.adjoint() - &gram).norm() < 1e-14 * gram.norm());
        let shifted = |by: f64| &gram - DMatrix::identity(5, 5) * Complex::from(by);
        let least = gram.symmetric_eigenvalues().min();
        assert!(cholesky_factor(shifted(least * (1.0 - 1e-9))).is_some());
        assert!(cholesky_factor(shifted(least * (1.0 + 1e-9))).is_none());
        for entry in [-1.0, 0.0, f64::NAN] {
            let single = DMatrix::from_element(1, 1, Complex::from(entry));
            assert!(cholesky_factor(single).is_none(), "{entry}");
        }
    }
}
