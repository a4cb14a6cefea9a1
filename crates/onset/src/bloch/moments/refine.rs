//! Descent from candidates to the bottoms of their wells, several at a time, by Newton's method on the exact sums.

use super::candidates::Candidates;
use super::contraction::{Columns, Contraction};
use super::sums::{LARGEST_HALF_PHASE, Local, Near, Sums, Workspace};
use crate::algebra::{LARGEST_LANES, Mask, Pack};
use crate::bloch::search::LONG_WAVE_FRACTION;
use pulp::{Simd, WithSimd};
use std::f64::consts::TAU;

/// Maximum number of evaluations in a descent.
const EVALUATIONS: usize = 24;
/// Number of Newton steps on the polynomials of the candidates, before the exact sums.
const APPROACH_STEPS: usize = 2;
/// Largest phase difference from the candidate in these first steps.
const APPROACH_PHASE: f64 = 0.15;
/// Longest Newton step, as a phase.
const LONGEST_STEP_PHASE: f64 = 0.6;
/// Largest Newton step, as a phase, of a converged descent: a further quadratic step reduces the error below rounding.
const STEP_TOLERANCE_PHASE: f64 = 1e-4;
/// Largest decrease, relative to the value, of a converged descent.
const DECREASE_TOLERANCE: f64 = 1e-8;
/// Phase of the longest wave that is sampled; longer waves are represented by the limit.
const LONG_WAVE_PHASE: f64 = LONG_WAVE_FRACTION * TAU;
/// Largest phase at which a slope toward `k = 0` means that the long-wave limit is the nearest minimum.
const LIMIT_BASIN_PHASE: f64 = 0.6;

/// End of a descent in a smooth minimum.
pub(super) const END_SETTLED: f64 = 0.0;
/// End of a descent that cannot fall below its floor.
pub(super) const END_BEATEN: f64 = 1.0;
/// End of a descent that failed and needs the general Newton method.
pub(super) const END_FAILED: f64 = 2.0;

/// Starts and floors of descents; after the descent, their ends. Padded to a multiple of [`LARGEST_LANES`].
#[derive(Clone, Debug, Default)]
pub(super) struct Descents {
    /// Phases `k.a_1` and `k.a_2`.
    pub(super) phases: [Vec<f64>; 2],
    /// Indices of the candidates at which the descents start.
    pub(super) candidates: Vec<usize>,
    /// Upper limits of the values that a descent must reach.
    pub(super) floors: Vec<f64>,
    /// Objective at the end.
    pub(super) values: Vec<f64>,
    /// Kind of end: [`END_SETTLED`], [`END_BEATEN`] or [`END_FAILED`].
    pub(super) ends: Vec<f64>,
}

impl Descents {
    /// Creates descents from the indices and floors of candidates.
    pub(super) fn new<const D: usize>(
        candidates: &Candidates<D>,
        starts: impl ExactSizeIterator<Item = (usize, f64)>,
    ) -> Self {
        let length = starts.len().next_multiple_of(LARGEST_LANES);
        let mut result = Self {
            phases: [vec![1.0; length], vec![1.0; length]],
            candidates: vec![0; length],
            // Padded entries count as unable to fall below their floor.
            floors: vec![f64::NEG_INFINITY; length],
            values: vec![f64::INFINITY; length],
            ends: vec![END_BEATEN; length],
        };
        for (n, (candidate, floor)) in starts.enumerate() {
            let phases = candidates.phases[candidate];
            result.phases[0][n] = phases[0];
            result.phases[1][n] = phases[1];
            result.candidates[n] = candidate;
            result.floors[n] = floor;
        }
        result
    }
}

/// Vectorized descents for the instruction set of the machine.
pub(super) struct Refine<'a, const D: usize, const MIRRORED: bool> {
    pub(super) sums: &'a Sums,
    pub(super) candidates: &'a Candidates<D>,
    pub(super) columns: &'a Columns,
    /// Sign of the objective: 1 for the smaller eigenvalue, -1 for the negative of the larger eigenvalue.
    pub(super) sign: f64,
    /// True if the eigenvalue is divided by the lattice Laplacian.
    pub(super) scaled: bool,
    pub(super) descents: &'a mut Descents,
}

