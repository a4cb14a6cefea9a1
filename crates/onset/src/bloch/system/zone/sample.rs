//! Samples of an objective on the grid, and its wells.

use super::{Candidate, HUGE_CELL_SIZE, Objective, ROUNDING_FACTOR, Sweep};
use crate::algebra::{Complex, Each, sort_by_value};
use crate::bloch::growth_rate;
use crate::bloch::pocket::Around;
use crate::bloch::search::{LONG_WAVE_FRACTION, RELAXED_RAY_STEPS, is_well, neighbors};
use crate::bloch::system::WaveSystem;
use crate::bloch::system::sampled::{Sampled, Spectra};
use crate::lattice::{WaveGrid, grid_coordinates};
use nalgebra::SVector;

/// Grid points per period of the fastest phase. A heuristic value; the division of boxes finds wells between the points.
const POINTS_PER_PERIOD: usize = 10;
/// Number of lowest branches that are checked for wells between the grid points.
pub(super) const TRACKED_BRANCHES: usize = 3;

/// Values of the objective for the lowest branches at a wave vector, lowest first; infinite if there are fewer branches.
pub(super) type Branches = [f64; TRACKED_BRANCHES];
/// Placeholder for the branches of long waves, which are not sampled.
pub(super) const UNKNOWN: Branches = [f64::INFINITY; TRACKED_BRANCHES];

impl<const D: usize> Sweep<'_, D> {
    /// `D(k)` with its derivatives; `None` for long waves.
    pub(super) fn around(&self, wave_vectors: &[SVector<f64, D>]) -> Vec<Option<Around<D>>> {
        let short = wave_vectors.iter().filter(|k| !self.is_long(k));
        let mut around = self
            .sampled()
            .around(&short.copied().collect::<Vec<_>>())
            .into_iter();
        let own = |k| if self.is_long(k) { None } else { around.next() };
        wave_vectors.iter().map(own).collect()
    }

    pub(super) fn sampled(&self) -> &dyn Sampled<D> {
        &**self.form.get_or_init(|| self.system.sampled())
    }

    /// `omega^2` at half of the grid.
    pub(super) fn spectra(&self) -> &Spectra {
        let sample = || self.sampled().spectra(&half(&self.waves));
        self.spectra.get_or_init(sample)
    }

    /// Values of the objective for the lowest branches at a wave vector, lowest first, from its spectrum.
    pub(super) fn branches(
        &self,
        objective: Objective,
        k: &SVector<f64, D>,
        spectrum: &[Complex],
    ) -> Branches {
        let mut lowest = UNKNOWN;
        if self.is_long(k) {
            return lowest;
        }
        let noise = ROUNDING_FACTOR * self.system.noise();
        let scale = self.search.speed_squared() * self.search.reference().laplacian(k);
        let mut insert = |mut value: f64| {
            for place in &mut lowest {
                if value.total_cmp(place).is_lt() {
                    std::mem::swap(place, &mut value);
                }
            }
        };
        match objective {
            Objective::Scaled => spectrum
                .iter()
                .for_each(|z| insert(scaled(z.re, noise, scale))),
            Objective::Lowest => spectrum.iter().for_each(|z| insert(z.re)),
            Objective::Highest => spectrum.iter().for_each(|z| insert(-z.re)),
            Objective::Growth => complex_growth(spectrum).for_each(insert),
            Objective::Function => self
                .function
                .iter()
                .for_each(|function| insert(function(k))),
        }
        lowest
    }

    pub(super) fn value(&self, objective: Objective, k: &SVector<f64, D>) -> f64 {
        self.branches_at(objective, &[*k])[0][0]
    }

    /// Values of the objective for the lowest branches, at wave vectors whose spectra are not yet known.
    pub(super) fn branches_at(
        &self,
        objective: Objective,
        wave_vectors: &[SVector<f64, D>],
    ) -> Vec<Branches> {
        let all = wave_vectors.iter();
        if objective == Objective::Function {
            return all.map(|k| self.branches(objective, k, &[])).collect();
        }
        let spectra = self.sampled().spectra(wave_vectors);
        all.zip(spectra.iter())
            .map(|(k, spectrum)| self.branches(objective, k, spectrum))
            .collect()
    }

    /// Scaled measure `omega^2 / (c^2 |k|_h^2)` of a squared frequency.
    ///
    /// Rounding errors of `omega^2`, which do not decrease with the wave vector, count as zero. Otherwise zero-energy modes would seem to grow for
    /// long waves.
    pub(super) fn scaled(&self, k: &SVector<f64, D>, omega_squared: f64) -> f64 {
        let scale = self.search.speed_squared() * self.search.reference().laplacian(k);
        scaled(omega_squared, ROUNDING_FACTOR * self.system.noise(), scale)
    }

    /// Returns true if the wave vector is so close to zero, or to a reciprocal vector, that the long-wave limit represents it.
    pub(super) fn is_long(&self, k: &SVector<f64, D>) -> bool {
        self.search.is_longer(k, LONG_WAVE_FRACTION)
    }

    /// Branches of an objective at the wave vectors of half of the grid.
    pub(super) fn sampled_branches(
        &self,
        objective: Objective,
        wave_vectors: &[SVector<f64, D>],
    ) -> Vec<Branches> {
        if objective == Objective::Function {
            return self.branches_at(objective, wave_vectors);
        }
        let waves = wave_vectors.iter().zip(self.spectra().iter());
        waves
            .map(|(k, spectrum)| self.branches(objective, k, spectrum))
            .collect()
    }

    /// Starts of descents along a ray, given one grid step along it. In large cells only the lowest start.
    pub(super) fn along_ray(
        &self,
        objective: Objective,
        step: &SVector<f64, D>,
    ) -> Vec<Candidate<D>> {
        let ray = RELAXED_RAY_STEPS.each(|steps| step * steps);
        let values = self.branches_at(objective, &ray);
        let mut starts: Vec<Candidate<D>> =
            values.iter().zip(ray).map(|(own, k)| (own[0], k)).collect();
        if self.effort.is_large {
            sort_by_value(&mut starts, |start| start.0);
            starts.truncate(1);
        }
        starts
    }

    /// Indices of the grid points at halves and thirds of reciprocal vectors, except `k = 0`.
    pub(super) fn symmetric_points(&self) -> impl Iterator<Item = usize> {
        let n = self.waves.resolution();
        let is_symmetric = move |c: &usize| [0, n / 3, n / 2, 2 * n / 3].contains(c);
        (1..self.waves.half())
            .filter(move |index| grid_coordinates::<D>(*index, n).iter().all(is_symmetric))
    }

    /// Wave vectors near a point of high symmetry, in one dimension only.
    ///
    /// Folded branches that nearly cross there have strong curvature within a fraction of a grid step. In higher dimensions the number of such wave
    /// vectors would be comparable to the size of the grid.
    pub(super) fn beside(&self, k: &SVector<f64, D>) -> impl Iterator<Item = SVector<f64, D>> {
        let step = self.search.reference().reciprocal().column(0) / self.waves.resolution() as f64;
        let near = RELAXED_RAY_STEPS.each(|share| [k - step * share, k + step * share]);
        near.into_iter().flatten().filter(|_| D == 1)
    }

    /// Distinct wells of the grid, deepest first: value, height of the highest neighbor above it, and index.
    pub(super) fn wells(&self, values: &[f64]) -> Vec<(f64, f64, usize)> {
        let n = self.waves.resolution();
        let relief = |index: usize| {
            let around = neighbors::<D>(index, n, values.len()).map(|other| values[other]);
            let around = around.filter(|value| value.is_finite());
            around.fold(values[index], f64::max) - values[index]
        };
        let mut wells: Vec<(f64, f64, usize)> = (0..values.len())
            .filter(|index| is_well::<D>(values, *index, n))
            .map(|index| (values[index], relief(index), index))
            .collect();
        sort_by_value(&mut wells, |item| item.0);
        // Wells of equal depth are symmetric images of each other.
        wells.dedup_by(|b, a| (b.0 - a.0).abs() <= 1e-10 * a.0.abs());
        wells.truncate(self.effort.wells);
        wells
    }
}

