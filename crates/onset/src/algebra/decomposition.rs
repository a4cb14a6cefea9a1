//! Eigenvalues of complex matrices of any size with their eigenvectors on both sides.

use super::{Complex, MAXIMUM_ITERATIONS};
use nalgebra::{DMatrix, Schur};

/// `A = V diag(values) W` with `W V = 1`: right eigenvectors as columns of `V`, left ones as rows of `W`.
///
/// Where `A` is not diagonalizable, vectors are as long as rounding makes them.
#[derive(Clone, Debug)]
pub(crate) struct Decomposition {
    pub(crate) values: Vec<Complex>,
    pub(crate) right: DMatrix<Complex>,
    pub(crate) left: DMatrix<Complex>,
}

impl Decomposition {
    /// From the Schur form `A = Q T Q*`, whose triangular factor has eigenvectors by substitution. `None` where the iteration does
    /// not converge, which needs entries that are not finite.
    pub(crate) fn new(matrix: DMatrix<Complex>) -> Option<Self> {
        let size = matrix.nrows();
        let smallest = f64::EPSILON * matrix.norm();
        let iterations = MAXIMUM_ITERATIONS * size;
        let (q, t) = Schur::try_new(matrix, f64::EPSILON, iterations)?.unpack();
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
        let inverse = vectors.solve_upper_triangular(&DMatrix::identity(size, size))?;
        Some(Self {
            values: t.diagonal().iter().copied().collect(),
            right: &q * vectors,
            left: inverse * q.adjoint(),
        })
    }
}
