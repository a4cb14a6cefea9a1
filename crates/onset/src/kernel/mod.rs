//! Weight functions with compact support.
//!
//! All kernels are functions of the distance in units of the support radius, `q = |x| / R0`, equal to one at the origin and zero for `q >= 1`.
//! Codes that use a smoothing length `h` place the rim at `2 h`, `2.5 h` or `3 h`. Here the user sets the radius.
//! [`Kernel::support_over_smoothing_length`] converts it by the standard deviation, which does not depend on such conventions.

mod description;
mod error;
mod exponential;
mod formula;
mod moments;
mod profile;
mod smoothness;
mod spline;
mod wendland;

pub use error::KernelError;
pub use formula::FormulaKernel;
pub use profile::Profile;
pub use smoothness::Smoothness;

use crate::real::Real;
use nalgebra::{SMatrix, SVector};
use profile::switch;

/// Relative distance at which a particle counts as on the rim, where the weight is zero. Such a particle is not a neighbor.
const RIM: f64 = 1.0 - 1e-12;

/// Weight function `W(q)` of the distance in units of the support radius: one at the origin, zero for `q >= 1`.
///
/// A kernel is read from text and written as text, by name or as a formula of `q`:
///
/// ```
/// use onset::kernel::Kernel;
/// let cubic: Kernel = "cubic-spline".parse()?;
/// assert_eq!(cubic, Kernel::CubicSpline);
/// let own: Kernel = "(1 - q)^2*(1 + 2*q)".parse()?;
/// assert_eq!(own.to_string(), "(1 - q)^2*(1 + 2*q)");
/// # Ok::<(), onset::kernel::KernelError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// Quartic spline, equation (35): `W = 1 - 6 q^2 + 8 q^3 - 3 q^4 = (1 - q)^3 (1 + 3 q)`.
    ///
    /// `W`, `W'` and `W''` vanish at `q = 1`; the third derivative jumps there and at `q = 0`. It is Wendland's C2 function of one dimension.
    QuarticSpline,
    /// Cubic B-spline M4, `2 (1 - q)^3 - 8 (1/2 - q)^3`, positive parts only; Monaghan's spline with `R0 = 2 h`.
    CubicSpline,
    /// Quartic B-spline M5, with `R0 = 5/2 h`.
    QuarticBSpline,
    /// Quintic B-spline M6, with `R0 = 3 h`.
    QuinticSpline,
    /// Wendland's twice differentiable function, for one dimension or for three.
    WendlandC2,
    /// Wendland's four times differentiable function, for one dimension or for three.
    WendlandC4,
    /// Wendland's six times differentiable function, for one dimension or for three.
    WendlandC6,
    /// Gaussian `exp(-9 q^2)`, so that `R0 = 3 h`, minus its Taylor polynomial of second order in `q^2` about the rim.
    Gaussian,
    /// Hyperbolic kernel with `R0 = 2 h`; its slope at the origin is nonzero.
    Hyperbolic,
    /// Laguerre-Gauss kernel `(1 - s^2/2 + s^4/6) exp(-s^2)`, `s = 3 q`, truncated like the Gaussian.
    LaguerreGauss,
    /// User-defined formula of `q`.
    Formula(FormulaKernel),
}

/// Weight with its first and second derivatives with respect to the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weight<const D: usize> {
    /// Value `W` of the weight; dimensionless.
    pub value: f64,
    /// Gradient `W_,j` of the weight; 1/length.
    pub gradient: SVector<f64, D>,
    /// Second derivatives `W_,jt`; 1/length^2.
    pub hessian: SMatrix<f64, D, D>,
}

impl Kernel {
    /// All named kernels, without formulas.
    pub const ALL: [Self; 10] = [
        Self::QuarticSpline,
        Self::CubicSpline,
        Self::QuarticBSpline,
        Self::QuinticSpline,
        Self::WendlandC2,
        Self::WendlandC4,
        Self::WendlandC6,
        Self::Gaussian,
        Self::Hyperbolic,
        Self::LaguerreGauss,
    ];

    /// Returns the profile within the support, `0 <= q <= 1`. It is not valid beyond the support, where the weight is zero.
    ///
    /// ```
    /// use onset::kernel::Kernel;
    /// let profile = Kernel::CubicSpline.profile::<3, f64>(0.5);
    /// assert_eq!(profile.value, 0.25);
    /// assert_eq!(profile.slope_over_q, -3.0);
    /// ```
    #[inline(always)]
    pub fn profile<const D: usize, R: Real>(self, q: R) -> Profile<R> {
        match self {
            Self::QuarticSpline => wendland::c2::<1, R>(q),
            Self::CubicSpline => spline::cubic(q),
            Self::QuarticBSpline => spline::quartic(q),
            Self::QuinticSpline => spline::quintic(q),
            Self::WendlandC2 => wendland::c2::<D, R>(q),
            Self::WendlandC4 => wendland::c4::<D, R>(q),
            Self::WendlandC6 => wendland::c6::<D, R>(q),
            Self::Gaussian => exponential::GAUSSIAN.profile(q),
            Self::Hyperbolic => spline::hyperbolic(q),
            Self::LaguerreGauss => exponential::LAGUERRE_GAUSS.profile(q),
            Self::Formula(formula) => formula.profile(q),
        }
    }

    /// Returns the profile at any distance, zero beyond the support.
    #[inline(always)]
    pub(crate) fn profile_anywhere<const D: usize, R: Real>(self, q: R) -> Profile<R> {
        switch!(q, RIM => self.profile::<D, R>(q), Profile::zero())
    }

    /// Returns the weight of a particle at the position `x` relative to the evaluation point, or `None` outside of the support.
    ///
    /// The distance is measured as `q = |metric x| / radius`, and derivatives are taken with respect to `x`.
    /// The metric is the identity for a spherical support and `F^-1` for a convected support.
    ///
    /// ```
    /// use nalgebra::{Matrix2, Vector2};
    /// use onset::kernel::Kernel;
    /// let weight = Kernel::QuarticSpline.weight(&Vector2::new(1.0, 0.0), 2.0, &Matrix2::identity());
    /// assert_eq!(weight.map(|weight| weight.value), Some(0.3125));
    /// ```
    pub fn weight<const D: usize>(
        self,
        x: &SVector<f64, D>,
        radius: f64,
        metric: &SMatrix<f64, D, D>,
    ) -> Option<Weight<D>> {
        let y = metric * x / radius;
        let q = y.norm();
        if q >= RIM {
            return None;
        }
        let profile = self.profile::<D, f64>(q);
        // With respect to y: grad = (W'/q) y, Hessian = (W'/q) 1 + ((W'' - W'/q)/q^2) y (x) y; then the chain rule.
        let map = metric / radius;
        let mut hessian = SMatrix::<f64, D, D>::identity() * profile.slope_over_q;
        if q > 0.0 {
            hessian += y * y.transpose() * (profile.curvature_over_q / q);
        }
        Some(Weight {
            value: profile.value,
            gradient: map.transpose() * y * profile.slope_over_q,
            hessian: map.transpose() * hessian * map,
        })
    }
}
