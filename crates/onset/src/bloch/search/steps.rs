//! Objectives with derivatives, and Newton steps, at several wave vectors of a matrix with a mirror line simultaneously.

use super::Objective;
use super::descent::CONVEXITY_RATIO;
use crate::algebra::{Each, Mask, Pack, sines_and_cosines};
use crate::bloch::mirror::{LANES, Lanes, MirrorSums, Multiples};
use crate::lattice::{BravaisLattice, HARMONICS, Mirror, MirrorWaves};
use nalgebra::{Matrix2, Vector2};
use pulp::{Arch, Simd, WithSimd};

/// Phase of the longest wave that is sampled; longer waves are represented by the limit.
const LONG_WAVE_PHASE: f64 = 5e-3;
/// Distance from the origin, in grid steps, within which the discriminant is not searched; it vanishes there with the fourth power of `k`.
const ORIGIN_RANGE_STEPS: f64 = 0.5;
/// Distance, in grid steps, within which branches that nearly cross count as crossing.
const CROSSING_RANGE_STEPS: f64 = 2.0;

/// Lattice Laplacian `|k|_h^2` as a function of the phases along the mirror lines.
#[derive(Clone, Copy, Debug)]
struct Laplacian {
    /// Weights `1 / |a_n|^2`, and the multiples of `u` and `v` in `k.a_n`.
    vectors: [(f64, [i32; 2]); 2],
}

impl Laplacian {
    fn new<const D: usize>(lattice: &BravaisLattice<D>, mirror: &Mirror) -> Self {
        let vector = |n: usize| {
            let weight = 1.0 / lattice.vectors().column(n).norm_squared();
            (weight, mirror.multiples(n))
        };
        Self {
            vectors: [vector(0), vector(1)],
        }
    }

    /// Evaluates the Laplacian from sines and cosines of multiples of half the phases.
    #[inline(always)]
    fn at<S: Simd>(&self, [u, v]: [&Multiples<S, HALF_PHASE_MULTIPLES>; 2]) -> Jet<S> {
        let zero = u.sines[0];
        let mut sum = Jet([zero; 6]);
        for n in 0..2 {
            let (weight, multiples) = self.vectors[n];
            let [i, j] = multiples;
            let ((su, cu), (sv, cv)) = (u.turn(i), v.turn(j));
            let sine = su.times_plus(cv, cu * sv);
            let cosine = cu.times_plus(cv, -(su * sv));
            let [i, j] = [zero.constant(f64::from(i)), zero.constant(f64::from(j))];
            let weighted = sine * zero.constant(4.0 * weight);
            let slope = weighted * cosine;
            let curvature = (cosine * cosine - sine * sine) * zero.constant(2.0 * weight);
            let Jet(own) = &mut sum;
            own[0] = weighted.times_plus(sine, own[0]);
            own[1] = slope.times_plus(i, own[1]);
            own[2] = slope.times_plus(j, own[2]);
            own[3] = curvature.times_plus(i * i, own[3]);
            own[4] = curvature.times_plus(i * j, own[4]);
            own[5] = curvature.times_plus(j * j, own[5]);
        }
        sum
    }
}

/// Number of multiples of half a phase: up to the largest coordinate of a primitive vector.
const HALF_PHASE_MULTIPLES: usize = Mirror::LARGEST_LINE_COORDINATE as usize + 1;

/// Function of `u` and `v`: value, and derivatives with respect to `u`, `v`, `uu`, `uv`, `vv`.
#[derive(Clone, Copy)]
struct Jet<S: Simd>([Pack<S>; 6]);

impl<S: Simd> Jet<S> {
    /// `self * factor + other` with a constant factor.
    #[inline(always)]
    fn times_plus(&self, factor: Pack<S>, other: &Self) -> Self {
        let mut sum = *other;
        for n in 0..6 {
            sum.0[n] = self.0[n].times_plus(factor, other.0[n]);
        }
        sum
    }

