//! The extremes of the spectrum over the zone, for any number of particles in a cell.
//!
//! With one particle in a cell the search of [`ZoneSearch`] is used. Otherwise: each objective is the lowest of several branches,
//! smooth but where two of them meet, so that its minima are smooth ones, however narrow the crossings leave them. The wells of a
//! grid are followed to their bottoms with exact derivatives; then the boxes around points of the grid in which some branch, by its
//! slope, can get lower are divided, again and again, and what lies lower there is followed too.

use super::WaveSystem;
use crate::algebra::{
    Complex, Decomposition, Each, is_well, lowest_between, neighbors, settled, sort_by_value,
};
use crate::bloch::bound::{BUDGET, Covered, GAP, Measure, Question, WIDEST, cover_system};
use crate::bloch::branches::Taylor;
use crate::bloch::pocket::{Around, FINER, Pockets};
use crate::bloch::search::{Flutter, RELAXED_RAY};
use crate::bloch::short_range::ShortRange;
use crate::bloch::{IsEnded, Judgment, Mode, SpectrumSummary, Stability, ZoneSearch, growth_rate};
use crate::continuum::{AcousticMinimum, Stiffness};
use crate::cores::of_each_long;
use crate::lattice::{WaveGrid, grid_coordinates};
use nalgebra::{DVector, SMatrix, SVector};
use std::convert::Infallible;
use std::sync::{Arc, OnceLock};

/// Points of the grid per period of the fastest phase.
const POINTS_PER_PERIOD: usize = 10;
/// What is within this multiple of the rounding error of sums counts as zero: force constants carry the rounding of the shape functions
/// that they are made of, which is some times that of the sums.
const ROUNDING: f64 = 16.0;
/// What a limit of long waves makes of the longest wave that is asked whether it grows, in units of what rounding makes of it; how many
/// waves are asked, two octaves apart; and how near in octaves the fastest growing one is found.
const TOLD: f64 = 8.0;
const FOLLOWED: i32 = 5;
const NARROWED: f64 = 1e-5;
/// What is not told from the largest and the smallest squared frequency, relative to it, and the part of the work for a bound that
/// is done for them.
const FREQUENCY_GAP: f64 = 1e-6;
const FREQUENCY_SHARE: usize = 4;
/// Differences of a bound from the smallest value, relative to it, from which the smallest value is searched too.
const LOOSE: f64 = 1e-3;
/// Growth rates above this part of the fastest one that is known are followed where Newton's method has not ended.
const PROMISING: f64 = 0.7;
/// Waves that grow faster than the one at `k = 0` by less than this part are taken for it.
const ALIKE: f64 = 1e-9;
/// Steps of the grid from a known bottom within which a descent that is not lower has come to the same one.
const AT_BOTTOM: f64 = 0.02;
/// How often boxes are divided.
const DIVISIONS: usize = 2;
/// How many of the lowest branches may have a well between the points of the grid.
const BRANCHES: usize = 3;
/// Cells of so many degrees of freedom are large.
const LARGE: usize = 24;
/// The zone of those of so many is so small that a few points are as dense as many are in that of one particle.
const HUGE: usize = 96;
/// Within half of a step of the grid a branch changes by about this fraction of its change within a step.
const HALF: f64 = 0.6;
/// Points of the grid along a reciprocal vector, and wells that are followed, with damping, where each value takes the eigenvalues of many
/// steps. The shortest of these is that of short waves, which vary slowly over the zone.
const DAMPED_GRID: usize = 12;
const DAMPED_WELLS: usize = 4;
/// Steps of the grid from the middle of a shell of long waves to its faces.
const SHELL: usize = 4;
/// Wave vectors below this fraction of a reciprocal vector are long waves, which are taken to their limit.
const LONG: f64 = 1e-3;

/// A wave vector with the value of the objective there.
type Candidate<const D: usize> = (f64, SVector<f64, D>);

/// What is sought; always a minimum.
#[derive(Clone, Copy, PartialEq)]
enum Objective {
    /// `Re omega^2 / (c^2 |k|_h^2)`.
    Scaled,
    /// `Re omega^2`.
    Lowest,
    /// `-Re omega^2`.
    Highest,
    /// Minus the growth rate of complex `omega^2`.
    Growth,
    /// A function of the wave vector, [`Sweep::function`].
    Function,
}

/// A function of the wave vector whose least value is searched.
pub(crate) type WaveFunction<'a, const D: usize> = &'a (dyn Fn(&SVector<f64, D>) -> f64 + Sync);

impl<const D: usize> ZoneSearch<D> {
    /// The extremes of the spectrum of a system; damping left out.
    pub fn summary_of(&self, system: &WaveSystem<D>) -> SpectrumSummary<D> {
        self.found_of(system, Flutter::All, None)
    }

    /// Least value over the zone of a function that depends on the waves of a system, and its wave vector. Waves longer than
    /// `1 / LONG` cells are left out. The best value so far once `is_ended`.
    pub(crate) fn least_of(
        &self,
        system: &WaveSystem<D>,
        function: WaveFunction<'_, D>,
        is_ended: IsEnded<'_>,
    ) -> (f64, SVector<f64, D>) {
        if let Some((range, search, system)) = self.short_ranged_system(system) {
            let to_given = range.map.transpose();
            let carried = |k: &SVector<f64, D>| function(&(to_given * k));
            let (value, k) = search.least_of(&system, &carried, is_ended);
            return (value, self.folded(&(to_given * k)));
        }
        let mut sweep = Sweep::new(self, system, Some(is_ended));
        sweep.function = Some(function);
        if system.damping().is_some() {
            sweep.waves = self.grid_of(DAMPED_GRID);
            sweep.effort.wells = sweep.effort.wells.min(DAMPED_WELLS);
            sweep.effort.boxes = sweep.effort.boxes.min(DAMPED_WELLS);
            sweep.effort.leaves = sweep.effort.leaves.min(DAMPED_WELLS);
        }
        let (value, k) = sweep.least();
        (value, self.folded(&k))
    }

