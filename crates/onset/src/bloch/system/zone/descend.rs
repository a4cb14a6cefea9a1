//! Descents from the wells to their bottoms.

use super::sample::{half, lowest_of};
use super::{BOX_DIVISIONS, Candidate, FOLLOWED_GROWTH_RATIO, Objective, ROUNDING_FACTOR, Sweep};
use crate::algebra::Complex;
use crate::bloch::branches::Taylor;
use crate::bloch::growth_rate;
use crate::bloch::search::settled;
use crate::real::LANES;
use nalgebra::{SMatrix, SVector};

/// Side of the smallest boxes, in grid steps.
const LEAF_STEPS: f64 = 0.25;
const _: () = assert!(LEAF_STEPS * (1 << BOX_DIVISIONS) as f64 == 1.0);
/// Distance from a known bottom, in grid steps, within which a descent that does not reach a lower value has found the same bottom.
const KNOWN_BOTTOM_STEPS: f64 = 0.02;

/// Start of a descent.
#[derive(Clone, Copy)]
pub(super) struct Start<const D: usize> {
    /// Number of the branch, and its value at a wave vector.
    pub(super) branch: usize,
    pub(super) place: Candidate<D>,
    /// Lowest value that the descent may reach.
    pub(super) bound: f64,
    /// True if the start represents a small box, which a known bottom inside settles.
    pub(super) is_in_box: bool,
}

impl<const D: usize> Start<D> {
    /// Start on the lowest branch of a descent that may reach any value.
    pub(super) fn at(place: Candidate<D>) -> Self {
        Self {
            branch: 0,
            place,
            bound: f64::NEG_INFINITY,
            is_in_box: false,
        }
    }
}

