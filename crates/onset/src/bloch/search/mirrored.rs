//! The search over the zone of a matrix with a mirror line.
//!
//! The spectrum is computed at a quarter of the zone's wave vectors, the measure that is scaled by the lattice Laplacian,
//! which need not have the mirror, at each and at its image. Wells of all objectives are found in one pass over a few lines
//! of the grid at a time, and followed to their bottoms several at once by Newton's method with exact derivatives.

use super::descent::{newton_step, principal};
use super::{Objective, RAY};
use crate::algebra::{Each, Pack, WIDEST, array_of, sines_and_cosines, sort_by_value};
use crate::bloch::branches::{Branches, Taylor};
use crate::bloch::mirror::{LANES, MirrorSums};
use crate::lattice::{BravaisLattice, FILL, Group, Mirror, MirrorWaves};
use nalgebra::{Matrix2, Vector2};
use pulp::{Arch, Simd, WithSimd};

/// Points of the grid per period of the fastest phase.
const DENSITY: usize = 12;
/// Multiples of the phases along the mirror lines below which none is taken to end: the scaled measure varies by itself.
const LEAST_REACH: usize = 3;
/// Wells that are followed to their bottom, deepest first.
const WELLS: usize = 12;
/// Steps of Newton's method.
const STEPS: usize = 24;
/// A step that is shorter than this over the fastest multiple of a phase leaves an error below rounding.
const SHORT: f64 = 2e-4;
/// A well is a valley when its curvatures differ by this factor.
const SHALLOW: f64 = 0.3;
/// How far along a valley others are looked for, in phases.
const ALONG_VALLEY: f64 = 0.4;
/// Below these phases a wave counts as long, which the limit covers.
const LONG_WAVE: f64 = 5e-3;
/// Steps of the grid around the origin from which a descent towards it is not followed, and within which the discriminant,
/// which vanishes there with the fourth power, is not sought.
const NEAR: f64 = 1.5;
const FLAT: f64 = 0.5;
/// Descents from around a bottom that come as near to it, in phases, lead nowhere else.
const SAME: f64 = 0.03;

/// What is sought on the grid, in the order in which it lies in memory.
const SOUGHT: [(Objective, bool); 5] = [
    (Objective::Scaled, false),
    (Objective::Scaled, true),
    (Objective::Lowest, false),
    (Objective::Highest, false),
    (Objective::Discriminant, false),
];

/// `|k|_h^2` in the phases along the mirror lines.
#[derive(Clone, Copy)]
struct Laplacian {
    /// `1 / |a_n|^2` and the factors of `u` and `v` in `k.a_n`.
    vectors: [(f64, [f64; 2]); 2],
}

impl Laplacian {
    fn new<const D: usize>(lattice: &BravaisLattice<D>, mirror: &Mirror) -> Self {
        let vector = |n: usize| {
            let weight = 1.0 / lattice.vectors().column(n).norm_squared();
            let factor = |uv: [f64; 2]| mirror.phases(uv)[n];
            (weight, [factor([1.0, 0.0]), factor([0.0, 1.0])])
        };
        Self {
            vectors: [vector(0), vector(1)],
        }
    }

    fn at(&self, [u, v]: [f64; 2]) -> Taylor<f64, 2> {
        let [(_, a), (_, b)] = &self.vectors;
        let halves = [0.5 * (a[0] * u + a[1] * v), 0.5 * (b[0] * u + b[1] * v)];
        let (sines, cosines) = sines_and_cosines(&halves);
        let mut sum = Taylor::ZERO;
        for n in 0..2 {
            let (weight, factors) = self.vectors[n];
            let (sine, cosine) = (sines[n], cosines[n]);
            sum.value += 4.0 * weight * sine * sine;
            let curvature = 2.0 * weight * (cosine * cosine - sine * sine);
            for a in 0..2 {
                sum.gradient[a] += 4.0 * weight * sine * cosine * factors[a];
                for b in 0..2 {
                    sum.hessian[a][b] += curvature * factors[a] * factors[b];
                }
            }
        }
        sum
    }
}

/// A search of one objective, with the value below which its minimum matters; omega^2 without the scale `c^2`.
#[derive(Clone, Copy)]
pub(super) struct Request {
    pub(super) objective: Objective,
    pub(super) floor: f64,
}

/// A local minimum of the grid.
struct Well {
    objective: Objective,
    /// The lowest that it is expected to reach, and its phases after a step to the bottom of a paraboloid.
    bound: f64,
    value: f64,
    place: [f64; 2],
}

