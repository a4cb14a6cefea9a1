//! Radial profiles in a form without singularity at the origin.

use crate::real::Real;

/// Radial profile `W(q)` with its derivatives, arranged so that gradient and Hessian over space are not singular at the origin.
///
/// With `y = x / R0` and `q = |y|`: `grad W = S y`, `Hess W = S 1 + (S' / q) y (x) y`, where `S = W'/q`, `S' = (W'' - W'/q) / q`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile<R> {
    /// Value `W(q)` of the profile; dimensionless.
    pub value: R,
    /// Slope over distance, `S = W'(q) / q`.
    pub slope_over_q: R,
    /// Derivative of the slope over distance, `S' = (W'' - W'/q) / q`.
    pub curvature_over_q: R,
}

impl<R: Real> Profile<R> {
    /// Profile of a zero weight.
    #[inline(always)]
    pub(super) fn zero() -> Self {
        let zero = R::constant(0.0);
        Self {
            value: zero,
            slope_over_q: zero,
            curvature_over_q: zero,
        }
    }

    /// Returns the profile from `W`, `W'` and `W''` away from the origin.
    #[inline(always)]
    pub(super) fn from_derivatives(q: R, [value, slope, curvature]: [R; 3]) -> Self {
        let slope_over_q = slope / q;
        Self {
            value,
            slope_over_q,
            curvature_over_q: (curvature - slope_over_q) / q,
        }
    }

    /// Returns a profile that encloses both of two profiles if `q` lies on both sides of a threshold.
    #[inline(always)]
    pub(super) fn blended(q: R, threshold: f64, below: Self, above: Self) -> Self {
        let either = |a: R, b: R| q.blended(threshold, a, b);
        Self {
            value: either(below.value, above.value),
            slope_over_q: either(below.slope_over_q, above.slope_over_q),
            curvature_over_q: either(below.curvature_over_q, above.curvature_over_q),
        }
    }
}

/// Evaluates one profile below a threshold of `q`, and another at and above it. Both are evaluated only if an interval contains the threshold or if
/// several numbers lie on both sides.
///
/// This is not a function of closures, because these would not be inlined.
macro_rules! switch {
    ($q:expr, $threshold:expr => $below:expr, $above:expr) => {{
        let (q, threshold) = ($q, $threshold);
        let side = q.side(threshold);
        let below = match side {
            Some($crate::real::Side::Above) => Profile::zero(),
            _ => $below,
        };
        match side {
            Some($crate::real::Side::Below) => below,
            _ => {
                let above = $above;
                match side {
                    Some(_) => above,
                    None => Profile::blended(q, threshold, below, above),
                }
            }
        }
    }};
    ($q:expr, $first:expr => $below:expr, $($rest:tt)+) => {
        switch!($q, $first => $below, switch!($q, $($rest)+))
    };
}
pub(super) use switch;

/// Largest distance, in support radii, at which a particle coincides with the evaluation point to rounding. There a cusped profile has the mean over
/// all directions, with zero gradient.
pub(super) const SELF_DISTANCE: f64 = 1e-12;

/// Profile with `W'(0) != 0`, for which `S = W'/q` is unbounded near the origin.
///
/// At the origin the gradient is zero by symmetry and the Hessian does not exist. Both are set to zero, because a particle does not move relative to
/// itself.
#[inline(always)]
pub(super) fn cusped<R: Real>(
    q: R,
    at_origin: R,
    derivatives: impl FnOnce() -> [R; 3],
) -> Profile<R> {
    let origin = Profile {
        value: at_origin,
        ..Profile::zero()
    };
    switch!(q, SELF_DISTANCE => origin, Profile::from_derivatives(q, derivatives()))
}
