//! The UMATs of the crate, compared with known properties of their laws.

use crate::{blatz_ko, general, settings, state};
use nalgebra::Matrix3;
use onset::kinematics::DeformationGradient;
use onset::material::{BlatzKo, Hyperelastic, Response};
use onset_umat::{Umat, UmatSettings};

/// Largest difference of two responses, relative to the tangent.
pub fn difference(a: &Response, b: &Response) -> f64 {
    let indices = || (0..81).map(|n| (n / 27, n / 9 % 3, n / 3 % 3, n % 3));
    let scale = indices().map(|at| a.tangent[at].abs()).fold(0.0, f64::max);
    let tangent = indices()
        .map(|at| (a.tangent[at] - b.tangent[at]).abs())
        .fold(0.0, f64::max);
    let stress = (a.first_piola - b.first_piola).amax();
    tangent.max(stress).max((a.energy - b.energy).abs()) / scale
}

pub fn states() -> Vec<DeformationGradient> {
    (0..40)
        .map(|n| {
            let t = f64::from(n);
            state([
                [1.0 + 0.3 * t.sin(), 0.2 * (2.0 * t).cos(), 0.1 * t.cos()],
                [0.25 * (3.0 * t).sin(), 1.0 + 0.2 * (5.0 * t).cos(), 0.0],
                [0.0, 0.15 * (0.7 * t).sin(), 1.0 - 0.2 * (1.3 * t).sin()],
            ])
        })
        .collect()
}

#[test]
fn the_umat_of_blatz_and_ko_responds_like_the_built_in_law() {
    let (umat, law) = (blatz_ko(), BlatzKo::default());
    for f in states() {
        let (a, b) = (law.response(&f), umat.response(&f));
        let error = difference(&a.expect("finite"), &b.expect("finite"));
        assert!(error < 1e-13, "{error:e}");
    }
}

#[test]
fn answers_are_the_same_in_single_calls_in_batches_and_from_many_threads() {
    let umat = blatz_ko();
    let paths: Vec<Vec<Matrix3<f64>>> = (0..5)
        .flat_map(|_| states())
        .map(|f| umat.path(&f).expect("a path"))
        .collect();
    let one_by_one: Vec<_> = paths.iter().map(|path| umat.along(path.clone())).collect();
    assert!(one_by_one.iter().all(Result::is_ok));
    assert_eq!(umat.along_all(&paths), one_by_one);
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for (path, expected) in paths.iter().zip(&one_by_one) {
                    assert_eq!(&umat.along(path.clone()), expected);
                }
            });
        }
    });
}

/// Young's modulus, Poisson's ratio, yield stress, hardening modulus.
pub const STEEL: [f64; 4] = [200e3, 0.3, 250.0, 2e3];

fn plastic(increments: u32) -> Umat {
    Umat::new(UmatSettings {
        state_variables: 1,
        increments,
        ..settings(&["fortran/j2_plasticity.f90"], &STEEL)
    })
    .expect("a UMAT")
}

/// Isochoric stretch: the deviatoric logarithmic strain is `e diag(1, -1/2, -1/2)`, and the pressure is zero.
pub fn stretched(e: f64) -> DeformationGradient {
    DeformationGradient::from_stretches([e.exp(), (-0.5 * e).exp(), (-0.5 * e).exp()])
        .expect("admissible")
}

#[test]
fn hardening_of_von_mises_plasticity_agrees_with_the_closed_form() {
    let [young, poisson, yield_stress, hardening] = STEEL;
    let shear = young / (2.0 * (1.0 + poisson));
    for increments in [1, 10] {
        let umat = plastic(increments);
        for e in [0.0005, 0.01, 0.2] {
            let path = umat.path(&stretched(e)).expect("a path");
            let outcome = umat.along(path).expect("an outcome");
            // Uniaxial stress after plastic flow: q = 3 G (e - p) = y + H p.
            let p = ((3.0 * shear * e - yield_stress) / (3.0 * shear + hardening)).max(0.0);
            let q = 3.0 * shear * (e - p);
            let stress = outcome.delivered.stress;
            assert!((outcome.state_variables[0] - p).abs() < 1e-13);
            assert!((stress[0] - stress[1] - q).abs() < 1e-9 * q, "{stress:?}");
            assert!((stress[0] + stress[1] + stress[2]).abs() < 1e-9 * q);
            let dissipated = yield_stress * p + 0.5 * hardening * p * p;
            assert!((outcome.plastic_dissipation - dissipated).abs() < 1e-9 * young * e);
            if increments == 10 && p > 0.0 {
                // Work is integrated by the trapezoidal rule, which is exact except for the increment that contains the yield point.
                let elastic = q * q / (6.0 * shear);
                let error = outcome.delivered.sse - elastic;
                assert!(error.abs() < 0.1 * yield_stress * e, "{error}");
            }
        }
    }
}

#[test]
fn a_rotation_along_the_path_only_rotates_the_stress_of_a_plastic_material() {
    let umat = plastic(16);
    let rotation = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
        * nalgebra::Rotation3::from_euler_angles(0.3, -0.2, 0.5).matrix();
    let f = general();
    let turned = rotation * f.matrix();
    let turned = state(std::array::from_fn(|i| {
        std::array::from_fn(|j| turned[(i, j)])
    }));
    let [a, b] = [f, turned].map(|f| {
        let path = umat.path(&f).expect("a path");
        umat.along(path).expect("an outcome")
    });
    let expected = rotation * a.delivered.cauchy() * rotation.transpose();
    assert!((b.delivered.cauchy() - expected).amax() < 1e-9 * expected.amax());
    assert!((a.state_variables[0] - b.state_variables[0]).abs() < 1e-13);
}

#[test]
fn the_tangent_is_elastic_before_yield_and_plastic_after_yield() {
    let umat = plastic(1);
    let [young, poisson, yield_stress, hardening] = STEEL;
    let shear = young / (2.0 * (1.0 + poisson));
    let at = |e: f64| {
        let path = umat.path(&stretched(e)).expect("a path");
        umat.along(path).expect("an outcome").delivered.ddsdde
    };
    let onset = yield_stress / (3.0 * shear);
    // Modulus along the flow direction (1, -1/2, -1/2).
    let modulus = |e: f64| {
        let c = at(e);
        let column = |i: usize| c[(i, 0)] - 0.5 * (c[(i, 1)] + c[(i, 2)]);
        column(0) - 0.5 * (column(1) + column(2))
    };
    assert!((modulus(0.99 * onset) / (3.0 * shear) - 1.0).abs() < 1e-12);
    let plastic = 3.0 * shear * hardening / (3.0 * shear + hardening);
    assert!((modulus(5.0 * onset) / plastic - 1.0).abs() < 1e-9);
}
