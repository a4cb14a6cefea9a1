//! Arrays: buffers of doubles as input, bytes as output.

use crate::failure::Failure;
use onset::kinematics::DeformationGradient;
use pyo3::buffer::PyBuffer;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// Numbers that are copied between two checks for signals, in some milliseconds.
const NUMBERS_BETWEEN_SIGNALS: usize = 1 << 20;

/// Copies the numbers of a buffer, with the last index varying fastest.
pub fn numbers(py: Python<'_>, buffer: &PyBuffer<f64>) -> PyResult<Vec<f64>> {
    buffer.to_vec(py)
}

/// Numbers as bytes that NumPy wraps as an array.
///
/// # Errors
/// `MemoryError`, and the exception of a signal that arrives during the copying of a large array.
pub fn bytes<'py>(py: Python<'py>, numbers: &[f64]) -> PyResult<Bound<'py, PyBytes>> {
    PyBytes::new_with(py, size_of_val(numbers), |bytes| {
        let parts = numbers.chunks(NUMBERS_BETWEEN_SIGNALS);
        for (numbers, bytes) in parts.zip(bytes.chunks_mut(8 * NUMBERS_BETWEEN_SIGNALS)) {
            py.check_signals()?;
            for (number, bytes) in numbers.iter().zip(bytes.chunks_exact_mut(8)) {
                bytes.copy_from_slice(&number.to_ne_bytes());
            }
        }
        Ok(())
    })
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
