//! Transfer of velocities between points and grid in one time step.

use crate::method::MethodError;

/// Transfer of the velocities of material points through the grid in a time step `dt`.
///
/// The velocities go to the nodes, `v_i = sum_p m_p N_ip (v_p + C_p (x_i - x_p)) / m_i`, change there, `v_i' = v_i + dt f_i / m_i`, and return to the
/// points.
/// Points and deformation follow `v_i'`: `x_p' = x_p + dt sum_i N_ip v_i'`, `F_p' = (1 + dt sum_i v_i' (x) grad N_ip) F_p`.
/// All functions are evaluated at the start of the step: symplectic Euler, with stresses updated last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Transfer {
    /// Limit of short steps of the fluid-implicit-particle transfer: equations in continuous time, stepped by any integrator.
    #[default]
    Continuous,
    /// Transfer without affine fields, `v_p' = sum_i N_ip v_i' + flip (v_p - sum_i N_ip v_i)`.
    ///
    /// The particle-in-cell transfer (Harlow 1964) has `flip = 0`, the fluid-implicit-particle transfer (Brackbill and Ruppel 1986) has `flip = 1`;
    /// other values blend both.
    Blended {
        /// Fraction of its velocity that a point keeps, from 0 to 1.
        flip: f64,
    },
    /// Affine particle-in-cell transfer (Jiang, Schroeder, Selle, Teran and Stomakhin 2015): `v_p' = sum_i N_ip v_i'` with affine fields
    /// `C_p' = sum_i N_ip v_i' (x) (x_i - x_p) D_p^-1`, `D_p = sum_i N_ip (x_i - x_p) (x) (x_i - x_p)`.
    Affine,
}

impl Transfer {
    /// Returns true if point velocities that vanish on the grid do not change.
    pub fn keeps_the_unseen(self) -> bool {
        matches!(self, Self::Continuous) || self == Self::Blended { flip: 1.0 }
    }

    /// Fraction of its velocity that a point keeps in a step; `None` in continuous time.
    pub(super) fn share_of_points(self) -> Option<f64> {
        match self {
            Self::Continuous => None,
            Self::Blended { flip } => Some(flip),
            Self::Affine => Some(0.0),
        }
    }

    /// Checks that the fraction is between 0 and 1.
    pub(super) fn check(self) -> Result<(), MethodError> {
        match self {
            Self::Blended { flip } if !(0.0..=1.0).contains(&flip) => Err(MethodError::Setting {
                name: "flip-share",
                value: flip,
                expected: "a number from 0 to 1",
            }),
            _ => Ok(()),
        }
    }
}
