//! Least squares under linearized constraints, by Gauss and Newton's method with damping.
//!
//! Each step solves `min |J s + r|^2 + damping |s|^2` subject to `G s >= g`. With `J = Q R` and `y = R s` the quadratic program has the identity as
//! its matrix, so that it is as well conditioned as the least-squares problem allows. For a law that is linear in its constants the first step without
//! damping is the optimum.

use crate::family::Family;
use crate::moduli::{Criterion, Perturbation};
use crate::range::Worst;
use crate::tests_of_specimens::Equations;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DMatrix, DVector};
use onset::cancel::checkpoint;
use onset::real::Dual;
use rayon::prelude::*;

/// Constraint that a form of the law is not below a margin: `q(state, perturbation) >= margin q(reference)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cut {
    pub criterion: Criterion,
    pub logs: [f64; 3],
    pub perturbation: Perturbation,
}

impl From<Worst> for Cut {
    fn from(worst: Worst) -> Self {
        Self {
            criterion: worst.criterion,
            logs: worst.logs,
            perturbation: worst.perturbation,
        }
    }
}

/// Least-squares problem with stability constraints.
pub(crate) struct Problem<'a> {
    pub family: &'a Family,
    pub equations: &'a Equations,
    pub cuts: &'a [Cut],
    pub margin: f64,
    /// Bounds of the constants. Fixed constants have equal bounds.
    pub bounds: &'a [[f64; 2]],
    /// Gradients of the constraints of a linear law ([`Problem::gradients`]), which do not depend on the constants; empty for other laws.
    pub gradients: &'a [DVector<f64>],
    /// Limits of the iteration.
    pub limits: Limits,
}

/// Limits of the iteration of one solve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Largest number of steps.
    pub steps: usize,
    /// The iteration ends if the sum of squares decreases by less than this fraction.
    pub gain: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            steps: MOST_STEPS,
            gain: LEAST_GAIN,
        }
    }
}

/// Constants with the sum of squares.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    pub constants: Vec<f64>,
    pub loss: f64,
    /// Gradients, with respect to the constants, of the stability constraints that may hold with equality.
    pub active: Vec<DVector<f64>>,
    /// Number of steps of the iteration.
    pub steps: usize,
}

/// Largest number of steps of one solve.
const MOST_STEPS: usize = 200;
/// The iteration ends with a step that lowers the sum of squares by less than this fraction.
const LEAST_GAIN: f64 = 1e-13;
/// Largest violation of a constraint of a linear law, and largest sum of violations of other laws, relative to the constants.
const MOST_VIOLATED: f64 = 1e-6;
/// Constraints with smaller values, relative to the sum of the magnitudes of their terms, count as equalities.
const ACTIVE: f64 = 1e-6;
/// Smallest number of constraints for which another thread is worthwhile.
const DEMANDS_OF_A_THREAD: usize = 64;
/// Weight of a violated constraint, relative to the sum of squares at the start.
const PENALTY: f64 = 10.0;

