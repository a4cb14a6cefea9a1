//! Inadmissible and extreme states are errors with the numbers that caused them, never panics.

use crate::table::laws;
use onset::kinematics::{DeformationGradient, KinematicsError, StraightPath};
use onset::material::{BlatzKo, Law, MaterialError, ModifiedMooneyRivlin};

#[test]
fn constants_that_overflow_the_energy_are_errors() {
    let f = DeformationGradient::from_stretches([1e-3, 1e3, 1.0]).expect("a state");
    let stiff = [
        ("ogden", vec![("mu1", 1.0), ("alpha1", 1e3)]),
        ("fung-isotropic", vec![("b", 1e6)]),
    ];
    for (name, parameters) in stiff {
        let law = Law::named(name).expect("a law").build(&parameters);
        let law = law.expect("admitted constants");
        assert_eq!(
            law.response(&f),
            Err(MaterialError::NotFinite {
                jacobian: f.jacobian()
            })
        );
    }
}

#[test]
fn stretches_of_any_magnitude_cause_no_panic_and_no_non_finite_numbers() {
    for entry in laws() {
        for first in -300..=300 {
            for second in [-first, 0, first / 2, first] {
                let stretches = [10.0_f64.powi(first), 10.0_f64.powi(second), 1.0];
                if let Ok(response) =
                    DeformationGradient::from_stretches(stretches).map(|f| entry.law.response(&f))
                    && let Ok(response) = response
                {
                    assert!(response.energy.is_finite() && response.tangent.is_finite());
                    assert!(response.first_piola.iter().all(|value| value.is_finite()));
                }
            }
        }
    }
}

#[test]
fn inadmissible_deformations_are_rejected_with_the_reason() {
    use KinematicsError::{Extreme, JacobianNotPositive, NotFinite, StretchNotPositive};
    let stretches = DeformationGradient::from_stretches;
    assert_eq!(
        stretches([1.0, -0.5, 1.0]),
        Err(StretchNotPositive {
            index: 2,
            value: -0.5
        })
    );
    assert_eq!(
        stretches([1.0, 1.0, 0.0]),
        Err(StretchNotPositive {
            index: 3,
            value: 0.0
        })
    );
    assert_eq!(
        stretches([f64::INFINITY, 1.0, 1.0]),
        Err(NotFinite {
            value: f64::INFINITY
        })
    );
    assert!(matches!(stretches([1.0, f64::NAN, 1.0]), Err(NotFinite { value }) if value.is_nan()));
    assert!(
        matches!(stretches([1e120; 3]), Err(Extreme { largest, .. }) if largest > 1e119 || largest.is_nan())
    );
    assert!(
        matches!(stretches([1.0, 1e-7, 1.0]), Err(Extreme { smallest, .. }) if (smallest / 1e-7 - 1.0).abs() < 1e-12)
    );
    assert!(matches!(
        stretches([1e-110; 3]),
        Err(Extreme { .. } | JacobianNotPositive { .. })
    ));
    // Two negative stretches are a rotation, one is a reflection.
    let turned = DeformationGradient::plane_strain([[-1.0, 0.0], [0.0, -1.0]], 1.0);
    assert_eq!(turned.map(|f| f.jacobian()), Ok(1.0));
    let reflected = DeformationGradient::plane_strain([[1.0, 0.0], [0.0, -1.0]], 1.0);
    assert_eq!(reflected, Err(JacobianNotPositive { jacobian: -1.0 }));
    let flat = DeformationGradient::plane_strain([[1.0, 2.0], [0.5, 1.0]], 1.0);
    assert_eq!(flat, Err(JacobianNotPositive { jacobian: 0.0 }));
}

#[test]
fn invariants_are_the_coefficients_of_the_characteristic_polynomial() {
    let mut random = crate::table::Random::new(41);
    for _ in 0..50 {
        let f = random.state();
        let c = f.matrix().transpose() * f.matrix();
        let invariants = f.invariants();
        let x = 1.7;
        let polynomial =
            x * x * x - invariants.first * x * x + invariants.second * x - invariants.third;
        let determinant = (nalgebra::Matrix3::identity() * x - c).determinant();
        assert!((polynomial - determinant).abs() < 1e-12 * (1.0 + c.norm().powi(3)));
        assert!(
            (invariants.jacobian - f.matrix().determinant()).abs() < 1e-14 * (1.0 + f.jacobian())
        );
    }
}

#[test]
fn straight_paths_have_exact_ends_and_reject_inverted_states() {
    let from = DeformationGradient::from_stretches([0.1, 1.3, 1.0]).expect("a state");
    let to = DeformationGradient::from_stretches([0.7, 0.9, 1.1]).expect("a state");
    let path = StraightPath::new(from, to).expect("a path");
    assert_eq!((path.at(0.0), path.at(1.0)), (Ok(from), Ok(to)));
    let middle = path.at(0.25).expect("a state").matrix();
    assert!((middle - (from.matrix() * 0.75 + to.matrix() * 0.25)).amax() < 1e-15);
    assert_eq!(
        StraightPath::new(from, from),
        Err(KinematicsError::EmptyPath)
    );
    // Half a turn leads through the singular state.
    let turned =
        DeformationGradient::plane_strain([[-1.0, 0.0], [0.0, -1.0]], 1.0).expect("a rotation");
    let through = StraightPath::new(DeformationGradient::identity(), turned).expect("a path");
    assert_eq!(
        through.at(0.5),
        Err(KinematicsError::JacobianNotPositive { jacobian: 0.0 })
    );
}

#[test]
fn parameters_out_of_range_are_rejected_by_name() {
    for bad in [0.0, -1.0, 1e-21, 1e21, f64::NAN, f64::INFINITY] {
        let refused =
            |error: MaterialError| matches!(error, MaterialError::Parameter { name: "mu", .. });
        assert!(BlatzKo::new(bad).is_err_and(refused));
    }
    let refused = |c1, c2, lambda, expected: &str| {
        let error = ModifiedMooneyRivlin::new(c1, c2, lambda);
        matches!(error, Err(MaterialError::Parameter { name, .. }) if name == expected)
    };
    assert!(refused(f64::NAN, 0.1, 1.0, "c1"));
    assert!(refused(0.1, f64::INFINITY, 1.0, "c2"));
    assert!(refused(0.1, 0.1, f64::NEG_INFINITY, "lambda"));
    assert!(refused(0.1, -0.2, 1.0, "c1 + c2"));
}
