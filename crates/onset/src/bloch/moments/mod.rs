//! Extremes of the spectrum of planar Lagrangian kernels for many states, from gradient moments that do not depend on the state.
//!
//! If all quadrature points have the same deformation, `D(k) = A : H(k)` with the gradient moments `H_JL(k) = 1/m sum_q V_q conj(B_qJ) B_qL`, which
//! depend neither on the material nor on the state. In the plane and with inversion centers, `H(k)` is real and thus a point in three dimensions. The
//! smallest eigenvalue of `A : H` is concave in `H` and the largest eigenvalue is convex, so that only extreme points of the set of all `H(k)`
//! matter.
//!
//! 1. A few grid points near extreme points are selected once, as candidates for all tangents (`candidates`).
//! 2. For each tangent, the best candidate of each region of the zone is found (`scan`).
//! 3. Newton's method on the exact sums leads from there to the extreme (`refine`). For weakly controlled modes, more starts are tried (`valley`).
//!
//! The extremes are sampled values; this module computes no bound. Constants without a stated derivation are heuristic; the tests of surveys compare
//! random states with a grid and with the search of a single state.

mod candidates;
mod contraction;
mod long_waves;
mod refine;
mod scan;
mod sums;
mod valley;

use super::branches::Taylor;
use super::dynamical_matrix::Expansion;
use super::representative::MEASURE_ROUNDING;
use super::search::Objective;
use super::{DynamicalMatrix, ZERO_ENERGY, ZoneSearch, moment_matrix};
use crate::algebra::{Complex, Each, array_of, moderate_unit};
use crate::continuum::direction;
use crate::kinematics::DeformationGradient;
use crate::lattice::{BravaisLattice, WaveGrid, inverse_of};
use crate::material::PlaneTangent;
use crate::method::{Background, Frame, Method, MethodError};
use candidates::Candidates;
use contraction::{Coefficients, Columns, coefficients, is_mirrored};
use long_waves::{LongMoments, LongWaves};
use nalgebra::{SMatrix, SVector};
use pulp::Arch;
use refine::{Descents, END_BEATEN, END_FAILED, Refine};
use scan::{Scan, Start, Starts};
use std::f64::consts::TAU;
use std::sync::{Arc, OnceLock};
use sums::Sums;
use valley::Valley;

/// Grid points per period of the fastest phase.
const POINTS_PER_PERIOD: usize = 12;
/// Number of directions that are sampled for the softest long wave if the vectorized search did not converge.
const SAMPLED_DIRECTIONS: usize = 32;
/// Maximum number of Newton steps to the minimum over directions.
const NEWTON_STEPS: usize = 12;
/// Number of states that are processed together; their columns fit into the cache.
const BATCH_STATES: usize = 1024;

/// Gradient moments of a planar Lagrangian method over the zone, valid for all states of the method.
#[derive(Clone, Debug)]
pub struct GradientMoments<const D: usize> {
    matrix: DynamicalMatrix<D>,
    search: ZoneSearch<D>,
    sums: Sums,
    /// Extreme points of `H(k) / |k|_h^2`.
    scaled: Wells<D>,
    /// Wave vectors of weakly controlled modes, if the method has such modes.
    valley: Option<Valley<D>>,
    /// Extreme points of `H(k)`.
    plain: Wells<D>,
    /// `H(k) / |k|_h^2` for long waves: `h0 + hc cos t + hs sin t` in the doubled angle `t` of `G^1/2 k`.
    long: LongMoments,
    /// Rounding error of the scaled moments of long waves.
    long_noise: f64,
    /// True if a wave with alternating neighbors causes no strain, so that it is a zero-energy mode at any state.
    misses_alternating: bool,
    /// Unit of the moments.
    moment_unit: f64,
    /// Unit of `D` and `c^2`.
    unit: f64,
}

/// Candidates for any tangent, and for tangents with the coordinate axes as mirror axes. Computed when first needed.
#[derive(Clone, Debug)]
struct Wells<const D: usize> {
    grid: Arc<WaveGrid<D>>,
    /// Moments at half of the grid.
    moments: Vec<[f64; 3]>,
    any: OnceLock<Candidates<D>>,
    mirrored: OnceLock<Candidates<D>>,
}

impl<const D: usize> Wells<D> {
    fn new(grid: &Arc<WaveGrid<D>>, moments: Vec<[f64; 3]>) -> Self {
        Self {
            grid: Arc::clone(grid),
            moments,
            any: OnceLock::new(),
            mirrored: OnceLock::new(),
        }
    }