impl Problem<'_> {
    /// Values of the constraints with their derivatives, scaled by the size of the gradient.
    fn demands(&self, constants: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let rows: Vec<(f64, DVector<f64>)> = match self.gradients.is_empty() {
            true => self.rows(constants),
            false => {
                let constants = DVector::from_column_slice(constants);
                let gradients = self.gradients.iter();
                gradients
                    .map(|own| (own.dot(&constants), own.clone()))
                    .collect()
            }
        };
        let values = DVector::from_fn(rows.len(), |n, _| rows[n].0);
        let slopes = DMatrix::from_fn(rows.len(), constants.len(), |n, c| rows[n].1[c]);
        (values, slopes)
    }

    /// Gradients of the constraints of a linear law, of norm 1.
    pub fn gradients(&self) -> Vec<DVector<f64>> {
        let rows = self.rows(&vec![1.0; self.bounds.len()]);
        rows.into_iter().map(|(_, gradient)| gradient).collect()
    }

    /// Value and gradient of each constraint, divided by the norm of the gradient.
    fn rows(&self, constants: &[f64]) -> Vec<(f64, DVector<f64>)> {
        let terms = self.family.terms();
        let shear = |term| Family::moduli_of(term, constants, [0.0; 3]).shear_modulus();
        let shears: Vec<Dual<2>> = terms.iter().map(shear).collect();
        let row = |cut: &Cut| {
            let mut value = 0.0;
            let mut slope = DVector::<f64>::zeros(constants.len());
            let least = self.margin * cut.criterion.reference(1.0);
            for (term, shear) in terms.iter().zip(&shears) {
                let moduli = Family::moduli_of(term, constants, cut.logs);
                let form = moduli.form(&cut.perturbation) - *shear * least;
                let modulus = constants[term.modulus];
                value += modulus * form.value;
                slope[term.modulus] += form.value;
                for (n, index) in term.shapes.iter().enumerate() {
                    slope[*index] += modulus * form.gradient[n];
                }
            }
            let size = slope.norm().max(f64::MIN_POSITIVE);
            (value / size, slope / size)
        };
        let all = self.cuts.par_iter().with_min_len(DEMANDS_OF_A_THREAD);
        all.map(row).collect()
    }

    /// Solution from a first guess; `None` if no constants satisfy the constraints, or the law is not defined at the guess.
    pub fn solve(&self, start: &[f64]) -> Option<Solution> {
        let mut constants = start.to_vec();
        self.confine(&mut constants);
        let is_free: Vec<bool> = self.bounds.iter().map(|[low, high]| low < high).collect();
        if self.family.is_linear() {
            let start = self.equations.errors(self.family, &constants);
            let mut found = self.of_moduli(&constants, start, &is_free)?;
            found.active = self.active(&found.constants);
            let most = self.violations(&found.constants).into_iter();
            return (most.fold(0.0, f64::max) < MOST_VIOLATED).then_some(found);
        }
        // If no moduli satisfy the constraints with these exponents, the exponents change from moduli that violate them.
        let unconstrained = Problem { cuts: &[], ..*self };
        let terms = self.equations.terms(self.family, &constants);
        let at = |constants: &[f64]| self.equations.errors_of(self.family, &terms, constants);
        constants = self
            .of_moduli(&constants, at(&constants), &is_free)
            .or_else(|| unconstrained.of_moduli(&constants, at(&constants), &is_free))?
            .constants;
        let (mut errors, mut jacobian) = at(&constants);
        let mut violated = self.violation(&constants);
        let mut loss = errors.norm_squared();
        let unit = loss.max(f64::MIN_POSITIVE);
        let merit = |loss: f64, violated: f64| loss + PENALTY * unit * violated;
        let mut damping = 1e-3;
        let mut idle = 0;
        let mut steps = 0;
        for _ in 0..self.limits.steps {
            checkpoint();
            steps += 1;
            let (values, slopes) = self.demands(&constants);
            let step = self.step(
                &errors,
                &jacobian,
                (&values, &slopes),
                &constants,
                damping,
                &is_free,
            );
            let Some(step) = step else {
                damping *= 10.0;
                if damping > 1e8 {
                    break;
                }
                continue;
            };
            let mut trial: Vec<f64> = constants
                .iter()
                .zip(step.iter())
                .map(|(x, s)| x + s)
                .collect();
            self.confine(&mut trial);
            // The moduli follow from the other constants.
            let terms = self.equations.terms(self.family, &trial);
            let at = |constants: &[f64]| self.equations.errors_of(self.family, &terms, constants);
            let there = at(&trial);
            if let Some(better) = self.of_moduli(&trial, there, &is_free) {
                trial = better.constants;
            }
            let (new_errors, new_jacobian) = at(&trial);
            let new_loss = new_errors.norm_squared();
            let new_violated = self.violation(&trial);
            let gain = merit(loss, violated) - merit(new_loss, new_violated);
            if gain > 0.0 {
                let part = gain / merit(loss, violated);
                (constants, errors, jacobian) = (trial, new_errors, new_jacobian);
                (loss, violated) = (new_loss, new_violated);
                damping = (damping * 0.2).max(1e-15);
                idle = if part < self.limits.gain { idle + 1 } else { 0 };
            } else {
                damping *= 8.0;
                idle += usize::from(damping > 1e3);
            }
            if idle > 2 || damping > 1e8 {
                break;
            }
        }
        (loss.is_finite() && violated < MOST_VIOLATED).then(|| Solution {
            active: self.active(&constants),
            constants,
            loss,
            steps,
        })
    }

    /// Gradients of the constraints that may hold with equality.
    pub fn active(&self, constants: &[f64]) -> Vec<DVector<f64>> {
        let (values, slopes) = self.demands(constants);
        let size = |n: &usize| {
            let terms = slopes.row(*n).into_iter().zip(constants);
            terms
                .map(|(slope, constant)| (slope * constant).abs())
                .sum::<f64>()
        };
        let active = (0..values.len()).filter(|n| values[*n] <= ACTIVE * size(n));
        active.map(|n| slopes.row(n).transpose()).collect()
    }

    /// Violations of the constraints, relative to the constants.
    fn violations(&self, constants: &[f64]) -> Vec<f64> {
        let (values, _) = self.demands(constants);
        let scale = constants.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let violations = values.iter().map(|value| (-value / scale).max(0.0));
        violations.collect()
    }

    fn violation(&self, constants: &[f64]) -> f64 {
        self.violations(constants).iter().sum()
    }

    fn confine(&self, constants: &mut [f64]) {
        self.family.admissible(constants, self.bounds);
        for (value, [low, high]) in constants.iter_mut().zip(self.bounds) {
            *value = value.clamp(*low, *high);
        }
    }

    /// Optimal moduli for given values of the other constants, from the errors and their derivatives there.
    fn of_moduli(
        &self,
        constants: &[f64],
        (mut errors, jacobian): (DVector<f64>, DMatrix<f64>),
        is_free: &[bool],
    ) -> Option<Solution> {
        let constants_of_law = self.family.constants().iter();
        let is_modulus: Vec<bool> = constants_of_law.map(|own| own.is_modulus).collect();
        let rest = self.equations.at_rest();
        let free: Vec<bool> = is_modulus
            .iter()
            .zip(is_free)
            .map(|(own, free)| *own && *free)
            .collect();
        if !jacobian
            .iter()
            .chain(errors.iter())
            .all(|own| own.is_finite())
        {
            return None;
        }
        let mut found = constants.to_vec();
        // A second step removes the rounding of the first one.
        for pass in 0..2 {
            let (values, slopes) = self.demands(&found);
            let Some(step) = self.step(&errors, &jacobian, (&values, &slopes), &found, 0.0, &free)
            else {
                if pass == 0 {
                    return None;
                }
                break;
            };
            for (x, s) in found.iter_mut().zip(step.iter()) {
                *x += s;
            }
            // The errors are linear in the moduli; the terms need not be evaluated again.
            errors.copy_from(&rest);
            for (n, value) in found.iter().enumerate().filter(|(n, _)| is_modulus[*n]) {
                errors.axpy(*value, &jacobian.column(n), 1.0);
            }
        }
        Some(Solution {
            loss: errors.norm_squared(),
            constants: found,
            active: Vec::new(),
            steps: 1,
        })
    }

    /// One step of the method in the free constants.
    fn step(
        &self,
        errors: &DVector<f64>,
        jacobian: &DMatrix<f64>,
        (values, slopes): (&DVector<f64>, &DMatrix<f64>),
        constants: &[f64],
        damping: f64,
        is_free: &[bool],
    ) -> Option<DVector<f64>> {
        let free: Vec<usize> = (0..constants.len()).filter(|n| is_free[*n]).collect();
        if free.is_empty() {
            return Some(DVector::zeros(constants.len()));
        }
        let (rows, columns) = (errors.len(), free.len());
        let sizes: Vec<f64> = free
            .iter()
            .map(|n| jacobian.column(*n).norm().max(1e-150))
            .collect();
        let extra = if damping > 0.0 { columns } else { 0 };
        let matrix = DMatrix::from_fn(rows + extra, columns, |i, j| match i < rows {
            true => jacobian[(i, free[j])] / sizes[j],
            false => f64::from(u8::from(i - rows == j)) * damping.sqrt(),
        });
        let mut right = DVector::zeros(rows + extra);
        right.rows_mut(0, rows).copy_from(&(-errors));
        if matrix.nrows() < columns {
            return None;
        }
        let qr = matrix.qr();
        let upper = qr.r();
        let target = qr.q().transpose() * right;
        if (0..columns).any(|n| upper[(n, n)].abs() < 1e-14) {
            return None;
        }
        // Conditions on the scaled step: constraints, and bounds of the constants.
        let mut conditions: Vec<(DVector<f64>, f64)> = Vec::new();
        for row in 0..values.len() {
            let slope = DVector::from_fn(columns, |j, _| slopes[(row, free[j])] / sizes[j]);
            conditions.push((slope, -values[row]));
        }
        for (j, n) in free.iter().enumerate() {
            let unit = |sign: f64| {
                DVector::from_fn(columns, |i, _| if i == j { sign / sizes[j] } else { 0.0 })
            };
            let [low, high] = self.bounds[*n];
            if low.is_finite() {
                conditions.push((unit(1.0), low - constants[*n]));
            }
            if high.is_finite() {
                conditions.push((unit(-1.0), constants[*n] - high));
            }
        }
        let free_step = upper.solve_upper_triangular(&target)?;
        let holds = |step: &DVector<f64>| {
            conditions
                .iter()
                .all(|(slope, bound)| slope.dot(step) >= *bound)
        };
        let scaled = match holds(&free_step) {
            true => free_step,
            false => upper.solve_upper_triangular(&nearest(&upper, &target, &conditions)?)?,
        };
        let mut step = DVector::zeros(constants.len());
        for (j, n) in free.iter().enumerate() {
            step[*n] = scaled[j] / sizes[j];
        }
        Some(step)
    }
}

