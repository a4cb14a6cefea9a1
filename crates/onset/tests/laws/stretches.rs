//! Energies of principal stretches compared with laws in invariants and closed forms, for equal, nearly equal and distinct stretches.

use crate::table::{Random, of, quadruples};
use nalgebra::{Matrix3, Vector3};
use onset::kinematics::DeformationGradient;
use onset::material::{
    Hyperelastic, Law, PrincipalEnergy, StrainEnergy, energy_of_stretches, library,
};
use onset::real::Real;

/// Energy `sum lambda^4 + sum lambda^-2 + (sum lambda^2)(sum lambda^6)/3`, which is not separable.
struct ByStretches;

impl PrincipalEnergy for ByStretches {
    fn of_stretches<R: Real>(&self, [a, b, c]: [R; 3]) -> R {
        let sum = |n: i32| a.powi(n) + b.powi(n) + c.powi(n);
        sum(4) + sum(-2) + sum(2) * sum(6) / 3.0
    }
}

impl StrainEnergy for ByStretches {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        energy_of_stretches(self, f)
    }
}

/// The energy of [`ByStretches`] in invariants, by Newton's identities.
struct ByInvariants;

impl StrainEnergy for ByInvariants {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let i = f.invariants();
        let (one, two, three) = (i.first, i.second, i.third);
        let squares = one * one - two * 2.0;
        let cubes = one * one * one - one * two * 3.0 + three * 3.0;
        squares + two / three + one * cubes / 3.0
    }
}

/// Stretches that are distinct, equal, or differ by a relative amount.
fn stretches() -> Vec<[f64; 3]> {
    let apart = [
        0.3, 0.06, 0.05, 0.04, 1e-2, 1e-3, 1e-5, 1e-7, 1e-9, 1e-12, 1e-15, 0.0,
    ];
    let pairs = apart.iter().flat_map(|d| {
        [
            [1.3, 1.3 * (1.0 + d), 0.7],
            [0.6, 1.1, 0.6 * (1.0 - d)],
            [0.9, 0.9 * (1.0 + d), 0.9 * (1.0 + 0.3 * d)],
        ]
    });
    pairs.chain([[2.5, 0.4, 1.0], [1.0, 1.0, 1.0]]).collect()
}

#[test]
fn tangents_are_exact_to_rounding_whether_stretches_coincide_or_not() {
    let mut random = Random::new(7);
    for stretches in stretches() {
        for turns in 0..4 {
            let [left, right] = match turns {
                0 => [Matrix3::identity(); 2],
                1 => [random.planar_rotation(), random.planar_rotation()],
                _ => [random.rotation(), random.rotation()],
            };
            let diagonal = Matrix3::from_diagonal(&Vector3::from(stretches));
            let f = of(&(left * diagonal * right));
            let [computed, expected] = [ByStretches.response(&f), ByInvariants.response(&f)];
            let (computed, expected) = (computed.expect("finite"), expected.expect("finite"));
            let largest = quadruples().map(|n| expected.tangent[n].abs());
            let scale = largest.fold(0.0, f64::max);
            let energy = computed.energy - expected.energy;
            assert!(energy.abs() < 1e-13 * expected.energy, "{stretches:?}");
            let stress = (computed.first_piola - expected.first_piola).amax();
            assert!(stress < 1e-13 * scale, "{stretches:?}: {stress:e}");
            for n in quadruples() {
                let error = (computed.tangent[n] - expected.tangent[n]).abs();
                assert!(
                    error < 2e-13 * scale,
                    "{stretches:?} {n:?}: {error:e} of {scale:e}"
                );
            }
        }
    }
}

/// Energy `sum lambda^exponent + sum lambda^2`.
struct Power(i32);

impl PrincipalEnergy for Power {
    fn of_stretches<R: Real>(&self, stretches: [R; 3]) -> R {
        let [a, b, c] = stretches.map(|own| own.powi(self.0) + own.powi(2));
        a + b + c
    }
}

impl StrainEnergy for Power {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        energy_of_stretches(self, f)
    }
}

