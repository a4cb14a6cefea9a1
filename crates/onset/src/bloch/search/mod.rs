//! Extremes of the spectrum of one particle in a cell over the whole first Brillouin zone.
//!
//! The search has three steps:
//!
//! 1. `D(k)` is evaluated on a grid over half of the zone, fine enough for the range of the force constants. In two dimensions with a mirror line,
//!    the sums run along the mirror lines and several wave vectors are evaluated at a time (`mirrored`, `steps`).
//! 2. The distinct wells of the grid are followed to their bottoms by Newton's method with exact gradients and Hessians (`descent`).
//! 3. Pockets of complex `omega^2` between the grid points are predicted from derivatives (`bloch::pocket`).
//!
//! Long waves are not sampled but represented by the limit `k -> 0`. The extremes are sampled values. Only the `bounded` variants add a guaranteed
//! lower bound of the scaled measure, for periodic matrices, by branch and bound (`bloch::bound`). Constants without a stated derivation are
//! heuristic; the tests `hunt` compare random states with a dense search.

mod descent;
mod grid;
mod mirrored;
mod steps;
mod well;

pub(in crate::bloch) use well::{is_near_crossing, neighbors};
pub(crate) use well::{is_well, settled, settled_along};

use super::bound::{self, Measure, Question};
use super::pocket::{Around, HALVED_STEP_POINTS, Order, Pockets};
use super::short_range::ShortRange;
use super::spectrum::{Judgment, Mode, SpectrumSummary, Stability};
use super::{DynamicalMatrix, growth_rate, is_shown_reversed};
use crate::algebra::{Complex, Deviator, Each, array_of, eigenvalues, eigenvector};
use crate::continuum::{AcousticMinimum, Stiffness};
use crate::kinematics::DeformationGradient;
use crate::lattice::{
    BravaisLattice, BrillouinZone, Equivalence, WaveGrid, WaveGrids, grid_coordinates, inverse_of,
};
use crate::method::Method;
use grid::{Grid, complex_growth};
use mirrored::{Mirrored, Request};
use nalgebra::{SMatrix, SVector};
use std::sync::{Arc, OnceLock};

/// Tolerance for zero of scaled measures, as a multiple of the rounding error of the long-wave stiffness.
const ROUNDING_FACTOR: f64 = 4.0;
/// Largest scaled measure of a nearly unstable state. Wells whose bottoms may be lower are followed, so that the measure is accurate along a path
/// that approaches instability.
const SOFT_MEASURE: f64 = 1e-3;
/// Growth rate of the slowest flutter that counts, as a fraction of sound speed over particle spacing. Slower growth is rounding of complex
/// eigenvalues.
const FLUTTER_TOLERANCE: f64 = 1e-7;
/// Largest growth rate of slow divergence, as a fraction of sound speed over particle spacing. In states that diverge slowly, the search covers all
/// flutter; otherwise only faster flutter matters.
const SLOW_DIVERGENCE: f64 = 0.05;
/// Smallest tolerance of scaled measures: a few times `f64::EPSILON`, the rounding error of `c^2` itself.
const MINIMUM_TOLERANCE: f64 = 1e-15;
/// Largest squared wave speed over `c^2` that counts as zero to rounding, if sums of force constants give no better estimate.
const ZERO_SPEED_SQUARED: f64 = 1e-13;
/// Largest wave number of a long wave, as a fraction of a reciprocal vector. The limit `k -> 0` represents such waves.
pub(in crate::bloch) const LONG_WAVE_FRACTION: f64 = 1e-3;
/// Maximum number of predicted pockets of complex `omega^2` that are refined.
const REFINED_POCKETS: usize = 1 << 14;
/// Number of refined pockets that start a maximization of growth, fastest first.
const FOLLOWED_POCKETS: usize = 16;
/// Distances from `k = 0` of starts along the softest or fastest growing long waves, in grid steps. The grid can miss wells that open there, because
/// they are narrow in angle.
const RAY_STEPS: [f64; 4] = [0.15, 0.35, 0.7, 1.2];
/// Distances of [`RAY_STEPS`] preceded by a shorter distance, for soft waves that require the relaxation of the particles of a cell and disappear at
/// shorter wavelengths.
pub(in crate::bloch) const RELAXED_RAY_STEPS: [f64; 5] =
    [0.05, RAY_STEPS[0], RAY_STEPS[1], RAY_STEPS[2], RAY_STEPS[3]];
/// Grid points per period of the fastest phase, to find a witness of instability.
const COARSE_POINTS_PER_PERIOD: usize = 6;
/// Grid points per period of the fastest phase, to find all wells.
const FINE_POINTS_PER_PERIOD: usize = 9;

/// Search over the Brillouin zone of one lattice, with the speed `c` of the scaled measure `omega^2 / (c^2 |k|_h^2)`.
#[derive(Clone, Debug)]
pub struct ZoneSearch<const D: usize> {
    /// Lattice whose zone is searched, and this zone once it is needed.
    lattice: BravaisLattice<D>,
    zone: OnceLock<BrillouinZone<D>>,
    /// Map from wave vectors of the searched zone to reference wave vectors, `home^T`.
    to_reference: SMatrix<f64, D, D>,
    /// Inverse of the matrix `to_reference`.
    from_reference: SMatrix<f64, D, D>,
    /// True if the searched lattice is the reference lattice.
    home_is_reference: bool,
    /// Grids of wave vectors of the reference lattice.
    grids: Arc<WaveGrids<D>>,
    is_periodic: bool,
    speed_squared: f64,
}

