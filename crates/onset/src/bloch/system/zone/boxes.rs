//! Boxes between grid points in which a branch may fall lower.

use super::sample::{Branches, TRACKED_BRANCHES, UNKNOWN, half};
use super::{BOX_DIVISIONS, Candidate, Objective, Sweep};
use crate::algebra::{Each, array_of, sort_by_value};
use crate::bloch::search::neighbors;
use crate::lattice::grid_coordinates;
use nalgebra::{SMatrix, SVector};

/// Change of a branch within half a grid step, as a fraction of its change within a whole step. It exceeds one half because branches curve.
const HALF_STEP_CHANGE: f64 = 0.6;

/// Box of wave vectors around a center.
pub(super) struct Region<const D: usize> {
    pub(super) center: SVector<f64, D>,
    /// Values of the objective for the lowest branches at the center.
    pub(super) branches: Branches,
    /// Branch with the lowest estimated values in the box, its estimated lower limit from the slope, and its expected minimum.
    pub(super) branch: usize,
    pub(super) bound: f64,
    expected: f64,
}

/// Estimated fall of a branch within a box: the largest and the expected one.
#[derive(Clone, Copy)]
struct Fall {
    most: f64,
    expected: f64,
}

impl<const D: usize> Region<D> {
    /// Creates a box from the estimated fall of each branch.
    fn new(center: SVector<f64, D>, branches: Branches, falls: impl Fn(usize) -> Fall) -> Self {
        let lowest = branches.iter().enumerate();
        let bounds = lowest.map(|(n, value)| (n, value - falls(n).most, value - falls(n).expected));
        let (branch, bound, expected) =
            bounds
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap_or((0, f64::INFINITY, f64::INFINITY));
        Self {
            center,
            branches,
            branch,
            bound,
            expected,
        }
    }
}

impl Fall {
    const NONE: Self = Self::of(0.0);

    const fn of(change: f64) -> Self {
        Self {
            most: change,
            expected: change,
        }
    }

    /// Fall within half a grid step in both directions, from the changes over the whole steps ahead and behind.
    ///
    /// The expected fall follows from the parabola through the three points if it is convex; otherwise the change is linear.
    fn between(ahead: f64, behind: f64) -> Self {
        let steepest = ahead.abs().max(behind.abs());
        let (slope, curvature) = (0.5 * (ahead - behind).abs(), ahead + behind);
        let expected = if slope < HALF_STEP_CHANGE * curvature {
            0.5 * slope * slope / curvature
        } else {
            HALF_STEP_CHANGE * steepest
        };
        Self {
            most: HALF_STEP_CHANGE * steepest,
            expected,
        }
    }

    fn or(self, other: Self) -> Self {
        Self {
            most: self.most.max(other.most),
            expected: self.expected.max(other.expected),
        }
    }
}

impl<const D: usize> Sweep<'_, D> {
    /// Small boxes in which a branch may fall below `below`, estimated from its changes around them.
    ///
    /// The boxes around the grid points are halved repeatedly; boxes of known bottoms are omitted.
    pub(super) fn regions(
        &self,
        objective: Objective,
        branches: Vec<Branches>,
        below: f64,
        known: &[Candidate<D>],
    ) -> Vec<Region<D>> {
        let (n, count) = (self.waves.resolution(), branches.len());
        let fall = |around: &[usize], index: usize, branch: usize| {
            let change = |other: &usize| {
                let change = branches[*other][branch] - branches[index][branch];
                change.is_finite().then_some(change)
            };
            let falls = around.iter().zip(around.iter().rev()).map(|pair| {
                let [ahead, behind] = [change(pair.0), change(pair.1)];
                let [ahead, behind] =
                    [ahead.or(behind), behind.or(ahead)].each(|x| x.unwrap_or(0.0));
                Fall::between(ahead, behind)
            });
            falls.fold(Fall::NONE, Fall::or)
        };
        let wave_vectors = half(&self.waves);
        let around = |index: usize| {
            // Opposite neighbors have the same distance from the ends of the list.
            let around: Vec<usize> = neighbors::<D>(index, n, count).collect();
            Region::new(wave_vectors[index], branches[index], |branch| {
                fall(&around, index, branch)
            })
        };
        let mut regions: Vec<Region<D>> = (1..count).map(around).collect();
        // No grid point describes the neighborhood of `k = 0`.
        regions.push(Region {
            center: SVector::zeros(),
            branches: UNKNOWN,
            branch: 0,
            bound: f64::NEG_INFINITY,
            expected: f64::NEG_INFINITY,
        });
        let mut step = self.search.reference().reciprocal() / n as f64;
        let mut side = 1.0;
        for _ in 0..BOX_DIVISIONS {
            regions.retain(|region| !self.is_known(region, known, side));
            chosen(&mut regions, below, self.effort.boxes);
            regions = self.divided(objective, &regions, &step);
            step *= 0.5;
            side *= 0.5;
        }
        regions.retain(|region| !self.is_known(region, known, side));
        chosen(&mut regions, below, self.effort.leaves);
        regions
    }

    /// Returns true if a box, with the given side in grid steps, contains a known bottom of its lowest branch.
    fn is_known(&self, region: &Region<D>, known: &[Candidate<D>], side: f64) -> bool {
        let is_lowest = region.branch == 0 && region.branches[0].is_finite();
        is_lowest && self.is_near_bottom(&region.center, known, side)
    }

    /// Divides boxes with the given sides into halves along each axis.
    fn divided(
        &self,
        objective: Objective,
        regions: &[Region<D>],
        sides: &SMatrix<f64, D, D>,
    ) -> Vec<Region<D>> {
        let corner = |part: usize| {
            let sides = grid_coordinates::<D>(part, 2);
            SVector::from(sides.each(|side| 0.5 * side as f64 - 0.25))
        };
        let centers: Vec<SVector<f64, D>> = regions
            .iter()
            .flat_map(|region| (0..1 << D).map(|part| region.center + sides * corner(part)))
            .collect();
        let branches = self.branches_at(objective, &centers);
        let parts = centers.chunks(1 << D).zip(branches.chunks(1 << D));
        let both = regions.iter().zip(parts);
        both.flat_map(|(region, (centers, branches))| parts_of(region, centers, branches))
            .collect()
    }
}

/// Parts of a box, given the branches at their centers.
fn parts_of<const D: usize>(
    region: &Region<D>,
    centers: &[SVector<f64, D>],
    branches: &[Branches],
) -> Vec<Region<D>> {
    // The distance from the center to the centers of the parts equals the distance from these to their corners.
    let fall = |branch: usize| {
        let values = || branches.iter().map(|part| part[branch]);
        let middle = match region.branches[branch] {
            value if value.is_finite() => value,
            _ => values().fold(f64::INFINITY, f64::min),
        };
        let changes = values().map(|value| (value - middle).abs());
        changes.filter(|x| x.is_finite()).fold(0.0, f64::max)
    };
    let falls: [Fall; TRACKED_BRANCHES] = array_of(|branch| Fall::of(fall(branch)));
    let parts = centers.iter().zip(branches);
    parts
        .map(|(k, branches)| Region::new(*k, *branches, |branch| falls[branch]))
        .collect()
}

/// Keeps the boxes that may contain a value below `below`, at most `most` of them.
fn chosen<const D: usize>(regions: &mut Vec<Region<D>>, below: f64, most: usize) {
    regions.retain(|region| region.bound < below);
    sort_by_value(regions, |region| region.expected);
    regions.truncate(most);
}
