//! Utility routines of Abaqus, as provided by `onset`.

use crate::{general, settings};
use nalgebra::{Matrix3, Vector3};
use onset_umat::{Umat, UmatError, UmatSettings};

const SOURCES: [&str; 2] = [
    "fortran/abaqus_utilities.f90",
    "tests/fortran/utilities.f90",
];
const STRESS: [f64; 6] = [3.0, -1.0, 2.0, 0.5, -0.7, 1.1];

fn umat(wish: f64) -> Umat {
    let mut properties = STRESS.to_vec();
    properties.push(wish);
    Umat::new(UmatSettings {
        state_variables: 25,
        ..settings(&SOURCES, &properties)
    })
    .expect("a UMAT")
}

#[test]
fn the_routines_of_abaqus_compute_invariants_principal_values_and_rotated_tensors() {
    let umat = umat(0.0);
    let path = umat.path(&general()).expect("a path");
    let outcome = umat.along(path).expect("an outcome");
    let values = &outcome.state_variables;
    let stress = onset_umat::Delivered {
        stress: STRESS,
        ddsdde: nalgebra::Matrix6::zeros(),
        sse: 0.0,
    }
    .cauchy();
    let mean = stress.trace() / 3.0;
    let deviator = stress - mean * Matrix3::identity();
    assert!((values[0] - mean).abs() < 1e-14);
    assert!((values[1] - (1.5 * deviator.norm_squared()).sqrt()).abs() < 1e-14);
    for n in 0..3 {
        assert_eq!(values[2 + n], values[5 + n]);
        // Directions are in rows of AN, which is stored by columns.
        let direction = Vector3::from_fn(|i, _| values[8 + n + 3 * i]);
        assert!((direction.norm() - 1.0).abs() < 1e-14);
        assert!((stress * direction - values[5 + n] * direction).amax() < 1e-13);
    }
    let rotation = onset_umat::Increment::between(Matrix3::identity(), general().matrix())
        .expect("invertible")
        .rotation;
    let turned = rotation * stress * rotation.transpose();
    for (a, (i, j)) in onset_umat::VOIGT.into_iter().enumerate() {
        assert!((values[17 + a] - turned[(i, j)]).abs() < 1e-14);
    }
    let here = std::env::current_dir().expect("a folder");
    assert_eq!(values[23], here.as_os_str().len() as f64);
    assert_eq!(values[24], 42.0, "SDVINI sets the first state variables");
}

#[test]
fn xit_and_errors_end_the_process_and_are_reported() {
    for (wish, text) in [
        (1.0, "the UMAT called XIT"),
        (2.0, "element 1 has 0.500000"),
    ] {
        let umat = umat(wish);
        let path = umat.path(&general()).expect("a path");
        match umat.along(path) {
            Err(UmatError::Ended { how, output, .. }) => {
                assert!(how.contains("exit code 1"), "{how}");
                assert!(output.contains(text), "{output}");
            }
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_umat_with_missing_utility_routines_gets_a_hint_where_to_find_them() {
    let error = Umat::new(settings(&SOURCES[1..], &[0.0])).err();
    let message = error.expect("an error").to_string();
    assert!(message.contains("undefined symbol"), "{message}");
    assert!(message.contains("onset umat-utilities"), "{message}");
}
