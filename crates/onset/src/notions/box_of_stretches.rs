//! The largest box of principal stretches in which a law is strongly elliptic.

use super::root::bracket_zero;
use super::{Measure, Notion, Range, State, Witness, is_isotropic};
use crate::kinematics::DeformationGradient;
use crate::material::Hyperelastic;

/// A box `[low, high]^3` of principal stretches in which a law is strongly elliptic, as far as a search can tell, and what ends it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafeBox {
    /// The smallest stretch.
    pub low: f64,
    /// The largest stretch.
    pub high: f64,
    /// The state on the surface of the box at which ellipticity is lost, and its wave; `None` where the box is as large as the range.
    pub critical: Option<([f64; 3], Witness)>,
}

/// Points along an edge of a face of the box from which rays are looked along.
const EDGE: usize = 11;
/// States looked at along a ray.
const ALONG: usize = 32;
/// The same for laws that are not isotropic, of which all faces are looked at and states cost more.
const EDGE_OF_ANY: usize = 7;
const ALONG_OF_ANY: usize = 20;
/// How many of the shortest rays are improved.
const IMPROVED: usize = 3;
/// Rays longer than the shortest one by this factor are of no interest.
const LONGER: f64 = 1.2;
/// Rays are turned until their step is below this, in units of the box.
const SMALLEST_TURN: f64 = 1e-11;
/// Width of the bracket of a loss along a ray, in units of the box.
const RESOLUTION: f64 = 1e-14;

/// The largest box `[h^-k, h]^3` of principal stretches within a range in which a law is strongly elliptic, with the exponent `k = skew`
/// (1 for a box that is symmetric in the logarithms). `None` where the law is not elliptic in the reference.
///
/// The principal axes are those of the coordinates; for an isotropic law ([`is_isotropic`]) that is no restriction. The box is found by a dense
/// search with local improvement, no proof: rays lead from the reference through points of a grid on the surface of the box to the first state at
/// which ellipticity is lost, and the shortest rays are turned until they are shortest.
///
/// ```
/// use onset::material::BlatzKo;
/// use onset::notions::{Range, safe_box};
/// // Blatz-Ko: elliptic while all ratios of stretches are below 2 + sqrt 3.
/// let safe = safe_box(&BlatzKo::default(), 1.0, &Range::default()).ok_or("not elliptic")?;
/// assert!((safe.high - (2.0 + 3.0_f64.sqrt()).sqrt()).abs() < 1e-10);
/// assert!((safe.low * safe.high - 1.0).abs() < 1e-14);
/// # Ok::<(), &str>(())
/// ```
pub fn safe_box(material: &dyn Hyperelastic, skew: f64, range: &Range) -> Option<SafeBox> {
    Field::new(material).safe_box(skew, range)
}

/// The widest box `[low, high]^3` within a range in which a law is strongly elliptic: the one with the largest `high / low` among boxes of all
/// skews that [`safe_box`] finds, refined beside the best of 9 skews. `None` where the law is not elliptic in the reference.
pub fn widest_safe_box(material: &dyn Hyperelastic, range: &Range) -> Option<SafeBox> {
    let field = Field::new(material);
    let at = |angle: f64| field.safe_box(angle.tan(), range);
    let width = |found: &SafeBox| (found.high / found.low).ln();
    let count = 9;
    let angle = |n: usize| std::f64::consts::FRAC_PI_2 * (n as f64 + 0.5) / count as f64;
    let boxes: Vec<SafeBox> = (0..count).map(|n| at(angle(n))).collect::<Option<_>>()?;
    let best = (0..count).max_by(|a, b| width(&boxes[*a]).total_cmp(&width(&boxes[*b])))?;
    // Golden section between the neighbors of the best one.
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (
        angle(best.saturating_sub(1)),
        angle((best + 1).min(count - 1)),
    );
    let mut widest = boxes[best];
    let (mut a, mut b) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut at_a, mut at_b) = (at(a)?, at(b)?);
    for _ in 0..30 {
        for found in [at_a, at_b] {
            if width(&found) > width(&widest) {
                widest = found;
            }
        }
        if width(&at_a) >= width(&at_b) {
            (high, b, at_b) = (b, a, at_a);
            a = high - ratio * (high - low);
            at_a = at(a)?;
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + ratio * (high - low);
            at_b = at(b)?;
        }
    }
    Some(widest)
}

/// Ellipticity over logarithms of principal stretches.
struct Field<'a> {
    material: &'a dyn Hyperelastic,
    isotropic: bool,
}

/// A box in logarithms of stretches, `[-low, high]^3`, and its size when it is as large as a range.
struct Shape {
    low: f64,
    high: f64,
}

impl<'a> Field<'a> {
    fn new(material: &'a dyn Hyperelastic) -> Self {
        Self {
            material,
            isotropic: is_isotropic(material),
        }
    }

    /// The measure at a state; `None` where the law is not defined.
    fn measure(&self, logarithms: [f64; 3]) -> Option<Measure> {
        let f = DeformationGradient::from_stretches(logarithms.map(f64::exp)).ok()?;
        let response = self.material.response(&f).ok()?;
        Notion::StrongEllipticity.measure(&State::of_response(response, self.isotropic))
    }

    /// A state that is not elliptic, or at which the law is not defined, has no positive value.
    fn value(&self, logarithms: [f64; 3]) -> f64 {
        self.measure(logarithms)
            .map_or(f64::NEG_INFINITY, |measure| measure.value)
    }