    fn candidates(
        &self,
        lattice: &BravaisLattice<D>,
        sums: &Sums,
        is_mirrored: bool,
    ) -> &Candidates<D> {
        let made = if is_mirrored {
            &self.mirrored
        } else {
            &self.any
        };
        made.get_or_init(|| Candidates::new(lattice, &self.grid, sums, &self.moments, is_mirrored))
    }
}

/// Extremes of `D(k) = A : H(k)` over the zone, sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MomentExtremes<const D: usize> {
    /// Smallest `omega^2 / (c^2 |k|_h^2)`, including long waves.
    pub scaled_minimum: f64,
    /// Wave vector of the minimum; the unit direction for long waves.
    pub wave_vector: SVector<f64, D>,
    /// True if the minimum is the long-wave limit.
    pub is_long_wave: bool,
    /// True if the softest mode, or a wave with alternating neighbors, is a zero-energy mode at any state.
    pub has_zero_mode: bool,
    /// Smallest long-wave limit of the scaled measure.
    pub long_wave_minimum: f64,
    /// Smallest `omega^2`; zero if no `omega^2` is negative. 1/time^2.
    pub lowest: f64,
    /// Largest `omega^2`. 1/time^2.
    pub highest: f64,
    /// Scaled measures of smaller magnitude are zero to rounding.
    pub tolerance: f64,
}

/// Value of the objective at a bottom, and its wave vector.
type Bottom<const D: usize> = (f64, SVector<f64, D>);

/// Returns true if a wave causes no strain: its gradient moments are zero to rounding, relative to long waves.
fn has_no_strain<const D: usize>(
    matrix: &DynamicalMatrix<D>,
    search: &ZoneSearch<D>,
    long: &LongMoments,
    k: &SVector<f64, D>,
) -> bool {
    let h = matrix.at(k);
    let trace = (h[(0, 0)] + h[(1, 1)]).re / search.reference().laplacian(k);
    trace <= ZERO_ENERGY * long.iter().map(|h| h[0].abs()).sum::<f64>()
}

impl<const D: usize> GradientMoments<D> {
    /// Computes the moments of a method. `speed_squared` is the `c^2` of the scaled measure.
    ///
    /// `None` if `D(k)` is not the contraction with a single tangent, or is not planar and real: for Eulerian kernels, an interpolated background, or
    /// quadrature points without an inversion center.
    ///
    /// # Errors
    /// [`MethodError`] if the method cannot be evaluated.
    pub fn new(method: &Method<D>, speed_squared: f64) -> Result<Option<Self>, MethodError> {
        let discretization = method.choices();
        if D != 2
            || discretization.frame != Frame::Lagrangian
            || discretization.background != Background::Imposed
        {
            return Ok(None);
        }
        let rest = DeformationGradient::identity();
        let matrix = moment_matrix(method, &rest)?;
        let moment_unit = matrix.moderate_unit();
        let matrix = matrix.over(moment_unit);
        let unit = moderate_unit(speed_squared);
        let speed_squared = speed_squared / unit;
        let search = ZoneSearch::new(method, &rest, speed_squared).ok_or(MethodError::NotFinite)?;
        let lattice = search.reference();
        let grid = method
            .wave_grids()
            .grid((POINTS_PER_PERIOD * matrix.effective_reach().clamp(4, 16)).next_multiple_of(6));
        let (Some(sums), Some(entries)) =
            (Sums::new(&matrix, lattice), matrix.planar_entries(&grid))
        else {
            return Ok(None);
        };
        let [h11, h12, _, h22] = &entries;
        let moments: Vec<[f64; 3]> = (0..h11.len()).map(|n| [h11[n], h12[n], h22[n]]).collect();
        let laplacian = grid.laplacian();
        let mut scaled: Vec<[f64; 3]> = moments
            .iter()
            .zip(laplacian)
            .map(|(h, laplacian)| h.each(|entry| entry / laplacian))
            .collect();
        // No wave exists at `k = 0`.
        scaled[0] = [f64::NAN; 3];
        let valley = Valley::new(lattice, &grid, &scaled);
        let (scaled, plain) = (Wells::new(&grid, scaled), Wells::new(&grid, moments));
        let long = long_moments(method, &matrix);
        let long_noise = matrix.long_wave_noise();
        let misses_alternating = lattice
            .alternating()
            .any(|k| has_no_strain(&matrix, &search, &long, &k));
        Ok(Some(Self {
            matrix,
            sums,
            scaled,
            valley,
            plain,
            long,
            long_noise,
            misses_alternating,
            search,
            moment_unit,
            unit,
        }))
    }

