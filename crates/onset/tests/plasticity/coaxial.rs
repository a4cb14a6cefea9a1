//! Laws that flow as materials: compared with loading paths of `follow`, with closed-form return mapping, and with small steps of a tensor update.

use crate::Numbers;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;
use onset::material::{FourthOrder, Hyperelastic, PlaneStress, Response};
use onset::plasticity::{
    Bands, CamClay, DeformationTheory, DruckerPrager, Elasticity, EllipticCap, FiniteState,
    FlowLaw, FlowStress, Gurson, Hardening, Kinematic, Load, Loading, LoadingPath, MohrCoulomb,
    ScalarDamage, Strains, flow_law, follow, library,
};

const G: f64 = 100.0;
const K: f64 = 150.0;
const STRENGTH: [f64; 4] = [1.0, 0.6, 40.0, 0.03];
/// Flow stress of metals in tension: a power law, a slope and a part that saturates.
const METAL: FlowStress = FlowStress {
    initial: 1.7,
    exponent: 0.15,
    reference: 0.02,
    modulus: 1.2,
    saturation: -0.5,
    rate: 20.0,
};
/// Pressure in the reference configuration of the clay.
const PRESSURE: f64 = 1.2;

fn elasticity(scale: f64) -> Elasticity {
    Elasticity {
        shear: G * scale,
        bulk: K * scale,
    }
}

fn hardening() -> Hardening {
    let [initial, residual, modulus, reference] = STRENGTH;
    Hardening::Peak {
        initial,
        residual,
        modulus,
        reference,
    }
}

fn material(name: &str, own: &[(&str, f64)]) -> Box<dyn Hyperelastic> {
    let law = library().iter().find(|law| law.name == name);
    let law = law.expect("a law");
    let [strength, residual, modulus, reference] = STRENGTH;
    let hardens = match law.parameter("yield-stress") {
        Some(_) => METAL.modulus,
        None => modulus,
    };
    let common = [
        ("mu", G),
        ("kappa", K),
        ("strength", strength),
        ("residual", residual),
        ("hardening-modulus", hardens),
        ("reference-slip", reference),
        ("yield-stress", METAL.initial),
        ("exponent", METAL.exponent),
        ("reference-strain", METAL.reference),
        ("saturation-stress", METAL.saturation),
        ("saturation-rate", METAL.rate),
    ];
    let common = common.into_iter();
    let given = common.filter(|(name, _)| law.parameter(name).is_some());
    let given: Vec<_> = given.chain(own.iter().copied()).collect();
    law.build(&given).expect("admissible")
}

/// Law with the same parameters as a material and as a law along axes.
struct Pair {
    name: &'static str,
    material: Box<dyn Hyperelastic>,
    law: Box<dyn FlowLaw>,
    confinement: f64,
}

/// All laws; those along axes with elastic moduli and pressures multiplied by a scale where the reference configuration is under pressure.
fn pairs(scale: f64) -> Vec<Pair> {
    let e = elasticity(1.0);
    let pair = |name, own: &[(&str, f64)], law: Box<dyn FlowLaw>| Pair {
        name,
        material: material(name, own),
        law,
        confinement: if name == "cam-clay" { PRESSURE } else { 0.0 },
    };
    let prager = DruckerPrager::new(G, e.poisson_ratio(), 0.5, 0.2, hardening());
    let coulomb = MohrCoulomb::new(e, 25.0, 8.0, hardening());
    let cap = EllipticCap::new(e, STRENGTH[0], [0.5, 3.0], 0.04);
    let clay = CamClay::new(elasticity(scale), 1.1, 2.5 * scale, 0.05);
    let metal = Hardening::Metal(METAL.in_shear());
    let gurson = Gurson::new(e, 0.02, [1.5, 1.1], metal);
    // In shear a third of the modulus and 1/sqrt(3) of the recovery in tension.
    let kinematic = Kinematic::new(e, 8.0, 3.0, metal);
    let damage = ScalarDamage::new(e, hardening());
    vec![
        pair(
            "drucker-prager",
            &[("friction", 0.5), ("dilatancy", 0.2)],
            Box::new(prager.expect("a law")),
        ),
        pair(
            "mohr-coulomb",
            &[("friction-angle", 25.0), ("dilation-angle", 8.0)],
            Box::new(coulomb.expect("a law")),
        ),
        pair(
            "cap",
            &[
                ("cap-start", 0.5),
                ("preconsolidation", 3.0),
                ("compressibility", 0.04),
            ],
            Box::new(cap.expect("a law")),
        ),
        pair(
            "cam-clay",
            &[
                ("critical-slope", 1.1),
                ("preconsolidation", 2.5),
                ("compressibility", 0.05),
                ("confinement", PRESSURE),
            ],
            Box::new(clay.expect("a law")),
        ),
        pair(
            "gurson",
            &[("voids", 0.02), ("q1", 1.5), ("q2", 1.1)],
            Box::new(gurson.expect("a law")),
        ),
        pair(
            "kinematic",
            &[("kinematic-modulus", 24.0), ("recovery", 27.0_f64.sqrt())],
            Box::new(kinematic.expect("a law")),
        ),
        pair("damage", &[], Box::new(damage.expect("a law"))),
    ]
}

