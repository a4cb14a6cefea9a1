//! Small-strain return mapping compared with an independent solution of its equations and with finite differences.

use crate::{Numbers, STRENGTHS, flowing, law};
use nalgebra::{Matrix3, SMatrix, SVector};
use onset::material::FourthOrder;
use onset::plasticity::{Branch, DruckerPrager, Hardening, PlasticityError, State};

fn with_shifted(strain: &Matrix3<f64>, k: usize, l: usize, by: f64) -> Matrix3<f64> {
    let mut shifted = *strain;
    shifted[(k, l)] += 0.5 * by;
    shifted[(l, k)] += 0.5 * by;
    shifted
}

#[track_caller]
fn assert_tangent(
    tangent: &FourthOrder,
    difference: impl Fn(usize, usize) -> Matrix3<f64>,
    tolerance: f64,
) {
    for k in 0..3 {
        for l in 0..3 {
            let difference = difference(k, l);
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

/// Newton's method on all equations of the implicit step together, six of flow and one of yield, with numerical derivatives.
fn implicit_step(law: &DruckerPrager, strain: &Matrix3<f64>, state: &State) -> (Matrix3<f64>, f64) {
    type Unknown = SVector<f64, 7>;
    const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)];
    let tensor = |x: &Unknown| {
        let mut matrix = Matrix3::zeros();
        for (n, (i, j)) in PAIRS.into_iter().enumerate() {
            matrix[(i, j)] = x[n];
            matrix[(j, i)] = x[n];
        }
        matrix
    };
    let residual = |x: &Unknown| {
        let (stress, slip) = (tensor(x), state.slip + x[6]);
        let (flow, _) = law.directions(&stress).expect("directions");
        let rest = law.elastic_strain(&stress) + state.plastic_strain + flow * x[6] - strain;
        let mut r = Unknown::zeros();
        for (n, (i, j)) in PAIRS.into_iter().enumerate() {
            r[n] = rest[(i, j)] * 100.0;
        }
        r[6] = law.yield_function(&stress, slip);
        r
    };
    let trial = law.elastic_stress(&(strain - state.plastic_strain));
    let mut x = Unknown::zeros();
    for (n, (i, j)) in PAIRS.into_iter().enumerate() {
        x[n] = trial[(i, j)];
    }
    for _ in 0..60 {
        let r = residual(&x);
        let jacobian = SMatrix::<f64, 7, 7>::from_fn(|a, b| {
            let step = if b == 6 { 1e-7 } else { 1e-5 };
            let (mut up, mut down) = (x, x);
            up[b] += step;
            down[b] -= step;
            (residual(&up)[a] - residual(&down)[a]) / (2.0 * step)
        });
        x -= jacobian.lu().solve(&r).expect("a step");
    }
    (tensor(&x), state.slip + x[6])
}

#[test]
fn the_closed_form_return_mapping_solves_the_equations_of_the_implicit_step() {
    let mut numbers = Numbers(2);
    for strength in STRENGTHS {
        for (friction, dilatancy) in [(0.0, 0.0), (0.6, 0.3)] {
            let law = law(friction, dilatancy, strength);
            let first = law
                .update(&(flowing(&mut numbers) * 0.7), &State::default())
                .expect("a first step");
            let strain = flowing(&mut numbers);
            let update = law.update(&strain, &first.state).expect("a second step");
            assert_eq!(update.branch, Branch::Cone);
            let (stress, slip) = implicit_step(&law, &strain, &first.state);
            assert!((update.stress - stress).norm() < 1e-9, "{strength:?}");
            assert!((update.state.slip - slip).abs() < 1e-11);
            let flow = update.state.plastic_strain - first.state.plastic_strain;
            let (direction, _) = law.directions(&update.stress).expect("a direction");
            assert!((flow - direction * (slip - first.state.slip)).norm() < 1e-10);
            assert!(law.yield_function(&update.stress, update.state.slip).abs() < 1e-12);
        }
    }
}

#[test]
fn the_consistent_tangent_is_the_derivative_of_the_step_on_every_branch() {
    let mut numbers = Numbers(4);
    let mut seen = [0; 3];
    for strength in STRENGTHS {
        for (friction, dilatancy) in [(0.0, 0.0), (0.6, 0.3), (0.4, 0.0), (0.8, 0.8)] {
            let law = law(friction, dilatancy, strength);
            for strain in [
                flowing(&mut numbers),
                flowing(&mut numbers) * 0.1,
                numbers.symmetric() * 0.001 + Matrix3::identity() * 0.006,
            ] {
                let update = match law.update(&strain, &State::default()) {
                    Err(PlasticityError::Apex) => continue,
                    update => update.expect("a stress"),
                };
                seen[update.branch as usize] += 1;
                let at = |k, l, by| {
                    law.update(&with_shifted(&strain, k, l, by), &State::default())
                        .expect("a stress")
                        .stress
                };
                let step = 1e-7;
                let difference = |k, l| (at(k, l, step) - at(k, l, -step)) / (2.0 * step);
                assert_tangent(&update.consistent_tangent, difference, 2e-5);
            }
        }
    }
    assert!(seen.iter().all(|count| *count > 2), "{seen:?}");
}

#[test]
fn the_continuum_tangent_is_the_limit_of_short_steps_and_differs_from_the_consistent_tangent_of_a_long_step()
 {
    let mut numbers = Numbers(5);
    for strength in STRENGTHS {
        let law = law(0.6, 0.3, strength);
        let strain = flowing(&mut numbers);
        let update = law.update(&strain, &State::default()).expect("a stress");
        assert_eq!(update.branch, Branch::Cone);
        let continuum = law
            .continuum_tangent(&update.stress, update.state.slip)
            .expect("a tangent");
        // Strain increments that keep the material flowing.
        let (_, normal) = law.directions(&update.stress).expect("a normal");
        for _ in 0..20 {
            let mut increment = numbers.symmetric() + normal;
            if law.elastic_stress(&normal).dot(&increment) < 0.0 {
                increment = -increment;
            }
            let step = 1e-7;
            let next = law
                .update(&(strain + increment * step), &update.state)
                .expect("a stress");
            let rate = (next.stress - update.stress) / step;
            let told = Matrix3::from_fn(|i, j| {
                (0..9)
                    .map(|n| continuum[(i, j, n / 3, n % 3)] * increment[(n / 3, n % 3)])
                    .sum::<f64>()
            });
            assert!((rate - told).norm() < 1e-2, "{rate} {told}");
        }
        let gap = (0..81)
            .map(|n| {
                let index = (n / 27, n / 9 % 3, n / 3 % 3, n % 3);
                (continuum[index] - update.consistent_tangent[index]).abs()
            })
            .fold(0.0, f64::max);
        assert!(gap > 1.0, "{gap}");
    }
}

#[test]
fn stresses_beyond_the_apex_return_to_the_apex() {
    let law = law(0.6, 0.3, STRENGTHS[0]);
    let update = law
        .update(&(Matrix3::identity() * 0.02), &State::default())
        .expect("a stress");
    assert_eq!(update.branch, Branch::Apex);
    let apex = law.hardening().strength(update.state.slip) / 0.6;
    assert!((update.stress - Matrix3::identity() * apex).norm() < 1e-12);
    let volume = update.state.plastic_strain.trace();
    assert!((volume - 0.3 * update.state.slip).abs() < 1e-15);
    assert_eq!(
        law.rate_moduli(&update.stress, update.state.slip),
        Err(PlasticityError::NoDeviator)
    );
}

#[test]
fn excessive_softening_and_exhausted_strength_are_rejected() {
    let steep = Hardening::linear(1.0, -100.0);
    assert_eq!(
        DruckerPrager::von_mises(100.0, 0.25, steep),
        Err(PlasticityError::SnapBack {
            modulus: -100.0,
            least: -100.0
        })
    );
    let metal = law(0.0, 0.0, STRENGTHS[1]);
    let strain = Matrix3::new(0.0, 0.5, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0);
    assert_eq!(
        metal.update(&strain, &State::default()),
        Err(PlasticityError::Exhausted { slip: 0.2 })
    );
    assert!(DruckerPrager::von_mises(100.0, 0.5, STRENGTHS[0]).is_err());
    assert!(DruckerPrager::new(100.0, 0.2, -0.1, 0.0, STRENGTHS[0]).is_err());
}

#[test]
fn plastic_moduli_are_the_slopes_of_the_hardening_curve_and_at_least_the_lowest_modulus() {
    for strength in STRENGTHS {
        let mut lowest = f64::INFINITY;
        for n in 0..4000 {
            let slip = f64::from(n) * 1e-4;
            let step = 1e-7;
            let slope =
                (strength.strength(slip + step) - strength.strength(slip - step)) / (2.0 * step);
            let told = strength.modulus(slip);
            assert!(
                (told - slope).abs() < 1e-6 * (1.0 + told.abs()),
                "{strength:?} {slip}"
            );
            lowest = lowest.min(told);
        }
        let told = strength.lowest_modulus();
        assert!(
            told <= lowest.min(0.0) && lowest.min(0.0) - told < 1e-2,
            "{strength:?} {told} {lowest}"
        );
    }
}