/// Objective of a search over the zone; always minimized.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::bloch) enum Objective {
    /// `Re omega^2 / (c^2 |k|_h^2)` of the lowest branch.
    Scaled,
    /// `Re omega^2` of the lowest branch.
    Lowest,
    /// `-Re omega^2` of the highest branch.
    Highest,
    /// A function that is negative where `omega^2` is complex.
    ///
    /// If `D` is real, this is the discriminant: `((D11 - D22)/2)^2 + D12 D21` in the plane, and `a^3 - h^2`, of degree six, in three dimensions.
    /// Unlike the imaginary part it is smooth. If `D` is complex, `omega^2` is complex almost everywhere, and the objective is the negative growth
    /// rate.
    Discriminant,
    /// Negative growth rate of a mode with complex `omega^2`.
    Growth,
}

/// Value of the objective, and its wave vector.
pub(in crate::bloch) type Candidate<const D: usize> = (f64, SVector<f64, D>);

/// A wave vector with the matrix and its eigenvalues by increasing real part, which determine all objectives.
struct Sample<const D: usize> {
    wave_vector: SVector<f64, D>,
    matrix: SMatrix<Complex, D, D>,
    omega_squared: [Complex; D],
}

impl<const D: usize> Sample<D> {
    fn of(matrix: &DynamicalMatrix<D>, k: SVector<f64, D>) -> Self {
        Self::with(matrix, k, matrix.at(&k))
    }

    fn with(
        matrix: &DynamicalMatrix<D>,
        wave_vector: SVector<f64, D>,
        there: SMatrix<Complex, D, D>,
    ) -> Self {
        Self {
            wave_vector,
            omega_squared: eigenvalues(&there, matrix.noise()),
            matrix: there,
        }
    }
}

/// Discriminant of a real matrix in two or three dimensions, negative where two `omega^2` are complex; `None` if the matrix is complex.
fn discriminant<const D: usize>(
    matrix: &DynamicalMatrix<D>,
    d: &SMatrix<Complex, D, D>,
) -> Option<f64> {
    if !matrix.is_centrosymmetric() {
        return None;
    }
    match D {
        2 => {
            let half = (d[(0, 0)] - d[(1, 1)]) * 0.5;
            Some((half * half + d[(0, 1)] * d[(1, 0)]).re)
        }
        3 => {
            let entries = array_of(|e| d[(e / 3, e % 3)].re);
            Some(Deviator::of(&entries).discriminant())
        }
        _ => None,
    }
}

impl<const D: usize> ZoneSearch<D> {
    /// Creates the search for a method at a state, with the `c^2` of the scaled measure.
    ///
    /// Returns `None` if the lattice degenerates in floating point.
    pub fn new(method: &Method<D>, f: &DeformationGradient, speed_squared: f64) -> Option<Self> {
        let home = method.home_map(f);
        let to_reference = home.transpose();
        Some(Self {
            lattice: method.lattice().mapped(&home)?,
            zone: OnceLock::new(),
            from_reference: inverse_of(&to_reference)?,
            to_reference,
            home_is_reference: home == SMatrix::<f64, D, D>::identity(),
            grids: Arc::clone(method.wave_grids()),
            is_periodic: method.is_periodic(),
            speed_squared,
        })
    }

    /// Creates the search over the zone of the lattice itself, for systems of cells.
    pub fn of_lattice(lattice: BravaisLattice<D>, speed_squared: f64) -> Self {
        Self {
            lattice,
            zone: OnceLock::new(),
            to_reference: SMatrix::identity(),
            from_reference: SMatrix::identity(),
            home_is_reference: true,
            grids: Arc::new(WaveGrids::new(lattice)),
            is_periodic: true,
            speed_squared,
        }
    }

    /// Grid of wave vectors over a cell of the reciprocal lattice.
    pub(in crate::bloch) fn grid_of(&self, resolution: usize) -> Arc<WaveGrid<D>> {
        self.grids.grid(resolution)
    }

    /// Returns true if waves are periodic in the reciprocal vectors.
    pub(in crate::bloch) fn is_periodic(&self) -> bool {
        self.is_periodic
    }

    /// Squared speed `c^2` of the scaled measure.
    pub(in crate::bloch) fn speed_squared(&self) -> f64 {
        self.speed_squared
    }

    /// `G^-1/2` of the metric `G` of long waves, `|k|_h^2 -> k.G k`.
    pub(in crate::bloch) fn long_wave_map(&self) -> &SMatrix<f64, D, D> {
        self.grids.long_wave_map()
    }

    pub(in crate::bloch) fn reference(&self) -> &BravaisLattice<D> {
        self.grids.lattice()
    }

    /// Wave vectors that symmetries of the reference lattice make equivalent.
    pub(in crate::bloch) fn equivalence(&self) -> &Equivalence<D> {
        self.grids.equivalence()
    }

    fn zone(&self) -> &BrillouinZone<D> {
        self.zone.get_or_init(|| BrillouinZone::new(self.lattice))
    }

    /// Returns the search for a matrix that is divided by `unit`.
    pub(in crate::bloch) fn in_units(&self, unit: f64) -> Self {
        Self {
            speed_squared: self.speed_squared / unit,
            ..self.clone()
        }
    }

    /// Returns the search in coordinates in which the forces have the same range in all directions.
    pub(in crate::bloch) fn in_short_range(&self, range: &ShortRange<D>) -> Option<Self> {
        let lattice = range.lattice(self.reference())?;
        Some(Self::of_lattice(lattice, self.speed_squared))
    }

    /// Search and matrix in isotropic coordinates, if the reference lattice is too oblique for kernels in current coordinates.
    fn short_ranged(
        &self,
        matrix: &DynamicalMatrix<D>,
    ) -> Option<(ShortRange<D>, Self, DynamicalMatrix<D>)> {
        if self.home_is_reference || !self.is_periodic {
            return None;
        }
        let range = matrix.short_range(self.reference())?;
        let search = self.in_short_range(&range)?;
        let matrix = matrix.in_short_range(&range, search.reference());
        Some((range, search, matrix))
    }

