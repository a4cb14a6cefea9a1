//! Measures at a state compared with independent computations.

use super::{NeoHooke, assert_close};
use nalgebra::{Matrix3, Rotation3, Vector3};
use onset::continuum::Stiffness;
use onset::criteria::{Criterion, State, Witness, has_energy, is_isotropic};
use onset::kinematics::DeformationGradient;
use onset::material::{BlatzKo, Hyperelastic, Law, ModifiedMooneyRivlin};

fn laws() -> [Box<dyn Hyperelastic>; 3] {
    [
        Box::new(ModifiedMooneyRivlin::default()),
        Box::new(BlatzKo::new(1.0).expect("admissible")),
        Box::new(NeoHooke {
            mu: 1.0,
            lambda: 2.0,
        }),
    ]
}

/// Numbers distributed evenly over the unit interval.
fn spread(n: usize, k: usize) -> f64 {
    let root = [0.754_877_666_2, 0.569_840_291_0, 0.437_150_1][k];
    (0.5 + root * (n + 1) as f64).fract()
}

fn states(count: usize) -> impl Iterator<Item = [f64; 3]> {
    (0..count).map(|n| [0, 1, 2].map(|k| (4.0 * spread(n, k) - 2.0).exp2()))
}

fn gradient(matrix: &Matrix3<f64>) -> DeformationGradient {
    let components = std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]));
    DeformationGradient::new(components).expect("admissible")
}

fn energy(law: &dyn Hyperelastic, matrix: &Matrix3<f64>) -> f64 {
    law.response(&gradient(matrix)).expect("finite").energy
}

fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

#[test]
fn the_algebraic_criterion_has_the_sign_of_a_search_over_the_sphere() {
    for law in &laws() {
        let mut lost = 0;
        for stretches in states(60) {
            let f = DeformationGradient::from_stretches(stretches).expect("stretches");
            let response = law.response(&f).expect("finite");
            let tangent = &response.tangent;
            let scale = (0..3).map(|i| tangent[(i, i, i, i)]).fold(1.0, f64::max);
            let searched = Stiffness::<3>::of(&response).minimum().eigenvalue.re;
            let state = State::of_response(response.clone(), true);
            let measure = Criterion::StrongEllipticity
                .measure(&state)
                .expect("defined");
            assert_eq!(
                measure.value > 0.0,
                searched > 0.0,
                "{stretches:?}: {} {searched}",
                measure.value
            );
            assert!(
                measure.value >= searched - 1e-11 * scale,
                "{stretches:?}: {} {searched}",
                measure.value
            );
            let Witness::Wave {
                direction,
                polarization,
            } = measure.witness
            else {
                panic!("a wave is the witness");
            };
            let (n, g) = (Vector3::from(direction), Vector3::from(polarization));
            let q = Stiffness::<3>::of(&response).acoustic_tensor(&n);
            assert_close(g.dot(&(q * g)), measure.value, 1e-10);
            assert!((n.norm() - 1.0).abs() < 1e-12 && (g.norm() - 1.0).abs() < 1e-12);
            lost += usize::from(searched < 0.0);
        }
        assert!(lost > 0, "no state tells the two apart");
    }
}

#[test]
fn rotations_of_state_and_reference_keep_the_measures() {
    let first = Rotation3::from_scaled_axis(Vector3::new(0.4, -0.9, 0.3)).into_inner();
    let second = Rotation3::from_scaled_axis(Vector3::new(-1.1, 0.2, 0.8)).into_inner();
    for law in &laws() {
        for stretches in states(12) {
            let straight = Matrix3::from_diagonal(&Vector3::from(stretches));
            let turned = first * straight * second;
            let states = [straight, turned].map(|f| {
                let response = law.response(&gradient(&f)).expect("finite");
                State::of_response(response, true)
            });
            for criterion in Criterion::ALL {
                if matches!(
                    criterion,
                    Criterion::PlaneEllipticity | Criterion::LoadMaximum
                ) {
                    continue;
                }
                let [a, b] = [0, 1].map(|n| criterion.measure(&states[n]).map(|m| m.value));
                if let (Some(a), Some(b)) = (a, b) {
                    let scale = states[0].response().tangent.clone();
                    let scale = (0..3)
                        .map(|i| scale[(i, i, i, i)].abs())
                        .fold(1.0, f64::max);
                    assert_close(a / scale, b / scale, 1e-10);
                }
            }
        }
    }
}

