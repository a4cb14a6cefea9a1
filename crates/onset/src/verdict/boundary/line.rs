//! Changes of phase along a line.

use super::Window;
use super::plane::Point;
use crate::verdict::change::{Knot, Narrowed, narrow};
use crate::verdict::{Phase, Probe};
use std::cell::Cell;

/// Phases in the window, in units of the window, with the number of evaluations.
pub(super) struct Field<'a, E> {
    pub(super) window: Window,
    pub(super) probe: &'a (dyn Fn([f64; 2]) -> Result<Probe, E> + Sync),
    asked: Cell<usize>,
}

/// Result of a search along a line.
pub(super) enum Found {
    /// Bracket of a change of phase: its end in the left phase, then its end in the right phase.
    Change(Knot, Knot),
    /// A third phase, or `None` at the edge of the window.
    Other(Option<Phase>),
    /// No change of phase.
    Nothing,
}

/// Phases to the left and to the right of a curve.
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

    /// Phase and measure at a point; `None` outside the window.
    pub(super) fn at(&self, u: Point) -> Result<Option<Probe>, E> {
        if !u.iter().all(|x| (0.0..=1.0).contains(x)) {
            return Ok(None);
        }
        self.asked.set(self.asked.get() + 1);
        (self.probe)(self.window.point(u)).map(Some)
    }

    /// Searches for a change of phase from a guess outward, with doubling steps. The parameter of the line increases towards the left phase.
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
            // Longer steps could miss a narrow phase.
            step = (2.0 * step).min(0.1 * limit);
        }
    }

    /// Narrows a change of phase along a line; see [`narrow`].
    pub(super) fn narrow(
        &self,
        line: &dyn Fn(f64) -> Point,
        knots: (Knot, Knot),
        tolerance: f64,
    ) -> Result<Found, E> {
        // `Err(None)` marks points outside the window.
        let at = |x: f64| self.at(line(x)).map_err(Some)?.ok_or(None);
        match narrow(&at, knots, tolerance) {
            Ok(Narrowed::Change(left, right)) => Ok(Found::Change(left, right)),
            Ok(Narrowed::Third((_, here))) => Ok(Found::Other(Some(here.0))),
            Err(None) => Ok(Found::Other(None)),
            Err(Some(error)) => Err(error),
        }
    }

    /// Finds and narrows a change of phase: [`Field::march`], then [`Field::narrow`].
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

impl Found {
    /// Middle of the bracket of a change, and half its length.
    pub(super) fn place(&self) -> Option<(f64, f64)> {
        match self {
            Self::Change(left, right) => {
                Some((0.5 * (left.0 + right.0), 0.5 * (left.0 - right.0).abs()))
            }
            _ => None,
        }
    }
}
