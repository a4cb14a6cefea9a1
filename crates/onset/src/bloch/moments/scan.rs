//! The best candidate of each region of the zone, for many tangents.

use super::candidates::Candidates;
use super::contraction::{Columns, Contraction};
use crate::algebra::Pack;
use pulp::{Simd, WithSimd};

/// The best value of each region and its candidate, a column of each for a region.
#[derive(Clone, Debug)]
pub(super) struct Found {
    /// Values at `[region * length + tangent]`.
    pub(super) values: Vec<f64>,
    /// Numbers of candidates, likewise.
    pub(super) indices: Vec<f64>,
    /// The best value of all regions.
    pub(super) best: Vec<f64>,
}

/// Work for the widest vectors of the machine.
pub(super) struct Scan<'a, const D: usize, const MIRRORED: bool> {
    pub(super) candidates: &'a Candidates<D>,
    pub(super) columns: &'a Columns,
    /// One for the smaller eigenvalue, minus one for minus the larger.
    pub(super) sign: f64,
}

impl<const D: usize, const MIRRORED: bool> WithSimd for Scan<'_, D, MIRRORED> {
    type Output = Found;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Found {
        let length = self.columns.length();
        let regions = self.candidates.ends.len();
        let mut found = Found {
            values: vec![0.0; regions * length],
            indices: vec![0.0; regions * length],
            best: vec![0.0; length],
        };
        let sign = Pack::splat(simd, self.sign);
        let infinite = Pack::splat(simd, f64::INFINITY);
        let groups = length / S::F64_LANES;
        for group in 0..groups {
            let contraction = Contraction::<S, MIRRORED>::of(simd, self.columns, group);
            let mut overall = infinite;
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
                    let value = contraction.branch(h, sign);
                    index = value
                        .is_below(best)
                        .select(Pack::splat(simd, n as f64), index);
                    best = best.min(value);
                }
                first = *end;
                best.write(&mut found.values, region * groups + group);
                index.write(&mut found.indices, region * groups + group);
                overall = overall.min(best);
            }
            overall.write(&mut found.best, group);
        }
        found
    }
}
