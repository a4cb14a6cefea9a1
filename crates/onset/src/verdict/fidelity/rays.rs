//! Loss of stability along a ray.

use crate::algebra::sort_by_value;
use crate::verdict::boundary::{Boundary, Window, located_between};
use crate::verdict::{Phase, Probe};

/// First change along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RayOnset {
    /// The ray starts in an unstable state.
    AtStart,
    /// Stability is lost at this distance, in units of the ray's direction.
    At(f64),
    /// The method is not defined beyond this distance.
    Undefined(f64),
    /// The ray remains stable within the window.
    None,
}

/// Smallest distance of a crossing that is distinguished from the start, as a fraction of the window.
const START: f64 = 1e-5;
/// Distance from the end of a chord, as a fraction of the chord, at which a ray still crosses it.
const END_TOLERANCE: f64 = 1e-9;

/// First loss of stability along `origin + s direction`, `s > 0`.
///
/// It is found on the polygons of the boundary, then bracketed to `1e-13` of the window with the probe that traced them.
///
/// # Errors
/// Errors of the probe.
pub fn onset_along<E>(
    window: Window,
    boundary: &Boundary,
    probe: &(dyn Fn([f64; 2]) -> Result<Probe, E> + Sync),
    (origin, direction): ([f64; 2], [f64; 2]),
) -> Result<RayOnset, E> {
    let size = window.size();
    // Length of the window in units of the direction.
    let reach = size[0].max(size[1]) / direction[0].hypot(direction[1]);
    let at = |s: f64| [0, 1].map(|i| origin[i] + s * direction[i]);
    // Where the ray leaves the window.
    let exit = |i: usize| match direction[i] {
        0.0 => f64::INFINITY,
        d if d > 0.0 => (window.high[i] - origin[i]) / d,
        d => (window.low[i] - origin[i]) / d,
    };
    let exit = exit(0).min(exit(1));
    let mut crossings: Vec<(f64, Phase)> = Vec::new();
    for curve in &boundary.curves {
        for pair in curve.vertices.windows(2) {
            if let Some((s, is_leftward)) =
                crossing(origin, direction, pair[0].point, pair[1].point)
                && s > START * reach
            {
                // A crossing from the right side of a curve leads to its left.
                crossings.push((s, if is_leftward { curve.left } else { curve.right }));
            }
        }
    }
    sort_by_value(&mut crossings, |item| item.0);
    let Some(&(s, behind)) = crossings.first() else {
        let phase = probe(at(START * reach))?.0;
        return Ok(match phase {
            Phase::Stable => RayOnset::None,
            Phase::Undefined => RayOnset::Undefined(0.0),
            _ => RayOnset::AtStart,
        });
    };
    match behind {
        Phase::Stable => {
            let phase = probe(at(START * reach))?.0;
            Ok(if phase == Phase::Undefined {
                RayOnset::Undefined(0.0)
            } else {
                RayOnset::AtStart
            })
        }
        Phase::Undefined => Ok(RayOnset::Undefined(s)),
        _ => {
            let near = 2e-4 * reach;
            // Rounding may carry the exit out of the window.
            let end = at((s + near).min(exit));
            let end = [0, 1].map(|i| end[i].clamp(window.low[i], window.high[i]));
            let found = located_between(window, probe, at(s - near.min(0.5 * s)), end)?;
            let length = direction[0].hypot(direction[1]);
            let refined =
                found.map(|point| (point[0] - origin[0]).hypot(point[1] - origin[1]) / length);
            Ok(RayOnset::At(refined.unwrap_or(s)))
        }
    }
}

/// Parameter at which a ray crosses a chord, and whether the ray leads from the right of the chord to its left.
fn crossing(origin: [f64; 2], d: [f64; 2], a: [f64; 2], b: [f64; 2]) -> Option<(f64, bool)> {
    let e = [b[0] - a[0], b[1] - a[1]];
    let off = [a[0] - origin[0], a[1] - origin[1]];
    let determinant = d[0] * e[1] - d[1] * e[0];
    if determinant == 0.0 {
        return None;
    }
    let s = (off[0] * e[1] - off[1] * e[0]) / determinant;
    let t = (off[0] * d[1] - off[1] * d[0]) / determinant;
    // Points to the left of the chord satisfy `e x d > 0`. A curve that ends on the edge of the window is crossed at its end by a ray along the edge.
    ((-END_TOLERANCE..=1.0 + END_TOLERANCE).contains(&t) && s > 0.0)
        .then_some((s, determinant < 0.0))
}