/// Largest number of quadratic programs in one step, number of constraints added to each, and admitted violation of the remaining constraints, as a
/// fraction of the unit.
const MOST_PROGRAMS: usize = 100;
const ADDED_CONDITIONS: usize = 12;
const CONDITION_TOLERANCE: f64 = 1e-12;

/// Returns true if no constants have positive values of all constraints, given by their gradients, and a positive shear modulus, given by its gradient.
///
/// The values are linear in the constants, so that the admissible constants form a cone. Its point nearest to the gradient of the shear modulus is the
/// origin if and only if the shear modulus is nowhere positive in the cone.
pub(crate) fn is_empty(shear: &DVector<f64>, gradients: &[DVector<f64>]) -> bool {
    let Some(target) = shear.clone().try_normalize(0.0) else {
        return false;
    };
    let conditions: Vec<(DVector<f64>, f64)> =
        gradients.iter().map(|own| (own.clone(), 0.0)).collect();
    let unit = DMatrix::identity(target.len(), target.len());
    nearest(&unit, &target, &conditions).is_some_and(|own| own.norm() < EMPTY)
}

/// Largest norm of a point that is the origin except for rounding.
const EMPTY: f64 = 1e-7;

/// Point `y` nearest to `target` with `slope . R^-1 y >= bound`; `None` if it does not exist.
fn nearest(
    upper: &DMatrix<f64>,
    target: &DVector<f64>,
    conditions: &[(DVector<f64>, f64)],
) -> Option<DVector<f64>> {
    let lower = upper.transpose();
    let mut rows: Vec<DVector<f64>> = Vec::new();
    let mut bounds = Vec::new();
    for (slope, bound) in conditions {
        // Slope in the scaled variables `y = R x`: `slope . R^-1 y = (R^-T slope) . y`.
        let turned = lower.solve_lower_triangular(slope)?;
        let size = turned.norm();
        if size < 1e-300 {
            continue;
        }
        rows.push(turned / -size);
        bounds.push(-bound / size);
    }
    // Numbers of order one: in units of the distance of the target or of the conditions.
    let needed = bounds.iter().fold(0.0_f64, |most, own| most.max(-own));
    let unit = target.norm().max(needed).max(1e-300);
    let target = target / unit;
    bounds.iter_mut().for_each(|own| *own /= unit);
    if let Some(point) = projected(&target, &rows, &bounds) {
        return Some(point * unit);
    }
    // Only a few of many conditions are active. Violated conditions are added until all hold.
    let mut active: Vec<usize> = Vec::new();
    let mut point = target.clone();
    for _ in 0..MOST_PROGRAMS {
        let mut violated: Vec<(usize, f64)> = (0..rows.len())
            .map(|n| (n, rows[n].dot(&point) - bounds[n]))
            .filter(|(n, excess)| *excess > CONDITION_TOLERANCE && !active.contains(n))
            .collect();
        if violated.is_empty() {
            break;
        }
        violated.sort_by(|a, b| b.1.total_cmp(&a.1));
        active.extend(violated.iter().take(ADDED_CONDITIONS).map(|(n, _)| *n));
        point = nearest_of(&target, &rows, &bounds, &active)?;
    }
    Some(point * unit)
}

