//! The long-wave limit: the smallest eigenvalue over all directions, for many tangents.

use super::contraction::{Columns, Contraction};
use crate::algebra::{Pack, array_of};
use pulp::{Simd, WithSimd};

/// Number of directions that are sampled before the descent.
const SAMPLED_DIRECTIONS: usize = 16;
/// Number of Newton steps.
const NEWTON_STEPS: usize = 6;
/// Largest relative height of the second well above the first at which a descent also follows the second.
const RIVAL_WELL_HEIGHT: f64 = 0.2;
/// Largest last step of a converged descent, in the doubled angle (radians).
const STEP_TOLERANCE: f64 = 1e-6;
/// Rounding error of a slope, relative to the value.
const SLOPE_ROUNDING: f64 = 1e-13;

/// `H(k) / |k|_h^2` for long waves: `h0 + hc cos t + hs sin t` in the doubled angle `t`, for each entry.
pub(super) type LongMoments = [[f64; 3]; 3];

/// Minima, with the cosine and sine of the doubled angle. Converged if `unsettled` is zero.
pub(super) struct LongMinima {
    pub(super) values: Vec<f64>,
    pub(super) turns: [Vec<f64>; 2],
    pub(super) unsettled: Vec<f64>,
}

/// Vectorized search for the instruction set of the machine.
pub(super) struct LongWaves<'a> {
    pub(super) moments: &'a LongMoments,
    pub(super) columns: &'a Columns,
}

impl WithSimd for LongWaves<'_> {
    type Output = LongMinima;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> LongMinima {
        let length = self.columns.length();
        let mut minima = LongMinima {
            values: vec![0.0; length],
            turns: [vec![0.0; length], vec![0.0; length]],
            unsettled: vec![0.0; length],
        };
        let number = |value: f64| Pack::splat(simd, value);
        let zero = number(0.0);
        let circle = circle();
        for group in 0..length / S::F64_LANES {
            let contraction = Contraction::<S, false>::of(simd, self.columns, group);
            let mut parts = [[zero; 3]; 3];
            for p in 0..3 {
                parts[p] = contraction.parts([
                    number(self.moments[0][p]),
                    number(self.moments[1][p]),
                    number(self.moments[2][p]),
                ]);
            }
            let ring = Ring { parts };
            let mut samples = [zero; SAMPLED_DIRECTIONS];
            for n in 0..SAMPLED_DIRECTIONS {
                samples[n] = ring.at(number(circle[n][0]), number(circle[n][1])).value;
            }
            let infinite = number(f64::INFINITY);
            let (mut best, mut second) = ([infinite, zero, zero], [infinite, zero, zero]);
            for n in 0..SAMPLED_DIRECTIONS {
                let (left, right) = (
                    samples[(n + SAMPLED_DIRECTIONS - 1) % SAMPLED_DIRECTIONS],
                    samples[(n + 1) % SAMPLED_DIRECTIONS],
                );
                let value = samples[n];
                let is_well = value.is_below(left).and(value.is_at_most(right));
                let is_best = is_well.and(value.is_below(best[0]));
                let is_second = is_well.and(value.is_below(second[0]));
                let here = [value, number(circle[n][0]), number(circle[n][1])];
                for p in 0..3 {
                    second[p] = is_best.select(best[p], is_second.select(here[p], second[p]));
                    best[p] = is_best.select(here[p], best[p]);
                }
            }
            // No well exists if all directions are equal.
            let is_flat = best[0].is_at_most(samples[0]).not();
            best[0] = is_flat.select(samples[0], best[0]);
            best[1] = is_flat.select(number(1.0), best[1]);
            let rival = best[0].abs().times_plus(number(RIVAL_WELL_HEIGHT), best[0]);
            let (mut found, mut moved) = ring.descended(best);
            let has_rival = second[0].is_at_most(rival);
            if has_rival.any() {
                let (other, other_moved) = ring.descended(second);
                let is_lower = has_rival.and(other[0].is_below(found[0]));
                for p in 0..3 {
                    found[p] = is_lower.select(other[p], found[p]);
                }
                moved = has_rival.select(moved.max(other_moved), moved);
            }
            found[0].write(&mut minima.values, group);
            found[1].write(&mut minima.turns[0], group);
            found[2].write(&mut minima.turns[1], group);
            let unsettled = moved.is_at_most(number(STEP_TOLERANCE)).not();
            unsettled
                .select(number(1.0), zero)
                .write(&mut minima.unsettled, group);
        }
        minima
    }
}

