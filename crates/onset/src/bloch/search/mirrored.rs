//! Search over the zone of a planar matrix with a mirror line.
//!
//! The spectrum is computed at a quarter of the wave vectors of the zone. The lattice Laplacian need not have the mirror symmetry, so that the scaled
//! measure is computed at each wave vector and at its image. A single pass over the grid, a few lines at a time, finds the wells of all objectives.
//! Newton's method with exact derivatives then follows several wells simultaneously in the lanes of a vector register (`steps`).

use super::descent::{first_dip, newton_step, principal};
use super::steps::{Places, Stepper, Steps};
use super::{Objective, RAY_STEPS};
use crate::algebra::{Each, LARGEST_LANES, Pack, sort_by_value};
use crate::bloch::mirror::{LANES, MirrorSums};
use crate::lattice::{BravaisLattice, FILL, Group, MirrorWaves};
use nalgebra::{Matrix2, Vector2};
use pulp::{Arch, Simd, WithSimd};
use std::sync::Arc;

/// Grid points per period of the fastest phase.
const POINTS_PER_PERIOD: usize = 12;
/// Smallest number of multiples of the phases along the mirror lines for which the grid is designed; the lattice Laplacian itself varies with the
/// phases.
const MINIMUM_REACH: usize = 3;
/// Maximum number of wells that are followed to their bottoms, deepest first.
const FOLLOWED_WELLS: usize = 12;
/// Maximum number of Newton steps.
const NEWTON_STEPS: usize = 24;
/// Phase of a converged Newton step, in the fastest multiple of a phase: the remaining error of the value is below rounding.
const STEP_TOLERANCE_PHASE: f64 = 2e-4;
/// Largest ratio of the smallest to the largest curvature of a valley. A heuristic value.
const VALLEY_CURVATURE_RATIO: f64 = 0.3;
/// Distance along a valley, as a phase, at which other bottoms are searched for.
const VALLEY_OFFSET_PHASE: f64 = 0.4;
/// Distance from the origin, in grid steps, within which a descent towards the origin is abandoned.
const ORIGIN_RANGE_STEPS: f64 = 1.5;
/// Phase difference from a known bottom within which a descent from its neighborhood is abandoned.
const KNOWN_BOTTOM_PHASE: f64 = 0.03;

/// Objectives on the grid in their order in memory, and whether they belong to the mirror image.
const OBJECTIVES: [(Objective, bool); 5] = [
    (Objective::Scaled, false),
    (Objective::Scaled, true),
    (Objective::Lowest, false),
    (Objective::Highest, false),
    (Objective::Discriminant, false),
];

/// Index of the lowest real branch among the objectives.
const LOWEST: usize = 2;
/// Index of the highest real branch among the objectives.
const HIGHEST: usize = 3;
const _: () = assert!(matches!(OBJECTIVES[LOWEST], (Objective::Lowest, false)));
const _: () = assert!(matches!(OBJECTIVES[HIGHEST], (Objective::Highest, false)));
/// Both objectives of the lowest branch are evaluated together along the ray of soft long waves.
const _: () = assert!(2 * RAY_STEPS.len() <= LANES);

/// Search for one objective, with a floor: minima above the floor are irrelevant. The scaled measure lacks the factor `1 / c^2`.
#[derive(Clone, Copy)]
pub(super) struct Request {
    pub(super) objective: Objective,
    pub(super) floor: f64,
}

/// Local minimum on the grid.
struct Well {
    objective: Objective,
    /// Square of the largest growth rate of complex branches that is expected nearby; infinite for other objectives.
    growth_squared: f64,
    /// Lowest expected value, the grid value, and the phases after a step to the bottom of a paraboloid.
    bound: f64,
    value: f64,
    place: [f64; 2],
}

/// State of a descent to the bottom of a well.
struct Descent {
    objective: Objective,
    place: [f64; 2],
    /// Last position that was lower than all earlier positions, and the step from it.
    last: [f64; 2],
    step: [f64; 2],
    value: f64,
    /// Known bottom of the same valley.
    bottom: Option<[f64; 2]>,
    /// True if the descent ended in a valley or near a crossing of branches, where the grid can miss wells.
    is_intricate: bool,
    state: State,
}

