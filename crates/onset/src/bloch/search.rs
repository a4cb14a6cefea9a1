//! The extremes of the spectrum over the whole first Brillouin zone.
//!
//! A grid fine enough for the range of the force constants finds the wells; each distinct one is then
//! followed to its bottom with exact gradients. Long waves are not sampled but taken to their limit.

use super::dynamical_matrix::grid_coordinates;
use super::{DynamicalMatrix, growth_rate};
use crate::algebra::{Complex, eigenvalues, eigenvector, left_eigenvector};
use crate::kinematics::DeformationGradient;
use crate::lattice::{BravaisLattice, BrillouinZone};
use crate::method::Method;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Scaled measures within this multiple of the rounding error of the matrix count as zero.
const ROUNDING: f64 = 4.0;
/// Growth rates of complex `omega^2` count as flutter beyond this fraction of sound speed over spacing.
const FLUTTER: f64 = 1e-7;
/// Distinct wells of the grid that are followed to their bottom, deepest first.
const WELLS: usize = 16;
/// Points of the grid per period of the fastest phase: to look for a witness, and to look for all wells. Multiples
/// of six periods have M, X and K among their points.
const COARSE: usize = 6;
const FINE: usize = 9;
/// Below this fraction of the zone a wave vector counts as a long wave, which the limit covers.
const LONG_WAVE: f64 = 1e-3;

/// A plane-wave mode of the discretization.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode<const D: usize> {
    /// Reference wave vector; in the long-wave limit its unit direction. 1/length.
    pub wave_vector: SVector<f64, D>,
    /// Whether this is the limit of long waves.
    pub is_long_wave: bool,
    /// `omega^2`; zero in the long-wave limit. 1/time^2.
    pub omega_squared: Complex,
    /// `Re omega^2 / (c^2 |k|_h^2)`, dimensionless, finite also in the long-wave limit.
    pub scaled: f64,
    /// Unit polarization `g`; its largest component is real and positive.
    pub polarization: SVector<Complex, D>,
}

/// The extremes of the spectrum over the zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectrumSummary<const D: usize> {
    /// The mode with the smallest scaled measure `mu`: the softest one. Where a rigid translation is not free
    /// (raw weights on a distorted lattice) the measure has no limit for long waves, and the modes below a
    /// thousandth of the zone are left out.
    pub softest: Mode<D>,
    /// The softest mode of the long-wave limit.
    pub long_wave: Mode<D>,
    /// The mode with the smallest `Re omega^2`; the translation `k = 0` when none is below zero.
    pub lowest: Mode<D>,
    /// The mode that grows fastest; the same as `lowest` unless `omega^2` is complex somewhere.
    pub fastest_growing: Mode<D>,
    /// `max sqrt(Re omega^2)`. 1/time.
    pub maximum_omega: f64,
    /// `|scaled|` below this is zero to rounding.
    pub tolerance: f64,
    /// Whether modes grow with a complex `omega^2`.
    pub flutters: bool,
}

/// How perturbations develop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// None grows.
    Stable,
    /// Some oscillate with growing amplitude: `omega^2` is complex, its real part nowhere negative.
    Flutter,
    /// Some have `Re omega^2 < 0`.
    Divergence,
}

impl<const D: usize> SpectrumSummary<D> {
    /// Whether a mode grows, and how.
    pub fn stability(&self) -> Stability {
        if self.softest.scaled < -self.tolerance || self.lowest.omega_squared.re < 0.0 {
            Stability::Divergence
        } else if self.flutters {
            Stability::Flutter
        } else {
            Stability::Stable
        }
    }

    /// Whether no mode grows.
    pub fn is_stable(&self) -> bool {
        self.stability() == Stability::Stable
    }

    /// The growth rate of the fastest growing mode, zero when stable. 1/time.
    pub fn growth_rate(&self) -> f64 {
        if self.is_stable() {
            0.0
        } else {
            growth_rate(self.fastest_growing.omega_squared)
        }
    }

