//! The phase along a line: where does it change?

use super::Window;
use super::plane::Point;
use crate::verdict::{Phase, Probe};
use std::cell::Cell;

/// The phases over the window, in units of the window; counts how often it is asked.
pub(super) struct Field<'a, E> {
    pub(super) window: Window,
    pub(super) probe: &'a (dyn Fn([f64; 2]) -> Result<Probe, E> + Sync),
    asked: Cell<usize>,
}

/// A place on a line with what is there.
pub(super) type Knot = (f64, Probe);

/// What a search along a line came to.
pub(super) enum Found {
    /// Two places, one in each phase: first that on the left, then that on the right.
    Change(Knot, Knot),
    /// Another phase, or `None` beyond the edge of the window.
    Other(Option<Phase>),
    /// The same phase all along.
    Nothing,
}

/// The phases to the left and to the right of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Sides {
    pub(super) left: Phase,
    pub(super) right: Phase,
}

impl Sides {
    pub(super) fn swapped(self) -> Self {
        Self {
            left: self.right,
            right: self.left,
        }
    }

    pub(super) fn holds(self, phase: Phase) -> bool {
        phase == self.left || phase == self.right
    }
}

impl<'a, E> Field<'a, E> {
    pub(super) fn new(
        window: Window,
        probe: &'a (dyn Fn([f64; 2]) -> Result<Probe, E> + Sync),
    ) -> Self {
        Self {
            window,
            probe,
            asked: Cell::new(0),
        }
    }

    pub(super) fn asked(&self) -> usize {
        self.asked.get()
    }

    /// What is at a point; `None` outside the window.
    pub(super) fn at(&self, u: Point) -> Result<Option<Probe>, E> {
        if !u.iter().all(|x| (0.0..=1.0).contains(x)) {
            return Ok(None);
        }
        self.asked.set(self.asked.get() + 1);
        (self.probe)(self.window.point(u)).map(Some)
    }

    /// From a guess outward with doubling steps until the phase changes; the line leads leftward.
    pub(super) fn march(
        &self,
        line: &dyn Fn(f64) -> Point,
        (guess, first, limit): (f64, f64, f64),
        sides: Sides,
    ) -> Result<Found, E> {
        let Some(start) = self.at(line(guess))? else {
            return Ok(Found::Other(None));
        };
        if !sides.holds(start.0) {
            return Ok(Found::Other(Some(start.0)));
        }
        let sign = if start.0 == sides.left { -1.0 } else { 1.0 };
        let mut last: Knot = (guess, start);
        let mut step = first;
        loop {
            let x = last.0 + sign * step;
            if x.abs() > limit {
                return Ok(Found::Nothing);
            }
            let Some(here) = self.at(line(x))? else {
                return Ok(Found::Other(None));
            };
            let knot = (x, here);
            if here.0 != start.0 {
                return Ok(if !sides.holds(here.0) {
                    Found::Other(Some(here.0))
                } else if start.0 == sides.left {
                    Found::Change(last, knot)
                } else {
                    Found::Change(knot, last)
                });
            }
            last = knot;
            // Not so far that a narrow phase is stepped over.
            step = (2.0 * step).min(0.1 * limit);
        }
    }

    /// Narrows a change of phase down to a tolerance. Interpolates the measure (the ITP method of Oliveira and Takahashi,
    /// ACM Trans. Math. Softw. 47, 2020, which never needs more than one step above bisection) where its sign is that of
    /// the phase, and bisects where it is not. The measure of an unstable state is that of any wave that grows and may
    /// jump, so that there the line through the last two stable places takes its place as soon as there are two.
    pub(super) fn narrow(
        &self,
        line: &dyn Fn(f64) -> Point,
        (mut left, mut right): (Knot, Knot),
        tolerance: f64,
    ) -> Result<Found, E> {
        let sides = Sides {
            left: left.1.0,
            right: right.1.0,
        };
        let start = (left.0 - right.0).abs();
        let mut budget =
            0.5 * tolerance * 2.0_f64.powf((start / tolerance).log2().ceil().max(0.0) + 1.0);
        let mut older: Option<Knot> = None;
        while (left.0 - right.0).abs() > tolerance {
            let x = match older {
                Some(older) if sides.left == Phase::Stable => {
                    interpolated(left, extrapolated(older, left, right), start, budget)
                }
                Some(older) => interpolated(extrapolated(older, right, left), right, start, budget),
                None => interpolated(left, right, start, budget),
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
            let Some(here) = self.at(line(x))? else {
                return Ok(Found::Other(None));
            };
            let replaced = if here.0 == sides.left {
                std::mem::replace(&mut left, (x, here))
            } else if here.0 == sides.right {
                std::mem::replace(&mut right, (x, here))
            } else {
                return Ok(Found::Other(Some(here.0)));
            };
            if here.0 == Phase::Stable {
                older = Some(replaced);
            }
        }
        Ok(Found::Change(left, right))
    }

    /// [`Field::march`], then [`Field::narrow`].
    pub(super) fn locate(
        &self,
        line: &dyn Fn(f64) -> Point,
        reach: (f64, f64, f64),
        sides: Sides,
        tolerance: f64,
    ) -> Result<Found, E> {
        match self.march(line, reach, sides)? {
            Found::Change(left, right) => self.narrow(line, (left, right), tolerance),
            other => Ok(other),
        }
    }
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

/// The next place to ask: the regula falsi, pulled towards the middle by at most `budget`.
fn interpolated(left: Knot, right: Knot, start: f64, budget: f64) -> f64 {
    let middle = 0.5 * (left.0 + right.0);
    let (above, below) = (left.1.1, right.1.1);
    if !(above * below < 0.0 && (above - below).is_finite()) {
        return middle;
    }
    let size = (left.0 - right.0).abs();
    let falsi = (left.0 * below - right.0 * above) / (below - above);
    let pull = (0.2 * size * size / start).min((middle - falsi).abs());
    let truncated = falsi + pull * (middle - falsi).signum();
    let radius = (budget - 0.5 * size).max(0.0);
    if (truncated - middle).abs() <= radius {
        truncated
    } else {
        middle - radius * (middle - falsi).signum()
    }
}

impl Found {
    /// The middle of a change and half of its length.
    pub(super) fn place(&self) -> Option<(f64, f64)> {
        match self {
            Self::Change(left, right) => {
                Some((0.5 * (left.0 + right.0), 0.5 * (left.0 - right.0).abs()))
            }
            _ => None,
        }
    }
}
