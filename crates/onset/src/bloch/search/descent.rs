//! Descent from the wells of the grid to their bottoms.

use super::grid::Grid;
use super::{Candidate, LONG_WAVE_FRACTION, Objective, RAY_STEPS, Sample, ZoneSearch};
use crate::algebra::{Complex, Each, array_of, eigenvalues, lowest_between, symmetric_eigen};
use crate::bloch::branches::Taylor;
use crate::bloch::{DynamicalMatrix, growth_rate};
use crate::lattice::grid_coordinates;
use nalgebra::{SMatrix, SVector, Vector2};
use std::convert::Infallible;

/// Maximum number of grid wells that are followed to their bottoms, deepest first.
const FOLLOWED_WELLS: usize = 16;
/// Maximum number of Newton steps to the bottom of a well.
const NEWTON_STEPS: usize = 40;
/// Largest ratio of the smallest to the largest curvature of a valley. A heuristic value.
const VALLEY_CURVATURE_RATIO: f64 = 0.1;
/// Intervals along an edge of a zone that is not periodic; minima along the edge are bracketed by them.
const EDGE_INTERVALS: usize = 24;
/// Tolerance of a minimum along an edge, as a fraction of an interval.
const EDGE_TOLERANCE: f64 = 1e-6;
/// Length of a converged Newton step, relative to the longest reciprocal vector.
const STEP_TOLERANCE: f64 = 1e-9;
/// Smallest determinant of a clearly positive planar curvature, relative to the square of its trace; a heuristic value.
pub(super) const CONVEXITY_RATIO: f64 = 1e-6;