    /// The critical time step of central differences without damping, `2 / omega_max`.
    pub fn critical_time_step(&self) -> f64 {
        2.0 / self.maximum_omega
    }
}

/// What is sought over the zone; always a minimum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Objective {
    /// `Re omega^2 / (c^2 |k|_h^2)` of the lowest branch.
    Scaled,
    /// `Re omega^2` of the lowest branch.
    Lowest,
    /// `-Re omega^2` of the highest branch.
    Highest,
    /// The discriminant `((D11 - D22)/2)^2 + D12 D21`, negative where `omega^2` is complex. Unlike the imaginary
    /// part of `omega^2` it is smooth. (In three dimensions minus the growth rate of complex pairs.)
    Discriminant,
}

/// The search over the zone of one method at one state.
#[derive(Clone, Debug)]
pub struct ZoneSearch<const D: usize> {
    zone: BrillouinZone<D>,
    /// From wave vectors of the searched zone to reference wave vectors, `home^T`.
    to_reference: SMatrix<f64, D, D>,
    /// The inverse.
    from_reference: SMatrix<f64, D, D>,
    reference: BravaisLattice<D>,
    is_periodic: bool,
    speed_squared: f64,
}

/// A wave vector with the value of the objective there.
type Candidate<const D: usize> = (f64, SVector<f64, D>);

impl<const D: usize> ZoneSearch<D> {
    /// The zone of a method at a state. `speed_squared` is the `c^2` of the scaled measure.
    ///
    /// `None` when the lattice degenerates in floating point.
    pub fn new(method: &Method<D>, f: &DeformationGradient, speed_squared: f64) -> Option<Self> {
        let home = method.home_map(f);
        let inverse = DMatrix::from_fn(D, D, |i, j| home[(j, i)]).try_inverse()?;
        Some(Self {
            zone: BrillouinZone::new(method.lattice().mapped(&home)?),
            to_reference: home.transpose(),
            from_reference: SMatrix::from_fn(|i, j| inverse[(i, j)]),
            reference: *method.lattice(),
            is_periodic: method.is_periodic(),
            speed_squared,
        })
    }

    /// The extremes of the spectrum.
    pub fn summary(&self, matrix: &DynamicalMatrix<D>) -> SpectrumSummary<D> {
        let grid = self.grid(matrix, FINE);
        let long_wave = self.long_wave_limit(matrix);
        let softest = self
            .bottom(matrix, &grid, Objective::Scaled, long_wave.scaled)
            .filter(|bottom| bottom.0 < long_wave.scaled)
            .map_or(long_wave, |bottom| self.mode(matrix, &bottom.1));
        let rest = self.rest(matrix);
        let lowest = self
            .bottom(matrix, &grid, Objective::Lowest, rest.omega_squared.re)
            .map(|bottom| self.mode(matrix, &bottom.1))
            .filter(|mode| {
                mode.omega_squared.re < rest.omega_squared.re
                    && mode.scaled < -self.tolerance(matrix)
            })
            .unwrap_or(rest);
        let flutters = self.flutter(matrix, &grid).is_some();
        let fastest_growing = if flutters {
            self.fastest(matrix, &grid, lowest)
        } else {
            lowest
        };
        let highest = self
            .bottom(matrix, &grid, Objective::Highest, f64::INFINITY)
            .map_or(0.0, |bottom| -bottom.0);
        SpectrumSummary {
            softest,
            long_wave,
            lowest,
            fastest_growing,
            maximum_omega: highest.max(0.0).sqrt(),
            tolerance: self.tolerance(matrix),
            flutters,
        }
    }

