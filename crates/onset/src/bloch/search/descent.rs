//! From the wells of the grid to their bottoms.

use super::grid::Grid;
use super::{Candidate, Objective, ZoneSearch};
use crate::algebra::{Complex, eigenvalues, eigenvector, left_eigenvector};
use crate::bloch::DynamicalMatrix;
use crate::bloch::dynamical_matrix::grid_coordinates;
use nalgebra::{DMatrix, DVector, SVector};

/// Distinct wells of the grid that are followed to their bottom, deepest first.
const WELLS: usize = 16;
/// Below this fraction of the zone a wave vector counts as a long wave, which the limit covers.
const LONG_WAVE: f64 = 1e-3;

impl<const D: usize> ZoneSearch<D> {
    /// The bottom of the deepest well. A well that is not going to reach below `floor` is left early.
    pub(super) fn bottom(
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
    pub(super) fn is_admissible(&self, k: &SVector<f64, D>) -> bool {
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
pub(super) fn coordinate_search<const D: usize>(
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