impl<const D: usize> ZoneSearch<D> {
    /// Bottom of the deepest well. The descent in a well whose bottom is not below `floor` ends early.
    pub(super) fn bottom(
        &self,
        matrix: &DynamicalMatrix<D>,
        grid: &Grid<D>,
        objective: Objective,
        floor: f64,
    ) -> Option<Candidate<D>> {
        // On the boundary of a zone that is not periodic, the minimum need not be stationary.
        let boundary = if self.is_periodic {
            Vec::new()
        } else {
            self.boundary_minima(matrix, grid, objective)
        };
        let mut best: Option<Candidate<D>> =
            boundary.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0));
        // Without a smooth discriminant, the growth rate is informative only inside pockets.
        let is_growth = objective == Objective::Discriminant && !matrix.is_centrosymmetric();
        let below = if is_growth { 0.0 } else { f64::INFINITY };
        for well in grid.wells(objective, below).iter().take(FOLLOWED_WELLS) {
            let to_beat = best.map_or(floor, |best| floor.min(best.0));
            // Near the boundary, neighbors on the folded grid are not the actual neighbors.
            if well.start.0 - well.relief <= to_beat || self.is_near_boundary(&well.start.1) {
                self.improve(matrix, objective, well.start, floor, &mut best);
            }
        }
        // Starts on the boundary are needed too: near it the folded grid can hide wells.
        let others = self.long_starts(matrix, grid, objective);
        for start in others.into_iter().chain(boundary) {
            self.improve(matrix, objective, start, floor, &mut best);
        }
        best
    }

    /// Descends from a start if it can still fall below the best value and the floor.
    pub(super) fn improve(
        &self,
        matrix: &DynamicalMatrix<D>,
        objective: Objective,
        start: Candidate<D>,
        floor: f64,
        best: &mut Option<Candidate<D>>,
    ) {
        let to_beat = best.map_or(floor, |best| floor.min(best.0));
        // At the edge of a pocket the growth rate is a square root, so that no parabola predicts its minimum.
        let is_growth = objective == Objective::Discriminant && !matrix.is_centrosymmetric();
        let to_leave = if is_growth { f64::INFINITY } else { to_beat };
        let (value, k) = self.descend(matrix, objective, start, to_leave);
        if !value.is_finite() || value > to_beat {
            return;
        }
        // The descent uses fast sums; near zero only the exact evaluation gives the sign.
        let value = self.value_at(matrix, objective, &k);
        if value.is_finite() && best.is_none_or(|best| value < best.0) {
            *best = Some((value, k));
        }
    }

    /// Starts between the origin and the first grid points, along the softest long wave. A well that opens at the origin covers a small angle, so
    /// that the grid may miss it.
    fn long_starts(
        &self,
        matrix: &DynamicalMatrix<D>,
        grid: &Grid<D>,
        objective: Objective,
    ) -> Vec<Candidate<D>> {
        if !matches!(objective, Objective::Scaled | Objective::Lowest) {
            return Vec::new();
        }
        let at = |steps: f64| {
            let k = grid.soft_direction * (steps * grid.step(self));
            (self.value_at(matrix, objective, &k), k)
        };
        let ray = RAY_STEPS.map(at);
        let first = first_dip(|n| ray[n].0);
        first.map(|n| ray[n]).into_iter().collect()
    }

    /// Returns true if a wave vector belongs to the search: inside the zone if `D` is not periodic.
    pub(super) fn is_admissible(&self, k: &SVector<f64, D>) -> bool {
        self.is_periodic || self.zone().contains(&(self.from_reference * k), 1e-9)
    }

    /// Returns true if a wave vector is close to the boundary of a zone that is not periodic.
    fn is_near_boundary(&self, k: &SVector<f64, D>) -> bool {
        !self.is_periodic && !self.zone().contains(&(self.from_reference * k * 1.08), 0.0)
    }

    /// Minima along the boundary of the zone, for matrices that are not periodic.
    fn boundary_minima(
        &self,
        matrix: &DynamicalMatrix<D>,
        grid: &Grid<D>,
        objective: Objective,
    ) -> Vec<Candidate<D>> {
        let corners = self.zone().corners();
        let at = |k: &SVector<f64, D>| {
            let k = self.to_reference * k;
            (self.value_at(matrix, objective, &k), k)
        };
        let mut minima: Vec<Candidate<D>> = corners.iter().map(at).collect();
        if D == 3 {
            let faces = self.zone().faces();
            minima.extend(faces.iter().map(|face| minimum_on_face(face, &at)));
        }
        let edges = grid.edges.get_or_init(|| self.edges(matrix));
        let value = |sample: &Sample<D>| self.value(matrix, objective, sample);
        let mut dips = Vec::new();
        for edge in edges {
            let values: Vec<f64> = edge.iter().map(value).collect();
            let is_dip = |n: &usize| values[*n] <= values[n - 1] && values[*n] <= values[n + 1];
            dips.extend(
                (1..EDGE_INTERVALS)
                    .filter(is_dip)
                    .map(|n| (values[n], edge, n)),
            );
        }
        for (value, edge, n) in dips {
            let (from, to) = (edge[0].wave_vector, edge[EDGE_INTERVALS].wave_vector);
            let along = |t: f64| from + (to - from) * (t / EDGE_INTERVALS as f64);
            let at = |t: f64| Ok::<f64, Infallible>(self.value_at(matrix, objective, &along(t)));
            let around = [-1.0, 0.0, 1.0].map(|step| n as f64 + step);
            let Ok((t, value)) = lowest_between(at, around, value, EDGE_TOLERANCE);
            minima.push((value, along(t)));
        }
        minima
    }

    /// Spectra along the edges of the zone in the plane, on one edge of each opposite pair; empty in one and three dimensions.
    fn edges(&self, matrix: &DynamicalMatrix<D>) -> Vec<Vec<Sample<D>>> {
        if D != 2 {
            return Vec::new();
        }
        let corners = self.zone().corners();
        let count = corners.len();
        let edge = |n: usize| {
            let [from, to] = [n, (n + 1) % count].map(|n| self.to_reference * corners[n]);
            let along = |n: usize| from + (to - from) * (n as f64 / EDGE_INTERVALS as f64);
            (0..=EDGE_INTERVALS)
                .map(|n| Sample::of(matrix, along(n)))
                .collect()
        };
        (0..count.div_ceil(2)).map(edge).collect()
    }

    /// Follows a well to its bottom.
    ///
    /// Newton's method with exact derivatives and a line search; where the objective is not smooth, at a crossing of two branches, a coordinate
    /// search follows.
    fn descend(
        &self,
        matrix: &DynamicalMatrix<D>,
        objective: Objective,
        start: Candidate<D>,
        floor: f64,
    ) -> Candidate<D> {
        let longest = self.longest();
        let at = |k: &SVector<f64, D>| {
            if self.is_sought(objective, k) {
                self.value_at(matrix, objective, k)
            } else {
                f64::INFINITY
            }
        };
        let (mut value, mut k) = start;
        for _ in 0..16 {
            let expansion = |k: &SVector<f64, D>| {
                self.is_sought(objective, k)
                    .then(|| self.expansion(matrix, objective, k))
            };
            let (bottom, settled) = self.newton(&expansion, (value, k), floor);
            (value, k) = bottom;
            if value > floor {
                return (value, k);
            }
            // The bottom may lie on the boundary of a zone that is not periodic: a coordinate search is needed there.
            if settled && !self.is_near_boundary(&k) {
                match self.lower_in_valley(&expansion, &at, (value, k)) {
                    Some(lower) => (value, k) = lower,
                    None => return (value, k),
                }
                continue;
            }
            let around = coordinate_search(&at, k, 1e-2 * longest);
            if around.0 >= value - 1e-12 * value.abs() {
                return if around.0 < value { around } else { (value, k) };
            }
            (value, k) = around;
        }
        (value, k)
    }

    /// Lower bottom along a shallow valley. Such a valley can have several bottoms within a few grid steps, and the grid resolves only one.
    fn lower_in_valley(
        &self,
        expansion: &impl Fn(&SVector<f64, D>) -> Option<Taylor<f64, D>>,
        at: &impl Fn(&SVector<f64, D>) -> f64,
        (value, k): Candidate<D>,
    ) -> Option<Candidate<D>> {
        let (values, axes) = principal(&expansion(&k)?.curvature());
        let order = |a: &usize, b: &usize| values[*a].abs().total_cmp(&values[*b].abs());
        let softest = (0..D).min_by(order)?;
        let stiffest = (0..D).max_by(order)?;
        if D == 1 || values[softest].abs() > VALLEY_CURVATURE_RATIO * values[stiffest].abs() {
            return None;
        }
        let step = 0.08 * self.longest();
        [-step, step]
            .each(|step| k + axes[softest] * step)
            .each(|k| self.newton(expansion, (at(&k), k), f64::INFINITY).0)
            .into_iter()
            .filter(|(there, _)| *there < value - 1e-9 * value.abs())
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// End of the descent from a wave vector; a descent that cannot fall below `floor` ends early.
    pub(super) fn settled(
        &self,
        matrix: &DynamicalMatrix<D>,
        objective: Objective,
        start: SVector<f64, D>,
        floor: f64,
    ) -> SVector<f64, D> {
        let value = self.value_at(matrix, objective, &start);
        self.descend(matrix, objective, (value, start), floor).1
    }

    /// Returns true if the objective is evaluated at a wave vector. Long waves are represented by their limit, and wave vectors outside a zone that
    /// is not periodic are excluded.
    pub(in crate::bloch) fn is_sought(&self, objective: Objective, k: &SVector<f64, D>) -> bool {
        let too_long =
            objective == Objective::Scaled && k.norm() < LONG_WAVE_FRACTION * self.longest();
        !too_long && self.is_admissible(k)
    }

    /// Returns true if a wave number is below a fraction of the shortest reciprocal vector.
    pub(in crate::bloch) fn is_longer(&self, k: &SVector<f64, D>, fraction: f64) -> bool {
        let lattice = self.reference();
        let lengths = lattice.reciprocal().column_iter().map(|b| b.norm());
        let shortest = lengths.fold(f64::INFINITY, f64::min);
        lattice.laplacian(k) < (fraction * shortest).powi(2)
    }

    fn longest(&self) -> f64 {
        let reciprocal = self.reference().reciprocal();
        reciprocal
            .column_iter()
            .map(|b| b.norm())
            .fold(0.0, f64::max)
    }

    /// Newton's method on a function of the wave vector, which is `None` outside its domain.
    ///
    /// The flag is true if the method ended in a smooth minimum, or is converging to a minimum above `floor`.
    pub(in crate::bloch) fn newton(
        &self,
        expansion: &impl Fn(&SVector<f64, D>) -> Option<Taylor<f64, D>>,
        start: Candidate<D>,
        floor: f64,
    ) -> (Candidate<D>, bool) {
        let mut descent = Descent::new(start, floor, self.longest());
        while descent.is_settled.is_none() {
            descent.take(expansion(&descent.trial));
        }
        (descent.place, descent.is_settled == Some(true))
    }

    /// Like `newton`, for several functions, which are evaluated together.
    pub(in crate::bloch) fn newton_together<N: Copy>(
        &self,
        expansions: &impl Fn(&[(N, SVector<f64, D>)]) -> Vec<Option<Taylor<f64, D>>>,
        starts: &[(N, Candidate<D>)],
        floor: f64,
    ) -> Vec<(Candidate<D>, bool)> {
        let longest = self.longest();
        let begin = |(own, start): &(N, Candidate<D>)| (*own, Descent::new(*start, floor, longest));
        let mut all: Vec<(N, Descent<D>)> = starts.iter().map(begin).collect();
        loop {
            let mut active: Vec<&mut (N, Descent<D>)> = all
                .iter_mut()
                .filter(|(_, descent)| descent.is_settled.is_none())
                .collect();
            if active.is_empty() {
                break;
            }
            let trials = active.iter().map(|(own, descent)| (*own, descent.trial));
            let there = expansions(&trials.collect::<Vec<_>>());
            for (own, there) in active.iter_mut().zip(there) {
                own.1.take(there);
            }
        }
        let end = |(_, descent): (N, Descent<D>)| (descent.place, descent.is_settled == Some(true));
        all.into_iter().map(end).collect()
    }

    /// Objective with its derivatives.
    fn expansion(
        &self,
        matrix: &DynamicalMatrix<D>,
        objective: Objective,
        k: &SVector<f64, D>,
    ) -> Taylor<f64, D> {
        if D == 3 {
            return self.spatial_expansion(matrix, objective, k);
        }
        let real = matrix.planar_expansion(k);
        if let Some(expansion) = real.filter(|_| objective != Objective::Growth) {
            return match objective {
                Objective::Highest => expansion.branch(1.0).map(|x| -x),
                Objective::Discriminant => expansion.discriminant(),
                Objective::Scaled => self.scaled(&expansion.branch(-1.0), k),
                _ => expansion.branch(-1.0),
            };
        }
        let expansion = matrix.expansion_at(k);
        match objective {
            Objective::Lowest => expansion.branch(-1.0),
            Objective::Highest => expansion.branch(1.0).map(|x| -x),
            Objective::Discriminant | Objective::Growth => expansion.growth().map(|x| -x),
            Objective::Scaled => self.scaled(&expansion.branch(-1.0), k),
        }
    }

    /// Quotient of a branch and `c^2 |k|_h^2`, with derivatives.
    pub(in crate::bloch) fn scaled(
        &self,
        branch: &Taylor<f64, D>,
        k: &SVector<f64, D>,
    ) -> Taylor<f64, D> {
        let (lattice, c2) = (self.reference(), self.speed_squared);
        let gradient = lattice.laplacian_gradient(k) * c2;
        let hessian = lattice.laplacian_hessian(k) * c2;
        branch.over(&Taylor {
            value: c2 * lattice.laplacian(k),
            gradient: array_of(|a| gradient[a]),
            hessian: array_of(|a| array_of(|b| hessian[(a, b)])),
        })
    }

    /// Objective with its derivatives in three dimensions, by the branch through the eigenvalue.
    fn spatial_expansion(
        &self,
        matrix: &DynamicalMatrix<D>,
        objective: Objective,
        k: &SVector<f64, D>,
    ) -> Taylor<f64, D> {
        let real = matrix.real_expansion_at::<2>(k);
        let is_discriminant = objective == Objective::Discriminant;
        if let Some(real) = real.filter(|_| is_discriminant) {
            return real.spatial_discriminant();
        }
        let whole = || match &real {
            Some(real) => real.complex(),
            None => matrix.expansion_at(k),
        };
        let value = match &real {
            Some(real) => real.value.map(|entry| Complex::new(entry, 0.0)),
            None => matrix.at(k),
        };
        let eigenvalues = eigenvalues(&value, matrix.noise());
        let growing = eigenvalues.iter().filter(|value| value.im != 0.0);
        let chosen = match objective {
            Objective::Highest => Some(&eigenvalues[D - 1]),
            Objective::Lowest | Objective::Scaled => Some(&eigenvalues[0]),
            Objective::Growth | Objective::Discriminant => {
                growing.max_by(|a, b| growth_rate(**a).total_cmp(&growth_rate(**b)))
            }
        };
        let Some(chosen) = chosen else {
            // No mode grows here, and the gradient of the growth rate is unknown.
            return Taylor {
                value: 0.0,
                gradient: [f64::NAN; D],
                hessian: [[f64::NAN; D]; D],
            };
        };
        if matches!(objective, Objective::Growth | Objective::Discriminant) {
            return whole().branch_through(*chosen).growth().map(|x| -x);
        }
        let branch = match &real {
            Some(real) if chosen.im == 0.0 => real.branch_through(chosen.re),
            _ => whole().branch_through(*chosen).map(|x| x.re),
        };
        match objective {
            Objective::Highest => branch.map(|x| -x),
            Objective::Scaled => self.scaled(&branch, k),
            _ => branch,
        }
    }
}

