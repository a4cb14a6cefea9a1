//! Pockets of complex `omega^2`, and the fastest growing mode in them.

use super::function::shell;
use super::sample::{complex_growth, half};
use super::{Candidate, Objective, Sweep};
use crate::algebra::{Complex, Each, array_of, sort_by_value};
use crate::bloch::Mode;
use crate::bloch::branches::Taylor;
use crate::bloch::pocket::{Around, Pockets};
use crate::bloch::search::is_near_crossing;
use crate::bloch::system::sampled::Spectra;
use crate::real::LANES;
use nalgebra::SVector;

/// Number of times that eight points along a ray narrow the interval around a crossing of two branches, each time to two ninths.
const CROSSING_ROUNDS: usize = 6;
/// Sizes of rings around `k = 0` for the search for crossings of branches, in units of the largest shell of long waves.
const RING_SIZES: [f64; 8] = [1.0, 0.7, 0.5, 0.35, 0.25, 0.18, 0.12, 0.06];

impl<const D: usize> Sweep<'_, D> {
    /// Wave vectors in pockets of complex `omega^2` in which waves may grow faster than `rival`.
    pub(super) fn pockets(&self, rival: f64) -> Vec<SVector<f64, D>> {
        let pockets = Pockets {
            around: &|wave_vectors, _| self.around(wave_vectors),
            is_large: self.effort.is_large,
            steps: self.search.reference().reciprocal() / self.waves.resolution() as f64,
            threshold: self.search.flutter_threshold(self.system.sites()),
            // The growth rate predicted for a pocket can be as low as half of the rate that a descent finds from there.
            rival: 0.5 * rival,
            most: self.effort.pockets,
            finer: self.effort.finer,
        };
        let n = self.waves.resolution();
        let is_near = |index: &usize| {
            let mut squares = self.squares().iter();
            squares.any(|own| is_near_crossing::<D>(own, *index, n))
        };
        let near = (1..self.waves.half()).filter(is_near);
        pockets.around(near.map(|index| self.waves.wave_vector(index)))
    }

    /// Squares of the half differences of neighboring branches at half of the grid, for each branch except the lowest; infinite for long waves.
    pub(super) fn squares(&self) -> &[Vec<f64>] {
        self.squares.get_or_init(|| {
            let wave_vectors = half(&self.waves);
            let of_branch = |upper: usize| {
                let waves = wave_vectors.iter().zip(self.spectra().iter());
                waves
                    .map(|(k, spectrum)| self.square(upper, k, spectrum))
                    .collect()
            };
            (1..self.system.size()).map(of_branch).collect()
        })
    }

    /// Square of the half difference of a branch and the one below it, from a spectrum: negative for a complex pair, and infinite for long waves.
    pub(super) fn square(&self, upper: usize, k: &SVector<f64, D>, spectrum: &[Complex]) -> f64 {
        if self.is_long(k) {
            return f64::INFINITY;
        }
        let apart = (spectrum[upper] - spectrum[upper - 1]) * 0.5;
        (apart * apart).re
    }

    /// Wave vectors at which two neighboring branches are a complex pair, found by descents of the square of their difference.
    ///
    /// Around a crossing the square is smooth, while the growth rate is defined only within a pocket. A descent from a grid point near a crossing
    /// follows the crossing to the strongest attraction of the branches, which can be a very small pocket.
    pub(super) fn meetings(&self) -> Vec<SVector<f64, D>> {
        if self.effort.is_large || self.system.is_hermitian() {
            return Vec::new();
        }
        let wave_vectors = half(&self.waves);
        let rings = self.rings();
        let ring_spectra: Vec<Spectra> = rings
            .iter()
            .map(|ring| self.sampled().spectra(ring))
            .collect();
        let mut starts: Vec<(f64, usize, Candidate<D>, Option<[f64; 2]>)> = Vec::new();
        for (upper, squares) in (1..).zip(self.squares()) {
            let wells = self.wells(squares).into_iter();
            starts.extend(wells.map(|(square, relief, index)| {
                let start = (square, wave_vectors[index]);
                (square / relief, upper, start, None)
            }));
            let along: Vec<Vec<f64>> = rings
                .iter()
                .zip(&ring_spectra)
                .map(|(ring, spectra)| {
                    let both = ring.iter().zip(spectra.iter());
                    both.map(|(k, spectrum)| self.square(upper, k, spectrum))
                        .collect()
                })
                .collect();
            for (n, three) in along.windows(3).enumerate() {
                for (place, own) in three[1].iter().enumerate() {
                    let beside = [three[0][place], three[2][place]];
                    if own.is_finite() && beside.iter().all(|other| own <= other) {
                        let start = (*own, rings[n + 1][place]);
                        let ends = [2, 0].each(|i| RING_SIZES[n + i] / RING_SIZES[n + 1]);
                        starts.push((own / beside[0], upper, start, Some(ends)));
                    }
                }
            }
        }
        // Squares that are small relative to their neighbors lie near a crossing.
        sort_by_value(&mut starts, |start| start.0);
        starts.truncate(self.effort.pockets);
        let starts: Vec<(usize, Candidate<D>)> = starts
            .into_iter()
            .map(|(_, upper, start, ends)| {
                // A descent would leave a crossing along its ring, toward another pocket.
                let crossing = ends.map(|ends| self.crossing(upper, start, ends));
                (upper, crossing.unwrap_or(start))
            })
            .collect();
        let squares = |places: &[(usize, SVector<f64, D>)]| self.squared_differences(places);
        let ends = self.search.newton_together(&squares, &starts, 0.0);
        // A start within a pocket counts too: the descent can end in another pocket.
        let both = starts.into_iter().zip(ends);
        both.flat_map(|((_, start), (end, _))| [start, end])
            .filter(|(square, _)| *square < 0.0)
            .map(|(_, k)| k)
            .collect()
    }

    /// Smallest squared half difference of two neighboring branches on the ray through a wave vector, between two multiples of it.
    fn crossing(
        &self,
        upper: usize,
        start: Candidate<D>,
        [mut low, mut high]: [f64; 2],
    ) -> Candidate<D> {
        let mut best = (start.0, 1.0);
        for _ in 0..CROSSING_ROUNDS {
            let step = (high - low) / (LANES + 1) as f64;
            let sizes: [f64; LANES] = array_of(|n| low + step * (n + 1) as f64);
            let spectra = self.sampled().spectra(&sizes.each(|size| start.1 * size));
            for (own, size) in spectra.iter().zip(sizes) {
                let apart = (own[upper] - own[upper - 1]) * 0.5;
                let square = (apart * apart).re;
                if square < best.0 {
                    best = (square, size);
                }
            }
            (low, high) = (low.max(best.1 - step), high.min(best.1 + step));
        }
        (best.0, start.1 * best.1)
    }

    /// Wave vectors on cubes around `k = 0`, largest first, with the same directions on each. Acoustic and soft optical branches of a cell cross on rings
    /// that the grid does not resolve.
    fn rings(&self) -> Vec<Vec<SVector<f64, D>>> {
        let step = self.search.reference().reciprocal() / self.waves.resolution() as f64;
        let ring = |size: f64| shell::<D>().map(|place| step * (place * size)).collect();
        RING_SIZES.map(ring).to_vec()
    }

    /// Squared half differences of branches and those below, numbered by increasing real part, with their derivatives; `None` for long waves.
    fn squared_differences(
        &self,
        places: &[(usize, SVector<f64, D>)],
    ) -> Vec<Option<Taylor<f64, D>>> {
        let wave_vectors: Vec<_> = places.iter().map(|(_, k)| *k).collect();
        let around = self.around(&wave_vectors).into_iter().zip(places);
        let square = |(around, (upper, _)): (Option<Around<D>>, &(usize, _))| {
            let branches = around?.branches(&|value| value.re, &[*upper, upper - 1])?;
            Some(branches[0].squared_half_difference(&branches[1]))
        };
        around.map(square).collect()
    }

    /// Returns true if a wave with complex `omega^2` grows noticeably. Only its existence is needed, so that one such grid point suffices.
    pub(super) fn flutters(&self) -> bool {
        let threshold = self.search.flutter_threshold(self.system.sites());
        let is_sampled = || -self.fastest_sampled().0 > threshold;
        !self.system.is_hermitian() && (is_sampled() || self.flutter(0.0, 0.0).is_some())
    }

    /// Largest growth rate of complex `omega^2` on the grid and at `k = 0`, with its wave vector; the value is negative.
    fn fastest_sampled(&self) -> Candidate<D> {
        let fastest = |spectrum: &[Complex]| complex_growth(spectrum).fold(0.0, f64::min);
        let waves = half(&self.waves).into_iter().zip(self.spectra().iter());
        let sampled = waves.filter(|(k, _)| !self.is_long(k));
        let sampled = sampled.map(|(k, spectrum)| (fastest(spectrum), k));
        let at_gamma = (fastest(&self.at_gamma), SVector::zeros());
        sampled.fold(
            at_gamma,
            |best, own| if own.0 < best.0 { own } else { best },
        )
    }

    /// Fastest growing mode with complex `omega^2`, if it grows noticeably and faster than `rival`.
    ///
    /// If flutter is already present on the grid, other pockets matter only if they grow faster than it and than `growth`, the rate of divergence.
    pub(super) fn flutter(&self, rival: f64, growth: f64) -> Option<Mode<D>> {
        if self.system.is_hermitian() {
            return None;
        }
        let sites = self.system.sites();
        let threshold = self.search.flutter_threshold(sites);
        let sampled = self.fastest_sampled();
        let is_sampled = -sampled.0 > threshold.max(rival);
        // Rate that further flutter must exceed. The rate of divergence counts only if flutter on the grid already answers whether the state
        // flutters.
        let least = |growth: f64| match is_sampled {
            true => rival.max(self.search.as_rival(growth, sites)),
            false => rival,
        };
        let rival = least(growth);
        let mut ends = self.bottoms(Objective::Growth, -rival);
        let deepest = |ends: &[Candidate<D>]| ends.iter().map(|end| end.0).fold(-rival, f64::min);
        let step = 1.0 / self.waves.resolution() as f64;
        let opening = self.search.long_flutter(&self.stiffness, step);
        let fastest = least(-deepest(&ends).min(sampled.0));
        // Pockets that descents alone find are small, so that waves in them grow slowly.
        let meetings = match fastest > 0.0 {
            true => Vec::new(),
            false => self.meetings(),
        };
        let pockets = self.pockets(fastest).into_iter().chain(meetings);
        let starts = self.starts(Objective::Growth, pockets.chain(opening));
        let growing = starts.into_iter().filter(|start| start.place.0 < 0.0);
        self.follow(Objective::Growth, growing, -rival, &mut ends);
        ends.push(sampled);
        let best = ends.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        best.filter(|(value, _)| is_sampled || -value > threshold.max(rival))
            .map(|(_, k)| self.fluttering(&k))
    }
}