    /// Computes the extremes for materials with the given plane tangents.
    pub fn extremes(&self, tangents: &[PlaneTangent]) -> Vec<MomentExtremes<D>> {
        let factor = self.moment_unit / self.unit;
        let in_units = |tangent| coefficients(tangent, factor);
        let rows: Vec<Coefficients> = tangents.iter().map(in_units).collect();
        let (mirrored, others): (Vec<usize>, Vec<usize>) =
            (0..rows.len()).partition(|n| is_mirrored(&rows[*n]));
        let mut found = vec![None; rows.len()];
        for (numbers, is_mirrored) in [(mirrored, true), (others, false)] {
            for numbers in numbers.chunks(BATCH_STATES) {
                let rows: Vec<Coefficients> = numbers.iter().map(|n| rows[*n]).collect();
                let extremes = if is_mirrored {
                    self.of_batch::<true>(&rows)
                } else {
                    self.of_batch::<false>(&rows)
                };
                for (n, extremes) in numbers.iter().zip(extremes) {
                    found[*n] = Some(MomentExtremes {
                        lowest: extremes.lowest * self.unit,
                        highest: extremes.highest * self.unit,
                        ..extremes
                    });
                }
            }
        }
        found.into_iter().flatten().collect()
    }

    fn of_batch<const MIRRORED: bool>(&self, rows: &[Coefficients]) -> Vec<MomentExtremes<D>> {
        let c2 = self.search.speed_squared();
        let columns = Columns::new(rows);
        let long = Arch::new().dispatch(LongWaves {
            moments: &self.long,
            columns: &columns,
        });
        let long_waves: Vec<(f64, [f64; 2])> = (0..rows.len())
            .map(|n| {
                if long.unsettled[n] == 0.0 {
                    (long.values[n], [long.turns[0][n], long.turns[1][n]])
                } else {
                    let (t, value) = self.long_wave_minimum(&rows[n]);
                    (value, [t.cos(), t.sin()])
                }
            })
            .collect();
        let batch = Batch {
            moments: self,
            rows,
            columns: &columns,
        };
        let limits: Vec<f64> = long_waves.iter().map(|(value, _)| *value).collect();
        let mut finite = batch.bottoms::<MIRRORED>(Objective::Scaled, &limits);
        for (row, bottom) in rows.iter().zip(&mut finite) {
            self.look_around(row, bottom);
        }
        let none = vec![f64::INFINITY; rows.len()];
        let highest = batch.bottoms::<MIRRORED>(Objective::Highest, &none);
        let mut extremes = Vec::with_capacity(rows.len());
        let mut growing = Vec::new();
        for n in 0..rows.len() {
            let tolerance = 16.0 * magnitude(&rows[n]) * self.long_noise / c2;
            let (limit, turn) = long_waves[n];
            let (value, wave_vector, is_long_wave) =
                self.chosen(&rows[n], finite[n], (limit, turn), tolerance * c2);
            let scaled_minimum = value / c2;
            if scaled_minimum < -tolerance {
                growing.push(n);
            }
            let has_no_strain = |k| has_no_strain(&self.matrix, &self.search, &self.long, k);
            let is_zero = !is_long_wave && scaled_minimum.abs() <= tolerance;
            let has_zero_mode = self.misses_alternating || is_zero && has_no_strain(&wave_vector);
            extremes.push(MomentExtremes {
                scaled_minimum,
                wave_vector,
                is_long_wave,
                has_zero_mode,
                long_wave_minimum: limit / c2,
                lowest: 0.0,
                highest: -highest[n].0,
                tolerance,
            });
        }
        if growing.is_empty() {
            return extremes;
        }
        let rows: Vec<Coefficients> = growing.iter().map(|n| rows[*n]).collect();
        let batch = Batch {
            moments: self,
            rows: &rows,
            columns: &Columns::new(&rows),
        };
        let lowest = batch.bottoms::<MIRRORED>(Objective::Lowest, &none[..rows.len()]);
        for (n, (value, _)) in growing.iter().zip(lowest) {
            extremes[*n].lowest = value.min(0.0);
        }
        extremes
    }

