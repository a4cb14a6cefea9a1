//! Covers of the zone by boxes. On each box stability is proved, or a growing wave is found.

use super::expansion::{Expansion, Region};
use super::patch::{is_positive, smallest};
use super::waves::{Entries, Waves};
use crate::algebra::Each;
use crate::cancel::checkpoint;
use crate::real::{Interval, Real};
use std::collections::VecDeque;

/// Number slightly above pi with few binary digits, so that boxes are bisected without rounding.
const HALF_PERIOD: f64 = 25736.0 / 8192.0;
/// Number of boxes along the half period in the first cover.
const FIRST_BOXES: f64 = 4.0;
/// Number of boxes before candidate waves are requested: about the cost of a floating-point search.
const CANDIDATE_DELAY_BOXES: usize = 2_000;
/// Largest width, in half periods, of the zone of a lattice whose dynamical matrix is not periodic.
const LARGEST_ZONE: f64 = 16.0;

/// Zone, tolerances and budget of a cover. Measures compare `D` with `L = sum_i (1 - cos theta_i)`.
pub(super) struct Question<'a> {
    /// Half planes `m.theta <= offset` that bound the zone; empty if `D` is periodic.
    pub(super) zone: &'a [([f64; 2], f64)],
    /// Largest magnitude of a phase in the zone.
    pub(super) farthest: f64,
    /// Largest squared growth rate that does not count as instability, in units of `D`.
    pub(super) growth_squared: f64,
    /// Fraction of the smallest sampled measure that must be proved.
    pub(super) share: f64,
    /// Largest number of boxes.
    pub(super) budget: usize,
}

/// Result of a cover.
#[derive(Clone, Copy, Debug)]
pub(super) enum Finding {
    /// Lower bound of the measure over the whole zone.
    Bounded(f64),
    /// A growing wave, confirmed in interval arithmetic.
    Grows(GrowingWave),
    /// Undecided boxes remain. `measure` is the smallest sampled measure, and `is_growth` is true if only the growth of oscillations is undecided.
    Open { measure: f64, is_growth: bool },
}

/// Growing wave, confirmed in interval arithmetic.
#[derive(Clone, Copy, Debug)]
pub(super) struct GrowingWave {
    /// Phases `k.a_i` of the wave.
    pub(super) phases: [f64; 2],
    /// Bounds of the real part of `omega^2`, in units of `D`.
    pub(super) omega_squared: Interval,
    /// Lower bound of the squared growth rate.
    pub(super) growth_squared: f64,
}

/// Result of one attempt to prove a lower bound of the measure.
enum Attempt {
    Proved,
    Grows(GrowingWave),
    /// A wave with a smaller measure than the target was found.
    Lower(f64),
    Exhausted {
        is_growth: bool,
    },
}

/// Covers the zone by boxes and returns the result.
///
/// If many boxes remain, the waves that `candidates` returns are examined before the subdivision continues.
pub(super) fn cover(
    waves: &Waves,
    question: &Question,
    candidates: impl FnOnce() -> Vec<[f64; 2]>,
) -> Finding {
    let expansion = Expansion::new(waves);
    let open = Finding::Open {
        measure: f64::NAN,
        is_growth: false,
    };
    if !expansion.is_finite() || question.farthest > LARGEST_ZONE * HALF_PERIOD {
        return open;
    }
    let cover = Cover {
        expansion,
        question,
    };
    let first = cover.finding(question.budget.min(CANDIDATE_DELAY_BOXES));
    if !matches!(first, Finding::Open { .. }) {
        return first;
    }
    let mut waves = candidates()
        .into_iter()
        .filter(|phases| cover.is_inside(*phases));
    match waves.find_map(|phases| cover.confirmed(phases)) {
        Some(wave) => Finding::Grows(wave),
        None if question.budget > CANDIDATE_DELAY_BOXES => cover.finding(question.budget),
        None => first,
    }
}

/// Result at the center of a box.
enum Seen {
    Grows(GrowingWave),
    Measure(f64),
}

struct Cover<'a> {
    expansion: Expansion<'a>,
    question: &'a Question<'a>,
}

