//! Directions on the sphere: a search from many starts with local refinement.

use super::Stiffness;
use crate::algebra::{Complex, eigenvalues};
use nalgebra::{SMatrix, SVector};

/// Starting directions spread over the half sphere (a direction and its opposite are the same).
const STARTS: usize = 160;
/// How many of the best starts are refined.
const REFINED: usize = 5;

pub(super) fn minimizing_direction<const D: usize>(stiffness: &Stiffness<D>) -> SVector<f64, D> {
    let eigenvalue = |n: &SVector<f64, D>| smallest_real_part(&stiffness.acoustic_tensor(n));
    let mut starts: Vec<(f64, SVector<f64, D>)> = (0..STARTS)
        .map(fibonacci_direction)
        .chain((0..D).map(|axis| SVector::from_fn(|i, _| f64::from(u8::from(i == axis)))))
        .map(|n| (eigenvalue(&n), n))
        .collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best = starts[0];
    for &(value, direction) in starts.iter().take(REFINED) {
        let refined = descend(value, direction, &eigenvalue);
        if refined.0 < best.0 {
            best = refined;
        }
    }
    best.1
}

/// The smallest real part of an eigenvalue. For a symmetric 3 x 3 matrix from the trigonometric solution of the
/// characteristic equation: good to the square root of rounding near double eigenvalues, enough to search with.
fn smallest_real_part<const D: usize>(q: &SMatrix<f64, D, D>) -> f64 {
    let asymmetry = (q - q.transpose()).amax();
    if D != 3 || asymmetry > 1e-12 * q.amax() {
        return eigenvalues(&q.map(|entry| Complex::new(entry, 0.0)), 0.0)[0].re;
    }
    let mean = q.trace() / 3.0;
    let deviator = q - SMatrix::<f64, D, D>::identity() * mean;
    let spread = (deviator.norm_squared() / 6.0).sqrt();
    if spread == 0.0 {
        return mean;
    }
    let b = |i: usize, j: usize| deviator[(i, j)] / spread;
    let determinant = b(0, 0) * (b(1, 1) * b(2, 2) - b(1, 2) * b(2, 1))
        - b(0, 1) * (b(1, 0) * b(2, 2) - b(1, 2) * b(2, 0))
        + b(0, 2) * (b(1, 0) * b(2, 1) - b(1, 1) * b(2, 0));
    let angle = (0.5 * determinant).clamp(-1.0, 1.0).acos() / 3.0;
    mean + 2.0 * spread * (angle + std::f64::consts::TAU / 3.0).cos()
}

/// The `n`-th of evenly spread directions on the upper half sphere (golden-angle spiral).
fn fibonacci_direction<const D: usize>(n: usize) -> SVector<f64, D> {
    let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let height = (n as f64 + 0.5) / STARTS as f64;
    let radius = (1.0 - height * height).sqrt();
    let (sine, cosine) = (golden_angle * n as f64).sin_cos();
    SVector::from_fn(|i, _| match i {
        0 => radius * cosine,
        1 => radius * sine,
        _ => height,
    })
}

/// Coordinate search on the sphere with a shrinking step.
fn descend<const D: usize>(
    mut value: f64,
    mut direction: SVector<f64, D>,
    eigenvalue: &impl Fn(&SVector<f64, D>) -> f64,
) -> (f64, SVector<f64, D>) {
    let mut step = 0.1;
    while step > 1e-9 {
        let mut improved = false;
        for axis in 0..D {
            for sign in [step, -step] {
                let mut trial = direction;
                trial[axis] += sign;
                trial.normalize_mut();
                let trial_value = eigenvalue(&trial);
                if trial_value < value {
                    (value, direction, improved) = (trial_value, trial, true);
                }
            }
        }
        if !improved {
            step *= 0.5;
        }
    }
    (value, direction)
}