#[derive(Clone, Copy, PartialEq)]
enum State {
    Running,
    /// The descent ended in a smooth minimum, with its direction if it is a valley.
    Settled(Option<[f64; 2]>),
    /// The descent was abandoned because its minimum is too high.
    Left,
    /// Newton's method does not descend.
    Lost,
}

/// Numbers of grid intervals along the mirror lines, fine enough for the range of the force constants.
pub(super) fn intervals(sums: &MirrorSums) -> [usize; 2] {
    let [u, v] = sums
        .effective_reach()
        .each(|reach| reach.max(MINIMUM_REACH));
    // Half of the period of `u`; a quarter for a centered rectangle.
    let part = if sums.mirror.is_centered() { 4 } else { 2 };
    [
        (POINTS_PER_PERIOD * u).div_ceil(part),
        (POINTS_PER_PERIOD * v).div_ceil(2),
    ]
}

/// Search for one matrix.
pub(super) struct Mirrored {
    sums: MirrorSums,
    waves: Arc<MirrorWaves>,
    stepper: Stepper,
    wells: Vec<Well>,
    /// Phases along the mirror lines of one grid step along the softest long wave.
    soft: [f64; 2],
    /// Negative of the largest `Re omega^2` on the grid.
    lowest: f64,
    /// Rounding error of the discriminant, negative.
    rounding: f64,
    /// Ends of the completed descents.
    pub(super) bottoms: Vec<Bottom>,
}

impl Mirrored {
    /// Sweeps over the grid and finds all wells whose bottoms may lie below the floors of the requests. `soft` contains the phases of the primitive
    /// vectors in the softest long wave.
    pub(super) fn new<const D: usize>(
        lattice: &BravaisLattice<D>,
        sums: MirrorSums,
        waves: Arc<MirrorWaves>,
        requests: &[Request],
        noise: f64,
        soft: [f64; 2],
    ) -> Self {
        let floor = |objective| {
            let request = requests
                .iter()
                .find(|request| request.objective == objective);
            request.map_or(f64::NEG_INFINITY, |request| request.floor)
        };
        let mut sweep = Sweep {
            sums: &sums,
            waves: &waves,
            floors: OBJECTIVES.each(|(objective, _)| floor(objective)),
            wells: Vec::with_capacity(16),
            lowest: 0.0,
        };
        Arch::new().dispatch(Sweeping(&mut sweep));
        let Sweep {
            mut wells, lowest, ..
        } = sweep;
        sort_by_value(&mut wells, |well| well.value);
        let along = waves.mirror.along(soft);
        let [a, b] = [0, 1].each(|axis| along[axis].abs() / waves.steps[axis]);
        Self {
            stepper: Stepper::new(lattice, &waves),
            soft: along.each(|x| x / a.max(b)),
            sums,
            waves,
            wells,
            lowest,
            rounding: noise * lowest,
            bottoms: Vec::new(),
        }
    }

    /// Largest `Re omega^2` on the grid.
    pub(super) fn largest(&self) -> f64 {
        -self.lowest
    }

    /// Follows the wells of real objectives whose minima may be lower than their floors. The values of the bottoms come from fast sums.
    pub(super) fn follow(&mut self, requests: &[Request]) {
        let mut descents = self.along_soft(requests);
        for request in requests {
            self.start(request, 0.0, &mut descents);
        }
        self.descend(&mut descents, requests);
        // Near a crossing of branches, and along a shallow valley, several bottoms can lie within one grid step.
        let mut others = Vec::new();
        let mut bests = requests.to_vec();
        for request in &mut bests {
            if let Some(best) = lowest_of(&descents, request.objective) {
                request.floor = best.value;
                if best.is_intricate {
                    self.look_around(best, &mut others);
                }
            }
        }
        self.descend(&mut others, &bests);
        self.keep(&descents);
        self.keep(&others);
    }

