//! Polynomials times `exp(-s^2)`, with smooth truncation at `s = 3`.
//!
//! Such functions have infinite support. A plain truncation causes a jump at the rim, where neighbors enter and leave. Here the Taylor polynomial of
//! second order in `s^2` about the rim is subtracted, so that `W`, `W'` and `W''` vanish there, and the difference is divided by its value at the
//! origin. The subtracted part is 0.6 % of the Gaussian at the origin and 3.6 % of Laguerre-Gauss.

use super::profile::Profile;
use crate::algebra::Each;
use crate::real::Real;
use std::f64::consts::PI;

/// Value of `s^2` at the rim.
const END: f64 = 9.0;
/// Value of `exp(-9)` at the rim.
const RIM: f64 = 1.234_098_040_866_795_5e-4;
/// Error function at the rim, `erf(3)`.
const ERROR_FUNCTION: f64 = 0.999_977_909_503_001_4;

/// `(c0 + c1 t + c2 t^2) exp(-t)`, `t = 9 q^2`, minus its Taylor polynomial about `t = 9`.
pub(super) struct Exponential {
    polynomial: [f64; 3],
    /// Value and first two derivatives with respect to `t` at `t = 9`, times `exp(9)`.
    at_rim: [f64; 3],
}

/// Gaussian kernel, `exp(-s^2)` before truncation.
pub(super) const GAUSSIAN: Exponential = Exponential {
    polynomial: [1.0, 0.0, 0.0],
    at_rim: [1.0, -1.0, 1.0],
};

/// Laguerre-Gauss kernel, `(1 - s^2/2 + s^4/6) exp(-s^2)` before truncation.
pub(super) const LAGUERRE_GAUSS: Exponential = Exponential {
    polynomial: [1.0, -0.5, 1.0 / 6.0],
    at_rim: [10.0, -7.5, 16.0 / 3.0],
};

impl Exponential {
    /// Value at the origin before normalization.
    const fn peak(&self) -> f64 {
        let [value, first, second] = self.at_rim;
        self.polynomial[0] - RIM * (value - first * END + second * END * END / 2.0)
    }

    #[inline(always)]
    pub(super) fn profile<R: Real>(&self, q: R) -> Profile<R> {
        let [c0, c1, c2] = self.polynomial;
        let [b0, b1, b2] = self.at_rim.each(|b| b * RIM);
        let scale = 1.0 / self.peak();
        let t = q.powi(2) * END;
        let (u, exponential) = (t - END, (-t).exp());
        let p = t * (t * c2 + c1) + c0;
        let p1 = t * (2.0 * c2) + c1;
        // Derivatives with respect to t: f = p e, f' = (p' - p) e, f'' = (p'' - 2 p' + p) e.
        let value = p * exponential - (u * (u * (0.5 * b2) + b1) + b0);
        let first = (p1 - p) * exponential - (u * b2 + b1);
        let second = (p - p1 * 2.0 + 2.0 * c2) * exponential - b2;
        Profile {
            value: value * scale,
            slope_over_q: first * (2.0 * END * scale),
            curvature_over_q: second * q * (4.0 * END * END * scale),
        }
    }

    /// Returns the radial integral `int_0^1 W q^(D-1) dq`.
    pub(super) fn radial_integral<const D: usize>(&self) -> f64 {
        // E_n = int_0^3 s^n exp(-s^2) ds by parts: E_(n+2) = (n + 1)/2 E_n - 3^(n+1) exp(-9)/2.
        let mut whole = [0.0; 8];
        whole[0] = 0.5 * PI.sqrt() * ERROR_FUNCTION;
        whole[1] = 0.5 * (1.0 - RIM);
        for n in 0..6 {
            let power = 3.0_f64.powi(n as i32 + 1);
            whole[n + 2] = 0.5 * ((n + 1) as f64 * whole[n] - power * RIM);
        }
        let d = D as f64;
        let cut: f64 = (0..3)
            .map(|i| self.polynomial[i] * whole[D - 1 + 2 * i])
            .sum();
        let [value, first, second] = self.at_rim;
        // Integrals of q^(D-1) (q^2 - 1)^n dq for n = 0, 1, 2.
        let linear = 1.0 / (d + 2.0) - 1.0 / d;
        let square = 1.0 / (d + 4.0) - 2.0 / (d + 2.0) + 1.0 / d;
        let taylor = value / d + first * END * linear + 0.5 * second * END * END * square;
        (cut / 3.0_f64.powi(D as i32) - RIM * taylor) / self.peak()
    }
}