    /// Whether a mode grows, and how: the same answer as that of the summary, without the modes; with a measure
    /// whose sign it is where the spectrum is real.
    pub fn stability(&self, matrix: &DynamicalMatrix<D>) -> (Stability, f64) {
        let tolerance = self.tolerance(matrix);
        let coarse = self.grid(matrix, COARSE);
        let sampled = coarse
            .points
            .iter()
            .map(|point| point.scaled)
            .fold(f64::INFINITY, f64::min);
        let mut measure = sampled.min(self.long_wave_limit(matrix).scaled);
        // One witness is enough, and most unstable states have one on a coarse grid.
        if measure < -tolerance || self.rest(matrix).omega_squared.re < 0.0 {
            return (Stability::Divergence, measure);
        }
        // Branches of a matrix that is not Hermitian can be complex in small pockets.
        let grid = if matrix.is_hermitian() {
            coarse
        } else {
            self.grid(matrix, FINE)
        };
        if let Some(bottom) = self.bottom(matrix, &grid, Objective::Scaled, -tolerance) {
            measure = measure.min(bottom.0);
        }
        if measure < -tolerance {
            (Stability::Divergence, measure)
        } else if self.flutter(matrix, &grid).is_some() {
            (Stability::Flutter, measure)
        } else {
            (Stability::Stable, measure)
        }
    }

    /// The mode at a given reference wave vector with the lowest `Re omega^2`.
    pub fn mode(&self, matrix: &DynamicalMatrix<D>, k: &SVector<f64, D>) -> Mode<D> {
        // Of equivalent wave vectors the one in the zone is shown, of k and -k that with a positive leading component.
        let mut folded = if self.is_periodic { self.folded(k) } else { *k };
        let leading = folded
            .iter()
            .find(|component| component.abs() > 1e-9 * folded.amax());
        if leading.is_some_and(|component| *component < 0.0) {
            folded = -folded;
        }
        let k = &folded;
        let d = matrix.at(k);
        let omega_squared = eigenvalues(&d, matrix.noise())[0];
        let laplacian = self.reference.laplacian(k);
        Mode {
            wave_vector: *k,
            is_long_wave: false,
            omega_squared,
            scaled: omega_squared.re / (self.speed_squared * laplacian),
            polarization: eigenvector(&d, omega_squared),
        }
    }

    /// The limit `k -> 0` of the scaled measure, minimized over all directions algebraically.
    pub fn long_wave_limit(&self, matrix: &DynamicalMatrix<D>) -> Mode<D> {
        // With k = G^-1/2 m the scale |k|_h^2 -> k.G k becomes |m|^2.
        let map = inverse_square_root(&self.reference.long_wave_metric());
        let minimum = matrix
            .long_wave_stiffness()
            .with_directions_mapped(&map)
            .minimum();
        Mode {
            wave_vector: (map * minimum.direction).normalize(),
            is_long_wave: true,
            omega_squared: Complex::new(0.0, 0.0),
            scaled: minimum.eigenvalue.re / self.speed_squared,
            polarization: minimum
                .polarization
                .map(|component| Complex::new(component, 0.0)),
        }
    }

    /// The rigid translation.
    fn rest(&self, matrix: &DynamicalMatrix<D>) -> Mode<D> {
        let d = matrix.at(&SVector::zeros());
        let omega_squared = eigenvalues(&d, matrix.noise())[0];
        Mode {
            wave_vector: SVector::zeros(),
            is_long_wave: false,
            omega_squared,
            scaled: self.long_wave_limit(matrix).scaled,
            polarization: eigenvector(&d, omega_squared),
        }
    }

    /// Scaled measures of smaller magnitude are zero to rounding.
    pub fn tolerance(&self, matrix: &DynamicalMatrix<D>) -> f64 {
        ROUNDING * matrix.long_wave_noise() / self.speed_squared
    }

    /// The equivalent reference wave vector in the searched zone.
    fn folded(&self, k: &SVector<f64, D>) -> SVector<f64, D> {
        self.to_reference * self.zone.folded(&(self.from_reference * k))
    }

    fn value(
        &self,
        objective: Objective,
        k: &SVector<f64, D>,
        d: &SMatrix<Complex, D, D>,
        omega_squared: &[Complex; D],
    ) -> f64 {
        match objective {
            Objective::Scaled => {
                omega_squared[0].re / (self.speed_squared * self.reference.laplacian(k))
            }
            Objective::Lowest => omega_squared[0].re,
            Objective::Highest => -omega_squared[D - 1].re,
            Objective::Discriminant => match D {
                1 => 0.0,
                2 => {
                    let half = (d[(0, 0)] - d[(1, 1)]) * 0.5;
                    (half * half + d[(0, 1)] * d[(1, 0)]).re
                }
                _ => -complex_growth(omega_squared),
            },
        }
    }

