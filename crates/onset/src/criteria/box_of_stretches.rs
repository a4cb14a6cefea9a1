//! The largest box of principal stretches in which a law is strongly elliptic.

use super::root::bracket_zero;
use super::{Measure, Range, State, Witness, is_isotropic};
use crate::algebra::{Each, array_of, lowest_between, sort_by_value};
use crate::kinematics::DeformationGradient;
use crate::material::Hyperelastic;

/// A box `[low, high]^3` of principal stretches in which a law is strongly elliptic, as far as a search can tell, and what ends it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafeBox {
    /// The smallest stretch.
    pub low: f64,
    /// The largest stretch.
    pub high: f64,
    /// What keeps the smallest stretch from being smaller.
    pub low_end: BoxEnd,
    /// What keeps the largest stretch from being larger.
    pub high_end: BoxEnd,
    /// The state on the surface of the box that ends it; `None` where only the range does.
    pub critical: Option<Critical>,
}

/// A state on the surface of a box beyond which a law is not strongly elliptic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Critical {
    /// Its principal stretches.
    pub stretches: [f64; 3],
    /// The wave that stops there; `None` where the law itself is not defined beyond.
    pub witness: Option<Witness>,
}

/// What is at an end of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize),
    serde(rename_all = "kebab-case")
)]
pub enum BoxEnd {
    /// The end of the range.
    Range,
    /// The critical state has this stretch.
    Critical,
    /// The other end and the shape of the box.
    Shape,
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
/// Rays lead beyond the range by this factor: a loss between two of them can be nearer than on any of them.
const BEYOND: f64 = 1.25;
/// Points along an edge of the grids with which a box is checked inside, a coarse and a fine one; for laws that are not isotropic.
const CHECKS: [usize; 2] = [21, 41];
const CHECKS_OF_ANY: [usize; 2] = [9, 13];
/// How often a box is made smaller on a grid.
const SHRINKS: usize = 16;
/// Grid points with the lowest values that are descended from, besides all lowest among their neighbors.
const LOWEST: usize = 8;
/// Descents from a grid, at most.
const STARTS: usize = 24;
/// Descents stop at a state that is the lowest of all beside it and above zero by so many times the most that these are above it.
const FLAT: f64 = 8.0;
/// Descents within a box stop at this step, in units of the box.
const SMALLEST_STEP: f64 = 1e-7;
/// Skews that are tried for the widest box, before the best is refined to such an angle.
const SKEWS: usize = 17;
const REFINED: f64 = 1e-6;
/// A stretch this near to an end of a box, relative, is at it.
const AT_END: f64 = 1e-7;

/// The largest box `[h^-k, h]^3` of principal stretches within a range in which a law is strongly elliptic, with the exponent `k = skew`
/// (1 for a box that is symmetric in the logarithms). `None` where the law is not elliptic in the reference.
///
/// The principal axes are those of the coordinates; for an isotropic law ([`is_isotropic`]) that is no restriction. The box is found by a dense
/// search with local improvement, no proof: rays lead from the reference through points of a grid on the surface of the box to the first state at
/// which ellipticity is lost, and the shortest rays are turned until they are shortest. The box is then searched inside: from the low points of two
/// grids the measure is descended, and where it is not positive the box is made smaller.
///
/// ```
/// use onset::material::BlatzKo;
/// use onset::criteria::{Range, safe_box};
/// // Blatz-Ko: elliptic while all ratios of stretches are below 2 + sqrt 3.
/// let safe = safe_box(&BlatzKo::default(), 1.0, &Range::default()).ok_or("not elliptic")?;
/// assert!((safe.high - (2.0 + 3.0_f64.sqrt()).sqrt()).abs() < 1e-10);
/// assert!((safe.low * safe.high - 1.0).abs() < 1e-14);
/// # Ok::<(), &str>(())
/// ```
pub fn safe_box(material: &dyn Hyperelastic, skew: f64, range: &Range) -> Option<SafeBox> {
    Field::new(material).safe_box(skew.atan(), range, true)
}

/// The widest box `[low, high]^3` within a range in which a law is strongly elliptic: the one with the largest `high / low` among boxes of all
/// skews that [`safe_box`] finds, those that begin or end at the reference among them, refined beside the best of 19 skews; boxes that reach the
/// ends of the range are looked at too. `None` where the law is not elliptic in the reference.
pub fn widest_safe_box(material: &dyn Hyperelastic, range: &Range) -> Option<SafeBox> {
    let field = Field::new(material);
    let width = |found: &SafeBox| (found.high / found.low).ln();
    let mut widest: Option<(f64, SafeBox)> = None;
    let mut at = |angle: f64| -> Option<f64> {
        let found = field.safe_box(angle, range, false)?;
        if widest.is_none_or(|(_, best)| width(&found) > width(&best)) {
            widest = Some((angle, found));
        }
        Some(width(&found))
    };
    // The skew is the tangent of an angle; at its ends the box reaches to one side of the reference only.
    let end = std::f64::consts::FRAC_PI_2;
    let step = end / SKEWS as f64;
    let angle = |n: usize| (step * (n as f64 - 0.5)).clamp(0.0, end);
    let widths: Vec<f64> = (0..SKEWS + 2)
        .map(|n| at(angle(n)))
        .collect::<Option<_>>()?;
    let best = (0..SKEWS + 2).max_by(|a, b| widths[*a].total_cmp(&widths[*b]))?;
    // Between the neighbors of the best one.
    let around = [best.saturating_sub(1), best, best + 1].each(angle);
    let narrowness = |angle: f64| at(angle).map(|width| -width).ok_or(());
    lowest_between(narrowness, around, -widths[best], REFINED).ok()?;
    // Boxes that reach an end of the range, or both.
    let (_, found) = widest?;
    let mut at = |angle: f64| {
        let found = field.safe_box(angle, range, false)?;
        // The same width to rounding, at a proper end, is preferred.
        if widest.is_none_or(|(_, best)| width(&found) > width(&best) - AT_END) {
            widest = Some((angle, found));
        }
        Some(())
    };
    let angle_of = |low: f64, high: f64| (-low.ln()).max(0.0).atan2(high.ln().max(0.0));
    // Boxes a little too large for the range beside the end tell where the other end is exactly.
    let nudge = 1e-3;
    let beside_low = angle_of(range.low().powf(1.0 - nudge), found.high);
    let beside_high = angle_of(found.low.powf(1.0 + nudge), range.high());
    let high = field.safe_box(beside_low, range, false)?.high;
    let low = field.safe_box(beside_high, range, false)?.low;
    for (low, high) in [
        (low, range.high()),
        (range.low(), high),
        (range.low(), range.high()),
    ] {
        at(angle_of(low, high))?;
    }
    let (angle, _) = widest?;
    field.safe_box(angle, range, true)
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
        // Where it is positive, how much of it is left guides the search only.
        Some(State::of_response(response, self.isotropic).strong_ellipticity(0.0))
    }

