//! Input of a routine as passed by Abaqus.

use crate::{general, settings};
use nalgebra::Matrix3;
use onset_umat::{Increment, Umat, UmatSettings};

#[test]
fn the_routine_receives_strains_times_rotations_and_gradients_as_from_abaqus() {
    let umat = Umat::new(UmatSettings {
        state_variables: 30,
        increments: 2,
        ..settings(&["tests/fortran/hostile.f90"], &[10.0, 4.0, 12.0])
    })
    .expect("a UMAT");
    let path = umat.path(&general()).expect("a path");
    let (middle, end) = (path[0], path[1]);
    let seen = umat.along(path).expect("an outcome").state_variables;
    let whole = Increment::between(Matrix3::identity(), end).expect("invertible");
    let last = Increment::between(middle, end).expect("invertible");
    let close = |value: f64, expected: f64| {
        assert!(
            (value - expected).abs() < 1e-14,
            "{value} is not {expected}"
        );
    };
    for (a, (i, j)) in onset_umat::VOIGT.into_iter().enumerate() {
        // Halfway, both strains are half of the total, rotated to the end; shear is doubled.
        let factor = if i == j { 0.5 } else { 1.0 };
        close(seen[a], factor * whole.strain[(i, j)]);
        close(seen[6 + a], factor * whole.strain[(i, j)]);
    }
    for i in 0..3 {
        close(seen[15 + i], last.rotation[(1, i)]);
        close(seen[18 + i], middle[(0, i)]);
        close(seen[21 + i], end[(0, i)]);
    }
    assert_eq!(
        seen[12..15],
        [0.5, 0.5, 0.5],
        "step time, total time, DTIME"
    );
    assert_eq!(
        seen[24..28],
        [3.0, 3.0, 6.0, 3.0],
        "NDI, NSHR, NTENS, NPROPS"
    );
    assert_eq!(seen[28], 2.0, "KINC");
    assert_eq!(seen[29], 1.0, "CMNAME");
}
