//! Hypoelastic laws compared with time integration of their rates along deformation paths.

use crate::Numbers;
use nalgebra::{Matrix3, Rotation3, Vector3};
use onset::continuum::Stiffness;
use onset::criteria::{Criterion, State};
use onset::kinematics::DeformationGradient;
use onset::lattice::{Crystal, LatticeKind};
use onset::material::{Hyperelastic, Response};
use onset::method::{KernelMethodChoices, Method};
use onset::plasticity::library;
use onset::scheme::Discretization;
use onset::scheme::sph::{
    TotalLagrangianChoices, TotalLagrangianSph, UpdatedSph, UpdatedSphChoices,
};
use onset::verdict::{MaterialAssessment, Phase, Survey, Verdict, probe_material};

const MU: f64 = 1.3;
const KAPPA: f64 = 3.1;
const NAMES: [&str; 2] = ["hypoelastic-jaumann", "hypoelastic-green-naghdi"];

fn law(name: &str, n: f64) -> Box<dyn Hyperelastic> {
    let law = library().iter().find(|law| law.name == name);
    let given = [("mu", MU), ("kappa", KAPPA), ("n", n)];
    law.expect("a law").build(&given).expect("admissible")
}

fn at(material: &dyn Hyperelastic, f: &Matrix3<f64>) -> Response {
    let f = DeformationGradient::new(f.transpose().into()).expect("a deformation gradient");
    material.response(&f).expect("a response")
}

/// Rotation of `F = R U`.
fn rotation(f: &Matrix3<f64>) -> Matrix3<f64> {
    let svd = f.svd(true, true);
    svd.u.expect("left") * svd.v_t.expect("right")
}

fn deviator(tensor: &Matrix3<f64>) -> Matrix3<f64> {
    tensor - Matrix3::identity() * (tensor.trace() / 3.0)
}

fn velocity_gradient(path: &dyn Fn(f64) -> Matrix3<f64>, t: f64) -> (Matrix3<f64>, Matrix3<f64>) {
    let h = 1e-4;
    let rate =
        ((path(t + h) - path(t - h)) * 8.0 - (path(t + 2.0 * h) - path(t - 2.0 * h))) / (12.0 * h);
    let l = rate * path(t).try_inverse().expect("admissible");
    ((l + l.transpose()) * 0.5, (l - l.transpose()) * 0.5)
}

/// Deviator at the end of a path from the stress-free state, by the Runge-Kutta method: the Jaumann rate in fixed axes, the Green-Naghdi rate in the
/// axes rotated by the polar decomposition.
fn integrated(name: &str, path: &dyn Fn(f64) -> Matrix3<f64>, end: f64) -> Matrix3<f64> {
    let is_unrotated = name == NAMES[1];
    let rate = |t: f64, s: &Matrix3<f64>| {
        let (d, w) = velocity_gradient(path, t);
        if is_unrotated {
            let r = rotation(&path(t));
            return deviator(&(r.transpose() * d * r)) * (2.0 * MU);
        }
        deviator(&d) * (2.0 * MU) + w * s - s * w
    };
    let steps = 200;
    let dt = end / f64::from(steps);
    let mut s = Matrix3::zeros();
    for step in 0..steps {
        let t = dt * f64::from(step);
        let k1 = rate(t, &s);
        let k2 = rate(t + 0.5 * dt, &(s + k1 * (0.5 * dt)));
        let k3 = rate(t + 0.5 * dt, &(s + k2 * (0.5 * dt)));
        let k4 = rate(t + dt, &(s + k3 * dt));
        s += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (dt / 6.0);
    }
    match is_unrotated {
        true => {
            let r = rotation(&path(end));
            r * s * r.transpose()
        }
        false => s,
    }
}

fn pressure(n: f64, jacobian: f64) -> f64 {
    match n == 0.0 {
        true => -KAPPA * jacobian.ln(),
        false => KAPPA / n * (jacobian.powf(-n) - 1.0),
    }
}

