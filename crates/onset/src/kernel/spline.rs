//! B-splines, which are piecewise polynomials of `q` with `W(0) = 1`, and the hyperbolic kernel.
//!
//! Like all profiles they are inlined, so that profiles of several numbers compile to vector instructions.

use super::profile::{Profile, cusped, switch};
use crate::real::Real;

/// `scale sum c (a - q)^n` away from the origin.
#[inline(always)]
fn powers<R: Real, const N: usize>(
    q: R,
    degree: i32,
    scale: f64,
    terms: [(f64, f64); N],
) -> Profile<R> {
    let n = f64::from(degree);
    let mut sums = [R::constant(0.0); 3];
    for (c, a) in terms {
        for (sum, less) in sums.iter_mut().zip(0..) {
            *sum = *sum + (-q + a).powi(degree - less) * (c * scale);
        }
    }
    let [value, slope, curvature] = sums;
    Profile::from_derivatives(q, [value, slope * -n, curvature * (n * (n - 1.0))])
}

/// Cubic B-spline `2 ((1 - q)^3 - 4 (1/2 - q)^3)`, positive parts only.
#[inline(always)]
pub(super) fn cubic<R: Real>(q: R) -> Profile<R> {
    let inner = Profile {
        value: q * q * (q * 6.0 - 6.0) + 1.0,
        slope_over_q: q * 18.0 - 12.0,
        curvature_over_q: R::constant(18.0),
    };
    switch!(q, 0.5 => inner, powers(q, 3, 2.0, [(1.0, 1.0)]))
}

/// Quartic B-spline `125/46 ((1 - q)^4 - 5 (3/5 - q)^4 + 10 (1/5 - q)^4)`, positive parts only.
#[inline(always)]
pub(super) fn quartic<R: Real>(q: R) -> Profile<R> {
    const SCALE: f64 = 125.0 / 46.0;
    let square = q * q;
    let inner = Profile {
        value: square * (square * (375.0 / 23.0) - 150.0 / 23.0) + 1.0,
        slope_over_q: square * (1500.0 / 23.0) - 300.0 / 23.0,
        curvature_over_q: q * (3000.0 / 23.0),
    };
    let middle = [(1.0, 1.0), (-5.0, 0.6)];
    switch!(q, 0.2 => inner, 0.6 => powers(q, 4, SCALE, middle), powers(q, 4, SCALE, [(1.0, 1.0)]))
}

/// Quintic B-spline `81/22 ((1 - q)^5 - 6 (2/3 - q)^5 + 15 (1/3 - q)^5)`, positive parts only.
#[inline(always)]
pub(super) fn quintic<R: Real>(q: R) -> Profile<R> {
    const SCALE: f64 = 81.0 / 22.0;
    let square = q * q;
    let inner = Profile {
        value: square * (square * (-q + 1.0) * (405.0 / 11.0) - 90.0 / 11.0) + 1.0,
        slope_over_q: square * (q * (-2025.0 / 11.0) + 1620.0 / 11.0) - 180.0 / 11.0,
        curvature_over_q: q * (q * (-6075.0 / 11.0) + 3240.0 / 11.0),
    };
    let middle = [(1.0, 1.0), (-6.0, 2.0 / 3.0)];
    switch!(
        q,
        1.0 / 3.0 => inner,
        2.0 / 3.0 => powers(q, 5, SCALE, middle),
        powers(q, 5, SCALE, [(1.0, 1.0)])
    )
}

/// Hyperbolic kernel: `(s^3 - 6 s + 6) / 6` for `s = 2 q < 1`, `(2 - s)^3 / 6` for `s < 2`.
#[inline(always)]
pub(super) fn hyperbolic<R: Real>(q: R) -> Profile<R> {
    let inner = || {
        let square = q * q;
        let derivatives = || {
            [
                q * (square * (4.0 / 3.0) - 2.0) + 1.0,
                square * 4.0 - 2.0,
                q * 8.0,
            ]
        };
        cusped(q, R::constant(1.0), derivatives)
    };
    switch!(q, 0.5 => inner(), powers(q, 3, 4.0 / 3.0, [(1.0, 1.0)]))
}