#[test]
fn the_tangent_between_close_stretches_is_accurate_for_exponents_of_some_hundred() {
    for exponent in [4, 30, 100, 200, 400, -300] {
        for apart in [0.09, 0.05, 0.03, 0.01, 3e-3, 1e-3, 1e-5, 1e-9] {
            let (a, b) = (0.97, 0.97 * (1.0 + apart));
            let f = DeformationGradient::from_stretches([a, b, 1.1]).expect("admissible");
            let tangent = Power(exponent).response(&f).expect("finite").tangent;
            // A_1212 = (l_1 W_1 - l_2 W_2) / (l_1^2 - l_2^2).
            let p = f64::from(exponent);
            let ratio = ((b - a) / a).ln_1p();
            let squares = (2.0 * ratio).exp_m1();
            let expected = p * a.powi(exponent - 2) * (p * ratio).exp_m1() / squares + 2.0;
            let error = (tangent[(0, 1, 0, 1)] / expected - 1.0).abs();
            assert!(error < 2e-12, "{exponent} {apart:e}: {error:e}");
        }
    }
}

/// `C^SE_1212 = 2 (g_1 - g_2) / (e_1 - e_2)` of `sum (ln lambda)^2`, where `g = ln e / (2 e)`: for `e_2 = e_1 (1 + d)` it is
/// `(ln(1 + d) / d - ln e_1) / (e_1^2 (1 + d))` in a form that loses no digits.
#[test]
fn the_shear_modulus_between_close_logarithmic_strains_is_the_closed_form() {
    let hencky = Law::named("hencky").expect("a law");
    // mu |dev h|^2 + kappa/2 (tr h)^2 with kappa = 2/3 mu is mu |h|^2.
    let law = hencky
        .build(&[("mu", 1.0), ("kappa", 2.0 / 3.0)])
        .expect("admissible");
    for first in [0.7, 1.0, 1.6] {
        for d in [0.5, 0.11, 0.1, 0.02, 1e-3, 1e-6, 1e-9, 1e-12] {
            let (one, two) = (first, first * f64::sqrt(1.0 + d));
            let f = DeformationGradient::from_stretches([one, two, 0.8]).expect("a state");
            let e = one * one;
            // Difference of the stretches as rounded and stored.
            let d = (two - one) * (two + one) / e;
            let expected = (d.ln_1p() / d - e.ln()) / (e * e * (1.0 + d));
            let computed = law.response(&f).expect("finite").second_elasticity()[(0, 1, 0, 1)];
            let error = (computed - expected).abs();
            assert!(
                error < 2e-13 * (1.0 + expected.abs()),
                "{first} {d}: {error:e}"
            );
        }
    }
}

#[test]
fn stresses_of_hencky_and_ogden_agree_with_closed_forms() {
    let build = |name: &str| {
        Law::named(name)
            .expect("a law")
            .build(&[])
            .expect("defaults")
    };
    let (hencky, ogden) = (build("hencky"), build("ogden"));
    let mut random = Random::new(8);
    for _ in 0..20 {
        let l: [f64; 3] = std::array::from_fn(|_| random.stretch(2.0));
        let volume: f64 = l.iter().product();
        let q = [random.rotation(), random.rotation()];
        let f = of(&(q[0] * Matrix3::from_diagonal(&Vector3::from(l)) * q[1].transpose()));
        let principal = |law: &dyn Hyperelastic| {
            let kirchhoff = law.response(&f).expect("finite").cauchy() * f.jacobian();
            (q[0].transpose() * kirchhoff * q[0]).diagonal()
        };
        let (mu, kappa) = (1.0, 5.0 / 3.0);
        let computed = principal(&*hencky);
        for i in 0..3 {
            let expected = 2.0 * mu * (l[i].ln() - volume.ln() / 3.0) + kappa * volume.ln();
            assert!((computed[i] - expected).abs() < 1e-13 * (1.0 + expected.abs()));
        }
        // Expected stress: tau_i = sum mu_p (l_i^a - 1/3 sum_j l_j^a) + kappa J (J - 1), with the isochoric stretches l.
        let computed = principal(&*ogden);
        let terms = [(0.6178, 1.3), (0.001_177, 5.0), (-0.009_807, -2.0)];
        let shape = l.map(|l| l / volume.cbrt());
        for i in 0..3 {
            let term = |(mu, a): &(f64, f64)| {
                let mean = shape.iter().map(|l| l.powf(*a)).sum::<f64>() / 3.0;
                mu * (shape[i].powf(*a) - mean)
            };
            let expected = terms.iter().map(term).sum::<f64>() + 100.0 * volume * (volume - 1.0);
            assert!((computed[i] - expected).abs() < 1e-12 * (1.0 + expected.abs()));
        }
    }
}