    fn value_at(
        &self,
        matrix: &DynamicalMatrix<D>,
        objective: Objective,
        k: &SVector<f64, D>,
    ) -> f64 {
        let d = matrix.at(k);
        self.value(objective, k, &d, &eigenvalues(&d, matrix.noise()))
    }

    // ---- the grid ------------------------------------------------------------------------------

    fn grid(&self, matrix: &DynamicalMatrix<D>, points_per_period: usize) -> Grid<D> {
        let resolution = points_per_period * matrix.reach().clamp(4, 32);
        let resolution = resolution.next_multiple_of(6);
        let resolution = if D == 3 {
            resolution.min(48)
        } else {
            resolution
        };
        let total = resolution.pow(D as u32);
        let matrices = if self.is_periodic {
            matrix.on_grid(resolution, true)
        } else {
            None
        };
        let mut points = Vec::with_capacity(total);
        // D(-k) = conj D(k), and index `total - n` (in each coordinate) is -k: half of the grid is enough.
        for index in 0..total {
            let opposite = opposite_index::<D>(index, resolution);
            if opposite < index {
                let GridPoint { k, .. }: GridPoint<D> = points[opposite];
                points.push(GridPoint {
                    k: -k,
                    ..points[opposite]
                });
                continue;
            }
            let centered = |j: usize| {
                if 2 * j > resolution {
                    j as f64 - resolution as f64
                } else {
                    j as f64
                }
            };
            let fractional =
                grid_coordinates::<D>(index, resolution).map(|j| centered(j) / resolution as f64);
            let mut k = self.reference.reciprocal() * SVector::from(fractional);
            if !self.is_periodic {
                k = self.folded(&k);
            }
            let d = match matrices.as_ref().and_then(|matrices| matrices.get(index)) {
                Some(d) => *d,
                None => matrix.at(&k),
            };
            let omega_squared = eigenvalues(&d, matrix.noise());
            let value = |objective| self.value(objective, &k, &d, &omega_squared);
            points.push(GridPoint {
                k,
                scaled: if index == 0 {
                    f64::INFINITY
                } else {
                    value(Objective::Scaled)
                },
                lowest: value(Objective::Lowest),
                highest: value(Objective::Highest),
                discriminant: value(Objective::Discriminant),
                growth: complex_growth(&omega_squared),
            });
        }
        Grid { resolution, points }
    }

