//! Extremes of the spectrum over the zone, for any number of particles in a cell.
//!
//! Systems with one particle in a cell are left to the matrix search of [`ZoneSearch`]. Otherwise, each objective is the lowest of several
//! branches. Its minima are smooth, because branches that cross leave a ridge, but crossings can make them narrow. The search has four steps:
//!
//! 1. `omega^2` is computed on a grid over half of the zone (`sampled`), and the wells of the grid are followed to their bottoms by Newton's method
//!    with exact derivatives.
//! 2. Boxes around grid points in which some branch can fall lower, judging by its slope, are halved repeatedly; lower values found there are
//!    followed too.
//! 3. If the forces do not derive from an energy, pockets of complex `omega^2` are predicted from the derivatives at grid points (`bloch::pocket`), and
//!    descents of the squared difference of neighboring branches end in pockets of any size.
//! 4. On request, branch and bound computes a lower bound (`bloch::bound`).
//!
//! Only the bound is guaranteed. The extremes themselves are sampled values. Constants without a stated derivation are heuristic; the tests `hunt`
//! compare random states with a dense search.

use super::WaveSystem;
use super::sampled::{LARGE_CELL_SIZE, Sampled, Spectra};
use crate::algebra::{Complex, Decomposition, Each, array_of, lowest_between, sort_by_value};
use crate::bloch::bound::{BUDGET, Covered, GAP, Measure, Question, WIDEST_GAP, cover_system};
use crate::bloch::branches::Taylor;
use crate::bloch::pocket::{Around, HALVED_STEP_POINTS, Pockets};
use crate::bloch::search::{
    Flutter, LONG_WAVE_FRACTION, RELAXED_RAY_STEPS, is_near_crossing, is_well, neighbors, settled,
    settled_along,
};
use crate::bloch::short_range::ShortRange;
use crate::bloch::{Judgment, Mode, SpectrumSummary, Stability, ZoneSearch, growth_rate};
use crate::continuum::{AcousticMinimum, Stiffness};
use crate::lattice::{WaveGrid, grid_coordinates};
use crate::real::LANES;
use nalgebra::{DVector, SMatrix, SVector};
use std::convert::Infallible;
use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::{Arc, OnceLock};