/// On its way to the bottom of a well.
struct Descent {
    objective: Objective,
    place: [f64; 2],
    /// The last place that was lower than all before, and the step from there.
    last: [f64; 2],
    step: [f64; 2],
    value: f64,
    /// A known bottom of the same valley.
    bottom: Option<[f64; 2]>,
    /// Whether it has ended in a valley or near a crossing of branches, where the grid does not tell all wells.
    is_intricate: bool,
    state: State,
}

#[derive(Clone, Copy, PartialEq)]
enum State {
    Running,
    /// In a smooth minimum, which is a valley along a direction or not.
    Settled(Option<[f64; 2]>),
    /// On its way to one that is not low enough.
    Left,
    /// Newton's method does not lead down.
    Lost,
}

/// Steps of a grid along the mirror lines that is fine enough for the range of the force constants.
pub(super) fn intervals(sums: &MirrorSums) -> [usize; 2] {
    let [u, v] = sums.effective_reach().each(|reach| reach.max(LEAST_REACH));
    // A half of the period of u, of a centered rectangle a quarter.
    let part = if sums.mirror.is_centered() { 4 } else { 2 };
    [(DENSITY * u).div_ceil(part), (DENSITY * v).div_ceil(2)]
}

/// The search of one matrix.
pub(super) struct Mirrored<'a> {
    sums: &'a MirrorSums,
    waves: &'a MirrorWaves,
    laplacian: Laplacian,
    wells: Vec<Well>,
    /// Minus the largest `Re omega^2` of the grid.
    pub(super) lowest: f64,
    /// Rounding error of the discriminant, negative.
    rounding: f64,
}

impl<'a> Mirrored<'a> {
    /// Sweeps over the grid: all wells of the objectives that may reach below the floors.
    pub(super) fn new<const D: usize>(
        lattice: &BravaisLattice<D>,
        sums: &'a MirrorSums,
        waves: &'a MirrorWaves,
        requests: &[Request],
        noise: f64,
    ) -> Self {
        let floor = |objective| {
            let request = requests
                .iter()
                .find(|request| request.objective == objective);
            request.map_or(f64::NEG_INFINITY, |request| request.floor)
        };
        let mut sweep = Sweep {
            sums,
            waves,
            floors: SOUGHT.each(|(objective, _)| floor(objective)),
            wells: Vec::with_capacity(16),
            lowest: 0.0,
        };
        Arch::new().dispatch(Sweeping(&mut sweep));
        let Sweep {
            mut wells, lowest, ..
        } = sweep;
        sort_by_value(&mut wells, |well| well.value);
        Self {
            sums,
            waves,
            laplacian: Laplacian::new(lattice, &waves.mirror),
            wells,
            lowest,
            rounding: noise * lowest,
        }
    }

    /// The phases along the mirror lines of a step of the grid in a direction that is given by the phases of the primitive
    /// vectors.
    pub(super) fn step_along(&self, phases: [f64; 2]) -> [f64; 2] {
        let along = self.waves.mirror.along(phases);
        let [a, b] = [0, 1].each(|axis| along[axis].abs() / self.waves.steps[axis]);
        along.each(|x| x / a.max(b))
    }