fn first_piola(n: f64, s: &Matrix3<f64>, f: &Matrix3<f64>) -> Matrix3<f64> {
    let jacobian = f.determinant();
    let cauchy = s - Matrix3::identity() * pressure(n, jacobian);
    cauchy * f.try_inverse().expect("admissible").transpose() * jacobian
}

/// Stretch along oblique axes, and its logarithm.
fn stretch(numbers: &mut Numbers) -> (Matrix3<f64>, Matrix3<f64>) {
    let turn = numbers.rotation();
    let strains = Vector3::new(0.3, -0.12, 0.05) + Vector3::from_fn(|_, _| 0.05 * numbers.next());
    let of = |values: Vector3<f64>| turn * Matrix3::from_diagonal(&values) * turn.transpose();
    (of(strains.map(f64::exp)), of(strains))
}

#[test]
fn stress_and_tangent_agree_with_time_integration_of_the_rates() {
    let mut numbers = Numbers(71);
    for name in NAMES {
        for n in [0.0, 1.0, 7.0] {
            let material = law(name, n);
            let (_, logarithm) = stretch(&mut numbers);
            let turn = numbers.rotation();
            let further = numbers.matrix();
            // The path is R U^t up to t = 1, then straight.
            let state = |t: f64| turn * (logarithm * t).exp();
            let response = at(&*material, &state(1.0));
            let reached = integrated(name, &state, 1.0);
            let stress = first_piola(n, &reached, &state(1.0));
            let error = (response.first_piola - stress).amax();
            assert!(error < 1e-9, "{name} {n}: {error:e}");
            // Rate at the end of the path, from the stress at the end.
            let beyond = |t: f64| state(1.0) + further * t;
            let after = |t: f64| {
                let on = |t: f64| beyond(t);
                let (d, w) = velocity_gradient(&on, 0.0);
                let spin = match name == NAMES[0] {
                    true => w,
                    false => {
                        let h = 1e-5;
                        (rotation(&beyond(h)) - rotation(&beyond(-h))) / (2.0 * h)
                            * rotation(&beyond(0.0)).transpose()
                    }
                };
                let rate = deviator(&d) * (2.0 * MU) + spin * reached - reached * spin;
                first_piola(n, &(reached + rate * t), &beyond(t))
            };
            let h = 1e-4;
            let slope = (after(h) - after(-h)) / (2.0 * h);
            let told = Matrix3::from_fn(|i, j| {
                (0..9)
                    .map(|m| response.tangent[(i, j, m / 3, m % 3)] * further[(m / 3, m % 3)])
                    .sum::<f64>()
            });
            let error = (slope - told).amax() / told.amax();
            assert!(error < 1e-6, "{name} {n}: {error:e}");
        }
    }
}

#[test]
fn the_response_is_objective_and_hookean_at_small_strains() {
    let mut numbers = Numbers(72);
    for name in NAMES {
        let material = law(name, 0.0);
        let (u, _) = stretch(&mut numbers);
        let q = *Rotation3::new(Vector3::new(0.4, -1.1, 0.7)).matrix();
        let (own, turned) = (at(&*material, &u), at(&*material, &(q * u)));
        assert!((turned.first_piola - q * own.first_piola).amax() < 1e-13);
        for n in 0..81 {
            let (i, j, k, l) = (n / 27, n / 9 % 3, n / 3 % 3, n % 3);
            let expected: f64 = (0..9)
                .map(|m| q[(i, m / 3)] * q[(k, m % 3)] * own.tangent[(m / 3, j, m % 3, l)])
                .sum();
            assert!((turned.tangent[(i, j, k, l)] - expected).abs() < 1e-12);
        }
        let (rest, lambda) = (at(&*material, &Matrix3::identity()), KAPPA - MU / 1.5);
        let delta = |i: usize, j: usize| f64::from(u8::from(i == j));
        for n in 0..81 {
            let (i, j, k, l) = (n / 27, n / 9 % 3, n / 3 % 3, n % 3);
            let shear = delta(i, k) * delta(j, l) + delta(i, l) * delta(j, k);
            let expected = lambda * delta(i, j) * delta(k, l) + MU * shear;
            assert!((rest.tangent[(i, j, k, l)] - expected).abs() < 1e-14);
        }
    }
}

