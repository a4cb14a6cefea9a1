//! Shape functions from weights: raw, Shepard, and moving least squares.
//!
//! All three are `phi_K = alpha . p(xi_K) W(xi_K)` with `xi_K = x_K - x`, where the coefficients
//! solve `M alpha = e_0` with the moment matrix `M = sum_K W p (x) p`: for the basis `p = (1)` this is
//! Shepard's function (34), for `p = (1, xi)` moving least squares with linear completeness; raw
//! weights have a constant `alpha`. Derivatives with respect to the evaluation point and to the
//! particles follow by implicit differentiation of `M alpha = e_0`.

use crate::kernel::Weight;
use nalgebra::{DMatrix, SMatrix, SVector};
use thiserror::Error;

/// How weights are corrected to become shape functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Approximation {
    /// The weight itself, times the particle volume over the weight's integral.
    Raw,
    /// Normalized weights, equation (34): partition of unity, not linearly complete.
    Shepard,
    /// Moving least squares with a linear basis: linearly complete.
    Mls,
}

/// The moment matrix of a quadrature point is singular: the neighbors do not span space.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("the moment matrix is singular (condition number {condition:.1e})")]
pub struct SingularMoment {
    /// Its condition number in the maximum norm.
    pub condition: f64,
}

/// Condition number of the moment matrix beyond which shape functions are noise.
const MAXIMUM_CONDITION: f64 = 1e12;

/// Shape functions of the neighbors of one point, with their derivatives.
#[derive(Clone, Debug)]
pub struct ShapeFunctions<const D: usize> {
    /// `phi_K`, dimensionless.
    pub values: Vec<f64>,
    /// `phi_K,j`, with respect to the evaluation point; 1/length.
    pub gradients: Vec<SVector<f64, D>>,
    /// `phi_K,jt`, with respect to the evaluation point; 1/length^2.
    pub hessians: Vec<SMatrix<f64, D, D>>,
    /// As `hessians`, but with the normalization `alpha` held fixed: `alpha . (p W)_,jt`.
    pub frozen_hessians: Vec<SMatrix<f64, D, D>>,
    /// How the gradients change when particles move, if asked for.
    motion: Option<Motion<D>>,
}

/// How the gradient `phi_I,j` at a fixed point changes when a particle `K` moves: `d phi_I,j / d x_K,t = sum_b (d_jt alpha_b)_K
/// (a_b)_I - (d_t alpha_b)_K (a_b,j)_I`, a sum of products of what depends on `K`, through the coefficients `alpha_b`, and on
/// `I`; for `K = I` also what the particle's own term `a` does. 1/length^2.
#[derive(Clone, Debug)]
pub(crate) struct Motion<const D: usize> {
    /// Number of basis functions.
    pub(crate) basis: usize,
    /// `a_b` with its gradient, at `[I * basis + b]`.
    pub(crate) terms: Vec<(f64, SVector<f64, D>)>,
    /// `d alpha_b / d x_K,t` and its derivative `j` along the evaluation point (row `j`, column `t`), at `[K * basis + b]`.
    pub(crate) shifts: Vec<(SVector<f64, D>, SMatrix<f64, D, D>)>,
    /// What is added for `K = I`.
    pub(crate) own: Vec<SMatrix<f64, D, D>>,
}

/// Which derivatives are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Values and gradients.
    First,
    /// Also second derivatives with respect to the evaluation point.
    Second,
    /// Also the sensitivities to the motion of every particle.
    Sensitivities,
}

impl<const D: usize> ShapeFunctions<D> {
    /// `d phi_I,j / d x_K,t`, row `j`, column `t`; not a number when the functions were made without
    /// [`Order::Sensitivities`].
    pub fn sensitivity(&self, of: usize, to: usize) -> SMatrix<f64, D, D> {
        let Some(motion) = &self.motion else {
            return SMatrix::repeat(f64::NAN);
        };
        let mut sum = SMatrix::zeros();
        for b in 0..motion.basis {
            let (value, gradient) = motion.terms[of * motion.basis + b];
            let (shift, slope) = motion.shifts[to * motion.basis + b];
            sum += slope * value - gradient * shift.transpose();
        }
        if of == to { sum + motion.own[of] } else { sum }
    }