    /// Softest wave among the bottom of the zone and the long-wave limit, by the rule that selects among waves with equal measures: its measure times
    /// `c^2`, its wave vector or direction, and whether it is the limit.
    fn chosen(
        &self,
        row: &Coefficients,
        (value, k): Bottom<D>,
        (limit, turn): (f64, [f64; 2]),
        tolerance: f64,
    ) -> (f64, SVector<f64, D>, bool) {
        let search = &self.search;
        let is_limit = || search.is_limit((value, &k), limit, tolerance);
        if value >= limit || value.is_nan() || is_limit() {
            let map = search.long_wave_map();
            let found = (map * half_turned(turn)).normalize();
            let equal = limit + MEASURE_ROUNDING * magnitude(row) * self.long_size();
            let is_equal = |n: &SVector<f64, D>| self.of_direction(row, n) <= equal;
            return (limit, search.chosen_direction(&found, is_equal), true);
        }
        let equal = value + MEASURE_ROUNDING * value.abs() + tolerance;
        let is_equal = |k: &SVector<f64, D>| self.exact(row, Objective::Scaled, k) <= equal;
        (value, search.chosen(&k, Vec::new, is_equal), false)
    }

    /// Size of the moments of long waves.
    fn long_size(&self) -> f64 {
        self.long.iter().map(|h| h[0].abs()).sum()
    }

    /// Long-wave limit of the scaled measure along a direction, times `c^2`.
    fn of_direction(&self, row: &Coefficients, n: &SVector<f64, D>) -> f64 {
        // With `m = G^1/2 n`, the cosine and sine of the doubled angle of `m`.
        let Some(m) = inverse_of(self.search.long_wave_map()).map(|map| map * n) else {
            return f64::INFINITY;
        };
        let square = m[0] * m[0] + m[1] * m[1];
        let turn = [
            (m[0] * m[0] - m[1] * m[1]) / square,
            2.0 * m[0] * m[1] / square,
        ];
        let h = self.long.each(|h| h[0] + h[1] * turn[0] + h[2] * turn[1]);
        let [mean, half, mixed] = parts(row, h);
        mean - (half * half + mixed * mixed).sqrt()
    }

    /// Replaces a bottom in a valley of weakly controlled modes by the lowest bottom found there.
    fn look_around(&self, row: &Coefficients, bottom: &mut Bottom<D>) {
        let magnitude = magnitude(row);
        if let Some(valley) = self
            .valley
            .as_ref()
            .filter(|v| v.holds(bottom.0, magnitude))
        {
            let found = valley.bottom(row, magnitude, |k| self.careful(row, Objective::Scaled, k));
            if found.0 < bottom.0 {
                *bottom = found;
            }
        }
    }

    /// Descent with the general Newton method, for the few cases in which the vectorized descent fails.
    fn careful(
        &self,
        row: &Coefficients,
        objective: Objective,
        start: &SVector<f64, D>,
    ) -> Bottom<D> {
        let expansion = |k: &SVector<f64, D>| self.expansion(row, objective, k);
        let value = self.exact(row, objective, start);
        let ((_, k), _) = self
            .search
            .newton(&expansion, (value, *start), f64::INFINITY);
        (self.exact(row, objective, &k), k)
    }

    fn expansion(
        &self,
        row: &Coefficients,
        objective: Objective,
        k: &SVector<f64, D>,
    ) -> Option<Taylor<f64, D>> {
        if !self.search.is_sought(objective, k) {
            return None;
        }
        let d = contracted(row, &self.matrix.planar_expansion(k)?);
        Some(match objective {
            Objective::Highest => d.branch(1.0).map(|x| -x),
            Objective::Scaled => {
                let c2 = self.search.speed_squared();
                self.search.scaled(&d.branch(-1.0), k).map(|x| c2 * x)
            }
            _ => d.branch(-1.0),
        })
    }

    /// Objective (the scaled measure times `c^2`) with full relative accuracy, also for long waves.
    fn exact(&self, row: &Coefficients, objective: Objective, k: &SVector<f64, D>) -> f64 {
        let h = self.matrix.at(k).map(|entry: Complex| entry.re);
        let h = [h[(0, 0)], 0.5 * (h[(0, 1)] + h[(1, 0)]), h[(1, 1)]];
        let [mean, half, mixed] = parts(row, h);
        let root = (half * half + mixed * mixed).sqrt();
        match objective {
            Objective::Highest => -mean - root,
            Objective::Scaled => (mean - root) / self.search.reference().laplacian(k),
            _ => mean - root,
        }
    }

