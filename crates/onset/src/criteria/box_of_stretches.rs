//! Largest box of principal stretches in which a law is strongly elliptic.

use super::root::bracket_zero;
use super::{Measure, Range, State, Witness, is_isotropic};
use crate::algebra::{Each, array_of, lowest_between, sort_by_value};
use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, Response};

/// Box `[low, high]^3` of principal stretches in which a search finds no loss of strong ellipticity, with the state that limits it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SafeBox {
    /// Smallest principal stretch of the box.
    pub low: f64,
    /// Largest principal stretch of the box.
    pub high: f64,
    /// Limit that keeps `low` from being smaller.
    pub low_end: BoxEnd,
    /// Limit that keeps `high` from being larger.
    pub high_end: BoxEnd,
    /// State on the surface of the box that limits it; `None` if only the range limits it.
    pub critical: Option<Critical>,
}

/// State on the surface of a box of stretches at which strong ellipticity is about to be lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Critical {
    /// Principal stretches of the state.
    pub stretches: [f64; 3],
    /// Wave whose speed vanishes in the state; `None` if the law itself is not defined beyond the state.
    pub witness: Option<Witness>,
}

/// Limit of a box of stretches at one of its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize),
    serde(rename_all = "kebab-case")
)]
pub enum BoxEnd {
    /// The end of the range of stretches.
    Range,
    /// The critical state: one of its principal stretches equals this end.
    Critical,
    /// The opposite end: the critical state limits it, and the shape of the box fixes this end.
    Shape,
}

/// Grid points along an edge of a face of the box; a ray from the reference configuration leads through each of them.
const EDGE_POINTS: usize = 11;
/// States evaluated along a ray.
const STATES_PER_RAY: usize = 32;
/// Edge points and states per ray for laws that are not isotropic, for which all faces are searched and a state is more expensive.
const EDGE_POINTS_ANISOTROPIC: usize = 7;
const STATES_PER_RAY_ANISOTROPIC: usize = 20;
/// Number of the shortest rays that are improved.
const IMPROVED_RAYS: usize = 3;
/// Largest ratio of the length of a ray to the shortest length at which the ray is followed.
const FOLLOWED_LENGTH_RATIO: f64 = 1.2;
/// Smallest step of the rotation of rays, in units of the box.
const SMALLEST_TURN: f64 = 1e-11;
/// Width of the bracket of a loss of ellipticity along a ray, in units of the box.
const RESOLUTION: f64 = 1e-14;
/// Length of the rays relative to the range. Rays extend beyond it, because a loss between two rays can be nearer than the losses on them.
const RAY_END: f64 = 1.25;
/// Points along an edge of the coarse and the fine grid that check the inside of a box.
const CHECK_GRIDS: [usize; 2] = [21, 41];
const CHECK_GRIDS_ANISOTROPIC: [usize; 2] = [9, 13];
/// Largest number of times that a box is shrunk on one grid.
const SHRINKS: usize = 16;
/// Number of distances from a dilation, each half of the distance before, at which a law that flows is evaluated.
const HALVINGS_TO_DILATION: i32 = 14;
/// Number of lowest grid points that start a descent, in addition to all local minima of the grid.
const LOWEST: usize = 8;
/// Largest number of descents from a grid.
const STARTS: usize = 24;
/// Descents stop at a local minimum whose value exceeds this multiple of the largest rise to its neighbors.
const STOP_RISE_RATIO: f64 = 8.0;
/// Descents within a box stop at this step, in units of the box.
const SMALLEST_STEP: f64 = 1e-7;
/// Number of skews tried for the widest box; the best skew is then refined to the angle below.
const SKEWS: usize = 17;
const SKEW_ANGLE_TOLERANCE: f64 = 1e-6;
/// Largest relative distance from an end of a box at which a stretch counts as lying at the end.
const AT_END: f64 = 1e-7;

/// Returns the largest box `[h^-k, h]^3` of principal stretches within a range in which a law is strongly elliptic.
///
/// The exponent `k = skew` is 1 for a box that is symmetric in the logarithms. The result is `None` if the law is not elliptic in the reference
/// configuration.
///
/// The principal axes are the coordinate axes, which is not a restriction for an isotropic law ([`is_isotropic`]). The box results from a dense
/// search with local improvement and is not proved. Rays from the reference configuration through grid points on the surface of the box are followed
/// to the first loss of ellipticity, and the shortest rays are rotated until they are locally shortest. The inside of the box is then searched: the
/// measure is minimized from the low points of two grids, and the box is shrunk where the measure is not positive.
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

