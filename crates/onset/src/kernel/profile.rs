//! Radial profiles in a form without singularity at the origin.

use crate::real::Real;

/// A radial profile `W(q)` with its derivatives, arranged so that gradient and Hessian over space need no quotient that is
/// singular at the origin: with `y = x / R0`, `q = |y|`,
///
/// `grad W = S y`, `Hess W = S 1 + (S' / q) y (x) y`, where `S = W'/q`, `S' = (W'' - W'/q) / q`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile<R> {
    /// `W(q)`, dimensionless.
    pub value: R,
    /// `S = W'(q) / q`.
    pub slope_over_q: R,
    /// `S' = (W'' - W'/q) / q`.
    pub curvature_over_q: R,
}

impl<R: Real> Profile<R> {
    /// That of no weight.
    #[inline(always)]
    pub(super) fn zero() -> Self {
        let zero = R::constant(0.0);
        Self {
            value: zero,
            slope_over_q: zero,
            curvature_over_q: zero,
        }
    }

    /// The profile from `W`, `W'` and `W''` away from the origin.
    #[inline(always)]
    pub(super) fn from_derivatives(q: R, [value, slope, curvature]: [R; 3]) -> Self {
        let slope_over_q = slope / q;
        Self {
            value,
            slope_over_q,
            curvature_over_q: (curvature - slope_over_q) / q,
        }
    }

    /// What stands for both of two profiles where `q` is on both sides of a threshold.
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

/// One profile below a threshold of `q`, another at it and above, of which only what is asked for is evaluated; both where an interval does not decide, or several
/// numbers do not agree. No function of closures: those would not be inlined.
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

/// The distance, in support radii, below which a cusped profile is that of a particle with itself: the mean over all directions,
/// whose gradient is zero.
pub(super) const SELF: f64 = 1e-12;

/// A profile with `W'(0) != 0`: `S = W'/q` grows without bound towards the origin. At the origin itself the gradient is zero by
/// symmetry and there is no Hessian; both are taken as zero there, for a particle does not move relative to itself.
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
    switch!(q, SELF => origin, Profile::from_derivatives(q, derivatives()))
}