/// A descent by Newton's method.
struct Descent<const D: usize> {
    /// Lowest known value, with its wave vector.
    place: Candidate<D>,
    /// Wave vector at which the function is needed next.
    trial: SVector<f64, D>,
    /// Step from the lowest place, the fraction of it that is tried, and the linear decrease along it; `None` before the function is known at the start.
    step: Option<(SVector<f64, D>, f64, f64)>,
    is_convex: bool,
    steps: usize,
    /// Set at the end: true in a smooth minimum, or on the way to a minimum above `floor`.
    is_settled: Option<bool>,
    floor: f64,
    /// Length of the longest reciprocal vector.
    longest: f64,
}

impl<const D: usize> Descent<D> {
    fn new(start: Candidate<D>, floor: f64, longest: f64) -> Self {
        Self {
            place: start,
            trial: start.1,
            step: None,
            is_convex: false,
            steps: 0,
            is_settled: None,
            floor,
            longest,
        }
    }

    /// Takes the function at the trial, and plans the next one.
    #[inline]
    fn take(&mut self, there: Option<Taylor<f64, D>>) {
        let Some((step, length, decrease)) = self.step else {
            match there {
                Some(local) => self.plan(&local),
                None => self.is_settled = Some(false),
            }
            return;
        };
        if let Some(local) = there.filter(|there| there.value < self.place.0) {
            self.place = (local.value, self.trial);
            self.plan(&local);
            return;
        }
        let length = 0.25 * length;
        if length < 1e-4 {
            // The remaining decrease may be below rounding.
            self.is_settled = Some(self.is_convex && decrease <= 1e-12 * self.place.0.abs());
        } else {
            self.step = Some((step, length, decrease));
            self.trial = self.place.1 + step * length;
        }
    }