    /// `self` plus the product of two functions.
    #[inline(always)]
    fn plus_product(&self, Self(x): &Self, Self(y): &Self) -> Self {
        let mut sum = *self;
        for n in 0..6 {
            sum.0[n] = x[0].times_plus(y[n], sum.0[n]);
            if n > 0 {
                sum.0[n] = x[n].times_plus(y[0], sum.0[n]);
            }
        }
        for (n, i, j) in SECOND_DERIVATIVES {
            sum.0[n] = x[i].times_plus(y[j], sum.0[n]);
            sum.0[n] = x[j].times_plus(y[i], sum.0[n]);
        }
        sum
    }

    /// Square root: NaN where the function is negative; the derivatives are not finite where it vanishes.
    #[inline(always)]
    fn root(&self) -> Self {
        let Self(own) = self;
        let root = own[0].sqrt();
        // Derivatives `1 / 2 sqrt(p)` and `-1 / 4 sqrt(p)^3` of the root, with one division.
        let inverse = own[0].constant(1.0) / root;
        let first = inverse * own[0].constant(0.5);
        let second = -(first * own[0].constant(0.5)) * inverse * inverse;
        let mut composed = Self([root; 6]);
        for n in 1..6 {
            composed.0[n] = own[n] * first;
        }
        for (n, i, j) in SECOND_DERIVATIVES {
            composed.0[n] = (own[i] * own[j]).times_plus(second, composed.0[n]);
        }
        composed
    }

    /// Quotient of two functions.
    #[inline(always)]
    fn over(&self, Self(scale): &Self) -> Self {
        let mut quotient = *self;
        let inverse = scale[0].constant(1.0) / scale[0];
        let Self(own) = &mut quotient;
        own[0] = own[0] * inverse;
        for n in 1..6 {
            own[n] = own[n] - own[0] * scale[n];
        }
        for n in 1..3 {
            own[n] = own[n] * inverse;
        }
        for (n, i, j) in SECOND_DERIVATIVES {
            own[n] = (own[n] - own[i] * scale[j] - own[j] * scale[i]) * inverse;
        }
        quotient
    }

    #[inline(always)]
    fn minus(&self, other: &Self) -> Self {
        let mut difference = *self;
        for n in 0..6 {
            difference.0[n] = self.0[n] - other.0[n];
        }
        difference
    }

    /// Selects `other` in the lanes of the mask.
    #[inline(always)]
    fn or(&self, is_other: Mask<S>, other: &Self) -> Self {
        let mut chosen = *self;
        for n in 0..6 {
            chosen.0[n] = is_other.select(other.0[n], self.0[n]);
        }
        chosen
    }
}

/// Indices of the second derivatives, each with the indices of its two first derivatives.
const SECOND_DERIVATIVES: [(usize, usize, usize); 3] = [(3, 1, 1), (4, 1, 2), (5, 2, 2)];

/// Evaluation of the objectives on a lattice and its grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stepper {
    laplacian: Laplacian,
    /// Grid steps as phases along the mirror lines.
    grid: [f64; 2],
}

/// Values of the objectives at several wave vectors, one objective at each, with the Newton steps from there.
pub(super) struct Steps {
    /// Value, and derivatives with respect to `u`, `v`, `uu`, `uv`, `vv`; the value is infinite where the objective is not defined.
    taylor: [Lanes; 6],
    /// Step to the bottom of the paraboloid, and the decrease of the tangent plane along it; the decrease is infinite if there may be no minimum.
    step: [Lanes; 2],
    decrease: Lanes,
    /// Negative where branches may cross within [`CROSSING_RANGE_STEPS`] grid steps.
    distance: Lanes,
}

/// Several wave vectors with the requested objective at each.
pub(super) struct Places {
    pub(super) count: usize,
    u: Lanes,
    v: Lanes,
    /// Requested objectives, by number.
    sought: Lanes,
}

