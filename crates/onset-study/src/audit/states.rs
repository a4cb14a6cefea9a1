//! The states at which a material is audited unless others are named.

use nalgebra::{Matrix3, Rotation3};
use onset::kinematics::{DeformationGradient, KinematicsError};

/// Six states with strains of about the given amount: tension, compression, shear, a general state without and with a rotation, and
/// a change of volume with shear. In the general ones nothing is aligned, symmetric or isochoric, so that no two conventions agree.
///
/// # Errors
/// [`KinematicsError`] when the strain is so large that matter is turned inside out.
///
/// ```
/// let states = onset_study::audit::states(0.2)?;
/// assert_eq!(states.len(), 6);
/// assert!((states[0].jacobian() - 1.2).abs() < 1e-15);
/// # Ok::<(), onset::kinematics::KinematicsError>(())
/// ```
pub fn states(strain: f64) -> Result<Vec<DeformationGradient>, KinematicsError> {
    let one: Matrix3<f64> = Matrix3::identity();
    let tension = Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let shear = Matrix3::new(0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let general = Matrix3::new(0.9, 0.6, -0.3, 0.2, -0.7, 0.5, 0.1, -0.2, 0.4);
    let volume = Matrix3::new(0.5, 0.0, 0.0, 0.0, 0.4, 0.8, 0.0, 0.0, 0.6);
    let rotation = Rotation3::from_euler_angles(0.7, -0.4, 1.1);
    [
        one + strain * tension,
        one - strain * tension,
        one + strain * shear,
        one + strain * general,
        rotation.matrix() * (one - strain * general),
        one + strain * volume,
    ]
    .iter()
    .map(super::subject::deformation)
    .collect()
}
