//! Eigenvalues of complex matrices of any size with right and left eigenvectors.

use super::schur::{eigenvectors, schur};
use super::{Complex, MAXIMUM_ITERATIONS, Pair};
use crate::cancel::checkpoint;
use nalgebra::{ComplexField, DMatrix, DVector, Dyn, SymmetricEigen};

/// Decomposition `A = V diag(values) W` with `W V = 1`: right eigenvectors are the columns of `V`, left ones the rows of `W`.
///
/// If `A` is not diagonalizable, the length of the vectors is determined by rounding.
#[derive(Clone, Debug)]
pub(crate) struct Decomposition {
    pub(crate) values: Vec<Complex>,
    pub(crate) right: DMatrix<Complex>,
    pub(crate) left: DMatrix<Complex>,
}

impl Decomposition {
    /// Decomposes by the Schur form `A = Q T Q*`. `None` if entries are not finite.
    pub(crate) fn new(matrix: DMatrix<Complex>) -> Option<Self> {
        let size = matrix.nrows();
        let (q, t) = schur_form(&matrix)?;
        let pairs = |matrix: &DMatrix<Complex>, unit: f64| -> Vec<Pair<f64>> {
            matrix.iter().map(|z| [z.re / unit, z.im / unit]).collect()
        };
        // Squares of very large or small entries would over- or underflow.
        let unit = match t.camax() {
            0.0 => 1.0,
            largest => largest,
        };
        let smallest = f64::EPSILON * (&matrix / Complex::from(unit)).norm();
        let (t_over_unit, q) = (pairs(&t, unit), pairs(&q, 1.0));
        let [right, left] = eigenvectors(size, &t_over_unit, &q, smallest).map(|own| {
            let entries = own.into_iter().map(|[re, im]| Complex::new(re, im));
            DMatrix::from_row_iterator(size, size, entries)
        });
        Some(Self {
            values: t.diagonal().iter().copied().collect(),
            right,
            left,
        })
    }

    /// Decomposes a Hermitian matrix, whose eigenvalues are real and whose left and right eigenvectors agree.
    pub(crate) fn of_hermitian(matrix: DMatrix<Complex>) -> Option<Self> {
        let eigen = hermitian_eigen(matrix)?;
        let values = eigen.eigenvalues.iter();
        Some(Self {
            values: values.map(|value| Complex::new(*value, 0.0)).collect(),
            left: eigen.eigenvectors.adjoint(),
            right: eigen.eigenvectors,
        })
    }

    /// Product of the norms of the matrices of left and right eigenvectors.
    pub(crate) fn condition(&self) -> f64 {
        self.left.norm() * self.right.norm()
    }
}

/// Eigenvalues of any matrix; `None` if entries are not finite.
pub(crate) fn any_eigenvalues(matrix: &DMatrix<Complex>) -> Option<Vec<Complex>> {
    checkpoint();
    let size = matrix.nrows();
    let mut own = finite(matrix.clone())?;
    if schur(size, own.as_mut_slice(), &mut []) {
        return Some(own.diagonal().iter().copied().collect());
    }
    let (_, t) = schur_form(matrix)?;
    Some(t.diagonal().iter().copied().collect())
}

/// Schur form `A = Q T Q*` with a triangular `T`.
///
/// The iteration may stall if a step leaves the matrix unchanged by symmetry; the matrix is then reflected by a vector without symmetry.
fn schur_form(matrix: &DMatrix<Complex>) -> Option<(DMatrix<Complex>, DMatrix<Complex>)> {
    checkpoint();
    let size = matrix.nrows();
    let form = |mut matrix: DMatrix<Complex>| {
        let mut q = DMatrix::zeros(size, size);
        schur(size, matrix.as_mut_slice(), q.as_mut_slice()).then_some((q, matrix))
    };
    let matrix = finite(matrix.clone())?;
    form(matrix.clone()).or_else(|| {
        let mirror = reflection(size);
        let (q, t) = form(&mirror * &matrix * &mirror)?;
        Some((mirror * q, t))
    })
}

