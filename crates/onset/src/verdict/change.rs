//! Bracketing of a change of phase between two points of a line.

use super::{Phase, Probe};

/// Parameter of a point on a line, with the phase and the measure there.
pub(crate) type Knot = (f64, Probe);

/// Result of narrowing a change of phase.
pub(crate) enum Narrowed {
    /// Bracket of the change: its end in the first phase, then its end in the second.
    Change(Knot, Knot),
    /// A point between the ends in a third phase.
    Third(Knot),
}

/// Narrows a change of phase to a bracket of length `tolerance`, or to neighboring floating-point numbers.
///
/// If the sign of the measure agrees with the phase, the measure is interpolated; otherwise the bracket is bisected. Interpolation uses the ITP
/// method (Oliveira and Takahashi, ACM Trans. Math. Softw. 47, 2020). Apart from rounding it needs at most one step more than bisection. The measure
/// of an unstable state belongs to any growing wave and may jump. Once two stable points are known, the line through them replaces it.
pub(crate) fn narrow<E>(
    at: &dyn Fn(f64) -> Result<Probe, E>,
    (mut left, mut right): (Knot, Knot),
    tolerance: f64,
) -> Result<Narrowed, E> {
    let phases = [left.1.0, right.1.0];
    let start = (left.0 - right.0).abs();
    let mut budget =
        0.5 * tolerance * 2.0_f64.powf((start / tolerance).log2().ceil().max(0.0) + 1.0);
    let mut older: Option<Knot> = None;
    let mut least = 0.9 * tolerance;
    while (left.0 - right.0).abs() > tolerance {
        // Within its rounding the measure gives no distance: the steps from there are doubled.
        let stable = [left, right]
            .into_iter()
            .find(|knot| knot.1.0 == Phase::Stable);
        if stable.is_some_and(|knot| knot.1.1 <= 0.0) {
            least *= 2.0;
        }
        let next = |left, right| interpolated(left, right, start, least, budget);
        let x = match older {
            Some(older) if phases[0] == Phase::Stable => {
                next(left, extrapolated(older, left, right))
            }
            Some(older) => next(extrapolated(older, right, left), right),
            None => next(left, right),
        };
        let is_end = |x: f64| x == left.0 || x == right.0;
        // If a measure is zero to rounding, interpolation returns an end of the bracket.
        let x = if is_end(x) {
            0.5 * (left.0 + right.0)
        } else {
            x
        };
        if is_end(x) {
            break;
        }
        budget *= 0.5;
        let here = at(x)?;
        let replaced = if here.0 == phases[0] {
            std::mem::replace(&mut left, (x, here))
        } else if here.0 == phases[1] {
            std::mem::replace(&mut right, (x, here))
        } else {
            return Ok(Narrowed::Third((x, here)));
        };
        if here.0 == Phase::Stable {
            older = Some(replaced);
        }
    }
    Ok(Narrowed::Change(left, right))
}

/// Returns `far` with the measure on the line through two points before the change, if this measure has the opposite sign.
fn extrapolated(older: Knot, near: Knot, far: Knot) -> Knot {
    let slope = (near.1.1 - older.1.1) / (near.0 - older.0);
    let measure = near.1.1 + slope * (far.0 - near.0);
    if measure * near.1.1 < 0.0 {
        (far.0, (far.1.0, measure))
    } else {
        far
    }
}

/// Next point to evaluate, by regula falsi.
///
/// The point is moved toward the middle by at least `least`, so that both ends of the bracket approach the change, and by as much as `budget`
/// requires.
fn interpolated(left: Knot, right: Knot, start: f64, least: f64, budget: f64) -> f64 {
    let middle = 0.5 * (left.0 + right.0);
    // Negative measures of stable states are rounding errors.
    let measure = |knot: Knot| match knot.1.0 {
        Phase::Stable => knot.1.1.max(0.0),
        _ => knot.1.1,
    };
    let (above, below) = (measure(left), measure(right));
    let is_change = (above < 0.0) != (below < 0.0) && above != below;
    if !(is_change && (above - below).is_finite()) {
        return middle;
    }
    let size = (left.0 - right.0).abs();
    let falsi = (left.0 * below - right.0 * above) / (below - above);
    let pull = (0.2 * size * size / start).max(least);
    let pull = pull.min((middle - falsi).abs());
    let truncated = falsi + pull * (middle - falsi).signum();
    let radius = (budget - 0.5 * size).max(0.0);
    if (truncated - middle).abs() <= radius {
        truncated
    } else {
        middle - radius * (middle - falsi).signum()
    }
}

#[cfg(test)]
mod tests {
    use super::{Narrowed, narrow};
    use crate::verdict::{Phase, Probe};
    use std::cell::Cell;

    /// Narrows the change of phase of a measure on `[0, 1]`; returns the bracket and the number of evaluations.
    fn narrowed(phase: impl Fn(f64) -> Probe, tolerance: f64) -> (f64, f64, usize) {
        let asked = Cell::new(0);
        let at = |x: f64| {
            asked.set(asked.get() + 1);
            Ok::<_, ()>(phase(x))
        };
        match narrow(&at, ((0.0, phase(0.0)), (1.0, phase(1.0))), tolerance) {
            Ok(Narrowed::Change(left, right)) => (left.0, right.0, asked.get()),
            _ => panic!("no change"),
        }
    }

    #[test]
    fn narrowing_needs_few_evaluations_even_if_rounding_makes_stable_measures_negative() {
        for (change, rounding, most) in [
            (0.3717, 0.0, 14),
            (1e-7, 0.0, 14),
            (0.3717, 1e-11, 20),
            (0.99, 1e-9, 34),
        ] {
            let probe = |x: f64| {
                let measure = (change - x) * (1.0 + x * x);
                match measure >= -rounding {
                    true => (Phase::Stable, measure),
                    false => (Phase::Unstable, measure),
                }
            };
            let (left, right, asked) = narrowed(probe, 1e-12);
            assert!((right - left).abs() <= 1e-12, "{left} {right}");
            let apart = (left - change).abs();
            assert!(apart <= 2.0 * rounding + 1e-12, "{left} {change}");
            assert!(asked <= most, "{change} {rounding}: {asked}");
        }
    }

    #[test]
    fn a_change_without_a_measure_is_bisected() {
        let probe = |x: f64| match x < 0.2 {
            true => (Phase::Stable, 1.0),
            false => (Phase::Flutter, 1.0),
        };
        let (left, right, asked) = narrowed(probe, 1e-10);
        assert!(left < 0.2 && right >= 0.2 && right - left <= 1e-10);
        assert!(asked <= 36, "{asked}");
    }
}
