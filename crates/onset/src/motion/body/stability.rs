//! Which steps are stable: the largest frequency of a body.

use crate::algebra::uniform;
use crate::motion::Fault;

/// Iterations by which the largest factor is sought.
const ITERATIONS: usize = 60;
/// Displacements by which forces are differentiated, in spacings.
pub(super) const DIFFERENCE: f64 = 1e-5;

/// What a linear map makes of a vector.
type Image = Result<Vec<f64>, Box<Fault>>;

/// The largest factor by which a linear map lengthens vectors of so many numbers, from above: sixty iterations of the power method find it up to the
/// share `0.871 ln n / 59` on average over random starts, which is added.
///
/// The map is given a vector and the size of its largest component.
///
/// Source: Kuczynski and Wozniakowski, SIAM J. Matrix Anal. Appl. 13 (1992) 1094, for symmetric matrices.
pub(super) fn largest_factor(
    unknowns: usize,
    map: &mut dyn FnMut(&[f64], f64) -> Image,
) -> Result<f64, Box<Fault>> {
    let mut random = 1;
    let mut along: Vec<f64> = (0..unknowns)
        .map(|_| 2.0 * uniform(&mut random) - 1.0)
        .collect();
    let norm = |field: &[f64]| field.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut largest = 0.0_f64;
    for _ in 0..ITERATIONS {
        let length = norm(&along);
        let highest = along.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        if highest == 0.0 {
            break;
        }
        let image = map(&along, highest)?;
        largest = norm(&image) / length;
        let scale = largest.max(f64::MIN_POSITIVE).recip();
        along = image.into_iter().map(|x| x * scale).collect();
    }
    let missed = 0.871 * (unknowns as f64).ln() / (ITERATIONS - 1) as f64;
    Ok(largest / (1.0 - missed.min(0.5)))
}

/// The largest stable step of the leapfrog with the squared frequency `w^2` and the damping `c`, the forces of which are those of velocities half a
/// step before: `w^2 dt^2 + 2 c dt = 4`, where the step multiplies an oscillation by -1. Time.
pub(super) fn critical_step(squared: f64, damping: f64) -> f64 {
    4.0 / (damping + (damping * damping + 4.0 * squared).sqrt())
}