impl Cover<'_> {
    fn waves(&self) -> &Waves {
        self.expansion.waves
    }

    /// Returns true if long waves are covered along rays, which requires `D(0) = 0`.
    fn has_rays(&self) -> bool {
        self.waves().rigid.is_none()
    }

    fn rays(&self, count: usize, r2: (f64, f64)) -> Vec<Region> {
        if !self.has_rays() {
            return Vec::new();
        }
        if self.waves().dimension == 1 {
            return vec![Region::Rays {
                chart: 0,
                s: (0.0, 0.0),
                r2,
            }];
        }
        let half = 1.0 / count as f64;
        let along = |index: usize| (2.0 * index as f64 + 1.0) * half - 1.0;
        (0..2 * count)
            .map(|index| Region::Rays {
                chart: index / count,
                s: (along(index % count), half),
                r2,
            })
            .collect()
    }

    /// Boxes of phases of a regular cover of half of the zone, since `k` and `-k` are equivalent.
    fn phases(&self, half: f64) -> Vec<Region> {
        let count = (self.question.farthest / (2.0 * half)).ceil() as i64;
        let along = |index: i64| (2.0 * index as f64 + 1.0) * half;
        let mut boxes = Vec::new();
        if self.waves().dimension == 1 {
            boxes.extend((0..count).map(|i| Region::Phases {
                center: [along(i), 0.0],
                half,
            }));
        } else {
            for j in 0..count {
                boxes.extend((-count..count).map(|i| Region::Phases {
                    center: [along(i), along(j)],
                    half,
                }));
            }
        }
        boxes
    }

    fn samples(&self) -> Vec<Region> {
        let mut samples = self.rays(16, (0.0, 0.0));
        samples.extend(self.phases(HALF_PERIOD / (2.0 * FIRST_BOXES)));
        samples.retain(|region| !self.is_outside(region));
        samples
    }

    /// Returns true if a box lies outside the zone, with a margin that exceeds rounding.
    fn is_outside(&self, region: &Region) -> bool {
        let Region::Phases { center, half } = *region else {
            return false;
        };
        self.question.zone.iter().any(|(m, offset)| {
            let nearest = m[0] * center[0] + m[1] * center[1] - half * (m[0].abs() + m[1].abs());
            nearest > offset * (1.0 + 1e-9)
        })
    }

    /// Evaluates the center of a box.
    fn seen(&self, region: &Region) -> Seen {
        let (at_center, phases, laplacian) = self.center(region);
        if !self.is_inside(phases) {
            // The box overlaps the zone but its center lies outside, so the center gives no information.
            return Seen::Measure(f64::INFINITY);
        }
        let measure = smallest(&at_center) / laplacian;
        let trace = at_center[0] + at_center[3];
        let half = 0.5 * (at_center[0] - at_center[3]);
        let discriminant = half * half + at_center[1] * at_center[2];
        let is_suspect =
            measure < 0.0 || discriminant < -2.0 * self.question.growth_squared * trace.max(0.0);
        if is_suspect && let Some(wave) = self.confirmed(phases) {
            return Seen::Grows(wave);
        }
        Seen::Measure(measure)
    }

    /// Matrix `D` at the center of a box, the phases there, and `L`; for rays in units of `r^2`.
    fn center(&self, region: &Region) -> (Entries, [f64; 2], f64) {
        match *region {
            Region::Phases { center, .. } => {
                let point = Region::Phases { center, half: 0.0 };
                let values = self.expansion.patch(&point, 0.0).each(|patch| patch.value);
                let laplacian = (0..self.waves().dimension)
                    .map(|i| 2.0 * (0.5 * center[i]).sin().powi(2))
                    .sum();
                (values, center, laplacian)
            }
            Region::Rays { chart, s, r2 } => {
                let point = Region::Rays {
                    chart,
                    s: (s.0, 0.0),
                    r2: (0.0, 0.0),
                };
                let values = self.expansion.patch(&point, 0.0).each(|patch| patch.value);
                // The length is a compromise: rounding dominates for shorter wave vectors, terms of higher order for longer ones.
                let r = if r2.0 > 0.0 {
                    r2.0.sqrt()
                } else {
                    1e-4 / self.waves().reach.max(1) as f64
                };
                let phases = if chart == 0 {
                    [r, r * s.0]
                } else {
                    [r * s.0, r]
                };
                let is_planar = f64::from(u8::from(self.waves().dimension == 2));
                (values, phases, 0.5 * (1.0 + is_planar * s.0 * s.0))
            }
        }
    }

    fn is_inside(&self, phases: [f64; 2]) -> bool {
        let mut zone = self.question.zone.iter();
        zone.all(|(m, offset)| m[0] * phases[0] + m[1] * phases[1] <= offset * (1.0 + 1e-9))
    }

    /// Wave at the given phases, if its growth is certain.
    fn confirmed(&self, phases: [f64; 2]) -> Option<GrowingWave> {
        let [m11, m12, m21, m22] = self.expansion.confirmed(phases);
        let half_trace = (m11 + m22) * 0.5;
        let half = (m11 - m22) * 0.5;
        let discriminant = half.square() + m12 * m21;
        let determinant = m11 * m22 - m12 * m21;
        let root = discriminant.hull(Interval::ZERO);
        let root = Interval::new(root.low.max(0.0), root.high).sqrt();
        let mut omega_squared = half_trace - root;
        if determinant.high < 0.0 || (half_trace.high < 0.0 && discriminant.low >= 0.0) {
            // The eigenvalues are real and at least one is negative. If the signs differ, divide to avoid cancellation.
            let larger = half_trace + root;
            if determinant.high < 0.0 && larger.low > 0.0 {
                omega_squared = determinant / larger;
            }
            // The magnitude of the negative value must be certain too.
            if omega_squared.high < 0.0 {
                return Some(GrowingWave {
                    phases,
                    omega_squared,
                    growth_squared: -omega_squared.high,
                });
            }
        }
        if half_trace.high < 0.0 {
            return Some(GrowingWave {
                phases,
                omega_squared,
                growth_squared: -half_trace.high,
            });
        }
        if discriminant.high < 0.0 {
            // -(Im omega)^2 = (|w| - Re w) / 2 with w = a + i b, written without cancellation: b^2 / (2 (|w| + a)).
            let b_squared = -discriminant;
            let size = (half_trace.square() + b_squared).sqrt();
            let growth_squared = b_squared / ((size + half_trace) * 2.0);
            if growth_squared.low > self.question.growth_squared {
                return Some(GrowingWave {
                    phases,
                    omega_squared: half_trace,
                    growth_squared: growth_squared.low,
                });
            }
        }
        None
    }

    /// Coefficients of the tolerated growth on a box, for the test of the discriminant.
    fn growth(&self, region: &Region) -> Option<(f64, f64)> {
        if self.waves().is_symmetric {
            return None;
        }
        // The growth rate is at most g if -disc <= 4 g^2 (g^2 + trace / 2).
        let g = self.question.growth_squared;
        Some(match *region {
            Region::Phases { .. } => (4.0 * g * g * (1.0 - 1e-15), 2.0 * g),
            // In units of r^4: the trace of D / r^2 divided by r^2.
            Region::Rays { r2, .. } => (0.0, 2.0 * g / (r2.0 + r2.1) * (1.0 - 1e-15)),
        })
    }

    fn finding(&self, budget: usize) -> Finding {
        // A few samples give the first target and often a growing wave.
        let mut smallest = f64::INFINITY;
        for region in self.samples() {
            match self.seen(&region) {
                Seen::Grows(wave) => return Finding::Grows(wave),
                Seen::Measure(measure) => smallest = smallest.min(measure),
            }
        }
        loop {
            // If the target is zero to rounding or less, only a growing wave can be found.
            let target = self.question.share * smallest.max(0.0);
            match self.attempt(target, budget) {
                Attempt::Proved => return Finding::Bounded(target.next_down()),
                Attempt::Grows(wave) => return Finding::Grows(wave),
                Attempt::Lower(measure) => smallest = measure,
                Attempt::Exhausted { is_growth } => {
                    return Finding::Open {
                        measure: smallest,
                        is_growth,
                    };
                }
            }
        }
    }

    /// Tries to prove that the measure is at least `target` everywhere.
    fn attempt(&self, target: f64, budget: usize) -> Attempt {
        let first = HALF_PERIOD / (2.0 * FIRST_BOXES);
        // Long waves are covered by rays where the remainder of the expansion is small compared with the target.
        let mut inner = 2.0 * first;
        let limit = (0.1 * target / self.expansion.sixth()).sqrt().sqrt();
        while inner > limit && inner > 1e-4 {
            inner *= 0.5;
        }
        if !self.has_rays() {
            inner = 0.0;
        }
        let inner_squared = inner * inner;
        let mut queue: VecDeque<Region> = self
            .rays(8, (0.5 * inner_squared, 0.5 * inner_squared))
            .into();
        queue.extend(self.phases(first));
        let mut boxes = 0;
        let mut is_growth = false;
        while let Some(region) = queue.pop_front() {
            checkpoint();
            if self.is_outside(&region) || is_within(&region, inner) {
                continue;
            }
            let patch = self.expansion.patch(&region, target);
            if is_positive(&patch, self.growth(&region)) {
                continue;
            }
            let measure = match self.seen(&region) {
                Seen::Grows(wave) => return Attempt::Grows(wave),
                Seen::Measure(measure) => measure,
            };
            if measure > 0.0 && measure < 1.05 * target {
                return Attempt::Lower(measure);
            }
            boxes += 1;
            if boxes > budget {
                is_growth |= self.growth(&region).is_some() && is_positive(&patch, None);
                return Attempt::Exhausted { is_growth };
            }
            queue.extend(halves(&region, self.waves().dimension));
        }
        Attempt::Proved
    }
}