    /// Computes the extremes of the spectrum by samples and descents, without a bound.
    pub fn summary(&self, matrix: &DynamicalMatrix<D>) -> SpectrumSummary<D> {
        self.found(matrix, Flutter::All, false)
    }

    /// Like `summary`, except that flutter which grows more slowly than the divergence of a state may be omitted.
    ///
    /// Slow flutter of long waves is then also omitted, unless `includes_long_waves` requests it.
    pub(crate) fn extremes(
        &self,
        matrix: &DynamicalMatrix<D>,
        includes_long_waves: bool,
    ) -> SpectrumSummary<D> {
        let sought = Flutter::Fastest {
            includes_long_waves,
        };
        self.found(matrix, sought, false)
    }

    /// Like `summary`, with a lower bound of the scaled measure if the matrix is periodic. For matrices that are not Hermitian it bounds the
    /// Hermitian part.
    pub fn bounded_summary(&self, matrix: &DynamicalMatrix<D>) -> SpectrumSummary<D> {
        self.found(matrix, Flutter::All, true)
    }

    /// Growth rate that flutter must exceed to be relevant; zero if all flutter is requested.
    pub(in crate::bloch) fn rival(
        &self,
        sought: Flutter,
        growing: Option<Mode<D>>,
        sites: usize,
    ) -> f64 {
        let growth = growing.map_or(0.0, |mode| growth_rate(mode.omega_squared));
        match sought {
            Flutter::Fastest { .. } => self.as_rival(growth, sites),
            Flutter::All => 0.0,
        }
    }

    /// Growth rate of divergence as the rate that flutter must exceed; zero if the divergence is slow.
    pub(in crate::bloch) fn as_rival(&self, growth: f64, sites: usize) -> f64 {
        match growth > SLOW_DIVERGENCE * self.speed_over_spacing(sites) {
            true => growth,
            false => 0.0,
        }
    }

    /// Computes the extremes; `is_bounded` requests a lower bound.
    pub(in crate::bloch) fn found(
        &self,
        matrix: &DynamicalMatrix<D>,
        sought: Flutter,
        is_bounded: bool,
    ) -> SpectrumSummary<D> {
        let unit = matrix.moderate_unit();
        if unit != 1.0 {
            let search = self.in_units(unit);
            let found = search.found(&matrix.over(unit), sought, is_bounded);
            return found.in_units(unit);
        }
        if let Some((range, search, matrix)) = self.short_ranged(matrix) {
            let found = search.found(&matrix, sought, is_bounded);
            return range.carried_back(&found, |k| self.folded(k));
        }
        let long_wave = self.long_wave_limit(matrix);
        let rest = self.rest(matrix, long_wave.scaled);
        let tolerance = self.tolerance(matrix);
        let followed = [Objective::Scaled, Objective::Lowest, Objective::Highest];
        let mut wells = self.wells(matrix, FINE_POINTS_PER_PERIOD, &followed, &long_wave, &rest);
        let bottom = wells.bottom(self, matrix, Objective::Scaled, long_wave.scaled);
        let softest = self.softest(matrix, bottom, long_wave);
        let (softest, bound) = match is_bounded && self.is_periodic {
            true => self.bounded(matrix, softest),
            false => (softest, f64::NEG_INFINITY),
        };
        // A translation that strains the body can have a negative `omega^2` itself.
        let grows = softest.scaled < -tolerance || rest.omega_squared.re < 0.0;
        let lowest = grows
            .then(|| wells.bottom(self, matrix, Objective::Lowest, rest.omega_squared.re))
            .flatten()
            .map(|bottom| self.mode(matrix, &bottom.1))
            .filter(|mode| {
                mode.omega_squared.re < rest.omega_squared.re && mode.scaled < -tolerance
            })
            .unwrap_or(rest);
        let rival = self.rival(sought, grows.then_some(lowest), 1);
        let fluttering = self.flutter(matrix, &mut wells, rival);
        let fastest_growing = fluttering.map_or(lowest, |mode| {
            self.fastest(matrix, &wells, lowest, mode, rival)
        });
        let may_flutter = sought.includes_long_waves(rival, fluttering.is_some());
        let highest = wells
            .bottom(self, matrix, Objective::Highest, f64::INFINITY)
            .map_or(0.0, |bottom| -bottom.0);
        SpectrumSummary {
            softest: if rest.omega_squared.re < 0.0 {
                self.over_largest_laplacian(lowest)
            } else {
                softest
            },
            long_wave,
            lowest,
            fastest_growing,
            maximum_omega: highest.max(0.0).sqrt(),
            tolerance,
            bound,
            flutters: fluttering.is_some(),
            long_waves_flutter: may_flutter && self.long_waves_flutter(matrix, &wells),
        }
    }

    /// Softest mode of the zone and a lower bound of the scaled measure by branch and bound, starting from a known soft mode.
    fn bounded(&self, matrix: &DynamicalMatrix<D>, known: Mode<D>) -> (Mode<D>, f64) {
        let scale = known.scaled.abs().max(1.0);
        let question = Question {
            known: known.scaled,
            gap: bound::GAP * scale + self.tolerance(matrix),
            widest: bound::WIDEST_GAP * scale,
            budget: bound::BUDGET,
            value: &|k| self.value_at(matrix, Objective::Scaled, k),
            descended: &|(value, k)| {
                let end = self.settled(matrix, Objective::Scaled, k, f64::INFINITY);
                let lower = self.value_at(matrix, Objective::Scaled, &end);
                if lower < value {
                    (lower, end)
                } else {
                    (value, k)
                }
            },
        };
        let measure = Measure::Scaled(self.speed_squared);
        let Some(covered) = bound::cover_matrix(matrix, measure, self.reference(), &question)
        else {
            return (known, f64::NEG_INFINITY);
        };
        let softest = match covered.wave_vector {
            Some(direction) if covered.is_long_wave => Mode {
                wave_vector: direction,
                scaled: covered.lowest,
                is_long_wave: true,
                ..known
            },
            Some(k) => self.mode(matrix, &k),
            None => known,
        };
        (softest, covered.bound)
    }