/// Grid points per period of the fastest phase. A heuristic value; the division of boxes finds wells between the points.
const POINTS_PER_PERIOD: usize = 10;
/// Tolerance for zero, as a multiple of the rounding error of lattice sums. Force constants also contain the rounding error of their shape functions,
/// which is several times larger.
const ROUNDING_FACTOR: f64 = 16.0;
/// Noise factor: at the smallest wave number tested for growth, the long-wave limit predicts this multiple of the rounding error.
const LONG_WAVE_NOISE_FACTOR: f64 = 8.0;
/// Number of wave numbers tested for growth, two octaves apart.
const TESTED_WAVE_NUMBERS: i32 = 5;
/// Tolerance, in octaves, of the wave number of the fastest growing long wave.
const PEAK_TOLERANCE_OCTAVES: f64 = 1e-5;
/// Accepted gap between an extreme squared frequency and its bound, relative to the largest squared frequency of a wave at speed `c`.
const FREQUENCY_GAP: f64 = 1e-6;
/// Divisor of the box budget for the bounds of the largest and the smallest squared frequency.
const FREQUENCY_BUDGET_DIVISOR: usize = 4;
/// Maximum gap between a bound and the smallest value, relative to this value. Beyond it the wells of the grid are followed too.
const LOOSE_BOUND_RATIO: f64 = 1e-3;
/// Minimum fraction of the largest known growth rate at which a wave is followed further although Newton's method has not converged. A heuristic
/// value.
const FOLLOWED_GROWTH_RATIO: f64 = 0.7;
/// Minimum fraction of the largest known growth rate at which the best point of shells of long waves is followed. The peak can lie between two shells.
const FOLLOWED_SHELL_RATIO: f64 = 0.4;
/// Relative tolerance of squared frequencies: a wave that is no lower than the wave at `k = 0` is replaced by it.
const EQUAL_FREQUENCY_TOLERANCE: f64 = 1e-9;
/// Relative difference of the lengths of wave vectors that count as equal.
const EQUAL_LENGTH_TOLERANCE: f64 = 1e-6;
/// Distance from a known bottom, in grid steps, within which a descent that does not reach a lower value has found the same bottom.
const KNOWN_BOTTOM_STEPS: f64 = 0.02;
/// Number of times that boxes are halved.
const BOX_DIVISIONS: usize = 2;
/// Side of the smallest boxes, in grid steps.
const LEAF_STEPS: f64 = 0.25;
const _: () = assert!(LEAF_STEPS * (1 << BOX_DIVISIONS) as f64 == 1.0);
/// Number of lowest branches that are checked for wells between the grid points.
const TRACKED_BRANCHES: usize = 3;
/// Minimum number of degrees of freedom of a huge cell. Its zone is so small that a few grid points resolve it.
const HUGE_CELL_SIZE: usize = 96;
/// Change of a branch within half a grid step, as a fraction of its change within a whole step. It exceeds one half because branches curve.
const HALF_STEP_CHANGE: f64 = 0.6;
/// Number of grid points along a reciprocal vector with damping, where each value requires the eigenvalues for many time steps. The extreme time
/// steps belong to short waves, which vary slowly over the zone.
const DAMPED_GRID_POINTS: usize = 12;
/// Number of wells that are followed to their bottoms with damping.
const DAMPED_WELLS: usize = 4;
/// Sizes of rings around `k = 0` for the search for crossings of branches, in units of the largest shell of long waves.
const RING_SIZES: [f64; 8] = [1.0, 0.7, 0.5, 0.35, 0.25, 0.18, 0.12, 0.06];
/// Number of times that eight points along a ray narrow the interval around a crossing of two branches, each time to two ninths.
const CROSSING_ROUNDS: usize = 6;
/// Ratios of short to long steps in a narrow valley.
const VALLEY_WIDTHS: [f64; 3] = [0.1, 1e-2, 1e-3];
/// Half the side of the cube of points around `k = 0`, in grid steps: the largest shell of long waves.
const SHELL_STEPS: usize = 4;

/// Values of the objective for the lowest branches at a wave vector, lowest first; infinite if there are fewer branches.
type Branches = [f64; TRACKED_BRANCHES];

/// Placeholder for the branches of long waves, which are not sampled.
const UNKNOWN: Branches = [f64::INFINITY; TRACKED_BRANCHES];

/// Value of the objective, and its wave vector.
type Candidate<const D: usize> = (f64, SVector<f64, D>);

/// Start of a descent.
#[derive(Clone, Copy)]
struct Start<const D: usize> {
    /// Number of the branch, and its value at a wave vector.
    branch: usize,
    place: Candidate<D>,
    /// Lowest value that the descent may reach.
    bound: f64,
    /// True if the start represents a small box, which a known bottom inside settles.
    is_in_box: bool,
}

impl<const D: usize> Start<D> {
    /// Start on the lowest branch of a descent that may reach any value.
    fn at(place: Candidate<D>) -> Self {
        Self {
            branch: 0,
            place,
            bound: f64::NEG_INFINITY,
            is_in_box: false,
        }
    }
}

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

/// Returns true if a descent from a value may end below the deepest end: `fraction` of a growth rate can rise to the rate itself on the way.
fn may_beat(value: f64, deepest: f64, fraction: f64) -> bool {
    value < deepest.max(fraction * deepest)
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
    /// See [`Self::squares`].
    squares: OnceLock<Vec<Vec<f64>>>,
    /// `omega^2` at `k = 0`, without free translations.
    at_gamma: Vec<Complex>,
    /// Long-wave stiffness, with the two estimates of its rounding error below.
    stiffness: Stiffness<D>,
    long_wave_noise: [f64; 2],
}

/// Results that need no search: the long-wave limit and `k = 0`.
struct LongWaves<const D: usize> {
    mode: Mode<D>,
    rest: Mode<D>,
    /// Tolerance of scaled measures at finite wave vectors; smaller magnitudes are zero to rounding.
    tolerance: f64,
    /// Tolerance of scaled measures in the long-wave limit, which includes the relaxation of the particles of a cell.
    of_limit: f64,
}