/// Point nearest to `target` with `row . y <= bound`; `None` if it does not exist or the method fails.
///
/// The least distance program of Lawson and Hanson (Solving Least Squares Problems, 1974, chapter 23): its dual is a problem of nonnegative least
/// squares. The active constraints are then imposed as equations, so that the point is exact except for rounding.
fn projected(target: &DVector<f64>, rows: &[DVector<f64>], bounds: &[f64]) -> Option<DVector<f64>> {
    let count = target.len();
    let gaps: Vec<f64> = rows
        .iter()
        .zip(bounds)
        .map(|(row, bound)| row.dot(target) - bound)
        .collect();
    let most = gaps.iter().fold(0.0_f64, |most, own| most.max(*own));
    if most <= 0.0 {
        return Some(target.clone());
    }
    let columns = rows.iter().zip(&gaps).map(|(row, gap)| {
        DVector::from_fn(count + 1, |i, _| match i < count {
            true => -row[i],
            false => gap / most,
        })
    });
    let columns: Vec<DVector<f64>> = columns.collect();
    let mut right = DVector::zeros(count + 1);
    right[count] = 1.0;
    let (active, rest) = nonnegative(&columns, &right)?;
    // The dual has no error if the constraints contradict each other. More active constraints than unknowns depend on each other.
    if rest.norm() < 1e-12 || active.len() > count {
        return None;
    }
    // y = target - N (N^T N)^-1 (N^T target - b), with the normals of the active constraints as the columns of N = Q R.
    let normals = DMatrix::from_fn(count, active.len(), |i, j| rows[active[j]][i]);
    let qr = normals.qr();
    let violated = DVector::from_fn(active.len(), |j, _| gaps[active[j]]);
    let upper = qr.r();
    let turned = upper.transpose().solve_lower_triangular(&violated)?;
    let point = target - qr.q() * turned;
    let scale = most.max(point.norm());
    let holds = |(row, bound): (&DVector<f64>, &f64)| {
        row.dot(&point) - bound <= PROJECTION_TOLERANCE * scale
    };
    rows.iter().zip(bounds).all(holds).then_some(point)
}