impl Places {
    /// Collects up to [`LANES`] wave vectors.
    pub(super) fn new(places: impl Iterator<Item = (Objective, [f64; 2])>) -> Self {
        let mut all = Self {
            count: 0,
            u: [0.0; LANES],
            v: [0.0; LANES],
            sought: [0.0; LANES],
        };
        for (lane, (objective, [u, v])) in places.take(LANES).enumerate() {
            (all.u[lane], all.v[lane]) = (u, v);
            all.sought[lane] = f64::from(objective as u8);
            all.count = lane + 1;
        }
        all
    }
}

impl Steps {
    pub(super) fn value(&self, lane: usize) -> f64 {
        self.taylor[0][lane]
    }

    pub(super) fn is_finite(&self, lane: usize) -> bool {
        self.taylor[1..].iter().all(|lanes| lanes[lane].is_finite())
    }

    pub(super) fn slope(&self, lane: usize) -> Vector2<f64> {
        Vector2::new(self.taylor[1][lane], self.taylor[2][lane])
    }

    pub(super) fn curvature(&self, lane: usize) -> Matrix2<f64> {
        let [uu, uv, vv] = [3, 4, 5].each(|n| self.taylor[n][lane]);
        Matrix2::new(uu, uv, uv, vv)
    }

    /// Newton step, at most one grid step long, and the decrease along it, if the curvature is clearly positive.
    pub(super) fn newton(&self, lane: usize) -> Option<([f64; 2], f64)> {
        let decrease = self.decrease[lane];
        decrease
            .is_finite()
            .then(|| (self.step.each_ref().map(|lanes| lanes[lane]), decrease))
    }

    pub(super) fn is_near_crossing(&self, lane: usize) -> bool {
        self.distance[lane] < 0.0
    }
}

impl Stepper {
    pub(super) fn new<const D: usize>(lattice: &BravaisLattice<D>, waves: &MirrorWaves) -> Self {
        Self {
            laplacian: Laplacian::new(lattice, &waves.mirror),
            grid: waves.steps,
        }
    }

    /// Evaluates the objectives at several wave vectors.
    pub(super) fn at(&self, sums: &MirrorSums, places: &Places) -> Steps {
        Arch::new().dispatch(StepsAt {
            stepper: self,
            sums,
            places,
        })
    }

    /// Objectives of a group of lanes, from mean and discriminant of the eigenvalues and from the lattice Laplacian.
    #[inline(always)]
    fn objectives<S: Simd>(
        &self,
        [mean, p]: [&Jet<S>; 2],
        laplacian: &Jet<S>,
        [u, v, sought]: [Pack<S>; 3],
    ) -> Jet<S> {
        let (zero, one) = (u.constant(0.0), u.constant(1.0));
        let infinite = u.constant(f64::INFINITY);
        // The real part of a complex pair is half of the trace.
        let root = p.root().or(p.0[0].is_below(zero), &Jet([zero; 6]));
        let sign = is(sought, Objective::Highest).select(-one, one);
        let branch = Jet([zero; 6]).minus(&root);
        let mut objective = mean.times_plus(sign, &branch);
        let is_scaled = is(sought, Objective::Scaled);
        if is_scaled.any() {
            let least = u.constant(LONG_WAVE_PHASE * LONG_WAVE_PHASE * self.laplacian.vectors[0].0);
            let is_long = is_scaled.and(laplacian.0[0].is_below(least));
            objective = objective.or(is_scaled, &objective.over(laplacian));
            objective.0[0] = is_long.select(infinite, objective.0[0]);
        }
        let is_discriminant = is(sought, Objective::Discriminant);
        if is_discriminant.any() {
            let [width, height] = self.grid;
            let is_beside = u.abs().is_below(u.constant(ORIGIN_RANGE_STEPS * width));
            let is_near = is_beside.and(v.abs().is_below(v.constant(ORIGIN_RANGE_STEPS * height)));
            objective = objective.or(is_discriminant, p);
            objective.0[0] = is_discriminant
                .and(is_near)
                .select(infinite, objective.0[0]);
        }
        let is_growth = is(sought, Objective::Growth);
        if is_growth.any() {
            // Negative square of the growth rate of a complex pair, `(h - sqrt(h^2 - p)) / 2`. It continues smoothly to real branches and is
            // positive there.
            let determinant = Jet([zero; 6]).minus(p).plus_product(mean, mean);
            let growth = mean.minus(&determinant.root());
            let half = growth.times_plus(u.constant(0.5), &Jet([zero; 6]));
            objective = objective.or(is_growth, &half);
        }
        objective
    }
}