/// Softest and lowest mode of a system, without flutter.
struct Softest<const D: usize> {
    softest: Mode<D>,
    lowest: Mode<D>,
    long_wave: Mode<D>,
    grows_at_gamma: bool,
    tolerance: f64,
    bound: f64,
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

/// Box of wave vectors around a center.
struct Region<const D: usize> {
    center: SVector<f64, D>,
    /// Values of the objective for the lowest branches at the center.
    branches: Branches,
    /// Branch with the lowest estimated values in the box, its estimated lower limit from the slope, and its expected minimum.
    branch: usize,
    bound: f64,
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

    fn long_waves(&self) -> LongWaves<D> {
        let mut mode = self.search.long_wave_mode(&self.stiffness);
        let at_gamma = self.at_gamma.iter().map(|value| value.re);
        let least = at_gamma.fold(f64::INFINITY, f64::min);
        let strains = self.system.rigid_translation().amax() > 0.0;
        if strains && least >= -ROUNDING_FACTOR * self.system.noise() {
            // A translation that raises the energy excludes long waves of vanishing frequency. Free modes near it are found at finite wave vectors.
            mode.scaled = f64::INFINITY;
        }
        let [tolerance, mut of_limit] = self
            .long_wave_noise
            .each(|noise| self.search.measure_of_noise(noise));
        if mode.scaled < -of_limit && !self.is_followed(&mode) {
            of_limit = -mode.scaled;
        }
        LongWaves {
            mode,
            rest: self.rest(mode.scaled),
            tolerance,
            of_limit,
        }
    }

    /// Smallest wave number, along the direction of a negative long-wave limit, at which growth exceeds rounding; and the lowest `Re omega^2` as a
    /// function of octaves above this wave number.
    fn smallest_tested(&self, limit: &Mode<D>) -> (f64, impl Fn(f64) -> f64) {
        let stiffness = -limit.scaled * self.search.speed_squared();
        let longest =
            (LONG_WAVE_NOISE_FACTOR * ROUNDING_FACTOR * self.system.noise() / stiffness).sqrt();
        let direction = limit.wave_vector.normalize();
        let lowest = move |octaves: f64| {
            let k = direction * (longest * octaves.exp2());
            let values = self.system.omega_squared(&k).into_iter();
            values.map(|value| value.re).fold(f64::INFINITY, f64::min)
        };
        (longest, lowest)
    }

    /// Returns true if finite waves grow along a direction of negative long-wave stiffness.
    fn is_followed(&self, limit: &Mode<D>) -> bool {
        let (_, lowest) = self.smallest_tested(limit);
        let noise = ROUNDING_FACTOR * self.system.noise();
        (0..TESTED_WAVE_NUMBERS).any(|n| lowest(f64::from(2 * n)) < -noise)
    }

    /// Fastest growing wave along a direction of negative long-wave stiffness, among waves longer than the grid resolves. Particles of a cell that
    /// barely resist relative motion relax only in such long waves.
    fn growing_long_wave(&self, limit: &Mode<D>) -> Option<Mode<D>> {
        let (longest, lowest) = self.smallest_tested(limit);
        let step = self.search.reference().reciprocal().column(0).norm();
        let octaves = (step / self.waves.resolution() as f64 / longest).log2();
        let values = (0..=octaves as usize).map(|n| (lowest(n as f64), n as f64));
        let (value, best) = values.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let at = |octaves: f64| Ok::<f64, Infallible>(lowest(octaves));
        let Ok((octaves, _)) = lowest_between(
            at,
            [best - 1.0, best, best + 1.0],
            value,
            PEAK_TOLERANCE_OCTAVES,
        );
        let k = limit.wave_vector.normalize() * (longest * octaves.exp2());
        let mode = self.mode(&k);
        (mode.omega_squared.re < -ROUNDING_FACTOR * self.system.noise()).then_some(mode)
    }