    /// Returns the stability (whether a wave grows, and by divergence or flutter) and the scaled measure.
    ///
    /// The result agrees with the summary, but is cheaper. The sign of the measure decides stability if the spectrum is real.
    pub fn stability(&self, matrix: &DynamicalMatrix<D>) -> (Stability, f64) {
        let judgment = self.judgment(matrix, f64::NEG_INFINITY, None);
        (judgment.stability, judgment.measure)
    }

    /// Like `stability`, with the softest mode of a stable state if its scaled measure is at most `soft`.
    ///
    /// The argument `beside` contains all growing wave vectors of neighboring states. They are tried first, and the coarse grid is then skipped,
    /// because it would decide few of the remaining states.
    pub(crate) fn judgment(
        &self,
        matrix: &DynamicalMatrix<D>,
        soft: f64,
        beside: Option<&[SVector<f64, D>]>,
    ) -> Judgment<D> {
        let unit = matrix.moderate_unit();
        if unit != 1.0 {
            let judgment = self
                .in_units(unit)
                .judgment(&matrix.over(unit), soft, beside);
            return Judgment {
                softest: judgment.softest.map(|mode| mode.in_units(unit)),
                ..judgment
            };
        }
        if let Some((range, search, matrix)) = self.short_ranged(matrix) {
            let judgment = search.judgment(&matrix, soft, None);
            let back = |mode: Mode<D>| range.mode_carried_back(&mode, |k| self.folded(k));
            return Judgment {
                softest: judgment.softest.map(back),
                witness: None,
                ..judgment
            };
        }
        let tolerance = self.tolerance(matrix);
        let diverges = |(measure, witness)| Judgment {
            stability: Stability::Divergence,
            measure,
            witness,
            softest: None,
        };
        // One witness is enough. Most unstable states have one among the long waves, the witnesses of neighboring states, the points of high symmetry
        // or a coarse grid; these are tried in the order of their cost.
        let long_wave = self.long_wave_limit(matrix);
        let rest = self.rest(matrix, long_wave.scaled);
        let mut least = (long_wave.scaled, None);
        if rest.omega_squared.re < 0.0 || least.0 < -tolerance {
            return diverges(least);
        }
        let known = beside.unwrap_or_default().iter();
        let known = known.map(|k| match self.is_periodic {
            true => *k,
            // The witnesses belong to the zone of another state.
            false => k * self.reach(k).min(1.0),
        });
        let sample = |k| (self.value_at(matrix, Objective::Scaled, &k), k);
        if let Some(witness) = known.map(sample).find(|(value, _)| *value < -tolerance) {
            return diverges((witness.0, Some(witness.1)));
        }
        least = self.symmetric_waves().map(sample).fold(least, lower);
        if least.0 < -tolerance {
            return diverges(least);
        }
        // The wells of a Hermitian matrix are followed from the coarse grid too.
        let is_coarse = matrix.is_hermitian() || beside.is_none();
        let points_per_period = if is_coarse {
            COARSE_POINTS_PER_PERIOD
        } else {
            FINE_POINTS_PER_PERIOD
        };
        let followed = [Objective::Scaled];
        let mut wells = self.wells(matrix, points_per_period, &followed, &long_wave, &rest);
        if let Wells::Grid(grid) = &wells {
            least = lower(least, grid.minimum(Objective::Scaled));
            if least.0 < -tolerance {
                return diverges(least);
            }
            // Branches of a matrix that is not Hermitian can be complex in small pockets.
            if is_coarse && !matrix.is_hermitian() {
                wells = Wells::Grid(Box::new(self.grid(
                    matrix,
                    FINE_POINTS_PER_PERIOD,
                    long_wave.wave_vector,
                )));
            }
        }
        let lowest = |wells: &Wells<D>, floor| wells.bottom(self, matrix, Objective::Scaled, floor);
        let is_soft = least.0 <= soft;
        let floor = if is_soft {
            long_wave.scaled
        } else {
            SOFT_MEASURE
        };
        let mut bottom = lowest(&wells, floor);
        if let Some(bottom) = bottom {
            least = lower(least, bottom);
        }
        let measure = least.0;
        if measure < -tolerance {
            return diverges(least);
        }
        if self.grid_flutters(matrix, &wells) || self.flutter(matrix, &mut wells, 0.0).is_some() {
            return Judgment {
                stability: Stability::Flutter,
                measure,
                witness: None,
                softest: None,
            };
        }
        if measure <= soft && !is_soft {
            bottom = lowest(&wells, long_wave.scaled);
        }
        Judgment {
            stability: Stability::Stable,
            measure,
            witness: None,
            softest: (measure <= soft).then(|| self.softest(matrix, bottom, long_wave)),
        }
    }

    /// Softest mode: the deepest bottom in the zone or the long-wave limit.
    fn softest(
        &self,
        matrix: &DynamicalMatrix<D>,
        bottom: Option<Candidate<D>>,
        long_wave: Mode<D>,
    ) -> Mode<D> {
        bottom
            .filter(|bottom| bottom.0 < long_wave.scaled)
            .map_or(long_wave, |bottom| self.mode(matrix, &bottom.1))
    }

