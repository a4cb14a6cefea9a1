//! Corners: intersections of two smooth branches of a curve.

use super::follow::{Heading, Node, SWEEP, heading_behind};
use super::line::{Field, Sides};
use super::plane::{
    Point, angle_of, cross, direction, distance, left_of, length, minus, plus, unit,
};
use crate::algebra::Each;
use std::f64::consts::PI;

/// Spacings of the points that define the extension of a branch. The next spacing is tried if the branches do not meet.
const SPACINGS: [f64; 3] = [2e-5, 2e-6, 2e-7];
/// Largest distance of the boundary from the intersection of the branches.
const CORNER_TOLERANCE: f64 = 1e-9;

/// Distance of two further points beyond a step, as a fraction of the step, and the length of their brackets.
const EXTENSION_STEPS: f64 = 0.05;
const EXTENSION_BRACKET: f64 = 1e-10;

/// Distance to a corner within a step in which the curve turns; `None` if the branches do not meet within the step.
///
/// The curve from the start is extended with its curvature, the branch at the end of the step backward. Their intersection is the corner.
pub(super) fn ahead<E>(
    field: &Field<'_, E>,
    sides: Sides,
    heading: &Heading,
    next: Point,
) -> Result<Option<f64>, E> {
    let spacing = EXTENSION_STEPS * distance(next, heading.at);
    let beyond = |from: Point, to: Point| {
        let onward = (to, angle_of(minus(to, from)));
        on_circle(field, sides, onward, spacing, EXTENSION_BRACKET)
    };
    let Some(first) = beyond(heading.at, next)? else {
        return Ok(None);
    };
    let Some(second) = beyond(next, first.at)? else {
        return Ok(None);
    };
    let along = direction(heading.angle);
    let run = |t: f64| {
        let bend = 0.5 * heading.curvature * t * t;
        plus(plus(heading.at, t, along), bend, left_of(along))
    };
    let before = Branch([run(0.0), run(spacing), run(2.0 * spacing)]);
    let behind = Branch([next, first.at, second.at]);
    let reach = 1.05 / EXTENSION_STEPS;
    let corner = before
        .crossing(&behind)
        .filter(|(t, s)| (0.0..=reach).contains(t) && (-reach..=0.2).contains(s));
    Ok(corner.map(|(t, _)| distance(heading.at, before.at(t))))
}

/// Corner between a heading and a point after it.
///
/// Returns the corner with the first vertices of the next branch, and the heading at the last of these vertices; `None` if the branches are not
/// smooth there.
pub(super) fn around<E>(
    field: &Field<'_, E>,
    sides: Sides,
    heading: &Heading,
    next: Node,
    bracket: f64,
) -> Result<Option<(Vec<Node>, Heading)>, E> {
    for spacing in SPACINGS {
        let back = |radius: f64| {
            let start = (heading.at, heading.angle + PI);
            on_circle(field, sides.swapped(), start, radius, bracket)
        };
        let (Some(one), Some(two)) = (back(spacing)?, back(2.0 * spacing)?) else {
            continue;
        };
        let ahead = angle_of(minus(next.at, heading.at));
        let Some(first) = on_circle(field, sides, (next.at, ahead), spacing, bracket)? else {
            continue;
        };
        let ahead = angle_of(minus(first.at, next.at));
        let Some(second) = on_circle(field, sides, (first.at, ahead), spacing, bracket)? else {
            continue;
        };
        let before = Branch([heading.at, one.at, two.at]);
        let behind = Branch([next.at, first.at, second.at]);
        let Some((meeting, tangents)) = before.meeting(&behind) else {
            continue;
        };
        if let Some((at, off)) = snapped(field, sides, meeting, tangents, bracket)? {
            let corner = Node {
                at,
                accuracy: off,
                is_corner: true,
            };
            let heading = heading_behind(next.at, first.at, second.at);
            let mut nodes = vec![corner];
            // The branch may begin at the corner.
            if distance(next.at, at) > 1e-3 * spacing {
                nodes.push(next);
            }
            nodes.extend([first, second]);
            return Ok(Some((nodes, heading)));
        }
    }
    Ok(None)
}

/// Point at which the curve leaves a small circle.
fn on_circle<E>(
    field: &Field<'_, E>,
    sides: Sides,
    (at, angle): (Point, f64),
    radius: f64,
    bracket: f64,
) -> Result<Option<Node>, E> {
    let circle = |turn: f64| plus(at, radius, direction(angle + turn));
    let found = field.locate(&circle, (0.0, 1e-3, SWEEP), sides, bracket / radius)?;
    Ok(found
        .place()
        .map(|(turn, accuracy)| Node::regular(circle(turn), accuracy * radius)))
}

/// Parabola through three points of a branch, starting with the point nearest to the corner, at the parameters 0, 1 and 2.
struct Branch([Point; 3]);

impl Branch {
    fn at(&self, t: f64) -> Point {
        let weights = [
            0.5 * (1.0 - t) * (2.0 - t),
            t * (2.0 - t),
            0.5 * t * (t - 1.0),
        ];
        [0, 1].each(|i| (0..3).map(|n| weights[n] * self.0[n][i]).sum())
    }

    fn slope(&self, t: f64) -> Point {
        let weights = [t - 1.5, 2.0 - 2.0 * t, t - 0.5];
        [0, 1].each(|i| (0..3).map(|n| weights[n] * self.0[n][i]).sum())
    }

    /// Parameters of the intersection of two branches.
    fn crossing(&self, other: &Self) -> Option<(f64, f64)> {
        let (mut t, mut s) = (0.0, 0.0);
        for _ in 0..30 {
            let gap = minus(other.at(s), self.at(t));
            let (a, b) = (self.slope(t), other.slope(s));
            // Newton step: a dt - b ds = gap.
            let determinant = -cross(a, b);
            if determinant.abs() < 1e-6 * length(a) * length(b) {
                return None;
            }
            let (dt, ds) = (-cross(gap, b) / determinant, -cross(gap, a) / determinant);
            t += dt;
            s += ds;
            if dt.abs().max(ds.abs()) < 1e-12 {
                break;
            }
        }
        Some((t, s))
    }

    /// Intersection of two branches near their first points, with the slopes of both there, away from the corner.
    fn meeting(&self, other: &Self) -> Option<(Point, [Point; 2])> {
        let (t, s) = self.crossing(other)?;
        let is_near = (-2.0..=0.2).contains(&t) && (-2.0..=0.2).contains(&s);
        is_near.then(|| (self.at(t), [self.slope(t), other.slope(s)]))
    }
}

/// Point of the boundary on the bisector of the corner, with its distance from the intersection of the branches; `None` if the boundary is too far
/// from it.
fn snapped<E>(
    field: &Field<'_, E>,
    sides: Sides,
    meeting: Point,
    [before, behind]: [Point; 2],
    bracket: f64,
) -> Result<Option<(Point, f64)>, E> {
    // Direction through the corner, and the direction to its left.
    let through = minus(unit(behind), unit(before));
    if length(through) < 1e-3 {
        return Ok(None);
    }
    let across = left_of(unit(through));
    let line = |x: f64| plus(meeting, x, across);
    let found = field.locate(&line, (0.0, 4.0 * bracket, 1e-7), sides, bracket)?;
    Ok(found
        .place()
        .map(|(x, accuracy)| (line(x), x.abs() + accuracy))
        .filter(|(_, off)| *off <= CORNER_TOLERANCE))
}
