//! Isotropic moduli of a material, for methods that take nothing else of it.

use crate::kinematics::DeformationGradient;
use crate::material::{Hyperelastic, MaterialError};

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
        let tangent = material.response(&DeformationGradient::identity())?.tangent;
        let sum = |d: usize, entry: fn(usize, usize) -> (usize, usize, usize, usize)| -> f64 {
            let pairs = (0..d).flat_map(|i| (0..d).map(move |j| (i, j)));
            pairs.map(|(i, j)| tangent[entry(i, j)]).sum()
        };
        let d = if D == 1 { 3 } else { D };
        let across = sum(d, |i, j| (i, j, i, j)) - sum(d, |i, j| (i, i, j, j)) / d as f64;
        Ok(Self {
            bulk: sum(D, |i, j| (i, i, j, j)) / (D * D) as f64,
            shear: across / (d * d + d - 2) as f64,
        })
    }
}
