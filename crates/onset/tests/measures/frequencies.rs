//! Errors of frequencies and of long waves.

use crate::{linear_complete, method, nodal};
use onset::lattice::LatticeKind;
use onset::material::ModifiedMooneyRivlin;
use onset::measures::{dispersion_errors, long_wave_error};
use onset::scheme::Discretization;
use onset::scheme::element::{
    ElementChoices, ElementMass, ElementMesh, FiniteElements, Formulation,
};
use onset::verdict::Survey;
use std::f64::consts::PI;

fn bars(mass: ElementMass) -> FiniteElements<1> {
    FiniteElements::new(&ElementChoices {
        mesh: ElementMesh::Bars,
        spacing: 0.3,
        formulation: Formulation {
            mass,
            ..Formulation::default()
        },
        ..ElementChoices::default()
    })
    .expect("a mesh")
}

fn errors<const D: usize>(scheme: &dyn Discretization<D>, wavelengths: &[f64]) -> Vec<f64> {
    let material = ModifiedMooneyRivlin::default();
    let survey = Survey::new(scheme, &material).expect("a survey");
    let found = dispersion_errors(&survey, wavelengths).expect("errors");
    found.iter().map(|error| error.error).collect()
}

#[test]
fn frequencies_of_bars_with_lumped_masses_are_reduced_by_the_factor_sin_x_over_x() {
    // Closed form: omega = 2 c/h sin(k h/2); at two elements per wavelength it is 2/pi of the exact frequency.
    let wavelengths = [2.0, 4.0, 8.0, 16.0];
    let found = errors(&bars(ElementMass::Lumped), &wavelengths);
    for (error, count) in found.iter().zip(wavelengths) {
        let half = PI / count;
        let expected = 1.0 - half.sin() / half;
        assert!((error - expected).abs() < 1e-12, "{error} for {expected}");
    }
    assert!((found[0] - (1.0 - 2.0 / PI)).abs() < 1e-12);
}

#[test]
fn frequencies_of_bars_with_consistent_masses_agree_with_the_closed_form() {
    // Closed form: omega^2 = 6 c^2/h^2 (1 - cos kh) / (2 + cos kh).
    let wavelengths = [2.0, 4.0, 8.0, 16.0];
    let found = errors(&bars(ElementMass::Consistent), &wavelengths);
    for (error, count) in found.iter().zip(wavelengths) {
        let angle = 2.0 * PI / count;
        let squared = 6.0 * (1.0 - angle.cos()) / (2.0 + angle.cos());
        let expected = squared.sqrt() / angle - 1.0;
        assert!((error - expected).abs() < 1e-12, "{error} for {expected}");
    }
}

fn of_long_waves<const D: usize>(scheme: &dyn Discretization<D>) -> f64 {
    let material = ModifiedMooneyRivlin::default();
    let survey = Survey::new(scheme, &material).expect("a survey");
    long_wave_error(&survey).expect("an error")
}

#[test]
fn long_waves_are_exact_for_linear_completeness_and_inexact_without_it() {
    for kind in [LatticeKind::Square, LatticeKind::Hexagonal] {
        let exact = method::<2>(linear_complete(kind));
        assert!(of_long_waves(&exact) < 1e-11);
        let wrong = method::<2>(nodal(kind));
        assert!(of_long_waves(&wrong) > 0.01);
    }
    let in_3d = method::<3>(linear_complete(LatticeKind::SimpleCubic));
    assert!(of_long_waves(&in_3d) < 1e-11);
}

#[test]
fn the_error_of_long_waves_is_the_error_of_their_frequencies() {
    // One component in one dimension: the error of the stiffness is (1 + e)^2 - 1 with the error e of the frequency.
    let chain = method::<1>(nodal(LatticeKind::Chain));
    let stiffness = of_long_waves(&chain);
    let frequency = errors(&chain, &[4000.0])[0];
    let slow = 1.0 - (1.0 - frequency) * (1.0 - frequency);
    let fast = (1.0 + frequency) * (1.0 + frequency) - 1.0;
    let nearest = (stiffness - slow).abs().min((stiffness - fast).abs());
    assert!(nearest < 1e-5, "{stiffness} for {slow} or {fast}");
}