    /// Where the minima of the requested objectives are, with their values as far as fast sums tell them; none where the
    /// floor is not reached. The last value tells whether Newton's method has done it.
    pub(super) fn bottoms(&self, requests: &[Request], soft: [f64; 2]) -> Vec<Bottom> {
        let mut descents = Vec::with_capacity(16);
        for request in requests {
            self.start(request, soft, &mut descents);
        }
        self.descend(&mut descents, requests);
        // Near a crossing of branches, and along a shallow valley, there can be several bottoms within a step of the grid,
        // which then sees one.
        let mut others = Vec::new();
        for request in requests {
            if let Some(best) = lowest_of(&descents, request.objective)
                && request.objective != Objective::Discriminant
                && best.is_intricate
            {
                self.look_around(best, &mut others);
            }
        }
        // Pockets of complex branches lie along the valleys of the discriminant, on which branches nearly cross.
        let is_valley = |descent: &&Descent| {
            let is_sought = descent.objective == Objective::Discriminant;
            is_sought && matches!(descent.state, State::Settled(Some(_)))
        };
        for best in descents.iter().filter(is_valley) {
            if let State::Settled(Some(along)) = best.state {
                for step in [-2.0, -1.0, 1.0, 2.0] {
                    let length = step * self.waves.steps[0].max(self.waves.steps[1]);
                    let place = [0, 1].each(|n| best.place[n] + length * along[n]);
                    others.push(Descent {
                        bottom: Some(best.place),
                        ..Descent::from(Objective::Discriminant, place)
                    });
                }
            }
        }
        let bests: Vec<Request> = requests
            .iter()
            .map(|request| Request {
                floor: lowest_of(&descents, request.objective)
                    .map_or(request.floor, |best| best.value),
                ..*request
            })
            .collect();
        self.descend(&mut others, &bests);
        descents.append(&mut others);
        // Where branches are complex they grow fastest elsewhere than where the discriminant is lowest.
        let is_complex = |descent: &&Descent| {
            descent.objective == Objective::Discriminant && descent.value < self.rounding
        };
        let mut growing: Vec<Descent> = descents
            .iter()
            .filter(is_complex)
            .map(|descent| Descent::from(Objective::Growth, descent.place))
            .collect();
        self.descend(&mut growing, &[]);
        descents.append(&mut growing);
        let bottoms = descents.iter().filter_map(|descent| match descent.state {
            State::Left | State::Running => None,
            _ => Some(Bottom {
                objective: descent.objective,
                value: descent.value,
                phases: self.waves.mirror.phases(descent.place),
                is_settled: descent.state != State::Lost,
            }),
        });
        bottoms.collect()
    }

    /// Descents from around a bottom.
    fn look_around(&self, best: &Descent, others: &mut Vec<Descent>) {
        let mut start = |offset: [f64; 2]| {
            others.push(Descent {
                bottom: Some(best.place),
                ..Descent::from(best.objective, [0, 1].each(|n| best.place[n] + offset[n]))
            });
        };
        let [u, v] = self.waves.steps;
        for (i, j) in [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (-1.0, 1.0)] {
            start([i * u, j * v]);
            start([-i * u, -j * v]);
        }
        if let State::Settled(Some(along)) = best.state {
            start(along.each(|x| ALONG_VALLEY * x));
            start(along.each(|x| -ALONG_VALLEY * x));
        }
    }

    /// The starts of the descents for one objective.
    fn start(&self, request: &Request, soft: [f64; 2], descents: &mut Vec<Descent>) {
        let own = || {
            self.wells
                .iter()
                .filter(|well| well.objective == request.objective)
        };
        let best = own()
            .next()
            .map_or(request.floor, |well| request.floor.min(well.value));
        for well in own().filter(|well| well.bound <= best).take(WELLS) {
            descents.push(Descent::from(request.objective, well.place));
        }
        if !is_of_lowest_branch(request.objective) {
            return;
        }
        // Between the origin and the first points of the grid, along the softest of the long waves, a well may be too narrow
        // in angle for the grid. What falls on beyond is seen from there.
        let places = RAY.each(|step| soft.each(|x| x * step));
        let (mut u, mut v) = ([0.0; LANES], [0.0; LANES]);
        for (lane, place) in places.iter().enumerate() {
            [u[lane], v[lane]] = *place;
        }
        let branches = self.sums.branches(places.len(), &u, &v);
        let ray: [f64; RAY.len()] = array_of(|lane| {
            self.objective(request.objective, &branches.of(lane), places[lane])
                .value
        });
        let is_dip = |n: &usize| (*n == 0 || ray[n - 1] >= ray[*n]) && ray[n + 1] >= ray[*n];
        if let Some(n) = (0..RAY.len() - 1).find(is_dip) {
            descents.push(Descent::from(request.objective, places[n]));
        }
    }

    /// Follows descents to their ends, several at once.
    fn descend(&self, descents: &mut [Descent], requests: &[Request]) {
        let mut floors = Floors::new(requests, descents);
        let mut running = Vec::with_capacity(descents.len());
        for _ in 0..STEPS {
            running.clear();
            running.extend((0..descents.len()).filter(|n| descents[*n].state == State::Running));
            if running.is_empty() {
                return;
            }
            for chunk in running.chunks(LANES) {
                let (mut u, mut v) = ([0.0; LANES], [0.0; LANES]);
                for (lane, n) in chunk.iter().enumerate() {
                    [u[lane], v[lane]] = descents[*n].place;
                }
                let branches = self.sums.branches(chunk.len(), &u, &v);
                for (lane, n) in chunk.iter().enumerate() {
                    let (descent, here) = (&mut descents[*n], branches.of(lane));
                    let taylor = self.objective(descent.objective, &here, descent.place);
                    descent.proceed(&taylor, floors.of(descent.objective), self);
                    floors.lower(descent);
                    if let State::Settled(valley) = descent.state {
                        descent.is_intricate =
                            valley.is_some() || self.is_near_crossing(&here.discriminant);
                    }
                }
            }
        }
    }

