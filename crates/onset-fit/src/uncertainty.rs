//! Standard deviations and correlations of fitted constants.

use crate::family::Family;
use crate::tests_of_specimens::Equations;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Standard deviations of the constants and their strong correlations, from the linearized errors at the optimum.
///
/// `cov = s^2 Z (Z^T J^T J Z)^-1 Z^T` with the derivatives `J` of the scaled errors, and with `s^2`, their sum of squares divided by the number of
/// degrees of freedom. `Z` spans the changes of the constants that keep the active stability constraints at equality, and constants at their bounds;
/// without these `Z` is the identity. Errors below the rounding of the data count as rounding.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Uncertainty {
    /// Standard deviations in the order of the constants; NaN for fixed constants and constants at a bound, 0 for constants that the active constraints determine.
    pub deviations: Vec<f64>,
    /// Names of two strongly correlated constants, and their correlation.
    pub correlated: Vec<(String, String, f64)>,
}

/// Rounding of the data, relative to their norm.
const ROUNDING_FRACTION: f64 = 1e-13;
/// Fraction of the gradient of the sum of squares that the active constraints may leave unexplained. Constraints with small multipliers matter: with
/// 2e-3 a deviation of `polynomial-3` is 12 times too large.
const UNEXPLAINED: f64 = 1e-5;
/// Smallest gradient, relative to the errors, that is not due to rounding. If the gradient is smaller, no constraint is active.
const STATIONARY: f64 = 1e-6;
/// Correlations of larger magnitude are reported.
const STRONG: f64 = 0.99;
/// Constants are determined by the constraints if their deviation is smaller than this fraction of the unconstrained deviation.
const DETERMINED: f64 = 1e-9;

impl Uncertainty {
    /// Computes the uncertainty at the optimum. `active` are the gradients of constraints that may hold with equality; a constraint counts if its
    /// normal contributes to the gradient of the sum of squares. Constants that are not free are fixed or at their bounds.
    pub(crate) fn new(
        family: &Family,
        equations: &Equations,
        constants: &[f64],
        is_free: &[bool],
        active: &[DVector<f64>],
    ) -> Self {
        let (errors, jacobian) = equations.errors(family, constants);
        let free: Vec<usize> = (0..constants.len()).filter(|n| is_free[*n]).collect();
        let sizes: Vec<f64> = free.iter().map(|n| jacobian.column(*n).norm()).collect();
        let mut own = Self {
            deviations: vec![f64::NAN; constants.len()],
            correlated: Vec::new(),
        };
        if free.is_empty() || sizes.contains(&0.0) {
            return own;
        }
        let scaled = DMatrix::from_fn(errors.len(), free.len(), |i, j| {
            jacobian[(i, free[j])] / sizes[j]
        });
        let Some(inverse) = scaled.qr().r().try_inverse() else {
            return own;
        };
        // In the variables y = R x the errors have the identity as their normal matrix.
        let mut kept = DMatrix::<f64>::identity(free.len(), free.len());
        let normals = active.iter().filter_map(|gradient| {
            let scaled = DVector::from_fn(free.len(), |j, _| gradient[free[j]] / sizes[j]);
            inverse.tr_mul(&scaled).try_normalize(0.0)
        });
        let normals: Vec<DVector<f64>> = normals.collect();
        // At the optimum the gradient of the sum of squares is a combination of the normals of the active constraints.
        let slope = DVector::from_fn(free.len(), |j, _| {
            jacobian.column(free[j]).dot(&errors) / sizes[j]
        });
        let gradient = inverse.tr_mul(&slope);
        if gradient.norm() > STATIONARY * errors.norm() {
            // Each constraint removes one direction.
            for _ in 0..free.len() {
                let rest = &kept * &gradient;
                if rest.norm() <= UNEXPLAINED * gradient.norm() {
                    break;
                }
                let parts = normals.iter().filter_map(|normal| {
                    let part = (&kept * normal).try_normalize(DETERMINED)?;
                    Some((part.dot(&rest).abs(), part))
                });
                let Some((size, part)) = parts.max_by(|a, b| a.0.total_cmp(&b.0)) else {
                    break;
                };
                if size <= STATIONARY * rest.norm() {
                    break;
                }
                kept -= &part * part.transpose();
            }
        }
        let unknown = kept.trace().round().max(0.0) as usize;
        let degrees = errors.len().saturating_sub(unknown);
        if degrees == 0 {
            return own;
        }
        let rounding = ROUNDING_FRACTION * equations.norm();
        let variance = errors.norm_squared().max(rounding * rounding) / degrees as f64;
        let root = &inverse * kept;
        let covariance = &root * root.transpose();
        let is_determined = |j: usize| root.row(j).norm() <= DETERMINED * inverse.row(j).norm();
        for (j, n) in free.iter().enumerate() {
            own.deviations[*n] = match is_determined(j) {
                true => 0.0,
                false => (variance * covariance[(j, j)]).sqrt() / sizes[j],
            };
            for i in (0..j).filter(|i| !is_determined(*i) && !is_determined(j)) {
                let size = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
                let correlation = covariance[(i, j)] / size;
                if correlation.abs() > STRONG {
                    let name = |n: usize| family.constants()[n].name.clone();
                    own.correlated.push((name(free[i]), name(*n), correlation));
                }
            }
        }
        own
    }
}
