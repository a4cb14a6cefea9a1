//! Shape functions from weights: raw, Shepard, moving least squares, and corrected derivatives.
//!
//! All but the last are `phi_K = alpha . p(xi_K) W(xi_K)` with `xi_K = x_K - x`, where the coefficients solve
//! `M alpha = e_0` with the moment matrix `M = sum_K W p (x) p`: for the basis `p = (1)` this is Shepard's function (34),
//! for all monomials up to a degree moving least squares, which is the reproducing kernel method of that order; raw
//! weights have a constant `alpha`. Corrected derivatives have gradients that are the derivative of no function:
//! `grad f(x) = C^T sum_K (f_K - f_0) grad W_K`, with the matrix `C` that makes it exact for linear fields.

mod basis;
mod corrected;
mod least_squares;

pub use basis::basis_size;

use crate::kernel::Weight;
use basis::{BasisValue, Monomials, Term};
use corrected::{Reference, corrected};
use least_squares::{Coefficients, solved};
use nalgebra::{SMatrix, SVector};
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
    /// Moving least squares with all monomials up to the second degree.
    #[cfg_attr(feature = "serde", serde(rename = "mls-2"))]
    Mls2,
    /// Moving least squares with all monomials up to the third degree.
    #[cfg_attr(feature = "serde", serde(rename = "mls-3"))]
    Mls3,
    /// Gradients of differences to the value of the particle at the point, corrected to be exact for linear fields:
    /// `grad f(x_I) = C^T sum_K (f_K - f_I) grad W_K`, `C = (sum_K (x_K - x_I) (x) grad W_K)^-1`, as in Randles and
    /// Libersky, Comput. Methods Appl. Mech. Engrg. 139 (1996) 375. At points that are no particles `f_I` is
    /// interpolated by Shepard's functions.
    RandlesLibersky,
    /// Gradients of Shepard's functions, corrected by a matrix to be exact for linear fields:
    /// `psi_K = C^T grad phi_K`, `C = (sum_K x_K (x) grad phi_K)^-1`, as in Krongauz and Belytschko, Comput. Methods
    /// Appl. Mech. Engrg. 146 (1997) 371.
    KrongauzBelytschko,
}

impl Approximation {
    /// All of them, in the order of the documentation.
    pub const ALL: [Self; 7] = [
        Self::Raw,
        Self::Shepard,
        Self::Mls,
        Self::Mls2,
        Self::Mls3,
        Self::RandlesLibersky,
        Self::KrongauzBelytschko,
    ];

    /// The degree up to which polynomials are reproduced by the values, `sum_K q(x_K) phi_K(x) = q(x)`; none where
    /// not even constants are.
    pub fn degree(self) -> Option<usize> {
        match self {
            Self::Raw => None,
            Self::Shepard | Self::RandlesLibersky | Self::KrongauzBelytschko => Some(0),
            Self::Mls => Some(1),
            Self::Mls2 => Some(2),
            Self::Mls3 => Some(3),
        }
    }

    /// The degree up to which gradients of polynomials are exact, `sum_K q(x_K) grad phi_K(x) = grad q(x)`.
    ///
    /// ```
    /// use onset::approximation::Approximation;
    /// let krongauz = Approximation::KrongauzBelytschko;
    /// assert_eq!((krongauz.degree(), krongauz.degree_of_gradients()), (Some(0), Some(1)));
    /// ```
    pub fn degree_of_gradients(self) -> Option<usize> {
        match self {
            Self::RandlesLibersky | Self::KrongauzBelytschko => Some(1),
            other => other.degree(),
        }
    }

