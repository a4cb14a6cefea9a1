//! Softest and lowest modes, with lower bounds.

use super::descend::Start;
use super::limits::LongWaves;
use super::sample::{half, lowest_of};
use super::{Candidate, Objective, ROUNDING_FACTOR, Sweep};
use crate::algebra::Decomposition;
use crate::bloch::Mode;
use crate::bloch::bound::{BUDGET, Covered, GAP, Measure, Question, WIDEST_GAP, cover_system};
use crate::real::LANES;
use nalgebra::SVector;

/// Relative difference of the lengths of wave vectors that count as equal.
const EQUAL_LENGTH_TOLERANCE: f64 = 1e-6;
/// Relative tolerance of squared frequencies: a wave that is no lower than the wave at `k = 0` is replaced by it.
const EQUAL_FREQUENCY_TOLERANCE: f64 = 1e-9;
/// Maximum gap between a bound and the smallest value, relative to this value. Beyond it the wells of the grid are followed too.
const LOOSE_BOUND_RATIO: f64 = 1e-3;
/// Divisor of the box budget for the bounds of the largest and the smallest squared frequency.
const FREQUENCY_BUDGET_DIVISOR: usize = 4;
/// Accepted gap between an extreme squared frequency and its bound, relative to the largest squared frequency of a wave at speed `c`.
const FREQUENCY_GAP: f64 = 1e-6;

/// Softest and lowest mode of a system, without flutter.
pub(super) struct Softest<const D: usize> {
    pub(super) softest: Mode<D>,
    pub(super) lowest: Mode<D>,
    pub(super) long_wave: Mode<D>,
    pub(super) grows_at_gamma: bool,
    pub(super) tolerance: f64,
    pub(super) bound: f64,
}