    /// The same, but for flutter that grows more slowly than what diverges, as [`ZoneSearch::extremes`] of a matrix.
    pub(crate) fn extremes_of(
        &self,
        system: &WaveSystem<D>,
        asks_about_long_waves: bool,
    ) -> SpectrumSummary<D> {
        let sought = Flutter::Fastest {
            asks_about_long_waves,
        };
        self.found_of(system, sought, None)
    }

    /// The same with a lower bound of the scaled measure wherever equations allow one.
    pub fn bounded_summary_of(&self, system: &WaveSystem<D>) -> SpectrumSummary<D> {
        self.bounded_summary_of_unless(system, &|| false)
    }

    /// The same, given up as soon as nobody waits for it any more.
    pub fn bounded_summary_of_unless(
        &self,
        system: &WaveSystem<D>,
        is_ended: IsEnded<'_>,
    ) -> SpectrumSummary<D> {
        self.found_of(system, Flutter::All, Some(is_ended))
    }

    /// The extremes; with a bound while somebody waits for it, where there is one.
    fn found_of(
        &self,
        system: &WaveSystem<D>,
        sought: Flutter,
        is_bounded: Option<IsEnded<'_>>,
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

    /// Whether a mode grows, and how: the same answer as that of the summary, without the largest frequency, and without more than one
    /// witness; with a measure whose sign it is where the spectrum is real, and the softest mode of a stable state whose measure is at
    /// most `soft`. Where witnesses of the states beside it are given, these are tried before any is searched for.
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
            // The modes that are left out have the measure zero: where one up to zero is asked about, the softest mode is wanted always.
            let soft = if soft < 0.0 { soft } else { f64::INFINITY };
            let judgment = self.judgment_of(reduced, soft, beside);
            return Judgment {
                // What is no number stays none.
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
            None => Sweep::new(self, system, None).judgment(soft, beside.unwrap_or_default()),
        }
    }

    /// What has been found of the reduced system, of the whole one: its other modes have `omega = 0` at any wave vector.
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

    /// The softest mode of the whole system, given that of the reduced one.
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

    /// Whether long waves of an unstable state grow, by flutter only where that is how waves of the material grow, as
    /// [`ZoneSearch::long_waves_grow`] of a matrix.
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
        let sweep = Sweep::new(self, system, None);
        let long = sweep.long_waves();
        let is_soft = stability == Stability::Divergence && long.mode.scaled < -long.tolerance;
        is_soft || (material.only_flutters() && sweep.stiffness.flutter().is_some())
    }
}

/// A mode of the reduced system, with the displacements of the whole one.
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
}

struct Sweep<'a, const D: usize> {
    search: &'a ZoneSearch<D>,
    system: &'a WaveSystem<D>,
    /// Whether bounds are wanted, which take several times as long as a search.
    is_bounded: bool,
    /// Whether nobody waits any more: then nothing is looked at that is not known.
    is_ended: IsEnded<'a>,
    /// The function of [`Objective::Function`].
    function: Option<WaveFunction<'a, D>>,
    effort: Effort,
    waves: Arc<WaveGrid<D>>,
    /// `omega^2` at half of the grid, once they are needed; `-k` has the same, conjugated.
    spectra: OnceLock<Vec<Vec<Complex>>>,
    /// `omega^2` at `k = 0`, translations left out where they are free.
    at_rest: Vec<Complex>,
    /// Of long waves, with the rounding errors of that.
    stiffness: Stiffness<D>,
    long_wave_noise: [f64; 2],
}

/// What is known without a search: of the limit of long waves, and of `k = 0`.
struct LongWaves<const D: usize> {
    mode: Mode<D>,
    rest: Mode<D>,
    /// Scaled measures of smaller magnitude are zero to rounding; and those of the limit, where particles of a cell relax.
    tolerance: f64,
    of_limit: f64,
}

/// What does not flutter.
struct Softest<const D: usize> {
    softest: Mode<D>,
    lowest: Mode<D>,
    long_wave: Mode<D>,
    grows_at_rest: bool,
    tolerance: f64,
    bound: f64,
}

/// How much is looked at, at most.
#[derive(Clone, Copy)]
struct Effort {
    /// Wells of the grid that are followed to their bottoms.
    wells: usize,
    /// Boxes that are divided each time.
    boxes: usize,
    /// Of the smallest boxes those from which a bottom is sought.
    leaves: usize,
    /// Pockets of complex `omega^2` that are foreseen and looked at again.
    pockets: usize,
    /// Points between halved steps from which these are foreseen.
    finer: usize,
    /// Whether each spectrum is worth a core: only the lowest wave along a ray is followed, and a bottom is searched once.
    is_large: bool,
}

impl Effort {
    /// For small cells in the plane that is cheap; large cells have small zones, with little between the points of the grid.
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
            finer: if system.size() < HUGE {
                FINER
            } else {
                FINER / 8
            },
            is_large: system.size() >= LARGE,
        }
    }
}

/// A box of wave vectors.
struct Region<const D: usize> {
    center: SVector<f64, D>,
    /// The objective of the lowest branches in the middle.
    branches: Vec<f64>,
    /// The branch that may get lowest in it, how low by its slope, and how low it is expected to get.
    branch: usize,
    bound: f64,
    expected: f64,
}

/// How far a branch may fall in a box, and how far it is expected to.
#[derive(Clone, Copy)]
struct Fall {
    most: f64,
    expected: f64,
}