    /// The bottom of the deepest well. A well that is not going to reach below `floor` is left early.
    fn bottom(
        &self,
        matrix: &DynamicalMatrix<D>,
        grid: &Grid<D>,
        objective: Objective,
        floor: f64,
    ) -> Option<Candidate<D>> {
        // On the boundary of a zone that does not repeat, the minimum need not be stationary.
        let boundary = if self.is_periodic {
            Vec::new()
        } else {
            self.boundary_minima(matrix, objective)
        };
        let mut best: Option<Candidate<D>> =
            boundary.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0));
        // From the boundary too: beside it the grid, folded back, does not tell the wells.
        let starts = grid.wells(objective).into_iter().take(WELLS);
        let starts = starts
            .chain(self.long_starts(matrix, grid, objective))
            .chain(boundary);
        for start in starts {
            let to_beat = best.map_or(floor, |best| floor.min(best.0));
            let (value, k) = self.descend(matrix, objective, start, to_beat);
            let better = best.is_none_or(|best| value < best.0);
            if value.is_finite() && better {
                best = Some((value, k));
            }
        }
        best
    }

    /// Starts between the origin and the first points of the grid: the best of a ring at each of some radii.
    fn long_starts(
        &self,
        matrix: &DynamicalMatrix<D>,
        grid: &Grid<D>,
        objective: Objective,
    ) -> Vec<Candidate<D>> {
        if !matches!(objective, Objective::Scaled | Objective::Lowest) {
            return Vec::new();
        }
        let directions: Vec<SVector<f64, D>> = match D {
            1 => vec![SVector::repeat(1.0)],
            _ => (0..12)
                .map(|n| (std::f64::consts::PI * f64::from(n) / 12.0).sin_cos())
                .map(|(sine, cosine)| SVector::from_fn(|i, _| [cosine, sine, 0.0][i]))
                .collect(),
        };
        let step = self.reference.reciprocal().column(0).norm() / grid.resolution as f64;
        let start = |radius: f64| {
            let ring = directions
                .iter()
                .map(|direction| direction * (radius * step));
            ring.map(|k| (self.value_at(matrix, objective, &k), k))
                .min_by(|a, b| a.0.total_cmp(&b.0))
        };
        [0.25, 0.6].into_iter().filter_map(start).collect()
    }

    /// Whether a wave vector belongs to the search: inside of the zone where `D` is not periodic.
    fn is_admissible(&self, k: &SVector<f64, D>) -> bool {
        self.is_periodic || self.zone.contains(&(self.from_reference * k), 1e-9)
    }

    /// Minima along the boundary of the zone, for matrices that are not periodic.
    fn boundary_minima(
        &self,
        matrix: &DynamicalMatrix<D>,
        objective: Objective,
    ) -> Vec<Candidate<D>> {
        const SAMPLES: usize = 24;
        let corners = self.zone.corners();
        let at = |k: &SVector<f64, D>| {
            let k = self.to_reference * k;
            (self.value_at(matrix, objective, &k), k)
        };
        let mut minima: Vec<Candidate<D>> = corners.iter().map(at).collect();
        if D != 2 {
            return minima;
        }
        // k and -k are equivalent: half of the edges is enough.
        for edge in 0..corners.len().div_ceil(2) {
            let (from, to) = (corners[edge], corners[(edge + 1) % corners.len()]);
            let along = |t: f64| at(&(from + (to - from) * t)).0;
            let samples: Vec<f64> = (0..=SAMPLES)
                .map(|n| along(n as f64 / SAMPLES as f64))
                .collect();
            for n in 1..SAMPLES {
                if samples[n] <= samples[n - 1] && samples[n] <= samples[n + 1] {
                    let (low, high) = (
                        (n - 1) as f64 / SAMPLES as f64,
                        (n + 1) as f64 / SAMPLES as f64,
                    );
                    minima.push(at(&(from + (to - from) * golden_section(&along, low, high))));
                }
            }
        }
        minima
    }

    /// A mode with complex `omega^2` that grows noticeably, if there is one.
    fn flutter(&self, matrix: &DynamicalMatrix<D>, grid: &Grid<D>) -> Option<Mode<D>> {
        // A Hermitian matrix has real eigenvalues.
        if D == 1 || matrix.is_hermitian() {
            return None;
        }
        let largest = grid
            .points
            .iter()
            .map(|point| point.highest.abs())
            .fold(0.0, f64::max);
        let (_, k) = self.bottom(
            matrix,
            grid,
            Objective::Discriminant,
            -matrix.noise() * largest,
        )?;
        let mode = self.fluttering_mode(matrix, &k)?;
        let spacing = self.reference.vectors().column(0).norm();
        let threshold = FLUTTER * self.speed_squared.sqrt() / spacing;
        (growth_rate(mode.omega_squared) > threshold).then_some(mode)
    }

    /// The fastest growing mode where some have a complex `omega^2`: the best of `lowest` and of the searches from
    /// the deepest well of the discriminant and from the fastest point of the grid.
    fn fastest(&self, matrix: &DynamicalMatrix<D>, grid: &Grid<D>, lowest: Mode<D>) -> Mode<D> {
        let step = self.reference.reciprocal().column(0).norm() / grid.resolution as f64;
        let slowness = |k: &SVector<f64, D>| {
            if self.is_admissible(k) {
                -complex_growth(&matrix.omega_squared(k))
            } else {
                0.0
            }
        };
        let on_grid = grid
            .points
            .iter()
            .max_by(|a, b| a.growth.total_cmp(&b.growth))
            .map(|point| point.k);
        let in_well = self.flutter(matrix, grid).map(|mode| mode.wave_vector);
        [on_grid, in_well]
            .into_iter()
            .flatten()
            .filter_map(|k| self.fluttering_mode(matrix, &coordinate_search(&slowness, k, step).1))
            .chain([lowest])
            .max_by(|a, b| growth_rate(a.omega_squared).total_cmp(&growth_rate(b.omega_squared)))
            .unwrap_or(lowest)
    }

    /// The fastest growing mode with a complex `omega^2` at a wave vector.
    fn fluttering_mode(&self, matrix: &DynamicalMatrix<D>, k: &SVector<f64, D>) -> Option<Mode<D>> {
        let mode = self.mode(matrix, k);
        let d = matrix.at(&mode.wave_vector);
        let omega_squared = eigenvalues(&d, matrix.noise())
            .into_iter()
            .filter(|value| value.im != 0.0)
            .max_by(|a, b| growth_rate(*a).total_cmp(&growth_rate(*b)))?;
        Some(Mode {
            omega_squared,
            polarization: eigenvector(&d, omega_squared),
            ..mode
        })
    }

    // ---- descent -------------------------------------------------------------------------------

    /// Follows a well to its bottom: Newton's method with exact gradients, a line search, and a final
    /// look around, since at a crossing of two branches the gradient is not defined.
    fn descend(
        &self,
        matrix: &DynamicalMatrix<D>,
        objective: Objective,
        start: Candidate<D>,
        floor: f64,
    ) -> Candidate<D> {
        let longest = self
            .reference
            .reciprocal()
            .column_iter()
            .map(|b| b.norm())
            .fold(0.0, f64::max);
        let at = |k: &SVector<f64, D>| {
            // The limit of long waves is taken exactly elsewhere; and a zone that does not repeat is not left.
            let too_long = objective == Objective::Scaled && k.norm() < LONG_WAVE * longest;
            if too_long || !self.is_admissible(k) {
                f64::INFINITY
            } else {
                self.value_at(matrix, objective, k)
            }
        };
        let (mut value, mut k) = start;
        for _ in 0..16 {
            (value, k) = self.newton(matrix, objective, (value, k), longest, floor, &at);
            // Two branches cross in a point where the discriminant is zero and stationary. It is a saddle where
            // the branches beside it are complex, which by symmetry its gradient may not show.
            if objective == Objective::Discriminant && value.abs() <= 1e-6 * start.0.abs() {
                return coordinate_search(&at, k, 1e-3 * longest);
            }
            if value > floor {
                return (value, k);
            }
            let around = coordinate_search(&at, k, 1e-2 * longest);
            if around.0 >= value - 1e-12 * value.abs() {
                return if around.0 < value { around } else { (value, k) };
            }
            (value, k) = around;
        }
        (value, k)
    }

    fn newton(
        &self,
        matrix: &DynamicalMatrix<D>,
        objective: Objective,
        start: Candidate<D>,
        longest: f64,
        floor: f64,
        at: &impl Fn(&SVector<f64, D>) -> f64,
    ) -> Candidate<D> {
        let (mut value, mut k) = start;
        for _ in 0..30 {
            let gradient = self.gradient(matrix, objective, &k);
            if !gradient.iter().all(|component| component.is_finite()) || gradient.norm() == 0.0 {
                break;
            }
            let step = self.newton_step(matrix, objective, &k, &gradient, longest);
            // A quadratic well falls by half of the linear decrease; eight times as much is on the safe side.
            if value + 4.0 * gradient.dot(&step) > floor {
                break;
            }
            let mut length = 1.0;
            let mut moved = false;
            for _ in 0..12 {
                let trial = k + step * length;
                let trial_value = at(&trial);
                if trial_value < value {
                    (value, k, moved) = (trial_value, trial, true);
                    break;
                }
                length *= 0.5;
            }
            if !moved || step.norm() * length < 1e-14 * longest {
                break;
            }
        }
        (value, k)
    }

    /// The Newton step, or a step down the gradient where the Hessian is not positive definite.
    fn newton_step(
        &self,
        matrix: &DynamicalMatrix<D>,
        objective: Objective,
        k: &SVector<f64, D>,
        gradient: &SVector<f64, D>,
        longest: f64,
    ) -> SVector<f64, D> {
        let h = 1e-5 * longest;
        let mut hessian = DMatrix::zeros(D, D);
        for a in 0..D {
            let mut shift = SVector::<f64, D>::zeros();
            shift[a] = h;
            let difference = (self.gradient(matrix, objective, &(k + shift))
                - self.gradient(matrix, objective, &(k - shift)))
                / (2.0 * h);
            for b in 0..D {
                hessian[(a, b)] += 0.5 * difference[b];
                hessian[(b, a)] += 0.5 * difference[b];
            }
        }
        let newton = hessian.cholesky().map(|cholesky| {
            let solved = cholesky.solve(&DVector::from_fn(D, |i, _| -gradient[i]));
            SVector::<f64, D>::from_fn(|i, _| solved[i])
        });
        let limit = 0.1 * longest;
        let step = newton
            .filter(|step| step.iter().all(|x| x.is_finite()))
            .unwrap_or_else(|| -gradient * (0.05 * longest / gradient.norm()));
        if step.norm() > limit {
            step * (limit / step.norm())
        } else {
            step
        }
    }

    /// The gradient of the objective: `d lambda = y^T dD x / (y^T x)` with left and right eigenvectors.
    fn gradient(
        &self,
        matrix: &DynamicalMatrix<D>,
        objective: Objective,
        k: &SVector<f64, D>,
    ) -> SVector<f64, D> {
        let d = matrix.at(k);
        let derivatives = matrix.gradient_at(k);
        if objective == Objective::Discriminant {
            return SVector::from_fn(|a, _| {
                let slope = &derivatives[a];
                let half = (d[(0, 0)] - d[(1, 1)]) * 0.5;
                let product = slope[(0, 1)] * d[(1, 0)] + d[(0, 1)] * slope[(1, 0)];
                if D == 2 {
                    (half * (slope[(0, 0)] - slope[(1, 1)]) + product).re
                } else {
                    f64::NAN
                }
            });
        }
        let branch = if objective == Objective::Highest {
            D - 1
        } else {
            0
        };
        let eigenvalue = eigenvalues(&d, matrix.noise())[branch];
        let (right, left) = (
            eigenvector(&d, eigenvalue),
            left_eigenvector(&d, eigenvalue),
        );
        let product = |a: &SVector<Complex, D>, b: &SVector<Complex, D>| {
            a.iter().zip(b.iter()).map(|(a, b)| a * b).sum::<Complex>()
        };
        let norm = product(&left, &right);
        let slope = SVector::<f64, D>::from_fn(|a, _| {
            let image = derivatives[a] * right;
            (product(&left, &image) / norm).re
        });
        match objective {
            Objective::Lowest | Objective::Discriminant => slope,
            Objective::Highest => -slope,
            Objective::Scaled => {
                let laplacian = self.reference.laplacian(k);
                let quotient = eigenvalue.re / laplacian;
                (slope - self.reference.laplacian_gradient(k) * quotient)
                    / (self.speed_squared * laplacian)
            }
        }
    }
}