/// Scaled measure of a squared frequency, in which rounding counts as zero; `scale` is `c^2 |k|_h^2`.
pub(super) fn scaled(omega_squared: f64, noise: f64, scale: f64) -> f64 {
    match omega_squared.abs() <= noise {
        true => 0.0,
        false => omega_squared / scale,
    }
}

/// Negative growth rates of complex `omega^2`; zero for real values.
pub(super) fn complex_growth(spectrum: &[Complex]) -> impl Iterator<Item = f64> {
    spectrum
        .iter()
        .map(|z| if z.im == 0.0 { 0.0 } else { -growth_rate(*z) })
}

/// Grid points along each reciprocal vector: enough for the range of the forces, fewer for large cells, whose zones are small. A multiple of six
/// places points of high symmetry on the grid.
pub(super) fn resolution<const D: usize>(system: &WaveSystem<D>) -> usize {
    let drift = system.drift().map_or(0, |drift| drift.reach());
    let reach = system.stiffness().reach() + drift;
    let (least, most) = match (D, system.size()) {
        (1, _) => (48, 192),
        (2, 0..16) => (30, 60),
        (3, 0..8) => (18, 18),
        (2, 16..64) => (18, 24),
        (3, 16..) | (_, HUGE_CELL_SIZE..) => (6, 6),
        _ => (12, 12),
    };
    let points = POINTS_PER_PERIOD * reach;
    points.clamp(least, most).next_multiple_of(6)
}

/// Values of the lowest branches.
pub(super) fn lowest_of(branches: &[Branches]) -> Vec<f64> {
    branches.iter().map(|own| own[0]).collect()
}

/// Half of the wave vectors of a grid; `-k` has the complex conjugate spectrum.
pub(super) fn half<const D: usize>(waves: &WaveGrid<D>) -> Vec<SVector<f64, D>> {
    waves.wave_vectors().take(waves.half()).collect()
}