/// Stretches under tension along the first axis with free lateral faces, by bisection.
fn uniaxial(law: &dyn Hyperelastic, stretch: f64) -> (f64, f64) {
    let (mut low, mut high) = (0.3, 1.5);
    let response = |lateral: f64| {
        let f = DeformationGradient::from_stretches([stretch, lateral, lateral]);
        law.response(&f.expect("a state"))
            .expect("finite")
            .first_piola
    };
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match response(middle)[(1, 1)] < 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    (low, response(low)[(0, 0)])
}

#[test]
fn nearly_incompressible_rubber_approaches_the_incompressible_formula_in_tension() {
    // P = 2 (lambda - lambda^-2) (W_1 + W_2 / lambda) for incompressible rubber.
    type Derivatives = fn(f64) -> (f64, f64);
    let cases: [(&str, Derivatives); 4] = [
        ("neo-hooke-isochoric", |_| (0.5, 0.0)),
        ("mooney-rivlin-isochoric", |_| (0.4, 0.1)),
        ("yeoh", |x| (0.5 - 0.02 * x + 0.003 * x * x, 0.0)),
        ("gent", |x| (0.5 / (1.0 - x / 97.2), 0.0)),
    ];
    for (name, derivatives) in cases {
        let law = Law::named(name)
            .expect("a law")
            .build(&[("kappa", 1e7)])
            .expect("admissible");
        for stretch in [0.6, 1.2, 2.0, 3.0_f64] {
            let (one, two) = derivatives(stretch * stretch + 2.0 / stretch - 3.0);
            let expected = 2.0 * (stretch - stretch.powi(-2)) * (one + two / stretch);
            let (_, stress) = uniaxial(&*law, stretch);
            let error = (stress - expected).abs();
            assert!(
                error < 1e-5 * (1.0 + expected.abs()),
                "{name} at {stretch}: {error:e}"
            );
        }
    }
}

#[test]
fn compressible_laws_in_uniaxial_tension_agree_with_closed_forms() {
    // The foam of Blatz and Ko: lambda_2 = lambda^(-1/4), P = mu (lambda^(-1/2) ... ) = mu (J - lambda^-2) / lambda.
    let foam = Law::named("generalized-blatz-ko").expect("a law");
    let foam = foam.build(&[("f", 0.0), ("mu", 2.0)]).expect("admissible");
    // Neo-Hooke: mu (b - 1) + lambda ln J = 0 across the pull, P = mu (lambda - lambda_2^2 / lambda).
    let neo = Law::named("neo-hooke")
        .expect("a law")
        .build(&[("lambda", 3.0)])
        .expect("admissible");
    for stretch in [0.7, 1.5, 2.5_f64] {
        let (lateral, stress) = uniaxial(&*foam, stretch);
        assert!((lateral - stretch.powf(-0.25)).abs() < 1e-12);
        let jacobian = stretch.sqrt();
        assert!((stress - 2.0 * (jacobian - stretch.powi(-2)) / stretch).abs() < 1e-11);
        let (lateral, stress) = uniaxial(&*neo, stretch);
        let across = lateral * lateral - 1.0 + 3.0 * (stretch * lateral * lateral).ln();
        assert!(across.abs() < 1e-12);
        assert!((stress - (stretch - lateral * lateral / stretch)).abs() < 1e-11);
    }
}

