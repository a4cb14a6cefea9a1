//! Extremes over the zone of what only a wave vector tells.

use crate::bloch::IsEnded;
use nalgebra::SVector;

/// Points of the grid of wave vectors along a reciprocal vector.
const GRID: usize = 12;
/// Where the refinement ends, in units of reciprocal vectors.
const FINEST: f64 = 1e-4;

/// The least value over the zone, and where it is in units of the reciprocal vectors: on a grid, with finer ones around the least.
/// Infinite where no value is finite. What is found so far, as soon as nobody waits any more.
pub(super) fn least_over_zone<const D: usize>(
    at: impl Fn(&SVector<f64, D>) -> f64,
    is_ended: IsEnded<'_>,
) -> (f64, SVector<f64, D>) {
    let points = GRID.pow(D as u32);
    let mut best = (f64::INFINITY, SVector::zeros());
    // Of a wave vector and its opposite one is enough.
    for index in 1..points / 2 + points.div_ceil(GRID) {
        if is_ended() {
            return best;
        }
        let mut rest = index;
        let fractional = SVector::from_fn(|_, _| {
            let coordinate = (rest % GRID) as f64 / GRID as f64;
            rest /= GRID;
            coordinate
        });
        let value = at(&fractional);
        if value < best.0 {
            best = (value, fractional);
        }
    }
    let mut size = 0.5 / GRID as f64;
    while size > FINEST && !is_ended() {
        let before = best.0;
        for axis in 0..D {
            for sign in [-1.0, 1.0] {
                let mut tried = best.1;
                tried[axis] += sign * size;
                let value = at(&tried);
                if value < best.0 {
                    best = (value, tried);
                }
            }
        }
        if best.0 >= before {
            size *= 0.5;
        }
    }
    best
}
