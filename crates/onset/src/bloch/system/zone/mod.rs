//! Extremes of the spectrum over the zone, for any number of particles in a cell.
//!
//! Systems with one particle in a cell are left to the matrix search of [`ZoneSearch`]. Otherwise, each objective is the lowest of several
//! branches. Its minima are smooth, because branches that cross leave a ridge, but crossings can make them narrow. The stages of the search:
//!
//! 1. `limits`: long waves and modes at `k = 0` need no search.
//! 2. `sample`: `omega^2` on a grid over half of the zone, and the wells of the grid.
//! 3. `descend`: wells are followed to their bottoms by Newton's method with exact derivatives, several at a time.
//! 4. `boxes`: boxes around grid points in which some branch can fall lower, judging by its slope, are halved repeatedly; lower values found there are
//!    followed too.
//! 5. `softest`: the softest and the lowest mode; on request, branch and bound computes a lower bound (`bloch::bound`).
//! 6. `flutter`: if the forces do not derive from an energy, pockets of complex `omega^2` are predicted from the derivatives at grid points near
//!    crossings (`bloch::pocket`), and descents of the squared difference of neighboring branches end in pockets of any size.
//! 7. `modes`: the modes that are reported.
//!
//! `function` minimizes any other function of the wave vector by the same stages.
//!
//! Only the bound is guaranteed. The extremes themselves are sampled values. Constants without a stated derivation are heuristic; the tests `hunt`
//! compare random states with a dense search.

mod boxes;
mod descend;
mod flutter;
mod function;
mod limits;
mod modes;
mod sample;
mod softest;

use crate::algebra::Complex;
use crate::bloch::pocket::HALVED_STEP_POINTS;
use crate::bloch::search::Flutter;
use crate::bloch::short_range::ShortRange;
use crate::bloch::system::WaveSystem;
use crate::bloch::system::sampled::{LARGE_CELL_SIZE, Sampled, Spectra};
use crate::bloch::{Judgment, Mode, SpectrumSummary, Stability, ZoneSearch, growth_rate};
use crate::continuum::{AcousticMinimum, Stiffness};
use crate::lattice::WaveGrid;
use limits::LongWaves;
use modes::largest_of_particles;
use nalgebra::SVector;
use sample::{half, resolution};
use softest::Softest;
use std::sync::{Arc, OnceLock};

/// Tolerance for zero, as a multiple of the rounding error of lattice sums. Force constants also contain the rounding error of their shape functions,
/// which is several times larger.
const ROUNDING_FACTOR: f64 = 16.0;
/// Minimum fraction of the largest known growth rate at which a wave is followed further although Newton's method has not converged. A heuristic
/// value.
const FOLLOWED_GROWTH_RATIO: f64 = 0.7;
/// Number of times that boxes are halved.
const BOX_DIVISIONS: usize = 2;
/// Minimum number of degrees of freedom of a huge cell. Its zone is so small that a few grid points resolve it.
const HUGE_CELL_SIZE: usize = 96;
/// Number of grid points along a reciprocal vector with damping, where each value requires the eigenvalues for many time steps. The extreme time
/// steps belong to short waves, which vary slowly over the zone.
const DAMPED_GRID_POINTS: usize = 12;
/// Number of wells that are followed to their bottoms with damping.
const DAMPED_WELLS: usize = 4;

/// Value of the objective, and its wave vector.
type Candidate<const D: usize> = (f64, SVector<f64, D>);

/// Objective of a search over the zone; always minimized.
#[derive(Clone, Copy, PartialEq)]
enum Objective {
    /// Scaled measure `Re omega^2 / (c^2 |k|_h^2)` of the lowest branch.
    Scaled,
    /// Real part `Re omega^2` of the lowest branch.
    Lowest,
    /// Negative real part, `-Re omega^2`, of the highest branch.
    Highest,
    /// Negative growth rate of complex `omega^2`.
    Growth,
    /// The function of the wave vector in [`Sweep::function`].
    Function,
}

