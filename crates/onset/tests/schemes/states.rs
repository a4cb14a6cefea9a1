//! Materials and states that are common to the tests of schemes.

use nalgebra::{Rotation3, SMatrix, Vector3};
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, Law};

/// Saint Venant-Kirchhoff law with the given Lame constants.
pub fn saint_venant_kirchhoff(lambda: f64, mu: f64) -> Box<dyn Hyperelastic> {
    let law = Law::named("saint-venant-kirchhoff").expect("a law of the library");
    law.build(&[("lambda", lambda), ("mu", mu)])
        .expect("a material")
}

/// Stretched and sheared state without symmetry.
pub fn sheared<const D: usize>() -> DeformationGradient {
    let all = [[1.1, 0.12, -0.05], [0.04, 0.93, 0.08], [0.07, -0.03, 1.06]];
    DeformationGradient::identity().with_leading(&SMatrix::<f64, D, D>::from_fn(|i, j| all[i][j]))
}

/// Rotation within `D` dimensions.
pub fn turned<const D: usize>() -> SMatrix<f64, D, D> {
    let axis = match D {
        2 => Vector3::z(),
        _ => Vector3::new(0.3, -0.5, 0.8).normalize(),
    };
    let rotation = Rotation3::new(axis * 0.6);
    match D {
        1 => SMatrix::identity(),
        _ => SMatrix::from_fn(|i, j| rotation[(i, j)]),
    }
}