/// Returns the widest box `[low, high]^3` of principal stretches within a range in which a law is strongly elliptic.
///
/// It has the largest `high / low` among the boxes of all skews that [`safe_box`] finds, including boxes that begin or end at stretch 1. The best
/// of 19 skews is refined locally, and boxes that reach the ends of the range are tried as well. The result is `None` if the law is not elliptic in
/// the reference configuration.
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
    // The skew is the tangent of an angle. At the extreme angles the box extends to one side of the reference configuration only.
    let end = std::f64::consts::FRAC_PI_2;
    let step = end / SKEWS as f64;
    let angle = |n: usize| (step * (n as f64 - 0.5)).clamp(0.0, end);
    let widths: Vec<f64> = (0..SKEWS + 2)
        .map(|n| at(angle(n)))
        .collect::<Option<_>>()?;
    let best = (0..SKEWS + 2).max_by(|a, b| widths[*a].total_cmp(&widths[*b]))?;
    // Refine between the neighbors of the best angle.
    let around = [best.saturating_sub(1), best, best + 1].each(angle);
    let narrowness = |angle: f64| at(angle).map(|width| -width).ok_or(());
    lowest_between(narrowness, around, -widths[best], SKEW_ANGLE_TOLERANCE).ok()?;
    // Try boxes that reach one end of the range or both.
    let (_, found) = widest?;
    let mut at = |angle: f64| {
        let found = field.safe_box(angle, range, false)?;
        // Among boxes of equal width to rounding, prefer a box that reaches an end of the range.
        if widest.is_none_or(|(_, best)| width(&found) > width(&best) - AT_END) {
            widest = Some((angle, found));
        }
        Some(())
    };
    let angle_of = |low: f64, high: f64| (-low.ln()).max(0.0).atan2(high.ln().max(0.0));
    // A box slightly too large for the range at one end locates the other end exactly.
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

/// Measure of strong ellipticity as a function of the logarithms of the principal stretches.
struct Field<'a> {
    material: &'a dyn Hyperelastic,
    isotropic: bool,
}