/// Cosines and sines of the sampled directions.
fn circle() -> [[f64; 2]; SAMPLED_DIRECTIONS] {
    array_of(|n| {
        let (sine, cosine) =
            (std::f64::consts::TAU * n as f64 / SAMPLED_DIRECTIONS as f64).sin_cos();
        [cosine, sine]
    })
}

/// Components `(D_11 + D_22) / 2`, `(D_11 - D_22) / 2` and `D_12` as trigonometric polynomials of first order in the doubled angle.
struct Ring<S: Simd> {
    parts: [[Pack<S>; 3]; 3],
}

/// Smaller eigenvalue on the ring with its derivatives with respect to the angle.
struct OnRing<S: Simd> {
    value: Pack<S>,
    slope: Pack<S>,
    curvature: Pack<S>,
}

impl<S: Simd> Ring<S> {
    #[inline(always)]
    fn at(&self, cosine: Pack<S>, sine: Pack<S>) -> OnRing<S> {
        let [constant, c, s] = self.parts;
        let mut turning = [cosine; 3];
        let mut slope = [cosine; 3];
        for q in 0..3 {
            turning[q] = c[q].times_plus(cosine, s[q] * sine);
            slope[q] = s[q].times_plus(cosine, -(c[q] * sine));
        }
        let half = constant[1] + turning[1];
        let mixed = constant[2] + turning[2];
        let root = half.times_plus(half, mixed * mixed).sqrt();
        let inverse = cosine.constant(1.0) / root;
        let turn = half.times_plus(slope[1], mixed * slope[2]) * inverse;
        // The second derivative of a first harmonic is its negative.
        let bend = slope[1].times_plus(slope[1], slope[2] * slope[2])
            - half.times_plus(turning[1], mixed * turning[2]);
        OnRing {
            value: constant[0] + turning[0] - root,
            slope: slope[0] - turn,
            curvature: -turning[0] - (bend - turn * turn) * inverse,
        }
    }

    /// Value, cosine and sine after descending Newton steps, and the magnitude of the last step.
    #[inline(always)]
    fn descended(&self, start: [Pack<S>; 3]) -> ([Pack<S>; 3], Pack<S>) {
        let [_, mut cosine, mut sine] = start;
        let zero = cosine.constant(0.0);
        let mut here = self.at(cosine, sine);
        let mut moved = zero;
        for _ in 0..NEWTON_STEPS {
            let is_convex = zero.is_below(here.curvature);
            let is_flat = here
                .slope
                .abs()
                .is_at_most(here.value.abs() * zero.constant(SLOPE_ROUNDING));
            let step = -(here.slope / here.curvature);
            moved = is_convex.select(step.abs(), is_flat.select(zero, zero.constant(1.0)));
            // A step along the tangent, projected back to the circle: for short steps this is a rotation.
            let length = zero.constant(1.0) / step.times_plus(step, zero.constant(1.0)).sqrt();
            let there = [
                (-step).times_plus(sine, cosine) * length,
                step.times_plus(cosine, sine) * length,
            ];
            let next = self.at(there[0], there[1]);
            let is_lower = is_convex.and(next.value.is_below(here.value));
            here = OnRing {
                value: is_lower.select(next.value, here.value),
                slope: is_lower.select(next.slope, here.slope),
                curvature: is_lower.select(next.curvature, here.curvature),
            };
            cosine = is_lower.select(there[0], cosine);
            sine = is_lower.select(there[1], sine);
        }
        let value = here.value;
        ([value, cosine, sine], moved)
    }
}
