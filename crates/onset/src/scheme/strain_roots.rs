//! Roots of the strain operator: wave vectors with zero-energy modes, computed by Newton's method.

use super::StrainRows;
use crate::algebra::{Complex, MAXIMUM_ITERATIONS, sort_by_value};
use crate::cancel::checkpoint;
use nalgebra::{DMatrix, DMatrixView, DVector, SVector};
use std::borrow::Cow;

/// Largest singular value that is zero to rounding at a root. The slope of `R` is at most one particle spacing.
const ROOT_SINGULAR_VALUE: f64 = 1e-11;
/// Largest singular value that counts as zero at a root whose wave vector is accurate only to the square root of the rounding error.
const ROUGH_ROOT_SINGULAR_VALUE: f64 = 1e-7;
/// Largest ratio of strain to size of a wave at which a search is considered close to a root.
const ROOT_STRAIN_RATIO: f64 = 1e-3;
/// Distance within which the root is then computed, relative to the wave number.
const ROOT_DISTANCE_RATIO: f64 = 1e-2;
/// Largest number of Newton steps. Double roots converge slowest: each step halves the distance.
const MAXIMUM_NEWTON_STEPS: usize = 60;

/// Singular value decomposition, largest values first.
#[derive(Clone)]
pub(crate) struct Singular {
    pub(crate) values: Vec<f64>,
    left: DMatrix<Complex>,
    right: DMatrix<Complex>,
}

impl Singular {
    pub(crate) fn of(matrix: DMatrix<Complex>) -> Option<Self> {
        checkpoint();
        let bound = MAXIMUM_ITERATIONS * matrix.ncols();
        let svd = matrix.try_svd(true, true, f64::EPSILON, bound)?;
        let (left, adjoint) = (svd.u?, svd.v_t?);
        let mut order: Vec<usize> = (0..svd.singular_values.len()).collect();
        sort_by_value(&mut order, |n| -svd.singular_values[*n]);
        Some(Self {
            values: order.iter().map(|n| svd.singular_values[*n]).collect(),
            left: left.select_columns(&order),
            right: adjoint.adjoint().select_columns(&order),
        })
    }

    fn smallest(&self) -> f64 {
        self.values.last().copied().unwrap_or(0.0)
    }

    fn below(&self, bound: f64) -> usize {
        self.values.iter().filter(|value| **value <= bound).count()
    }

    /// Number of singular values that are zero at a root.
    pub(crate) fn nullity(&self) -> usize {
        self.below(ROUGH_ROOT_SINGULAR_VALUE)
    }

    /// Right singular vectors of the `count` smallest values.
    pub(crate) fn softest(&self, count: usize) -> DMatrix<Complex> {
        let n = self.right.ncols();
        self.right.columns(n - count, count).into_owned()
    }

    /// Orthonormal basis of the range of the remaining right singular vectors.
    pub(crate) fn range(&self, count: usize) -> DMatrixView<'_, Complex> {
        self.left.columns(0, self.left.ncols() - count)
    }

    /// Part of a matrix that is orthogonal to this range. Changes of the soft vectors cancel the remaining part.
    pub(crate) fn unanswered(&self, count: usize, matrix: DMatrix<Complex>) -> DMatrix<Complex> {
        let range = self.range(count);
        let answered = range * range.ad_mul(&matrix);
        matrix - answered
    }

    /// Preimages of this basis under the matrix, one per column: the remaining right singular vectors divided by their singular values.
    pub(crate) fn origins(&self, count: usize) -> DMatrix<Complex> {
        let n = self.right.ncols() - count;
        let mut origins = self.right.columns(0, n).into_owned();
        for (mut column, value) in origins.column_iter_mut().zip(&self.values) {
            column /= Complex::from(*value);
        }
        origins
    }
}

impl<const D: usize> StrainRows<D> {
    /// Returns true if an exactly known wave vector has a zero-energy mode. Translations at `k = 0` are excluded.
    pub(crate) fn has_zero_mode_at(&self, k: &SVector<f64, D>) -> bool {
        let nullity = Singular::of(self.at(k)).map_or(0, |singular| match k.norm() > 0.0 {
            true => singular.below(ROOT_SINGULAR_VALUE),
            false => singular.nullity(),
        });
        let translations = if k.norm() > 0.0 { 0 } else { D };
        nullity * self.modes_per_column() > translations
    }

    /// Returns the wave vector of the zero-energy mode close to a wave vector from a search with small strains.
    pub(crate) fn zero_mode_near(&self, k: &SVector<f64, D>) -> Option<SVector<f64, D>> {
        let is_small = self.smallest(k) <= ROOT_STRAIN_RATIO * self.slope * k.norm();
        is_small.then(|| self.polished(k, ROOT_DISTANCE_RATIO * k.norm()))?
    }

    /// Computes a wave vector at which `R` has a kernel, by Newton's method within the distance `reach` of the start.
    pub(crate) fn polished(&self, start: &SVector<f64, D>, reach: f64) -> Option<SVector<f64, D>> {
        let first = Singular::of(self.at(start))?;
        // The nullity of the root is not known in advance: the number of small singular values, or one.
        let small = first.below(3.0 * first.smallest() + ROOT_SINGULAR_VALUE);
        let mut counts = vec![small, 1];
        counts.dedup();
        counts
            .into_iter()
            .find_map(|count| self.followed(start, &first, reach, count))
    }

    fn followed(
        &self,
        start: &SVector<f64, D>,
        first: &Singular,
        reach: f64,
        count: usize,
    ) -> Option<SVector<f64, D>> {
        let (mut k, mut singular) = (*start, Cow::Borrowed(first));
        let mut best = (f64::INFINITY, k);
        let mut idle = 0;
        for _ in 0..MAXIMUM_NEWTON_STEPS {
            let smallest = singular.smallest();
            if smallest < 0.9 * best.0 {
                idle = 0;
            } else {
                idle += 1;
            }
            if smallest < best.0 {
                best = (smallest, k);
            }
            if idle > 3 || smallest == 0.0 {
                break;
            }
            let step = self.newton_step(&k, &singular, count)?;
            if step.norm() <= 1e-15 * (1.0 / self.spacing + k.norm()) {
                break;
            }
            k += step;
            let has_strayed = (k - start).norm() > reach;
            if has_strayed || !k.iter().all(|x| x.is_finite()) {
                break;
            }
            singular = Cow::Owned(Singular::of(self.at(&k))?);
        }
        (best.0 <= ROOT_SINGULAR_VALUE).then_some(best.1)
    }

    /// Smallest change of `k` that minimizes the residual of `R(k) V`, with `V` the vectors of the smallest singular values.
    fn newton_step(
        &self,
        k: &SVector<f64, D>,
        singular: &Singular,
        count: usize,
    ) -> Option<SVector<f64, D>> {
        let soft = singular.softest(count);
        let stacked = |matrix: DMatrix<Complex>| -> Vec<f64> {
            let left = singular.unanswered(count, matrix);
            left.iter().flat_map(|z| [z.re, z.im]).collect()
        };
        let residual = DVector::from_vec(stacked(self.at(k) * &soft));
        let columns: Vec<DVector<f64>> = (0..D)
            .map(|i| DVector::from_vec(stacked(self.derivative(k, i) * &soft)))
            .collect();
        let jacobian = DMatrix::from_columns(&columns);
        let svd = jacobian.try_svd(true, true, f64::EPSILON, 10 * MAXIMUM_ITERATIONS)?;
        let step = svd.solve(&-residual, 1e-9 * self.slope).ok()?;
        Some(SVector::from_fn(|i, _| step[i]))
    }
}
