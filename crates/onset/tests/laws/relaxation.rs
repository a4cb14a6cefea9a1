//! Viscoelastic laws compared with the integrated stress of a strain history, and waves of the standard solid.

use crate::random::Random;
use nalgebra::{DMatrix, Matrix3};
use onset::algebra::Complex;
use onset::analysis::analysis;
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, Moduli, PronyTerm, Viscoelastic, library};
use onset::scheme::MethodChoices;
use onset::scheme::element::ElementChoices;
use std::sync::Arc;

/// Two terms with both kinds of relaxation, and two that relax both parts of the stress alike.
fn series(alike: bool) -> Vec<PronyTerm> {
    let terms = [(0.25, 0.1, 0.3), (0.35, 0.05, 4.0)];
    let term = |(shear, bulk, time): (f64, f64, f64)| PronyTerm {
        shear,
        bulk: if alike { shear } else { bulk },
        time,
    };
    terms.map(term).to_vec()
}

fn law(name: &str) -> Arc<dyn Hyperelastic> {
    let mut laws = library().iter().chain(onset::plasticity::library());
    let found = laws.find(|law| law.name == name).expect("a law");
    Arc::from(found.build(&[]).expect("defaults"))
}

fn state(matrix: &Matrix3<f64>) -> DeformationGradient {
    let rows = std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]));
    DeformationGradient::new(rows).expect("a state")
}

/// Deviatoric and mean part of the second Piola-Kirchhoff stress.
fn split(law: &dyn Hyperelastic, f: &Matrix3<f64>) -> [Matrix3<f64>; 2] {
    let (_, stress) = law.energy_and_stress(&state(f)).expect("a stress");
    let kirchhoff = stress * f.transpose();
    let mean = Matrix3::identity() * (kirchhoff.trace() / 3.0);
    let inverse = f.try_inverse().expect("regular");
    [kirchhoff - mean, mean].map(|part| inverse * part * inverse.transpose())
}

/// First Piola-Kirchhoff stress at the time 0 after the history `F + e H exp(s t)`, with overstresses integrated in small steps.
fn integrated(
    law: &dyn Hyperelastic,
    terms: &[PronyTerm],
    [f, h]: [&Matrix3<f64>; 2],
    amplitude: f64,
    rate: f64,
) -> Matrix3<f64> {
    let steps = 12_000;
    let start = -24.0 / rate;
    let at = |n: usize| {
        let time = start * (1.0 - n as f64 / f64::from(steps));
        f + h * (amplitude * (rate * time).exp())
    };
    let step = -start / f64::from(steps);
    let mut before = split(law, f);
    let mut overstress = vec![Matrix3::zeros(); terms.len()];
    for n in 1..=steps as usize {
        let now = split(law, &at(n));
        for (own, term) in overstress.iter_mut().zip(terms) {
            let decay = (-step / term.time).exp();
            let share = (1.0 - decay) * term.time / step;
            let change = (now[0] - before[0]) * term.shear + (now[1] - before[1]) * term.bulk;
            *own = *own * decay + change * share;
        }
        before = now;
    }
    let remaining = |part: fn(&PronyTerm) -> f64| 1.0 - terms.iter().map(part).sum::<f64>();
    let long_term =
        before[0] * remaining(|term| term.shear) + before[1] * remaining(|term| term.bulk);
    at(steps as usize) * (long_term + overstress.iter().sum::<Matrix3<f64>>())
}

#[test]
fn the_tangent_of_a_growing_disturbance_follows_from_the_integrated_history() {
    let mut random = Random::new(20);
    for (name, alike) in [
        ("neo-hooke-isochoric", false),
        ("mooney-rivlin-isochoric", false),
        ("ogden", false),
        ("hyperfoam", true),
        ("blatz-ko", true),
    ] {
        let law = law(name);
        let terms = series(alike);
        let relaxing = Viscoelastic::new(Arc::clone(&law), terms.clone(), Moduli::Instantaneous);
        let relaxing = relaxing.expect("a series");
        let mut matrix = |size: f64| Matrix3::from_fn(|_, _| size * (2.0 * random.number() - 1.0));
        let f = Matrix3::identity() + matrix(0.25);
        let h = matrix(1.0);
        let rate = 0.7;
        let [shear, bulk] = terms.iter().fold([0.0; 2], |sums, term| {
            let lag = rate * term.time / (1.0 + rate * term.time);
            [sums[0] + term.shear * lag, sums[1] + term.bulk * lag]
        });
        let response = relaxing.disturbed([shear, bulk]).response(&state(&f));
        let response = response.expect("a response");
        let amplitude = 1e-5;
        let ends =
            [1.0, -1.0].map(|side| integrated(&*law, &terms, [&f, &h], side * amplitude, rate));
        let found = (ends[0] - ends[1]) / (2.0 * amplitude);
        let expected = Matrix3::from_fn(|i, j| {
            let terms = (0..9).map(|n| response.tangent[(i, j, n / 3, n % 3)] * h[(n / 3, n % 3)]);
            terms.sum()
        });
        let scale = expected.amax();
        assert!(
            (found - expected).amax() < 1e-5 * scale,
            "{name}: {found} {expected}"
        );
        // Without the disturbance the relaxed law gives the stress.
        let rest = integrated(&*law, &terms, [&f, &h], 0.0, rate);
        assert!(
            (rest - response.first_piola).amax() < 1e-11 * rest.amax(),
            "{name}"
        );
    }
}