    /// Smallest long-wave limit of the scaled measure, times `c^2`, and the doubled angle of its direction.
    fn long_wave_minimum(&self, row: &Coefficients) -> (f64, f64) {
        let d = [0, 1, 2].each(|p| {
            let [mean, half, mixed] = parts(row, self.long.each(|h| h[p]));
            [mean + half, mixed, mean - half]
        });
        let at = |t: f64| {
            let (sine, cosine) = t.sin_cos();
            let value = |e: usize| d[0][e] + d[1][e] * cosine + d[2][e] * sine;
            let slope = |e: usize| -d[1][e] * sine + d[2][e] * cosine;
            let (x, xs) = ([0, 1, 2].map(value), [0, 1, 2].map(slope));
            let (half, half1) = (0.5 * (x[0] - x[2]), 0.5 * (xs[0] - xs[2]));
            let root = (half * half + x[1] * x[1]).sqrt();
            // Derivatives of `h - sqrt(p)`; each entry satisfies `f'' = -(f - f0)`.
            let half2 = 0.5 * (d[0][0] - d[0][2]) - half;
            let mixed2 = d[0][1] - x[1];
            let trace2 = 0.5 * (d[0][0] + d[0][2]) - 0.5 * (x[0] + x[2]);
            let p1 = half * half1 + x[1] * xs[1];
            let p2 = half1 * half1 + half * half2 + xs[1] * xs[1] + x[1] * mixed2;
            let first = 0.5 * (xs[0] + xs[2]) - p1 / root;
            let second = trace2 - p2 / root + p1 * p1 / (root * root * root);
            (0.5 * (x[0] + x[2]) - root, first, second)
        };
        let step = std::f64::consts::TAU / SAMPLED_DIRECTIONS as f64;
        let sampled: [f64; SAMPLED_DIRECTIONS] = array_of(|n| at(n as f64 * step).0);
        let mut best = (0.0, f64::INFINITY);
        for n in 0..SAMPLED_DIRECTIONS {
            let (left, right) = (
                sampled[(n + SAMPLED_DIRECTIONS - 1) % SAMPLED_DIRECTIONS],
                sampled[(n + 1) % SAMPLED_DIRECTIONS],
            );
            if sampled[n] > left || sampled[n] > right {
                continue;
            }
            let mut t = n as f64 * step;
            let mut value = sampled[n];
            for _ in 0..NEWTON_STEPS {
                let (_, first, second) = at(t);
                let next = t - first / second;
                let there = at(next).0;
                if !(second > 0.0 && there < value) {
                    break;
                }
                (t, value) = (next, there);
            }
            if value < best.1 {
                best = (t, value);
            }
        }
        best
    }
}

/// Tangents that are processed together.
struct Batch<'a, const D: usize> {
    moments: &'a GradientMoments<D>,
    rows: &'a [Coefficients],
    columns: &'a Columns,
}