    /// Plans a step from the lowest place, where the function is `local`.
    #[inline]
    fn plan(&mut self, local: &Taylor<f64, D>) {
        let (slope, curvature) = (local.slope(), local.curvature());
        let is_smooth = slope.iter().chain(curvature.iter()).all(|x| x.is_finite());
        if !is_smooth || self.steps == NEWTON_STEPS {
            self.is_settled = Some(false);
            return;
        }
        self.steps += 1;
        let (step, is_convex) = newton_step(&slope, &curvature, self.longest);
        let decrease = -slope.dot(&step);
        let value = self.place.0;
        // Quadratic convergence: the next step gains less than rounding.
        let gains_nothing =
            step.norm() < STEP_TOLERANCE * self.longest || decrease <= 1e-13 * value.abs();
        // A quadratic well falls by half of the linear decrease; eight times this amount is a safe limit.
        if is_convex && (gains_nothing || value - 4.0 * decrease > self.floor) {
            self.is_settled = Some(true);
            return;
        }
        self.is_convex = is_convex;
        self.step = Some((step, 1.0, decrease));
        self.trial = self.place.1 + step;
    }
}

/// Newton step, at most a tenth of `longest`, and whether the curvature is positive.
///
/// Negative principal curvatures are replaced by their magnitudes, so that it is a descent step. At a saddle it follows the direction of negative
/// curvature.
pub(super) fn newton_step<const D: usize>(
    slope: &SVector<f64, D>,
    curvature: &SMatrix<f64, D, D>,
    longest: f64,
) -> (SVector<f64, D>, bool) {
    let limit = 0.1 * longest;
    if let Some(step) = planar_step(slope, curvature, limit) {
        return (step, true);
    }
    let (values, axes) = principal(curvature);
    let largest = values.iter().map(|value| value.abs()).fold(0.0, f64::max);
    let is_convex = values.iter().all(|value| *value > 1e-12 * largest);
    let mut step = SVector::<f64, D>::zeros();
    for (value, axis) in values.iter().zip(&axes) {
        let along = axis.dot(slope);
        let size = value.abs().max(1e-12 * largest);
        // On the crest the slope vanishes: a step of full length to one side.
        let length = if *value < 0.0 && along.abs() < 1e-3 * limit * size {
            limit * if along > 0.0 { -1.0 } else { 1.0 }
        } else {
            -along / size
        };
        step += axis * length;
    }
    let norm = step.norm();
    if !norm.is_finite() || largest == 0.0 {
        (-slope * (limit / slope.norm()), false)
    } else {
        (
            if norm > limit {
                step * (limit / norm)
            } else {
                step
            },
            is_convex,
        )
    }
}

