//! Shape functions from weights: raw, Shepard, moving least squares, and corrected derivatives.
//!
//! Except for the corrected derivatives the functions are `phi_K = alpha . p(xi_K) W(xi_K)` with `xi_K = x_K - x`. The coefficients solve
//! `M alpha = e_0` with the moment matrix `M = sum_K W p (x) p`. The basis `p = (1)` gives Shepard's function (34).
//! All monomials up to a degree give moving least squares, which is the reproducing kernel method of this order. Raw weights have a constant `alpha`.
//!
//! Corrected derivatives are gradients that are not derivatives of any functions: `grad f(x) = C^T sum_K (f_K - f_0) grad W_K`, with the matrix `C`
//! that makes the gradient exact for linear fields.

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

/// Correction that turns weights into shape functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Approximation {
    /// The kernel itself, times the ratio of the particle volume to the integral of the kernel.
    Raw,
    /// Normalized weights, equation (34): a partition of unity, not linearly complete.
    Shepard,
    /// Moving least squares with a linear basis: linearly complete.
    Mls,
    /// Moving least squares with all monomials up to the second degree.
    #[cfg_attr(feature = "serde", serde(rename = "mls-2"))]
    Mls2,
    /// Moving least squares with all monomials up to the third degree.
    #[cfg_attr(feature = "serde", serde(rename = "mls-3"))]
    Mls3,
    /// Gradients of differences to the value of the particle at the point, corrected to be exact for linear fields.
    ///
    /// `grad f(x_I) = C^T sum_K (f_K - f_I) grad W_K`, `C = (sum_K (x_K - x_I) (x) grad W_K)^-1`, as in Randles and
    /// Libersky, Comput. Methods Appl. Mech. Engrg. 139 (1996) 375. At points that are not particles Shepard's functions interpolate `f_I`.
    RandlesLibersky,
    /// Gradients of Shepard's functions, corrected by a matrix to be exact for linear fields.
    ///
    /// `psi_K = C^T grad phi_K`, `C = (sum_K x_K (x) grad phi_K)^-1`, as in Krongauz and Belytschko, Comput. Methods
    /// Appl. Mech. Engrg. 146 (1997) 371.
    KrongauzBelytschko,
}

impl Approximation {
    /// All approximations, in the order of the documentation.
    pub const ALL: [Self; 7] = [
        Self::Raw,
        Self::Shepard,
        Self::Mls,
        Self::Mls2,
        Self::Mls3,
        Self::RandlesLibersky,
        Self::KrongauzBelytschko,
    ];

    /// Degree of the polynomials that the values reproduce, `sum_K q(x_K) phi_K(x) = q(x)`; `None` if constants are not reproduced.
    pub fn degree(self) -> Option<usize> {
        match self {
            Self::Raw => None,
            Self::Shepard | Self::RandlesLibersky | Self::KrongauzBelytschko => Some(0),
            Self::Mls => Some(1),
            Self::Mls2 => Some(2),
            Self::Mls3 => Some(3),
        }
    }

    /// Degree of the polynomials whose gradients are exact, `sum_K q(x_K) grad phi_K(x) = grad q(x)`; `None` if not even constants have exact gradients.
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

    /// Smallest number of neighbors that determine a gradient in a dimension.
    pub fn neighbors_needed(self, dimension: usize) -> usize {
        basis_size(dimension, self.degree().unwrap_or(0).max(1))
    }
}

/// The moment matrix of a quadrature point is singular because the neighbors do not span space.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("the moment matrix is singular (condition number {condition:.1e})")]
pub struct SingularMoment {
    /// Condition number of the moment matrix in the maximum norm.
    pub condition: f64,
}

/// Largest condition number of the moment matrix for which shape functions and corrected gradients are accurate.
pub(crate) const MAXIMUM_CONDITION: f64 = 1e12;

/// Shape functions of the neighbors of one point, with their derivatives.
#[derive(Clone, Debug)]
pub struct ShapeFunctions<const D: usize> {
    /// Values `phi_K` of the functions; dimensionless.
    pub values: Vec<f64>,
    /// Gradients `phi_K,j` with respect to the evaluation point, or the corrected gradients in their place; 1/length.
    pub gradients: Vec<SVector<f64, D>>,
    /// Derivative `t` of the gradient `j` with respect to the evaluation point, row `j`, column `t`; 1/length^2. Symmetric unless the gradient is
    /// corrected.
    pub hessians: Vec<SMatrix<f64, D, D>>,
    /// Second derivatives with the normalization `alpha` held fixed, `alpha . (p W)_,jt`; for corrected gradients `C_mj W_,mt`. Shapes and units as
    /// for `hessians`.
    pub frozen_hessians: Vec<SMatrix<f64, D, D>>,
    /// Changes of the gradients when particles move, if [`Order::Sensitivities`] was requested.
    motion: Option<Motion<D>>,
}

/// Change of the gradient `phi_I,j` at a fixed point when a particle `K` moves; 1/length^2.
///
/// `d phi_I,j / d x_K,t = sum_b (d_jt alpha_b)_K (a_b)_I - (d_t alpha_b)_K (a_b,j)_I`: each product separates the dependence on `K`, through the
/// coefficients `alpha_b`, from the dependence on `I`. For `K = I` the change of the particle's term `a` is added.
#[derive(Clone, Debug)]
pub(crate) struct Motion<const D: usize> {
    /// Number of products in the sum.
    pub(crate) basis: usize,
    /// Factors `a_b` with their gradients, at `[I * basis + b]`.
    pub(crate) terms: Vec<(f64, SVector<f64, D>)>,
    /// `d alpha_b / d x_K,t` and its derivative `j` along the evaluation point (row `j`, column `t`), at `[K * basis + b]`.
    pub(crate) shifts: Vec<(SVector<f64, D>, SMatrix<f64, D, D>)>,
    /// Term added for `K = I`.
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

/// Highest derivatives of the shape functions to compute.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Values and first derivatives of the functions.
    First,
    /// Second derivatives with respect to the evaluation point, in addition to `First`.
    Second,
    /// Sensitivities to the motion of every particle, in addition to `Second`.
    Sensitivities,
}

impl<const D: usize> ShapeFunctions<D> {
    /// Derivative `d phi_I,j / d x_K,t`, row `j`, column `t`. NaN if the functions were computed without [`Order::Sensitivities`].
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

    /// Returns the changes of the gradients when particles move, if they were requested.
    pub(crate) fn motion(&self) -> Option<&Motion<D>> {
        self.motion.as_ref()
    }
}

impl Approximation {
    /// Returns the shape functions at a point from the weights of its neighbors at the relative positions `xi_K = x_K - x`.
    ///
    /// `raw_factor` is the ratio of particle volume to kernel integral. `length` scales the basis and affects only rounding errors.
    ///
    /// # Errors
    /// [`SingularMoment`] if the neighbors do not determine the coefficients.
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