/// Mask of the lanes with the given objective.
#[inline(always)]
fn is<S: Simd>(sought: Pack<S>, objective: Objective) -> Mask<S> {
    let own = sought.constant(f64::from(objective as u8));
    own.is_at_most(sought).and(sought.is_at_most(own))
}

/// Vectorized evaluation for the instruction set of the machine.
struct StepsAt<'a> {
    stepper: &'a Stepper,
    sums: &'a MirrorSums,
    places: &'a Places,
}

impl WithSimd for StepsAt<'_> {
    type Output = Steps;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Steps {
        match self.sums.reach.into_iter().max() {
            Some(0..=7) => self.with::<S, 8>(simd),
            Some(8..=15) => self.with::<S, 16>(simd),
            _ => self.with::<S, { HARMONICS + 1 }>(simd),
        }
    }
}

impl StepsAt<'_> {
    /// Evaluation with tables of `COUNT` multiples of the phases.
    #[inline(always)]
    fn with<S: Simd, const COUNT: usize>(&self, simd: S) -> Steps {
        let Places {
            count,
            u,
            v,
            sought,
        } = self.places;
        let mut steps = Steps {
            taylor: [[0.0; LANES]; 6],
            step: [[0.0; LANES]; 2],
            decrease: [0.0; LANES],
            distance: [0.0; LANES],
        };
        let (half_u, half_v) = (halves(u), halves(v));
        for group in 0..count.div_ceil(S::F64_LANES) {
            let half_u = Multiples::<S, HALF_PHASE_MULTIPLES>::of_group(
                simd,
                &half_u,
                group,
                HALF_PHASE_MULTIPLES - 1,
            );
            let half_v = Multiples::<S, HALF_PHASE_MULTIPLES>::of_group(
                simd,
                &half_v,
                group,
                HALF_PHASE_MULTIPLES - 1,
            );
            let ((su, cu), (sv, cv)) = (half_u.turn(2), half_v.turn(2));
            let [reach, other] = self.sums.reach;
            let first = Multiples::<S, COUNT>::of(su, cu, reach);
            let second = Multiples::<S, COUNT>::of(sv, cv, other);
            let entries = self.sums.entries(&first, &second);
            let u = Pack::of(simd, u, group);
            let v = Pack::of(simd, v, group);
            let sought = Pack::of(simd, sought, group);
            let none = Jet([u.constant(0.0); 6]);
            let (mut mean, mut difference, mut b, mut c) = (none, none, none, none);
            for n in 0..6 {
                let [own, mixed, other, last] = entries[n];
                mean.0[n] = (own + last) * u.constant(0.5);
                difference.0[n] = (own - last) * u.constant(0.5);
                (b.0[n], c.0[n]) = (mixed, other);
            }
            let p = none.plus_product(&b, &c);
            let p = p.plus_product(&difference, &difference);
            let laplacian = self.stepper.laplacian.at([&half_u, &half_v]);
            let objective = self
                .stepper
                .objectives([&mean, &p], &laplacian, [u, v, sought]);
            steps.set(self.stepper, &objective, &p, group);
        }
        steps
    }
}

/// Sines and cosines of half the phases.
#[inline(always)]
fn halves(phases: &Lanes) -> (Lanes, Lanes) {
    let mut halves = *phases;
    for half in &mut halves {
        *half *= 0.5;
    }
    sines_and_cosines(&halves)
}