    fn safe_box(&self, skew: f64, range: &Range) -> Option<SafeBox> {
        if self.value([0.0; 3]) <= 0.0 {
            return None;
        }
        // The largest box of this shape within the range.
        let high = range.high().ln().min(-range.low().ln() / skew);
        let shape = Shape {
            low: skew * high,
            high,
        };
        let (edge, along) = match self.isotropic {
            true => (EDGE, ALONG),
            false => (EDGE_OF_ANY, ALONG_OF_ANY),
        };
        // Rays that are clearly longer than the shortest one so far are not followed to their end.
        let mut shortest = 1.0_f64;
        let mut rays: Vec<(f64, Point)> = Vec::new();
        for point in shape.surface(edge, self.isotropic) {
            if let Some(length) = self.loss(&shape, &point, along, LONGER * shortest) {
                shortest = shortest.min(length);
                rays.push((length, point));
            }
        }
        rays.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best: Option<(f64, Point)> = None;
        let mut tried: Vec<Point> = Vec::new();
        for (length, point) in rays {
            if tried.len() == IMPROVED {
                break;
            }
            if tried.iter().any(|other| other.is_beside(&point, edge)) {
                continue;
            }
            let improved = self.improved(&shape, (length, point), along, edge);
            tried.push(point);
            if best.is_none_or(|best| improved.0 < best.0) {
                best = Some(improved);
            }
        }
        let size = best.map_or(1.0, |(length, _)| length);
        Some(SafeBox {
            low: (-size * shape.low).exp(),
            high: (size * shape.high).exp(),
            critical: best.and_then(|(length, point)| self.critical(&shape, length, &point)),
        })
    }

    fn critical(&self, shape: &Shape, length: f64, point: &Point) -> Option<([f64; 3], Witness)> {
        let state = shape.state(point, length);
        let stretches = state.map(f64::exp);
        let witness = self.measure(state)?.witness;
        Some((stretches, witness))
    }

    /// The first place along a ray, as a part of the box up to `limit` (or the whole), at which ellipticity is lost.
    fn loss(&self, shape: &Shape, point: &Point, along: usize, limit: f64) -> Option<f64> {
        let mut value = |t: f64| Some(self.value(shape.state(point, t)));
        let mut before = (0.0, f64::INFINITY);
        for n in 1..=along {
            let t = limit.min(1.0).min(n as f64 / along as f64);
            if t <= before.0 {
                break;
            }
            let here = (t, self.value(shape.state(point, t)));
            if here.1 <= 0.0 {
                let ends = [before, here].map(|(t, value)| (t, value.clamp(-1e300, 1e300)));
                let (low, high) = bracket_zero(&mut value, ends[0], ends[1], RESOLUTION);
                return Some(0.5 * (low + high));
            }
            before = here;
        }
        None
    }

    /// A ray turned on its face until it is shortest.
    fn improved(
        &self,
        shape: &Shape,
        (mut length, mut point): (f64, Point),
        along: usize,
        edge: usize,
    ) -> (f64, Point) {
        let mut turn = 0.5 / (edge - 1) as f64;
        while turn > SMALLEST_TURN {
            let mut shorter = None;
            for (first, second) in [
                (turn, 0.0),
                (-turn, 0.0),
                (0.0, turn),
                (0.0, -turn),
                (turn, turn),
                (-turn, -turn),
                (turn, -turn),
                (-turn, turn),
            ] {
                let trial = point.turned(first, second);
                // Only a shorter ray is of interest, so no more of it is looked at.
                if trial == point || self.value(shape.state(&trial, length)) > 0.0 && turn < 1e-3 {
                    continue;
                }
                if let Some(found) = self.loss(shape, &trial, along, length)
                    && found < length
                {
                    shorter = Some((found, trial));
                    break;
                }
            }
            match shorter {
                Some(found) => (length, point) = found,
                None => turn *= 0.5,
            }
        }
        (length, point)
    }
}

/// A point on the surface of a box: one stretch is at an end, the two others are within.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    /// Which stretch is at an end.
    axis: usize,
    /// At the upper end.
    upper: bool,
    /// Where the others are between the lower end (0) and the upper end (1).
    within: [f64; 2],
}

impl Point {
    fn turned(&self, first: f64, second: f64) -> Self {
        Self {
            within: [
                (self.within[0] + first).clamp(0.0, 1.0),
                (self.within[1] + second).clamp(0.0, 1.0),
            ],
            ..*self
        }
    }

    /// Whether a point is a neighbor on the grid of the same face.
    fn is_beside(&self, other: &Self, edge: usize) -> bool {
        let near = 2.5 / (edge - 1) as f64;
        (self.axis, self.upper) == (other.axis, other.upper)
            && (0..2).all(|n| (self.within[n] - other.within[n]).abs() < near)
    }
}

impl Shape {
    /// A grid on the surface; of an isotropic law one of all orders of the stretches.
    fn surface(&self, edge: usize, isotropic: bool) -> Vec<Point> {
        let mut points = Vec::new();
        for axis in 0..if isotropic { 1 } else { 3 } {
            for upper in [false, true] {
                for first in 0..edge {
                    for second in 0..if isotropic { first + 1 } else { edge } {
                        let part = |n: usize| n as f64 / (edge - 1) as f64;
                        points.push(Point {
                            axis,
                            upper,
                            within: [part(first), part(second)],
                        });
                    }
                }
            }
        }
        points
    }

    /// The logarithms of the stretches on the ray through a point, at a part of its length.
    fn state(&self, point: &Point, part: f64) -> [f64; 3] {
        let inside = |t: f64| part * (t * self.high - (1.0 - t) * self.low);
        let mut state = [0.0; 3];
        state[point.axis] = inside(f64::from(u8::from(point.upper)));
        state[(point.axis + 1) % 3] = inside(point.within[0]);
        state[(point.axis + 2) % 3] = inside(point.within[1]);
        state
    }
}