    /// The least number of neighbors that determine a gradient in a dimension.
    pub fn neighbors_needed(self, dimension: usize) -> usize {
        basis_size(dimension, self.degree().unwrap_or(0).max(1))
    }
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
    /// `phi_K,j`, with respect to the evaluation point, or the corrected gradient in its place; 1/length.
    pub gradients: Vec<SVector<f64, D>>,
    /// The derivative `t` of the gradient `j` with respect to the evaluation point, row `j`, column `t`; symmetric unless
    /// the gradient is a corrected one. 1/length^2.
    pub hessians: Vec<SMatrix<f64, D, D>>,
    /// As `hessians`, but with the normalization `alpha` held fixed: `alpha . (p W)_,jt`; of corrected gradients
    /// `C_mj W_,mt`.
    pub frozen_hessians: Vec<SMatrix<f64, D, D>>,
    /// How the gradients change when particles move, if asked for.
    motion: Option<Motion<D>>,
}

/// How the gradient `phi_I,j` at a fixed point changes when a particle `K` moves: `d phi_I,j / d x_K,t = sum_b (d_jt alpha_b)_K
/// (a_b)_I - (d_t alpha_b)_K (a_b,j)_I`, a sum of products of what depends on `K`, through the coefficients `alpha_b`, and on
/// `I`; for `K = I` also what the particle's own term `a` does. 1/length^2.
#[derive(Clone, Debug)]
pub(crate) struct Motion<const D: usize> {
    /// Number of products.
    pub(crate) basis: usize,
    /// `a_b` with its gradient, at `[I * basis + b]`.
    pub(crate) terms: Vec<(f64, SVector<f64, D>)>,
    /// `d alpha_b / d x_K,t` and its derivative `j` along the evaluation point (row `j`, column `t`), at `[K * basis + b]`.
    pub(crate) shifts: Vec<(SVector<f64, D>, SMatrix<f64, D, D>)>,
    /// What is added for `K = I`.
    pub(crate) own: Vec<SMatrix<f64, D, D>>,
}

impl<const D: usize> Motion<D> {
    fn with_capacity(basis: usize, neighbors: usize) -> Self {
        Self {
            basis,
            terms: Vec::with_capacity(basis * neighbors),
            shifts: Vec::with_capacity(basis * neighbors),
            own: Vec::with_capacity(neighbors),
        }
    }
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
    /// basis and has no influence but on rounding.
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
        let constant = || -> Vec<Term<D, 1>> {
            let term = |w: &Weight<D>| Term::new(BasisValue::constant(), w);
            weights.iter().map(term).collect()
        };
        let neighbors = Neighbors {
            positions,
            weights,
            length,
            order,
        };
        match (self, D) {
            (Self::Raw, _) => {
                let fixed = Coefficients::<D, 1>::fixed(raw_factor);
                Ok(fixed.shape_functions(&constant(), order))
            }
            (Self::Shepard, _) => solved(&constant(), order),
            (Self::Mls, 1) => neighbors.least_squares::<2>(),
            (Self::Mls, 2) | (Self::Mls2, 1) => neighbors.least_squares::<3>(),
            (Self::Mls, _) | (Self::Mls3, 1) => neighbors.least_squares::<4>(),
            (Self::Mls2, 2) => neighbors.least_squares::<6>(),
            (Self::Mls2, _) | (Self::Mls3, 2) => neighbors.least_squares::<10>(),
            (Self::Mls3, _) => neighbors.least_squares::<20>(),
            (Self::RandlesLibersky, _) => {
                corrected(positions, weights, Reference::Particle, length, order)
            }
            (Self::KrongauzBelytschko, _) => {
                corrected(positions, weights, Reference::Interpolated, length, order)
            }
        }
    }
}

/// The neighbors of a point.
struct Neighbors<'a, const D: usize> {
    positions: &'a [SVector<f64, D>],
    weights: &'a [Weight<D>],
    length: f64,
    order: Order,
}

impl<const D: usize> Neighbors<'_, D> {
    /// Moving least squares with the first `B` monomials.
    fn least_squares<const B: usize>(&self) -> Result<ShapeFunctions<D>, SingularMoment> {
        let monomials = Monomials::<D, B>::new();
        let terms: Vec<Term<D, B>> = self
            .positions
            .iter()
            .zip(self.weights)
            .map(|(xi, w)| Term::new(monomials.at(xi, self.length), w))
            .collect();
        solved(&terms, self.order)
    }
}