impl Steps {
    /// Sets the results of a group of lanes.
    #[inline(always)]
    fn set<S: Simd>(
        &mut self,
        stepper: &Stepper,
        Jet(own): &Jet<S>,
        Jet(p): &Jet<S>,
        group: usize,
    ) {
        for n in 0..6 {
            own[n].write(&mut self.taylor[n], group);
        }
        let (zero, one) = (own[0].constant(0.0), own[0].constant(1.0));
        let infinite = zero.constant(f64::INFINITY);
        let trace = own[3] + own[5];
        let determinant = own[3] * own[5] - own[4] * own[4];
        let is_certain = zero
            .is_below(trace)
            .and((trace * trace * zero.constant(CONVEXITY_RATIO)).is_below(determinant));
        let inverse = one / determinant;
        let mut u = (own[4] * own[2] - own[5] * own[1]) * inverse;
        let mut v = (own[4] * own[1] - own[3] * own[2]) * inverse;
        let square = u.times_plus(u, v * v);
        let longest = stepper.grid[0].max(stepper.grid[1]);
        let is_long = zero.constant(longest * longest).is_below(square);
        if is_long.any() {
            let share = zero.constant(longest) / square.sqrt();
            u = is_long.select(u * share, u);
            v = is_long.select(v * share, v);
        }
        let decrease = -(own[1].times_plus(u, own[2] * v));
        let is_certain = is_certain.and(square.is_below(infinite));
        u.write(&mut self.step[0], group);
        v.write(&mut self.step[1], group);
        is_certain
            .select(decrease, infinite)
            .write(&mut self.decrease, group);
        let mut distance = p[0];
        for axis in 0..2 {
            let step = CROSSING_RANGE_STEPS * stepper.grid[axis];
            distance = distance - p[1 + axis].abs() * zero.constant(step);
            distance = distance - p[3 + 2 * axis].abs() * zero.constant(0.5 * step * step);
        }
        distance.write(&mut self.distance, group);
    }
}

#[cfg(test)]
mod tests {
    use super::{Places, Stepper};
    use crate::algebra::uniform;
    use crate::bloch::dynamical_matrix;
    use crate::bloch::mirror::LANES;
    use crate::bloch::search::Objective;
    use crate::bloch::search::descent::newton_step;
    use crate::bloch::search::mirrored::intervals;
    use crate::kinematics::DeformationGradient;
    use crate::lattice::LatticeKind;
    use crate::material::ModifiedMooneyRivlin;
    use crate::method::{Frame, KernelMethodChoices, Method};
    use nalgebra::Vector2;
    use std::f64::consts::TAU;

    const ALL: [Objective; 5] = [
        Objective::Scaled,
        Objective::Lowest,
        Objective::Highest,
        Objective::Discriminant,
        Objective::Growth,
    ];