#[test]
fn laws_that_are_special_cases_of_others_agree_with_them() {
    let build = |name: &str, given: &[(&str, f64)]| {
        Law::named(name)
            .expect("a law")
            .build(given)
            .expect("admissible")
    };
    let one_term = [("mu2", 0.0), ("mu3", 0.0), ("kappa", 7.0)];
    let ogden = |mu: f64, alpha: f64| {
        build(
            "ogden",
            &[&one_term[..], &[("mu1", mu), ("alpha1", alpha)]].concat(),
        )
    };
    let pairs = [
        // Two particular exponents of Ogden's law give the Mooney-Rivlin invariants.
        (
            build(
                "ogden",
                &[
                    ("mu1", 0.8),
                    ("alpha1", 2.0),
                    ("mu2", -0.2),
                    ("alpha2", -2.0),
                    ("mu3", 0.0),
                    ("kappa", 7.0),
                ],
            ),
            build("mooney-rivlin-isochoric", &[("kappa", 7.0)]),
        ),
        (
            ogden(1.0, 2.0),
            build("yeoh", &[("c20", 0.0), ("c30", 0.0), ("kappa", 7.0)]),
        ),
        (
            build("generalized-blatz-ko", &[("f", 0.0)]),
            build("blatz-ko", &[]),
        ),
        // The foam with exponent -2 is the Blatz-Ko foam.
        (
            build(
                "hyperfoam",
                &[("mu1", 32.0), ("alpha1", -2.0), ("beta1", 0.5)],
            ),
            build("blatz-ko", &[]),
        ),
        (
            build(
                "hyperfoam",
                &[("mu1", 2.0), ("alpha1", 2.0), ("beta1", 0.5)],
            ),
            build("generalized-blatz-ko", &[("f", 1.0), ("mu", 2.0)]),
        ),
        (
            build(
                "saint-venant-orthotropic",
                &[
                    ("young1", 2.5),
                    ("young2", 2.5),
                    ("young3", 2.5),
                    ("nu12", 0.25),
                    ("nu13", 0.25),
                    ("nu23", 0.25),
                    ("shear12", 1.0),
                    ("shear13", 1.0),
                    ("shear23", 1.0),
                    ("angle", 20.0),
                ],
            ),
            build("saint-venant-kirchhoff", &[]),
        ),
        (
            build("cubic-crystal", &[("c11", 3.0), ("c12", 1.0), ("c44", 1.0)]),
            build("saint-venant-kirchhoff", &[]),
        ),
        (
            build("standard-reinforcing", &[("gamma", 0.0)]),
            build("neo-hooke", &[]),
        ),
        (
            build("holzapfel-gasser-ogden", &[("k1", 0.0)]),
            build("neo-hooke-isochoric", &[("mu", 3.0)]),
        ),
    ];
    let mut random = Random::new(9);
    for (number, (one, other)) in pairs.iter().enumerate() {
        for _ in 0..6 {
            let f = random.state();
            let [one, other] = [one, other].map(|law| law.response(&f).expect("finite"));
            let scale = quadruples()
                .map(|n| other.tangent[n].abs())
                .fold(0.0, f64::max);
            assert!(
                (one.energy - other.energy).abs() < 1e-12 * scale,
                "pair {number}"
            );
            assert!(
                (one.first_piola - other.first_piola).amax() < 1e-12 * scale,
                "pair {number}"
            );
            for n in quadruples() {
                let error = (one.tangent[n] - other.tangent[n]).abs();
                assert!(error < 1e-12 * scale, "pair {number}: {error:e}");
            }
        }
    }
}

#[test]
fn fibers_carry_compression_only_without_the_switch() {
    let names = [
        "holzapfel-gasser-ogden",
        "holzapfel-gasser-ogden-switch",
        "neo-hooke-isochoric",
    ];
    let [both, switched, matrix] = names.map(|name| {
        let law = library()
            .iter()
            .find(|law| law.name == name)
            .expect("a law");
        law.build(&[("mu", 3.0)]).expect("admissible")
    });
    let stress = |law: &dyn Hyperelastic, stretch: f64| {
        let f = DeformationGradient::from_stretches([stretch, 1.0 / stretch, 1.0]);
        law.response(&f.expect("a state"))
            .expect("finite")
            .first_piola[(0, 0)]
    };
    assert_eq!(stress(&*both, 1.2), stress(&*switched, 1.2));
    assert!((stress(&*switched, 0.8) - stress(&*matrix, 0.8)).abs() < 1e-14);
    assert!(stress(&*both, 0.8) < stress(&*matrix, 0.8) - 0.1);
}

