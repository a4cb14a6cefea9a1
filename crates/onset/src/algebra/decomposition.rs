//! Eigenvalues of complex matrices of any size with right and left eigenvectors.

use super::schur::schur;
use super::{Complex, MAXIMUM_ITERATIONS};
use crate::cancel::checkpoint;
use nalgebra::{ComplexField, DMatrix, DVector, Dyn, RowDVector, SymmetricEigen};

/// Decomposition `A = V diag(values) W` with `W V = 1`: right eigenvectors are columns of `V = Q X`, left ones rows of `W = X^-1 Q*`.
///
/// If `A` is not diagonalizable, the length of the vectors is determined by rounding.
#[derive(Clone, Debug)]
pub(crate) struct Decomposition {
    pub(crate) values: Vec<Complex>,
    /// Unitary factor of the Schur form.
    q: DMatrix<Complex>,
    /// Eigenvectors of the triangular Schur factor, a triangular matrix; `None` if `Q` contains the eigenvectors of `A`.
    x: Option<DMatrix<Complex>>,
}

impl Decomposition {
    /// Decomposes by the Schur form `A = Q T Q*`, whose triangular factor has eigenvectors by substitution. `None` if entries are not finite.
    pub(crate) fn new(matrix: DMatrix<Complex>) -> Option<Self> {
        let size = matrix.nrows();
        let smallest = f64::EPSILON * matrix.norm();
        let (q, t) = schur_form(&matrix)?;
        let mut vectors = DMatrix::<Complex>::identity(size, size);
        for j in 0..size {
            for i in (0..j).rev() {
                let sum: Complex = (i + 1..=j).map(|l| t[(i, l)] * vectors[(l, j)]).sum();
                let difference = t[(i, i)] - t[(j, j)];
                let apart = difference.norm() > smallest;
                let difference = if apart {
                    difference
                } else {
                    Complex::new(smallest, 0.0)
                };
                vectors[(i, j)] = -sum / difference;
            }
        }
        Some(Self {
            values: t.diagonal().iter().copied().collect(),
            q,
            x: Some(vectors),
        })
    }

    /// Decomposes a Hermitian matrix, whose eigenvalues are real and whose left and right eigenvectors agree.
    pub(crate) fn of_hermitian(matrix: DMatrix<Complex>) -> Option<Self> {
        let eigen = hermitian_eigen(matrix)?;
        let values = eigen.eigenvalues.iter();
        Some(Self {
            values: values.map(|value| Complex::new(*value, 0.0)).collect(),
            q: eigen.eigenvectors,
            x: None,
        })
    }

    /// Right eigenvector, a column of `V`.
    pub(crate) fn right(&self, number: usize) -> DVector<Complex> {
        match &self.x {
            Some(x) => &self.q * x.column(number),
            None => self.q.column(number).into_owned(),
        }
    }

    /// Left eigenvector, a row of `W`.
    pub(crate) fn left(&self, number: usize) -> RowDVector<Complex> {
        match &self.x {
            // The row e of X^-1 satisfies e X = unit row.
            Some(x) => {
                let mut unit = DVector::zeros(self.values.len());
                unit[number] = Complex::new(1.0, 0.0);
                let row = x.tr_solve_upper_triangular(&unit).unwrap_or(unit);
                row.transpose() * self.q.adjoint()
            }
            None => self.q.column(number).adjoint(),
        }
    }

    /// Product `r V` with the right eigenvectors.
    pub(crate) fn onto_right(&self, row: &RowDVector<Complex>) -> RowDVector<Complex> {
        let own = row * &self.q;
        match &self.x {
            Some(x) => own * x,
            None => own,
        }
    }

    /// Product `W c` with the left eigenvectors.
    pub(crate) fn onto_left(&self, column: &DVector<Complex>) -> DVector<Complex> {
        let own = self.q.ad_mul(column);
        match &self.x {
            Some(x) => x.solve_upper_triangular(&own).unwrap_or(own),
            None => own,
        }
    }

    /// Matrices `V` and `W` of all right and left eigenvectors.
    pub(crate) fn vectors(&self) -> [DMatrix<Complex>; 2] {
        let adjoint = self.q.adjoint();
        match &self.x {
            Some(x) => {
                let left = x.solve_upper_triangular(&adjoint).unwrap_or(adjoint);
                [&self.q * x, left]
            }
            None => [self.q.clone(), adjoint],
        }
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
        let [right, left] = all.vectors();
        let diagonal = &left * matrix * &right;
        for i in 0..size {
            for j in 0..size {
                let expected = if i == j {
                    all.values[i]
                } else {
                    Complex::default()
                };
                assert!((diagonal[(i, j)] - expected).norm() < 1e-12);
            }
            assert!((all.right(i) - right.column(i)).norm() < 1e-12);
            assert!((all.left(i) - left.row(i)).norm() < 1e-12);
            let row = matrix.row(i).into_owned();
            assert!((all.onto_right(&row) - row * &right).norm() < 1e-12);
            let column = matrix.column(i).into_owned();
            assert!((all.onto_left(&column) - &left * column).norm() < 1e-12);
        }
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