fn deformation_theory() -> Pair {
    let name = "deformation-theory";
    let law = DeformationTheory::new(elasticity(1.0), Hardening::Metal(METAL.in_shear()));
    Pair {
        name,
        material: material(name, &[]),
        law: Box::new(law.expect("a law")),
        confinement: 0.0,
    }
}

fn gradient(f: &Matrix3<f64>) -> DeformationGradient {
    DeformationGradient::new(f.transpose().into()).expect("a deformation gradient")
}

fn at(material: &dyn Hyperelastic, f: &Matrix3<f64>) -> Response {
    material.response(&gradient(f)).expect("a response")
}

fn difference(a: &FourthOrder, b: &FourthOrder) -> f64 {
    (0..81)
        .map(|n| (n / 27, n / 9 % 3, n / 3 % 3, n % 3))
        .map(|place| (a[place] - b[place]).abs())
        .fold(0.0, f64::max)
}

/// Logarithmic strains beyond yield, without symmetry and under some pressure, along rotated axes, and a rotation of the body.
fn state(numbers: &mut Numbers, size: f64) -> (Matrix3<f64>, Matrix3<f64>) {
    let axes = numbers.rotation();
    let strains =
        (Vector3::new(0.5, -0.1, -1.0) + Vector3::from_fn(|_, _| numbers.next()) * 0.2) * size;
    let stretch = axes * Matrix3::from_diagonal(&strains.map(f64::exp)) * axes.transpose();
    let logarithm = axes * Matrix3::from_diagonal(&strains) * axes.transpose();
    (numbers.rotation() * stretch, logarithm)
}

#[test]
fn drucker_prager_is_its_closed_form_return_mapping_on_proportional_paths() {
    let law = pairs(1.0).swap_remove(0);
    let e = elasticity(1.0);
    let other = DruckerPrager::new(G, e.poisson_ratio(), 0.5, 0.2, hardening()).expect("a law");
    let mut numbers = Numbers(7);
    for size in [1e-3, 0.03, 0.1, 0.3] {
        let (f, _) = state(&mut numbers, size);
        let update = other.finite_update(&gradient(&f), &FiniteState::default());
        let update = update.expect("a step");
        let own = at(&*law.material, &f);
        let stress = (own.first_piola - update.first_piola()).amax();
        assert!(stress < 1e-8, "{size}: {stress}");
        let tangent = update.continuum_tangent().expect("flow");
        assert!(difference(&own.tangent, &tangent) < 1e-7 * G, "{size}");
    }
}