/// Function of the wave vector whose minimum is computed.
pub(crate) type WaveFunction<'a, const D: usize> = &'a (dyn Fn(&SVector<f64, D>) -> f64 + Sync);

impl<const D: usize> ZoneSearch<D> {
    /// Computes the extremes of the undamped spectrum of a system. Sampled, without a lower bound.
    pub fn summary_of(&self, system: &WaveSystem<D>) -> SpectrumSummary<D> {
        self.found_of(system, Flutter::All, false)
    }

    /// Minimum over the zone of a function that depends on the waves of a system, and its wave vector. Long waves are excluded.
    pub(crate) fn least_of(
        &self,
        system: &WaveSystem<D>,
        function: WaveFunction<'_, D>,
    ) -> (f64, SVector<f64, D>) {
        if let Some((range, search, system)) = self.short_ranged_system(system) {
            let to_given = range.map.transpose();
            let carried = |k: &SVector<f64, D>| function(&(to_given * k));
            let (value, k) = search.least_of(&system, &carried);
            return (value, self.folded(&(to_given * k)));
        }
        let mut sweep = Sweep::new(self, system, true);
        sweep.function = Some(function);
        if system.damping().is_some() {
            sweep.waves = self.grid_of(DAMPED_GRID_POINTS);
            sweep.effort.wells = sweep.effort.wells.min(DAMPED_WELLS);
            sweep.effort.boxes = sweep.effort.boxes.min(DAMPED_WELLS);
            sweep.effort.leaves = sweep.effort.leaves.min(DAMPED_WELLS);
        }
        let (value, k) = sweep.least();
        (value, self.folded(&k))
    }

    /// Like `summary_of`, but without flutter that grows more slowly than the divergence of the state, as in [`ZoneSearch::extremes`].
    pub(crate) fn extremes_of(
        &self,
        system: &WaveSystem<D>,
        includes_long_waves: bool,
    ) -> SpectrumSummary<D> {
        let sought = Flutter::Fastest {
            includes_long_waves,
        };
        self.found_of(system, sought, false)
    }

    /// Like `summary_of`, with a lower bound of the scaled measure if the equations allow it.
    pub fn bounded_summary_of(&self, system: &WaveSystem<D>) -> SpectrumSummary<D> {
        self.found_of(system, Flutter::All, true)
    }

    /// Computes the extremes; `is_bounded` requests a lower bound.
    fn found_of(
        &self,
        system: &WaveSystem<D>,
        sought: Flutter,
        is_bounded: bool,
    ) -> SpectrumSummary<D> {
        if let Some((system, unit)) = system.in_moderate_units() {
            let search = self.in_units(unit);
            return search.found_of(&system, sought, is_bounded).in_units(unit);
        }
        if let Some(reduced) = system.reduced() {
            return self.with_null_space(system, self.found_of(reduced, sought, is_bounded));
        }
        if let Some((range, search, system)) = self.short_ranged_system(system) {
            let found = search.found_of(&system, sought, is_bounded);
            return range.carried_back(&found, |k| self.folded(k));
        }
        match system.single() {
            Some(matrix) => self.found(&matrix, sought, is_bounded),
            None => Sweep::new(self, system, is_bounded).summary(sought),
        }
    }

