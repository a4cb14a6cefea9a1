//! What nearly incompressible laws share: volume and shape taken apart.

use crate::kinematics::Invariants;
use crate::real::Real;

/// `(J^2 - 1)/2 - ln J`: convex in `J`, grows without bound towards both ends; second derivative 2 at `J = 1`. Source: Simo and
/// Taylor, Comput. Methods Appl. Mech. Eng. 85 (1991) 273.
pub(super) fn polyconvex<R: Real>(jacobian: R) -> R {
    (jacobian * jacobian - 1.0) * 0.5 - jacobian.ln()
}

/// `J^(-2/3) I1`, the first invariant of the change of shape alone.
pub(super) fn isochoric_first<R: Real>(i: &Invariants<R>) -> R {
    i.first * i.jacobian.powf(-2.0 / 3.0)
}

/// `J^(-4/3) I2`, the second invariant of the change of shape alone.
pub(super) fn isochoric_second<R: Real>(i: &Invariants<R>) -> R {
    i.second * i.jacobian.powf(-4.0 / 3.0)
}