/// Newton step in the plane if the curvature is clearly positive: by Cramer's rule, much faster than by principal axes.
#[inline]
fn planar_step<const D: usize>(
    slope: &SVector<f64, D>,
    curvature: &SMatrix<f64, D, D>,
    limit: f64,
) -> Option<SVector<f64, D>> {
    if D != 2 {
        return None;
    }
    let [a, b, c] = [curvature[(0, 0)], curvature[(0, 1)], curvature[(1, 1)]];
    let (trace, determinant) = (a + c, a * c - b * b);
    let is_certain = trace > 0.0 && determinant > CONVEXITY_RATIO * trace * trace;
    if !is_certain {
        return None;
    }
    let mut step = [
        (b * slope[1] - c * slope[0]) / determinant,
        (b * slope[0] - a * slope[1]) / determinant,
    ];
    let norm = (step[0] * step[0] + step[1] * step[1]).sqrt();
    if !norm.is_finite() {
        return None;
    }
    if norm > limit {
        step = step.each(|x| x * (limit / norm));
    }
    Some(SVector::from_fn(|i, _| step[i]))
}

/// Principal values and axes of a symmetric matrix with up to three rows.
pub(super) fn principal<const D: usize>(
    m: &SMatrix<f64, D, D>,
) -> ([f64; D], [SVector<f64, D>; D]) {
    let mut values: [f64; D] = array_of(|i| m[(i, i)]);
    let mut axes: [SVector<f64, D>; D] =
        array_of(|i| SVector::from_fn(|j, _| f64::from(u8::from(i == j))));
    if D == 3 && m.iter().all(|entry| entry.is_finite()) {
        let rows: [[f64; 3]; 3] = array_of(|i| array_of(|j| m[(i, j)]));
        let (known, vectors) = symmetric_eigen(&rows);
        values = array_of(|n| known[n]);
        axes = array_of(|n| SVector::from_fn(|i, _| vectors[n][i]));
    }
    if D == 2 && m[(0, 1)] != 0.0 {
        let (mean, half) = (0.5 * (m[(0, 0)] + m[(1, 1)]), 0.5 * (m[(0, 0)] - m[(1, 1)]));
        let radius = (half * half + m[(0, 1)] * m[(0, 1)]).sqrt();
        // Eigenvector of the larger eigenvalue; of its two forms the one without cancellation.
        let (x, y) = if half > 0.0 {
            (half + radius, m[(0, 1)])
        } else {
            (m[(0, 1)], radius - half)
        };
        let length = (x * x + y * y).sqrt();
        values = array_of(|i| if i == 0 { mean + radius } else { mean - radius });
        axes[0] = SVector::from_fn(|i, _| [x, y][i] / length);
        axes[1] = SVector::from_fn(|i, _| [-y, x][i] / length);
    }
    (values, axes)
}

