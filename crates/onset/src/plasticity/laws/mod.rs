//! Laws other than Drucker-Prager, each defined by its yield function and flow.

mod damage;
mod gurson;
mod hill;
mod kinematic;
mod mohr_coulomb;
mod soil;

pub use damage::{DeformationTheory, ScalarDamage};
pub use gurson::Gurson;
pub use hill::HillOrthotropic;
pub use kinematic::Kinematic;
pub use mohr_coulomb::MohrCoulomb;
pub use soil::{CamClay, EllipticCap};

pub(super) use damage::{DAMAGE, DEFORMATION_THEORY, damage, deformation_theory};
pub(super) use gurson::{GURSON, gurson};
pub(super) use kinematic::{KINEMATIC, kinematic};
pub(super) use mohr_coulomb::{MOHR_COULOMB, mohr_coulomb};
pub(super) use soil::{CAM_CLAY, CAP, cam_clay, cap};
