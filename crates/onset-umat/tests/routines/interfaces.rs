//! Routines with the interfaces of Abaqus/Explicit and of `onset_law.h`.

use crate::laws::{STEEL, difference, states, stretched};
use crate::{general, settings, state};
use nalgebra::Matrix3;
use onset::kinematics::DeformationGradient;
use onset::material::{BlatzKo, Hyperelastic};
use onset::plasticity::IncrementalLaw;
use onset_umat::{Interface, Umat, UmatError, UmatSettings};

fn routine(interface: Interface, source: &str, properties: &[f64]) -> UmatSettings {
    UmatSettings {
        interface,
        ..settings(&[source], properties)
    }
}

fn flawed(flaw: u8) -> UmatSettings {
    routine(Interface::Law, "tests/c/flawed.c", &[32.0, f64::from(flaw)])
}

#[test]
fn a_vumat_and_a_function_in_c_respond_like_the_built_in_law() {
    let law = BlatzKo::default();
    let vumat = routine(Interface::Vumat, "fortran/blatz_ko_vumat.f90", &[32.0]);
    // With the derivative of the function itself, and with differences of its stress.
    let function = routine(Interface::Law, "c/blatz_ko_law.c", &[32.0]);
    for (settings, tolerance, has_energy) in [
        (vumat, 1e-9, true),
        (function, 1e-13, true),
        (flawed(0), 1e-9, false),
    ] {
        for increments in [1, 3] {
            let own = UmatSettings {
                increments,
                ..settings.clone()
            };
            let routine = Umat::new(own).expect("a routine");
            for f in states() {
                let (a, mut b) = (
                    law.response(&f).expect("finite"),
                    routine.response(&f).expect("finite"),
                );
                if !has_energy {
                    b.energy = a.energy;
                }
                let error = difference(&a, &b);
                assert!(error < tolerance, "{settings:?}: {error:e}");
            }
        }
    }
}

/// Both subroutines integrate the same equations if the rotation grows in proportion to the strain.
#[test]
fn a_plastic_vumat_has_the_stress_of_the_umat_and_a_consistent_tangent() {
    let plastic = |interface, source: &str| {
        let settings = UmatSettings {
            state_variables: 1,
            increments: 8,
            ..routine(interface, source, &STEEL)
        };
        Umat::new(settings).expect("a routine")
    };
    let umat = plastic(Interface::Umat, "fortran/j2_plasticity.f90");
    let vumat = plastic(Interface::Vumat, "fortran/j2_plasticity_vumat.f90");
    for f in [stretched(0.0005), stretched(0.02), general()] {
        let path = umat.path(&f).expect("a path");
        let [a, b] = [&umat, &vumat].map(|own| own.along(path.clone()).expect("an outcome"));
        let scale = a.delivered.cauchy().amax();
        let error = (a.delivered.cauchy() - b.delivered.cauchy()).amax();
        assert!(error < 1e-9 * scale, "{error:e} of {scale}");
        assert!((a.state_variables[0] - b.state_variables[0]).abs() < 1e-12);
        if (f.jacobian() - 1.0).abs() < 1e-12 {
            // The UMAT sums energies per current volume, which agree with those per mass at constant volume.
            let (one, other) = (a.plastic_dissipation, b.plastic_dissipation);
            assert!((one - other).abs() < 1e-9, "{one} {other}");
            let (one, other) = (a.delivered.sse, b.delivered.sse);
            assert!((one - other).abs() < 1e-9, "{one} {other}");
        }
        // One-sided tests along the path: the derivative in each direction from the end of the last increment but one.
        let response = vumat.response(&f).expect("finite");
        let history: Vec<DeformationGradient> = path[..path.len() - 1]
            .iter()
            .map(|f| state(std::array::from_fn(|i| std::array::from_fn(|j| f[(i, j)]))))
            .collect();
        let largest = (0..81)
            .map(|n| response.tangent[(n / 27, n / 9 % 3, n / 3 % 3, n % 3)].abs())
            .fold(0.0, f64::max);
        for (k, l) in [(0, 0), (0, 1), (2, 1)] {
            let moved = |step: f64| {
                let mut end = f.matrix();
                end[(k, l)] += step;
                let mut history = history.clone();
                history.push(state(std::array::from_fn(|i| {
                    std::array::from_fn(|j| end[(i, j)])
                })));
                vumat.after(&history).expect("finite").first_piola
            };
            let step = 1e-6;
            let change = (moved(step) - moved(-step)) / (2.0 * step);
            let own = Matrix3::from_fn(|i, j| response.tangent[(i, j, k, l)]);
            let error = (change - own).amax();
            assert!(error < 1e-7 * largest, "{error:e} of {largest:e}");
        }
    }
}

