//! Zeros and local minima of a function of one variable.

use crate::algebra::lowest_between;

/// Brackets a zero of a function between two arguments with different signs, to neighboring numbers or `resolution`.
///
/// The Illinois variant of regula falsi is used, with bisection where it converges slowly. Arguments for which the function is `None` are not
/// admissible states and are assigned to the side of `high`.
pub(super) fn bracket_zero(
    value: &mut impl FnMut(f64) -> Option<f64>,
    (mut low, mut at_low): (f64, f64),
    (mut high, mut at_high): (f64, f64),
    resolution: f64,
) -> (f64, f64) {
    let mut last = 0;
    for step in 0..200 {
        let width = (high - low).abs();
        if width <= resolution {
            break;
        }
        let secant = low + (high - low) * at_low / (at_low - at_high);
        let guard = 0.25 * resolution;
        let inside = (secant - low).abs() > guard && (secant - high).abs() > guard;
        let middle = if step % 3 == 2 || !secant.is_finite() {
            0.5 * (low + high)
        } else if inside {
            secant
        } else {
            // The secant reaches an end of the bracket: step half the resolution away from it, so that the bracket closes.
            let end = if (secant - low).abs() <= guard {
                low
            } else {
                high
            };
            end + (0.5 * (low + high) - end).signum() * 0.5 * resolution
        };
        if middle == low || middle == high {
            break;
        }
        let found = value(middle).unwrap_or(at_high);
        if (found > 0.0) == (at_low > 0.0) {
            (low, at_low) = (middle, found);
            if last == 1 {
                at_high *= 0.5;
            }
            last = 1;
        } else {
            (high, at_high) = (middle, found);
            if last == -1 {
                at_low *= 0.5;
            }
            last = -1;
        }
    }
    (low, high)
}

/// Returns an argument between two others at which a function is not positive, by minimizing from a given middle argument and value, to `tolerance`.
///
/// The result is `None` if the function is not defined at an argument that is evaluated.
pub(super) fn dip(
    value: &mut impl FnMut(f64) -> Option<f64>,
    around: [f64; 3],
    middle: f64,
    tolerance: f64,
) -> Option<(f64, f64)> {
    let at = |s: f64| match value(s) {
        Some(found) if found > 0.0 => Ok(found),
        found => Err(found.map(|found| (s, found))),
    };
    lowest_between(at, around, middle, tolerance)
        .err()
        .flatten()
}
