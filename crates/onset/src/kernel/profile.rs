//! Radial profiles in a form without singularity at the origin.

use crate::real::{Real, Side};

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
    /// The profile from `W`, `W'` and `W''` away from the origin.
    pub(super) fn from_derivatives(q: R, [value, slope, curvature]: [R; 3]) -> Self {
        let slope_over_q = slope / q;
        Self {
            value,
            slope_over_q,
            curvature_over_q: (curvature - slope_over_q) / q,
        }
    }

    /// One profile below a threshold of `q`, another at it and above; what holds both where an interval does not decide.
    pub(super) fn switch(
        q: R,
        threshold: f64,
        below: impl FnOnce() -> Self,
        above: impl FnOnce() -> Self,
    ) -> Self {
        match q.side(threshold) {
            Some(Side::Below) => below(),
            Some(Side::Above) => above(),
            None => {
                let (below, above) = (below(), above());
                let either = |a: R, b: R| q.blended(threshold, a, b);
                Self {
                    value: either(below.value, above.value),
                    slope_over_q: either(below.slope_over_q, above.slope_over_q),
                    curvature_over_q: either(below.curvature_over_q, above.curvature_over_q),
                }
            }
        }
    }
}

/// The distance, in support radii, below which a cusped profile is that of a particle with itself: the mean over all directions,
/// whose gradient is zero.
pub(super) const SELF: f64 = 1e-12;

/// A profile with `W'(0) != 0`: `S = W'/q` grows without bound towards the origin. At the origin itself the gradient is zero by
/// symmetry and there is no Hessian; both are taken as zero there, for a particle does not move relative to itself.
pub(super) fn cusped<R: Real>(
    q: R,
    at_origin: R,
    derivatives: impl FnOnce() -> [R; 3],
) -> Profile<R> {
    Profile::switch(
        q,
        SELF,
        || Profile {
            value: at_origin,
            slope_over_q: R::constant(0.0),
            curvature_over_q: R::constant(0.0),
        },
        || Profile::from_derivatives(q, derivatives()),
    )
}