/// For small exponents Ogden's law and the foam with `mu alpha = 2` tend to Hencky's energy `|dev h|^2`, and `|h|^2`, with an error of the order of
/// the exponent; no digit is lost.
#[test]
fn tiny_exponents_lose_no_digits() {
    let logarithms =
        "let h1 = ln(lambda1); let h2 = ln(lambda2); let h3 = ln(lambda3); let t = h1 + h2 + h3;";
    let typed = |energy: &str| {
        let text = format!("{logarithms} {energy}");
        onset::formula::Formula::parse(&text)
            .expect("a formula")
            .with(&[])
            .expect("a law")
    };
    let alpha = 1e-12;
    let ogden = [
        ("mu1", 2.0 / alpha),
        ("alpha1", alpha),
        ("mu2", 0.0),
        ("mu3", 0.0),
        ("kappa", 3.0),
    ];
    let foam = [
        ("mu1", 1.0),
        ("alpha1", alpha),
        ("beta1", 0.5),
        ("mu2", 0.0),
        ("mu3", 0.0),
    ];
    for (law, limit) in [
        (
            library_law("ogden", &ogden),
            typed("h1^2 + h2^2 + h3^2 - t^2/3 + 3/2*(J - 1)^2"),
        ),
        (
            library_law("hyperfoam", &foam),
            typed("h1^2 + h2^2 + h3^2 + t^2/2"),
        ),
    ] {
        for stretches in [[1.3, 0.8, 1.1], [0.6, 1.9, 1.02], [1.2, 1.2, 0.7]] {
            let f = DeformationGradient::from_stretches(stretches).expect("stretches");
            let (own, expected) = (
                law.response(&f).expect("finite"),
                limit.response(&f).expect("finite"),
            );
            assert!(
                (own.energy / expected.energy - 1.0).abs() < 1e-10,
                "{} {}",
                own.energy,
                expected.energy
            );
            let scale = expected.tangent.largest();
            assert!((own.first_piola - expected.first_piola).amax() < 1e-10 * scale);
            for n in 0..81 {
                let index = (n / 27, n / 9 % 3, n / 3 % 3, n % 3);
                let error = own.tangent[index] - expected.tangent[index];
                assert!(error.abs() < 1e-10 * scale, "{index:?}: {error:e}");
            }
        }
    }
}

fn library_law(name: &str, given: &[(&str, f64)]) -> Box<dyn Hyperelastic> {
    Law::named(name)
        .expect("a law")
        .build(given)
        .expect("admissible")
}

/// A bulk modulus multiplies the error of the change of volume. The sum of the logarithms of stretches from `F^T F` has 90 times the error of the
/// determinant here.
#[test]
fn changes_of_volume_are_accurate_although_stretches_differ_by_a_factor_of_ninety() {
    let mut random = Random::new(3);
    let stretches = [9.0, 0.5, 0.1];
    let exact = stretches.iter().map(|x: &f64| x.ln()).sum::<f64>();
    for (name, bulk_energy) in [
        ("hencky", 0.5 * exact * exact),
        (
            "exponentiated-hencky",
            ((0.125 * exact * exact).exp() - 1.0) / 0.25,
        ),
        ("ogden", 0.5 * (exact.exp() - 1.0).powi(2)),
    ] {
        let [stiff, soft] = [1e12, 1.0].map(|kappa| library_law(name, &[("kappa", kappa)]));
        for _ in 0..50 {
            let diagonal = Matrix3::from_diagonal(&Vector3::from(stretches));
            let f = of(&(random.rotation() * diagonal * random.rotation()));
            let energy = |law: &dyn Hyperelastic| law.response(&f).expect("finite").energy;
            let bulk = energy(&*stiff) - energy(&*soft);
            assert!(
                (bulk / ((1e12 - 1.0) * bulk_energy) - 1.0).abs() < 5e-13,
                "{name} {bulk}"
            );
        }
    }
}