impl<const D: usize, const MIRRORED: bool> WithSimd for Refine<'_, D, MIRRORED> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut workspace = Workspace::new(simd);
        for group in 0..self.columns.length() / S::F64_LANES {
            let objective = Objective::<S, MIRRORED> {
                simd,
                sums: self.sums,
                contraction: Contraction::of(simd, self.columns, group),
                sign: Pack::splat(simd, self.sign),
                scaled: self.scaled,
            };
            let lanes = group * S::F64_LANES..(group + 1) * S::F64_LANES;
            let phases = [
                Pack::of(simd, &self.descents.phases[0], group),
                Pack::of(simd, &self.descents.phases[1], group),
            ];
            let near = Near::of(
                simd,
                &self.candidates.polynomials,
                &self.descents.candidates[lanes],
                phases,
            );
            let start = objective.approached(&near, phases);
            objective.descend(group, start, self.descents, &mut workspace);
        }
    }
}

struct Objective<'a, S: Simd, const MIRRORED: bool> {
    simd: S,
    sums: &'a Sums,
    contraction: Contraction<S, MIRRORED>,
    sign: Pack<S>,
    scaled: bool,
}

impl<S: Simd, const MIRRORED: bool> Objective<'_, S, MIRRORED> {
    /// Approaches the bottoms with the polynomials of the candidates.
    #[inline(always)]
    fn approached(&self, near: &Near<S>, start: [Pack<S>; 2]) -> [Pack<S>; 2] {
        let half = Pack::splat(self.simd, 0.5);
        let farthest = Pack::splat(self.simd, APPROACH_PHASE * APPROACH_PHASE);
        let mut at = start;
        for turn in 0..APPROACH_STEPS {
            let laplacian = self
                .sums
                .laplacian_at(self.simd, [at[0] * half, at[1] * half]);
            let h = if turn == 0 {
                near.local()
            } else {
                near.local_at(at)
            };
            let newton = newton_step(&self.branch(&h, &laplacian));
            let next = [at[0] + newton.step[0], at[1] + newton.step[1]];
            let (x, y) = (next[0] - start[0], next[1] - start[1]);
            let is_near = x.times_plus(x, y * y).is_below(farthest);
            for a in 0..2 {
                at[a] = is_near.select(next[a], at[a]);
            }
        }
        at
    }

    #[inline(always)]
    fn descend(
        &self,
        group: usize,
        start: [Pack<S>; 2],
        descents: &mut Descents,
        workspace: &mut Workspace<S>,
    ) {
        let number = |value: f64| Pack::splat(self.simd, value);
        let zero = number(0.0);
        let floor = Pack::of(self.simd, &descents.floors, group);
        let mut base = start;
        let mut step = [zero; 2];
        let mut last = number(f64::INFINITY);
        let mut end = number(END_FAILED);
        let mut active = zero.is_at_most(zero);
        for _ in 0..EVALUATIONS {
            let at = [base[0] + step[0], base[1] + step[1]];
            let local = self.local(at, workspace);
            let lower = local.value.is_at_most(last).and(active);
            let short = step[0].times_plus(step[0], step[1] * step[1]);
            let stuck = active
                .and(lower.not())
                .and(short.is_below(number(1e-8 * LONGEST_STEP_PHASE * LONGEST_STEP_PHASE)));
            for a in 0..2 {
                base[a] = lower.select(at[a], base[a]);
            }
            last = lower.select(local.value, last);
            let newton = newton_step(&local);
            for a in 0..2 {
                step[a] = lower.select(newton.step[a], step[a] * number(0.25));
            }
            let decrease =
                -(local.slope[0].times_plus(newton.step[0], local.slope[1] * newton.step[1]));
            let size = local.value.abs();
            let quiet = newton
                .square
                .is_at_most(number(STEP_TOLERANCE_PHASE * STEP_TOLERANCE_PHASE))
                .and(decrease.is_at_most(size * number(DECREASE_TOLERANCE)))
                .or(decrease.is_at_most(size * number(1e-15)));
            let settled = lower.and(newton.is_convex).and(quiet);
            let beaten = lower
                .and(newton.is_convex)
                .and(floor.is_below(decrease.times_plus(number(-4.0), local.value)))
                .or(self.falls_to_the_limit(&local, at, floor).and(lower));
            // The point lies on a crest, or the step leads beyond the range of the power series.
            let crest = lower.and(newton.is_convex.not()).and(quiet);
            let far = (base[0] + step[0]).abs().max((base[1] + step[1]).abs());
            let lost = crest
                .or(stuck)
                .or(active.and(far.is_at_most(number(2.0 * LARGEST_HALF_PHASE)).not()));
            end = settled.select(number(END_SETTLED), end);
            end = beaten.select(number(END_BEATEN), end);
            active = active.and(settled.or(beaten).or(lost).not());
            // The last step of a converged descent is taken; others stay where they ended.
            for a in 0..2 {
                base[a] = settled.select(at[a] + step[a], base[a]);
                step[a] = active.select(step[a], zero);
            }
            if !active.any() {
                break;
            }
        }
        let half = [base[0] * number(0.5), base[1] * number(0.5)];
        let (moments, laplacian) = self.sums.at(self.simd, half, workspace);
        let branch = self.contraction.branch(moments, self.sign);
        let value = if self.scaled {
            branch / laplacian
        } else {
            branch
        };
        base[0].write(&mut descents.phases[0], group);
        base[1].write(&mut descents.phases[1], group);
        value.write(&mut descents.values, group);
        end.write(&mut descents.ends, group);
    }

    /// Returns true if the objective falls toward long waves and their limit is known to be lower.
    #[inline(always)]
    fn falls_to_the_limit(
        &self,
        local: &Local<Pack<S>>,
        at: [Pack<S>; 2],
        floor: Pack<S>,
    ) -> Mask<S> {
        let number = |value: f64| Pack::splat(self.simd, value);
        let square = at[0].times_plus(at[0], at[1] * at[1]);
        let radial = at[0].times_plus(local.slope[0], at[1] * local.slope[1]);
        let reach = if self.scaled { LIMIT_BASIN_PHASE } else { 0.0 };
        let near = square.is_below(number(reach * reach));
        let too_long = square.is_below(number(if self.scaled {
            LONG_WAVE_PHASE * LONG_WAVE_PHASE
        } else {
            0.0
        }));
        near.and(floor.is_at_most(local.value))
            .and(number(0.0).is_at_most(radial))
            .or(too_long)
    }

    /// Objective with its derivatives.
    #[inline(always)]
    fn local(&self, at: [Pack<S>; 2], workspace: &mut Workspace<S>) -> Local<Pack<S>> {
        let half = Pack::splat(self.simd, 0.5);
        let (h, laplacian) = self
            .sums
            .local_at(self.simd, [at[0] * half, at[1] * half], workspace);
        self.branch(&h, &laplacian)
    }

    /// Objective from `H` and the lattice Laplacian with their derivatives.
    #[inline(always)]
    fn branch(&self, h: &[Local<Pack<S>>; 3], laplacian: &Local<Pack<S>>) -> Local<Pack<S>> {
        let number = |value: f64| Pack::splat(self.simd, value);
        let value = self.contraction.parts([h[0].value, h[1].value, h[2].value]);
        let mut slope = [value; 2];
        for a in 0..2 {
            slope[a] = self
                .contraction
                .parts([h[0].slope[a], h[1].slope[a], h[2].slope[a]]);
        }
        let mut curvature = [value; 3];
        for a in 0..3 {
            curvature[a] =
                self.contraction
                    .parts([h[0].curvature[a], h[1].curvature[a], h[2].curvature[a]]);
        }
        // The value is `sign * mean - root` with `root^2 = half^2 + mixed^2`.
        let root = value[1].times_plus(value[1], value[2] * value[2]).sqrt();
        let inverse = number(1.0) / root;
        let mut turn = [root; 2];
        for a in 0..2 {
            turn[a] = value[1].times_plus(slope[a][1], value[2] * slope[a][2]) * inverse;
        }
        let mut branch = Local {
            value: self.sign.times_plus(value[0], -root),
            slope: [root; 2],
            curvature: [root; 3],
        };
        for a in 0..2 {
            branch.slope[a] = self.sign.times_plus(slope[a][0], -turn[a]);
        }
        for (p, (a, b)) in [(0, 0), (0, 1), (1, 1)].into_iter().enumerate() {
            let bend = slope[a][1].times_plus(
                slope[b][1],
                slope[a][2].times_plus(
                    slope[b][2],
                    value[1].times_plus(curvature[p][1], value[2] * curvature[p][2]),
                ),
            );
            let root_curvature = (bend - turn[a] * turn[b]) * inverse;
            branch.curvature[p] = self.sign.times_plus(curvature[p][0], -root_curvature);
        }
        if !self.scaled {
            return branch;
        }
        let inverse = number(1.0) / laplacian.value;
        let quotient = branch.value * inverse;
        let mut scaled = Local {
            value: quotient,
            ..branch
        };
        for a in 0..2 {
            scaled.slope[a] = (-quotient).times_plus(laplacian.slope[a], branch.slope[a]) * inverse;
        }
        for (p, (a, b)) in [(0, 0), (0, 1), (1, 1)].into_iter().enumerate() {
            let rest = scaled.slope[a].times_plus(
                laplacian.slope[b],
                scaled.slope[b].times_plus(laplacian.slope[a], quotient * laplacian.curvature[p]),
            );
            scaled.curvature[p] = (branch.curvature[p] - rest) * inverse;
        }
        scaled
    }
}

