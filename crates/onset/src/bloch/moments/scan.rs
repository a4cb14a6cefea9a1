//! Where to descend from: the best candidate of each region of the zone, for many tangents.

use super::candidates::{Candidates, WIDEST_MARGIN, margin};
use super::contraction::{Columns, Contraction};
use crate::algebra::{Each, Pack};
use pulp::{Simd, WithSimd};

/// Where the lowest value is below this fraction of the largest one, wells are narrow beside the spacing of the grid:
const WEAK: f64 = 1e-3;
/// descents lead further down, and regions are looked into that lie by this fraction of the lowest value above it.
const RIVAL: f64 = 0.05;

/// That part of the margin. It is less than what the threshold of the scan has to spare.
fn rivalry(lowest: f64, scale: f64) -> f64 {
    if lowest.abs() < WEAK * scale {
        RIVAL * lowest.abs()
    } else {
        0.0
    }
}

/// A tangent and a candidate, by their numbers.
pub(super) type Start = (usize, usize);

/// Starts: the best of each tangent, and those in other regions that may lead lower.
#[derive(Clone, Debug, Default)]
pub(super) struct Starts {
    pub(super) best: Vec<Start>,
    pub(super) rivals: Vec<Start>,
}

/// Work for the widest vectors of the machine.
pub(super) struct Scan<'a, const D: usize, const MIRRORED: bool> {
    pub(super) candidates: &'a Candidates<D>,
    pub(super) columns: &'a Columns,
    /// One for the smaller eigenvalue, minus one for minus the larger.
    pub(super) sign: f64,
    /// For each tangent what is to be beaten.
    pub(super) limits: &'a [f64],
    /// The largest value of each tangent, padded like the columns.
    pub(super) scales: &'a [f64],
}

impl<const D: usize, const MIRRORED: bool> WithSimd for Scan<'_, D, MIRRORED> {
    type Output = Starts;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Starts {
        let lanes = S::F64_LANES;
        let regions = self.candidates.ends.len();
        let mut values = vec![0.0; regions * lanes];
        let mut indices = vec![0.0; regions * lanes];
        let mut lowest = vec![0.0; lanes];
        let mut starts = Starts::default();
        let sign = Pack::splat(simd, self.sign);
        let infinite = Pack::splat(simd, f64::INFINITY);
        let zero = Pack::splat(simd, 0.0);
        for group in 0..self.columns.length() / lanes {
            let contraction = Contraction::<S, MIRRORED>::of(simd, self.columns, group);
            let [near, soft] = WIDEST_MARGIN.each(|part| Pack::splat(simd, 3.0 * part));
            let soft = soft * Pack::of(simd, self.scales, group);
            let mut overall = infinite;
            let mut threshold = infinite;
            let mut first = 0;
            for (region, end) in self.candidates.ends.iter().enumerate() {
                let (mut best, mut index) = (infinite, infinite);
                for n in first..*end {
                    let [h11, h12, h22] = self.candidates.moments[n];
                    let h = [
                        Pack::splat(simd, h11),
                        Pack::splat(simd, h12),
                        Pack::splat(simd, h22),
                    ];
                    let [mean, half, mixed] = contraction.parts(h);
                    let square = half.times_plus(half, mixed * mixed);
                    // `mean - root <= threshold` without the root, which few candidates need.
                    let excess = mean.times_plus(sign, -threshold);
                    let matters = excess
                        .is_at_most(zero)
                        .or((excess * excess).is_at_most(square));
                    if !matters.any() {
                        continue;
                    }
                    let value = mean * sign - square.sqrt();
                    index = value
                        .is_below(best)
                        .select(Pack::splat(simd, n as f64), index);
                    best = best.min(value);
                    overall = overall.min(value);
                    // More than what is asked for below, whatever is rounded.
                    threshold = overall.abs().times_plus(near, overall + soft);
                }
                first = *end;
                best.write(&mut values, region);
                index.write(&mut indices, region);
            }
            overall.write(&mut lowest, 0);
            for lane in 0..lanes {
                let n = group * lanes + lane;
                let Some(limit) = self.limits.get(n) else {
                    break;
                };
                let best = lowest[lane];
                let margin = 2.0 * margin(best, self.scales[n]) + rivalry(best, self.scales[n]);
                if best - margin > *limit {
                    continue;
                }
                let mut is_first = true;
                for region in 0..regions {
                    let value = values[region * lanes + lane];
                    if value > best + margin {
                        continue;
                    }
                    let start = (n, indices[region * lanes + lane] as usize);
                    if value == best && is_first {
                        is_first = false;
                        starts.best.push(start);
                    } else {
                        starts.rivals.push(start);
                    }
                }
            }
        }
        starts
    }
}
