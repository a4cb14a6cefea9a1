//! Minimum of a function of the wave vector.

use super::{Candidate, FOLLOWED_GROWTH_RATIO, Objective, Sweep};
use crate::algebra::{Each, array_of};
use crate::bloch::search::settled_along;
use crate::lattice::grid_coordinates;
use nalgebra::SVector;
use std::f64::consts::FRAC_1_SQRT_2;

/// Ratios of short to long steps in a narrow valley.
const VALLEY_WIDTHS: [f64; 3] = [0.1, 1e-2, 1e-3];
/// Minimum fraction of the largest known growth rate at which the best point of shells of long waves is followed. The peak can lie between two shells.
const FOLLOWED_SHELL_RATIO: f64 = 0.4;
/// Half the side of the cube of points around `k = 0`, in grid steps: the largest shell of long waves.
const SHELL_STEPS: usize = 4;

impl<const D: usize> Sweep<'_, D> {
    /// Minimum of the function: over the bottoms from the grid, from pockets of complex `omega^2`, and from long waves.
    pub(super) fn least(&self) -> Candidate<D> {
        let objective = Objective::Function;
        let mut ends = self.bottoms(objective, f64::INFINITY);
        let deepest =
            |ends: &[Candidate<D>]| ends.iter().map(|end| end.0).fold(f64::INFINITY, f64::min);
        let is_damped = self.system.damping().is_some();
        if !self.system.is_hermitian() {
            let meetings = if is_damped {
                Vec::new()
            } else {
                self.meetings()
            };
            for k in self.pockets(0.0).into_iter().chain(meetings) {
                let start = (self.value(objective, &k), k);
                if may_beat(start.0, deepest(&ends), FOLLOWED_GROWTH_RATIO) {
                    ends.push(self.followed(objective, start));
                }
            }
        }
        // For long damped waves two amplification factors of a time step coincide to rounding and do not limit the step.
        if is_damped {
            return least_of_all(ends);
        }
        // Shells around `k = 0`, half an octave apart: the minimum of a function that vanishes with `k` can lie at any distance from `k = 0`.
        // On the best shell `k^2 - k^4` is at least 8/9 of its maximum, enough to be followed.
        let step = self.search.reference().reciprocal() / self.waves.resolution() as f64;
        let places = self.shell();
        let shells: Vec<(f64, Vec<Candidate<D>>)> =
            std::iter::successors(Some(1.0), |size| Some(FRAC_1_SQRT_2 * size))
                .map(|size| {
                    let start = |place: &SVector<f64, D>| {
                        let k = step * (place * size);
                        (self.value(objective, &k), k)
                    };
                    (size, places.iter().map(start).collect::<Vec<_>>())
                })
                .take_while(|(_, starts)| starts.iter().any(|start| start.0.is_finite()))
                .collect();
        let is_beside =
            |a: &SVector<f64, D>, b: &SVector<f64, D>| (a - b).amax().min((a + b).amax()) <= 1.0;
        for (n, (size, starts)) in shells.iter().enumerate() {
            for (number, start) in starts.iter().enumerate() {
                let beside = starts.iter().zip(&places);
                let beside = beside.filter(|(_, place)| is_beside(place, &places[number]));
                let shells = [shells.get(n + 1), shells.get(n.wrapping_sub(1))];
                let along = shells.into_iter().flatten().map(|(_, own)| &own[number]);
                let mut others = beside.map(|(other, _)| other).chain(along);
                if others.all(|other| start.0 <= other.0)
                    && may_beat(start.0, deepest(&ends), FOLLOWED_SHELL_RATIO)
                {
                    ends.push(self.settled(objective, *start, &(step * *size)));
                }
            }
        }
        self.along_valley(least_of_all(ends))
    }

    /// Minimum of the function near the end of a descent. Descents take long steps along the ray from `k = 0` and short steps across it, and vice
    /// versa, because a pocket of growing waves can be a narrow sector, or a narrow part of a ring.
    fn along_valley(&self, mut best: Candidate<D>) -> Candidate<D> {
        let length = best.1.norm();
        if length == 0.0 || !best.0.is_finite() {
            return best;
        }
        let step = self.search.reference().reciprocal().column(0).norm();
        let size = length.min(step / self.waves.resolution() as f64);
        let at = |all: &[SVector<f64, D>]| -> Vec<f64> {
            let branches = self.branches_at(Objective::Function, all).into_iter();
            branches.map(|own| own[0]).collect()
        };
        for width in VALLEY_WIDTHS {
            for [along, across] in [[1.0, width], [width, 1.0]] {
                let mut steps = orthonormal(&best.1).each(|axis| axis * (size * across));
                steps[0] *= along / across;
                best = settled_along(&at, best, &steps);
            }
        }
        best
    }

    /// Points on the surface of a cube around zero, in grid steps, one of each pair of opposite points. Waves that grow can fill a narrow sector, so that
    /// points along the directions of the softest and the fastest fluttering long waves are added.
    pub(super) fn shell(&self) -> Vec<SVector<f64, D>> {
        let softest = self.search.long_wave_mode(&self.stiffness).wave_vector;
        let fluttering = self.search.long_flutter(&self.stiffness, 1.0);
        let along = std::iter::once(softest).chain(fluttering.into_iter().take(1));
        let along = along.map(|k| self.search.reference().fractional(&k));
        let along = along.map(|place| place * (SHELL_STEPS as f64 / place.amax()));
        shell()
            .chain(along.filter(|place| place.amax().is_finite()))
            .collect()
    }
}

/// Returns true if a descent from a value may end below the deepest end: `fraction` of a growth rate can rise to the rate itself on the way.
fn may_beat(value: f64, deepest: f64, fraction: f64) -> bool {
    value < deepest.max(fraction * deepest)
}

/// Candidate with the smallest value; infinite if the list is empty.
fn least_of_all<const D: usize>(ends: Vec<Candidate<D>>) -> Candidate<D> {
    let best = ends.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    best.unwrap_or((f64::INFINITY, SVector::zeros()))
}

/// Points on the surface of a cube around zero, in grid steps; one of each pair of opposite points.
pub(super) fn shell<const D: usize>() -> impl Iterator<Item = SVector<f64, D>> {
    let side = 2 * SHELL_STEPS + 1;
    let places = (0..side.pow(D as u32) / 2).map(move |n| grid_coordinates::<D>(n, side));
    let centered = places.map(|place| SVector::from(place.each(|c| c as f64 - SHELL_STEPS as f64)));
    centered.filter(|place| place.amax() == SHELL_STEPS as f64)
}

/// Orthonormal vectors, the first of them parallel to a given vector.
fn orthonormal<const D: usize>(along: &SVector<f64, D>) -> [SVector<f64, D>; D] {
    let mut found: [SVector<f64, D>; D] = array_of(|_| SVector::zeros());
    found[0] = along.normalize();
    // The axes except the one nearest to the vector are independent of it.
    let order = |a: &usize, b: &usize| along[*a].abs().total_cmp(&along[*b].abs());
    let nearest = (0..D).max_by(order);
    for (n, axis) in (0..D).filter(|axis| Some(*axis) != nearest).enumerate() {
        let unit = SVector::<f64, D>::from_fn(|i, _| f64::from(u8::from(i == axis)));
        let known = found[..=n].iter().map(|own| own * own.dot(&unit));
        found[n + 1] = (unit - known.sum::<SVector<f64, D>>()).normalize();
    }
    found
}