    /// Compares the values with the matrix itself, and the derivatives and Newton steps with finite differences.
    #[test]
    fn objectives_along_the_mirror_lines_and_their_derivatives_agree_with_the_matrix() {
        let (mut random, mut steep, mut certain) = (7_u64, 0, 0);
        for (lattice, stretches) in [
            (LatticeKind::Hexagonal, [1.2, 0.7]),
            (LatticeKind::Square, [0.8, 1.1]),
            (LatticeKind::Hexagonal, [1.0, 0.6]),
        ] {
            let choices = KernelMethodChoices {
                frame: Frame::Eulerian,
                lattice,
                ..KernelMethodChoices::default()
            };
            let method = Method::<2>::new(choices).expect("an admissible method");
            let state = DeformationGradient::from_stretches([stretches[0], stretches[1], 1.0]);
            let material = ModifiedMooneyRivlin::default();
            let d =
                dynamical_matrix(&method, &material, &state.expect("positive")).expect("finite");
            let sums = d
                .mirror_sums(method.wave_grids().mirrors())
                .expect("mirrors");
            let waves = method.wave_grids().mirrored(sums.number, intervals(&sums));
            let stepper = Stepper::new(method.lattice(), &waves);
            let exact = |objective: Objective, [u, v]: [f64; 2]| {
                let phases = Vector2::from(sums.mirror.phases([u, v])) / TAU;
                let k = method.lattice().reciprocal() * phases;
                let d = d.at(&k);
                let [a, b, c, d] = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|at| d[at].re);
                let (mean, p) = (0.5 * (a + d), 0.25 * (a - d) * (a - d) + b * c);
                let root = p.max(0.0).sqrt();
                match objective {
                    Objective::Scaled => (mean - root) / method.lattice().laplacian(&k),
                    Objective::Lowest => mean - root,
                    Objective::Highest => -mean - root,
                    Objective::Discriminant => p,
                    Objective::Growth => 0.5 * (mean - (mean * mean - p).sqrt()),
                }
            };
            for objective in ALL {
                let places = [(); LANES].map(|()| [0; 2].map(|_| 6.0 * uniform(&mut random) - 3.0));
                let steps = stepper.at(
                    &sums,
                    &Places::new(places.map(|at| (objective, at)).into_iter()),
                );
                for (lane, [u, v]) in places.into_iter().enumerate() {
                    let h = 1e-4;
                    let at = |a: f64, b: f64| exact(objective, [u + a * h, v + b * h]);
                    let middle = at(0.0, 0.0);
                    let own = steps.value(lane);
                    if middle.is_nan() {
                        // One of the two real branches is negative.
                        assert!(objective == Objective::Growth && own.is_nan());
                        continue;
                    }
                    assert!(
                        (own - middle).abs() < 1e-11 * middle.abs().max(1.0),
                        "{objective:?} {own} {middle}"
                    );
                    let slope =
                        Vector2::new(at(1.0, 0.0) - at(-1.0, 0.0), at(0.0, 1.0) - at(0.0, -1.0))
                            / (2.0 * h);
                    let bend = |a: f64, b: f64| (at(a, b) + at(-a, -b) - 2.0 * middle) / (h * h);
                    let curvature = steps.curvature(lane);
                    let size = curvature.amax().max(1.0);
                    if size > 100.0 || !size.is_finite() {
                        // The branches are close to a crossing.
                        steep += 1;
                        continue;
                    }
                    assert!(
                        (steps.slope(lane) - slope).amax() < 1e-5 * size,
                        "{objective:?}"
                    );
                    assert!(
                        (curvature.m11 - bend(1.0, 0.0)).abs() < 1e-4 * size,
                        "{objective:?}"
                    );
                    assert!(
                        (curvature.m22 - bend(0.0, 1.0)).abs() < 1e-4 * size,
                        "{objective:?}"
                    );
                    let mixed = 0.25 * (bend(1.0, 1.0) - bend(1.0, -1.0));
                    assert!((curvature.m12 - mixed).abs() < 1e-4 * size, "{objective:?}");
                    let longest = waves.steps[0].max(waves.steps[1]);
                    let (step, is_convex) =
                        newton_step(&steps.slope(lane), &curvature, 10.0 * longest);
                    if let Some((own, decrease)) = steps.newton(lane) {
                        certain += 1;
                        assert!(is_convex && (Vector2::from(own) - step).norm() < 1e-9 * longest);
                        assert!((decrease + steps.slope(lane).dot(&step)).abs() < 1e-9 * size);
                    }
                }
            }
            let near = [[1e-3, 1e-3]; 2]
                .into_iter()
                .zip([Objective::Scaled, Objective::Discriminant]);
            let near = stepper.at(
                &sums,
                &Places::new(near.map(|(at, objective)| (objective, at))),
            );
            assert!([0, 1].iter().all(|lane| near.value(*lane) == f64::INFINITY));
        }
        assert!(steep < 40 && certain > 10, "{steep} {certain}");
    }
}