#[test]
fn the_energy_is_the_work_along_the_path_and_no_potential_of_the_tangent() {
    let mut numbers = Numbers(73);
    let (u, logarithm) = stretch(&mut numbers);
    for name in NAMES {
        for n in [0.0, 1.0] {
            let material = law(name, n);
            // Simpson's rule for P : dF/dt.
            let power = |t: f64| {
                let f = (logarithm * t).exp();
                at(&*material, &f).first_piola.dot(&(logarithm * f))
            };
            let (steps, mut work) = (200, 0.0);
            for step in 0..steps {
                let t = f64::from(step) / f64::from(steps);
                let h = 1.0 / f64::from(steps);
                work += h / 6.0 * (power(t) + 4.0 * power(t + 0.5 * h) + power(t + h));
            }
            let response = at(&*material, &u);
            assert!((response.energy - work).abs() < 1e-11, "{name} {n}");
            let missing = (0..81)
                .map(|n| (n / 27, n / 9 % 3, n / 3 % 3, n % 3))
                .map(|(i, j, k, l)| response.tangent[(i, j, k, l)] - response.tangent[(k, l, i, j)])
                .fold(0.0_f64, |largest, own| largest.max(own.abs()));
            assert!(missing > 0.1 * MU, "{name} {n}: {missing}");
            // For a state of pure pressure the tangent has major symmetry, as with a potential.
            let pressed = at(&*material, &(Matrix3::identity() * 0.9));
            for n in 0..81 {
                let (i, j, k, l) = (n / 27, n / 9 % 3, n / 3 % 3, n % 3);
                let other = pressed.tangent[(k, l, i, j)];
                assert!((pressed.tangent[(i, j, k, l)] - other).abs() < 1e-13);
            }
        }
    }
}

/// Without rotation no spin rotates the stress of a plane wave whose polarization is its direction; for all other waves the two rates differ.
#[test]
fn the_rates_differ_in_shear_alone() {
    let f = Matrix3::from_diagonal(&Vector3::new(1.3, 0.9, 1.0));
    let [one, other] = NAMES.map(|name| at(&*law(name, 0.0), &f));
    for i in 0..3 {
        for j in 0..3 {
            let place = (i, i, j, j);
            assert!((one.tangent[place] - other.tangent[place]).abs() < 1e-14);
        }
    }
    assert!((one.tangent[(0, 1, 0, 1)] - other.tangent[(0, 1, 0, 1)]).abs() > 1e-3);
    // Derivation by hand: W_12 = (L_12 - L_21)/2, s' = 2 mu D_12 + W_12 (s_2 - s_1), P_12 = J (sigma_12/F_2 ...).
    let sigma = one.cauchy();
    let jacobian = f.determinant();
    let g1212 = MU + 0.5 * (sigma[(1, 1)] - sigma[(0, 0)]);
    let expected = jacobian / 0.81 * g1212;
    assert!((one.tangent[(0, 1, 0, 1)] - expected).abs() < 1e-13);
}

/// A map and a single state give equal results for a tangent without major symmetry.
#[test]
fn maps_and_states_agree_without_major_symmetry() {
    let method = Method::<2>::new(KernelMethodChoices::default()).expect("a method");
    for name in NAMES {
        let material = law(name, 0.0);
        let survey = Survey::new(&method, &*material).expect("a survey");
        let many = survey.clone().for_many_states().expect("moments");
        for stretches in [[1.3, 0.8, 1.0], [1.1, 1.1, 1.0], [0.6, 1.7, 1.0]] {
            let f = DeformationGradient::from_stretches(stretches).expect("a state");
            let assessed = survey.assess(&f).expect("an answer");
            let surveyed = many.state(&f).expect("an answer");
            let (own, other) = (assessed.spectrum.softest.scaled, surveyed.scaled_minimum);
            assert!((own - other).abs() < 1e-9, "{name}: {own} {other}");
            assert_eq!(assessed.verdict, surveyed.verdict);
        }
    }
}

