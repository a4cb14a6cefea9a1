//! The tangent as a quadratic form of rates of the deformation gradient.

use crate::algebra::array_of;
use crate::material::FourthOrder;
use nalgebra::{DMatrix, Matrix3, SMatrix, SVector, SymmetricEigen};

/// `X : A : Y` for rates `X`, `Y`; the symmetric part of `A` as a matrix of nine rows.
#[derive(Clone, Debug)]
pub(super) struct QuadraticForm(SMatrix<f64, 9, 9>);

impl QuadraticForm {
    pub(super) fn of(tangent: &FourthOrder) -> Self {
        Self(SMatrix::from_fn(|a, b| {
            let (i, j, k, l) = (a / 3, a % 3, b / 3, b % 3);
            0.5 * (tangent[(i, j, k, l)] + tangent[(k, l, i, j)])
        }))
    }

    /// The largest component.
    pub(super) fn magnitude(&self) -> f64 {
        self.0.amax()
    }

    /// `X : A : Y`.
    pub(super) fn at(&self, x: &Matrix3<f64>, y: &Matrix3<f64>) -> f64 {
        vector(x).dot(&(self.0 * vector(y)))
    }

    /// The smallest value at combinations of some orthonormal rates, of unit length, with the combination.
    pub(super) fn smallest(&self, rates: &[Matrix3<f64>]) -> (f64, Matrix3<f64>) {
        self.smallest_with(rates, rates, |_, _| 0.0)
    }

    /// The smallest `X : A : X + extra(D, D)` at combinations `D` of orthonormal tensors with the rates `X` that belong to them;
    /// with the combination `D`.
    pub(super) fn smallest_with(
        &self,
        rates: &[Matrix3<f64>],
        tensors: &[Matrix3<f64>],
        extra: impl Fn(&Matrix3<f64>, &Matrix3<f64>) -> f64,
    ) -> (f64, Matrix3<f64>) {
        let count = tensors.len();
        let matrix = DMatrix::from_fn(count, count, |a, b| {
            self.at(&rates[a], &rates[b]) + extra(&tensors[a], &tensors[b])
        });
        let Some(eigen) = SymmetricEigen::try_new(matrix, f64::EPSILON, 500) else {
            return (f64::NAN, Matrix3::zeros());
        };
        let lowest = eigen.eigenvalues.imin();
        let mut combination = Matrix3::zeros();
        for (n, tensor) in tensors.iter().enumerate() {
            combination += tensor * eigen.eigenvectors[(n, lowest)];
        }
        (eigen.eigenvalues[lowest], combination)
    }
}

fn vector(rate: &Matrix3<f64>) -> SVector<f64, 9> {
    SVector::from_fn(|n, _| rate[(n / 3, n % 3)])
}

/// All rates, orthonormal.
pub(super) fn all_rates() -> [Matrix3<f64>; 9] {
    array_of(|n| unit(n / 3, n % 3))
}

/// Symmetric rates, orthonormal.
pub(super) fn symmetric_rates() -> [Matrix3<f64>; 6] {
    let shear = |i: usize, j: usize| (unit(i, j) + unit(j, i)) / std::f64::consts::SQRT_2;
    [
        unit(0, 0),
        unit(1, 1),
        unit(2, 2),
        shear(1, 2),
        shear(0, 2),
        shear(0, 1),
    ]
}

fn unit(i: usize, j: usize) -> Matrix3<f64> {
    let mut matrix = Matrix3::zeros();
    matrix[(i, j)] = 1.0;
    matrix
}
