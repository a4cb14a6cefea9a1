//! Response of laws whose stiffness against changes of volume hides all other stiffnesses.

use super::{FourthOrder, Hyperelastic, Response, cofactor};
use nalgebra::Matrix3;

/// Ratio of shear to bulk modulus that is a rounding error, as for fluids.
const SHEAR_ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Smallest ratio of bulk to shear modulus that counts as infinite. Results differ by no more than the inverse ratio, while rounding of the volume
/// change would cost the pressure of a compressible law more digits.
const STIFF: f64 = 5e7;

/// Bulk modulus of a law in the reference configuration, if it counts as infinite.
pub(crate) fn huge_bulk_modulus(material: &dyn Hyperelastic) -> Option<f64> {
    bulk_modulus_above(material, STIFF)
}

/// Bulk modulus of a law in the reference configuration, if its ratio to the shear modulus exceeds a number.
pub(crate) fn bulk_modulus_above(material: &dyn Hyperelastic, ratio: f64) -> Option<f64> {
    if material.dimension() < 3 || material.is_path_dependent() {
        return None;
    }
    let response = material.undeformed().ok()?;
    let shear = response.tangent[(0, 1, 0, 1)];
    let bulk = response.tangent[(0, 0, 0, 0)] - shear * (4.0 / 3.0);
    (shear > SHEAR_ROUNDING * bulk && bulk > ratio * shear).then_some(bulk)
}

/// Second derivative `d^2 J / dF_iJ dF_kL = e_ikm e_JLN F_mN` of the volume ratio.
fn second_derivative_of_volume(f: &Matrix3<f64>) -> FourthOrder {
    let sign = |a: usize, b: usize, c: usize| match (3 + b - a) % 3 {
        _ if a == b || b == c || a == c => 0.0,
        1 => 1.0,
        _ => -1.0,
    };
    FourthOrder::from_fn(|i, j, k, l| {
        if i == k || j == l {
            return 0.0;
        }
        let (m, n) = (3 - i - k, 3 - j - l);
        sign(i, k, m) * sign(j, l, n) * f[(m, n)]
    })
}

/// Response with an additional pressure.
pub(crate) fn with_pressure(response: Response, pressure: f64) -> Response {
    let f = response.deformation.matrix();
    let second = second_derivative_of_volume(&f);
    Response {
        first_piola: response.first_piola - cofactor(&f) * pressure,
        tangent: FourthOrder::from_fn(|i, j, k, l| {
            response.tangent[(i, j, k, l)] - pressure * second[(i, j, k, l)]
        }),
        ..response
    }
}