    /// How the gradients change when particles move, if it was asked for.
    pub(crate) fn motion(&self) -> Option<&Motion<D>> {
        self.motion.as_ref()
    }
}

impl Approximation {
    /// The shape functions at a point from the weights of its neighbors at the relative positions
    /// `xi_K = x_K - x`. `raw_factor` is particle volume over kernel integral; `length` scales the
    /// linear basis and has no influence but on rounding.
    ///
    /// # Errors
    /// [`SingularMoment`] when the neighbors do not determine the coefficients.
    pub fn shape_functions<const D: usize>(
        self,
        positions: &[SVector<f64, D>],
        weights: &[Weight<D>],
        raw_factor: f64,
        length: f64,
        order: Order,
    ) -> Result<ShapeFunctions<D>, SingularMoment> {
        let constant = |_: usize| BasisValue::<D, 1>::constant();
        match (self, D) {
            (Self::Raw, _) => {
                let fixed = Coefficients::<D, 1>::fixed(raw_factor);
                Ok(fixed.shape_functions(&terms(weights, constant), order))
            }
            (Self::Shepard, _) => solved(&terms(weights, constant), order),
            (Self::Mls, 1) => solved(
                &terms(weights, |k| {
                    BasisValue::<D, 2>::linear(&positions[k], length)
                }),
                order,
            ),
            (Self::Mls, 2) => solved(
                &terms(weights, |k| {
                    BasisValue::<D, 3>::linear(&positions[k], length)
                }),
                order,
            ),
            (Self::Mls, _) => solved(
                &terms(weights, |k| {
                    BasisValue::<D, 4>::linear(&positions[k], length)
                }),
                order,
            ),
        }
    }
}

/// The basis `p` at a neighbor and its (constant) gradient.
struct BasisValue<const D: usize, const B: usize> {
    value: SVector<f64, B>,
    gradient: [SVector<f64, B>; D],
}

impl<const D: usize, const B: usize> BasisValue<D, B> {
    fn constant() -> Self {
        Self {
            value: SVector::repeat(1.0),
            gradient: [SVector::zeros(); D],
        }
    }

    /// `p = (1, xi / length)`.
    fn linear(xi: &SVector<f64, D>, length: f64) -> Self {
        let unit = |j: usize| SVector::from_fn(|b, _| if b == j + 1 { 1.0 / length } else { 0.0 });
        Self {
            value: SVector::from_fn(|b, _| if b == 0 { 1.0 } else { xi[b - 1] / length }),
            gradient: std::array::from_fn(unit),
        }
    }
}

/// What one neighbor contributes: `a = p W` and `m = W p (x) p`, differentiated with respect to `xi`.
struct Term<const D: usize, const B: usize> {
    a: SVector<f64, B>,
    a1: [SVector<f64, B>; D],
    a2: [[SVector<f64, B>; D]; D],
    m: SMatrix<f64, B, B>,
    m1: [SMatrix<f64, B, B>; D],
    m2: [[SMatrix<f64, B, B>; D]; D],
}

fn terms<const D: usize, const B: usize>(
    weights: &[Weight<D>],
    basis: impl Fn(usize) -> BasisValue<D, B>,
) -> Vec<Term<D, B>> {
    let term = |(k, w): (usize, &Weight<D>)| {
        let BasisValue {
            value: p,
            gradient: p1,
        } = basis(k);
        let a = p * w.value;
        let a1 = std::array::from_fn(|j| p1[j] * w.value + p * w.gradient[j]);
        let a2 = std::array::from_fn(|j| {
            std::array::from_fn(|t| {
                p1[j] * w.gradient[t] + p1[t] * w.gradient[j] + p * w.hessian[(j, t)]
            })
        });
        Term {
            a,
            a1,
            a2,
            m: p * a.transpose(),
            m1: std::array::from_fn(|j| p1[j] * a.transpose() + p * a1[j].transpose()),
            m2: std::array::from_fn(|j| {
                std::array::from_fn(|t| {
                    p1[j] * a1[t].transpose() + p1[t] * a1[j].transpose() + p * a2[j][t].transpose()
                })
            }),
        }
    };
    weights.iter().enumerate().map(term).collect()
}