#[test]
fn short_increments_of_a_vumat_do_not_unload_its_tangent() {
    let [young, poisson, _, hardening] = STEEL;
    let shear = young / (2.0 * (1.0 + poisson));
    for increments in [1, 100, 5_000] {
        let settings = UmatSettings {
            state_variables: 1,
            increments,
            ..routine(Interface::Vumat, "fortran/j2_plasticity_vumat.f90", &STEEL)
        };
        let vumat = Umat::new(settings).expect("a VUMAT");
        let path = vumat.path(&stretched(0.02)).expect("a path");
        let c = vumat.along(path).expect("an outcome").delivered.ddsdde;
        // Modulus along the flow direction (1, -1/2, -1/2). The rotation of the axes adds nothing, the volume the stress.
        let column = |i: usize| c[(i, 0)] - 0.5 * (c[(i, 1)] + c[(i, 2)]);
        let modulus = column(0) - 0.5 * (column(1) + column(2));
        let flow = 3.0 * shear * hardening / (3.0 * shear + hardening);
        assert!(
            (modulus / flow - 1.0).abs() < 1e-5,
            "{increments}: {modulus} {flow}"
        );
    }
}

#[test]
fn the_response_of_a_vumat_rotates_with_the_body() {
    let settings = UmatSettings {
        state_variables: 1,
        increments: 16,
        ..routine(Interface::Vumat, "fortran/j2_plasticity_vumat.f90", &STEEL)
    };
    let vumat = Umat::new(settings).expect("a VUMAT");
    let rotation = *nalgebra::Rotation3::from_euler_angles(0.3, -0.2, 1.5).matrix();
    let turned = rotation * general().matrix();
    let turned = state(std::array::from_fn(|i| {
        std::array::from_fn(|j| turned[(i, j)])
    }));
    let [a, b] = [general(), turned].map(|f| vumat.response(&f).expect("finite"));
    let expected = rotation * a.first_piola;
    assert!((b.first_piola - expected).amax() < 1e-9 * expected.amax());
}

#[test]
fn flaws_of_a_function_are_reported_with_their_cause() {
    let asked = |settings: UmatSettings| {
        let routine = Umat::new(settings)?;
        let path = routine.path(&general())?;
        routine.along(path)
    };
    for flaw in [1, 2] {
        let error = asked(flawed(flaw)).expect_err("unsymmetric");
        assert!(matches!(error, UmatError::Skew { .. }), "{error}");
        assert!(error.to_string().contains("P[3*i + J]"), "{error}");
    }
    // Along its axes a transposed stress is symmetric, and only its differences are not.
    let transposed = Umat::new(flawed(1)).expect("a function");
    let diagonal = DeformationGradient::from_stretches([1.2, 0.9, 1.0]).expect("admissible");
    let error = transposed.response(&diagonal).expect_err("unsymmetric");
    assert!(error.to_string().contains("angular momentum"), "{error}");
    // Rounding of a stress that is nearly zero is no such error.
    let rough = Umat::new(flawed(7)).expect("a function");
    let (sine, cosine) = 0.5_f64.sin_cos();
    let turned = state([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]);
    assert!(rough.response(&turned).is_ok());
    let error = asked(flawed(8)).expect_err("a part of A").to_string();
    assert!(error.contains("only a part of it set"), "{error}");
    let error = asked(flawed(3)).expect_err("no response").to_string();
    assert!(error.contains("no response at F_11 = 1.2"), "{error}");
    assert!(error.contains("onset_law returned 300"), "{error}");
    let error = asked(flawed(4)).expect_err("an overrun");
    assert!(
        matches!(
            error,
            UmatError::Overrun {
                argument: "state",
                ..
            }
        ),
        "{error}"
    );
    assert!(error.to_string().contains("material.state-variables"));
    let error = asked(flawed(5)).expect_err("NaN").to_string();
    assert!(error.contains("returned NaN in P"), "{error}");
    let missing = UmatSettings {
        interface: Interface::Vumat,
        ..flawed(0)
    };
    let error = asked(missing).expect_err("another interface");
    assert!(
        matches!(
            error,
            UmatError::NoRoutine {
                interface: Interface::Vumat,
                ..
            }
        ),
        "{error}"
    );
    assert!(error.to_string().contains("vumat_"), "{error}");
}

#[test]
fn a_vumat_that_updates_more_state_variables_than_there_are_is_detected() {
    let settings = routine(Interface::Vumat, "fortran/j2_plasticity_vumat.f90", &STEEL);
    let vumat = Umat::new(settings).expect("a VUMAT");
    let path = vumat.path(&stretched(0.02)).expect("a path");
    let error = vumat.along(path).expect_err("an overrun");
    assert!(
        error.to_string().contains("material.state-variables"),
        "{error}"
    );
}

#[test]
fn finite_differences_do_not_change_the_state_variables_of_a_function() {
    let settings = UmatSettings {
        state_variables: 1,
        increments: 5,
        ..flawed(6)
    };
    let routine = Umat::new(settings).expect("a function");
    let path = routine.path(&general()).expect("a path");
    let outcome = routine.along(path).expect("an outcome");
    assert!((outcome.state_variables[0] - 0.2).abs() < 1e-14);
}