/// The objectives on a periodic grid over the zone.
struct Grid<const D: usize> {
    resolution: usize,
    points: Vec<GridPoint<D>>,
}

#[derive(Clone, Copy)]
struct GridPoint<const D: usize> {
    /// Reference wave vector.
    k: SVector<f64, D>,
    scaled: f64,
    lowest: f64,
    highest: f64,
    discriminant: f64,
    /// Fastest growth of a mode with complex `omega^2`.
    growth: f64,
}

impl<const D: usize> Grid<D> {
    /// The distinct local minima of the grid, deepest first.
    fn wells(&self, objective: Objective) -> Vec<Candidate<D>> {
        let value = |index: usize| {
            let point = &self.points[index];
            match objective {
                Objective::Scaled => point.scaled,
                Objective::Lowest => point.lowest,
                Objective::Highest => point.highest,
                Objective::Discriminant => point.discriminant,
            }
        };
        let mut wells: Vec<Candidate<D>> = Vec::new();
        for index in 1..self.points.len() {
            let own = value(index);
            // Of k and -k only the first is taken.
            let first = opposite_index::<D>(index, self.resolution) >= index;
            if first && own.is_finite() && self.neighbors(index).all(|other| value(other) >= own) {
                wells.push((own, self.points[index].k));
            }
        }
        wells.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Wells of the same depth are images of each other under the symmetry of the lattice.
        wells.dedup_by(|b, a| (b.0 - a.0).abs() <= 1e-10 * a.0.abs());
        wells
    }