impl<const D: usize> Sweep<'_, D> {
    /// Smallest bottom that a descent finds.
    pub(super) fn bottom(&self, objective: Objective, floor: f64) -> Option<Candidate<D>> {
        let bottoms = self.bottoms(objective, floor).into_iter();
        bottoms.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Ends of all descents that may fall below `floor` and below the bottoms found before.
    pub(super) fn bottoms(&self, objective: Objective, floor: f64) -> Vec<Candidate<D>> {
        let wave_vectors = half(&self.waves);
        let branches = self.sampled_branches(objective, &wave_vectors);
        let mut ends: Vec<Candidate<D>> = Vec::new();
        let wells = self.wells(&lowest_of(&branches)).into_iter();
        let wells = wells.map(|(value, relief, index)| Start {
            bound: value - relief,
            ..Start::at((value, wave_vectors[index]))
        });
        self.follow(objective, wells, floor, &mut ends);
        // Wells that open at `k = 0` are narrow in angle and can miss the grid: start along the direction of the softest long waves.
        let mut others = Vec::new();
        if matches!(objective, Objective::Scaled | Objective::Lowest) {
            let along = self.search.long_wave_mode(&self.stiffness).wave_vector;
            let reciprocal = self.search.reference().reciprocal().column(0).norm();
            let step = reciprocal / self.waves.resolution() as f64;
            let ray = self.along_ray(objective, &(along * step)).into_iter();
            others.extend(ray.map(Start::at));
        }
        // At points of high symmetry slopes vanish, and the lowest point nearby need not belong to their well.
        for index in self.symmetric_points() {
            let k = wave_vectors[index];
            let beside = self.beside(&k).map(|k| (self.value(objective, &k), k));
            let starts = std::iter::once((branches[index][0], k)).chain(beside);
            others.extend(starts.map(|start| Start {
                bound: start.0,
                ..Start::at(start)
            }));
        }
        self.follow(objective, others, floor, &mut ends);
        let below = self.to_beat(objective, floor, &ends);
        let regions = self.regions(objective, branches, below, &ends).into_iter();
        let regions = regions.map(|region| Start {
            branch: region.branch,
            place: (region.branches[region.branch], region.center),
            bound: region.bound,
            is_in_box: region.branch == 0 && region.branches[0].is_finite(),
        });
        self.follow(objective, regions, floor, &mut ends);
        ends
    }

    /// Largest value of a new bottom: the smallest of `floor` and the known ends, less rounding.
    fn to_beat(&self, objective: Objective, floor: f64, ends: &[Candidate<D>]) -> f64 {
        ends.iter().map(|end| end.0).fold(floor, f64::min) - self.margin(objective)
    }

    /// Largest difference of an objective that is a rounding error. Zero-energy modes have many wells that are due to rounding.
    pub(super) fn margin(&self, objective: Objective) -> f64 {
        let noise = ROUNDING_FACTOR * self.system.noise();
        let scale = self.search.speed_squared() * self.search.largest_laplacian();
        match objective {
            Objective::Scaled => noise / scale,
            Objective::Lowest | Objective::Highest => noise,
            Objective::Growth => self.search.flutter_threshold(self.system.sites()),
            Objective::Function => 0.0,
        }
    }

    /// Returns true if a known bottom lies within a number of grid steps.
    pub(super) fn is_near_bottom(
        &self,
        k: &SVector<f64, D>,
        known: &[Candidate<D>],
        steps: f64,
    ) -> bool {
        known
            .iter()
            .any(|end| self.steps_between(k, &end.1) <= steps)
    }

    /// Distance of two wave vectors in grid steps, modulo reciprocal vectors.
    fn steps_between(&self, a: &SVector<f64, D>, b: &SVector<f64, D>) -> f64 {
        let periods = self.search.reference().fractional(&(a - b));
        let apart = periods.map(|x| (x - x.round()).abs()).max();
        apart * self.waves.resolution() as f64
    }

    /// Starts at wave vectors.
    pub(super) fn starts(
        &self,
        objective: Objective,
        wave_vectors: impl Iterator<Item = SVector<f64, D>>,
    ) -> Vec<Start<D>> {
        let wave_vectors: Vec<_> = wave_vectors.collect();
        let branches = self.branches_at(objective, &wave_vectors);
        let both = branches.into_iter().zip(wave_vectors);
        both.map(|(own, k)| Start::at((own[0], k))).collect()
    }

    /// Follows branches from their starts to their bottoms, several at a time. Starts that cannot fall below `floor` and all known ends are omitted.
    pub(super) fn follow(
        &self,
        objective: Objective,
        starts: impl IntoIterator<Item = Start<D>>,
        floor: f64,
        ends: &mut Vec<Candidate<D>>,
    ) {
        let together = match self.effort.is_large || objective == Objective::Function {
            true => 1,
            false => LANES,
        };
        let mut starts = starts.into_iter();
        loop {
            let to_beat = self.to_beat(objective, floor, ends);
            let may_fall = |start: &Start<D>| {
                let is_inside = || self.is_near_bottom(&start.place.1, ends, LEAF_STEPS);
                start.bound < to_beat && !(start.is_in_box && is_inside())
            };
            let several: Vec<Start<D>> = starts.by_ref().filter(may_fall).take(together).collect();
            if several.is_empty() {
                return;
            }
            self.follow_together(objective, &several, to_beat, ends);
        }
    }

    /// Follows branches to their bottoms.
    ///
    /// Newton's method is tried first; where it does not end in a smooth minimum, a search with finite differences follows. A descent ends early if it
    /// cannot fall below `floor`, or at a known bottom.
    pub(super) fn follow_together(
        &self,
        objective: Objective,
        starts: &[Start<D>],
        floor: f64,
        ends: &mut Vec<Candidate<D>>,
    ) {
        let step = self.search.reference().reciprocal() / self.waves.resolution() as f64;
        if objective == Objective::Function {
            let settled = starts
                .iter()
                .map(|start| self.settled(objective, start.place, &step));
            ends.extend(settled);
            return;
        }
        // At the edge of a pocket the growth rate is a square root, so that no parabola predicts its minimum.
        let (to_beat, floor) = match objective {
            Objective::Growth => (f64::INFINITY, FOLLOWED_GROWTH_RATIO * floor),
            _ => (floor, floor),
        };
        let taylor = |places: &[(usize, SVector<f64, D>)]| self.taylor(objective, places);
        let places: Vec<_> = starts.iter().map(|own| (own.branch, own.place)).collect();
        let bottoms = self.search.newton_together(&taylor, &places, to_beat);
        let wave_vectors: Vec<_> = bottoms.iter().map(|(bottom, _)| bottom.1).collect();
        let values = self.branches_at(objective, &wave_vectors);
        let margin = self.margin(objective);
        for ((start, (bottom, is_settled)), value) in starts.iter().zip(bottoms).zip(values) {
            let end = (value[0], bottom.1);
            // In the zone of a small cell a grid step is long, so that a lower bottom can lie within one step of a known one.
            let is_known = |known: &Candidate<D>| {
                self.effort.is_large
                    && known.0 <= end.0 + margin
                    && self.steps_between(&known.1, &end.1) < KNOWN_BOTTOM_STEPS
            };
            let is_bottom = is_settled && start.branch == 0;
            let is_end = is_bottom || end.0 >= floor || ends.iter().any(is_known);
            ends.push(match is_end {
                true => end,
                false => self.settled(objective, end, &step),
            });
        }
    }

    /// Bottom of the lowest branch below a start.
    pub(super) fn followed(&self, objective: Objective, start: Candidate<D>) -> Candidate<D> {
        let mut ends = Vec::with_capacity(1);
        self.follow_together(objective, &[Start::at(start)], f64::INFINITY, &mut ends);
        ends[0]
    }

    /// Local minimum of the lowest branch, by finite differences with the given initial steps.
    pub(super) fn settled(
        &self,
        objective: Objective,
        start: Candidate<D>,
        steps: &SMatrix<f64, D, D>,
    ) -> Candidate<D> {
        let lowest = |wave_vectors: &[SVector<f64, D>]| {
            let branches = self.branches_at(objective, wave_vectors).into_iter();
            branches.map(|own| own[0]).collect()
        };
        settled(&lowest, start, steps)
    }

    /// Taylor expansions of branches of an objective; `None` for long waves.
    fn taylor(
        &self,
        objective: Objective,
        places: &[(usize, SVector<f64, D>)],
    ) -> Vec<Option<Taylor<f64, D>>> {
        let order = |omega_squared: Complex| match objective {
            Objective::Highest => -omega_squared.re,
            Objective::Growth => -growth_rate(omega_squared),
            _ => omega_squared.re,
        };
        let short = places.iter().filter(|(_, k)| !self.is_long(k));
        let (numbers, wave_vectors): (Vec<usize>, Vec<_>) = short.copied().unzip();
        let branches = self.sampled().branches(&wave_vectors, &order, &numbers);
        let mut branches = branches.into_iter();
        let own = |(_, k): &(usize, SVector<f64, D>)| {
            let value = match self.is_long(k) {
                true => None,
                false => branches.next().flatten(),
            }?;
            match objective {
                Objective::Scaled => Some(self.search.scaled(&value.map(|z| z.re), k)),
                Objective::Highest => Some(value.map(|z| -z.re)),
                Objective::Growth => Some(value.growth().map(|x| -x)),
                Objective::Lowest => Some(value.map(|z| z.re)),
                Objective::Function => None,
            }
        };
        places.iter().map(own).collect()
    }
}
