//! The extremes of the spectrum over the zone, for any number of particles in a cell.
//!
//! With one particle in a cell the search of [`ZoneSearch`] is used; otherwise a grid finds the wells, and the deepest ones are
//! followed to their bottoms.

use super::WaveSystem;
use crate::algebra::{Complex, is_well, settled};
use crate::bloch::short_range::ShortRange;
use crate::bloch::{Mode, SpectrumSummary, ZoneSearch, growth_rate};
use crate::lattice::WaveGrid;
use nalgebra::{DMatrix, DVector, SVector};

/// Points of the grid per period of the fastest phase.
const POINTS_PER_PERIOD: usize = 6;
/// Scaled measures within this multiple of the rounding error count as zero.
const ROUNDING: f64 = 4.0;
/// Growth rates of complex `omega^2` count as flutter beyond this fraction of sound speed over spacing.
const FLUTTER: f64 = 1e-7;
/// How many wells of the grid are followed to their bottoms.
const WELLS: usize = 6;
/// Wave vectors below this fraction of a reciprocal vector are long waves, which are taken to their limit.
const LONG: f64 = 1e-3;

/// What is sought; always a minimum.
#[derive(Clone, Copy)]
enum Objective {
    Scaled,
    Lowest,
    Highest,
    Growth,
}

impl<const D: usize> ZoneSearch<D> {
    /// The extremes of the spectrum of a system; damping left out.
    pub fn summary_of(&self, system: &WaveSystem<D>) -> SpectrumSummary<D> {
        if let Some((system, unit)) = system.in_moderate_units() {
            return self.in_units(unit).summary_of(&system).in_units(unit);
        }
        if let Some((range, search, system)) = self.short_ranged_system(system) {
            let found = search.summary_of(&system);
            return range.carried_back(&found, |k| self.folded(k));
        }
        match system.single() {
            Some(matrix) => self.summary(&matrix),
            None => Sweep {
                search: self,
                system,
            }
            .summary(),
        }
    }
}

impl<const D: usize> ZoneSearch<D> {
    /// Search and system in coordinates in which the forces reach equally far in all directions, where the reference lattice
    /// is too oblique for them.
    pub(in crate::bloch) fn short_ranged_system(
        &self,
        system: &WaveSystem<D>,
    ) -> Option<(ShortRange<D>, Self, WaveSystem<D>)> {
        let range = system.short_range()?;
        let system = system.in_short_range(&range)?;
        Some((range, self.in_short_range(&range)?, system))
    }

    /// The system in such coordinates, in which a grid over its zone sees all of it; none where it does anyway.
    pub(crate) fn short_ranged_waves(&self, system: &WaveSystem<D>) -> Option<WaveSystem<D>> {
        self.short_ranged_system(system)
            .map(|(_, _, system)| system)
    }
}

struct Sweep<'a, const D: usize> {
    search: &'a ZoneSearch<D>,
    system: &'a WaveSystem<D>,
}