    fn neighbors(&self, index: usize) -> impl Iterator<Item = usize> {
        let n = self.resolution;
        let center = grid_coordinates::<D>(index, n);
        (0..3_usize.pow(D as u32))
            .filter(move |&shift| shift != 3_usize.pow(D as u32) / 2)
            .map(move |shift| {
                let offsets = grid_coordinates::<D>(shift, 3);
                (0..D).fold(0, |sum, i| sum * n + (center[i] + offsets[i] + n - 1) % n)
            })
    }
}

/// The fastest growth among complex eigenvalues.
fn complex_growth(omega_squared: &[Complex]) -> f64 {
    omega_squared
        .iter()
        .filter(|value| value.im != 0.0)
        .map(|value| growth_rate(*value))
        .fold(0.0, f64::max)
}

fn opposite_index<const D: usize>(index: usize, resolution: usize) -> usize {
    grid_coordinates::<D>(index, resolution)
        .into_iter()
        .fold(0, |sum, j| sum * resolution + (resolution - j) % resolution)
}

/// `m^-1/2` of a symmetric positive definite matrix.
fn inverse_square_root<const D: usize>(m: &SMatrix<f64, D, D>) -> SMatrix<f64, D, D> {
    let eigen = DMatrix::from_fn(D, D, |i, j| m[(i, j)]).symmetric_eigen();
    SMatrix::from_fn(|i, j| {
        (0..D)
            .map(|n| {
                let vector = eigen.eigenvectors.column(n);
                vector[i] * vector[j] / eigen.eigenvalues[n].sqrt()
            })
            .sum()
    })
}