/// Violation of a constraint by a projected point, relative to its distance.
const PROJECTION_TOLERANCE: f64 = 1e-10;
/// Largest number of changes of the active set.
const MOST_CHANGES: usize = 400;

/// Indices of the positive components of `argmin |sum_n u_n column_n - right|` with `u_n >= 0`, and the negative of the error; `None` if the iteration
/// does not end.
fn nonnegative(
    columns: &[DVector<f64>],
    right: &DVector<f64>,
) -> Option<(Vec<usize>, DVector<f64>)> {
    let mut active: Vec<usize> = Vec::new();
    let mut values: Vec<f64> = Vec::new();
    let mut rest = right.clone();
    let mut refused: Vec<usize> = Vec::new();
    for _ in 0..MOST_CHANGES {
        let gains = columns.iter().enumerate();
        let gains = gains
            .filter(|(n, _)| !active.contains(n) && !refused.contains(n))
            .map(|(n, column)| (n, column.dot(&rest) / column.norm()));
        let best = gains.max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((next, _)) = best.filter(|(_, gain)| *gain > 1e-13) else {
            return Some((active, rest));
        };
        active.push(next);
        values.push(0.0);
        loop {
            let matrix = DMatrix::from_fn(right.len(), active.len(), |i, j| columns[active[j]][i]);
            let own = match active.len() <= right.len() {
                true => {
                    let qr = matrix.qr();
                    qr.r().solve_upper_triangular(&(qr.q().tr_mul(right)))
                }
                false => None,
            };
            let last = active.len() - 1;
            let Some(own) = own.filter(|own| {
                let is_new = active[last] == next && values[last] == 0.0;
                own.iter().all(|value| value.is_finite()) && (!is_new || own[last] > 0.0)
            }) else {
                // The new column depends on the others.
                refused.push(next);
                let place = active.iter().position(|n| *n == next)?;
                active.remove(place);
                values.remove(place);
                break;
            };
            if own.iter().all(|value| *value > 0.0) {
                values = own.iter().copied().collect();
                refused.clear();
                break;
            }
            let steps = values.iter().zip(own.iter());
            let part = steps
                .filter(|(_, own)| **own <= 0.0)
                .map(|(old, own)| old / (old - own))
                .fold(1.0, f64::min);
            for (old, own) in values.iter_mut().zip(own.iter()) {
                *old += part * (own - *old);
            }
            let least = values.iter().fold(0.0_f64, |a, b| a.max(*b)) * 1e-15;
            let kept: Vec<bool> = values.iter().map(|own| *own > least).collect();
            let keep = |n: usize| kept[n];
            active = (0..active.len())
                .filter(|n| keep(*n))
                .map(|n| active[n])
                .collect();
            values = (0..values.len())
                .filter(|n| keep(*n))
                .map(|n| values[n])
                .collect();
            if active.is_empty() {
                break;
            }
        }
        rest = right.clone();
        for (n, value) in active.iter().zip(&values) {
            rest -= &columns[*n] * *value;
        }
    }
    None
}

/// Point nearest to `target` on one side of some planes; `None` if it does not exist.
fn nearest_of(
    target: &DVector<f64>,
    rows: &[DVector<f64>],
    bounds: &[f64],
    active: &[usize],
) -> Option<DVector<f64>> {
    let count = target.len();
    let row = |n: &usize| rows[*n].iter().copied().collect();
    let matrix: Vec<Vec<f64>> = active.iter().map(row).collect();
    let bounds: Vec<f64> = active.iter().map(|n| bounds[*n]).collect();
    let linear: Vec<f64> = target.iter().map(|own| -own).collect();
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-13,
        tol_gap_rel: 1e-13,
        tol_feas: 1e-13,
        ..DefaultSettings::default()
    };
    let cones = [SupportedConeT::NonnegativeConeT(bounds.len())];
    let mut solver = DefaultSolver::new(
        &CscMatrix::identity(count),
        &linear,
        &CscMatrix::from(&matrix),
        &bounds,
        &cones,
        settings,
    )
    .ok()?;
    solver.solve();
    let is_solved = matches!(
        solver.solution.status,
        SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress
    );
    is_solved.then(|| DVector::from_vec(solver.solution.x))
}