struct NewtonStep<S: Simd> {
    step: [Pack<S>; 2],
    /// Squared length of the step before it is limited.
    square: Pack<S>,
    is_convex: Mask<S>,
}

/// Newton step with the magnitudes of the principal curvatures, so that it is a descent step; its length is limited to `LONGEST_STEP_PHASE`.
#[inline(always)]
fn newton_step<S: Simd>(local: &Local<Pack<S>>) -> NewtonStep<S> {
    let number = |value: f64| local.value.constant(value);
    let [xx, xy, yy] = local.curvature;
    let [x, y] = local.slope;
    let half = number(0.5);
    let (mean, difference) = ((xx + yy) * half, (xx - yy) * half);
    let radius = difference.times_plus(difference, xy * xy).sqrt();
    let (low, high) = (mean - radius, mean + radius);
    let tiny = low.abs().max(high.abs()) * number(1e-12);
    let (small, large) = (low.abs().max(tiny), high.abs().max(tiny));
    // `|C|^-1 = a + b C` on both principal axes; if both curvatures are positive, this is `(tr C - C) / det C`.
    let is_convex = tiny.is_below(low);
    let product = number(1.0) / (small * large);
    let spread = number(1.0) / (radius + radius);
    let b = is_convex.select(-product, (small - large) * product * spread);
    let a = is_convex.select((mean + mean) * product, number(1.0) / large - b * high);
    let step = [
        -(a * x + b * xx.times_plus(x, xy * y)),
        -(a * y + b * xy.times_plus(x, yy * y)),
    ];
    let square = step[0].times_plus(step[0], step[1] * step[1]);
    let limit = number(LONGEST_STEP_PHASE);
    let factor = number(1.0).min(limit / square.sqrt());
    NewtonStep {
        step: [step[0] * factor, step[1] * factor],
        square,
        is_convex,
    }
}