    /// Whether the discriminant may vanish within two steps of the grid.
    fn is_near_crossing(&self, p: &Taylor<f64, 2>) -> bool {
        let along = |axis: usize| {
            let step = 2.0 * self.waves.steps[axis];
            step * p.gradient[axis].abs() + 0.5 * step * step * p.hessian[axis][axis].abs()
        };
        p.value < along(0) + along(1)
    }

    /// How many steps of the grid a place is from the origin.
    fn steps_from_origin(&self, place: [f64; 2]) -> f64 {
        let [u, v] = self.waves.steps;
        (place[0].abs() / u).max(place[1].abs() / v)
    }

    /// An objective with its derivatives by the phases; infinite for waves that are too long to be sought.
    fn objective(&self, objective: Objective, d: &Branches<2>, place: [f64; 2]) -> Taylor<f64, 2> {
        match objective {
            Objective::Highest => d.branch(1.0).times_number(-1.0),
            Objective::Lowest => d.branch(-1.0),
            Objective::Growth => d.negative_square_of_growth(),
            Objective::Discriminant if self.steps_from_origin(place) < FLAT => Taylor::INFINITE,
            Objective::Discriminant => d.discriminant,
            Objective::Scaled => {
                let laplacian = self.laplacian.at(place);
                if laplacian.value < LONG_WAVE * LONG_WAVE * self.laplacian.vectors[0].0 {
                    Taylor::INFINITE
                } else {
                    d.branch(-1.0).over(&laplacian)
                }
            }
        }
    }
}

/// What descents have to get below: the floor of the search, and what others have reached; of the discriminant, all of
/// whose wells are wanted, the former alone.
struct Floors([f64; 5]);

impl Floors {
    fn new(requests: &[Request], descents: &[Descent]) -> Self {
        let mut floors = Self([f64::INFINITY; 5]);
        for request in requests {
            let floor = &mut floors.0[request.objective as usize];
            *floor = floor.min(request.floor);
        }
        for descent in descents {
            floors.lower(descent);
        }
        floors
    }

    fn of(&self, objective: Objective) -> f64 {
        self.0[objective as usize]
    }

    fn lower(&mut self, descent: &Descent) {
        if descent.objective != Objective::Discriminant {
            let floor = &mut self.0[descent.objective as usize];
            *floor = floor.min(descent.value);
        }
    }
}

/// Where a descent has ended.
pub(super) struct Bottom {
    pub(super) objective: Objective,
    /// By fast sums; of the scaled measure without `c^2`.
    pub(super) value: f64,
    /// The phases of the primitive vectors.
    pub(super) phases: [f64; 2],
    /// Whether Newton's method has ended in a smooth minimum.
    pub(super) is_settled: bool,
}

fn is_of_lowest_branch(objective: Objective) -> bool {
    matches!(objective, Objective::Scaled | Objective::Lowest)
}

fn lowest_of(descents: &[Descent], objective: Objective) -> Option<&Descent> {
    let own = descents
        .iter()
        .filter(|descent| descent.objective == objective);
    own.filter(|descent| matches!(descent.state, State::Settled(_)))
        .min_by(|a, b| a.value.total_cmp(&b.value))
}

impl Descent {
    fn from(objective: Objective, place: [f64; 2]) -> Self {
        Self {
            objective,
            place,
            last: place,
            step: [0.0; 2],
            value: f64::INFINITY,
            bottom: None,
            is_intricate: false,
            state: State::Running,
        }
    }