    /// A state that is not elliptic, or at which the law is not defined, has no positive value.
    fn value(&self, logarithms: [f64; 3]) -> f64 {
        self.measure(logarithms)
            .map_or(f64::NEG_INFINITY, |measure| measure.value)
    }

    /// The box whose skew is the tangent of an angle.
    fn safe_box(&self, angle: f64, range: &Range, checked: bool) -> Option<SafeBox> {
        if !self.measure([0.0; 3])?.holds() {
            return None;
        }
        // The largest box of this shape within the range.
        let (low, high) = angle.sin_cos();
        let size = (range.high().ln() / high).min(-range.low().ln() / low);
        let shape = Shape {
            low: size * low,
            high: size * high,
        };
        let mut best = self
            .shortest(&shape)
            .filter(|(length, _)| *length < 1.0 + AT_END);
        if checked {
            for count in self.either(CHECKS, CHECKS_OF_ANY) {
                for _ in 0..SHRINKS {
                    let size = best.map_or(1.0, |(length, _)| length.min(1.0));
                    let Some(found) = self.inside(&shape, size, count) else {
                        break;
                    };
                    best = Some(found);
                    if found.0 > size * (1.0 - 1e-12) {
                        break;
                    }
                }
            }
        }
        let size = best.map_or(1.0, |(length, _)| length.min(1.0));
        let [low, high] = [-size * shape.low, size * shape.high].map(f64::exp);
        let critical = best.map(|(length, point)| self.critical(&shape, length, &point));
        let end = |own: f64, limit: f64| {
            let near = |stretch: f64| (stretch / own - 1.0).abs() < AT_END;
            match critical {
                _ if near(limit) => BoxEnd::Range,
                Some(critical) if critical.stretches.into_iter().any(near) => BoxEnd::Critical,
                _ => BoxEnd::Shape,
            }
        };
        Some(SafeBox {
            low,
            high,
            low_end: end(low, range.low()),
            high_end: end(high, range.high()),
            critical,
        })
    }

