//! Volumetric and isochoric parts of nearly incompressible laws.

use crate::kinematics::{DeformationGradient, Invariants};
use crate::real::Real;

/// Logarithm `ln |J|` of the change of volume, from the determinant.
///
/// The logarithms of the principal stretches add up to the same value, with a rounding error that is larger by the ratio of the largest to the smallest
/// stretch: the stretches follow from the eigenvalues of `F^T F`. The bulk modulus multiplies the error.
pub(super) fn logarithmic<R: Real>(f: &DeformationGradient<R>) -> R {
    let jacobian = f.determinant();
    (jacobian * jacobian).ln() * 0.5
}

/// Volumetric energy `(J^2 - 1)/2 - ln J`: convex in `J`, unbounded toward both ends, with second derivative 2 at `J = 1`. Source: Simo and Taylor,
/// Comput. Methods Appl. Mech. Eng. 85 (1991) 273.
pub(super) fn polyconvex<R: Real>(jacobian: R) -> R {
    (jacobian * jacobian - 1.0) * 0.5 - jacobian.ln()
}

/// Isochoric first invariant `J^(-2/3) I1`.
pub(super) fn isochoric_first<R: Real>(i: &Invariants<R>) -> R {
    i.first * i.jacobian.powf(-2.0 / 3.0)
}

/// Isochoric second invariant `J^(-4/3) I2`.
pub(super) fn isochoric_second<R: Real>(i: &Invariants<R>) -> R {
    i.second * i.jacobian.powf(-4.0 / 3.0)
}