    /// Returns whether a wave grows, and by divergence or flutter.
    ///
    /// Cheaper than `summary_of`: it stops at the first growing wave and omits the largest frequency. The sign of the measure decides stability if
    /// the spectrum is real.
    ///
    /// - `soft`: the softest mode of a stable state is returned if its scaled measure is at most this value.
    /// - `beside`: growing wave vectors of neighboring states, which are tried first.
    pub(crate) fn judgment_of(
        &self,
        system: &WaveSystem<D>,
        soft: f64,
        beside: Option<&[SVector<f64, D>]>,
    ) -> Judgment<D> {
        if let Some((system, unit)) = system.in_moderate_units() {
            let judgment = self.in_units(unit).judgment_of(&system, soft, beside);
            return Judgment {
                softest: judgment.softest.map(|mode| mode.in_units(unit)),
                ..judgment
            };
        }
        if let Some(reduced) = system.reduced() {
            // The omitted modes have the scaled measure zero: if a limit of zero or above is requested, the softest mode is always needed.
            let soft = if soft < 0.0 { soft } else { f64::INFINITY };
            let judgment = self.judgment_of(reduced, soft, beside);
            return Judgment {
                // A NaN measure remains NaN.
                measure: match judgment.measure > 0.0 {
                    true => 0.0,
                    false => judgment.measure,
                },
                softest: judgment.softest.map(|mode| self.softest_of(system, mode)),
                ..judgment
            };
        }
        if let Some((range, search, system)) = self.short_ranged_system(system) {
            let judgment = search.judgment_of(&system, soft, None);
            let back = |mode: Mode<D>| range.mode_carried_back(&mode, |k| self.folded(k));
            return Judgment {
                softest: judgment.softest.map(back),
                witness: None,
                ..judgment
            };
        }
        match system.single() {
            Some(matrix) => self.judgment(&matrix, soft, beside),
            None => Sweep::new(self, system, false).judgment(soft, beside.unwrap_or_default()),
        }
    }

    /// Extends the summary of the reduced system to the whole one, whose other modes have `omega = 0` at every wave vector.
    fn with_null_space(
        &self,
        system: &WaveSystem<D>,
        found: SpectrumSummary<D>,
    ) -> SpectrumSummary<D> {
        let shown = |mode| shown_of(system, mode);
        SpectrumSummary {
            softest: self.softest_of(system, found.softest),
            lowest: shown(found.lowest),
            fastest_growing: shown(found.fastest_growing),
            bound: found.bound.min(0.0),
            ..found
        }
    }

    /// Softest mode of the whole system, from the softest mode of the reduced one.
    fn softest_of(&self, system: &WaveSystem<D>, reduced: Mode<D>) -> Mode<D> {
        let softest = match reduced.scaled > 0.0 {
            true => Mode {
                wave_vector: self.folded(&(self.reference().reciprocal() * SVector::repeat(0.5))),
                is_long_wave: false,
                omega_squared: Complex::default(),
                scaled: 0.0,
                ..reduced
            },
            false => reduced,
        };
        shown_of(system, softest)
    }

    /// Returns true if long waves of an unstable state grow, as in [`ZoneSearch::long_waves_grow`]. Flutter counts only if the waves of the material
    /// also grow by flutter alone.
    pub(crate) fn long_waves_grow_of(
        &self,
        system: &WaveSystem<D>,
        stability: Stability,
        material: &AcousticMinimum<D>,
    ) -> bool {
        if let Some((system, unit)) = system.in_moderate_units() {
            return self
                .in_units(unit)
                .long_waves_grow_of(&system, stability, material);
        }
        if let Some(reduced) = system.reduced() {
            return self.long_waves_grow_of(reduced, stability, material);
        }
        if let Some((_, search, system)) = self.short_ranged_system(system) {
            return search.long_waves_grow_of(&system, stability, material);
        }
        if let Some(matrix) = system.single() {
            return self.long_waves_grow(&matrix, material);
        }
        let sweep = Sweep::new(self, system, false);
        let long = sweep.long_waves();
        let is_soft = stability == Stability::Divergence && long.mode.scaled < -long.tolerance;
        is_soft || (material.only_flutters() && sweep.stiffness.flutter().is_some())
    }
}

