//! Critical moduli of both criteria compared with the acoustic tensor, at small and at finite strain.

use crate::{Numbers, STRENGTHS, directions, flowing, law};
use nalgebra::{Matrix3, Vector3};
use onset::kinematics::DeformationGradient;
use onset::plasticity::{Branch, Criterion, FiniteState, Hardening, RateModuli, State};

const CRITERIA: [Criterion; 2] = [Criterion::Ellipticity, Criterion::StrongEllipticity];

/// Flowing states of all laws at small and finite strain, including large elastic strains.
fn states() -> Vec<RateModuli> {
    let mut numbers = Numbers(7);
    let mut states = Vec::new();
    // The strength is large relative to the stiffness, so that stress terms matter.
    let strong = Hardening::linear(15.0, -10.0);
    for (n, strength) in STRENGTHS.into_iter().chain([strong]).enumerate() {
        for (friction, dilatancy) in [(0.0, 0.0), (0.6, 0.3), (0.5, -0.1), (0.9, 0.9)] {
            let law = law(friction, dilatancy, strength);
            let update = law
                .update(&flowing(&mut numbers), &State::default())
                .expect("a stress");
            if strength != strong {
                states.push(
                    law.rate_moduli(&update.stress, update.state.slip)
                        .expect("moduli"),
                );
            }
            let scale = if strength == strong {
                10.0
            } else {
                [1.5, 3.0][n % 2]
            };
            let f = numbers.rotation() * (Matrix3::identity() + flowing(&mut numbers) * scale);
            let f = DeformationGradient::new(f.transpose().into()).expect("a deformation");
            let update = law
                .finite_update(&f, &FiniteState::default())
                .expect("a stress");
            assert_eq!(update.branch, Branch::Cone);
            states.push(update.rate_moduli().expect("moduli"));
        }
    }
    states
}

#[test]
fn no_direction_has_a_larger_critical_modulus_than_the_maximum() {
    for state in states() {
        for criterion in CRITERIA {
            let critical = state.critical(criterion).expect("a critical state");
            let along = |n: &Vector3<f64>| {
                state
                    .critical_modulus_along(n, criterion)
                    .expect("a modulus")
            };
            let attained = along(&critical.band.normal);
            assert!((attained - critical.modulus).abs() < 1e-11 * 100.0);
            for n in directions(3000) {
                assert!(along(&n) <= critical.modulus + 1e-9, "{criterion:?} at {n}");
            }
            assert!(critical.modulus <= critical.bound && critical.bound < critical.modulus + 1e-5);
        }
    }
}

#[test]
fn at_the_critical_modulus_the_acoustic_tensor_is_singular_with_the_polarization_of_the_band() {
    for state in states() {
        let critical = state.critical(Criterion::Ellipticity).expect("critical");
        let band = critical.band;
        let q = state
            .with_modulus(critical.modulus)
            .acoustic_tensor(&band.normal);
        assert!((q * band.polarization).norm() < 1e-10 * q.norm());
        // For a larger plastic modulus no determinant vanishes; for a smaller one some determinant is negative.
        let determinant = |margin: f64, n: &Vector3<f64>| {
            state
                .with_modulus(critical.modulus + margin)
                .acoustic_tensor(n)
                .determinant()
        };
        assert!(directions(2000).all(|n| determinant(0.1, &n) > 0.0));
        assert!(determinant(-0.1, &band.normal) < 0.0);
    }
}

#[test]
fn at_the_critical_modulus_of_strong_ellipticity_the_symmetric_part_is_singular() {
    for state in states() {
        let critical = state
            .critical(Criterion::StrongEllipticity)
            .expect("critical");
        let (n, g) = (critical.band.normal, critical.band.polarization);
        let at = |margin: f64| state.with_modulus(critical.modulus + margin);
        let q = at(0.0).acoustic_tensor(&n);
        assert!(((q + q.transpose()) * g).norm() < 1e-10 * q.norm());
        assert!(at(-0.1).smallest_symmetric_eigenvalue(&n) < 0.0);
        assert!(directions(2000).all(|n| at(0.1).smallest_symmetric_eigenvalue(&n) > 0.0));
        assert!(
            at(0.1)
                .holds(Criterion::StrongEllipticity)
                .expect("an answer")
        );
        assert!(
            !at(-0.1)
                .holds(Criterion::StrongEllipticity)
                .expect("an answer")
        );
    }
}

#[test]
fn strong_ellipticity_is_lost_first_and_with_ellipticity_only_if_the_flow_is_associated() {
    for strength in STRENGTHS {
        for (friction, dilatancy) in [(0.0, 0.0), (0.7, 0.7), (0.7, 0.2), (0.3, 0.6)] {
            let law = law(friction, dilatancy, strength);
            let stress = Numbers(3).symmetric() - Matrix3::identity();
            let state = law.rate_moduli(&stress, 0.01).expect("moduli");
            let [bands, strong] = CRITERIA.map(|n| state.critical(n).expect("critical").modulus);
            if friction == dilatancy {
                assert!((bands - strong).abs() < 1e-10, "{bands} {strong}");
            } else {
                assert!(strong > bands + 0.1, "{bands} {strong}");
            }
        }
    }
}

#[test]
fn a_rotated_state_has_the_rotated_band() {
    let mut numbers = Numbers(11);
    let law = law(0.6, 0.2, STRENGTHS[3]);
    let stress = numbers.symmetric() - Matrix3::identity();
    let rotation = numbers.rotation();
    let turned = rotation * stress * rotation.transpose();
    for criterion in CRITERIA {
        let of = |stress: &Matrix3<f64>| {
            law.rate_moduli(stress, 0.0)
                .and_then(|moduli| moduli.critical(criterion))
                .expect("critical")
        };
        let (reference, rotated) = (of(&stress), of(&turned));
        assert!((reference.modulus - rotated.modulus).abs() < 1e-10);
        assert!((reference.band.angle_to_major - rotated.band.angle_to_major).abs() < 1e-6);
        // Either of the two conjugate bands may be reported.
        let along = law
            .rate_moduli(&turned, 0.0)
            .and_then(|m| m.critical_modulus_along(&(rotation * reference.band.normal), criterion));
        assert!((along.expect("a modulus") - rotated.modulus).abs() < 1e-10);
    }
}

#[test]
fn critical_moduli_scale_with_the_unit_of_stress() {
    let critical = |unit: f64, criterion| {
        let strength = Hardening::linear(unit, 0.0);
        let law = onset::plasticity::DruckerPrager::new(100.0 * unit, 0.25, 0.6, 0.2, strength)
            .expect("a law");
        let stress = flowing(&mut Numbers(13)) * unit;
        let state = law.rate_moduli(&stress, 0.0).expect("moduli");
        let critical = state.critical(criterion).expect("critical");
        let along = state
            .critical_modulus_along(&critical.band.normal, criterion)
            .expect("a modulus");
        assert!((along / critical.modulus - 1.0).abs() < 1e-10);
        critical.modulus / unit
    };
    for criterion in CRITERIA {
        for unit in [1e-100, 1e-9, 1e12, 1e140] {
            let (reference, scaled) = (critical(1.0, criterion), critical(unit, criterion));
            assert!((scaled / reference - 1.0).abs() < 1e-10, "{unit}");
        }
    }
}