/// The coefficients `alpha` and what their derivatives need.
struct Coefficients<const D: usize, const B: usize> {
    /// `M^-1`; zero where `alpha` is fixed, which makes all derivatives of `alpha` vanish.
    inverse: SMatrix<f64, B, B>,
    alpha: SVector<f64, B>,
    /// `D_j alpha`, with respect to the evaluation point.
    alpha1: [SVector<f64, B>; D],
    /// `D_j D_t alpha`.
    alpha2: [[SVector<f64, B>; D]; D],
    /// `sum_K m_,j`: minus the derivative of `M` with respect to the evaluation point.
    moment1: [SMatrix<f64, B, B>; D],
}

fn solved<const D: usize, const B: usize>(
    terms: &[Term<D, B>],
    order: Order,
) -> Result<ShapeFunctions<D>, SingularMoment> {
    let moment: SMatrix<f64, B, B> = terms.iter().map(|term| term.m).sum();
    let inverse = DMatrix::from_fn(B, B, |i, j| moment[(i, j)]).try_inverse();
    let inverse = inverse.map(|inverse| SMatrix::<f64, B, B>::from_fn(|i, j| inverse[(i, j)]));
    let condition = inverse.map_or(f64::INFINITY, |inverse| inverse.amax() * moment.amax());
    let Some(inverse) = inverse.filter(|_| condition < MAXIMUM_CONDITION) else {
        return Err(SingularMoment { condition });
    };
    let alpha: SVector<f64, B> = inverse.column(0).into_owned();
    // M alpha = e0 differentiated: D_j M = -M_j (the point moves against the neighbors), so
    // D_j alpha = M^-1 M_j alpha and D_jt alpha = M^-1 (M_j D_t alpha + M_t D_j alpha - M_jt alpha).
    let moment1: [SMatrix<f64, B, B>; D] =
        std::array::from_fn(|j| terms.iter().map(|term| term.m1[j]).sum());
    let alpha1 = std::array::from_fn(|j| inverse * (moment1[j] * alpha));
    let alpha2 = std::array::from_fn(|j| {
        std::array::from_fn(|t| {
            let moment2: SMatrix<f64, B, B> = terms.iter().map(|term| term.m2[j][t]).sum();
            inverse * (moment1[j] * alpha1[t] + moment1[t] * alpha1[j] - moment2 * alpha)
        })
    });
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
    /// A constant `alpha`, as raw weights have.
    fn fixed(alpha: f64) -> Self {
        Self {
            inverse: SMatrix::zeros(),
            alpha: SVector::repeat(alpha),
            alpha1: [SVector::zeros(); D],
            alpha2: [[SVector::zeros(); D]; D],
            moment1: [SMatrix::zeros(); D],
        }
    }

    fn shape_functions(&self, terms: &[Term<D, B>], order: Order) -> ShapeFunctions<D> {
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

    /// From `phi_I,j = D_j alpha . a_I - alpha . a_I,j`.
    fn motion(&self, terms: &[Term<D, B>]) -> Motion<D> {
        let mut motion = Motion {
            basis: B,
            terms: Vec::with_capacity(B * terms.len()),
            shifts: Vec::with_capacity(B * terms.len()),
            own: Vec::with_capacity(terms.len()),
        };
        for term in terms {
            // d alpha / d x_K,t = -M^-1 m_,t alpha, and its derivative along the evaluation point.
            let shift: [SVector<f64, B>; D] =
                std::array::from_fn(|t| -(self.inverse * (term.m1[t] * self.alpha)));
            let slope: [[SVector<f64, B>; D]; D] = std::array::from_fn(|j| {
                std::array::from_fn(|t| {
                    self.inverse
                        * (term.m2[j][t] * self.alpha + self.moment1[j] * shift[t]
                            - term.m1[t] * self.alpha1[j])
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
