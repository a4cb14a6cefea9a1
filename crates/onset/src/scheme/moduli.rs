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
