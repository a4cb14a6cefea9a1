//! How velocities go from the points to the grid and back in a step.

use crate::method::MethodError;

/// How the velocities of material points go through the grid in a step of time `dt`: to the nodes,
/// `v_i = sum_p m_p N_ip (v_p + C_p (x_i - x_p)) / m_i`; there `v_i' = v_i + dt f_i / m_i`; and back. Points and deformation follow
/// `v_i'`, `x_p' = x_p + dt sum_i N_ip v_i'`, `F_p' = (1 + dt sum_i v_i' (x) grad N_ip) F_p`, all with the functions at the start of the
/// step: symplectic Euler, stresses updated last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Transfer {
    /// The limit of short steps of the fluid-implicit-particle transfer: equations in continuous time, stepped by any integrator.
    #[default]
    Continuous,
    /// `v_p' = sum_i N_ip v_i' + flip (v_p - sum_i N_ip v_i)` without affine fields: the particle-in-cell transfer (Harlow 1964) at
    /// `flip = 0`, the fluid-implicit-particle transfer (Brackbill and Ruppel 1986) at 1, and blends of both.
    Blended {
        /// The share of its own velocity that a point keeps, from 0 to 1.
        flip: f64,
    },
    /// `v_p' = sum_i N_ip v_i'` with affine fields `C_p' = sum_i N_ip v_i' (x) (x_i - x_p) D_p^-1`,
    /// `D_p = sum_i N_ip (x_i - x_p) (x) (x_i - x_p)`: the affine particle-in-cell transfer (Jiang, Schroeder, Selle, Teran and
    /// Stomakhin 2015).
    Affine,
}

impl Transfer {
    /// Whether velocities of points that the grid does not see stay as they are.
    pub fn keeps_the_unseen(self) -> bool {
        matches!(self, Self::Continuous) || self == Self::Blended { flip: 1.0 }
    }

    /// The share of its own velocity that a point keeps in a step; none in continuous time.
    pub(super) fn share_of_points(self) -> Option<f64> {
        match self {
            Self::Continuous => None,
            Self::Blended { flip } => Some(flip),
            Self::Affine => Some(0.0),
        }
    }

    /// That the share is one.
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