/// Long waves of any method agree with the continuum, whose acoustic tensor is `Q_ik = A_iJkL N_J N_L`.
#[test]
fn long_waves_have_the_acoustic_tensor() {
    let crystal = || Crystal::of_lattice(LatticeKind::Square.lattice::<2>(1.0).expect("a lattice"));
    let total = TotalLagrangianSph::new(crystal(), TotalLagrangianChoices::default());
    let updated = UpdatedSph::new(
        crystal(),
        UpdatedSphChoices {
            corrected: true,
            radius: 4.0,
            ..UpdatedSphChoices::default()
        },
    );
    let (total, updated) = (total.expect("a method"), updated.expect("a method"));
    let methods: [(&dyn Discretization<2>, f64); 2] = [(&total, 1e-5), (&updated, 5e-2)];
    let f = DeformationGradient::from_stretches([1.15, 0.95, 1.0]).expect("a state");
    for name in NAMES {
        let material = law(name, 0.0);
        let stiffness = Stiffness::<2>::of(&material.response(&f).expect("a response"));
        for (method, tolerance) in methods {
            let waves = method.waves(&*material, &f).expect("waves");
            let direction = nalgebra::Vector2::new(0.8, 0.6);
            let small = 1e-3;
            let discrete = waves.dynamical_matrix_at(&(direction * small))
                / nalgebra::Complex::from(small * small);
            let acoustic = stiffness.acoustic_tensor(&direction);
            for (i, k) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let apart = (discrete[(i, k)].re - acoustic[(i, k)]).abs();
                assert!(
                    apart < tolerance * acoustic.amax(),
                    "{name}: {discrete} {acoustic}"
                );
            }
        }
    }
}

/// With the Jaumann rate a shear wave across the smaller of two stretches has the stiffness `mu (1 - ln(a/b))` for any moduli, which vanishes at the
/// ratio `e`. The Green-Naghdi rate gives `mu (1 - 2 x/(e^x + 1))`, `x = ln(a/b)`, which has no zero.
#[test]
fn the_jaumann_rate_loses_ellipticity_at_the_stretch_ratio_e() {
    let root = 0.5_f64.exp();
    for (factor, is_lost) in [(0.999, false), (1.001, true)] {
        let f = DeformationGradient::from_stretches([root * factor, 1.0 / root, 1.0]);
        let f = f.expect("a state");
        let minimum = |name: &str| {
            let response = law(name, 0.0).response(&f).expect("a response");
            Stiffness::<2>::of(&response).minimum()
        };
        assert_eq!(
            minimum(NAMES[0]).ellipticity().is_lost(),
            is_lost,
            "{factor}"
        );
        assert!(minimum(NAMES[1]).ellipticity().is_elliptic());
    }
    for x in [-3.0_f64, -1.0, 0.5, 1.0, 2.0, 4.0] {
        let f = Matrix3::from_diagonal(&Vector3::new((0.5 * x).exp(), (-0.5 * x).exp(), 1.0));
        for (name, expected) in NAMES
            .into_iter()
            .zip([1.0 - x, 1.0 - 2.0 * x / (x.exp() + 1.0)])
        {
            let own = at(&*law(name, 0.0), &f).tangent[(0, 1, 0, 1)];
            assert!(
                (own - MU * expected * x.exp()).abs() < 1e-12 * x.exp(),
                "{name} {x}"
            );
        }
    }
}