/// Mode of the reduced system, with the displacements of the whole system.
fn shown_of<const D: usize>(system: &WaveSystem<D>, mode: Mode<D>) -> Mode<D> {
    match mode.is_long_wave || mode.wave_vector.norm() == 0.0 {
        true => mode,
        false => Mode {
            polarization: largest_of_particles(
                &system.mode_of(&mode.wave_vector, mode.omega_squared),
            ),
            ..mode
        },
    }
}

impl<const D: usize> ZoneSearch<D> {
    /// Search and system in coordinates in which the forces have the same range in all directions, if the reference lattice is too oblique for them.
    pub(in crate::bloch) fn short_ranged_system(
        &self,
        system: &WaveSystem<D>,
    ) -> Option<(ShortRange<D>, Self, WaveSystem<D>)> {
        let range = system.short_range()?;
        let system = system.in_short_range(&range)?;
        Some((range, self.in_short_range(&range)?, system))
    }
}

struct Sweep<'a, const D: usize> {
    search: &'a ZoneSearch<D>,
    system: &'a WaveSystem<D>,
    /// Form in which the system is evaluated, built when first needed.
    form: OnceLock<Box<dyn Sampled<D> + 'a>>,
    /// True if lower bounds are requested; they cost several times the search.
    is_bounded: bool,
    /// Objective function for [`Objective::Function`].
    function: Option<WaveFunction<'a, D>>,
    effort: Effort,
    waves: Arc<WaveGrid<D>>,
    /// `omega^2` at half of the grid, computed when first needed. The wave vector `-k` has the complex conjugates.
    spectra: OnceLock<Spectra>,
    /// Squared half differences of neighboring branches at half of the grid, computed when first needed.
    squares: OnceLock<Vec<Vec<f64>>>,
    /// `omega^2` at `k = 0`, without free translations.
    at_gamma: Vec<Complex>,
    /// Long-wave stiffness, with the two estimates of its rounding error below.
    stiffness: Stiffness<D>,
    long_wave_noise: [f64; 2],
}

/// Upper limits of the work of a search.
#[derive(Clone, Copy)]
struct Effort {
    /// Number of grid wells that are followed to their bottoms.
    wells: usize,
    /// Number of boxes that are divided in each round.
    boxes: usize,
    /// Number of smallest boxes that start a descent.
    leaves: usize,
    /// Number of predicted pockets of complex `omega^2` that are refined.
    pockets: usize,
    /// Number of points between halved steps at which pockets are predicted.
    finer: usize,
    /// True if one spectrum occupies one core. Then only the lowest wave along a ray is followed, and each bottom is followed only once.
    is_large: bool,
}

impl Effort {
    /// Chooses the limits. Small cells in the plane are cheap; large cells have small zones with little detail between the grid points.
    fn of<const D: usize>(system: &WaveSystem<D>) -> Self {
        let (wells, boxes, leaves, pockets) = match (D, system.size()) {
            (3, 0..8) => (48, 16, 8, 256),
            (3, _) | (_, 16..) => (6, 8, 4, 48),
            _ => (32, 48, 12, 256),
        };
        Self {
            wells,
            boxes,
            leaves,
            pockets,
            finer: if system.size() < HUGE_CELL_SIZE {
                HALVED_STEP_POINTS
            } else {
                HALVED_STEP_POINTS / 8
            },
            is_large: system.size() >= LARGE_CELL_SIZE,
        }
    }
}

impl<'a, const D: usize> Sweep<'a, D> {
    fn new(search: &'a ZoneSearch<D>, system: &'a WaveSystem<D>, is_bounded: bool) -> Self {
        let waves = search.grid_of(resolution(system));
        let (stiffness, long_wave_noise) = system.long_waves();
        Self {
            search,
            system,
            form: OnceLock::new(),
            is_bounded,
            function: None,
            effort: Effort::of(system),
            spectra: OnceLock::new(),
            squares: OnceLock::new(),
            waves,
            at_gamma: system.omega_squared_at_gamma(),
            stiffness,
            long_wave_noise,
        }
    }