    /// Mode with the lowest `Re omega^2` at a reference wave vector.
    pub fn mode(&self, matrix: &DynamicalMatrix<D>, k: &SVector<f64, D>) -> Mode<D> {
        let (k, d, omega_squared) = self.spectrum_at(matrix, k);
        self.mode_of(k, &d, &omega_squared, omega_squared[0])
    }

    /// Reported wave vector among those equivalent to `k`, with `D` and its eigenvalues there.
    fn spectrum_at(
        &self,
        matrix: &DynamicalMatrix<D>,
        k: &SVector<f64, D>,
    ) -> (SVector<f64, D>, SMatrix<Complex, D, D>, [Complex; D]) {
        // The zone contains one of the equivalent wave vectors; of `k` and `-k`, the vector with a positive leading component is reported.
        let mut folded = if self.is_periodic { self.folded(k) } else { *k };
        if is_shown_reversed(&folded) {
            folded = -folded;
        }
        let d = matrix.at(&folded);
        (folded, d, eigenvalues(&d, matrix.noise()))
    }

    /// Mode of one of the eigenvalues.
    fn mode_of(
        &self,
        wave_vector: SVector<f64, D>,
        d: &SMatrix<Complex, D, D>,
        all: &[Complex; D],
        omega_squared: Complex,
    ) -> Mode<D> {
        let laplacian = self.reference().laplacian(&wave_vector);
        Mode {
            wave_vector,
            is_long_wave: false,
            omega_squared,
            scaled: all[0].re / (self.speed_squared * laplacian),
            polarization: eigenvector(d, omega_squared),
        }
    }

    /// Limit `k -> 0` of the scaled measure, minimized over all directions.
    ///
    /// The limit is infinite if a translation raises the energy, because then no long wave becomes soft.
    pub fn long_wave_limit(&self, matrix: &DynamicalMatrix<D>) -> Mode<D> {
        let limit = self.long_wave_mode(&matrix.long_wave_stiffness());
        if self.rest(matrix, 0.0).omega_squared.re > matrix.noise() {
            return Mode {
                scaled: f64::INFINITY,
                ..limit
            };
        }
        limit
    }

    /// Softest long wave of a stiffness per density.
    pub(in crate::bloch) fn long_wave_mode(&self, stiffness: &Stiffness<D>) -> Mode<D> {
        // With `k = G^-1/2 m` the scale `|k|_h^2 -> k.G k` becomes `|m|^2`.
        let map = self.grids.long_wave_map();
        let mapped = stiffness.with_directions_mapped(map).smallest();
        let mode = |minimum: &AcousticMinimum<D>, direction: SVector<f64, D>, scaled: f64| Mode {
            wave_vector: direction.normalize(),
            is_long_wave: true,
            omega_squared: Complex::new(0.0, 0.0),
            scaled,
            polarization: minimum
                .polarization
                .map(|component| Complex::new(component, 0.0)),
        };
        let softest = mapped.eigenvalue.re / self.speed_squared;
        if self.reference().is_measured_by_own_vectors() {
            return mode(&mapped, map * mapped.direction, softest);
        }
        // A metric of other coordinates can be so anisotropic that rounding decides the sign of the quotient. The sign is then taken from the
        // numerator.
        let plain = stiffness.smallest();
        let metric = self.reference().long_wave_metric();
        let value = plain.eigenvalue.re / self.speed_squared;
        let witness = value / plain.direction.dot(&(metric * plain.direction));
        if value >= -ZERO_SPEED_SQUARED {
            let least = value.max(0.0) / metric.trace();
            return mode(&mapped, map * mapped.direction, softest.max(least));
        }
        if witness < softest {
            mode(&plain, plain.direction, witness)
        } else {
            mode(&mapped, map * mapped.direction, softest)
        }
    }

    /// Returns true if modes grow in the long-wave limit, as in [`SpectrumSummary::long_waves_grow`].
    pub(crate) fn long_waves_grow(
        &self,
        matrix: &DynamicalMatrix<D>,
        material: &AcousticMinimum<D>,
    ) -> bool {
        match self.short_ranged(matrix) {
            Some((_, search, matrix)) => search.long_waves_grow(&matrix, material),
            None => {
                self.long_wave_limit(matrix).scaled < -self.tolerance(matrix)
                    || (material.only_flutters()
                        && matrix.long_wave_stiffness().flutter().is_some())
            }
        }
    }

    /// Tolerance of scaled measures; smaller magnitudes are zero to rounding.
    pub fn tolerance(&self, matrix: &DynamicalMatrix<D>) -> f64 {
        self.measure_of_noise(ROUNDING_FACTOR * matrix.long_wave_noise())
    }

    /// Scaled measure of a rounding error of a squared wave speed. It is at least the rounding error of `c^2`, because the force constants of weakly
    /// coupled particles are sums of that magnitude.
    pub(in crate::bloch) fn measure_of_noise(&self, noise: f64) -> f64 {
        (noise / self.speed_squared).max(MINIMUM_TOLERANCE)
    }

    /// Smallest growth rate of complex `omega^2` that counts as flutter. 1/time.
    pub(in crate::bloch) fn flutter_threshold(&self, sites: usize) -> f64 {
        FLUTTER_TOLERANCE * self.speed_over_spacing(sites)
    }

    /// Sound speed divided by particle spacing, for cells of `sites` particles. 1/time.
    fn speed_over_spacing(&self, sites: usize) -> f64 {
        let side = self.reference().vectors().column(0).norm();
        self.speed_squared.sqrt() * (sites as f64).powf(1.0 / D as f64) / side
    }

    /// Largest `|k|_h^2` of all wave vectors. 1/length^2.
    pub(in crate::bloch) fn largest_laplacian(&self) -> f64 {
        let vectors = self.reference().vectors().column_iter();
        vectors.map(|a| 4.0 / a.norm_squared()).sum()
    }

