//! Weight functions of compact support.

use crate::real::Real;
use nalgebra::{SMatrix, SVector};

/// A weight function `W(q)` of the distance in units of the support radius, zero for `q >= 1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Kernel {
    /// The quartic spline, equation (35): `W = 1 - 6 q^2 + 8 q^3 - 3 q^4 = (1 - q)^3 (1 + 3 q)`.
    /// `W`, `W'` and `W''` vanish at `q = 1`; the third derivative jumps there and at `q = 0`.
    QuarticSpline,
}

/// A weight with its first and second derivatives with respect to the position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weight<const D: usize> {
    /// `W`, dimensionless.
    pub value: f64,
    /// `W_,j`; 1/length.
    pub gradient: SVector<f64, D>,
    /// `W_,jt`; 1/length^2.
    pub hessian: SMatrix<f64, D, D>,
}

/// The radial profile in a form that has no singularity at the origin.
pub(crate) struct Profile<R> {
    pub(crate) value: R,
    /// `W'(q) / q`.
    pub(crate) slope_over_q: R,
    /// `(W'' - W'/q) / q^2` times `q`, finite at zero.
    pub(crate) curvature_over_q: R,
}

impl Kernel {
    /// The profile within the support, `q <= 1`, where it ends with the value, slope and curvature zero.
    pub(crate) fn profile<R: Real>(self, q: R) -> Profile<R> {
        match self {
            Self::QuarticSpline => {
                let p = -q + 1.0;
                Profile {
                    value: p * p * p * (q * 3.0 + 1.0),
                    slope_over_q: p * -12.0 * p,
                    curvature_over_q: p * 24.0,
                }
            }
        }
    }

    /// The weight of a particle at the position `x` relative to the evaluation point, with the
    /// distance measured as `q = |metric x| / radius`, and derivatives with respect to `x`.
    ///
    /// The metric is the identity for a spherical support, `F^-1` for one that is convected.
    /// `None` outside of the support.
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
        // Where rounding decides, a particle on the rim, whose weight is zero, does not count as a neighbor.
        if q >= 1.0 - 1e-12 {
            return None;
        }
        let profile = self.profile(q);
        // In y: grad = (W'/q) y, Hessian = (W'/q) 1 + ((W'' - W'/q)/q^2) y (x) y; then the chain rule.
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

    /// The integral of `W(|x| / radius)` over space; length^D.
    pub fn integral<const D: usize>(self, radius: f64) -> f64 {
        use std::f64::consts::PI;
        let unit = match (self, D) {
            (Self::QuarticSpline, 1) => 4.0 / 5.0,
            (Self::QuarticSpline, 2) => PI / 5.0,
            (Self::QuarticSpline, _) => 16.0 * PI / 105.0,
        };
        unit * radius.powi(D as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::Kernel;
    use nalgebra::{SMatrix, SVector};

    /// Radial quadrature (midpoint rule) of the kernel over the unit ball.
    fn integrated<const D: usize>(kernel: Kernel) -> f64 {
        let surface = [2.0, std::f64::consts::TAU, 2.0 * std::f64::consts::TAU][D - 1];
        let n = 20_000;
        (0..n)
            .map(|i| {
                let q = (f64::from(i) + 0.5) / f64::from(n);
                let x = SVector::<f64, D>::from_fn(|j, _| if j == 0 { q } else { 0.0 });
                let weight = kernel
                    .weight(&x, 1.0, &SMatrix::identity())
                    .map_or(0.0, |w| w.value);
                surface * weight * q.powi(D as i32 - 1) / f64::from(n)
            })
            .sum()
    }

    #[test]
    fn integral_is_the_quadrature_of_the_weight() {
        let kernel = Kernel::QuarticSpline;
        assert!((kernel.integral::<1>(1.0) - integrated::<1>(kernel)).abs() < 1e-8);
        assert!((kernel.integral::<2>(1.0) - integrated::<2>(kernel)).abs() < 1e-8);
        assert!((kernel.integral::<3>(1.0) - integrated::<3>(kernel)).abs() < 1e-8);
        assert!((kernel.integral::<2>(2.5) / kernel.integral::<2>(1.0) - 6.25).abs() < 1e-14);
    }

    #[test]
    fn equation_35_as_printed_equals_the_factored_form() {
        for q in [0.0_f64, 0.1, 0.5, 0.9, 0.999] {
            let x = SVector::<f64, 2>::new(q * 1.7, 0.0);
            let weight = Kernel::QuarticSpline
                .weight(&x, 1.7, &SMatrix::identity())
                .expect("inside");
            let printed = 1.0 - 6.0 * q.powi(2) + 8.0 * q.powi(3) - 3.0 * q.powi(4);
            assert!((weight.value - printed).abs() < 1e-14);
        }
    }

    #[test]
    fn derivatives_are_those_of_the_value_also_with_an_elliptic_metric() {
        let kernel = Kernel::QuarticSpline;
        let metric = SMatrix::<f64, 2, 2>::new(0.9, 0.2, -0.1, 1.2);
        let at = |x: SVector<f64, 2>| kernel.weight(&x, 2.0, &metric).expect("inside");
        let x = SVector::<f64, 2>::new(0.7, -0.4);
        let h = 1e-5;
        for j in 0..2 {
            let mut step = SVector::zeros();
            step[j] = h;
            let (plus, minus) = (at(x + step), at(x - step));
            assert!(((plus.value - minus.value) / (2.0 * h) - at(x).gradient[j]).abs() < 1e-9);
            let second = (plus.gradient - minus.gradient) / (2.0 * h);
            assert!((second - at(x).hessian.column(j)).amax() < 1e-8);
        }
    }
}
