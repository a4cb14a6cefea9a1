//! Energy, stress and tangent are consistent with each other and with the published law.

use crate::table::{Random, delta, differentiated, laws, of, quadruples};
use nalgebra::Matrix3;
use onset::kinematics::DeformationGradient;

const STATES: usize = 40;

fn unit(i: usize, j: usize) -> Matrix3<f64> {
    Matrix3::from_fn(|a, b| delta(a, i) * delta(b, j))
}

#[test]
fn stress_is_the_derivative_of_the_energy() {
    for entry in laws() {
        let mut random = Random::new(1);
        for _ in 0..STATES {
            let f = random.state();
            let response = entry.law.response(&f).expect("finite");
            let plain = (entry.energy)(&f);
            let difference = (response.energy - plain).abs();
            assert!(
                difference < 1e-13 * entry.bulk_modulus.max(plain),
                "{}: the energy of jets",
                entry.name
            );
            let scale = response.first_piola.amax().max(entry.shear_modulus);
            for i in 0..3 {
                for j in 0..3 {
                    let along = |t: f64| (entry.energy)(&of(&(f.matrix() + unit(i, j) * t)));
                    let error = response.first_piola[(i, j)] - differentiated(1e-3, along);
                    assert!(
                        error.abs() < 1e-8 * scale,
                        "{}: P{i}{j} is off by {error:e} at {f:?}",
                        entry.name
                    );
                }
            }
        }
    }
}

#[test]
fn all_81_tangent_components_are_second_derivatives_of_the_energy() {
    for entry in laws() {
        let mut random = Random::new(2);
        for _ in 0..8 {
            let f = random.state();
            let response = entry.law.response(&f).expect("finite");
            let scale = quadruples()
                .map(|n| response.tangent[n].abs())
                .fold(0.0, f64::max);
            for (i, j, k, l) in quadruples() {
                let second = differentiated(2e-3, |s| {
                    differentiated(2e-3, |t| {
                        (entry.energy)(&of(&(f.matrix() + unit(i, j) * s + unit(k, l) * t)))
                    })
                });
                let error = response.tangent[(i, j, k, l)] - second;
                assert!(
                    error.abs() < 1e-7 * scale,
                    "{}: A{i}{j}{k}{l} is off by {error:e} at {f:?}",
                    entry.name
                );
            }
        }
    }
}

#[test]
fn stress_and_elasticity_tensor_equal_the_closed_forms() {
    for entry in laws() {
        let mut random = Random::new(3);
        for _ in 0..STATES {
            let f = random.state();
            let c = f.matrix().transpose() * f.matrix();
            let response = entry.law.response(&f).expect("finite");
            let stress = (entry.second_piola)(&c);
            let scale = stress.amax().max(entry.shear_modulus);
            let error = (response.second_piola() - stress).amax();
            assert!(
                error < 1e-11 * scale,
                "{}: S is off by {error:e} at {f:?}",
                entry.name
            );
            let (computed, closed) = (response.second_elasticity(), (entry.second_elasticity)(&c));
            let scale = quadruples().map(|n| computed[n].abs()).fold(0.0, f64::max);
            for (i, j, k, l) in quadruples() {
                let error = computed[(i, j, k, l)] - closed(i, j, k, l);
                assert!(
                    error.abs() < 1e-11 * scale,
                    "{}: C^SE {i}{j}{k}{l} is off by {error:e}",
                    entry.name
                );
                // The tangent A from the closed forms alone.
                let m = f.matrix();
                let mut tangent = delta(i, k) * stress[(j, l)];
                for r in 0..3 {
                    for p in 0..3 {
                        tangent += m[(i, r)] * m[(k, p)] * closed(r, j, p, l);
                    }
                }
                let error = response.tangent[(i, j, k, l)] - tangent;
                assert!(
                    error.abs() < 1e-10 * scale,
                    "{}: A {i}{j}{k}{l} is off by {error:e}",
                    entry.name
                );
            }
        }
    }
}