impl<const D: usize> Sweep<'_, D> {
    pub(super) fn softest(&self, long: &LongWaves<D>) -> Softest<D> {
        let (long_wave, rest) = (long.mode, long.rest);
        let grows_at_gamma = rest.omega_squared.re < 0.0;
        // If a mode grows at `k = 0`, no scaled measure exists, and the lowest wave decides.
        let covered = (!grows_at_gamma)
            .then(|| self.covered(Objective::Scaled, long_wave.scaled, None))
            .flatten();
        let softest = match &covered {
            Some(covered) => covered.wave_vector.map(|k| (covered.lowest, k)),
            None if grows_at_gamma => None,
            None => self.bottom(Objective::Scaled, long_wave.scaled),
        };
        let is_finite = covered.as_ref().is_none_or(|covered| !covered.is_long_wave);
        let softest = softest.map(|own| match is_finite && own.0.abs() <= long.tolerance {
            true => self.shortest_zero(own, long.tolerance),
            false => own,
        });
        let softest = softest
            .filter(|(value, _)| *value < long_wave.scaled)
            .map_or(long_wave, |(value, k)| match &covered {
                Some(covered) if covered.is_long_wave => Mode {
                    wave_vector: k,
                    scaled: value,
                    ..long_wave
                },
                _ => self.mode(&k),
            });
        let lowest = (grows_at_gamma || softest.scaled < -long.tolerance)
            .then(|| self.lowest(Objective::Lowest, rest.omega_squared.re, &softest))
            .flatten()
            .map(|(_, k)| self.mode(&k))
            .filter(|mode| {
                mode.omega_squared.re < rest.omega_squared.re * (1.0 + EQUAL_FREQUENCY_TOLERANCE)
            })
            .or_else(|| {
                let is_limit = softest.is_long_wave && softest.scaled < -long.of_limit;
                (is_limit && !grows_at_gamma)
                    .then(|| self.growing_long_wave(&softest))
                    .flatten()
            })
            .unwrap_or(rest);
        // Slightly negative values are rounding of the relaxation or of eigenvalues unless a finite wave also grows.
        let rounding = match softest.is_long_wave {
            true => long.of_limit,
            false => self.rounding_at(&softest),
        };
        let is_rounding = softest.scaled >= -rounding
            && lowest.omega_squared.re >= -ROUNDING_FACTOR * self.system.noise();
        Softest {
            softest,
            lowest: if is_rounding { rest } else { lowest },
            long_wave,
            grows_at_gamma,
            tolerance: match is_rounding {
                true => long.tolerance.max(-softest.scaled),
                false => long.tolerance,
            },
            bound: covered.map_or(f64::NEG_INFINITY, |covered| covered.bound),
        }
    }

    /// Shortest wave of zero energy among a known one and the bottoms of the wells of the grid. Which of several separate waves a search for the smallest
    /// value finds is decided by rounding.
    fn shortest_zero(&self, known: Candidate<D>, tolerance: f64) -> Candidate<D> {
        let wave_vectors = half(&self.waves);
        let branches = self.sampled_branches(Objective::Scaled, &wave_vectors);
        let zone = &self.search.equivalence().zone;
        let length = |own: &Candidate<D>| zone.folded(&own.1).norm();
        let wells = self.wells(&lowest_of(&branches)).into_iter();
        let starts = wells.map(|(value, _, index)| Start::at((value, wave_vectors[index])));
        let mut ends = Vec::new();
        for several in starts.collect::<Vec<_>>().chunks(LANES) {
            self.follow_together(Objective::Scaled, several, f64::INFINITY, &mut ends);
        }
        let zeros = ends.into_iter().filter(|end| end.0.abs() <= tolerance);
        zeros.fold(known, |best, own| {
            match length(&own) < length(&best) * (1.0 - EQUAL_LENGTH_TOLERANCE) {
                true => own,
                false => best,
            }
        })
    }

    /// Rounding error of the scaled measure of a mode of a system that is not Hermitian.
    ///
    /// If the left and right eigenvectors are nearly orthogonal, the eigenvalue is ill-conditioned: its error is the rounding error of the matrix
    /// times the product of the norms of these vectors. Zero for Hermitian systems, whose error the general tolerance covers.
    fn rounding_at(&self, mode: &Mode<D>) -> f64 {
        if self.system.is_hermitian() {
            return 0.0;
        }
        let k = mode.wave_vector;
        let Some(all) = Decomposition::new(self.system.dynamical_matrix_at(&k)) else {
            return 0.0;
        };
        let distance = |n: &usize| (all.values[*n] - mode.omega_squared).norm();
        let nearest = (0..all.values.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let condition =
            nearest.map_or(1.0, |n| all.left.row(n).norm() * all.right.column(n).norm());
        let noise = ROUNDING_FACTOR * self.system.noise() * condition;
        noise / (self.search.speed_squared() * self.search.reference().laplacian(&k))
    }

    /// Smallest value of an objective below `floor`: by branch and bound if possible, otherwise sampled.
    pub(super) fn lowest(
        &self,
        objective: Objective,
        floor: f64,
        softest: &Mode<D>,
    ) -> Option<Candidate<D>> {
        let start = match objective {
            Objective::Lowest => Some(self.lowest_near(softest)),
            _ => None,
        };
        let covered = self.covered(objective, floor, start);
        let sought = covered.as_ref().is_none_or(|covered| {
            // A growing wave can be so slow that the bound of the squared frequencies does not separate it from zero.
            objective == Objective::Lowest && covered.wave_vector.is_none()
        });
        if sought {
            let known = start.filter(|start| start.0 < floor);
            let floor = known.map_or(floor, |known| known.0);
            return self.bottom(objective, floor).or(known);
        }
        covered.and_then(|covered| covered.wave_vector.map(|k| (covered.lowest, k)))
    }

    /// Smallest `Re omega^2` reached by descent from the softest wave. If the softest wave is the long-wave limit, the descent starts from waves
    /// along its direction.
    fn lowest_near(&self, softest: &Mode<D>) -> Candidate<D> {
        let k = softest.wave_vector;
        let reciprocal = self.search.reference().reciprocal().column(0).norm();
        let step = reciprocal / self.waves.resolution() as f64;
        let starts = match softest.is_long_wave {
            true => self.along_ray(Objective::Lowest, &(k * step)),
            false => vec![(self.value(Objective::Lowest, &k), k)],
        };
        let at_gamma = self.at_gamma.iter().map(|value| value.re);
        let rest = (at_gamma.fold(f64::INFINITY, f64::min), SVector::zeros());
        let mut ends = vec![rest];
        let starts = starts.into_iter().map(Start::at);
        self.follow(Objective::Lowest, starts, f64::INFINITY, &mut ends);
        let lowest = ends.into_iter().skip(1).min_by(|a, b| a.0.total_cmp(&b.0));
        lowest.unwrap_or((f64::INFINITY, k))
    }

    /// Smallest value of an objective and a lower bound of all its values, by branch and bound; `None` if no bound is available.
    ///
    /// Values at or above `floor` need not be resolved. `start` is a known value.
    fn covered(
        &self,
        objective: Objective,
        floor: f64,
        start: Option<Candidate<D>>,
    ) -> Option<Covered<D>> {
        // The bound of the Hermitian part is not a bound of the frequencies of a system that is not Hermitian.
        let is_hermitian = self.system.is_hermitian();
        if !self.is_bounded || !(is_hermitian || objective == Objective::Scaled) {
            return None;
        }
        let speed_squared = self.search.speed_squared();
        let measure = match objective {
            Objective::Scaled => Measure::Scaled(speed_squared),
            Objective::Lowest => Measure::Lowest,
            Objective::Highest => Measure::Highest,
            Objective::Growth | Objective::Function => return None,
        };
        // Start from an attained value.
        let corner = self.search.reference().reciprocal() * SVector::repeat(0.5);
        let corner = (self.value(objective, &corner), corner);
        let start = start.filter(|start| start.0 < corner.0).unwrap_or(corner);
        let known = floor.min(start.0);
        let (scale, gap, budget) = match objective {
            Objective::Scaled => (known.abs().max(1.0), GAP, BUDGET),
            _ => (
                known
                    .abs()
                    .max(speed_squared * self.search.largest_laplacian()),
                FREQUENCY_GAP,
                BUDGET / FREQUENCY_BUDGET_DIVISOR,
            ),
        };
        let question = Question {
            known,
            gap: gap * scale + self.margin(objective),
            widest: WIDEST_GAP * scale,
            budget,
            value: &|k| self.value(objective, k),
            descended: &|start| self.followed(objective, start),
        };
        let mut covered = cover_system(self.system, measure, self.search.reference(), &question)?;
        let is_loose = covered.bound < covered.lowest - LOOSE_BOUND_RATIO * covered.lowest.abs();
        if is_loose || !is_hermitian {
            // If the bound does not determine the value, the wells of the grid are searched too.
            let lower = self.bottom(objective, covered.lowest);
            if let Some((value, k)) = lower.filter(|(value, _)| *value < covered.lowest) {
                covered.wave_vector = Some(k);
                covered.is_long_wave = false;
                covered.lowest = value;
            }
        }
        if covered.wave_vector.is_none() && known < floor {
            covered.wave_vector = Some(start.1);
        }
        Some(covered)
    }
}