/// Finite differences of `d^2 W / dln(lambda_i) dln(lambda_j)`, and the shear part by
/// `(tau_1 - tau_2)(lambda_1^2 + lambda_2^2)/(lambda_1^2 - lambda_2^2)`.
#[test]
fn drucker_is_the_hessian_in_logarithms_and_the_jaumann_shear_moduli() {
    for law in &laws() {
        for stretches in states(10) {
            let logs = stretches.map(f64::ln);
            let at = |d: [f64; 3]| {
                let l = [0, 1, 2].map(|i| (logs[i] + d[i]).exp());
                energy(&**law, &Matrix3::from_diagonal(&Vector3::from(l)))
            };
            let h = 1e-3;
            let unit = |i: usize, s: f64| [0, 1, 2].map(|k| if k == i { s } else { 0.0 });
            let add = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| a[k] + b[k]);
            let hessian = Matrix3::from_fn(|i, j| {
                let term = |s: f64, t: f64| at(add(unit(i, s), unit(j, t)));
                let difference = |h: f64| {
                    (term(h, h) - term(h, -h) - term(-h, h) + term(-h, -h)) / (4.0 * h * h)
                };
                (4.0 * difference(h) - difference(2.0 * h)) / 3.0
            });
            let expected = hessian.symmetric_eigenvalues().min();
            let f = DeformationGradient::from_stretches(stretches).expect("stretches");
            let state = State::new(&**law, &f).expect("finite");
            let found = Criterion::DruckerAbaqus
                .measure(&state)
                .expect("defined")
                .value;
            let scale = hessian.amax();
            assert_close(found / scale, expected / scale, 1e-7);
            let response = state.response();
            let tau = response.first_piola * f.matrix().transpose();
            let mut lowest = found;
            for (i, j) in [(0, 1), (0, 2), (1, 2)] {
                let (a, b) = (stretches[i].powi(2), stretches[j].powi(2));
                // Modulus of the shear rate D = (e_i e_j + e_j e_i)/sqrt 2: the value of D : tau°.
                lowest = f64::min(lowest, (tau[(i, i)] - tau[(j, j)]) * (a + b) / (a - b));
            }
            let full = Criterion::Drucker.measure(&state).expect("defined").value;
            assert_close(full / scale, lowest / scale, 1e-7);
        }
    }
}

#[test]
fn hill_rotation_free_is_the_curvature_of_the_energy_in_the_right_stretch_tensor() {
    let rotation = Rotation3::from_scaled_axis(Vector3::new(0.7, 0.4, -0.5)).into_inner();
    for law in &laws() {
        for stretches in states(8) {
            let axes = Rotation3::from_scaled_axis(Vector3::new(0.3, -0.2, 0.6)).into_inner();
            let u = axes * Matrix3::from_diagonal(&Vector3::from(stretches)) * axes.transpose();
            let state = State::new(&**law, &gradient(&(rotation * u))).expect("finite");
            let measure = Criterion::HillRotationFree
                .measure(&state)
                .expect("defined");
            let Witness::DeformationRate { rate } = measure.witness else {
                panic!("a rate is the witness");
            };
            let s = rotation.transpose() * matrix(&rate);
            assert!((s - s.transpose()).amax() < 1e-9 && (s.norm() - 1.0).abs() < 1e-12);
            let h = 1e-3;
            let second = |s: &Matrix3<f64>| {
                let w = |t: f64| energy(&**law, &(u + s * t));
                (16.0 * (w(h) + w(-h)) - w(2.0 * h) - w(-2.0 * h) - 30.0 * w(0.0)) / (12.0 * h * h)
            };
            let scale = Criterion::Hill.measure(&state).expect("defined").neutral / 3e-14;
            assert!((second(&s) - measure.value).abs() < 1e-6 * scale);
            // No other symmetric rate in the sample has a smaller value.
            for n in 0..20 {
                let entry = |k: usize| spread(n, k) - 0.5;
                let trial = Matrix3::new(
                    entry(0),
                    entry(1),
                    entry(2),
                    entry(1),
                    -entry(0),
                    0.7 * entry(1),
                    entry(2),
                    0.7 * entry(1),
                    entry(2) - entry(0),
                );
                assert!(second(&(trial / trial.norm())) > measure.value - 1e-6 * scale);
            }
        }
    }
}

/// With `Fdot = w x F` the form is `tr(tau) |w|^2 - w . tau w`.
#[test]
fn hill_includes_rotations_and_is_lost_where_two_principal_stresses_have_a_negative_sum() {
    let law = NeoHooke {
        mu: 1.0,
        lambda: 2.0,
    };
    for (stretches, holds) in [
        ([1.2, 1.1, 1.05], true),
        ([0.95, 0.97, 0.99], false),
        ([1.3, 0.6, 1.0], false),
    ] {
        let f = DeformationGradient::from_stretches(stretches).expect("stretches");
        let state = State::new(&law, &f).expect("finite");
        let tau = state.response().first_piola * f.matrix();
        let sums = [(0, 1), (0, 2), (1, 2)].map(|(i, j)| tau[(i, i)] + tau[(j, j)]);
        assert_eq!(sums.iter().all(|sum| *sum > 0.0), holds);
        let measure = Criterion::Hill.measure(&state).expect("defined");
        assert_eq!(measure.holds(), holds);
        // The rotation rate e_3 x F has the value tau_1 + tau_2 and the length (l1^2 + l2^2)^(1/2).
        let rotation = sums[0] / (stretches[0].powi(2) + stretches[1].powi(2));
        assert!(measure.value <= rotation + 1e-12);
    }
    // Neutral in the reference configuration: rotations have no energy, all other rates have positive energy.
    let state = State::new(&law, &DeformationGradient::identity()).expect("finite");
    let measure = Criterion::Hill.measure(&state).expect("defined");
    assert!(measure.holds() && measure.value.abs() < 1e-12);
    assert!(
        Criterion::HillRotationFree
            .measure(&state)
            .expect("defined")
            .value
            > 1.0
    );
}