    /// Follows the wells of the discriminant and the pockets of complex branches, except where the growth rate is less than half of the rival's rate.
    pub(super) fn follow_flutter(&mut self, rival: f64) {
        let request = Request {
            objective: Objective::Discriminant,
            floor: 0.0,
        };
        let mut descents = Vec::new();
        self.start(&request, 0.25 * rival * rival, &mut descents);
        self.descend(&mut descents, &[request]);
        // Pockets of complex branches lie along the valleys of the discriminant, where branches nearly cross.
        let length = self.waves.steps[0].max(self.waves.steps[1]);
        let beside = descents.iter().flat_map(|best| {
            let along = match best.state {
                State::Settled(along) => along,
                _ => None,
            };
            let steps = [-2.0, -1.0, 1.0, 2.0].into_iter();
            let places = along.map(|along| {
                steps.map(move |step| [0, 1].each(|n| best.place[n] + step * length * along[n]))
            });
            places.into_iter().flatten().map(|place| Descent {
                bottom: Some(best.place),
                ..Descent::from(Objective::Discriminant, place)
            })
        });
        let mut others: Vec<Descent> = beside.collect();
        let best = lowest_of(&descents, Objective::Discriminant);
        let floor = best.map_or(0.0, |best| best.value);
        self.descend(&mut others, &[Request { floor, ..request }]);
        descents.append(&mut others);
        // The growth rate of complex branches has its maximum away from the minimum of the discriminant.
        let is_complex = |descent: &&Descent| descent.value < self.rounding;
        let mut growing: Vec<Descent> = descents
            .iter()
            .filter(is_complex)
            .map(|descent| Descent::from(Objective::Growth, descent.place))
            .collect();
        self.descend(&mut growing, &[]);
        self.keep(&descents);
        self.keep(&growing);
    }

    /// Records the ends of descents.
    fn keep(&mut self, descents: &[Descent]) {
        let bottoms = descents.iter().filter_map(|descent| match descent.state {
            State::Left | State::Running => None,
            _ => Some(Bottom {
                objective: descent.objective,
                value: descent.value,
                phases: self.waves.mirror.phases(descent.place),
                is_settled: descent.state != State::Lost,
            }),
        });
        self.bottoms.extend(bottoms);
    }

    /// Starts descents around a bottom.
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
            start(along.each(|x| VALLEY_OFFSET_PHASE * x));
            start(along.each(|x| -VALLEY_OFFSET_PHASE * x));
        }
    }

    /// Starts descents for one objective from the wells of the grid. For the discriminant, only from wells in which the growth rate squared can reach
    /// `growth_squared`.
    fn start(&self, request: &Request, growth_squared: f64, descents: &mut Vec<Descent>) {
        let own = || {
            let wells = self.wells.iter();
            wells.filter(|well| {
                well.objective == request.objective && well.growth_squared >= growth_squared
            })
        };
        let best = own()
            .next()
            .map_or(request.floor, |well| request.floor.min(well.value));
        for well in own().filter(|well| well.bound <= best).take(FOLLOWED_WELLS) {
            descents.push(Descent::from(request.objective, well.place));
        }
    }

    /// Starts between the origin and the first grid points, along the softest long wave, where a well may be too narrow in angle for the grid.
    fn along_soft(&self, requests: &[Request]) -> Vec<Descent> {
        let mut descents = Vec::with_capacity(16);
        let objectives = requests.iter().map(|request| request.objective);
        let objectives: Vec<Objective> =
            objectives.filter(|own| is_of_lowest_branch(*own)).collect();
        let place = |n: usize| self.soft.each(|x| x * RAY_STEPS[n]);
        let places = || (0..RAY_STEPS.len()).map(place);
        let all = objectives
            .iter()
            .flat_map(|own| places().map(|place| (*own, place)));
        let steps = self.stepper.at(&self.sums, &Places::new(all));
        for (number, objective) in objectives.iter().enumerate() {
            let value = |n: usize| steps.value(number * RAY_STEPS.len() + n);
            if let Some(n) = first_dip(value) {
                descents.push(Descent::from(*objective, place(n)));
            }
        }
        descents
    }

    /// Follows descents to their ends, `LANES` at a time.
    fn descend(&self, descents: &mut [Descent], requests: &[Request]) {
        let mut floors = Floors::new(requests, descents);
        let mut running = Vec::with_capacity(descents.len());
        for _ in 0..NEWTON_STEPS {
            running.clear();
            running.extend((0..descents.len()).filter(|n| descents[*n].state == State::Running));
            if running.is_empty() {
                return;
            }
            for chunk in running.chunks(LANES) {
                let places = chunk.iter().map(|n| &descents[*n]);
                let places = Places::new(places.map(|own| (own.objective, own.place)));
                let steps = self.stepper.at(&self.sums, &places);
                for (lane, n) in chunk.iter().enumerate() {
                    let descent = &mut descents[*n];
                    descent.proceed(&steps, lane, floors.of(descent.objective), self);
                    floors.lower(descent);
                }
            }
        }
    }

    /// Distance of a position from the origin in grid steps.
    fn steps_from_origin(&self, place: [f64; 2]) -> f64 {
        let [u, v] = self.waves.steps;
        (place[0].abs() / u).max(place[1].abs() / v)
    }
}

