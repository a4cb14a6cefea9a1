//! Standard deviations and correlations of fitted constants.

use crate::family::Family;
use crate::tests_of_specimens::Equations;
use nalgebra::DMatrix;
use serde::Serialize;

/// Standard deviations of the constants and their strong correlations, from the linearized errors at the optimum.
///
/// `cov = s^2 (J^T J)^-1` with the derivatives `J` of the scaled errors and `s^2` their sum of squares over the degrees of freedom. Errors below the rounding of
/// the data count as rounding.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Uncertainty {
    /// Standard deviations in the order of the constants; NaN for fixed constants.
    pub deviations: Vec<f64>,
    /// Names of two strongly correlated constants, and their correlation.
    pub correlated: Vec<(String, String, f64)>,
}

/// Rounding of the data, relative to their norm.
const ROUNDING_FRACTION: f64 = 1e-13;
/// Correlations of larger magnitude are reported.
const STRONG: f64 = 0.99;

impl Uncertainty {
    pub(crate) fn new(
        family: &Family,
        equations: &Equations,
        constants: &[f64],
        is_free: &[bool],
    ) -> Self {
        let (errors, jacobian) = equations.errors(family, constants);
        let free: Vec<usize> = (0..constants.len()).filter(|n| is_free[*n]).collect();
        let sizes: Vec<f64> = free.iter().map(|n| jacobian.column(*n).norm()).collect();
        let mut own = Self {
            deviations: vec![f64::NAN; constants.len()],
            correlated: Vec::new(),
        };
        let degrees = errors.len().saturating_sub(free.len());
        if degrees == 0 || free.is_empty() || sizes.contains(&0.0) {
            return own;
        }
        let scaled = DMatrix::from_fn(errors.len(), free.len(), |i, j| {
            jacobian[(i, free[j])] / sizes[j]
        });
        let rounding = ROUNDING_FRACTION * equations.norm();
        let variance = errors.norm_squared().max(rounding * rounding) / degrees as f64;
        let upper = scaled.qr().r();
        let Some(inverse) = upper.try_inverse() else {
            return own;
        };
        let covariance = &inverse * inverse.transpose();
        for (j, n) in free.iter().enumerate() {
            own.deviations[*n] = (variance * covariance[(j, j)]).sqrt() / sizes[j];
            for i in 0..j {
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
