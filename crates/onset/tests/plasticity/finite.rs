//! Finite strain: Hencky's law in the elastic range, objectivity, and both tangents compared with finite differences.

use crate::{Numbers, STRENGTHS, flowing, law};
use nalgebra::{Matrix3, Vector3};
use onset::kinematics::DeformationGradient;
use onset::material::FourthOrder;
use onset::plasticity::{Branch, DruckerPrager, FiniteState, FiniteUpdate, State};

fn deformation(matrix: &Matrix3<f64>) -> DeformationGradient {
    DeformationGradient::new(matrix.transpose().into()).expect("a deformation gradient")
}

fn step(law: &DruckerPrager, f: &Matrix3<f64>, state: &FiniteState) -> FiniteUpdate {
    law.finite_update(&deformation(f), state).expect("a stress")
}

/// Deformation gradient with strains `scale` times the strains of [`flowing`], and a rotation.
fn strained(numbers: &mut Numbers, scale: f64) -> Matrix3<f64> {
    numbers.rotation() * (Matrix3::identity() + flowing(numbers) * scale)
}

#[track_caller]
fn assert_derivative(
    tangent: &FourthOrder,
    f: &Matrix3<f64>,
    piola: impl Fn(&Matrix3<f64>) -> Matrix3<f64>,
    tolerance: f64,
) {
    let size = 1e-6;
    for k in 0..3 {
        for l in 0..3 {
            let (mut up, mut down) = (*f, *f);
            up[(k, l)] += size;
            down[(k, l)] -= size;
            let difference = (piola(&up) - piola(&down)) / (2.0 * size);
            for i in 0..3 {
                for j in 0..3 {
                    let (told, found) = (tangent[(i, j, k, l)], difference[(i, j)]);
                    assert!(
                        (told - found).abs() < tolerance,
                        "{i}{j}{k}{l}: {told} {found}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_elastic_range_has_stress_and_tangent_of_henckys_energy() {
    let mut numbers = Numbers(21);
    let stiff = onset::plasticity::Hardening::linear(1e3, 0.0);
    let law = law(0.0, 0.0, stiff);
    let energy = |f: &Matrix3<f64>| {
        // Independent of the library: the squares of the stretches are the eigenvalues of C.
        let squares = (f.transpose() * f).symmetric_eigenvalues();
        let strains = squares.map(|square| 0.5 * square.ln());
        let mean = strains.sum() / 3.0;
        let deviatoric: f64 = strains.iter().map(|e| (e - mean).powi(2)).sum();
        100.0 * deviatoric + 0.5 * law.bulk_modulus() * strains.sum().powi(2)
    };
    for _ in 0..5 {
        let f = Matrix3::identity() + numbers.matrix() * 0.3;
        let update = step(&law, &f, &FiniteState::default());
        assert_eq!(update.branch, Branch::Elastic);
        let size = 1e-5;
        let piola = Matrix3::from_fn(|i, j| {
            let (mut up, mut down) = (f, f);
            up[(i, j)] += size;
            down[(i, j)] -= size;
            (energy(&up) - energy(&down)) / (2.0 * size)
        });
        assert!((update.first_piola() - piola).norm() < 1e-6, "{piola}");
        let stress = |f: &Matrix3<f64>| step(&law, f, &FiniteState::default()).first_piola();
        assert_derivative(&update.consistent_tangent(), &f, stress, 1e-5);
        assert_eq!(
            update.continuum_tangent().expect("elastic"),
            update.consistent_tangent()
        );
    }
}

#[test]
fn the_consistent_tangent_is_the_derivative_of_the_first_piola_stress() {
    let mut numbers = Numbers(22);
    for strength in STRENGTHS {
        for (friction, dilatancy) in [(0.0, 0.0), (0.6, 0.3)] {
            let law = law(friction, dilatancy, strength);
            let first = step(&law, &strained(&mut numbers, 1.0), &FiniteState::default());
            let f = strained(&mut numbers, 3.0);
            let update = step(&law, &f, &first.state);
            assert_eq!(update.branch, Branch::Cone);
            let piola = |f: &Matrix3<f64>| step(&law, f, &first.state).first_piola();
            assert_derivative(&update.consistent_tangent(), &f, piola, 1e-4);
        }
    }
}

#[test]
fn the_consistent_tangent_is_continuous_at_equal_principal_stretches() {
    let law = law(0.6, 0.3, STRENGTHS[0]);
    for stretches in [[1.1, 0.9, 0.9], [1.2, 1.2, 0.8], [0.7, 0.9, 0.9 + 1e-9]] {
        let f = Matrix3::from_diagonal(&Vector3::from(stretches));
        let update = step(&law, &f, &FiniteState::default());
        let piola = |f: &Matrix3<f64>| step(&law, f, &FiniteState::default()).first_piola();
        assert_derivative(&update.consistent_tangent(), &f, piola, 1e-4);
    }
}

#[test]
fn the_continuum_tangent_is_the_limit_of_short_steps() {
    let mut numbers = Numbers(23);
    for strength in STRENGTHS {
        for (friction, dilatancy) in [(0.0, 0.0), (0.6, 0.3)] {
            let law = law(friction, dilatancy, strength);
            let f = strained(&mut numbers, 3.0);
            let update = step(&law, &f, &FiniteState::default());
            assert_eq!(update.branch, Branch::Cone, "{strength:?}");
            let tangent = update.continuum_tangent().expect("a tangent");
            let (_, normal) = law.directions(&update.kirchhoff()).expect("a normal");
            for _ in 0..10 {
                let mut rate = numbers.matrix() + normal;
                if law.elastic_stress(&normal).dot(&rate) < 0.0 {
                    rate = -rate;
                }
                let (size, rate) = (1e-7, rate * f);
                let next = step(&law, &(f + rate * size), &update.state);
                assert_eq!(next.branch, Branch::Cone);
                let found = (next.first_piola() - update.first_piola()) / size;
                let told = Matrix3::from_fn(|i, j| {
                    (0..9)
                        .map(|n| tangent[(i, j, n / 3, n % 3)] * rate[(n / 3, n % 3)])
                        .sum::<f64>()
                });
                assert!((found - told).norm() < 2e-2, "{found} {told}");
            }
        }
    }
}

#[test]
fn the_rate_moduli_give_the_acoustic_tensor_of_the_continuum_tangent() {
    let mut numbers = Numbers(24);
    for strength in STRENGTHS {
        let law = law(0.6, 0.3, strength);
        let f = strained(&mut numbers, 5.0);
        let update = step(&law, &f, &FiniteState::default());
        let tangent = update.continuum_tangent().expect("a tangent");
        let rates = update.rate_moduli().expect("moduli");
        for n in crate::directions(20) {
            let pulled = f.transpose() * n;
            let q = Matrix3::from_fn(|i, k| {
                (0..9)
                    .map(|m| tangent[(i, m / 3, k, m % 3)] * pulled[m / 3] * pulled[m % 3])
                    .sum::<f64>()
            });
            assert!((q - rates.acoustic_tensor(&n)).norm() < 1e-10 * q.norm());
        }
    }
}

#[test]
fn rotating_the_body_rotates_the_stress_and_keeps_the_state() {
    let mut numbers = Numbers(25);
    let law = law(0.6, 0.3, STRENGTHS[2]);
    let (mut state, mut turned_state) = (FiniteState::default(), FiniteState::default());
    for _ in 0..5 {
        let f = strained(&mut numbers, 5.0);
        let rotation = numbers.rotation();
        let (update, turned) = (
            step(&law, &f, &state),
            step(&law, &(rotation * f), &turned_state),
        );
        assert!((turned.first_piola() - rotation * update.first_piola()).norm() < 1e-11);
        (state, turned_state) = (update.state, turned.state);
        let gap = state.inverse_plastic_metric - turned_state.inverse_plastic_metric;
        assert!(gap.norm() < 1e-12 && (state.slip - turned_state.slip).abs() < 1e-13);
        // Rotated material axes: F R^T with the state rotated accordingly.
        let metric = rotation * state.inverse_plastic_metric * rotation.transpose();
        let start = FiniteState {
            inverse_plastic_metric: metric,
            ..state
        };
        let next = strained(&mut numbers, 5.0);
        let reference = step(&law, &next, &state).cauchy();
        let other = step(&law, &(next * rotation.transpose()), &start).cauchy();
        assert!((reference - other).norm() < 1e-11);
    }
}

#[test]
fn von_mises_flow_keeps_the_plastic_volume() {
    let mut numbers = Numbers(26);
    let metal = law(0.0, 0.0, STRENGTHS[0]);
    let mut state = FiniteState::default();
    for _ in 0..10 {
        state = step(&metal, &strained(&mut numbers, 5.0), &state).state;
        assert!((state.inverse_plastic_metric.determinant() - 1.0).abs() < 1e-12);
    }
    assert!(state.slip > 0.5);
}

#[test]
fn at_small_strains_finite_and_small_strain_agree_to_first_order() {
    let mut numbers = Numbers(27);
    let gradient = numbers.symmetric();
    let gap = |size: f64| {
        let strength = onset::plasticity::Hardening::linear(10.0 * size, 20.0);
        let law = law(0.6, 0.3, strength);
        let strain = gradient * size;
        let small = law
            .update(&strain, &State::default())
            .expect("a stress")
            .stress;
        let finite = step(
            &law,
            &(Matrix3::identity() + strain),
            &FiniteState::default(),
        )
        .cauchy();
        (small - finite).norm() / small.norm()
    };
    assert!(gap(1e-4) < 1e-3);
    assert!((gap(1e-4) / gap(1e-5) - 10.0).abs() < 0.1);
}