/// Point of [`RAY_STEPS`] at which a descent starts: the first local minimum, or the last point of a branch that falls below zero along the whole
/// ray. Branches that fall beyond the ray are covered by the grid.
pub(super) fn first_dip(value: impl Fn(usize) -> f64) -> Option<usize> {
    let last = RAY_STEPS.len() - 1;
    let rises = |n: usize| match n == last {
        true => value(n) < 0.0,
        false => value(n + 1) >= value(n),
    };
    (0..=last).find(|n| (*n == 0 || value(*n - 1) >= value(*n)) && rises(*n))
}

/// Minimum of a function on a convex face in three dimensions, given by its corners in order. The search along the face starts at the lowest of the
/// points between center and rim.
fn minimum_on_face<const D: usize>(
    corners: &[SVector<f64, D>],
    at: &impl Fn(&SVector<f64, D>) -> Candidate<D>,
) -> Candidate<D> {
    /// Number of rings of points between the center and the rim.
    const RINGS: usize = 6;
    let count = corners.len();
    let middle: SVector<f64, D> = corners.iter().sum::<SVector<f64, D>>() / count.max(1) as f64;
    // In each sector: weights of the center, of a corner and of the next corner.
    let place = |sector: usize, weights: &Vector2<f64>| {
        let (next, rim) = (weights[0], weights[1]);
        let (from, to) = (corners[sector], corners[(sector + 1) % count]);
        middle + ((from - middle) * (1.0 - next) + (to - middle) * next) * rim
    };
    let mut best = (at(&middle).0, 0, Vector2::zeros());
    for sector in 0..count {
        for ring in 1..=RINGS {
            for step in 0..ring {
                let weights = Vector2::new(step as f64 / ring as f64, ring as f64 / RINGS as f64);
                let value = at(&place(sector, &weights)).0;
                if value < best.0 {
                    best = (value, sector, weights);
                }
            }
        }
    }
    let (_, sector, weights) = best;
    let along = |weights: &Vector2<f64>| {
        if weights.iter().all(|x| (0.0..=1.0).contains(x)) {
            at(&place(sector, weights)).0
        } else {
            f64::INFINITY
        }
    };
    let (_, weights) = coordinate_search(&along, weights, 0.5 / RINGS as f64);
    at(&place(sector, &weights))
}

/// Minimization without derivatives along axes and diagonals, with a shrinking step.
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
        let count = 3_usize.pow(D as u32);
        // The middle shift moves nothing.
        let better = (0..count)
            .filter(|shift| 2 * shift + 1 != count)
            .map(|shift| {
                let offsets = grid_coordinates::<D>(shift, 3).each(|j| (j as f64 - 1.0) * length);
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