    fn either<T>(&self, of_isotropic: T, of_any: T) -> T {
        match self.isotropic {
            true => of_isotropic,
            false => of_any,
        }
    }

    /// The shortest ray to a loss, with its length in units of the box, as far as a little beyond the box.
    fn shortest(&self, shape: &Shape) -> Option<(f64, Point)> {
        let (edge, along) = self.either((EDGE, ALONG), (EDGE_OF_ANY, ALONG_OF_ANY));
        // Rays that are clearly longer than the shortest one so far are not followed to their end.
        let mut shortest = BEYOND;
        let mut rays: Vec<(f64, Point)> = Vec::new();
        for point in shape.surface(edge, self.isotropic) {
            if let Some(length) = self.loss(shape, &point, along, LONGER * shortest) {
                shortest = shortest.min(length);
                rays.push((length, point));
            }
        }
        sort_by_value(&mut rays, |item| item.0);
        let mut best: Option<(f64, Point)> = None;
        let mut tried: Vec<Point> = Vec::new();
        for (length, point) in rays {
            if tried.len() == IMPROVED {
                break;
            }
            if tried.iter().any(|other| other.is_beside(&point, edge)) {
                continue;
            }
            let improved = self.improved(shape, (length, point), along, edge);
            tried.push(point);
            if best.is_none_or(|best| improved.0 < best.0) {
                best = Some(improved);
            }
        }
        best
    }

    /// A ray within a box to a loss that a descent from low points of a grid finds, turned until it is shortest.
    fn inside(&self, shape: &Shape, size: f64, count: usize) -> Option<(f64, Point)> {
        let (edge, along) = self.either((EDGE, ALONG), (EDGE_OF_ANY, ALONG_OF_ANY));
        let within = Grid::new(count, self.isotropic, |place| {
            self.value(shape.inside(place, size))
        });
        let first = 0.5 / (count - 1) as f64;
        let mut ends = Vec::new();
        for start in within.low_points() {
            let (value, place) = self.descended(shape, size, start, first, &ends);
            if value > 0.0 {
                ends.push(place);
                continue;
            }
            let (length, point) = shape.ray(shape.inside(place, size));
            if let Some(length) = self.loss(shape, &point, along, length.min(size)) {
                return Some(self.improved(shape, (length, point), along, edge));
            }
        }
        None
    }

    /// From a place in a box down to one at which ellipticity is lost, or as far as it goes: to a lowest value, or near the end of an
    /// earlier descent.
    fn descended(
        &self,
        shape: &Shape,
        size: f64,
        start: [f64; 3],
        first: f64,
        ends: &[[f64; 3]],
    ) -> (f64, [f64; 3]) {
        let value = |place: &[f64; 3]| self.value(shape.inside(*place, size));
        let mut step = first;
        let mut walk = Walk::new((value(&start), start));
        while walk.value > 0.0 && step >= SMALLEST_STEP {
            let is_near = |end: &[f64; 3]| (0..3).all(|i| (end[i] - walk.place[i]).abs() < step);
            if step < first && ends.iter().any(is_near) {
                break;
            }
            let mut lowest = (walk.value, walk.place);
            let mut rise: f64 = 0.0;
            for direction in 0..27 {
                let turn = [1, 3, 9].each(|digit| f64::from(direction / digit % 3 - 1) * step);
                let trial = moved(&walk.place, turn);
                let found = value(&trial);
                rise = rise.max(found - walk.value);
                if found < lowest.0 {
                    lowest = (found, trial);
                }
            }
            if lowest.0 < walk.value {
                walk.go(lowest, |trial, least| {
                    Some(value(trial)).filter(|value| *value < least)
                });
            } else if step < first && walk.value > FLAT * rise {
                // A smooth measure falls between near states by less than it rises around them.
                break;
            } else {
                step *= 0.5;
            }
        }
        (walk.value, walk.place)
    }