/// In three dimensions the Green-Naghdi rate has complex acoustic eigenvalues from a stretch ratio of about six on: waves of the material flutter, so
/// flutter of the particles is physical.
#[test]
fn flutter_of_the_law_is_physical() {
    let law = law(NAMES[1], 0.0);
    let cubic = LatticeKind::SimpleCubic
        .lattice::<3>(1.0)
        .expect("a lattice");
    let choices = TotalLagrangianChoices::default();
    let sph = TotalLagrangianSph::new(Crystal::of_lattice(cubic), choices).expect("a method");
    let survey = Survey::new(&sph, &*law).expect("waves");
    let mut random = Numbers(17);
    for (x, flutters) in [(0.7_f64, false), (1.0, true)] {
        let f = DeformationGradient::from_stretches([x.exp(), (-x).exp(), 1.0]).expect("a state");
        let stiffness = Stiffness::<3>::of(&law.response(&f).expect("a response"));
        let imaginary = |n: &Vector3<f64>| {
            let values = stiffness.acoustic_tensor(n).complex_eigenvalues();
            values
                .iter()
                .fold(0.0_f64, |most, value| most.max(value.im))
        };
        let directions = (0..20_000).map(|_| Vector3::from_fn(|_, _| random.next()).normalize());
        let scan = directions.map(|n| imaginary(&n)).fold(0.0, f64::max);
        let assessment = survey.assess(&f).expect("a state");
        let found = assessment.material.minimum.flutter;
        assert_eq!(found.is_some(), flutters, "{x}: {scan}");
        assert!(assessment.material.minimum.eigenvalue.re > 0.0);
        if let Some(found) = found {
            assert!(
                found.eigenvalue.im > 0.98 * scan && scan > 1e-3,
                "{found:?} {scan}"
            );
            assert!((imaginary(&found.direction) - found.eigenvalue.im).abs() < 1e-9);
            assert_eq!(assessment.verdict, Verdict::Physical);
            assert_eq!(survey.judge(&f).expect("a state").0, Verdict::Physical);
            assert_eq!(
                survey.state(&f).expect("a state").verdict,
                Verdict::Physical
            );
            let probed = probe_material::<3>(&*law, &f).expect("a state");
            assert_eq!(probed.0, Phase::Flutter);
        } else {
            assert!(scan < 1e-6, "{scan}");
        }
    }
}

/// Strong ellipticity requires `g . Q g > 0`; without major symmetry it is lost before the first wave grows.
#[test]
fn strong_ellipticity_is_lost_before_waves_grow() {
    let law = law(NAMES[1], 0.0);
    let f = DeformationGradient::from_stretches([10.0, 0.1, 1.0]).expect("a state");
    let stiffness = Stiffness::<2>::of(&law.response(&f).expect("a response"));
    let form = |angle: f64| {
        let q = stiffness.acoustic_tensor(&nalgebra::Vector2::new(angle.cos(), angle.sin()));
        let (mean, half) = (0.5 * q.trace(), 0.5 * (q[(0, 0)] - q[(1, 1)]));
        mean - half.hypot(0.5 * (q[(0, 1)] + q[(1, 0)]))
    };
    let angles = (0..20_000).map(|n| f64::from(n) * std::f64::consts::PI / 20_000.0);
    assert!(angles.map(form).fold(f64::INFINITY, f64::min) < -1e-3);
    assert!(!stiffness.is_strongly_elliptic());
    assert!(!stiffness.minimum().has_growing_waves());
    let assessed = MaterialAssessment::<2>::new(&*law, &f).expect("a state");
    assert!(assessed.ellipticity.is_lost() && assessed.minimum.ellipticity().is_elliptic());
    // The criteria agree; their closed form for isotropic laws requires symmetric tangents.
    let measure = |criterion: Criterion, x: f64| {
        let f = DeformationGradient::from_stretches([x, 1.0 / x, 1.0]).expect("a state");
        let state = State::new(&*law, &f).expect("a state");
        criterion.measure(&state).expect("a measure").value
    };
    for (x, is_lost) in [(6.0, false), (7.0, true), (10.0, true)] {
        for criterion in [Criterion::StrongEllipticity, Criterion::PlaneEllipticity] {
            assert_eq!(measure(criterion, x) < 0.0, is_lost, "{criterion:?} {x}");
        }
    }
}