/// Reflection `1 - 2 w w*`, which is an involution, with a unit vector whose components have equal magnitude and irregular phases.
fn reflection(size: usize) -> DMatrix<Complex> {
    let length = (size as f64).recip().sqrt();
    let w = DVector::from_fn(size, |n, _| Complex::from_polar(length, (n * n) as f64));
    DMatrix::identity(size, size) - &w * w.adjoint() * Complex::from(2.0)
}

/// Eigenvalues and eigenvectors of a Hermitian matrix of any size, from its lower triangle. `None` if entries are not finite; otherwise the iteration
/// terminates after a few steps per row.
pub(crate) fn hermitian_eigen<T: ComplexField<RealField = f64>>(
    matrix: DMatrix<T>,
) -> Option<SymmetricEigen<T, Dyn>> {
    checkpoint();
    let iterations = MAXIMUM_ITERATIONS * matrix.nrows();
    finite(matrix)?.try_symmetric_eigen(f64::EPSILON, iterations)
}

/// Eigenvalues of a Hermitian matrix; NaN if entries are not finite.
pub(crate) fn hermitian_eigenvalues(matrix: DMatrix<Complex>) -> Vec<Complex> {
    checkpoint();
    let size = matrix.nrows();
    let values = finite(matrix).map(|matrix| matrix.symmetric_eigenvalues());
    let values = values.unwrap_or_else(|| DVector::repeat(size, f64::NAN));
    values
        .iter()
        .map(|value| Complex::new(*value, 0.0))
        .collect()
}

/// Returns the matrix if all entries are finite.
fn finite<T: ComplexField<RealField = f64>>(matrix: DMatrix<T>) -> Option<DMatrix<T>> {
    let is_finite = matrix.iter().all(|entry| entry.is_finite());
    is_finite.then_some(matrix)
}

#[cfg(test)]
mod tests {
    use super::Decomposition;
    use crate::algebra::{Complex, uniform};
    use nalgebra::DMatrix;

    fn random(size: usize) -> DMatrix<Complex> {
        let mut random = 5;
        let mut number = || 2.0 * uniform(&mut random) - 1.0;
        DMatrix::from_fn(size, size, |_, _| Complex::new(number(), number()))
    }

    fn assert_decomposed(matrix: &DMatrix<Complex>, all: &Decomposition) {
        let size = matrix.nrows();
        let diagonal = &all.left * matrix * &all.right;
        for i in 0..size {
            for j in 0..size {
                let expected = if i == j {
                    all.values[i]
                } else {
                    Complex::default()
                };
                assert!((diagonal[(i, j)] - expected).norm() < 1e-12);
            }
        }
        let product = &all.left * &all.right;
        assert!((product - DMatrix::identity(size, size)).norm() < 1e-11);
    }

    #[test]
    fn a_reflection_is_an_involution() {
        let mirror = super::reflection(18);
        assert!((&mirror * &mirror - DMatrix::identity(18, 18)).norm() < 1e-14);
        assert!((&mirror - mirror.adjoint()).norm() < 1e-14);
    }

    #[test]
    fn a_matrix_is_diagonal_between_its_left_and_right_eigenvectors() {
        // Large matrices take more steps than small ones.
        [7, 120]
            .into_iter()
            .map(random)
            .for_each(assert_is_decomposed);
    }

    fn assert_is_decomposed(matrix: DMatrix<Complex>) {
        let all = Decomposition::new(matrix.clone()).expect("finite");
        assert_decomposed(&matrix, &all);
        let hermitian = &matrix + matrix.adjoint();
        let all = Decomposition::of_hermitian(hermitian.clone()).expect("finite");
        assert_decomposed(&hermitian, &all);
        assert!(all.values.iter().all(|value| value.im == 0.0));
    }
}