/// Upper limits of the values that descents must reach: the floor of the request and the lowest value of other descents. For the discriminant only
/// the floor counts, because all its wells are needed.
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

/// End of a descent.
pub(super) struct Bottom {
    pub(super) objective: Objective,
    /// Value from fast sums; the scaled measure lacks the factor `1 / c^2`.
    pub(super) value: f64,
    /// Phases of the primitive vectors.
    pub(super) phases: [f64; 2],
    /// True if Newton's method ended in a smooth minimum.
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

    /// Performs one step of Newton's method from the values at the current position. If this position is higher than the last position, the step is
    /// shortened instead.
    fn proceed(&mut self, here: &Steps, lane: usize, floor: f64, search: &Mirrored) {
        let reach = search.sums.reach;
        let length =
            |step: [f64; 2]| (step[0].abs() * reach[0] as f64).max(step[1].abs() * reach[1] as f64);
        let value = here.value(lane);
        if value == f64::INFINITY && search.steps_from_origin(self.last) < ORIGIN_RANGE_STEPS {
            self.state = State::Left;
            return;
        }
        if value.is_nan() || value >= self.value {
            self.step = [0.25 * self.step[0], 0.25 * self.step[1]];
            if length(self.step) < STEP_TOLERANCE_PHASE {
                // The value belongs to the last position.
                self.place = self.last;
                self.state = State::Lost;
            } else {
                self.place = [self.last[0] + self.step[0], self.last[1] + self.step[1]];
            }
            return;
        }
        self.value = value;
        self.last = self.place;
        let (decrease, is_convex) = match here.newton(lane) {
            Some((step, decrease)) => {
                self.step = step;
                (decrease, true)
            }
            None if !here.is_finite(lane) => {
                self.state = State::Lost;
                return;
            }
            None => {
                // `newton_step` limits steps to a tenth of its argument: one grid step.
                let [u, v] = search.waves.steps;
                let slope = here.slope(lane);
                let (step, is_convex) = newton_step(&slope, &here.curvature(lane), 10.0 * u.max(v));
                self.step = [step[0], step[1]];
                (-slope.dot(&step), is_convex)
            }
        };
        self.place = [self.last[0] + self.step[0], self.last[1] + self.step[1]];
        if !is_convex {
            return;
        }
        let is_near = |bottom: [f64; 2]| {
            (0..2).all(|n| (bottom[n] - self.place[n]).abs() < KNOWN_BOTTOM_PHASE)
        };
        let is_known = self.bottom.is_some_and(is_near);
        let is_too_high = self.value - 4.0 * decrease > floor;
        if length(self.step) < STEP_TOLERANCE_PHASE || decrease <= 1e-14 * self.value.abs() {
            self.value -= 0.5 * decrease;
            let valley = valley(&here.curvature(lane));
            self.state = State::Settled(valley);
            self.is_intricate = valley.is_some() || here.is_near_crossing(lane);
        } else if is_known || is_too_high {
            self.state = State::Left;
        }
    }
}

