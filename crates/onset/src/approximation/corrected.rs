//! Corrected derivatives: gradients that are exact for linear fields but are not the derivatives of any functions.
//!
//! The discrete gradient of a field is `grad f(x) = sum_K f_K psi_K` with
//!
//! `psi_K = C^T h_K`, `h_K = g_K - n_K sum_L g_L`, `C = (sum_K x_K (x) h_K)^-1`, `g_K = grad W(x_K - x)`,
//!
//! which is `C^T sum_K (f_K - f_0) g_K`: the gradient of differences to the value `f_0 = sum_K n_K f_K` of the field at the point. `sum_K psi_K = 0`
//! and `sum_K x_K (x) psi_K = 1` for any `n_K` that add up to one. The two corrections differ in `n_K`. Krongauz and Belytschko use Shepard's
//! functions, so that `h_K` is their derivative times `sum W`. Randles and Libersky use one for the particle at the point and zero for all others. If
//! the point is not a particle, its value is interpolated, and both corrections are identical. Both use Shepard's functions for the values.
//!
//! The derivatives below are derivatives of these formulas: `psi_K,jt` is not symmetric.

use super::least_squares::inverted;
use super::{Motion, Order, ShapeFunctions, SingularMoment};
use crate::algebra::array_of;
use crate::kernel::Weight;
use nalgebra::{SMatrix, SVector};

/// Relative positions below this fraction of the length scale coincide with the point.
const PARTICLE_TOLERANCE: f64 = 1e-12;

/// Value that is subtracted in the differences of a gradient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reference {
    /// Value interpolated by Shepard's functions.
    Interpolated,
    /// Value of the particle at the point, if there is a particle.
    Particle,
}

/// Corrected gradients at a point.
struct Correction<'a, const D: usize> {
    positions: &'a [SVector<f64, D>],
    weights: &'a [Weight<D>],
    /// Sum of the weights, `sum W`.
    sum: f64,
    /// Whether `n_K` are Shepard's functions, which move with the particles.
    is_interpolated: bool,
    /// Weights `n_K` of the value at the point.
    shares: Vec<f64>,
    /// Sum of the weight gradients, `sum_L g_L`.
    total: SVector<f64, D>,
    /// Gradients `h_K` of differences.
    differences: Vec<SVector<f64, D>>,
    /// Correction matrix `C` of the gradients.
    inverse: SMatrix<f64, D, D>,
}

/// Returns shape functions with Shepard's values and corrected gradients.
///
/// # Errors
/// [`SingularMoment`] if the neighbors do not span space.
pub(super) fn corrected<const D: usize>(
    positions: &[SVector<f64, D>],
    weights: &[Weight<D>],
    reference: Reference,
    length: f64,
    order: Order,
) -> Result<ShapeFunctions<D>, SingularMoment> {
    let sum: f64 = weights.iter().map(|w| w.value).sum();
    let values: Vec<f64> = weights.iter().map(|w| w.value / sum).collect();
    let own = positions
        .iter()
        .position(|x| x.amax() <= PARTICLE_TOLERANCE * length)
        .filter(|_| reference == Reference::Particle);
    let shares = match own {
        Some(own) => (0..weights.len())
            .map(|k| f64::from(u8::from(k == own)))
            .collect(),
        None => values.clone(),
    };
    let total: SVector<f64, D> = -weights.iter().map(|w| w.gradient).sum::<SVector<f64, D>>();
    let differences: Vec<SVector<f64, D>> = weights
        .iter()
        .zip(&shares)
        .map(|(w, share)| -w.gradient - total * *share)
        .collect();
    let moment: SMatrix<f64, D, D> = positions
        .iter()
        .zip(&differences)
        .map(|(x, h)| x * h.transpose())
        .sum();
    let correction = Correction {
        positions,
        weights,
        sum,
        is_interpolated: own.is_none(),
        shares,
        total,
        inverse: inverted(&moment)?,
        differences,
    };
    let gradient = |h: &SVector<f64, D>| correction.inverse.transpose() * h;
    let frozen = |w: &Weight<D>| correction.inverse.transpose() * w.hessian;
    let (hessians, frozen_hessians) = match order {
        Order::First => (Vec::new(), Vec::new()),
        _ => (correction.hessians(), weights.iter().map(frozen).collect()),
    };
    Ok(ShapeFunctions {
        gradients: correction.differences.iter().map(gradient).collect(),
        hessians,
        frozen_hessians,
        motion: (order == Order::Sensitivities).then(|| correction.motion()),
        values,
    })
}