/// On paths of constant strain ratios `localize` and the commands for particles give the same answer.
#[test]
fn every_law_has_the_acoustic_tensors_of_its_loading_path() {
    // At finite strain `follow` measures the stress per volume of the stress-free state.
    let scale = (-PRESSURE / K).exp();
    let mut numbers = Numbers(8);
    for pair in pairs(scale).into_iter().chain([deformation_theory()]) {
        let mut count = 0;
        for (path, load) in [
            (LoadingPath::PureShear, Load::Tension),
            (LoadingPath::UniaxialStrain, Load::Compression),
            (LoadingPath::UniaxialStrain, Load::Tension),
        ] {
            let loading = Loading {
                path,
                load,
                strains: Strains::Finite,
                bands: Bands::Bulk,
                confinement: pair.confinement,
                strain_ratio: 0.0,
                slip: 0.03,
            };
            let Ok(found) = follow(&*pair.law, &loading) else {
                continue;
            };
            for point in found.points.iter().skip(1).step_by(17) {
                let f = Matrix3::from_diagonal(&Vector3::from(point.strain).map(f64::exp));
                let own = match pair.material.response(&gradient(&f)) {
                    Ok(own) => own,
                    // Two principal stresses are equal in uniaxial strain.
                    Err(error) if pair.name == "mohr-coulomb" => {
                        assert_eq!(path, LoadingPath::UniaxialStrain);
                        assert!(error.to_string().contains("corner"), "{error}");
                        continue;
                    }
                    Err(error) => panic!("{} {path:?}: {error}", pair.name),
                };
                let cauchy = own.cauchy().diagonal() - Vector3::from(point.stress);
                assert!(cauchy.amax() < 1e-7, "{} {path:?}: {cauchy}", pair.name);
                let n = numbers.rotation().column(0).into_owned();
                let told = point.moduli.acoustic_tensor(&n);
                let spatial = own.spatial_tangent();
                let acoustic = Matrix3::from_fn(|i, k| {
                    (0..9)
                        .map(|m| (m / 3, m % 3))
                        .map(|(j, l)| spatial[(i, j, k, l)] * n[j] * n[l])
                        .sum()
                });
                // `follow` has Kirchhoff stress per volume of the stress-free state.
                let volume = f.determinant() * if pair.confinement > 0.0 { scale } else { 1.0 };
                let error = (acoustic * volume - told).amax();
                assert!(error < 1e-6 * G, "{} {path:?}: {error:e}", pair.name);
                count += 1;
            }
        }
        assert!(count >= 10, "{}: {count}", pair.name);
    }
}

/// The stress follows from the strain: at the strain `s/(3 G) + e` in tension it is `s(e)`.
#[test]
fn deformation_theory_is_its_closed_form_and_its_tangent_the_derivative() {
    let Pair { material, .. } = deformation_theory();
    let mut numbers = Numbers(11);
    let stress = |f: &Matrix3<f64>| {
        let b = SymmetricEigen::new(f * f.transpose());
        let strain = b.eigenvalues.map(|value| 0.5 * value.ln());
        let deviator = strain.add_scalar(-strain.mean());
        let size = (deviator.norm_squared() / 1.5).sqrt();
        let (mut low, mut high) = (0.0, size);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            match METAL.at(middle) / (3.0 * G) + middle < size {
                true => low = middle,
                false => high = middle,
            }
        }
        let tau = deviator * (METAL.at(low) / (1.5 * size)) + Vector3::repeat(K * strain.sum());
        let tau = b.eigenvectors * Matrix3::from_diagonal(&tau) * b.eigenvectors.transpose();
        tau * f.try_inverse().expect("regular").transpose()
    };
    for size in [0.03, 0.2] {
        let (f, _) = state(&mut numbers, size);
        let own = at(&*material, &f);
        let error = (own.first_piola - stress(&f)).amax();
        assert!(error < 1e-8, "{size}: {error:e}");
        let change = Matrix3::from_fn(|_, _| numbers.next());
        let h = 1e-5;
        let told = (stress(&(f + change * h)) - stress(&(f - change * h))) / (2.0 * h);
        let linear = Matrix3::from_fn(|i, j| {
            (0..9)
                .map(|n| own.tangent[(i, j, n / 3, n % 3)] * change[(n / 3, n % 3)])
                .sum()
        });
        let error = (told - linear).amax();
        assert!(error < 1e-6 * G, "{size}: {error:e}");
        let unloading = material.unloading_tangent(&gradient(&f)).expect("a state");
        assert!(unloading.is_none());
    }
}

/// The material and the flow along axes are made from the same parameters.
#[test]
fn flow_along_axes_has_the_parameters_of_the_material() {
    for law in library() {
        let Some(flow) = flow_law(law, &[]) else {
            assert!(law.name.starts_with("hypoelastic"), "{}", law.name);
            continue;
        };
        let flow = flow.expect("a law");
        let defaults = |name: &str| law.parameter(name).map(|own| own.default);
        assert_eq!(Some(flow.elasticity().shear), defaults("mu"));
        let in_shear = defaults("yield-stress").map(|own| own / 3.0_f64.sqrt());
        if let Some(told) = defaults("strength").or(in_shear) {
            assert!(
                (flow.strength() - told).abs() < 1e-12 * told,
                "{}",
                law.name
            );
        }
    }
    let turned = flow_law(&library()[1], &[("angle", 20.0)]).expect("a law that flows");
    assert!(turned.is_err_and(|error| error.to_string().contains("axes of the path")));
}