/// Direction of a valley, if the two curvatures differ by a large factor.
fn valley(curvature: &Matrix2<f64>) -> Option<[f64; 2]> {
    let ([high, low], [_, along]) = principal(curvature);
    (low.abs() < VALLEY_CURVATURE_RATIO * high.abs()).then_some([along[0], along[1]])
}

/// One pass over the grid.
struct Sweep<'a> {
    sums: &'a MirrorSums,
    waves: &'a MirrorWaves,
    floors: [f64; 5],
    wells: Vec<Well>,
    lowest: f64,
}

/// Vectorized sweep for the instruction set of the machine.
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
        // Values of the objectives on the last three lines.
        let size = OBJECTIVES.len() * groups;
        // Values beyond the last column are not used.
        let mut ring = vec![[0.0; FILL]; 3 * size + 1];
        for line in 0..self.waves.lines() {
            self.fill(simd, line, &rows, &mut ring[line % 3 * size..][..size]);
            if line >= 2 {
                self.find(simd, line - 1, ring.as_flattened());
            }
        }
    }

    /// Evaluates the objectives on a line.
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
                for number in 0..OBJECTIVES.len() {
                    sought[number].write(&mut values[number * groups + group], part);
                }
            }
        }
        if line == 1 {
            // Long waves are represented by their limit.
            for number in 0..OBJECTIVES.len() {
                values[number * groups][1] = f64::INFINITY;
            }
        }
    }

    /// Finds the wells on a line from the values on it and on both neighboring lines.
    #[inline(always)]
    fn find<S: Simd>(&mut self, simd: S, line: usize, ring: &[f64]) {
        let width = self.waves.width;
        let size = OBJECTIVES.len() * width;
        let [last_column, last_line] = self.waves.intervals.each(|n| n + 1);
        for number in 0..OBJECTIVES.len() {
            let (objective, is_image) = OBJECTIVES[number];
            // On the mirror lines wave and image coincide.
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
                let mut lowest = [0.0; LARGEST_LANES];
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
                    self.record(number, [n, line], ring);
                }
            }
        }
    }

    /// Records a well of the grid if its bottom may lie below the floor.
    fn record(&mut self, number: usize, at: [usize; 2], ring: &[f64]) {
        let around = |number: usize| {
            let lines = [at[1] + 2, at[1], at[1] + 1];
            let start = |line: usize| (line % 3 * OBJECTIVES.len() + number) * self.waves.width;
            lines.each(|line| [0, 1, 2].each(|n| ring[start(line) + at[0] - 1 + n]))
        };
        let (objective, is_image) = OBJECTIVES[number];
        let [a, b, c] = around(number);
        let value = b[1];
        let (_, highest) = range([a, b, c].as_flattened());
        let bound = value - (highest - value);
        if bound > self.floors[number] || !value.is_finite() {
            return;
        }
        let growth_squared = match objective {
            Objective::Discriminant => {
                let (low, high) = (around(LOWEST), around(HIGHEST));
                let means = [0, 1, 2].each(|i| [0, 1, 2].each(|j| 0.5 * (low[i][j] - high[i][j])));
                fastest_growth(bound, means.as_flattened())
            }
            _ => f64::INFINITY,
        };
        let steps = self.waves.steps;
        let mut place = [
            (at[0] as f64 - 1.0) * steps[0],
            (at[1] as f64 - 1.0) * steps[1],
        ];
        // Step to the bottom of the paraboloid through the points around.
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
            growth_squared,
            bound,
            value,
            place,
        });
    }
}

/// Smallest and largest finite value.
fn range(values: &[f64]) -> (f64, f64) {
    let finite = values.iter().filter(|value| value.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), x| {
        (least.min(*x), most.max(*x))
    })
}

/// Expected square of the largest growth rate `Im omega` of a pair `omega^2 = h +- i sqrt(-p)`.
///
/// The expected discriminant is `p <= 0`. The estimate of the mean `h` is lowered below all neighboring means by the range of these means.
fn fastest_growth(p: f64, means: &[f64]) -> f64 {
    let (least, most) = range(means);
    let mean = least - (most - least);
    0.5 * ((mean * mean - p).sqrt() - mean)
}

/// Lowest of the eight neighbors of each point of a group on the second of three lines; the first point of the lines is excluded.
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