    /// Replaces the scaled measure of a mode by `Re omega^2` over `c^2` times the largest `|k|_h^2`. The usual measure has no minimum if a mode grows
    /// at `k = 0`.
    pub(in crate::bloch) fn over_largest_laplacian(&self, mode: Mode<D>) -> Mode<D> {
        let scale = self.speed_squared * self.largest_laplacian();
        Mode {
            scaled: mode.omega_squared.re / scale,
            ..mode
        }
    }

    /// Wave vectors along the direction in which the longest waves flutter fastest; empty if long waves do not flutter.
    ///
    /// A pocket of complex `omega^2` can open at `k = 0` between the grid points. `step` is the grid step as a fraction of a reciprocal vector.
    ///
    /// The long-wave stiffness of forces without an energy has no major symmetry, so that its acoustic tensors can have complex eigenvalues.
    pub(in crate::bloch) fn long_flutter(
        &self,
        stiffness: &Stiffness<D>,
        step: f64,
    ) -> Vec<SVector<f64, D>> {
        let map = self.grids.long_wave_map();
        let Some(fastest) = stiffness.with_directions_mapped(map).flutter() else {
            return Vec::new();
        };
        let direction = map * fastest.direction;
        let reciprocal = self.reference().reciprocal().column(0).norm();
        let along = |steps: f64| direction * (steps * step * reciprocal / direction.norm());
        RELAXED_RAY_STEPS.map(along).to_vec()
    }

    /// Points of high symmetry, moved into the searched zone if `D` is not periodic.
    fn symmetric_waves(&self) -> impl Iterator<Item = SVector<f64, D>> {
        self.symmetric_points()
            .map(|k| if self.is_periodic { k } else { self.folded(&k) })
    }

    /// Halves and thirds of reciprocal vectors, which include X, M and K; one of each pair `k`, `-k`.
    fn symmetric_points(&self) -> impl Iterator<Item = SVector<f64, D>> {
        let fractions = [0.0, 1.0 / 3.0, 0.5, 2.0 / 3.0];
        (1..4_usize.pow(D as u32))
            .map(|index| grid_coordinates::<D>(index, 4))
            .filter(|at| *at <= at.each(|n| (4 - n) % 4))
            .map(move |at| SVector::from(at.each(|n| fractions[n])))
            .map(|fractional| self.reference().reciprocal() * fractional)
    }

    /// Rigid translation, with the given scaled measure.
    fn rest(&self, matrix: &DynamicalMatrix<D>, scaled: f64) -> Mode<D> {
        let d = matrix
            .rigid_translation()
            .map(|entry| Complex::new(entry, 0.0));
        let omega_squared = eigenvalues(&d, matrix.noise())[0];
        Mode {
            wave_vector: SVector::zeros(),
            is_long_wave: false,
            omega_squared,
            scaled,
            polarization: eigenvector(&d, omega_squared),
        }
    }

    /// Converts a reference wave vector to the coordinates of the kernel.
    ///
    /// This is `F^-T k` for Eulerian kernels on the convected lattice, otherwise `k`.
    pub fn kernel_wave_vector(&self, k: &SVector<f64, D>) -> SVector<f64, D> {
        self.from_reference * k
    }

    /// Returns the equivalent reference wave vector in the searched zone.
    pub fn folded(&self, k: &SVector<f64, D>) -> SVector<f64, D> {
        self.to_reference * self.zone().folded(&(self.from_reference * k))
    }

    /// Largest `t` for which `t k` lies in the searched zone; infinite for `k = 0`.
    pub fn reach(&self, k: &SVector<f64, D>) -> f64 {
        self.zone().reach(&(self.from_reference * k))
    }

    fn value(&self, matrix: &DynamicalMatrix<D>, objective: Objective, sample: &Sample<D>) -> f64 {
        let omega_squared = &sample.omega_squared;
        match objective {
            Objective::Scaled => {
                let laplacian = self.reference().laplacian(&sample.wave_vector);
                omega_squared[0].re / (self.speed_squared * laplacian)
            }
            Objective::Lowest => omega_squared[0].re,
            Objective::Highest => -omega_squared[D - 1].re,
            Objective::Discriminant => discriminant(matrix, &sample.matrix)
                .unwrap_or_else(|| -complex_growth(omega_squared)),
            Objective::Growth => -complex_growth(omega_squared),
        }
    }

    fn value_at(
        &self,
        matrix: &DynamicalMatrix<D>,
        objective: Objective,
        k: &SVector<f64, D>,
    ) -> f64 {
        let d = matrix.at(k);
        if objective == Objective::Discriminant
            && let Some(value) = discriminant(matrix, &d)
        {
            return value;
        }
        self.value(matrix, objective, &Sample::with(matrix, *k, d))
    }

    /// Returns true if a wave on the grid flutters noticeably. Only its existence is needed, so that the best grid point suffices.
    fn grid_flutters(&self, matrix: &DynamicalMatrix<D>, wells: &Wells<D>) -> bool {
        let Wells::Grid(grid) = wells else {
            return false;
        };
        // A Hermitian matrix has real eigenvalues.
        if matrix.is_hermitian() {
            return false;
        }
        let (lowest, k) = grid.minimum(Objective::Discriminant);
        let grows = |mode: Mode<D>| growth_rate(mode.omega_squared) > self.flutter_threshold(1);
        lowest < 0.0 && self.fluttering_mode(matrix, &k).is_some_and(grows)
    }