    /// A step of Newton's method with what is known of the place reached, back towards the last one if that was lower.
    fn proceed(&mut self, here: &Taylor<f64, 2>, floor: f64, search: &Mirrored) {
        let reach = search.sums.reach;
        let length =
            |step: [f64; 2]| (step[0].abs() * reach[0] as f64).max(step[1].abs() * reach[1] as f64);
        if here.value == f64::INFINITY && search.steps_from_origin(self.last) < NEAR {
            self.state = State::Left;
            return;
        }
        if here.value.is_nan() || here.value >= self.value {
            self.step = [0.25 * self.step[0], 0.25 * self.step[1]];
            if length(self.step) < SHORT {
                // The value is that of the last place.
                self.place = self.last;
                self.state = State::Lost;
            } else {
                self.place = [self.last[0] + self.step[0], self.last[1] + self.step[1]];
            }
            return;
        }
        self.value = here.value;
        self.last = self.place;
        if !here.is_finite() {
            self.state = State::Lost;
            return;
        }
        let (slope, curvature) = (here.slope(), here.curvature());
        // Steps are at most a tenth of what is given: a step of the grid.
        let [u, v] = search.waves.steps;
        let (step, is_convex) = newton_step(&slope, &curvature, 10.0 * u.max(v));
        let decrease = -(slope[0] * step[0] + slope[1] * step[1]);
        self.step = [step[0], step[1]];
        self.place = [self.last[0] + step[0], self.last[1] + step[1]];
        if !is_convex {
            return;
        }
        let is_near = |bottom: [f64; 2]| (0..2).all(|n| (bottom[n] - self.place[n]).abs() < SAME);
        let is_known = self.bottom.is_some_and(is_near);
        let is_too_high = self.value - 4.0 * decrease > floor;
        if length(self.step) < SHORT || decrease <= 1e-14 * self.value.abs() {
            self.value -= 0.5 * decrease;
            self.state = State::Settled(valley(&curvature));
        } else if is_known || is_too_high {
            self.state = State::Left;
        }
    }
}

/// The direction of a valley, where curvatures differ much.
fn valley(curvature: &Matrix2<f64>) -> Option<[f64; 2]> {
    let ([high, low], [_, along]) = principal(curvature);
    (low.abs() < SHALLOW * high.abs()).then_some([along[0], along[1]])
}

/// A pass over the grid.
struct Sweep<'a> {
    sums: &'a MirrorSums,
    waves: &'a MirrorWaves,
    floors: [f64; 5],
    wells: Vec<Well>,
    lowest: f64,
}

/// Work for the widest vectors of the machine.
struct Sweeping<'a, 'b>(&'b mut Sweep<'a>);

impl WithSimd for Sweeping<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.0.run(simd);
    }
}