/// Internal state of the tensor update: inverse plastic metric (of damage: the identity), slip and internal variables.
struct Inner {
    metric: Matrix3<f64>,
    slip: f64,
    internal: Vector3<f64>,
    has_yielded: bool,
}

/// One explicit step to a deformation gradient: principal axes of the trial state, flow of the law in them. Returns the Kirchhoff stress.
///
/// The axes are in the order of the trial strains, so internal variables remain assigned to their axes.
fn step(pair: &Pair, inner: &mut Inner, f: &Matrix3<f64>) -> Matrix3<f64> {
    let trial = SymmetricEigen::new(f * inner.metric * f.transpose());
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| trial.eigenvalues[*b].total_cmp(&trial.eigenvalues[*a]));
    let axes = Matrix3::from_fn(|i, j| trial.eigenvectors[(i, order[j])]);
    let strain = Vector3::from_fn(|i, _| 0.5 * trial.eigenvalues[order[i]].ln());
    let law = &pair.law;
    let elasticity = law.unloading(inner.slip);
    let offset = Vector3::repeat(pair.confinement);
    let mut stress = elasticity.stress(&strain) - offset;
    if !inner.has_yielded {
        inner.internal = law.start(&stress).0;
    }
    let excess = law.excess(&stress, inner.slip, &inner.internal);
    if excess > 0.0 {
        inner.has_yielded = true;
        // Iterations of the cutting plane: each linearizes flow and yield function at the current stress.
        for _ in 0..30 {
            let flow = law
                .flow(&stress, inner.slip, &inner.internal)
                .expect("flow");
            let excess = law.excess(&stress, inner.slip, &inner.internal);
            // Scale of the yield function: its slope along the normal.
            let h = 1e-6;
            let scale = (law.excess(&(stress + flow.normal * h), inner.slip, &inner.internal)
                - law.excess(&(stress - flow.normal * h), inner.slip, &inner.internal))
                / (2.0 * h * flow.normal.norm_squared());
            let rate = excess / scale / (flow.hardening + flow.per_slip * flow.relaxation());
            stress -= flow.elasticity.stress(&flow.direction) * (flow.per_slip * rate);
            inner.slip += rate;
            inner.internal += flow.internal * rate;
            if excess.abs() < 1e-14 {
                break;
            }
        }
        if pair.name != "damage" {
            let elastic = elasticity.strain(&(stress + offset));
            let b =
                axes * Matrix3::from_diagonal(&elastic.map(|e| (2.0 * e).exp())) * axes.transpose();
            let inverse = f.try_inverse().expect("regular");
            inner.metric = inverse * b * inverse.transpose();
        }
    }
    axes * Matrix3::from_diagonal(&stress) * axes.transpose()
}

/// State at the end of a path that is followed in small steps of the tensor update.
fn walked(pair: &Pair, logarithm: &Matrix3<f64>, steps: u32) -> (Matrix3<f64>, Inner) {
    let mut inner = Inner {
        metric: Matrix3::identity(),
        slip: 0.0,
        internal: Vector3::zeros(),
        has_yielded: false,
    };
    let spectrum = SymmetricEigen::new(*logarithm);
    let mut stress = Matrix3::zeros();
    for count in 1..=steps {
        let part = f64::from(count) / f64::from(steps);
        let values = spectrum.eigenvalues.map(|value| (part * value).exp());
        let u = spectrum.eigenvectors
            * Matrix3::from_diagonal(&values)
            * spectrum.eigenvectors.transpose();
        stress = step(pair, &mut inner, &u);
    }
    (stress, inner)
}

