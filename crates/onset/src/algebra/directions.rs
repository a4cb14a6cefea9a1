//! Sampling directions in all dimensions.

use nalgebra::SVector;
use std::f64::consts::PI;

/// Number of directions in the plane.
const PLANE: usize = 180;
/// Number of directions in three dimensions.
const SPACE: usize = 400;

/// Directions spread over half of the circle, or of the sphere along a spiral by the golden angle.
pub(crate) fn directions<const D: usize>() -> Vec<SVector<f64, D>> {
    let vector = |components: [f64; 3]| SVector::from_fn(|i, _| components[i]);
    match D {
        1 => vec![vector([1.0, 0.0, 0.0])],
        2 => (0..PLANE)
            .map(|n| PI * n as f64 / PLANE as f64)
            .map(|angle| vector([angle.cos(), angle.sin(), 0.0]))
            .collect(),
        _ => {
            let golden = PI * (3.0 - 5.0_f64.sqrt());
            (0..SPACE)
                .map(|n| {
                    let height = (n as f64 + 0.5) / SPACE as f64;
                    let radius = (1.0 - height * height).sqrt();
                    let (sine, cosine) = (golden * n as f64).sin_cos();
                    vector([radius * cosine, radius * sine, height])
                })
                .collect()
        }
    }
}