impl<const D: usize> Batch<'_, D> {
    /// Lowest bottom of each tangent; infinite if it is not below the long-wave limit.
    fn bottoms<const MIRRORED: bool>(
        &self,
        objective: Objective,
        limits: &[f64],
    ) -> Vec<Bottom<D>> {
        let moments = self.moments;
        let wells = if objective == Objective::Scaled {
            &moments.scaled
        } else {
            &moments.plain
        };
        let lattice = moments.search.reference();
        let candidates = wells.candidates(lattice, &moments.sums, MIRRORED);
        let sign = if objective == Objective::Highest {
            -1.0
        } else {
            1.0
        };
        let mut scales = vec![0.0; self.columns.length()];
        for (scale, row) in scales.iter_mut().zip(self.rows) {
            *scale = candidates.scale * magnitude(row);
        }
        let Starts { best, rivals } = Arch::new().dispatch(Scan::<D, MIRRORED> {
            candidates,
            columns: self.columns,
            sign,
            limits,
            scales: &scales,
        });
        let mut bottoms = vec![(f64::INFINITY, SVector::zeros()); self.rows.len()];
        // The best candidates come first, because they exclude most rivals immediately.
        for mut starts in [best, rivals] {
            // Descents from one candidate need a similar number of steps.
            starts.sort_unstable_by_key(|(_, candidate)| *candidate);
            self.descend::<MIRRORED>(objective, candidates, &starts, limits, &mut bottoms);
        }
        bottoms
    }

    /// Descends from candidates of the given tangents and keeps lower bottoms.
    fn descend<const MIRRORED: bool>(
        &self,
        objective: Objective,
        candidates: &Candidates<D>,
        starts: &[Start],
        limits: &[f64],
        bottoms: &mut [Bottom<D>],
    ) {
        let rows: Vec<Coefficients> = starts.iter().map(|(n, _)| self.rows[*n]).collect();
        let floor = |n: usize| limits[n].min(bottoms[n].0);
        let mut descents = Descents::new(
            candidates,
            starts.iter().map(|(n, candidate)| (*candidate, floor(*n))),
        );
        Arch::new().dispatch(Refine::<D, MIRRORED> {
            sums: &self.moments.sums,
            candidates,
            columns: &Columns::new(&rows),
            sign: if objective == Objective::Highest {
                -1.0
            } else {
                1.0
            },
            scaled: objective == Objective::Scaled,
            descents: &mut descents,
        });
        for (place, (n, candidate)) in starts.iter().enumerate() {
            let end = descents.ends[place];
            if end == END_BEATEN {
                continue;
            }
            let (value, k) = if end == END_FAILED {
                let start = &candidates.wave_vectors[*candidate];
                self.moments.careful(&rows[place], objective, start)
            } else {
                let phases = [descents.phases[0][place], descents.phases[1][place]];
                let reciprocal = self.moments.search.reference().reciprocal();
                let k = SVector::from_fn(|i, _| {
                    (reciprocal[(i, 0)] * phases[0] + reciprocal[(i, 1)] * phases[1]) / TAU
                });
                (descents.values[place], k + candidates.shifts[*candidate])
            };
            if value < bottoms[*n].0 {
                bottoms[*n] = (value, k);
            }
        }
    }
}

/// Largest entry of the linear map from `H` to `D`.
fn magnitude([mean, half, mixed]: &Coefficients) -> f64 {
    (0..3)
        .map(|e| f64::max(mean[e].abs() + half[e].abs(), mixed[e].abs()))
        .fold(0.0, f64::max)
}

/// Components `(D_11 + D_22) / 2`, `(D_11 - D_22) / 2` and `D_12`.
fn parts(row: &Coefficients, h: [f64; 3]) -> [f64; 3] {
    row.each(|c| c[0] * h[0] + c[1] * h[1] + c[2] * h[2])
}

/// Computes `D(k) = A : H(k)` with its derivatives.
fn contracted<const D: usize>(row: &Coefficients, h: &Expansion<f64, D>) -> Expansion<f64, D> {
    let map = |h: &SMatrix<f64, D, D>| {
        let h = [h[(0, 0)], 0.5 * (h[(0, 1)] + h[(1, 0)]), h[(1, 1)]];
        let [mean, half, mixed] = parts(row, h);
        SMatrix::from_fn(|i, k| [mean + half, mixed, mean - half][i + k])
    };
    Expansion {
        value: map(&h.value),
        gradient: array_of(|a| map(&h.gradient[a])),
        hessian: array_of(|a| array_of(|b| map(&h.hessian[a][b]))),
    }
}

/// Long-wave limit of `H(k) / |k|_h^2`.
fn long_moments<const D: usize>(method: &Method<D>, matrix: &DynamicalMatrix<D>) -> LongMoments {
    let stiffness = matrix
        .long_wave_stiffness()
        .with_directions_mapped(method.wave_grids().long_wave_map());
    let along = |t: f64| {
        let h = stiffness.acoustic_tensor(&direction(t));
        [h[(0, 0)], 0.5 * (h[(0, 1)] + h[(1, 0)]), h[(1, 1)]]
    };
    let (east, north, west) = (along(0.0), along(0.25 * TAU), along(0.5 * TAU));
    array_of(|e| {
        let mean = 0.5 * (east[e] + west[e]);
        [mean, 0.5 * (east[e] - west[e]), north[e] - mean]
    })
}

/// Unit vector at half of the angle with the given cosine and sine.
fn half_turned<const D: usize>([cosine, sine]: [f64; 2]) -> SVector<f64, D> {
    // Both forms are free of cancellation.
    let (x, y) = if cosine > 0.0 {
        (1.0 + cosine, sine)
    } else {
        (sine.abs(), (1.0 - cosine).copysign(sine))
    };
    let length = (x * x + y * y).sqrt();
    SVector::from_fn(|i, _| [x, y][i] / length)
}