impl<const D: usize> Region<D> {
    /// From how much each branch may fall.
    fn new(center: SVector<f64, D>, branches: Vec<f64>, falls: impl Fn(usize) -> Fall) -> Self {
        let lowest = branches.iter().take(BRANCHES).enumerate();
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

    /// Between the middles of steps to both sides, from the changes within these: of a parabola through the three points where that
    /// is a valley, otherwise along a line.
    fn between(ahead: f64, behind: f64) -> Self {
        let steepest = ahead.abs().max(behind.abs());
        let (slope, curvature) = (0.5 * (ahead - behind).abs(), ahead + behind);
        let expected = if slope < HALF * curvature {
            0.5 * slope * slope / curvature
        } else {
            HALF * steepest
        };
        Self {
            most: HALF * steepest,
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
    fn new(
        search: &'a ZoneSearch<D>,
        system: &'a WaveSystem<D>,
        is_bounded: Option<IsEnded<'a>>,
    ) -> Self {
        let waves = search.grid_of(resolution(system));
        let (stiffness, long_wave_noise) = system.long_waves();
        Self {
            search,
            system,
            is_bounded: is_bounded.is_some(),
            is_ended: is_bounded.unwrap_or(&|| false),
            function: None,
            effort: Effort::of(system),
            spectra: OnceLock::new(),
            waves,
            at_rest: system.omega_squared_at_rest(),
            stiffness,
            long_wave_noise,
        }
    }

    fn summary(&self, sought: Flutter) -> SpectrumSummary<D> {
        let found = self.softest(&self.long_waves());
        let Softest {
            softest, lowest, ..
        } = found;
        let grows = found.grows_at_rest || softest.scaled < -found.tolerance;
        let sites = self.system.sites();
        let growing = grows.then_some(lowest);
        let rival = self.search.rival(sought, growing, sites);
        let growth = growing.map_or(0.0, |mode| growth_rate(mode.omega_squared));
        let fluttering = self.flutter(rival, growth);
        let fastest_growing = fluttering
            .filter(|mode| growth_rate(mode.omega_squared) > growth_rate(lowest.omega_squared))
            .unwrap_or(lowest);
        let at_rest = self.at_rest.iter().map(|value| value.re);
        let highest = at_rest.fold(0.0, f64::max);
        let highest = self
            .lowest(Objective::Highest, -highest, &softest)
            .map_or(highest, |(value, _)| highest.max(-value));
        SpectrumSummary {
            softest: if found.grows_at_rest {
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
            long_waves_flutter: sought.asks_about_long_waves(rival, fluttering.is_some())
                && self.stiffness.flutter().is_some(),
        }
    }

    /// As [`ZoneSearch::judgment_of`].
    fn judgment(&self, soft: f64, beside: &[SVector<f64, D>]) -> Judgment<D> {
        let diverges = |measure, witness| Judgment {
            stability: Stability::Divergence,
            measure,
            witness,
            softest: None,
        };
        let long = self.long_waves();
        if long.rest.omega_squared.re < 0.0 || long.mode.scaled < -long.of_limit {
            // The limit of long waves is that of the rest, unless this grows itself.
            return diverges(long.rest.scaled, None);
        }
        // One witness is enough: one that is known, or one of the grid.
        let known = beside.iter().map(|k| (*k, self.omega_squared(k)));
        let mut known = known.filter_map(|(k, spectrum)| self.witness(&long, k, &spectrum));
        let seen = || {
            let grid = half(&self.waves).into_iter().zip(self.spectra());
            let seen = grid.filter_map(|(k, spectrum)| self.witness(&long, k, spectrum));
            seen.min_by(|a, b| a.0.total_cmp(&b.0))
        };
        if let Some((measure, k)) = known.next().or_else(seen) {
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

    /// A wave vector with its scaled measure, where that is negative beyond rounding.
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
        let is_told = measure < -long.tolerance && lowest < -ROUNDING * self.system.noise();
        is_told.then_some((measure, k))
    }

    fn long_waves(&self) -> LongWaves<D> {
        let mut mode = self.search.long_wave_mode(&self.stiffness);
        let at_rest = self.at_rest.iter().map(|value| value.re);
        let least = at_rest.fold(f64::INFINITY, f64::min);
        let strains = self.system.rigid_translation().amax() > 0.0;
        if strains && least >= -ROUNDING * self.system.noise() {
            // A translation that costs energy leaves no long waves to become soft; what is free beside it is found at finite ones.
            mode.scaled = f64::INFINITY;
        }
        let [tolerance, mut of_limit] = self.long_wave_noise.each(|noise| self.search.told(noise));
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

    /// The longest wave along the direction of a limit below zero of which rounding can tell that it grows, and `Re omega^2` of the lowest
    /// branch at the wave that is so many octaves shorter.
    fn longest_told(&self, limit: &Mode<D>) -> (f64, impl Fn(f64) -> f64) {
        let stiffness = -limit.scaled * self.search.speed_squared();
        let longest = (TOLD * ROUNDING * self.system.noise() / stiffness).sqrt();
        let direction = limit.wave_vector.normalize();
        let lowest = move |octaves: f64| {
            let k = direction * (longest * octaves.exp2());
            let values = self.system.omega_squared(&k).into_iter();
            values.map(|value| value.re).fold(f64::INFINITY, f64::min)
        };
        (longest, lowest)
    }

    /// Whether waves grow where the limit of long ones does.
    fn is_followed(&self, limit: &Mode<D>) -> bool {
        let (_, lowest) = self.longest_told(limit);
        let noise = ROUNDING * self.system.noise();
        (0..FOLLOWED).any(|n| lowest(f64::from(2 * n)) < -noise)
    }

    /// The fastest growing wave along the direction of a limit below zero, among those longer than a step of the grid: particles of a cell
    /// that hardly resist each other relax in these only.
    fn growing_long_wave(&self, limit: &Mode<D>) -> Option<Mode<D>> {
        let (longest, lowest) = self.longest_told(limit);
        let step = self.search.reference().reciprocal().column(0).norm();
        let octaves = (step / self.waves.resolution() as f64 / longest).log2();
        let values = (0..=octaves as usize).map(|n| (lowest(n as f64), n as f64));
        let (value, best) = values.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let at = |octaves: f64| Ok::<f64, Infallible>(lowest(octaves));
        let Ok((octaves, _)) = lowest_between(at, [best - 1.0, best, best + 1.0], value, NARROWED);
        let k = limit.wave_vector.normalize() * (longest * octaves.exp2());
        let mode = self.mode(&k);
        (mode.omega_squared.re < -ROUNDING * self.system.noise()).then_some(mode)
    }

    fn softest(&self, long: &LongWaves<D>) -> Softest<D> {
        let (long_wave, rest) = (long.mode, long.rest);
        let grows_at_rest = rest.omega_squared.re < 0.0;
        // What grows at k = 0 has no scaled measure: the lowest wave tells all.
        let covered = (!grows_at_rest)
            .then(|| self.covered(Objective::Scaled, long_wave.scaled, None))
            .flatten();
        let softest = match &covered {
            Some(covered) => covered.wave_vector.map(|k| (covered.lowest, k)),
            None if grows_at_rest => None,
            None => self.bottom(Objective::Scaled, long_wave.scaled),
        };
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
        let lowest = (grows_at_rest || softest.scaled < -long.tolerance)
            .then(|| self.lowest(Objective::Lowest, rest.omega_squared.re, &softest))
            .flatten()
            .map(|(_, k)| self.mode(&k))
            .filter(|mode| mode.omega_squared.re < rest.omega_squared.re * (1.0 + ALIKE))
            .or_else(|| {
                let is_limit = softest.is_long_wave && softest.scaled < -long.of_limit;
                (is_limit && !grows_at_rest)
                    .then(|| self.growing_long_wave(&softest))
                    .flatten()
            })
            .unwrap_or(rest);
        // What is hardly negative, where no other wave grows, is zero to the rounding of the relaxation or of eigenvalues.
        let rounding = match softest.is_long_wave {
            true => long.of_limit,
            false => self.rounding_at(&softest),
        };
        let is_rounding = softest.scaled >= -rounding
            && lowest.omega_squared.re >= -ROUNDING * self.system.noise();
        Softest {
            softest,
            lowest: if is_rounding { rest } else { lowest },
            long_wave,
            grows_at_rest,
            tolerance: match is_rounding {
                true => long.tolerance.max(-softest.scaled),
                false => long.tolerance,
            },
            bound: covered.map_or(f64::NEG_INFINITY, |covered| covered.bound),
        }
    }

    /// The scaled measure of what rounding makes of a squared frequency whose vectors on both sides are nearly dependent: the product of their
    /// lengths times as much as of one of a Hermitian matrix, of which the measure of zero is told already.
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
        let condition = nearest.map_or(1.0, |n| all.left(n).norm() * all.right(n).norm());
        let noise = ROUNDING * self.system.noise() * condition;
        noise / (self.search.speed_squared() * self.search.reference().laplacian(&k))
    }

    /// Wave vectors in pockets of complex `omega^2`, where waves may grow faster than a rival.
    fn pockets(&self, rival: f64) -> Vec<SVector<f64, D>> {
        let pockets = Pockets {
            around: &|k, _| {
                let is_seen = !self.is_long(k) && !(self.is_ended)();
                is_seen.then(|| Around::Complex(self.system.expansion_at(k)))
            },
            is_large: self.effort.is_large,
            steps: self.search.reference().reciprocal() / self.waves.resolution() as f64,
            threshold: self.search.flutter_threshold(self.system.sites()),
            // What is foreseen of a pocket can be half of what is found from there.
            rival: 0.5 * rival,
            most: self.effort.pockets,
            finer: self.effort.finer,
        };
        pockets.around(half(&self.waves).into_iter())
    }

    /// The omega^2 at half of the grid.
    fn spectra(&self) -> &[Vec<Complex>] {
        self.spectra.get_or_init(|| {
            let spectrum = |k| self.omega_squared(&k);
            of_each_long(self.effort.is_large, half(&self.waves), spectrum)
        })
    }

    /// All `omega^2` of a wave vector, none where nobody waits for them.
    fn omega_squared(&self, k: &SVector<f64, D>) -> Vec<Complex> {
        match (self.is_ended)() {
            true => Vec::new(),
            false => self.system.omega_squared(k),
        }
    }

    /// The smallest value of an objective, where one is below a floor: with a bound where there is one, otherwise searched.
    fn lowest(&self, objective: Objective, floor: f64, softest: &Mode<D>) -> Option<Candidate<D>> {
        let start = match objective {
            Objective::Lowest => Some(self.lowest_near(softest)),
            _ => None,
        };
        let covered = self.covered(objective, floor, start);
        let sought = covered.as_ref().is_none_or(|covered| {
            // What is softer than a wave that grows can be less than the bound of frequencies tells from zero.
            objective == Objective::Lowest && covered.wave_vector.is_none()
        });
        if sought {
            let known = start.filter(|start| start.0 < floor);
            let floor = known.map_or(floor, |known| known.0);
            return self.bottom(objective, floor).or(known);
        }
        covered.and_then(|covered| covered.wave_vector.map(|k| (covered.lowest, k)))
    }

    /// The smallest `Re omega^2` downhill from the softest wave; where that is the limit of long waves, from waves along its direction.
    fn lowest_near(&self, softest: &Mode<D>) -> Candidate<D> {
        let k = softest.wave_vector;
        let reciprocal = self.search.reference().reciprocal().column(0).norm();
        let step = reciprocal / self.waves.resolution() as f64;
        let starts = match softest.is_long_wave {
            true => self.along_ray(Objective::Lowest, &(k * step)),
            false => vec![(self.value(Objective::Lowest, &k), k)],
        };
        let at_rest = self.at_rest.iter().map(|value| value.re);
        let rest = (at_rest.fold(f64::INFINITY, f64::min), SVector::zeros());
        let follow = |start| self.followed(Objective::Lowest, 0, start, f64::INFINITY, &[rest]);
        let ends = starts.into_iter().map(follow);
        let lowest = ends.min_by(|a, b| a.0.total_cmp(&b.0));
        lowest.unwrap_or((f64::INFINITY, k))
    }

    /// The smallest value of an objective, of which one below a floor may be known, and a bound of all its values; `None` where there is
    /// no bound.
    fn covered(
        &self,
        objective: Objective,
        floor: f64,
        start: Option<Candidate<D>>,
    ) -> Option<Covered<D>> {
        // The bound of a Hermitian part does not tell how far the values themselves go down.
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
        // A value that is attained, to begin with.
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
                BUDGET / FREQUENCY_SHARE,
            ),
        };
        let question = Question {
            known,
            gap: gap * scale + self.margin(objective),
            widest: WIDEST * scale,
            budget,
            value: &|k| self.value(objective, k),
            descended: &|start| self.followed(objective, 0, start, f64::INFINITY, &[]),
            is_ended: self.is_ended,
        };
        let mut covered = cover_system(self.system, measure, self.search.reference(), &question)?;
        let is_loose = covered.bound < covered.lowest - LOOSE * covered.lowest.abs();
        if is_loose || !is_hermitian {
            // Where the bound does not tell the value, the wells of the grid are looked at too.
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

    /// Whether a wave with a complex `omega^2` grows noticeably: where nobody asks how fast, one on the grid is enough.
    fn flutters(&self) -> bool {
        let threshold = self.search.flutter_threshold(self.system.sites());
        let is_seen = || -self.fastest_seen().0 > threshold;
        !self.system.is_hermitian() && (is_seen() || self.flutter(0.0, 0.0).is_some())
    }

    /// The fastest growth of complex `omega^2` among the points of the grid and `k = 0`.
    fn fastest_seen(&self) -> Candidate<D> {
        let fastest = |spectrum: &[Complex]| complex_growth(spectrum).fold(0.0, f64::min);
        let waves = half(&self.waves).into_iter().zip(self.spectra());
        let seen = waves.filter(|(k, _)| !self.is_long(k));
        let seen = seen.map(|(k, spectrum)| (fastest(spectrum), k));
        let at_rest = (fastest(&self.at_rest), SVector::zeros());
        seen.fold(at_rest, |best, own| if own.0 < best.0 { own } else { best })
    }

    /// The fastest growing mode with a complex `omega^2`, if one grows noticeably, and faster than a rival. Where one is seen on the grid, others
    /// are of interest only if they grow faster than it, and than what grows anyway.
    fn flutter(&self, rival: f64, growth: f64) -> Option<Mode<D>> {
        if self.system.is_hermitian() {
            return None;
        }
        let sites = self.system.sites();
        let threshold = self.search.flutter_threshold(sites);
        let seen = self.fastest_seen();
        let is_seen = -seen.0 > threshold.max(rival);
        // That of what is to be beaten, where the flutter that is seen is an answer.
        let least = |growth: f64| match is_seen {
            true => rival.max(self.search.as_rival(growth, sites)),
            false => rival,
        };
        let rival = least(growth);
        let mut ends = self.bottoms(Objective::Growth, -rival);
        let deepest = |ends: &[Candidate<D>]| ends.iter().map(|end| end.0).fold(-rival, f64::min);
        let step = 1.0 / self.waves.resolution() as f64;
        let opening = self.search.long_flutter(&self.stiffness, step);
        let fastest = least(-deepest(&ends).min(seen.0));
        for k in self.pockets(fastest).into_iter().chain(opening) {
            let value = self.value(Objective::Growth, &k);
            if value < 0.0 {
                let deepest = deepest(&ends);
                ends.push(self.followed(Objective::Growth, 0, (value, k), deepest, &ends));
            }
        }
        ends.push(seen);
        let best = ends.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        best.filter(|(value, _)| is_seen || -value > threshold.max(rival))
            .map(|(_, k)| self.fluttering(&k))
    }

    /// The objective of the branches, lowest first.
    fn branches(
        &self,
        objective: Objective,
        k: &SVector<f64, D>,
        spectrum: &[Complex],
    ) -> Vec<f64> {
        if self.is_long(k) {
            return vec![f64::INFINITY];
        }
        let mut values: Vec<f64> = match objective {
            Objective::Scaled => spectrum.iter().map(|z| self.scaled(k, z.re)).collect(),
            Objective::Lowest => spectrum.iter().map(|z| z.re).collect(),
            Objective::Highest => spectrum.iter().map(|z| -z.re).collect(),
            Objective::Growth => complex_growth(spectrum).collect(),
            Objective::Function => self
                .function
                .map(|function| function(k))
                .into_iter()
                .collect(),
        };
        values.sort_by(f64::total_cmp);
        if values.is_empty() {
            values.push(f64::INFINITY);
        }
        values
    }

    fn value(&self, objective: Objective, k: &SVector<f64, D>) -> f64 {
        self.branches_at(objective, k)[0]
    }

    /// The objective of the branches at a wave vector whose spectrum is not known yet.
    fn branches_at(&self, objective: Objective, k: &SVector<f64, D>) -> Vec<f64> {
        match objective {
            Objective::Function if (self.is_ended)() => vec![f64::INFINITY],
            Objective::Function => self.branches(objective, k, &[]),
            _ => self.branches(objective, k, &self.omega_squared(k)),
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
    fn bottom(&self, objective: Objective, floor: f64) -> Option<Candidate<D>> {
        let bottoms = self.bottoms(objective, floor).into_iter();
        bottoms.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Bottoms that lie, or seemed to, below a floor and those found before.
    fn bottoms(&self, objective: Objective, floor: f64) -> Vec<Candidate<D>> {
        let wave_vectors = half(&self.waves);
        let branches: Vec<Vec<f64>> = match objective {
            Objective::Function => {
                let waves = wave_vectors.iter();
                waves.map(|k| self.branches_at(objective, k)).collect()
            }
            _ => {
                let waves = wave_vectors.iter().zip(self.spectra());
                let branches = |(k, spectrum): (_, &Vec<_>)| self.branches(objective, k, spectrum);
                waves.map(branches).collect()
            }
        };
        let mut ends: Vec<Candidate<D>> = Vec::new();
        let margin = self.margin(objective);
        let to_beat =
            |ends: &[Candidate<D>]| ends.iter().map(|end| end.0).fold(floor, f64::min) - margin;
        for (value, relief, index) in self.wells(&branches) {
            if value - relief < to_beat(&ends) {
                let start = (value, wave_vectors[index]);
                ends.push(self.followed(objective, 0, start, to_beat(&ends), &ends));
            }
        }
        // Wells that open at k = 0 are narrow in angle: a ray along the softest long waves, on which points of the grid need not lie.
        if matches!(objective, Objective::Scaled | Objective::Lowest) {
            let along = self.search.long_wave_mode(&self.stiffness).wave_vector;
            let reciprocal = self.search.reference().reciprocal().column(0).norm();
            let step = reciprocal / self.waves.resolution() as f64;
            for start in self.along_ray(objective, &(along * step)) {
                ends.push(self.followed(objective, 0, start, to_beat(&ends), &ends));
            }
        }
        // At points of high symmetry slopes vanish, and the lowest point near need not be that of their well.
        for index in self.symmetric_points() {
            let k = wave_vectors[index];
            let beside = self.beside(&k).map(|k| (self.value(objective, &k), k));
            for start in std::iter::once((branches[index][0], k)).chain(beside) {
                if start.0 < to_beat(&ends) {
                    ends.push(self.followed(objective, 0, start, to_beat(&ends), &ends));
                }
            }
        }
        for region in self.regions(objective, branches, to_beat(&ends), &ends) {
            if region.bound < to_beat(&ends) && !self.is_known(&region, &ends, 0.25) {
                let start = (region.branches[region.branch], region.center);
                ends.push(self.followed(objective, region.branch, start, to_beat(&ends), &ends));
            }
        }
        ends
    }

    /// Least value of the function: the bottoms of the grid, of pockets of complex `omega^2`, and of long waves.
    fn least(&self) -> Candidate<D> {
        let objective = Objective::Function;
        let mut ends = self.bottoms(objective, f64::INFINITY);
        let deepest =
            |ends: &[Candidate<D>]| ends.iter().map(|end| end.0).fold(f64::INFINITY, f64::min);
        if !self.system.is_hermitian() {
            for k in self.pockets(0.0) {
                let start = (self.value(objective, &k), k);
                if start.0 < deepest(&ends) {
                    ends.push(self.followed(objective, 0, start, f64::INFINITY, &[]));
                }
            }
        }
        // Of long damped waves two factors of a step are equal to rounding, which says nothing of the step.
        if self.system.damping().is_some() {
            return least_of_all(ends);
        }
        // Shells around k = 0, an octave apart: what vanishes with k has its bottoms anywhere between k = 0 and the grid.
        let step = self.search.reference().reciprocal() / self.waves.resolution() as f64;
        let shells: Vec<(f64, Candidate<D>)> =
            std::iter::successors(Some(1.0), |size| Some(0.5 * size))
                .map(|size| {
                    let starts = shell::<D>().map(|place| {
                        let k = step * (place * size);
                        (self.value(objective, &k), k)
                    });
                    let least = starts.min_by(|a, b| a.0.total_cmp(&b.0));
                    (size, least.unwrap_or((f64::INFINITY, SVector::zeros())))
                })
                .take_while(|(_, least)| least.0.is_finite())
                .collect();
        let value = |n: usize| shells.get(n).map_or(f64::INFINITY, |shell| shell.1.0);
        for (n, (size, start)) in shells.iter().enumerate() {
            if start.0 <= value(n.wrapping_sub(1)) && start.0 <= value(n + 1) {
                ends.push(settled(
                    &|k| self.value(objective, k),
                    *start,
                    &(step * *size),
                ));
            }
        }
        least_of_all(ends)
    }

    /// Where to begin along a ray, of which one step is given; in large cells at the lowest place.
    fn along_ray(&self, objective: Objective, step: &SVector<f64, D>) -> Vec<Candidate<D>> {
        let start = |steps: f64| (self.value(objective, &(step * steps)), step * steps);
        let mut starts = RELAXED_RAY.each(start).to_vec();
        if self.effort.is_large {
            sort_by_value(&mut starts, |start| start.0);
            starts.truncate(1);
        }
        starts
    }

    /// The points of the grid at halves and thirds of reciprocal vectors, `k = 0` left out.
    fn symmetric_points(&self) -> impl Iterator<Item = usize> {
        let n = self.waves.resolution();
        let is_symmetric = move |c: &usize| [0, n / 3, n / 2, 2 * n / 3].contains(c);
        (1..self.waves.half())
            .filter(move |index| grid_coordinates::<D>(*index, n).iter().all(is_symmetric))
    }

    /// Wave vectors near a point of high symmetry: folded branches that nearly cross there bend within a part of a step. Beyond one
    /// dimension they would be as many as those of the grid.
    fn beside(&self, k: &SVector<f64, D>) -> impl Iterator<Item = SVector<f64, D>> {
        let step = self.search.reference().reciprocal().column(0) / self.waves.resolution() as f64;
        let near = RELAXED_RAY.each(|share| [k - step * share, k + step * share]);
        near.into_iter().flatten().filter(|_| D == 1)
    }

    /// Differences of an objective that mean nothing: modes that no force answers have many wells of rounding.
    fn margin(&self, objective: Objective) -> f64 {
        let noise = ROUNDING * self.system.noise();
        let scale = self.search.speed_squared() * self.search.largest_laplacian();
        match objective {
            Objective::Scaled => noise / scale,
            Objective::Lowest | Objective::Highest => noise,
            Objective::Growth => self.search.flutter_threshold(self.system.sites()),
            Objective::Function => 0.0,
        }
    }

    /// The distinct wells of the grid, deepest first: value, how far the highest point around is above it, and where it is.
    fn wells(&self, branches: &[Vec<f64>]) -> Vec<(f64, f64, usize)> {
        let n = self.waves.resolution();
        let values: Vec<f64> = branches.iter().map(|branches| branches[0]).collect();
        let relief = |index: usize| {
            let around = neighbors::<D>(index, n, values.len()).map(|other| values[other]);
            let around = around.filter(|value| value.is_finite());
            around.fold(values[index], f64::max) - values[index]
        };
        let mut wells: Vec<(f64, f64, usize)> = (0..values.len())
            .filter(|index| is_well::<D>(&values, *index, n))
            .map(|index| (values[index], relief(index), index))
            .collect();
        sort_by_value(&mut wells, |item| item.0);
        // Wells of the same depth are images of each other under the symmetry of the lattice.
        wells.dedup_by(|b, a| (b.0 - a.0).abs() <= 1e-10 * a.0.abs());
        wells.truncate(self.effort.wells);
        wells
    }

    /// Small boxes in which a branch may get below a value, by how it changes around them: found by division of those around the
    /// points of the grid, but for those of known bottoms.
    fn regions(
        &self,
        objective: Objective,
        branches: Vec<Vec<f64>>,
        below: f64,
        known: &[Candidate<D>],
    ) -> Vec<Region<D>> {
        let (n, count) = (self.waves.resolution(), branches.len());
        let fall = |around: &[usize], index: usize, branch: usize| {
            let change = |other: &usize| {
                let change = branches[*other].get(branch)? - branches[index][branch];
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
            // Opposite neighbors are as far from the ends of the list.
            let around: Vec<usize> = neighbors::<D>(index, n, count).collect();
            let own = branches[index].clone();
            Region::new(wave_vectors[index], own, |branch| {
                fall(&around, index, branch)
            })
        };
        let mut regions: Vec<Region<D>> = (1..count).map(around).collect();
        // What is around k = 0, no point tells.
        regions.push(Region {
            center: SVector::zeros(),
            branches: Vec::new(),
            branch: 0,
            bound: f64::NEG_INFINITY,
            expected: f64::NEG_INFINITY,
        });
        let mut step = self.search.reference().reciprocal() / n as f64;
        let mut side = 1.0;
        for _ in 0..DIVISIONS {
            regions.retain(|region| !self.is_known(region, known, side));
            chosen(&mut regions, below, self.effort.boxes);
            let divided = |region| self.divided(objective, &region, &step);
            let parts = of_each_long(self.effort.is_large, regions, divided);
            regions = parts.into_iter().flatten().collect();
            step *= 0.5;
            side *= 0.5;
        }
        regions.retain(|region| !self.is_known(region, known, side));
        chosen(&mut regions, below, self.effort.leaves);
        regions
    }

    /// Whether a box with sides of so many steps of the grid is that of a bottom that is known.
    fn is_known(&self, region: &Region<D>, known: &[Candidate<D>], side: f64) -> bool {
        let is_near = |end: &Candidate<D>| self.steps_between(&region.center, &end.1) <= side;
        region.branch == 0 && !region.branches.is_empty() && known.iter().any(is_near)
    }

    /// The parts of a box with given sides.
    fn divided(
        &self,
        objective: Objective,
        region: &Region<D>,
        sides: &SMatrix<f64, D, D>,
    ) -> Vec<Region<D>> {
        let parts: Vec<(SVector<f64, D>, Vec<f64>)> = (0..2_usize.pow(D as u32))
            .map(|part| {
                let corner = grid_coordinates::<D>(part, 2).each(|side| 0.5 * side as f64 - 0.25);
                let k = region.center + sides * SVector::from(corner);
                (k, self.branches_at(objective, &k))
            })
            .collect();
        // From the middle to those of the parts it is as far as from these to their corners.
        let fall = |branch: usize| {
            let values = || parts.iter().filter_map(|part| part.1.get(branch));
            let middle = match region.branches.get(branch) {
                Some(value) if value.is_finite() => *value,
                _ => values().copied().fold(f64::INFINITY, f64::min),
            };
            let changes = values().map(|value| (value - middle).abs());
            changes.filter(|x| x.is_finite()).fold(0.0, f64::max)
        };
        let falls: Vec<Fall> = (0..BRANCHES).map(fall).map(Fall::of).collect();
        let part = |(k, branches)| Region::new(k, branches, |branch| falls[branch]);
        parts.into_iter().map(part).collect()
    }

    /// How many steps of the grid two wave vectors are apart, equivalent ones being the same.
    fn steps_between(&self, a: &SVector<f64, D>, b: &SVector<f64, D>) -> f64 {
        let periods = self.search.reference().fractional(&(a - b));
        let apart = periods.map(|x| (x - x.round()).abs()).max();
        apart * self.waves.resolution() as f64
    }

    /// Follows a branch from a start to its bottom: by Newton's method, where that does not end in a smooth minimum with a
    /// look around. Left early where it is not going to get below a floor, and at a bottom that is known.
    fn followed(
        &self,
        objective: Objective,
        branch: usize,
        start: Candidate<D>,
        floor: f64,
        known: &[Candidate<D>],
    ) -> Candidate<D> {
        if (self.is_ended)() {
            return start;
        }
        let step = self.search.reference().reciprocal() / self.waves.resolution() as f64;
        if objective == Objective::Function {
            return settled(&|k| self.value(objective, k), start, &step);
        }
        let taylor = |k: &SVector<f64, D>| self.taylor(objective, branch, k);
        // At the edge of a pocket growth is a square root, of which no parabola tells how far it goes on.
        let (to_beat, floor) = match objective {
            Objective::Growth => (f64::INFINITY, PROMISING * floor),
            _ => (floor, floor),
        };
        let (bottom, is_settled) = self.search.newton(&taylor, start, to_beat);
        let end = (self.value(objective, &bottom.1), bottom.1);
        let margin = self.margin(objective);
        // In the zone of a small cell a step of the grid is long, and within one around a known bottom there may be a lower one.
        let is_known = |known: &Candidate<D>| {
            self.effort.is_large
                && known.0 <= end.0 + margin
                && self.steps_between(&known.1, &end.1) < AT_BOTTOM
        };
        if (is_settled && branch == 0) || end.0 >= floor || known.iter().any(is_known) {
            return end;
        }
        settled(&|k| self.value(objective, k), end, &step)
    }

    /// A branch of an objective with its derivatives; `None` for long waves.
    fn taylor(
        &self,
        objective: Objective,
        branch: usize,
        k: &SVector<f64, D>,
    ) -> Option<Taylor<f64, D>> {
        if self.is_long(k) || (self.is_ended)() {
            return None;
        }
        let expansion = self.system.expansion_at(k);
        let all = self.system.decomposed(&expansion)?;
        let mut numbers: Vec<usize> = (0..all.values.len()).collect();
        let of = |n: &usize| match objective {
            Objective::Highest => -all.values[*n].re,
            Objective::Growth => -growth_rate(all.values[*n]),
            _ => all.values[*n].re,
        };
        sort_by_value(&mut numbers, of);
        let value = expansion.branch(&all, *numbers.get(branch)?);
        Some(match objective {
            Objective::Scaled => self.search.scaled(&value.map(|z| z.re), k),
            Objective::Highest => value.map(|z| -z.re),
            Objective::Growth => value.growth().map(|x| -x),
            Objective::Lowest => value.map(|z| z.re),
            Objective::Function => return None,
        })
    }

    /// The mode with the lowest `Re omega^2` at a wave vector.
    fn mode(&self, k: &SVector<f64, D>) -> Mode<D> {
        let k = self.search.folded(k);
        self.shown(&k, |values| (!values.is_empty()).then_some(0))
    }

    /// The mode with complex `omega^2` that grows fastest at a wave vector.
    fn fluttering(&self, k: &SVector<f64, D>) -> Mode<D> {
        let k = self.search.folded(k);
        self.shown(&k, |values| {
            let complex = (0..values.len()).filter(|n| values[*n].im != 0.0);
            complex.max_by(|a, b| growth_rate(values[*a]).total_cmp(&growth_rate(values[*b])))
        })
    }

    /// The mode that is chosen from the values of `omega^2` at a wave vector.
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

    /// The mode with the lowest `Re omega^2` at `k = 0`: the translation, with the scaled measure of its neighborhood, unless
    /// another one, or the translation itself, grows.
    fn rest(&self, scaled: f64) -> Mode<D> {
        let lowest = self.at_rest.iter().map(|value| value.re);
        let lowest = lowest.fold(f64::INFINITY, f64::min);
        let threshold = self.search.flutter_threshold(self.system.sites()).powi(2);
        if lowest < -threshold.max(ROUNDING * self.system.noise()) {
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

/// The boxes that may hold something lower, as many as there may be.
fn chosen<const D: usize>(regions: &mut Vec<Region<D>>, below: f64, most: usize) {
    regions.retain(|region| region.bound < below);
    sort_by_value(regions, |region| region.expected);
    regions.truncate(most);
}

/// Minus the growth rates of complex `omega^2`, zero for real ones.
fn complex_growth(spectrum: &[Complex]) -> impl Iterator<Item = f64> {
    spectrum
        .iter()
        .map(|z| if z.im == 0.0 { 0.0 } else { -growth_rate(*z) })
}

/// Points along each reciprocal vector: enough for the range of the forces, fewer for large cells, whose zones are small. Multiples of six
/// have the points of high symmetry among them.
fn resolution<const D: usize>(system: &WaveSystem<D>) -> usize {
    let drift = system.drift().map_or(0, |drift| drift.reach());
    let reach = system.stiffness().reach() + drift;
    let (least, most) = match (D, system.size()) {
        (1, _) => (48, 192),
        (2, 0..16) => (30, 60),
        (3, 0..8) => (18, 18),
        (2, 16..64) => (18, 24),
        (3, 16..) | (_, HUGE..) => (6, 6),
        _ => (12, 12),
    };
    let points = POINTS_PER_PERIOD * reach;
    points.clamp(least, most).next_multiple_of(6)
}

/// The candidate with the least value; infinite where there is none.
fn least_of_all<const D: usize>(ends: Vec<Candidate<D>>) -> Candidate<D> {
    let best = ends.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
    best.unwrap_or((f64::INFINITY, SVector::zeros()))
}

/// Half of the points on the surface of a cube around zero, in steps of a grid; of opposite points one.
fn shell<const D: usize>() -> impl Iterator<Item = SVector<f64, D>> {
    let side = 2 * SHELL + 1;
    let places = (0..side.pow(D as u32) / 2).map(move |n| grid_coordinates::<D>(n, side));
    let centered = places.map(|place| SVector::from(place.each(|c| c as f64 - SHELL as f64)));
    centered.filter(|place| place.amax() == SHELL as f64)
}

/// Half of the wave vectors of a grid; `-k` has the same spectrum, conjugated.
fn half<const D: usize>(waves: &WaveGrid<D>) -> Vec<SVector<f64, D>> {
    waves.wave_vectors().take(waves.half()).collect()
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