#[test]
fn tangents_have_the_symmetries_of_a_potential() {
    for entry in laws() {
        let mut random = Random::new(4);
        for _ in 0..STATES {
            let response = entry.law.response(&random.state()).expect("finite");
            let (a, c) = (&response.tangent, response.second_elasticity());
            let scale = quadruples().map(|n| a[n].abs()).fold(0.0, f64::max);
            for (i, j, k, l) in quadruples() {
                let major = (a[(i, j, k, l)] - a[(k, l, i, j)]).abs();
                assert!(
                    major < 1e-14 * scale,
                    "{}: major symmetry of A: {major:e}",
                    entry.name
                );
                let minor = (c[(i, j, k, l)] - c[(j, i, k, l)])
                    .abs()
                    .max((c[(i, j, k, l)] - c[(i, j, l, k)]).abs());
                assert!(
                    minor < 1e-11 * scale,
                    "{}: minor symmetry of C^SE: {minor:e}",
                    entry.name
                );
            }
            // Balance of angular momentum: sigma is symmetric.
            let sigma = response.cauchy();
            assert!((sigma - sigma.transpose()).amax() < 1e-12 * scale);
        }
    }
}

#[test]
fn rotations_of_reference_and_state_keep_the_energy() {
    for entry in laws() {
        let mut random = Random::new(5);
        for _ in 0..STATES {
            let (f, q) = (random.state(), random.rotation());
            let energy = (entry.energy)(&f);
            let tolerance = 1e-12 * energy.abs().max(entry.bulk_modulus);
            let objective = (entry.energy)(&of(&(q * f.matrix()))) - energy;
            let isotropic = (entry.energy)(&of(&(f.matrix() * q))) - energy;
            assert!(
                objective.abs() < tolerance,
                "{}: W(QF) - W(F) = {objective:e}",
                entry.name
            );
            assert!(
                isotropic.abs() < tolerance,
                "{}: W(FQ) - W(F) = {isotropic:e}",
                entry.name
            );
        }
    }
}

#[test]
fn the_reference_state_is_free_of_stress_and_has_the_moduli_of_the_law() {
    for entry in laws() {
        let response = entry
            .law
            .response(&DeformationGradient::identity())
            .expect("finite");
        assert!(
            response.energy.abs() < 1e-14 * entry.bulk_modulus,
            "{}",
            entry.name
        );
        assert!(
            response.first_piola.amax() < 1e-14 * entry.bulk_modulus,
            "{}",
            entry.name
        );
        let (mu, bulk) = (entry.shear_modulus, entry.bulk_modulus);
        for (i, j, k, l) in quadruples() {
            let hooke = (bulk - 2.0 / 3.0 * mu) * delta(i, j) * delta(k, l)
                + mu * (delta(i, k) * delta(j, l) + delta(i, l) * delta(j, k));
            let error = response.tangent[(i, j, k, l)] - hooke;
            assert!(
                error.abs() < 1e-13 * bulk,
                "{}: A{i}{j}{k}{l} is off by {error:e}",
                entry.name
            );
        }
    }
}

#[test]
fn equations_30_and_31_hold_in_plane_strain() {
    use crate::table::{C1, C2, LAMBDA};
    let entry = &laws()[0];
    for (l1, l2) in [(1.2_f64, 0.9_f64), (0.7, 0.6), (2.5, 1.4)] {
        let f = DeformationGradient::from_stretches([l1, l2, 1.0]).expect("a state");
        let (i1, i3) = (l1 * l1 + l2 * l2 + 1.0, (l1 * l2).powi(2));
        let s0 = C1 * i3.cbrt() + 2.0 * C2 * i3.cbrt().powi(2) - LAMBDA * i3.ln();
        let s1 = C1 / 3.0 * i3.cbrt() + 4.0 / 3.0 * C2 * i3.cbrt().powi(2) - LAMBDA;
        let response = entry.law.response(&f).expect("finite");
        let (s, c) = (response.second_piola(), response.second_elasticity());
        let stress = |l: f64| C1 + C2 * i1 - C2 * l * l - s0 / (l * l);
        let shear = -C2 + s0 / (l1 * l2).powi(2);
        let expected = [
            (s[(0, 0)], stress(l1)),
            (s[(1, 1)], stress(l2)),
            (s[(0, 1)], 0.0),
            (c[(0, 0, 0, 0)], 2.0 * (s0 - s1) / l1.powi(4)),
            (c[(1, 1, 1, 1)], 2.0 * (s0 - s1) / l2.powi(4)),
            (c[(0, 0, 1, 1)], 2.0 * C2 - 2.0 * s1 / (l1 * l2).powi(2)),
            (c[(0, 1, 0, 1)], shear),
            (c[(1, 0, 0, 1)], shear),
            (c[(0, 0, 0, 1)], 0.0),
        ];
        for (n, (computed, printed)) in expected.into_iter().enumerate() {
            assert!(
                (computed - printed).abs() < 1e-11,
                "component {n}: {computed} against {printed}"
            );
        }
    }
}