    /// A mode with noticeable flutter, or `None`. `fastest` then maximizes its growth rate.
    ///
    /// With a `rival`, the result is also `None` if no flutter can grow faster than this rate.
    fn flutter(
        &self,
        matrix: &DynamicalMatrix<D>,
        wells: &mut Wells<D>,
        rival: f64,
    ) -> Option<Mode<D>> {
        // A Hermitian matrix has real eigenvalues.
        if matrix.is_hermitian() {
            return None;
        }
        if let Wells::Mirrored(search) = wells {
            search.follow_flutter(rival);
        }
        let wells = &*wells;
        let largest = wells.largest();
        let floor = match (D, matrix.is_centrosymmetric()) {
            (3, true) => -matrix.noise() * largest.powi(5),
            (_, true) => -matrix.noise() * largest,
            (_, false) => 0.0,
        };
        // In three dimensions, each pocket between the grid points is examined. If the largest growth rate on the grid is less than half of the
        // rival's, no pocket is likely to exceed it.
        let is_far = match wells {
            Wells::Grid(grid) if rival > 0.0 => {
                grid.has_asymmetry() && grid.largest_growth() <= 0.5 * rival
            }
            _ => false,
        };
        let pocket = match is_far {
            true => None,
            false => wells.bottom(self, matrix, Objective::Discriminant, floor),
        };
        let opening = match wells {
            Wells::Grid(grid) if !is_far => self.opening(matrix, grid),
            _ => &[],
        };
        let candidates = pocket
            .map(|(_, k)| k)
            .into_iter()
            .chain(opening.iter().copied());
        let noticeable =
            |mode: &Mode<D>| growth_rate(mode.omega_squared) > self.flutter_threshold(1);
        candidates
            .filter_map(|k| self.fluttering_mode(matrix, &k))
            .max_by(|a, b| growth_rate(a.omega_squared).total_cmp(&growth_rate(b.omega_squared)))
            .filter(noticeable)
            .or_else(|| {
                // In the plane, the discriminant of a real matrix detects all of its pockets.
                let is_complete = D < 3 && matrix.is_centrosymmetric();
                let pockets = match wells {
                    Wells::Grid(grid) if !is_complete => self.pockets(matrix, grid, rival),
                    _ => &[],
                };
                let mut modes = pockets
                    .iter()
                    .filter_map(|k| self.fluttering_mode(matrix, k));
                modes.find(noticeable)
            })
    }

    /// Wave vectors along the direction in which the longest waves flutter fastest.
    fn opening<'g>(&self, matrix: &DynamicalMatrix<D>, grid: &'g Grid<D>) -> &'g [SVector<f64, D>] {
        let step = 1.0 / grid.waves.resolution() as f64;
        grid.opening
            .get_or_init(|| self.long_flutter(&matrix.long_wave_stiffness(), step))
    }

    /// Returns true if the longest waves flutter.
    fn long_waves_flutter(&self, matrix: &DynamicalMatrix<D>, wells: &Wells<D>) -> bool {
        match wells {
            Wells::Grid(grid) => !self.opening(matrix, grid).is_empty(),
            Wells::Mirrored(_) => {
                let opening = self.long_flutter(&matrix.long_wave_stiffness(), 1.0);
                !opening.is_empty()
            }
        }
    }

    /// Wave vectors in pockets of complex `omega^2` between the grid points, in which waves may grow faster than `rival`.
    fn pockets<'g>(
        &self,
        matrix: &DynamicalMatrix<D>,
        grid: &'g Grid<D>,
        rival: f64,
    ) -> &'g [SVector<f64, D>] {
        grid.pockets
            .get_or_init(|| self.pockets_between(matrix, grid, rival))
    }

    fn pockets_between(
        &self,
        matrix: &DynamicalMatrix<D>,
        grid: &Grid<D>,
        rival: f64,
    ) -> Vec<SVector<f64, D>> {
        let (points, stride) = grid.near_crossings(matrix.is_centrosymmetric(), rival);
        // The growth rate predicted for a pocket can be as low as half of the rate that a descent finds from there. In the plane it is cheap to examine
        // all pockets.
        let rival = match grid.has_asymmetry() {
            true => 0.5 * rival,
            false => 0.0,
        };
        let pockets = Pockets {
            around: &|wave_vectors, order| {
                let around = |k: &SVector<f64, D>| {
                    let is_sought = self.is_sought(Objective::Scaled, k);
                    let real = || match order {
                        Order::First => matrix.real_expansion_at::<1>(k),
                        Order::Second => matrix.real_expansion_at::<2>(k),
                    };
                    is_sought.then(|| match real() {
                        Some(expansion) => Around::Real(expansion),
                        None => Around::Complex(matrix.expansion_at(k).into()),
                    })
                };
                wave_vectors.iter().map(around).collect()
            },
            is_large: false,
            steps: self.reference().reciprocal() * (stride as f64 / grid.waves.resolution() as f64),
            threshold: self.flutter_threshold(1).max(rival),
            rival,
            most: REFINED_POCKETS,
            finer: HALVED_STEP_POINTS,
        };
        pockets.around(points.into_iter())
    }

    /// Wells of the zone: from a grid with the given density, or, for a matrix with a mirror line, the bottoms of the requested objectives.
    fn wells(
        &self,
        matrix: &DynamicalMatrix<D>,
        points_per_period: usize,
        sought: &[Objective],
        long_wave: &Mode<D>,
        rest: &Mode<D>,
    ) -> Wells<D> {
        let mirrors = if self.is_periodic {
            self.grids.mirrors()
        } else {
            &[]
        };
        let Some(sums) = matrix.mirror_sums(mirrors) else {
            let grid = self.grid(matrix, points_per_period, long_wave.wave_vector);
            return Wells::Grid(Box::new(grid));
        };
        let waves = self.grids.mirrored(sums.number, mirrored::intervals(&sums));
        let request = |objective| Request {
            objective,
            floor: match objective {
                Objective::Scaled => long_wave.scaled * self.speed_squared,
                Objective::Lowest => rest.omega_squared.re,
                Objective::Highest => f64::INFINITY,
                Objective::Discriminant | Objective::Growth => 0.0,
            },
        };
        let mut requests: Vec<Request> = sought.iter().copied().map(request).collect();
        let followed = requests.len();
        if !matrix.is_hermitian() {
            requests.push(request(Objective::Discriminant));
        }
        let k = long_wave.wave_vector;
        let soft = [0, 1].each(|n| k.dot(&self.reference().vectors().column(n)));
        let noise = matrix.noise();
        let mut search = Mirrored::new(self.reference(), sums, waves, &requests, noise, soft);
        search.follow(&requests[..followed]);
        Wells::Mirrored(Box::new(search))
    }

    /// Reference wave vector with the given phases of the two primitive vectors, in the plane.
    fn with_phases(&self, phases: [f64; 2]) -> SVector<f64, D> {
        let fractional = SVector::from_fn(|n, _| phases[n] / std::f64::consts::TAU);
        self.reference().reciprocal() * fractional
    }

    /// Fastest growing mode of a state with complex `omega^2`: the best of `lowest` and of the descents.
    ///
    /// The descents start from `fluttering`, from the fastest grid points and from the pockets between them.
    fn fastest(
        &self,
        matrix: &DynamicalMatrix<D>,
        wells: &Wells<D>,
        lowest: Mode<D>,
        fluttering: Mode<D>,
        rival: f64,
    ) -> Mode<D> {
        // In three dimensions a descent that cannot exceed the growth by divergence is too expensive.
        let floor = match D {
            3 => -growth_rate(lowest.omega_squared),
            _ => f64::INFINITY,
        };
        let ends: Vec<SVector<f64, D>> = match wells {
            Wells::Grid(grid) => grid
                .fastest_flutter()
                .take(4)
                .chain([fluttering.wave_vector])
                .chain(
                    self.pockets(matrix, grid, rival)
                        .iter()
                        .copied()
                        .take(FOLLOWED_POCKETS),
                )
                .map(|k| self.settled(matrix, Objective::Growth, k, floor))
                .collect(),
            Wells::Mirrored(search) => search
                .bottoms
                .iter()
                .filter(|bottom| bottom.objective == Objective::Growth)
                .map(|bottom| self.with_phases(bottom.phases))
                .chain([fluttering.wave_vector])
                .collect(),
        };
        ends.iter()
            .filter_map(|k| self.fluttering_mode(matrix, k))
            .chain([lowest])
            .max_by(|a, b| growth_rate(a.omega_squared).total_cmp(&growth_rate(b.omega_squared)))
            .unwrap_or(lowest)
    }

    /// Fastest growing mode with complex `omega^2` at a wave vector.
    fn fluttering_mode(&self, matrix: &DynamicalMatrix<D>, k: &SVector<f64, D>) -> Option<Mode<D>> {
        let (k, d, all) = self.spectrum_at(matrix, k);
        let omega_squared = all
            .iter()
            .filter(|value| value.im != 0.0)
            .max_by(|a, b| growth_rate(**a).total_cmp(&growth_rate(**b)))?;
        Some(self.mode_of(k, &d, &all, *omega_squared))
    }
}

