//! The tangent as a quadratic form of rates of the deformation gradient.

use crate::algebra::array_of;
use crate::material::FourthOrder;
use nalgebra::{DMatrix, Matrix3, SMatrix, SVector, SymmetricEigen};

/// Form `X : A : Y` of rates `X`, `Y`: the symmetric part of `A` as a 9 x 9 matrix.
#[derive(Clone, Debug)]
pub(super) struct QuadraticForm(SMatrix<f64, 9, 9>);

impl QuadraticForm {
    pub(super) fn of(tangent: &FourthOrder) -> Self {
        Self(SMatrix::from_fn(|a, b| {
            let (i, j, k, l) = (a / 3, a % 3, b / 3, b % 3);
            0.5 * (tangent[(i, j, k, l)] + tangent[(k, l, i, j)])
        }))
    }

    /// Largest component in magnitude.
    pub(super) fn magnitude(&self) -> f64 {
        self.0.amax()
    }

    /// Value `X : A : Y` of the form.
    pub(super) fn at(&self, x: &Matrix3<f64>, y: &Matrix3<f64>) -> f64 {
        vector(x).dot(&(self.0 * vector(y)))
    }

    /// Smallest value over unit combinations of orthonormal rates, with the minimizing combination.
    pub(super) fn smallest(&self, rates: &[Matrix3<f64>]) -> (f64, Matrix3<f64>) {
        self.smallest_with(rates, rates, |_, _| 0.0)
    }

    /// Smallest `X : A : X + extra(D, D)` over unit combinations `D` of orthonormal tensors, where `X` is the same combination of `rates`; with the
    /// minimizing `D`.
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

/// Orthonormal basis of all rates.
pub(super) fn all_rates() -> [Matrix3<f64>; 9] {
    array_of(|n| unit(n / 3, n % 3))
}

/// Orthonormal basis of the symmetric rates.
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