/// Box `[-low, high]^3` of logarithmic stretches, as large as the range permits.
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

    /// Measure at a state; `None` if the law is not defined there.
    fn measure(&self, logarithms: [f64; 3]) -> Option<Measure> {
        let f = DeformationGradient::from_stretches(logarithms.map(f64::exp)).ok()?;
        Some(self.measure_of(self.material.response(&f).ok()?))
    }

    fn measure_of(&self, response: Response) -> Measure {
        // The magnitude of a positive value only guides the search.
        State::of_response(response, self.isotropic).strong_ellipticity(0.0)
    }

    /// Value of the measure, minus infinity if the law is not defined at the state.
    fn value(&self, logarithms: [f64; 3]) -> f64 {
        value_of(self.measure(logarithms))
    }

    /// Value of the measure along the ray through a point of the surface, as a function of the distance in units of the box.
    fn ray(&self, shape: &Shape, point: &Point) -> impl FnMut(f64) -> f64 {
        let mut response = self.material.along(shape.state(point, 1.0));
        move |t| value_of(response(t).map(|response| self.measure_of(response)))
    }

    /// Returns the largest box whose skew is the tangent of `angle`; its inside is searched if `checked`.
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
            for count in self.either(CHECK_GRIDS, CHECK_GRIDS_ANISOTROPIC) {
                let mut beside: Option<Vec<(f64, [f64; 3])>> = None;
                for _ in 0..SHRINKS {
                    let size = best.map_or(1.0, |(length, _)| length.min(1.0));
                    let beside =
                        beside.get_or_insert_with(|| self.beside_dilations(&shape, size, count));
                    let Some(found) = self.inside(&shape, size, count, beside) else {
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

    /// Returns the shortest ray to a loss of ellipticity and its length in units of the box. Losses beyond `RAY_END` are ignored.
    fn shortest(&self, shape: &Shape) -> Option<(f64, Point)> {
        let (edge, along) = self.either(
            (EDGE_POINTS, STATES_PER_RAY),
            (EDGE_POINTS_ANISOTROPIC, STATES_PER_RAY_ANISOTROPIC),
        );
        // Rays that are clearly longer than the shortest one found before are not followed to their end.
        let mut shortest = RAY_END;
        let mut rays: Vec<(f64, Point)> = Vec::new();
        for point in shape.surface(edge, self.isotropic) {
            let limit = FOLLOWED_LENGTH_RATIO * shortest;
            if let Some(length) = loss(&mut self.ray(shape, &point), along, limit) {
                shortest = shortest.min(length);
                rays.push((length, point));
            }
        }
        sort_by_value(&mut rays, |item| item.0);
        let mut best: Option<(f64, Point)> = None;
        let mut tried: Vec<Point> = Vec::new();
        for (length, point) in rays {
            if tried.len() == IMPROVED_RAYS {
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

    /// Returns the locally shortest ray to a loss inside the box, found by descents from the low points of a grid and of the states `beside` dilations.
    fn inside(
        &self,
        shape: &Shape,
        size: f64,
        count: usize,
        beside: &[(f64, [f64; 3])],
    ) -> Option<(f64, Point)> {
        let (edge, along) = self.either(
            (EDGE_POINTS, STATES_PER_RAY),
            (EDGE_POINTS_ANISOTROPIC, STATES_PER_RAY_ANISOTROPIC),
        );
        let within = Grid::new(count, self.isotropic, |place| {
            self.value(shape.inside(place, size))
        });
        let first = 0.5 / (count - 1) as f64;
        let mut ends = Vec::new();
        let beside = beside
            .iter()
            .map(|(value, state)| (*value, shape.place(*state, size)));
        let beside =
            beside.filter(|(_, place)| place.iter().all(|t| (t - 0.5).abs() < 0.5 + AT_END));
        let beside = beside.min_by(|a, b| a.0.total_cmp(&b.0));
        let beside = beside.map(|(_, place)| place.each(|t: f64| t.clamp(0.0, 1.0)));
        for start in beside.into_iter().chain(within.low_points()) {
            let (value, place) = self.descended(shape, size, start, first, &ends);
            if value > 0.0 {
                ends.push(place);
                continue;
            }
            let (length, point) = shape.ray(shape.inside(place, size));
            if let Some(length) = loss(&mut self.ray(shape, &point), along, length.min(size)) {
                return Some(self.improved(shape, (length, point), along, edge));
            }
        }
        None
    }

    /// Returns logarithmic stretches near dilations with their values, for a law that flows. A dilation is elastic, and flow begins at a small distance from it,
    /// where the measure jumps down: the shell of these states is thinner than the cells of a grid.
    fn beside_dilations(&self, shape: &Shape, size: f64, count: usize) -> Vec<(f64, [f64; 3])> {
        let mut found = Vec::new();
        if !self.material.is_path_dependent() {
            return found;
        }
        for n in 0..count {
            let dilation = [n as f64 / (count - 1) as f64; 3];
            for halvings in 0..HALVINGS_TO_DILATION {
                let distance = 0.5_f64.powi(halvings) / (count - 1) as f64;
                for (axis, sense) in self
                    .either(&[0][..], &[0, 1, 2][..])
                    .iter()
                    .flat_map(|axis| [(*axis, -1.0), (*axis, 1.0)])
                {
                    // Distances from an end of the box lead inward.
                    let mut place = dilation;
                    place[axis] += sense * distance;
                    if !(0.0..=1.0).contains(&place[axis]) {
                        continue;
                    }
                    let state = shape.inside(place, size);
                    found.push((self.value(state), state));
                }
            }
        }
        found
    }

    /// Minimizes the measure within a box from `start`. Stops at a loss of ellipticity, at a local minimum or near the end of an earlier descent.
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
            } else if step < first && walk.value > STOP_RISE_RATIO * rise {
                // The value is large relative to the variation between neighbors: no zero is near.
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

    /// Rotates a ray on its face of the box until it is locally shortest.
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
                // Only a shorter ray is an improvement, so the ray is not followed any further.
                let mut ray = self.ray(shape, &trial);
                if turn < 1e-3 && ray(length) > 0.0 {
                    return None;
                }
                let found = loss(&mut ray, along, length);
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

/// Value of a measure; minus infinity if the law is not defined. A value that is zero to rounding counts as positive: if the stiffness against
/// changes of volume is huge at large strain, the sign of the softest shear would be determined by rounding alone.
fn value_of(measure: Option<Measure>) -> f64 {
    measure.map_or(f64::NEG_INFINITY, |measure| measure.value + measure.zero)
}

/// Last point along a ray, in units of the box and at most `limit`, before ellipticity is lost.
fn loss(ray: &mut impl FnMut(f64) -> f64, along: usize, limit: f64) -> Option<f64> {
    let mut before = (0.0, f64::INFINITY);
    for n in 1..=along {
        let t = limit.min(RAY_END * n as f64 / along as f64);
        if t <= before.0 {
            break;
        }
        let here = (t, ray(t));
        if here.1 <= 0.0 {
            let ends = [before, here].each(|(t, value)| (t, value.clamp(-1e300, 1e300)));
            let mut value = |t: f64| Some(ray(t));
            let (low, _) = bracket_zero(&mut value, ends[0], ends[1], RESOLUTION);
            return Some(low);
        }
        before = here;
    }
    None
}

/// Pattern search for a minimum in the unit cube (R. Hooke and T. A. Jeeves, *J. ACM* 8 (1961) 212).
struct Walk<const N: usize> {
    value: f64,
    place: [f64; N],
    /// The last two points.
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

    /// Performs a step down and extrapolates the last two steps while the value is `lower`. A narrow valley is not parallel to any of the trial
    /// directions, only to a combination of two of them.
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

/// Point after a step, clamped to the unit cube.
fn moved<const N: usize>(place: &[f64; N], step: [f64; N]) -> [f64; N] {
    array_of(|i| (place[i] + step[i]).clamp(0.0, 1.0))
}

/// Point on the surface of a box: one stretch is at an end of the box, the two others lie between its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Point {
    /// Index of the stretch that is at an end.
    axis: usize,
    /// Whether this stretch is at the upper end.
    upper: bool,
    /// Positions of the two other stretches between the lower end (0) and the upper end (1).
    within: [f64; 2],
}

impl Point {
    /// Returns true if two points are neighbors on the grid of one face.
    fn is_beside(&self, other: &Self, edge: usize) -> bool {
        let near = 2.5 / (edge - 1) as f64;
        (self.axis, self.upper) == (other.axis, other.upper)
            && (0..2).all(|n| (self.within[n] - other.within[n]).abs() < near)
    }
}

impl Shape {
    /// Grid points on the surface. For an isotropic law only one of each set of permuted stretches is included.
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

    /// Logarithmic stretches at a point of the unit cube, where 0 is the lower end and 1 the upper end of the scaled box.
    fn inside(&self, place: [f64; 3], part: f64) -> [f64; 3] {
        place.each(|t| part * (t * self.high - (1.0 - t) * self.low))
    }

    /// Point of the unit cube of a scaled box at logarithmic stretches, the inverse of [`Self::inside`].
    fn place(&self, state: [f64; 3], part: f64) -> [f64; 3] {
        state.each(|x| (x / part + self.low) / (self.high + self.low))
    }

    /// Ray through a state, with the distance of the state along it in units of the box.
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

    /// Logarithmic stretches at a distance along a ray, in units of the box.
    fn state(&self, point: &Point, part: f64) -> [f64; 3] {
        let inside = |t: f64| part * (t * self.high - (1.0 - t) * self.low);
        let mut state = [0.0; 3];
        state[point.axis] = inside(f64::from(u8::from(point.upper)));
        state[(point.axis + 1) % 3] = inside(point.within[0]);
        state[(point.axis + 2) % 3] = inside(point.within[1]);
        state
    }
}

/// Values on a grid over the unit cube.
struct Grid {
    count: usize,
    isotropic: bool,
    values: Vec<f64>,
}

impl Grid {
    /// Evaluates the grid. For an isotropic law only one of each set of permuted points is evaluated.
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
            // The sorted place precedes its permutations, because its largest index is the lowest digit.
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

    /// Points with values no higher than the values of their neighbors, and the lowest of all points, sorted by value.
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