/// Requested part of the flutter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::bloch) enum Flutter {
    /// All waves with complex `omega^2`.
    All,
    /// Waves that may grow faster than the lowest wave, and long waves on request.
    Fastest { includes_long_waves: bool },
}

impl Flutter {
    /// Returns true if flutter of long waves is evaluated, given the rival's growth rate and whether flutter was found.
    pub(in crate::bloch) fn includes_long_waves(self, rival: f64, flutters: bool) -> bool {
        match self {
            Self::Fastest {
                includes_long_waves,
            } if rival > 0.0 => includes_long_waves,
            _ => flutters,
        }
    }
}

/// Smaller of two scaled measures: of the long-wave limit or a wave vector, and of another wave vector.
fn lower<const D: usize>(
    least: (f64, Option<SVector<f64, D>>),
    (value, k): Candidate<D>,
) -> (f64, Option<SVector<f64, D>>) {
    if value < least.0 || least.0.is_nan() {
        (value, Some(k))
    } else {
        least
    }
}

/// Wells of the zone.
enum Wells<const D: usize> {
    /// Wells of a grid, not yet followed.
    Grid(Box<Grid<D>>),
    /// Wells of a matrix with a mirror line, with the known bottoms; initially only the wells of the real objectives.
    Mirrored(Box<Mirrored>),
}

impl<const D: usize> Wells<D> {
    /// Deepest bottom, if it may lie below `floor`.
    fn bottom(
        &self,
        search: &ZoneSearch<D>,
        matrix: &DynamicalMatrix<D>,
        objective: Objective,
        floor: f64,
    ) -> Option<Candidate<D>> {
        let bottoms = match self {
            Self::Grid(grid) => return search.bottom(matrix, grid, objective, floor),
            Self::Mirrored(search) => &search.bottoms,
        };
        let own = || {
            bottoms
                .iter()
                .filter(|bottom| bottom.objective == objective)
        };
        let settled = own().filter(|bottom| bottom.is_settled);
        let mut best = settled
            .min_by(|a, b| a.value.total_cmp(&b.value))
            .map(|bottom| search.with_phases(bottom.phases))
            .map(|k| (search.value_at(matrix, objective, &k), k));
        for bottom in own().filter(|bottom| !bottom.is_settled) {
            let k = search.with_phases(bottom.phases);
            let start = (search.value_at(matrix, objective, &k), k);
            search.improve(matrix, objective, start, floor, &mut best);
        }
        best
    }

    /// Largest `Re omega^2` on the grid.
    fn largest(&self) -> f64 {
        match self {
            Self::Grid(grid) => grid.largest(),
            Self::Mirrored(search) => search.largest(),
        }
    }
}
