//! Isotropic moduli of a material, for methods that use no other property of the law.

use crate::kinematics::DeformationGradient;
use crate::material::{FourthOrder, Hyperelastic, MaterialError};

/// Moduli of the isotropic tensor with the same sums `A_iijj` and `A_ijij` as the tangent in the reference state; stress.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moduli {
    /// Bulk modulus `kappa = lambda + 2 mu / D` in `D` dimensions.
    pub(super) bulk: f64,
    /// Shear modulus `mu`; in one dimension the shear modulus in three dimensions.
    pub(super) shear: f64,
}

impl Moduli {
    /// Moduli of a material in `D` dimensions.
    ///
    /// # Errors
    /// [`MaterialError`] if the material cannot be evaluated in the reference state.
    pub(super) fn of<const D: usize>(material: &dyn Hyperelastic) -> Result<Self, MaterialError> {
        let tangent = reference_tangent(material)?;
        let shear = match D {
            1 => shear::<3>(&tangent),
            _ => shear::<D>(&tangent),
        };
        Ok(Self {
            bulk: trace::<D>(&tangent) / (D * D) as f64,
            shear,
        })
    }
}

/// Shear modulus of a material in the reference state, positive, for forces between pairs of particles in `D` dimensions; stress.
///
/// # Errors
/// [`MaterialError`] if the material cannot be evaluated there, or if it has no stiffness against shear: a fluid, or a bar in uniaxial stress.
pub(super) fn shear_modulus<const D: usize>(
    material: &dyn Hyperelastic,
) -> Result<f64, MaterialError> {
    let tangent = reference_tangent(material)?;
    let modulus = match D.max(2).min(material.dimension()) {
        _ if D == 1 && material.dimension() == 3 => shear::<3>(&tangent),
        2 => shear::<2>(&tangent),
        3 => shear::<3>(&tangent),
        _ => 0.0,
    };
    // The modulus is a difference of these sums.
    let rounding = 1e-13 * trace::<3>(&tangent).abs();
    match modulus > rounding && modulus.is_finite() {
        true => Ok(modulus),
        false => Err(MaterialError::NoShearModulus),
    }
}

/// Tangent of a material in the reference state.
///
/// # Errors
/// [`MaterialError`] if the material cannot be evaluated there.
pub(super) fn reference_tangent(material: &dyn Hyperelastic) -> Result<FourthOrder, MaterialError> {
    Ok(material.response(&DeformationGradient::identity())?.tangent)
}

/// Sum `A_iijj` over `D` dimensions: `D^2` times the bulk modulus in `D` dimensions.
pub(super) fn trace<const D: usize>(tangent: &FourthOrder) -> f64 {
    pairs::<D>().map(|(i, j)| tangent[(i, i, j, j)]).sum()
}

/// Shear modulus of the isotropic tensor with the same sums in `D` dimensions, two or three.
fn shear<const D: usize>(tangent: &FourthOrder) -> f64 {
    let across: f64 = pairs::<D>().map(|(i, j)| tangent[(i, j, i, j)]).sum();
    (across - trace::<D>(tangent) / D as f64) / (D * D + D - 2) as f64
}

fn pairs<const D: usize>() -> impl Iterator<Item = (usize, usize)> {
    (0..D).flat_map(|i| (0..D).map(move |j| (i, j)))
}
