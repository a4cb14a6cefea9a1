//! Transfer of velocities between points and grid in one time step.

use crate::bloch::VelocityFilter;
use crate::method::MethodError;

/// Largest order of an approximation of the full mass matrix.
const MAXIMUM_ORDER: u32 = 100;

/// Transfer of the velocities of material points through the grid in a time step `dt`.
///
/// The velocities are transferred to the nodes, `v_i = sum_p m_p N_ip (v_p + C_p (x_i - x_p)) / m_i`, updated there, `v_i' = v_i + dt f_i / m_i`, and
/// transferred back to the points. Points and deformation follow `v_i'`: `x_p' = x_p + dt sum_i N_ip v_i'`, `F_p' = (1 + dt sum_i v_i' (x) grad N_ip)
/// F_p`. All functions are evaluated at the start of the step: symplectic Euler, with stresses updated last.
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
        /// Fraction of its previous velocity that a point keeps, from 0 to 1.
        flip: f64,
    },
    /// Affine particle-in-cell transfer (Jiang, Schroeder, Selle, Teran and Stomakhin 2015): `v_p' = sum_i N_ip v_i'` with affine fields
    /// `C_p' = sum_i N_ip v_i' (x) (x_i - x_p) D_p^-1`, `D_p = sum_i N_ip (x_i - x_p) (x) (x_i - x_p)`.
    Affine,
    /// Extended particle-in-cell transfer XPIC(k) (Hammerquist and Nairn 2017): `v_p' = sum_i N_ip (v_i^k + v_i' - v_i)`.
    ///
    /// The velocities `v^k = (1 + A + ... + A^(k-1)) v`, `A_ij = delta_ij - sum_p m_p N_ip N_jp / m_i`, replace the lumped masses in the transfer to the
    /// nodes by an approximation of the full mass matrix of order `k`. Point velocities without effect on the grid are removed in one step.
    Extended {
        /// Order `k`, from 1 (the particle-in-cell transfer) to 100.
        order: u32,
    },
    /// Full mass matrix transfer FMPM(k) (Nairn and Hammerquist 2021): the velocities `v^k` of the nodes after the forces move and strain the points,
    /// which receive these velocities, `v_p' = sum_i N_ip v_i'^k`, `x_p' = x_p + dt v_p'`, `F_p' = (1 + dt sum_i v_i'^k (x) grad N_ip) F_p`.
    FullMass {
        /// Order `k`, from 1 (the particle-in-cell transfer) to 100.
        order: u32,
    },
}

impl Transfer {
    /// Returns true if point velocities that vanish on the grid do not change.
    pub fn keeps_the_unseen(self) -> bool {
        matches!(self, Self::Continuous) || self == Self::Blended { flip: 1.0 }
    }

    /// Velocities that points receive from the grid in a step; `None` in continuous time.
    pub(super) fn filter(self) -> Option<VelocityFilter> {
        match self {
            Self::Continuous => None,
            Self::Blended { flip } => Some(VelocityFilter::Blended { flip }),
            Self::Affine => Some(VelocityFilter::Blended { flip: 0.0 }),
            Self::Extended { order } => Some(VelocityFilter::Extended { order }),
            Self::FullMass { order } => Some(VelocityFilter::FullMass { order }),
        }
    }

    /// Checks that the fraction is between 0 and 1, and that the order is in its range.
    pub(super) fn check(self) -> Result<(), MethodError> {
        match self {
            Self::Blended { flip } if !(0.0..=1.0).contains(&flip) => Err(MethodError::Setting {
                name: "flip-share",
                value: flip,
                expected: "a number from 0 to 1",
            }),
            Self::Extended { order } | Self::FullMass { order }
                if !(1..=MAXIMUM_ORDER).contains(&order) =>
            {
                Err(MethodError::Setting {
                    name: "transfer-order",
                    value: f64::from(order),
                    expected: "a whole number from 1 to 100",
                })
            }
            _ => Ok(()),
        }
    }
}
