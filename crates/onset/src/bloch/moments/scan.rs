//! Selection of starts: the best candidate of each region of the zone, for many tangents.

use super::candidates::{Candidates, WIDEST_MARGIN, margin};
use super::contraction::{Columns, Contraction};
use crate::algebra::{Each, Pack};
use pulp::{Simd, WithSimd};

/// Largest ratio of the lowest to the largest value at which wells are narrow compared with the grid spacing.
const NARROW_WELL_RATIO: f64 = 1e-3;
/// Additional height, as a fraction of the lowest value, of regions in which descents start if wells are narrow; these descents then reach lower
/// values.
const NARROW_WELL_MARGIN: f64 = 0.05;

/// Additional margin for narrow wells. It is smaller than the reserve in the threshold of the scan.
fn rivalry(lowest: f64, scale: f64) -> f64 {
    if lowest.abs() < NARROW_WELL_RATIO * scale {
        NARROW_WELL_MARGIN * lowest.abs()
    } else {
        0.0
    }
}

/// Index of a tangent and index of a candidate.
pub(super) type Start = (usize, usize);

/// Starts of descents: the best candidate of each tangent, and candidates of other regions that may lead to lower values.
#[derive(Clone, Debug, Default)]
pub(super) struct Starts {
    pub(super) best: Vec<Start>,
    pub(super) rivals: Vec<Start>,
}

/// Vectorized selection for the instruction set of the machine.
pub(super) struct Scan<'a, const D: usize, const MIRRORED: bool> {
    pub(super) candidates: &'a Candidates<D>,
    pub(super) columns: &'a Columns,
    /// Sign of the objective: 1 for the smaller eigenvalue, -1 for the negative of the larger eigenvalue.
    pub(super) sign: f64,
    /// Upper limits of the values that the tangents must reach.
    pub(super) limits: &'a [f64],
    /// Largest value of each tangent, padded like the columns.
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
                    // This margin exceeds the one below, rounding included.
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
