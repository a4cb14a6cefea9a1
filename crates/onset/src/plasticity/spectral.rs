//! Spectral decomposition of symmetric tensors.

use crate::algebra::symmetric_eigen;
use nalgebra::{Matrix3, Vector3};

/// Principal values and axes of a symmetric tensor.
pub(super) struct Spectral {
    pub(super) values: Vector3<f64>,
    pub(super) axes: Matrix3<f64>,
}

impl Spectral {
    pub(super) fn of(tensor: &Matrix3<f64>) -> Self {
        let symmetric = (tensor + tensor.transpose()) * 0.5;
        // A symmetric matrix may be read by rows.
        let (values, axes) = symmetric_eigen(&symmetric.data.0);
        Self {
            values: values.into(),
            axes: axes.into(),
        }
    }

    /// Decomposes a tensor with positive principal values; `None` otherwise.
    pub(super) fn positive(tensor: &Matrix3<f64>) -> Option<Self> {
        Some(Self::of(tensor)).filter(|found| found.values.min() > 0.0)
    }

    /// Decomposes `1/2 ln T` of a tensor `T` with positive principal values, such as `F^T F` or `F F^T`.
    pub(super) fn half_logarithm(tensor: &Matrix3<f64>) -> Option<Self> {
        Self::positive(tensor).map(|squares| Self {
            values: squares.values.map(|square| 0.5 * square.ln()),
            ..squares
        })
    }

    /// Tensor with a function applied to its principal values.
    pub(super) fn map(&self, function: impl Fn(f64) -> f64) -> Matrix3<f64> {
        self.turned(&Matrix3::from_diagonal(&self.values.map(function)))
    }

    /// Transforms a tensor from the principal axes to the fixed axes.
    pub(super) fn turned(&self, tensor: &Matrix3<f64>) -> Matrix3<f64> {
        self.axes * tensor * self.axes.transpose()
    }

    /// Tensor `Y` with `dE : K = Y : dB` for `E = 1/2 ln B` of this tensor `B`.
    pub(super) fn dual_of_logarithm(&self, k: &Matrix3<f64>) -> Matrix3<f64> {
        let own = self.axes.transpose() * k * self.axes;
        let quotient = |a: usize, b: usize| {
            // (ln a - ln b)/(2 (a - b)), which has no singularity where they coincide.
            let half = 0.5 * (self.values[a] / self.values[b]).ln();
            let ratio = if half == 0.0 { 1.0 } else { half / half.sinh() };
            0.5 * ratio / (self.values[a] * self.values[b]).sqrt()
        };
        self.turned(&Matrix3::from_fn(|a, b| own[(a, b)] * quotient(a, b)))
    }
}