    fn softest(&self, long: &LongWaves<D>) -> Softest<D> {
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

    /// Wave vectors in pockets of complex `omega^2` in which waves may grow faster than `rival`.
    fn pockets(&self, rival: f64) -> Vec<SVector<f64, D>> {
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

    /// Squares of the half differences of neighboring branches at half of the grid, for each branch but the lowest; infinite for long waves.
    fn squares(&self) -> &[Vec<f64>] {
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
    fn square(&self, upper: usize, k: &SVector<f64, D>, spectrum: &[Complex]) -> f64 {
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
    fn meetings(&self) -> Vec<SVector<f64, D>> {
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

    /// `D(k)` with its derivatives; `None` for long waves.
    fn around(&self, wave_vectors: &[SVector<f64, D>]) -> Vec<Option<Around<D>>> {
        let short = wave_vectors.iter().filter(|k| !self.is_long(k));
        let mut around = self
            .sampled()
            .around(&short.copied().collect::<Vec<_>>())
            .into_iter();
        let own = |k| if self.is_long(k) { None } else { around.next() };
        wave_vectors.iter().map(own).collect()
    }

    fn sampled(&self) -> &dyn Sampled<D> {
        &**self.form.get_or_init(|| self.system.sampled())
    }

    /// `omega^2` at half of the grid.
    fn spectra(&self) -> &Spectra {
        let sample = || self.sampled().spectra(&half(&self.waves));
        self.spectra.get_or_init(sample)
    }

    /// Smallest value of an objective below `floor`: by branch and bound if possible, otherwise sampled.
    fn lowest(&self, objective: Objective, floor: f64, softest: &Mode<D>) -> Option<Candidate<D>> {
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

    /// Returns true if a wave with complex `omega^2` grows noticeably. Only its existence is needed, so that one such grid point suffices.
    fn flutters(&self) -> bool {
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
    fn flutter(&self, rival: f64, growth: f64) -> Option<Mode<D>> {
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

    /// Values of the objective for the lowest branches at a wave vector, lowest first, from its spectrum.
    fn branches(
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

    fn value(&self, objective: Objective, k: &SVector<f64, D>) -> f64 {
        self.branches_at(objective, &[*k])[0][0]
    }

    /// Values of the objective for the lowest branches, at wave vectors whose spectra are not yet known.
    fn branches_at(&self, objective: Objective, wave_vectors: &[SVector<f64, D>]) -> Vec<Branches> {
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
    fn scaled(&self, k: &SVector<f64, D>, omega_squared: f64) -> f64 {
        let scale = self.search.speed_squared() * self.search.reference().laplacian(k);
        scaled(omega_squared, ROUNDING_FACTOR * self.system.noise(), scale)
    }

    /// Returns true if the wave vector is so close to zero, or to a reciprocal vector, that the long-wave limit represents it.
    fn is_long(&self, k: &SVector<f64, D>) -> bool {
        let lattice = self.search.reference();
        let smallest = lattice.reciprocal().column_iter().map(|b| b.norm());
        let smallest = smallest.fold(f64::INFINITY, f64::min);
        lattice.laplacian(k) < (LONG_WAVE_FRACTION * smallest).powi(2)
    }

    /// Smallest bottom that a descent finds.
    fn bottom(&self, objective: Objective, floor: f64) -> Option<Candidate<D>> {
        let bottoms = self.bottoms(objective, floor).into_iter();
        bottoms.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Branches of an objective at the wave vectors of half of the grid.
    fn sampled_branches(
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

    /// Ends of all descents that may fall below `floor` and below the bottoms found before.
    fn bottoms(&self, objective: Objective, floor: f64) -> Vec<Candidate<D>> {
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

    /// Value below which a descent finds something new: the smallest of `floor` and the known ends, less rounding.
    fn to_beat(&self, objective: Objective, floor: f64, ends: &[Candidate<D>]) -> f64 {
        ends.iter().map(|end| end.0).fold(floor, f64::min) - self.margin(objective)
    }

    /// Minimum of the function: over the bottoms from the grid, from pockets of complex `omega^2`, and from long waves.
    fn least(&self) -> Candidate<D> {
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
    fn shell(&self) -> Vec<SVector<f64, D>> {
        let softest = self.search.long_wave_mode(&self.stiffness).wave_vector;
        let fluttering = self.search.long_flutter(&self.stiffness, 1.0);
        let along = std::iter::once(softest).chain(fluttering.into_iter().take(1));
        let along = along.map(|k| self.search.reference().fractional(&k));
        let along = along.map(|place| place * (SHELL_STEPS as f64 / place.amax()));
        shell()
            .chain(along.filter(|place| place.amax().is_finite()))
            .collect()
    }

    /// Starts of descents along a ray, given one grid step along it. In large cells only the lowest start.
    fn along_ray(&self, objective: Objective, step: &SVector<f64, D>) -> Vec<Candidate<D>> {
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
    fn symmetric_points(&self) -> impl Iterator<Item = usize> {
        let n = self.waves.resolution();
        let is_symmetric = move |c: &usize| [0, n / 3, n / 2, 2 * n / 3].contains(c);
        (1..self.waves.half())
            .filter(move |index| grid_coordinates::<D>(*index, n).iter().all(is_symmetric))
    }

    /// Wave vectors near a point of high symmetry, in one dimension only.
    ///
    /// Folded branches that nearly cross there have strong curvature within a fraction of a grid step. In higher dimensions the number of such wave
    /// vectors would be comparable to the size of the grid.
    fn beside(&self, k: &SVector<f64, D>) -> impl Iterator<Item = SVector<f64, D>> {
        let step = self.search.reference().reciprocal().column(0) / self.waves.resolution() as f64;
        let near = RELAXED_RAY_STEPS.each(|share| [k - step * share, k + step * share]);
        near.into_iter().flatten().filter(|_| D == 1)
    }

    /// Largest difference of an objective that is a rounding error. Zero-energy modes have many wells that are due to rounding.
    fn margin(&self, objective: Objective) -> f64 {
        let noise = ROUNDING_FACTOR * self.system.noise();
        let scale = self.search.speed_squared() * self.search.largest_laplacian();
        match objective {
            Objective::Scaled => noise / scale,
            Objective::Lowest | Objective::Highest => noise,
            Objective::Growth => self.search.flutter_threshold(self.system.sites()),
            Objective::Function => 0.0,
        }
    }

    /// Distinct wells of the grid, deepest first: value, height of the highest neighbor above it, and index.
    fn wells(&self, values: &[f64]) -> Vec<(f64, f64, usize)> {
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

    /// Small boxes in which a branch may fall below `below`, estimated from its changes around them.
    ///
    /// The boxes around the grid points are halved repeatedly; boxes of known bottoms are omitted.
    fn regions(
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

    /// Returns true if a known bottom lies within a number of grid steps.
    fn is_near_bottom(&self, k: &SVector<f64, D>, known: &[Candidate<D>], steps: f64) -> bool {
        known
            .iter()
            .any(|end| self.steps_between(k, &end.1) <= steps)
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

    /// Distance of two wave vectors in grid steps, modulo reciprocal vectors.
    fn steps_between(&self, a: &SVector<f64, D>, b: &SVector<f64, D>) -> f64 {
        let periods = self.search.reference().fractional(&(a - b));
        let apart = periods.map(|x| (x - x.round()).abs()).max();
        apart * self.waves.resolution() as f64
    }

    /// Starts at wave vectors.
    fn starts(
        &self,
        objective: Objective,
        wave_vectors: impl Iterator<Item = SVector<f64, D>>,
    ) -> Vec<Start<D>> {
        let wave_vectors: Vec<_> = wave_vectors.collect();
        let branches = self.branches_at(objective, &wave_vectors);
        let both = branches.into_iter().zip(wave_vectors);
        both.map(|(own, k)| Start::at((own[0], k))).collect()
    }

    /// Follows branches from their starts to their bottoms, as many at a time as are evaluated together, except those that cannot fall below `floor`
    /// and all known ends.
    fn follow(
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
    fn follow_together(
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
    fn followed(&self, objective: Objective, start: Candidate<D>) -> Candidate<D> {
        let mut ends = Vec::with_capacity(1);
        self.follow_together(objective, &[Start::at(start)], f64::INFINITY, &mut ends);
        ends[0]
    }

    /// Local minimum of the lowest branch, by finite differences with the given initial steps.
    fn settled(
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

    /// Mode with the lowest `Re omega^2` at a wave vector.
    fn mode(&self, k: &SVector<f64, D>) -> Mode<D> {
        let k = self.search.folded(k);
        self.shown(&k, |values| (!values.is_empty()).then_some(0))
    }

    /// Fastest growing mode with complex `omega^2` at a wave vector.
    fn fluttering(&self, k: &SVector<f64, D>) -> Mode<D> {
        let k = self.search.folded(k);
        self.shown(&k, |values| {
            let complex = (0..values.len()).filter(|n| values[*n].im != 0.0);
            complex.max_by(|a, b| growth_rate(values[*a]).total_cmp(&growth_rate(values[*b])))
        })
    }

    /// Mode at a wave vector that `chosen` selects from the values of `omega^2`.
    fn shown(&self, k: &SVector<f64, D>, chosen: impl Fn(&[Complex]) -> Option<usize>) -> Mode<D> {
        let modes = self
            .system
            .modes_of(k, |values| chosen(values).into_iter().collect());
        let mode = modes.into_iter().next();
        let (omega_squared, displacements) = mode.unwrap_or_else(|| no_mode(self.system.size()));
        Mode {
            wave_vector: *k,
            is_long_wave: false,
            omega_squared,
            scaled: self.scaled(k, omega_squared.re),
            polarization: largest_of_particles(&displacements),
        }
    }

    /// Mode with the lowest `Re omega^2` at `k = 0`. This is the translation, with the given scaled measure, unless a mode grows there.
    fn rest(&self, scaled: f64) -> Mode<D> {
        let lowest = self.at_gamma.iter().map(|value| value.re);
        let lowest = lowest.fold(f64::INFINITY, f64::min);
        let threshold = self.search.flutter_threshold(self.system.sites()).powi(2);
        if lowest < -threshold.max(ROUNDING_FACTOR * self.system.noise()) {
            return self
                .search
                .over_largest_laplacian(self.mode(&SVector::zeros()));
        }
        Mode {
            wave_vector: SVector::zeros(),
            is_long_wave: false,
            omega_squared: Complex::new(0.0, 0.0),
            scaled,
            polarization: SVector::from_fn(|i, _| Complex::new(f64::from(u8::from(i == 0)), 0.0)),
        }
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

/// Scaled measure of a squared frequency, in which rounding counts as zero; `scale` is `c^2 |k|_h^2`.
fn scaled(omega_squared: f64, noise: f64, scale: f64) -> f64 {
    match omega_squared.abs() <= noise {
        true => 0.0,
        false => omega_squared / scale,
    }
}

/// Keeps the boxes that may contain a value below `below`, at most `most` of them.
fn chosen<const D: usize>(regions: &mut Vec<Region<D>>, below: f64, most: usize) {
    regions.retain(|region| region.bound < below);
    sort_by_value(regions, |region| region.expected);
    regions.truncate(most);
}

/// Negative growth rates of complex `omega^2`; zero for real values.
fn complex_growth(spectrum: &[Complex]) -> impl Iterator<Item = f64> {
    spectrum
        .iter()
        .map(|z| if z.im == 0.0 { 0.0 } else { -growth_rate(*z) })
}

/// Grid points along each reciprocal vector: enough for the range of the forces, fewer for large cells, whose zones are small. A multiple of six
/// places points of high symmetry on the grid.
fn resolution<const D: usize>(system: &WaveSystem<D>) -> usize {
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
fn lowest_of(branches: &[Branches]) -> Vec<f64> {
    branches.iter().map(|own| own[0]).collect()
}

/// Candidate with the smallest value; infinite if the list is empty.
fn least_of_all<const D: usize>(ends: Vec<Candidate<D>>) -> Candidate<D> {
    let best = ends.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    best.unwrap_or((f64::INFINITY, SVector::zeros()))
}

/// Points on the surface of a cube around zero, in grid steps; one of each pair of opposite points.
fn shell<const D: usize>() -> impl Iterator<Item = SVector<f64, D>> {
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

/// Half of the wave vectors of a grid; `-k` has the complex conjugate spectrum.
fn half<const D: usize>(waves: &WaveGrid<D>) -> Vec<SVector<f64, D>> {
    waves.wave_vectors().take(waves.half()).collect()
}

/// Displacement of the particle with the largest amplitude, scaled to unit length.
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

/// Mode of NaN values for an eigenvalue iteration that has not converged.
fn no_mode(size: usize) -> (Complex, DVector<Complex>) {
    let nan = Complex::new(f64::NAN, f64::NAN);
    (nan, DVector::repeat(size, nan))
}