    fn summary(&self, sought: Flutter) -> SpectrumSummary<D> {
        let found = self.softest(&self.long_waves());
        let Softest {
            softest, lowest, ..
        } = found;
        let grows = found.grows_at_gamma || softest.scaled < -found.tolerance;
        let sites = self.system.sites();
        let growing = grows.then_some(lowest);
        let rival = self.search.rival(sought, growing, sites);
        let growth = growing.map_or(0.0, |mode| growth_rate(mode.omega_squared));
        let fluttering = self.flutter(rival, growth);
        let fastest_growing = fluttering
            .filter(|mode| growth_rate(mode.omega_squared) > growth_rate(lowest.omega_squared))
            .unwrap_or(lowest);
        let at_gamma = self.at_gamma.iter().map(|value| value.re);
        let highest = at_gamma.fold(0.0, f64::max);
        let highest = self
            .lowest(Objective::Highest, -highest, &softest)
            .map_or(highest, |(value, _)| highest.max(-value));
        SpectrumSummary {
            softest: if found.grows_at_gamma {
                self.search.over_largest_laplacian(lowest)
            } else {
                softest
            },
            long_wave: found.long_wave,
            lowest,
            fastest_growing,
            maximum_omega: highest.max(0.0).sqrt(),
            tolerance: found.tolerance,
            bound: found.bound,
            flutters: fluttering.is_some(),
            long_waves_flutter: sought.includes_long_waves(rival, fluttering.is_some())
                && self.stiffness.flutter().is_some(),
        }
    }

    /// Implements [`ZoneSearch::judgment_of`] by a search.
    fn judgment(&self, soft: f64, beside: &[SVector<f64, D>]) -> Judgment<D> {
        let diverges = |measure, witness| Judgment {
            stability: Stability::Divergence,
            measure,
            witness,
            softest: None,
        };
        let long = self.long_waves();
        if long.rest.omega_squared.re < 0.0 || long.mode.scaled < -long.of_limit {
            // The long-wave limit also describes the mode at `k = 0`, unless this mode grows itself.
            return diverges(long.rest.scaled, None);
        }
        // One witness is enough: a known one, or one on the grid.
        let spectra = self.sampled().spectra(beside);
        let known = beside.iter().zip(spectra.iter());
        let mut known = known.filter_map(|(k, spectrum)| self.witness(&long, *k, spectrum));
        let sampled = || {
            let grid = half(&self.waves).into_iter().zip(self.spectra().iter());
            let sampled = grid.filter_map(|(k, spectrum)| self.witness(&long, k, spectrum));
            sampled.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        if let Some((measure, k)) = known.next().or_else(sampled) {
            return diverges(measure, Some(k));
        }
        let found = self.softest(&long);
        let measure = found.softest.scaled;
        if measure < -found.tolerance || found.lowest.omega_squared.re < 0.0 {
            let witness = (!found.softest.is_long_wave).then_some(found.softest.wave_vector);
            return diverges(measure, witness);
        }
        let flutters = self.flutters();
        Judgment {
            stability: match flutters {
                true => Stability::Flutter,
                false => Stability::Stable,
            },
            measure,
            witness: None,
            softest: (!flutters && measure <= soft).then_some(found.softest),
        }
    }

    /// Returns the scaled measure of a wave vector if it is negative beyond rounding.
    fn witness(
        &self,
        long: &LongWaves<D>,
        k: SVector<f64, D>,
        spectrum: &[Complex],
    ) -> Option<Candidate<D>> {
        if self.is_long(&k) {
            return None;
        }
        let lowest = spectrum.iter().map(|z| z.re).fold(f64::INFINITY, f64::min);
        let measure = self.scaled(&k, lowest);
        let is_significant =
            measure < -long.tolerance && lowest < -ROUNDING_FACTOR * self.system.noise();
        is_significant.then_some((measure, k))
    }
}
