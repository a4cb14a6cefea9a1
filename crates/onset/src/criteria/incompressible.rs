//! Incompressible response: isochoric states whose pressure leaves a face traction-free, and volume-preserving increments.
//!
//! An incompressible law is an energy of the states with `J = 1` and a pressure that the volume does not determine: `P = dW/dF - p cof F`,
//! `A = d^2 W/dF dF - p d^2 J/dF dF`. The energy of a compressible law can be used: its volumetric part adds a multiple of `cof F` to `P`, and
//! multiples of `cof F (x) cof F` and of `d^2 J/dF dF` to `A`. Volume-preserving increments, `cof F : Fdot = 0`, are affected by these terms only
//! through `p`. Source: Ogden, Non-linear elastic deformations (1984), sections 4.3 and 6.2.

use super::loading::{Loading, Mode};
use crate::algebra::{Each, array_of};
use crate::kinematics::DeformationGradient;
use crate::material::{
    FourthOrder, Hyperelastic, Response, cofactor, huge_bulk_modulus, with_pressure,
};
use nalgebra::{Matrix3, Vector3};

impl Loading {
    /// Loadings of an incompressible specimen: each has a free face that determines the pressure, and none appears twice.
    pub const INCOMPRESSIBLE: [Self; 4] = {
        use super::Lateral::{Free, PlaneStress};
        [
            Self {
                mode: Mode::Uniaxial,
                lateral: Free,
            },
            Self {
                mode: Mode::Equibiaxial,
                lateral: PlaneStress,
            },
            Self {
                mode: Mode::Planar,
                lateral: PlaneStress,
            },
            Self {
                mode: Mode::SimpleShear,
                lateral: PlaneStress,
            },
        ]
    };

    /// Isochoric state at `s = ln lambda` with its derivative with respect to `s`; `None` if the loading changes the volume.
    pub(super) fn isochoric(self, s: f64) -> Option<(Matrix3<f64>, Matrix3<f64>)> {
        use super::Lateral::{Free, Held, PlaneStrain, PlaneStress};
        let powers = match (self.mode, self.lateral) {
            (Mode::Uniaxial, Free) => [1.0, -0.5, -0.5],
            (Mode::Uniaxial | Mode::Planar, PlaneStrain) => [1.0, -1.0, 0.0],
            (Mode::Equibiaxial, PlaneStress | Free) => [1.0, 1.0, -2.0],
            (Mode::Planar, PlaneStress | Free) => [1.0, 0.0, -1.0],
            (Mode::SimpleShear, Free | PlaneStrain | PlaneStress) => return Some(self.imposed(s)),
            (_, Held) | (Mode::Equibiaxial | Mode::Hydrostatic | Mode::Uniaxial, _) => return None,
        };
        let stretches = Vector3::from(powers.each(|power: f64| (power * s).exp()));
        let rates = stretches.component_mul(&Vector3::from(powers));
        Some((
            Matrix3::from_diagonal(&stretches),
            Matrix3::from_diagonal(&rates),
        ))
    }

    /// Coordinate axes whose faces are traction-free in the isochoric loading.
    pub(super) fn free_faces(self) -> &'static [usize] {
        use super::Lateral::{Free, PlaneStrain};
        match (self.mode, self.lateral) {
            (Mode::Uniaxial | Mode::SimpleShear, Free) => &[1, 2],
            (Mode::Uniaxial, PlaneStrain) => &[1],
            (_, PlaneStrain) => &[],
            _ => &[2],
        }
    }
}

/// Largest relative difference of the deviatoric stresses of equal shapes; rounding of a bulk modulus of 1e12 shear moduli is smaller.
const SHAPE_STRESS_TOLERANCE: f64 = 1e-3;

/// Adds the volume change that corresponds to the pressure of a law with a finite bulk modulus, relative to the stress `other` of the same shape.
/// The Kirchhoff stress and the stiffness per reference volume against rates of deformation are kept.
pub(super) fn swollen(
    material: &dyn Hyperelastic,
    response: Response,
    other: &Matrix3<f64>,
    bulk: f64,
) -> Response {
    let f = response.deformation.matrix();
    let pressure = (response.first_piola - other).dot(&f) / 3.0;
    let growth = 1.0 + pressure / (3.0 * bulk);
    let f = f * growth;
    let components = array_of(|i| array_of(|j| f[(i, j)]));
    let deformation = DeformationGradient::from_components(components);
    let energy = material.energy_and_stress(&deformation);
    Response {
        energy: energy.map_or(response.energy, |(energy, _)| energy),
        deformation,
        first_piola: response.first_piola / growth,
        tangent: FourthOrder::from_fn(|i, j, k, l| {
            response.tangent[(i, j, k, l)] / (growth * growth)
        }),
    }
}