impl<const D: usize> Correction<'_, D> {
    /// Derivative `sum_L d g_L,m / d x_t` at fixed particles.
    fn total1(&self) -> SMatrix<f64, D, D> {
        self.weights.iter().map(|w| w.hessian).sum()
    }

    /// Derivative `d psi_I,j / d x_t` at fixed particles, from `d C = -C dN C`, `N = sum_K x_K (x) h_K`.
    fn hessians(&self) -> Vec<SMatrix<f64, D, D>> {
        let total1 = self.total1();
        // d h_K,m / d x_t = W_K,mt - n_K sum_L W_L,mt - n_K,t sum_L g_L,m, with n_K,t = h_K,t / sum W for Shepard's.
        let slope = |k: usize| {
            let frozen = self.weights[k].hessian - total1 * self.shares[k];
            match self.is_interpolated {
                true => frozen - self.total * (self.differences[k] / self.sum).transpose(),
                false => frozen,
            }
        };
        let slopes: Vec<SMatrix<f64, D, D>> = (0..self.weights.len()).map(slope).collect();
        // Product `C dN C` for each direction `t`.
        let turned: [SMatrix<f64, D, D>; D] = array_of(|t| {
            let moment1: SMatrix<f64, D, D> = self
                .positions
                .iter()
                .zip(&slopes)
                .map(|(x, slope)| x * slope.column(t).transpose())
                .sum();
            self.inverse * moment1 * self.inverse
        });
        (0..self.weights.len())
            .map(|k| {
                let direct = self.inverse.transpose() * slopes[k];
                let h = &self.differences[k];
                SMatrix::from_fn(|j, t| direct[(j, t)] - turned[t].column(j).dot(h))
            })
            .collect()
    }

    /// Change of `psi_I,j = h_I,m C_mj` when particles move. The change of `C` gives one product with `h_I` for each dimension; the change of `h_I`
    /// gives one product with `n_I` and the term from the weight of the particle.
    fn motion(&self) -> Motion<D> {
        let mut motion = Motion::with_capacity(D + 1, self.weights.len());
        let mean: SVector<f64, D> = self
            .positions
            .iter()
            .zip(&self.shares)
            .map(|(x, share)| x * *share)
            .sum();
        for (k, w) in self.weights.iter().enumerate() {
            let own = match self.is_interpolated {
                true => w.hessian + self.total * (w.gradient / self.sum).transpose(),
                false => w.hessian,
            };
            // d N_im / d x_K,t = delta_it h_K,m + (sum_L n_L x_L - x_K)_i own_mt.
            let lever = mean - self.positions[k];
            let turned: [SMatrix<f64, D, D>; D] = array_of(|t| {
                let mut moment1 = lever * own.column(t).transpose();
                for m in 0..D {
                    moment1[(t, m)] += self.differences[k][m];
                }
                self.inverse * moment1 * self.inverse
            });
            let still = SVector::zeros();
            for b in 0..D {
                motion.terms.push((self.differences[k][b], still));
                let slope = SMatrix::from_fn(|j, t| -turned[t][(b, j)]);
                motion.shifts.push((still, slope));
            }
            let own = self.inverse.transpose() * own;
            motion.terms.push((self.shares[k], still));
            motion.shifts.push((still, own));
            motion.own.push(-own);
        }
        motion
    }
}