/// Returns true if a box lies in the square of long waves.
fn is_within(region: &Region, inner: f64) -> bool {
    match *region {
        Region::Phases { center, half } => center.iter().all(|x| x.abs() + half <= inner),
        Region::Rays { .. } => false,
    }
}

fn halves(region: &Region, dimension: usize) -> Vec<Region> {
    match *region {
        Region::Phases { center, half } => {
            let half = 0.5 * half;
            let signs = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
            let shifted = |(x, y): (f64, f64)| Region::Phases {
                center: [
                    center[0] + x * half,
                    if dimension == 1 {
                        center[1]
                    } else {
                        center[1] + y * half
                    },
                ],
                half,
            };
            let count = if dimension == 1 { 2 } else { 4 };
            signs[..count].iter().copied().map(shifted).collect()
        }
        Region::Rays { chart, s, r2 } => {
            let split = |(center, half): (f64, f64)| {
                let half = 0.5 * half;
                [(center - half, half), (center + half, half)]
            };
            let mut regions = Vec::with_capacity(4);
            for r2 in split(r2) {
                if dimension == 1 {
                    regions.push(Region::Rays { chart, s, r2 });
                } else {
                    regions.extend(split(s).each(|s| Region::Rays { chart, s, r2 }));
                }
            }
            regions
        }
    }
}
