//! A change of phase between two places on a line, narrowed down.

use super::{Phase, Probe};

/// A place on a line with what is there.
pub(crate) type Knot = (f64, Probe);

/// What became of a change between two places.
pub(crate) enum Narrowed {
    /// Two places, one in each phase: first that of the first one.
    Change(Knot, Knot),
    /// A place between them in another phase.
    Third(Knot),
}

/// Narrows a change of phase down to a tolerance, or to neighboring numbers. Interpolates the measure (the ITP method of Oliveira and
/// Takahashi, ACM Trans. Math. Softw. 47, 2020, which but for rounding never needs more than one step above bisection) where its sign is that of
/// the phase, and bisects where it is not. The measure of an unstable state is that of any wave that grows and may
/// jump, so that there the line through the last two stable places takes its place as soon as there are two.
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
        // Within the rounding of the measure it tells nothing: ever longer steps from there.
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
        // A measure of zero to rounding leads to an end.
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

/// A place beyond the change of phase with the measure on the line through two places before it, where that has the other
/// sign.
fn extrapolated(older: Knot, near: Knot, far: Knot) -> Knot {
    let slope = (near.1.1 - older.1.1) / (near.0 - older.0);
    let measure = near.1.1 + slope * (far.0 - near.0);
    if measure * near.1.1 < 0.0 {
        (far.0, (far.1.0, measure))
    } else {
        far
    }
}

/// The next place to ask: the regula falsi, pulled towards the middle by at most `budget`, and by a length at least: the places close around a change
/// that is met.
fn interpolated(left: Knot, right: Knot, start: f64, least: f64, budget: f64) -> f64 {
    let middle = 0.5 * (left.0 + right.0);
    // What is stable has no measure below zero but by rounding.
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

    /// Narrows the change of phases that a measure tells, with how often it is asked.
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
    fn a_change_is_closed_in_by_few_questions_even_where_rounding_lets_what_is_stable_fall_below_zero()
     {
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
