//! Arrays: buffers of doubles as input, bytes as output.

use crate::failure::Failure;
use onset::kinematics::DeformationGradient;
use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// Copies the numbers of a buffer, with the last index varying fastest.
pub fn numbers(py: Python<'_>, buffer: &PyBuffer<f64>) -> PyResult<Vec<f64>> {
    buffer.to_vec(py)
}

/// Numbers as bytes that NumPy wraps as an array.
pub fn bytes<'py>(py: Python<'py>, numbers: &[f64]) -> Bound<'py, PyBytes> {
    let mut bytes = Vec::with_capacity(size_of_val(numbers));
    for number in numbers {
        bytes.extend_from_slice(&number.to_ne_bytes());
    }
    PyBytes::new(py, &bytes)
}

/// Deformation gradients from nine components each; `first` is the number of the first state in messages.
///
/// # Errors
/// [`Failure`] with the number of the first invalid one.
pub fn deformations(components: &[f64], first: usize) -> Result<Vec<DeformationGradient>, Failure> {
    let gradient = |(n, part): (usize, &[f64])| {
        let rows = [0, 3, 6].map(|row| [part[row], part[row + 1], part[row + 2]]);
        DeformationGradient::new(rows)
            .map_err(|error| Failure::Input(format!("state {}: {error}", first + n)))
    };
    components
        .chunks_exact(9)
        .enumerate()
        .map(gradient)
        .collect()
}