impl Sweep<'_> {
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S) {
        let groups = self.waves.groups();
        let mut rows = vec![[[0.0; FILL]; 4]; groups * (self.sums.reach[1] + 1)];
        let [cosines, sines] = &self.waves.along;
        self.sums.rows(simd, [cosines, sines], &mut rows);
        // The values of the objectives on the last three lines.
        let size = SOUGHT.len() * groups;
        // What is looked at beside the last column of all does not count.
        let mut ring = vec![[0.0; FILL]; 3 * size + 1];
        for line in 0..self.waves.lines() {
            self.fill(simd, line, &rows, &mut ring[line % 3 * size..][..size]);
            if line >= 2 {
                self.find(simd, line - 1, ring.as_flattened());
            }
        }
    }

    /// The objectives on a line.
    #[inline(always)]
    fn fill<S: Simd>(&self, simd: S, line: usize, rows: &[[Group; 4]], values: &mut [Group]) {
        let groups = self.waves.groups();
        let lines = self.waves.lines();
        let [own, image] = &self.waves.inverse_laplacian;
        let [cosines, sines] = &self.waves.across;
        let (zero, number) = (Pack::splat(simd, 0.0), Pack::splat(simd, 0.5));
        for group in 0..groups {
            for part in 0..FILL / S::F64_LANES {
                let mut d = [zero; 4];
                for j in 0..=self.sums.reach[1] {
                    let row = &rows[j * groups + group];
                    let cosine = zero.constant(cosines[j * lines + line]);
                    let sine = zero.constant(sines[j * lines + line]);
                    d[0] = Pack::of(simd, &row[0], part).times_plus(cosine, d[0]);
                    d[1] = Pack::of(simd, &row[1], part).times_plus(sine, d[1]);
                    d[2] = Pack::of(simd, &row[2], part).times_plus(sine, d[2]);
                    d[3] = Pack::of(simd, &row[3], part).times_plus(cosine, d[3]);
                }
                let mean = (d[0] + d[3]) * number;
                let half = (d[0] - d[3]) * number;
                let p = half.times_plus(half, d[1] * d[2]);
                let root = p.max(zero).sqrt();
                let low = mean - root;
                let place = line * groups + group;
                let sought = [
                    low * Pack::of(simd, &own[place], part),
                    low * Pack::of(simd, &image[place], part),
                    low,
                    -(mean + root),
                    p,
                ];
                for number in 0..SOUGHT.len() {
                    sought[number].write(&mut values[number * groups + group], part);
                }
            }
        }
        if line == 1 {
            // Long waves are taken to their limit elsewhere.
            for number in 0..SOUGHT.len() {
                values[number * groups][1] = f64::INFINITY;
            }
        }
    }

    /// The wells on a line with those before and behind it.
    #[inline(always)]
    fn find<S: Simd>(&mut self, simd: S, line: usize, ring: &[f64]) {
        let width = self.waves.width;
        let size = SOUGHT.len() * width;
        let [last_column, last_line] = self.waves.intervals.each(|n| n + 1);
        for number in 0..SOUGHT.len() {
            let (objective, is_image) = SOUGHT[number];
            // On mirror lines the image is the wave itself.
            if is_image && (line == 1 || line == last_line) {
                continue;
            }
            let lines = [line + 2, line, line + 1]
                .each(|line| &ring[line % 3 * size + number * width..][..width + 2]);
            for group in 0..width / S::F64_LANES {
                let around = lowest_around(simd, &lines, group);
                let here = Pack::of(simd, &lines[1][1..=width], group);
                if !here.is_at_most(around).any() {
                    continue;
                }
                let mut lowest = [0.0; WIDEST];
                around.write(&mut lowest[..S::F64_LANES], 0);
                for lane in 0..S::F64_LANES {
                    let n = group * S::F64_LANES + lane + 1;
                    let is_own = n <= last_column && !(is_image && n == 1);
                    if !is_own || lines[1][n] > lowest[lane] || lines[1][n].is_nan() {
                        continue;
                    }
                    if objective == Objective::Highest {
                        self.lowest = self.lowest.min(lines[1][n]);
                    }
                    self.record(objective, is_image, [n, line], lines, self.floors[number]);
                }
            }
        }
    }

    /// Notes a well of the grid, unless it is not going to reach below the floor.
    fn record(
        &mut self,
        objective: Objective,
        is_image: bool,
        at: [usize; 2],
        lines: [&[f64]; 3],
        floor: f64,
    ) {
        let n = at[0];
        let three = |line: &[f64]| [line[n - 1], line[n], line[n + 1]];
        let [a, b, c] = [three(lines[0]), three(lines[1]), three(lines[2])];
        let value = b[1];
        let mut highest = value;
        for x in [a, b, c].as_flattened() {
            if x.is_finite() {
                highest = highest.max(*x);
            }
        }
        let bound = value - (highest - value);
        if bound > floor || !value.is_finite() {
            return;
        }
        let steps = self.waves.steps;
        let mut place = [
            (at[0] as f64 - 1.0) * steps[0],
            (at[1] as f64 - 1.0) * steps[1],
        ];
        // To the bottom of the paraboloid through the points around.
        let slope = Vector2::new(0.5 * (b[2] - b[0]), 0.5 * (c[1] - a[1]));
        let mixed = 0.25 * (c[2] - c[0] - a[2] + a[0]);
        let curvature = Matrix2::new(
            b[2] + b[0] - 2.0 * value,
            mixed,
            mixed,
            c[1] + a[1] - 2.0 * value,
        );
        let determinant = curvature.determinant();
        if determinant > 0.0 && determinant.is_finite() {
            let step = [
                (mixed * slope.y - curvature.m22 * slope.x) / determinant,
                (mixed * slope.x - curvature.m11 * slope.y) / determinant,
            ];
            for axis in 0..2 {
                place[axis] += step[axis].clamp(-1.0, 1.0) * steps[axis];
            }
        }
        if is_image {
            place[1] = -place[1];
        }
        self.wells.push(Well {
            objective,
            bound,
            value,
            place,
        });
    }
}

/// The lowest of the eight points around each point of a group on the second of three lines, its first point left out.
#[inline(always)]
fn lowest_around<S: Simd>(simd: S, lines: &[&[f64]; 3], group: usize) -> Pack<S> {
    let width = lines[1].len() - 2;
    let mut lowest = Pack::of(simd, &lines[1][..width], group);
    lowest = lowest.min(Pack::of(simd, &lines[1][2..], group));
    for line in [lines[0], lines[2]] {
        for shift in 0..3 {
            lowest = lowest.min(Pack::of(simd, &line[shift..][..width], group));
        }
    }
    lowest
}