/// Law with one stiffer direction.
struct Fibers;

impl onset::material::StrainEnergy for Fibers {
    fn energy<R: onset::real::Real>(&self, f: &DeformationGradient<R>) -> R {
        let c = f.right_cauchy_green();
        let fiber = c[0][0] - 1.0;
        NeoHooke {
            mu: 1.0,
            lambda: 1.0,
        }
        .energy(f)
            + fiber * fiber * 0.1
    }
}

#[test]
fn isotropy_is_detected() {
    for law in &laws() {
        assert!(is_isotropic(&**law));
    }
    // Its stress overflows at most changes of volume.
    let stiff = Law::named("generalized-blatz-ko").expect("a law");
    for nu in [0.49, 0.499, 0.4999, 0.49999, 0.499_999_5] {
        let stiff = stiff.build(&[("nu", nu)]).expect("admissible");
        assert!(is_isotropic(&*stiff) && has_energy(&*stiff), "{nu}");
    }
    assert!(!is_isotropic(&Fibers) && has_energy(&Fibers));
    let state = State::new(&Fibers, &DeformationGradient::identity()).expect("finite");
    assert_eq!(Criterion::BakerEricksen.measure(&state), None);
    assert!(
        Criterion::StrongEllipticity
            .measure(&state)
            .expect("defined")
            .holds()
    );
}

/// Principal Cauchy stresses of a state along the axes.
fn cauchy(law: &dyn Hyperelastic, stretches: [f64; 3]) -> [f64; 3] {
    let f = DeformationGradient::from_stretches(stretches).expect("stretches");
    let p = law.response(&f).expect("finite").first_piola;
    [0, 1, 2].map(|i| p[(i, i)] * stretches[i] / f.jacobian())
}

/// Finite differences of the principal stresses, and `(sigma_i - sigma_j)(a_i^2 + a_j^2)/(a_i^2 - a_j^2)` for shears of the axes.
#[test]
fn true_stress_monotonicity_is_the_derivative_of_cauchy_stress_with_respect_to_logarithmic_strain()
{
    for law in &laws() {
        let mut lost = 0;
        for stretches in states(40) {
            let step = 1e-5_f64;
            let column = |j: usize| {
                let moved = |sign: f64| {
                    let mut there = stretches;
                    there[j] *= (sign * step).exp();
                    Vector3::from(cauchy(&**law, there))
                };
                (moved(1.0) - moved(-1.0)) / (2.0 * step)
            };
            let derivative = Matrix3::from_columns(&[column(0), column(1), column(2)]);
            let symmetric = (derivative + derivative.transpose()) * 0.5;
            let sigma = cauchy(&**law, stretches);
            let shears = [(0, 1), (1, 2), (2, 0)].map(|(i, j)| {
                let [a, b] = [stretches[i].powi(2), stretches[j].powi(2)];
                (sigma[i] - sigma[j]) * (a + b) / (a - b)
            });
            let expected = shears
                .into_iter()
                .fold(symmetric.symmetric_eigenvalues().min(), f64::min);
            let f = DeformationGradient::from_stretches(stretches).expect("stretches");
            let state = State::new(&**law, &f).expect("finite");
            let measure = Criterion::TrueStressMonotonicity
                .measure(&state)
                .expect("defined");
            let size = symmetric.amax() + expected.abs();
            assert!(
                (measure.value - expected).abs() < 1e-7 * size,
                "{stretches:?}: {} {expected}",
                measure.value
            );
            lost += usize::from(expected < 0.0);
        }
        assert!(lost > 0, "no state loses it");
    }
}

#[test]
fn ordered_forces_compare_differences_of_forces_and_stretches() {
    for law in &laws() {
        for stretches in states(40) {
            let f = DeformationGradient::from_stretches(stretches).expect("stretches");
            let state = State::new(&**law, &f).expect("finite");
            let p = law.response(&f).expect("finite").first_piola;
            let expected = [(0, 1), (1, 2), (2, 0)]
                .map(|(i, j)| (p[(i, i)] - p[(j, j)]) / (stretches[i] - stretches[j]))
                .into_iter()
                .fold(f64::INFINITY, f64::min);
            let measure = Criterion::OrderedForces.measure(&state).expect("defined");
            assert!(
                (measure.value - expected).abs() < 1e-9 * (p.amax() + expected.abs()),
                "{stretches:?}: {} {expected}",
                measure.value
            );
        }
    }
}