    fn critical(&self, shape: &Shape, length: f64, point: &Point) -> Critical {
        let beyond = self.measure(shape.state(point, length + 4.0 * RESOLUTION));
        let state = shape.state(point, length);
        Critical {
            stretches: state.map(f64::exp),
            witness: beyond
                .filter(|measure| measure.value.is_finite())
                .map(|measure| measure.witness),
        }
    }

    /// The last place along a ray, as a part of the box up to `limit`, before ellipticity is lost.
    fn loss(&self, shape: &Shape, point: &Point, along: usize, limit: f64) -> Option<f64> {
        let mut value = |t: f64| Some(self.value(shape.state(point, t)));
        let mut before = (0.0, f64::INFINITY);
        for n in 1..=along {
            let t = limit.min(BEYOND * n as f64 / along as f64);
            if t <= before.0 {
                break;
            }
            let here = (t, self.value(shape.state(point, t)));
            if here.1 <= 0.0 {
                let ends = [before, here].each(|(t, value)| (t, value.clamp(-1e300, 1e300)));
                let (low, _) = bracket_zero(&mut value, ends[0], ends[1], RESOLUTION);
                return Some(low);
            }
            before = here;
        }
        None
    }

    /// A ray turned on its face until it is shortest.
    fn improved(
        &self,
        shape: &Shape,
        (length, point): (f64, Point),
        along: usize,
        edge: usize,
    ) -> (f64, Point) {
        let mut turn = 0.5 / (edge - 1) as f64;
        let mut walk = Walk::new((length, point.within));
        while turn > SMALLEST_TURN {
            let shorter = |within: &[f64; 2], length: f64| {
                let trial = Point {
                    within: *within,
                    ..point
                };
                // Only a shorter ray is of interest, so no more of it is looked at.
                if turn < 1e-3 && self.value(shape.state(&trial, length)) > 0.0 {
                    return None;
                }
                let found = self.loss(shape, &trial, along, length);
                found.filter(|found| *found < length)
            };
            let directions = [
                [1.0, 0.0],
                [-1.0, 0.0],
                [0.0, 1.0],
                [0.0, -1.0],
                [1.0, 1.0],
                [-1.0, -1.0],
                [1.0, -1.0],
                [-1.0, 1.0],
            ];
            let found = directions.iter().find_map(|direction| {
                let trial = moved(&walk.place, direction.each(|x| x * turn));
                (trial != walk.place)
                    .then(|| shorter(&trial, walk.value))
                    .flatten()
                    .map(|length| (length, trial))
            });
            match found {
                Some(found) => walk.go(found, shorter),
                None => turn *= 0.5,
            }
        }
        let point = Point {
            within: walk.place,
            ..point
        };
        (walk.value, point)
    }
}

/// A search for a lowest value by steps in a unit cube (R. Hooke and T. A. Jeeves, *J. ACM* 8 (1961) 212).
struct Walk<const N: usize> {
    value: f64,
    place: [f64; N],
    /// The last two places.
    before: [[f64; N]; 2],
}

impl<const N: usize> Walk<N> {
    fn new((value, place): (f64, [f64; N])) -> Self {
        Self {
            value,
            place,
            before: [place; 2],
        }
    }

