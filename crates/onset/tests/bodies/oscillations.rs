//! Stable steps of damped oscillations against the matrices of the schemes.

use crate::random::Random;
use nalgebra::{DMatrix, DVector};
use onset::time_step::{Integrator, Oscillation};

/// Spectral radius of the matrix of a step, written out from the definition of the scheme.
fn radius(k: &DMatrix<f64>, c: &DMatrix<f64>, integrator: Integrator, dt: f64) -> f64 {
    let n = k.nrows();
    let mut step = DMatrix::zeros(2 * n, 2 * n);
    for column in 0..2 * n {
        let unit =
            |from: usize| DVector::from_fn(n, |i, _| f64::from(u8::from(i + from == column)));
        let (mut u, mut v) = (unit(0), unit(n));
        match integrator {
            Integrator::CentralDifferences => {
                v -= (k * &u + c * &v) * dt;
                u += &v * dt;
            }
            _ => {
                v -= (k * &u + c * &v) * (0.5 * dt);
                u += &v * dt;
                v -= (k * &u + c * &v) * (0.5 * dt);
            }
        }
        for i in 0..n {
            step[(i, column)] = u[i];
            step[(n + i, column)] = v[i];
        }
    }
    let values = step.complex_eigenvalues();
    values.iter().map(|z| z.norm()).fold(0.0, f64::max)
}

const BOTH: [Integrator; 2] = [Integrator::CentralDifferences, Integrator::KickDriftKick];

/// Below the step every mode with less damping decays; above it one of them grows.
#[test]
fn the_step_of_one_mode_is_the_limit_of_the_scheme() {
    let one = |x: f64| DMatrix::from_element(1, 1, x);
    for integrator in BOTH {
        for damping in [0.01, 0.3, 1.0, 2.0, 5.0, 40.0] {
            let squared = 1.7;
            let own = Oscillation { squared, damping };
            let limit = own.critical_time_step(integrator).expect("a step");
            let worst = |dt: f64| {
                let all = (0..=400).map(|n| damping * f64::from(n) / 400.0);
                let all = all.map(|c| radius(&one(squared), &one(c), integrator, dt));
                all.fold(0.0, f64::max)
            };
            assert!(
                worst(0.9999 * limit) <= 1.0 + 1e-9,
                "{integrator:?} {damping}"
            );
            assert!(
                worst(1.0002 * limit) > 1.0 + 1e-9,
                "{integrator:?} {damping}"
            );
        }
    }
}

#[test]
fn matrices_without_common_eigenvectors_are_stable_up_to_the_step() {
    let mut random = Random::new(5);
    let mut square = |size: f64| {
        let root = DMatrix::from_fn(3, 3, |_, _| random.number());
        &root * root.transpose() * size
    };
    for case in 0..200 {
        let (k, c) = (square(1.0), square(0.02 * f64::from(case)));
        let own = Oscillation {
            squared: k.clone().symmetric_eigenvalues().max(),
            damping: c.clone().symmetric_eigenvalues().max(),
        };
        for integrator in BOTH {
            let limit = own.critical_time_step(integrator).expect("a step");
            for share in [0.2, 0.6, 0.95, 0.999] {
                let found = radius(&k, &c, integrator, share * limit);
                assert!(found <= 1.0 + 1e-9, "{case} {integrator:?} {share} {found}");
            }
        }
    }
}