#[test]
fn constants_are_long_term_or_instantaneous_moduli() {
    let mut random = Random::new(21);
    for (name, alike) in [
        ("ogden", false),
        ("hyperfoam", true),
        ("hypoelastic-jaumann", false),
    ] {
        let law = law(name);
        let f = state(&(Matrix3::identity() + 0.2 * random.rotation()).map(|x| x / 1.1));
        let build = |constants| {
            Viscoelastic::new(Arc::clone(&law), series(alike), constants).expect("a series")
        };
        let own = law.response(&f).expect("a response");
        let [long, short] = [build(Moduli::LongTerm), build(Moduli::Instantaneous)];
        assert_eq!(long.relaxed().response(&f).expect("a response"), own);
        assert_eq!(short.instantaneous().response(&f).expect("a response"), own);
        // Scaling the constants back and forth changes nothing.
        let whole = Viscoelastic::new(short.relaxed(), series(alike), Moduli::LongTerm);
        let whole = whole.expect("a series").instantaneous().response(&f);
        let difference = whole.expect("a response").first_piola - own.first_piola;
        assert!(difference.amax() < 1e-12 * own.first_piola.amax(), "{name}");
        // Energy and stress of the relaxed law belong together.
        if !law.is_path_dependent() {
            let step = 1e-6;
            let energy = |side: f64| {
                let mut components = *f.components();
                components[0][1] += side * step;
                let f = DeformationGradient::new(components).expect("a state");
                short.relaxed().response(&f).expect("a response").energy
            };
            let slope = (energy(1.0) - energy(-1.0)) / (2.0 * step);
            let stress = short
                .relaxed()
                .response(&f)
                .expect("a response")
                .first_piola[(0, 1)];
            assert!(
                (slope - stress).abs() < 1e-7 * own.first_piola.amax(),
                "{name}"
            );
        }
    }
}

#[test]
fn impossible_series_are_refused_with_a_reason() {
    let term = |shear, bulk, time| PronyTerm { shear, bulk, time };
    for (name, terms, reason) in [
        ("blatz-ko", vec![term(0.2, 0.1, 1.0)], "expected g = k"),
        (
            "ogden",
            vec![term(0.6, 0.0, 1.0), term(0.4, 0.0, 2.0)],
            "add up to 1",
        ),
        (
            "ogden",
            vec![term(0.6, 0.0, 0.0)],
            "a relaxation time is 0.0",
        ),
        ("ogden", vec![term(-0.1, 0.0, 1.0)], "a fraction g is -0.1"),
        (
            "ogden",
            vec![term(0.1, f64::NAN, 1.0)],
            "a fraction k is NaN",
        ),
    ] {
        let refused = Viscoelastic::new(law(name), terms, Moduli::LongTerm).err();
        let told = refused.expect("refused").to_string();
        assert!(told.contains(reason), "{told}");
    }
}

/// At `F = 1` a single term with `g = k` makes each wave a standard linear solid: `s^2 + w^2 (1 - g)(...)`, with the frequency `w` of the instantaneous law,
/// `s^2 (1 + s tau) + w^2 (1 - g)(1 + s tau) + w^2 g s tau = 0`.
#[test]
fn waves_of_the_reference_state_are_standard_linear_solids() {
    let (part, time) = (0.4, 0.2);
    let terms = vec![PronyTerm {
        shear: part,
        bulk: part,
        time,
    }];
    let law = Viscoelastic::new(law("blatz-ko"), terms, Moduli::Instantaneous).expect("a series");
    let choices = MethodChoices::FiniteElements(ElementChoices::default());
    let of = |law| analysis(&choices, law).expect("a method");
    let (relaxed, instantaneous) = (of(law.relaxed()), of(law.instantaneous()));
    let rest = DeformationGradient::identity();
    let waves = instantaneous.waves(&rest).expect("waves");
    let relaxing = relaxed.relaxing(&rest, &law).expect("waves");
    for k in [[0.3, 0.1], [2.0, 1.0], [3.0, -2.5]] {
        let rates = relaxing.rates(&k);
        assert_eq!(rates.len(), 6);
        for square in waves.omega_squared(&k) {
            let square = square.re;
            let cubic = DMatrix::from_row_slice(
                3,
                3,
                &[
                    0.0,
                    1.0,
                    0.0,
                    0.0,
                    0.0,
                    1.0,
                    -square * (1.0 - part) / time,
                    -square,
                    -1.0 / time,
                ],
            );
            for root in cubic.complex_eigenvalues().iter() {
                let distance = |rate: &Complex| (rate - root).norm();
                let nearest = rates.iter().map(distance).fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-9 * square.sqrt(), "{root} is not in {rates:?}");
            }
        }
    }
    assert_eq!(relaxing.fastest().0, 0.0);
}