/// Returns true if the shape stiffness of an isotropic law hides behind the rounding of a huge bulk modulus, and depends on `J^(-1/3) F` alone.
pub(super) fn is_shape_separable(material: &dyn Hyperelastic) -> bool {
    let deviator = |stretches: [f64; 3]| {
        let f = DeformationGradient::from_stretches(stretches).ok()?;
        let response = material.isochoric_response(&f).ok()?;
        let tau = (response.first_piola * f.matrix().transpose()).diagonal();
        Some(tau.add_scalar(-tau.mean()))
    };
    let stretches = [1.3, 0.8, 1.1];
    let side = stretches.iter().product::<f64>().cbrt();
    let both = deviator(stretches).zip(deviator(stretches.each(|own: f64| own / side)));
    huge_bulk_modulus(material).is_some()
        && both.is_some_and(|(own, of_shape)| {
            (own - of_shape).amax() <= SHAPE_STRESS_TOLERANCE * own.amax()
        })
}

/// Response of a law at `J^(-1/3) F`, without pressure and stiffness against changes of volume.
///
/// The law is the sum of an energy of this shape and an energy of the volume. Waves and increments of constant volume then have the stiffness of this
/// response times `J^(-2/3)`. It lacks the rounding of the pressure, which is larger by orders of magnitude.
pub(super) fn of_shape(material: &dyn Hyperelastic, f: &DeformationGradient) -> Option<Response> {
    let side = f.jacobian().cbrt();
    let shape = f.components().each(|row| row.map(|own| own / side));
    let shape = DeformationGradient::new(shape).ok()?;
    let response = material.isochoric_response(&shape).ok()?;
    let tau = response.first_piola * shape.matrix().transpose();
    let pressure = tau.trace() / (3.0 * shape.jacobian());
    Some(preserving_volume(with_pressure(response, pressure)))
}

/// Response with the pressure that makes the normal traction on a face zero, without the stiffness against changes of volume.
pub(super) fn pressurized(response: Response, free_face: usize) -> Response {
    let face = (free_face, free_face);
    let pressure = response.first_piola[face] / cofactor(&response.deformation.matrix())[face];
    preserving_volume(with_pressure(response, pressure))
}

/// Response without stiffness against changes of volume.
fn preserving_volume(response: Response) -> Response {
    let cofactor = cofactor(&response.deformation.matrix());
    let mut dilation = 0.0;
    for (a, b) in (0..81).map(|n| (n / 9, n % 9)) {
        let (i, j, k, l) = (a / 3, a % 3, b / 3, b % 3);
        dilation += cofactor[(i, j)] * response.tangent[(i, j, k, l)] * cofactor[(k, l)];
    }
    dilation /= cofactor.norm_squared().powi(2);
    Response {
        tangent: FourthOrder::from_fn(|i, j, k, l| {
            response.tangent[(i, j, k, l)] - dilation * cofactor[(i, j)] * cofactor[(k, l)]
        }),
        ..response
    }
}

/// Orthonormal basis of the tensors in a span that are orthogonal to `normal`; it has one tensor fewer than `tensors`.
pub(super) fn orthogonal_to(tensors: &[Matrix3<f64>], normal: &Matrix3<f64>) -> Vec<Matrix3<f64>> {
    let mut mirror: Vec<f64> = tensors.iter().map(|tensor| tensor.dot(normal)).collect();
    let length = mirror.iter().map(|x| x * x).sum::<f64>().sqrt();
    // Householder's reflection maps the first tensor to the normal and the others to the basis.
    mirror[0] += if mirror[0] < 0.0 { -length } else { length };
    let square: f64 = mirror.iter().map(|x| x * x).sum();
    (1..tensors.len())
        .map(|own| {
            let part = 2.0 * mirror[own] / square;
            let reflected = tensors
                .iter()
                .zip(&mirror)
                .map(|(tensor, x)| tensor * (x * part));
            tensors[own] - reflected.sum::<Matrix3<f64>>()
        })
        .collect()
}

/// Stretches `lambda_i` along the principal axes.
pub(super) fn stretches_along(
    f: &DeformationGradient,
    left: &Matrix3<f64>,
    right: &Matrix3<f64>,
) -> Vector3<f64> {
    (left.transpose() * f.matrix() * right).diagonal()
}
