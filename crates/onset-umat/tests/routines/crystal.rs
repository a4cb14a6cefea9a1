//! Crystal with one slip system, compared with closed forms: slip, tangent, and the acoustic tensor of the slip plane.

use crate::{settings, state};
use nalgebra::{Matrix3, Vector3};
use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, Response};
use onset_umat::{Umat, UmatSettings};

const SHEAR: f64 = 26.0;
const STRENGTH: f64 = 0.1;
const ANGLE: f64 = 35.0;

fn crystal(hardening: f64) -> Umat {
    let properties = [SHEAR, 50.0, STRENGTH, hardening, ANGLE];
    Umat::new(UmatSettings {
        state_variables: 1,
        ..settings(&["fortran/single_slip.f90"], &properties)
    })
    .expect("a UMAT")
}

/// Slip direction and slip plane normal.
fn system() -> (Vector3<f64>, Vector3<f64>) {
    let (sine, cosine) = ANGLE.to_radians().sin_cos();
    (
        Vector3::new(cosine, sine, 0.0),
        Vector3::new(-sine, cosine, 0.0),
    )
}

/// States with slip in either direction, with rotation and out-of-plane shear.
fn states() -> [DeformationGradient; 3] {
    [
        state([[1.1, 0.0, 0.0], [0.0, 0.93, 0.0], [0.0, 0.0, 1.0]]),
        state([[0.9, 0.2, 0.05], [-0.1, 1.1, 0.0], [0.02, -0.1, 1.02]]),
        state([[1.0, -0.3, 0.0], [0.3, 1.05, 0.1], [0.0, 0.0, 0.97]]),
    ]
}

fn respond(umat: &Umat, f: &Matrix3<f64>) -> Response {
    let f = state(std::array::from_fn(|i| std::array::from_fn(|j| f[(i, j)])));
    umat.response(&f).expect("a response")
}

#[test]
fn slip_follows_schmid_and_the_tangent_is_consistent_with_the_stress() {
    let (s, m) = system();
    for hardening in [0.5, 0.0, -0.3] {
        let umat = crystal(hardening);
        for f in states() {
            let outcome = umat
                .along(umat.path(&f).expect("a path"))
                .expect("an outcome");
            let slip = outcome.state_variables[0];
            // Resolved shear from the Cauchy stress and the lattice vectors, independent of the routine's output.
            let elastic = f.matrix() * (Matrix3::identity() - s * m.transpose() * slip);
            let normal = elastic.try_inverse().expect("invertible").transpose() * m;
            let resolved = (elastic * s).dot(&(outcome.delivered.cauchy() * normal)) * f.jacobian();
            assert!(slip.abs() > 1e-3);
            assert!((resolved - slip.signum() * (STRENGTH + hardening * slip.abs())).abs() < 1e-12);
            let response = respond(&umat, &f.matrix());
            for (k, l) in (0..9).map(|n| (n / 3, n % 3)) {
                let moved = |t: f64| {
                    let mut moved = f.matrix();
                    moved[(k, l)] += t;
                    respond(&umat, &moved).first_piola
                };
                let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
                    let error = response.tangent[(i, j, k, l)] - difference[(i, j)];
                    assert!(
                        error.abs() < 1e-7 * SHEAR,
                        "{hardening} {i}{j}{k}{l}: {error:e}"
                    );
                }
            }
        }
    }
}

/// R. J. Asaro and J. R. Rice, J. Mech. Phys. Solids 25 (1977) 309: with Schmid's law, bands along the slip plane require `h = 0`.
///
/// For the unit polarization along `s* = F s` and the normal `m` of the undeformed slip plane, the acoustic tensor is `G h/(h + G |s*|^2)`.
#[test]
fn the_resistance_of_the_slip_plane_to_bands_agrees_with_its_closed_form_and_vanishes_without_hardening()
 {
    let (s, m) = system();
    for f in states() {
        let slipped = f.matrix() * s;
        for hardening in [1.0, 0.02, 0.0, -0.02] {
            let response = respond(&crystal(hardening), &f.matrix());
            let stiffness = Stiffness::<3>::of(&response);
            let acoustic = stiffness.acoustic_tensor(&m);
            let unit = slipped.normalize();
            let expected = SHEAR * hardening / (hardening + SHEAR * slipped.norm_squared());
            let found = unit.dot(&(acoustic * unit));
            assert!(
                (found - expected).abs() < 1e-12 * SHEAR,
                "{found} {expected}"
            );
            if hardening == 0.0 {
                // The whole traction vanishes: the acoustic tensor is singular.
                assert!((acoustic * unit).amax() < 1e-12 * SHEAR);
            }
            let smallest = stiffness.minimum().eigenvalue.re;
            assert!(smallest <= expected + 1e-12 * SHEAR, "{smallest}");
            match hardening {
                1.0 => assert!(smallest > 0.0, "{smallest}"),
                -0.02 => assert!(smallest < 0.0, "{smallest}"),
                _ => {}
            }
        }
    }
}