#[test]
fn every_law_is_the_limit_of_small_steps_and_its_tangents_belong_to_the_next_step() {
    let mut numbers = Numbers(9);
    for pair in pairs(1.0) {
        for size in [0.03, 0.08] {
            let (f, logarithm) = state(&mut numbers, size);
            let u = {
                let c = SymmetricEigen::new(logarithm);
                let values = c.eigenvalues.map(f64::exp);
                c.eigenvectors * Matrix3::from_diagonal(&values) * c.eigenvectors.transpose()
            };
            let turn = f * u.try_inverse().expect("regular");
            let own = at(&*pair.material, &f);
            // Richardson extrapolation of steps of first order.
            let [coarse, fine] = [2000, 4000].map(|steps| walked(&pair, &logarithm, steps));
            let stress = fine.0 * 2.0 - coarse.0;
            let told = own.first_piola * f.transpose();
            let error = (turn * stress * turn.transpose() - told).amax();
            assert!(error < 2e-5, "{} {size}: {error:e}", pair.name);

            // Steps in random directions, in the sense in which flow continues; the reversed step unloads.
            let unloading = pair.material.unloading_tangent(&gradient(&f));
            let unloading = unloading.expect("a tangent").expect("flow");
            let inner = fine.1;
            let (mut flowed, mut unloaded) = (0, 0);
            for _ in 0..12 {
                let change = Matrix3::from_fn(|_, _| numbers.next());
                let h = 1e-6;
                let stepped = |sign: f64| {
                    let mut copy = Inner { ..inner };
                    let next = u + change * (sign * h);
                    let kirchhoff = step(&pair, &mut copy, &next);
                    let inverse = next.try_inverse().expect("regular");
                    (kirchhoff * inverse.transpose(), copy.slip > inner.slip)
                };
                // Stress at the state itself, with the error of the steps.
                let base = {
                    let mut copy = Inner { ..inner };
                    step(&pair, &mut copy, &u) * u.try_inverse().expect("regular").transpose()
                };
                let spun = turn * change;
                for sign in [1.0, -1.0] {
                    let (next, flows) = stepped(sign);
                    let tangent = match flows {
                        true => &own.tangent,
                        false => &unloading,
                    };
                    let rate = Matrix3::from_fn(|i, j| {
                        (0..9)
                            .map(|m| (m / 3, m % 3))
                            .map(|(k, l)| tangent[(i, j, k, l)] * spun[(k, l)])
                            .sum::<f64>()
                    });
                    let found = turn * (next - base) / (sign * h);
                    let error = (found - rate).amax();
                    assert!(error < 3e-3 * G, "{} {size} {flows}: {error:e}", pair.name);
                    match flows {
                        true => flowed += 1,
                        false => unloaded += 1,
                    }
                }
            }
            assert!(
                flowed > 2 && unloaded > 2,
                "{}: {flowed} {unloaded}",
                pair.name
            );
        }
    }
}

#[test]
fn elastic_states_have_one_tangent_and_yield_where_the_law_does() {
    let mut numbers = Numbers(10);
    for pair in pairs(1.0) {
        let (f, _) = state(&mut numbers, 1e-3);
        let unloading = pair.material.unloading_tangent(&gradient(&f));
        assert_eq!(unloading.expect("a tangent"), None, "{}", pair.name);
        let own = at(&*pair.material, &f);
        let pressure = own.cauchy().trace() / -3.0;
        assert!((pressure - pair.confinement).abs() < 0.5, "{}", pair.name);
    }
    let names = |law: &&onset::material::Law| !law.name.starts_with("hypoelastic");
    assert_eq!(library().iter().filter(names).count(), 3 + pairs(1.0).len());
}

/// States of a ray, in any order, agree with states that are reached from the beginning: during loading, during unloading, and beyond the end of the
/// path.
#[test]
fn states_along_a_ray_are_the_states_of_the_law() {
    let mut numbers = Numbers(12);
    let mut flowing = 0;
    for pair in pairs(1.0) {
        for _ in 0..6 {
            let logarithms: [f64; 3] = std::array::from_fn(|_| 0.2 * numbers.next());
            let mut ray = pair.material.along(logarithms);
            for t in [0.001, 0.2, 0.4, 0.3, 0.999, 1.0, 1.0, 0.4, 1.7, 0.0] {
                let stretches = logarithms.map(|x| (t * x).exp());
                let f = DeformationGradient::from_stretches(stretches).expect("a state");
                let own = pair.material.response(&f).ok();
                let along = ray(t);
                assert_eq!(along.is_some(), own.is_some(), "{} at {t}", pair.name);
                let (Some(along), Some(own)) = (along, own) else {
                    continue;
                };
                let stress = (along.first_piola - own.first_piola).amax();
                assert!(stress < 1e-7, "{} at {t}: {stress:e}", pair.name);
                let tangent = difference(&along.tangent, &own.tangent);
                assert!(tangent < 1e-6 * G, "{} at {t}: {tangent:e}", pair.name);
                let unloading = pair.material.unloading_tangent(&f).expect("a tangent");
                flowing += usize::from(unloading.is_some());
            }
        }
    }
    assert!(flowing > 100, "{flowing}");
}

