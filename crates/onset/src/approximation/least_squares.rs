//! Moving least squares of any order, with Shepard's functions as order zero.
//!
//! `phi_K = alpha . p(xi_K) W(xi_K)` with `M alpha = e_0`, `M = sum_K W p (x) p`. Derivatives with respect to the
//! evaluation point and to the particles follow by implicit differentiation of `M alpha = e_0`.

use super::basis::Term;
use super::{MAXIMUM_CONDITION, Motion, Order, ShapeFunctions, SingularMoment};
use crate::algebra::array_of;
use nalgebra::{DMatrix, SMatrix, SVector};

/// Coefficients `alpha` and the quantities needed for their derivatives.
pub(super) struct Coefficients<const D: usize, const B: usize> {
    /// `M^-1`, or zero for a fixed `alpha`, so that all derivatives of `alpha` vanish.
    inverse: SMatrix<f64, B, B>,
    alpha: SVector<f64, B>,
    /// Derivatives `D_j alpha` with respect to the evaluation point.
    alpha1: [SVector<f64, B>; D],
    /// Second derivatives `D_j D_t alpha` with respect to the evaluation point.
    alpha2: [[SVector<f64, B>; D]; D],
    /// Sum `sum_K (p (x) a)_,j`: the negative derivative of `M` with respect to the evaluation point.
    moment1: [SMatrix<f64, B, B>; D],
}

/// Inverse of a moment matrix.
///
/// # Errors
/// [`SingularMoment`] if the matrix is singular to rounding.
pub(super) fn inverted<const B: usize>(
    moment: &SMatrix<f64, B, B>,
) -> Result<SMatrix<f64, B, B>, SingularMoment> {
    let inverse = DMatrix::from_fn(B, B, |i, j| moment[(i, j)]).try_inverse();
    let inverse = inverse.map(|inverse| SMatrix::<f64, B, B>::from_fn(|i, j| inverse[(i, j)]));
    let condition = inverse.map_or(f64::INFINITY, |inverse| inverse.amax() * moment.amax());
    inverse
        .filter(|_| condition < MAXIMUM_CONDITION)
        .ok_or(SingularMoment { condition })
}

/// Returns the functions whose coefficients solve `M alpha = e_0`.
///
/// # Errors
/// [`SingularMoment`] if the neighbors do not determine the coefficients.
pub(super) fn solved<const D: usize, const B: usize>(
    terms: &[Term<D, B>],
    order: Order,
) -> Result<ShapeFunctions<D>, SingularMoment> {
    let moment: SMatrix<f64, B, B> = terms.iter().map(|term| term.p * term.a.transpose()).sum();
    let inverse = inverted(&moment)?;
    let alpha: SVector<f64, B> = inverse.column(0).into_owned();
    // M alpha = e0 differentiated: D_j M = -M_j (the point moves against the neighbors), so
    // D_j alpha = M^-1 M_j alpha and D_jt alpha = M^-1 (M_j D_t alpha + M_t D_j alpha - M_jt alpha).
    let moment1: [SMatrix<f64, B, B>; D] = array_of(|j| {
        let of_term =
            |term: &Term<D, B>| term.p1[j] * term.a.transpose() + term.p * term.a1[j].transpose();
        terms.iter().map(of_term).sum()
    });
    let alpha1 = array_of(|j| inverse * (moment1[j] * alpha));
    let mut alpha2 = [[SVector::zeros(); D]; D];
    if order != Order::First {
        for j in 0..D {
            for t in 0..=j {
                let moment2 = terms.iter().map(|term| term.moment2_times(j, t, &alpha));
                let moment2: SVector<f64, B> = moment2.sum();
                alpha2[j][t] =
                    inverse * (moment1[j] * alpha1[t] + moment1[t] * alpha1[j] - moment2);
                alpha2[t][j] = alpha2[j][t];
            }
        }
    }
    Ok(Coefficients {
        inverse,
        alpha,
        alpha1,
        alpha2,
        moment1,
    }
    .shape_functions(terms, order))
}

impl<const D: usize, const B: usize> Coefficients<D, B> {
    /// Constant `alpha`, as for raw weights.
    pub(super) fn fixed(alpha: f64) -> Self {
        Self {
            inverse: SMatrix::zeros(),
            alpha: SVector::repeat(alpha),
            alpha1: [SVector::zeros(); D],
            alpha2: [[SVector::zeros(); D]; D],
            moment1: [SMatrix::zeros(); D],
        }
    }

    pub(super) fn shape_functions(&self, terms: &[Term<D, B>], order: Order) -> ShapeFunctions<D> {
        let Self {
            alpha,
            alpha1,
            alpha2,
            ..
        } = self;
        let matrix = |entry: &dyn Fn(usize, usize) -> f64| SMatrix::from_fn(entry);
        let gradient =
            |i: &Term<D, B>| SVector::from_fn(|j, _| alpha1[j].dot(&i.a) - alpha.dot(&i.a1[j]));
        let frozen = |i: &Term<D, B>| matrix(&|j, t| alpha.dot(&i.a2[j][t]));
        let hessian = |i: &Term<D, B>| {
            matrix(&|j, t| {
                alpha2[j][t].dot(&i.a) - alpha1[j].dot(&i.a1[t]) - alpha1[t].dot(&i.a1[j])
                    + alpha.dot(&i.a2[j][t])
            })
        };
        let second = order != Order::First;
        let optional = |make: &dyn Fn(&Term<D, B>) -> SMatrix<f64, D, D>| {
            if second {
                terms.iter().map(make).collect()
            } else {
                Vec::new()
            }
        };
        ShapeFunctions {
            values: terms.iter().map(|i| alpha.dot(&i.a)).collect(),
            gradients: terms.iter().map(gradient).collect(),
            hessians: optional(&hessian),
            frozen_hessians: optional(&frozen),
            motion: (order == Order::Sensitivities).then(|| self.motion(terms)),
        }
    }

    /// Motion of the gradients, from `phi_I,j = D_j alpha . a_I - alpha . a_I,j`.
    fn motion(&self, terms: &[Term<D, B>]) -> Motion<D> {
        let mut motion = Motion::with_capacity(B, terms.len());
        for term in terms {
            // d alpha / d x_K,t = -M^-1 m_,t alpha, and its derivative along the evaluation point.
            let shift: [SVector<f64, B>; D] =
                array_of(|t| -(self.inverse * term.moment1_times(t, &self.alpha)));
            let slope: [[SVector<f64, B>; D]; D] = array_of(|j| {
                array_of(|t| {
                    self.inverse
                        * (term.moment2_times(j, t, &self.alpha) + self.moment1[j] * shift[t]
                            - term.moment1_times(t, &self.alpha1[j]))
                })
            });
            for b in 0..B {
                let gradient = SVector::from_fn(|j, _| term.a1[j][b]);
                motion.terms.push((term.a[b], gradient));
                let shift = SVector::from_fn(|t, _| shift[t][b]);
                motion
                    .shifts
                    .push((shift, SMatrix::from_fn(|j, t| slope[j][t][b])));
            }
            motion.own.push(SMatrix::from_fn(|j, t| {
                self.alpha1[j].dot(&term.a1[t]) - self.alpha.dot(&term.a2[j][t])
            }));
        }
        motion
    }
}