/// The minimum of a unimodal function between two arguments.
fn golden_section(f: &impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut a, mut b) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..30 {
        if fa <= fb {
            (high, b, fb) = (b, a, fa);
            a = high - ratio * (high - low);
            fa = f(a);
        } else {
            (low, a, fa) = (a, b, fb);
            b = low + ratio * (high - low);
            fb = f(b);
        }
    }
    0.5 * (low + high)
}

/// Minimization without derivatives along axes and diagonals with a shrinking step.
fn coordinate_search<const D: usize>(
    f: &impl Fn(&SVector<f64, D>) -> f64,
    start: SVector<f64, D>,
    step: f64,
) -> Candidate<D> {
    let (mut value, mut k) = (f(&start), start);
    let mut length = step;
    for _ in 0..200 {
        if length < 1e-7 * step {
            break;
        }
        let better = (0..3_usize.pow(D as u32))
            .map(|shift| {
                let offsets = grid_coordinates::<D>(shift, 3).map(|j| (j as f64 - 1.0) * length);
                k + SVector::from(offsets)
            })
            .map(|trial| (f(&trial), trial))
            .filter(|trial| trial.0 < value)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match better {
            Some(found) => (value, k) = found,
            None => length *= 0.25,
        }
    }
    (value, k)
}