/// The thickness of a sheet keeps its faces free in both tangents.
#[test]
fn a_sheet_unloads_with_free_faces() {
    let sheet = PlaneStress::new(material("drucker-prager", &[]).into(), 2).expect("a sheet");
    let f = DeformationGradient::from_stretches([1.03, 0.99, 1.0]).expect("a state");
    let unloading = sheet.unloading_tangent(&f).expect("a tangent");
    let unloading = unloading.expect("flow");
    let own = sheet.response(&f).expect("a response");
    let whole = material("drucker-prager", &[]);
    let elastic = whole.unloading_tangent(&own.deformation);
    let elastic = elastic.expect("a tangent").expect("flow");
    for (i, j, k, l) in [(0, 0, 0, 0), (0, 0, 1, 1), (1, 1, 1, 1), (0, 1, 0, 1)] {
        let across = match (i == j, k == l) {
            (true, true) => elastic[(i, j, 2, 2)] * elastic[(2, 2, k, l)] / elastic[(2, 2, 2, 2)],
            _ => 0.0,
        };
        let expected = elastic[(i, j, k, l)] - across;
        assert!((unloading[(i, j, k, l)] - expected).abs() < 1e-9 * G);
    }
    assert!(difference(&own.tangent, &unloading) > 1e-2 * G);
}

#[test]
fn states_that_cannot_be_reached_are_refused_with_the_reason() {
    let told = |name: &str, own: &[(&str, f64)], stretches: [f64; 3]| {
        let f = DeformationGradient::from_stretches(stretches).expect("a state");
        let error = material(name, own).response(&f).expect_err("a refusal");
        error.to_string()
    };
    // Hydrostatic tension reaches the apex of the cone.
    let apex = told("drucker-prager", &[("friction", 0.5)], [1.1; 3]);
    assert!(apex.contains("no deviator"), "{apex}");
    let corner = told(
        "mohr-coulomb",
        &[("friction-angle", 10.0)],
        [0.95, 1.0, 1.0],
    );
    assert!(corner.contains("corner"), "{corner}");
    let law = library().iter().find(|law| law.name == "cam-clay");
    let error = law.expect("a law").build(&[("confinement", 200.0)]);
    let error = error.err().expect("a refusal").to_string();
    assert!(error.contains("does not yield"), "{error}");
    let law = library().iter().find(|law| law.name == "drucker-prager");
    let error = law.expect("a law").build(&[("reference-slip", 1e-5)]);
    let error = error.err().expect("a refusal").to_string();
    assert!(error.contains("softens too fast"), "{error}");
}

/// For softening without friction, the speed of a long wave of the tangent vanishes where `h` falls to the critical modulus, and the elastic tangent
/// keeps its wave speeds.
#[test]
fn a_softening_law_loses_ellipticity_for_loading_but_not_for_unloading() {
    let law = material(
        "drucker-prager",
        &[("friction", 0.0), ("dilatancy", 0.0), ("confinement", 0.0)],
    );
    let smallest = |tangent: FourthOrder, own: &Response| {
        let response = Response {
            tangent,
            ..own.clone()
        };
        Stiffness::<3>::of(&response).minimum().eigenvalue.re
    };
    let f = Matrix3::from_diagonal(&Vector3::new(1.1, 1.0 / 1.1, 1.0));
    let own = at(&*law, &f);
    let unloading = law.unloading_tangent(&gradient(&f)).expect("a tangent");
    assert!(smallest(own.tangent.clone(), &own) < -1e-3 * G);
    assert!(smallest(unloading.expect("flow"), &own) > 0.5 * G);
}
