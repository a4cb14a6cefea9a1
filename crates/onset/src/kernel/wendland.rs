//! Wendland's functions: polynomials of minimal degree with a positive Fourier transform in a given dimension. The functions for one dimension differ
//! from those for two and three.

use super::profile::Profile;
use crate::real::Real;

/// C2 function: `(1 - q)^3 (1 + 3 q)` in one dimension, the paper's quartic; `(1 - q)^4 (1 + 4 q)` in two and three.
#[inline(always)]
pub(super) fn c2<const D: usize, R: Real>(q: R) -> Profile<R> {
    let p = -q + 1.0;
    if D == 1 {
        Profile {
            value: p * p * p * (q * 3.0 + 1.0),
            slope_over_q: p * -12.0 * p,
            curvature_over_q: p * 24.0,
        }
    } else {
        Profile {
            value: p.powi(4) * (q * 4.0 + 1.0),
            slope_over_q: p.powi(3) * -20.0,
            curvature_over_q: p * p * 60.0,
        }
    }
}

/// C4 function: `(1 - q)^5 (1 + 5 q + 8 q^2)` in one dimension; `(1 - q)^6 (1 + 6 q + 35/3 q^2)` in two and three.
#[inline(always)]
pub(super) fn c4<const D: usize, R: Real>(q: R) -> Profile<R> {
    let p = -q + 1.0;
    if D == 1 {
        Profile {
            value: p.powi(5) * (q * (q * 8.0 + 5.0) + 1.0),
            slope_over_q: p.powi(4) * (q * 4.0 + 1.0) * -14.0,
            curvature_over_q: p.powi(3) * q * 280.0,
        }
    } else {
        Profile {
            value: p.powi(6) * (q * (q * (35.0 / 3.0) + 6.0) + 1.0),
            slope_over_q: p.powi(5) * (q * 5.0 + 1.0) * (-56.0 / 3.0),
            curvature_over_q: p.powi(4) * q * 560.0,
        }
    }
}

/// C6 function: `(1 - q)^7 (1 + 7 q + 19 q^2 + 21 q^3)` in one dimension; `(1 - q)^8 (1 + 8 q + 25 q^2 + 32 q^3)` in two and three.
#[inline(always)]
pub(super) fn c6<const D: usize, R: Real>(q: R) -> Profile<R> {
    let p = -q + 1.0;
    if D == 1 {
        Profile {
            value: p.powi(7) * (q * (q * (q * 21.0 + 19.0) + 7.0) + 1.0),
            slope_over_q: p.powi(6) * (q * (q * 35.0 + 18.0) + 3.0) * -6.0,
            curvature_over_q: p.powi(5) * (q * 5.0 + 1.0) * q * 336.0,
        }
    } else {
        Profile {
            value: p.powi(8) * (q * (q * (q * 32.0 + 25.0) + 8.0) + 1.0),
            slope_over_q: p.powi(7) * (q * (q * 16.0 + 7.0) + 1.0) * -22.0,
            curvature_over_q: p.powi(6) * (q * 6.0 + 1.0) * q * 528.0,
        }
    }
}
