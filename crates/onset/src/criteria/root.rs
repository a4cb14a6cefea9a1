//! Zeros and dips of a function of one variable.

use crate::algebra::lowest_between;

/// A zero of a function between two places at which its signs differ, by regula falsi with the Illinois rule and bisection where that
/// is slow; down to neighboring numbers or `resolution`. `None` for values are not possible places and count as the side of `high`.
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
            // Beside the end that the zero is at, so that the bracket closes.
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

/// A place between two others at which a function is not positive, sought where it is smallest, to `tolerance`, given a place between them
/// with its value. `None` where it has no value somewhere on the way.
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