impl<const D: usize> Sweep<'_, D> {
    fn summary(&self) -> SpectrumSummary<D> {
        let waves = self.search.grid_of(self.resolution());
        let long_wave = self.long_wave();
        let rest = self.rest(long_wave.scaled);
        let spectra: Vec<Vec<Complex>> = self
            .half(&waves)
            .iter()
            .map(|k| self.system.omega_squared(k))
            .collect();
        let bottom = |objective| self.bottom(objective, &waves, &spectra);
        let tolerance = self.tolerance();

        let softest = bottom(Objective::Scaled)
            .filter(|(value, _)| *value < long_wave.scaled)
            .map_or(long_wave, |(_, k)| self.mode(&k));
        let grows = softest.scaled < -tolerance || rest.omega_squared.re < 0.0;
        let lowest = grows
            .then(|| bottom(Objective::Lowest))
            .flatten()
            .map(|(_, k)| self.mode(&k))
            .filter(|mode| mode.omega_squared.re < rest.omega_squared.re)
            .unwrap_or(rest);
        let fluttering = (!self.system.is_hermitian())
            .then(|| bottom(Objective::Growth))
            .flatten()
            .filter(|(value, _)| -value > self.threshold())
            .map(|(_, k)| self.fluttering(&k));
        let fastest_growing = fluttering
            .filter(|mode| growth_rate(mode.omega_squared) > growth_rate(lowest.omega_squared))
            .unwrap_or(lowest);
        let highest = bottom(Objective::Highest).map_or(0.0, |(value, _)| -value);
        SpectrumSummary {
            softest,
            long_wave,
            lowest,
            fastest_growing,
            maximum_omega: highest.max(0.0).sqrt(),
            tolerance,
            flutters: fluttering.is_some(),
        }
    }

    /// Points along each reciprocal vector: enough for the range of the forces, fewer for large cells, whose zones are small.
    fn resolution(&self) -> usize {
        let system = self.system;
        let drift = system.drift().map_or(0, |drift| drift.reach());
        let reach = (system.stiffness().reach() + drift).clamp(2, 16);
        let most = match (D, system.size()) {
            (3, 0..8) => 24,
            (3, _) => 12,
            (_, 0..16) => 48,
            (_, 16..64) => 24,
            _ => 12,
        };
        (POINTS_PER_PERIOD * reach).min(most).next_multiple_of(6)
    }

    /// Half of the wave vectors of a grid; `-k` has the same spectrum, conjugated.
    fn half<'w>(&self, waves: &'w WaveGrid<D>) -> &'w [SVector<f64, D>] {
        let n = waves.resolution();
        let all = waves.wave_vectors();
        &all[..(n / 2 + 1) * (all.len() / n)]
    }

    fn tolerance(&self) -> f64 {
        let stiffness = self.system.stiffness();
        let crystal = self.system.crystal();
        let origin = |site: usize| crystal.position(&crate::lattice::Particle::home(site));
        let sum: f64 = stiffness
            .blocks()
            .map(|(from, to, block)| {
                block.amax() * (crystal.position(to) - origin(from)).norm_squared()
            })
            .sum();
        let per_mass = sum / self.system.cell_mass() * crystal.sites().len() as f64;
        ROUNDING * f64::EPSILON * per_mass / self.search.speed_squared()
    }

    fn threshold(&self) -> f64 {
        let spacing = self.search.reference().vectors().column(0).norm();
        FLUTTER * self.search.speed_squared().sqrt() / spacing
    }

    fn value(&self, objective: Objective, k: &SVector<f64, D>, spectrum: &[Complex]) -> f64 {
        match objective {
            Objective::Lowest => spectrum[0].re,
            Objective::Highest => spectrum.iter().map(|z| -z.re).fold(0.0, f64::min),
            Objective::Growth => spectrum
                .iter()
                .filter(|z| z.im != 0.0)
                .map(|z| -growth_rate(*z))
                .fold(0.0, f64::min),
            Objective::Scaled if self.is_long(k) => f64::INFINITY,
            Objective::Scaled => self.scaled(k, spectrum[0].re),
        }
    }

    /// `omega^2 / (c^2 |k|_h^2)`. Rounding of `omega^2`, which does not become smaller with the wave vector, counts as zero: modes
    /// that no force answers would otherwise seem to grow at long waves.
    fn scaled(&self, k: &SVector<f64, D>, omega_squared: f64) -> f64 {
        if omega_squared.abs() <= ROUNDING * self.system.noise() {
            return 0.0;
        }
        omega_squared / (self.search.speed_squared() * self.search.reference().laplacian(k))
    }

    /// Whether a wave vector is near enough to zero (or to a reciprocal vector) to be taken to the limit.
    fn is_long(&self, k: &SVector<f64, D>) -> bool {
        let lattice = self.search.reference();
        let smallest = lattice.reciprocal().column_iter().map(|b| b.norm());
        let smallest = smallest.fold(f64::INFINITY, f64::min);
        lattice.laplacian(k) < (LONG * smallest).powi(2)
    }

    /// The deepest bottom.
    fn bottom(
        &self,
        objective: Objective,
        waves: &WaveGrid<D>,
        spectra: &[Vec<Complex>],
    ) -> Option<(f64, SVector<f64, D>)> {
        let wave_vectors = self.half(waves);
        let values: Vec<f64> = wave_vectors
            .iter()
            .zip(spectra)
            .map(|(k, spectrum)| self.value(objective, k, spectrum))
            .collect();
        let mut wells: Vec<(f64, usize)> = (0..values.len())
            .filter(|index| is_well::<D>(&values, *index, waves.resolution()))
            .map(|index| (values[index], index))
            .collect();
        wells.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Wells of the same depth are images of each other under the symmetry of the arrangement.
        wells.dedup_by(|b, a| (b.0 - a.0).abs() <= 1e-10 * a.0.abs());
        let step = self.search.reference().reciprocal() / waves.resolution() as f64;
        let at = |k: &SVector<f64, D>| self.value(objective, k, &self.system.omega_squared(k));
        wells
            .into_iter()
            .take(WELLS)
            .map(|(value, index)| settled(&at, (value, wave_vectors[index]), &step))
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The mode with the lowest `Re omega^2` at a wave vector.
    fn mode(&self, k: &SVector<f64, D>) -> Mode<D> {
        let k = self.search.folded(k);
        let mut modes = self.system.modes(&k).into_iter();
        let none = || no_mode(self.system.size());
        let (omega_squared, displacements) = modes.next().unwrap_or_else(none);
        self.shown(&k, omega_squared, &displacements)
    }

    /// The mode with complex `omega^2` that grows fastest at a wave vector.
    fn fluttering(&self, k: &SVector<f64, D>) -> Mode<D> {
        let k = self.search.folded(k);
        let modes = self.system.modes(&k).into_iter();
        let (omega_squared, displacements) = modes
            .filter(|(value, _)| value.im != 0.0)
            .max_by(|a, b| growth_rate(a.0).total_cmp(&growth_rate(b.0)))
            .unwrap_or_else(|| no_mode(self.system.size()));
        self.shown(&k, omega_squared, &displacements)
    }

    fn shown(
        &self,
        k: &SVector<f64, D>,
        omega_squared: Complex,
        displacements: &DVector<Complex>,
    ) -> Mode<D> {
        Mode {
            wave_vector: *k,
            is_long_wave: false,
            omega_squared,
            scaled: self.scaled(k, omega_squared.re),
            polarization: largest_of_particles(displacements),
        }
    }

    fn rest(&self, scaled: f64) -> Mode<D> {
        let rigid = self.system.rigid_translation();
        let matrix = DMatrix::from_fn(D, D, |i, j| Complex::new(rigid[(i, j)], 0.0));
        let mut values = super::spectrum::general_eigenvalues(matrix, self.system.noise());
        values.sort_by(|a, b| a.re.total_cmp(&b.re));
        Mode {
            wave_vector: SVector::zeros(),
            is_long_wave: false,
            omega_squared: values[0],
            scaled,
            polarization: SVector::from_fn(|i, _| Complex::new(f64::from(u8::from(i == 0)), 0.0)),
        }
    }

    fn long_wave(&self) -> Mode<D> {
        self.search
            .long_wave_mode(&self.system.long_wave_stiffness())
    }
}

/// The displacement, of unit length, of the particle that moves most.
fn largest_of_particles<const D: usize>(displacements: &DVector<Complex>) -> SVector<Complex, D> {
    let mut best = SVector::<Complex, D>::zeros();
    for start in (0..displacements.len()).step_by(D) {
        let own = SVector::<Complex, D>::from_fn(|i, _| displacements[start + i]);
        if own.norm() > best.norm() * (1.0 + 1e-9) {
            best = own;
        }
    }
    best.try_normalize(0.0).unwrap_or(best)
}

/// What is shown where the eigenvalue iteration has not converged.
fn no_mode(size: usize) -> (Complex, DVector<Complex>) {
    let nan = Complex::new(f64::NAN, f64::NAN);
    (nan, DVector::repeat(size, nan))
}
