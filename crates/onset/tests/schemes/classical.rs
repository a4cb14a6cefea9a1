//! Kernel methods as schemes: their forces, and the matrix in closed form.

use crate::battery::{assert_long_waves_are_those_of_the_material, assert_scheme};
use onset::approximation::Approximation;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::{BlatzKo, ModifiedMooneyRivlin};
use onset::method::{Frame, KernelMethodChoices, Linearization, Method, MethodError};
use onset::quadrature::Quadrature;
use onset::scheme::Discretization;
use onset::verdict::{Survey, assess};

fn state(stretches: [f64; 3]) -> DeformationGradient {
    DeformationGradient::from_stretches(stretches).expect("a state")
}

#[test]
fn the_dynamical_matrix_is_the_derivative_of_the_forces_of_a_patch() {
    for frame in [Frame::Lagrangian, Frame::Eulerian] {
        for quadrature in [Quadrature::Nodal, Quadrature::StressPoints] {
            for approximation in [Approximation::Shepard, Approximation::Mls] {
                let method = Method::<2>::new(KernelMethodChoices {
                    frame,
                    quadrature,
                    approximation,
                    support: 1.9,
                    ..KernelMethodChoices::default()
                })
                .expect("a method");
                assert_scheme(
                    &method,
                    &ModifiedMooneyRivlin::default(),
                    &state([1.15, 0.9, 1.0]),
                );
            }
        }
    }
}

#[test]
fn natural_stabilization_has_forces() {
    let method = Method::<2>::new(KernelMethodChoices {
        quadrature: Quadrature::NodalStabilized,
        lattice: LatticeKind::Square,
        ..KernelMethodChoices::default()
    })
    .expect("a method");
    assert_scheme(&method, &BlatzKo::default(), &state([1.1, 0.95, 1.0]));
}

#[test]
fn chains_are_schemes_in_one_dimension() {
    for frame in [Frame::Lagrangian, Frame::Eulerian] {
        let method = Method::<1>::new(KernelMethodChoices {
            lattice: LatticeKind::Chain,
            approximation: Approximation::Mls,
            frame,
            ..KernelMethodChoices::default()
        })
        .expect("a method");
        let material = ModifiedMooneyRivlin::default();
        assert_scheme(&method, &material, &state([1.2, 1.0, 1.0]));
        if frame == Frame::Lagrangian {
            let f = state([1.2, 1.0, 1.0]);
            assert_long_waves_are_those_of_the_material(&method, &material, &f, 1e-11);
        }
    }
}

#[test]
fn a_survey_of_a_scheme_agrees_with_the_assessment_of_the_method() {
    let material = ModifiedMooneyRivlin::default();
    for frame in [Frame::Lagrangian, Frame::Eulerian] {
        for quadrature in [Quadrature::Nodal, Quadrature::StressPoints] {
            let method = Method::<2>::new(KernelMethodChoices {
                frame,
                quadrature,
                ..KernelMethodChoices::default()
            })
            .expect("a method");
            let survey = Survey::new(&method, &material).expect("a survey");
            for stretches in [[1.1, 1.05, 1.0], [0.85, 0.9, 1.0], [1.6, 1.5, 1.0]] {
                let f = state(stretches);
                let surveyed = survey.state(&f).expect("a state");
                let assessed = assess(&method, &material, &f).expect("a state");
                assert_eq!(
                    surveyed.verdict, assessed.verdict,
                    "{frame:?}, {quadrature:?}, {stretches:?}"
                );
                let difference = surveyed.scaled_minimum - assessed.spectrum.softest.scaled;
                assert!(difference.abs() < 1e-9, "{difference}");
            }
        }
    }
}

#[test]
fn linearizations_that_are_not_derivatives_have_no_forces() {
    let method = Method::<2>::new(KernelMethodChoices {
        frame: Frame::Eulerian,
        linearization: Linearization::Paper,
        ..KernelMethodChoices::default()
    })
    .expect("a method");
    let error = method.waves(&ModifiedMooneyRivlin::default(), &state([1.1, 1.0, 1.0]));
    assert!(matches!(error, Err(MethodError::NotOfForces { .. })));
}
