//! Random methods and states: a proof is never wrong.

use crate::choices::{Case, case, config};
use nalgebra::Vector2;
use onset::bloch::{Stability, dynamical_matrix, growth_rate};
use onset::certificate::{Certainty, Certifier, GROWTH};
use onset::continuum::Stiffness;
use onset::lattice::BrillouinZone;
use onset::verdict::{judge, speed_squared};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use std::cell::Cell;

/// Number of undecided states.
const UNDECIDED: f64 = 0.05;

fn check(case: &Case, decided: &Cell<usize>) -> Result<(), TestCaseError> {
    let (method, material) = (case.method(), case.material());
    let certifier = Certifier::new(&method, &*material, 1e-3)
        .expect("a method")
        .with_budget(20_000);
    let certificate = certifier.certify(&case.state).expect("an admissible state");
    let response = material.response(&case.state).expect("finite");
    let is_elliptic = Stiffness::<2>::of(&response).is_strongly_elliptic();
    match certificate.material {
        Certainty::Stable { .. } => prop_assert!(is_elliptic),
        Certainty::Unstable { .. } => prop_assert!(!is_elliptic),
        _ => {}
    }
    decided.set(decided.get() + usize::from(certificate.discretization.is_decided()));
    let matrix = dynamical_matrix(&method, &*material, &case.state).expect("finite");
    let speed_squared = speed_squared(&method, &*material).expect("finite");
    match certificate.discretization {
        Certainty::Stable { bound } => {
            let (_, stability) = judge(&method, &*material, &case.state).expect("finite");
            prop_assert_eq!(stability, Stability::Stable);
            let home = method.home_map(&case.state);
            let zone = BrillouinZone::new(method.lattice().mapped(&home).expect("a lattice"));
            for i in 0..40 {
                for j in 0..40 {
                    let fractional = Vector2::new(f64::from(i) + 0.3, f64::from(j) + 0.7) / 40.0;
                    let k = home.transpose() * zone.folded(&zone.wave_vector(&fractional));
                    let measure = matrix.omega_squared(&k)[0].re
                        / (speed_squared * method.lattice().laplacian(&k));
                    prop_assert!(
                        measure >= bound * (1.0 - 1e-9),
                        "{measure:e} below {bound:e} at {k:?}"
                    );
                }
            }
        }
        Certainty::Unstable { witness } => {
            // The floating-point search may miss a small pocket, but must not contradict the wave.
            let growth = matrix.omega_squared(&witness.wave_vector).map(growth_rate);
            let growth = growth.into_iter().fold(0.0, f64::max) / speed_squared.sqrt();
            let noise = (matrix.noise() / speed_squared).sqrt();
            prop_assert!(
                growth >= witness.growth_rate * (1.0 - 1e-6) - noise,
                "{growth:e} of {witness:?}"
            );
            prop_assert!(witness.measure.high < 0.0 || witness.growth_rate > GROWTH * (1.0 - 1e-9));
        }
        Certainty::ZeroEnergy { wave_vector } => {
            let highest = matrix.omega_squared(&wave_vector)[1].re.abs();
            prop_assert!(
                highest <= 1e-9 * speed_squared,
                "omega^2 = {highest:e} at {wave_vector:?}"
            );
        }
        Certainty::Undecided { .. } => {}
    }
    Ok(())
}

#[test]
fn no_proof_contradicts_the_floating_point_matrix() {
    let (decided, seen) = (Cell::new(0), Cell::new(0));
    let mut runner = TestRunner::new(config(1500));
    let result = runner.run(&case(), |case| {
        seen.set(seen.get() + 1);
        check(&case, &decided)
    });
    result.expect("all cases pass");
    let open = 1.0 - decided.get() as f64 / f64::from(seen.get());
    assert!(
        open < UNDECIDED,
        "{} of {} are decided",
        decided.get(),
        seen.get()
    );
}
