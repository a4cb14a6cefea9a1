//! Component order of symmetric tensors in Abaqus.

use nalgebra::{Matrix3, Matrix6, Vector6};
use onset::material::FourthOrder;

/// Index pairs in the order of Abaqus/Standard: 11, 22, 33, 12, 13, 23.
pub const VOIGT: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// Position of the pair `(i, j)` in this order.
fn place(i: usize, j: usize) -> usize {
    if i == j { i } else { i + j + 2 }
}

/// Symmetric tensor from stress-like components (no factor 2 on shear).
pub(crate) fn symmetric(components: &[f64]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| components[place(i, j)])
}

/// Stress-like components of a tensor: its components with `i <= j`.
pub(crate) fn stress_like(tensor: &Matrix3<f64>) -> Vector6<f64> {
    Vector6::from_fn(|a, _| tensor[VOIGT[a]])
}

/// Strain-like components of a symmetric tensor: engineering shear, twice the tensor component.
pub(crate) fn strain_like(tensor: &Matrix3<f64>) -> Vector6<f64> {
    Vector6::from_fn(|a, _| tensor[VOIGT[a]] * if a < 3 { 1.0 } else { 2.0 })
}

/// Symmetric tensor from strain-like components.
pub(crate) fn strain(components: &[f64]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| components[place(i, j)] * if i == j { 1.0 } else { 0.5 })
}

/// Tensor `T_ijkl` from a matrix that maps engineering strains to stresses.
///
/// An engineering shear contains both `kl` and `lk`, so that the components of the matrix equal the components of the tensor.
pub fn tensor_of_voigt(matrix: &Matrix6<f64>) -> FourthOrder {
    FourthOrder::from_fn(|i, j, k, l| matrix[(place(i, j), place(k, l))])
}

/// Matrix of the components `T_ijkl` with `i <= j`, `k <= l`; the inverse of [`tensor_of_voigt`] for tensors with both minor symmetries.
pub fn voigt_of_tensor(tensor: &FourthOrder) -> Matrix6<f64> {
    Matrix6::from_fn(|a, b| {
        let ((i, j), (k, l)) = (VOIGT[a], VOIGT[b]);
        tensor[(i, j, k, l)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_components_is_the_order_of_abaqus_in_both_directions() {
        for (a, &(i, j)) in VOIGT.iter().enumerate() {
            assert_eq!(place(i, j), a);
            assert_eq!(place(j, i), a);
        }
        let matrix = Matrix6::from_fn(|a, b| (10 * a + b) as f64);
        assert_eq!(voigt_of_tensor(&tensor_of_voigt(&matrix)), matrix);
        let tensor = Matrix3::new(1.0, 4.0, 5.0, 4.0, 2.0, 6.0, 5.0, 6.0, 3.0);
        let components = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        assert_eq!(symmetric(&components), tensor);
        assert_eq!(stress_like(&tensor).as_slice(), components);
        assert_eq!(strain(strain_like(&tensor).as_slice()), tensor);
        assert_eq!(strain_like(&tensor)[4], 10.0);
    }
}