    /// A step down, and on along the last two steps as long as that is `lower`: a narrow valley is along none of the directions in
    /// which steps are tried, but along two of them together.
    fn go(
        &mut self,
        (value, place): (f64, [f64; N]),
        lower: impl Fn(&[f64; N], f64) -> Option<f64>,
    ) {
        (self.value, self.place) = (value, place);
        let mut along: [f64; N] = array_of(|i| place[i] - self.before[0][i]);
        self.before = [self.before[1], place];
        loop {
            let trial = moved(&self.place, along);
            if trial == self.place {
                break;
            }
            let Some(value) = lower(&trial, self.value) else {
                break;
            };
            (self.value, self.place) = (value, trial);
            along = along.each(|step| 2.0 * step);
        }
    }
}

/// A place of the unit cube after a step, which ends at the faces.
fn moved<const N: usize>(place: &[f64; N], step: [f64; N]) -> [f64; N] {
    array_of(|i| (place[i] + step[i]).clamp(0.0, 1.0))
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

    /// The logarithms of the stretches at a place between the lower ends (0) and the upper ends (1) of a part of the box.
    fn inside(&self, place: [f64; 3], part: f64) -> [f64; 3] {
        place.each(|t| part * (t * self.high - (1.0 - t) * self.low))
    }

    /// The ray through a state, with the length at which it is there.
    fn ray(&self, state: [f64; 3]) -> (f64, Point) {
        let parts = state.each(|x| {
            if x > 0.0 {
                x / self.high
            } else {
                -x / self.low
            }
        });
        let longest = |best: usize, axis: usize| {
            if parts[axis] > parts[best] {
                axis
            } else {
                best
            }
        };
        let axis = (1..3).fold(0, longest);
        let length = parts[axis];
        let within = |axis: usize| {
            let place = (state[axis] / length + self.low) / (self.high + self.low);
            place.clamp(0.0, 1.0)
        };
        let point = Point {
            axis,
            upper: state[axis] > 0.0,
            within: [within((axis + 1) % 3), within((axis + 2) % 3)],
        };
        (length, point)
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

/// Values on a grid over a cube of places from 0 to 1.
struct Grid {
    count: usize,
    isotropic: bool,
    values: Vec<f64>,
}

impl Grid {
    /// Of an isotropic law one of all orders is evaluated.
    fn new(count: usize, isotropic: bool, value: impl Fn([f64; 3]) -> f64) -> Self {
        let mut grid = Self {
            count,
            isotropic,
            values: vec![0.0; count.pow(3)],
        };
        for n in 0..grid.values.len() {
            let indices = grid.indices(n);
            let mut ordered = indices;
            if isotropic {
                ordered.sort_unstable();
                ordered.reverse();
            }
            // The ordered one comes first, by its largest index in the lowest digit, or is the same.
            grid.values[n] = match ordered == indices {
                true => value(grid.place(indices)),
                false => grid.values[grid.number(ordered)],
            };
        }
        grid
    }

    fn indices(&self, n: usize) -> [usize; 3] {
        let count = self.count;
        [n % count, n / count % count, n / count / count]
    }

    fn number(&self, indices: [usize; 3]) -> usize {
        (indices[2] * self.count + indices[1]) * self.count + indices[0]
    }

    fn place(&self, indices: [usize; 3]) -> [f64; 3] {
        indices.each(|index| index as f64 / (self.count - 1) as f64)
    }

    /// Places that are not above their neighbors, and the lowest of all; lowest first.
    fn low_points(&self) -> Vec<[f64; 3]> {
        let mut order: Vec<usize> = (0..self.values.len())
            .filter(|n| !self.isotropic || self.indices(*n).is_sorted_by(|a, b| a >= b))
            .collect();
        sort_by_value(&mut order, |n| self.values[*n]);
        order
            .iter()
            .enumerate()
            .filter(|(rank, n)| *rank < LOWEST || self.is_low(**n))
            .take(STARTS)
            .map(|(_, n)| self.place(self.indices(*n)))
            .collect()
    }

    fn is_low(&self, n: usize) -> bool {
        let indices = self.indices(n);
        (0..3).all(|axis| {
            let mut neighbors = [indices; 2];
            neighbors[0][axis] = indices[axis].saturating_sub(1);
            neighbors[1][axis] = (indices[axis] + 1).min(self.count - 1);
            neighbors
                .into_iter()
                .all(|other| self.values[n] <= self.values[self.number(other)])
        })
    }
}
