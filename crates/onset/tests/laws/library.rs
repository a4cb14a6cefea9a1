//! Tests of the library: every listed law must pass.

use crate::table::{Random, delta, differentiated, of, quadruples};
use nalgebra::{Matrix3, Rotation3, Vector3};
use onset::certificate::{Certainty, certify};
use onset::kinematics::DeformationGradient;
use onset::material::{Hyperelastic, Law, MaterialError, Response, Symmetry, library};
use onset::method::{KernelMethodChoices, Method};
use onset::real::Interval;

/// Laws of the library with their defaults, and with every parameter changed, with angles away from the axes.
fn laws() -> impl Iterator<
    Item = (
        &'static Law,
        Vec<(&'static str, f64)>,
        Box<dyn Hyperelastic>,
    ),
> {
    library().iter().flat_map(|law| {
        let changed = law.parameters.iter().map(|parameter| {
            let value = match parameter.unit {
                "deg" => parameter.default + 17.0,
                _ => parameter.default * 1.1,
            };
            (parameter.name, value)
        });
        [Vec::new(), changed.collect()].map(|given: Vec<_>| {
            let built = law.build(&given);
            (law, given, built.expect("admissible parameters"))
        })
    })
}

/// Rotation of the material axes of a law about the third axis; zero for fibers on both sides of an axis.
fn turn(law: &Law, given: &[(&'static str, f64)]) -> Matrix3<f64> {
    let is_turned = !law.name.starts_with("holzapfel");
    let angle = given.iter().find(|(name, _)| *name == "angle" && is_turned);
    let radians = angle.map_or(0.0, |(_, degrees)| degrees.to_radians());
    *Rotation3::from_axis_angle(&Vector3::z_axis(), radians).matrix()
}

fn scale_of(material: &dyn Hyperelastic) -> f64 {
    let reference = material.response(&DeformationGradient::identity());
    let tangent = reference.expect("finite").tangent;
    quadruples().map(|n| tangent[n].abs()).fold(0.0, f64::max)
}

#[test]
fn every_law_is_described_by_name_formula_domain_moduli_and_source() {
    for (number, law) in library().iter().enumerate() {
        assert_eq!(Law::named(law.name), Some(law));
        assert!(library()[..number].iter().all(|other| other != law));
        for text in [law.formula, law.domain, law.small_strains, law.source] {
            assert!(!text.is_empty(), "{}", law.name);
        }
        for (number, parameter) in law.parameters.iter().enumerate() {
            assert!(parameter.holds(parameter.default));
            assert!(["stress", "1", "deg"].contains(&parameter.unit));
            let earlier = &law.parameters[..number];
            assert!(earlier.iter().all(|other| other.name != parameter.name));
            // The formula mentions all terms together.
            let is_of_series = parameter.name.ends_with(|last: char| last.is_ascii_digit());
            let is_angle = parameter.unit == "deg";
            let inherits = law.formula.starts_with("as ");
            assert!(
                is_of_series || is_angle || inherits || law.formula.contains(parameter.name),
                "{}: {} is not in the formula",
                law.name,
                parameter.name
            );
        }
    }
}

#[test]
fn inadmissible_values_are_rejected_by_name() {
    for law in library() {
        for parameter in law.parameters {
            let refused = law.build(&[(parameter.name, f64::NAN)]).err();
            assert!(
                matches!(refused, Some(MaterialError::Parameter { name, .. }) if name == parameter.name)
            );
        }
        let unknown = law.build(&[("no such parameter", 1.0)]).err();
        assert!(matches!(
            unknown,
            Some(MaterialError::UnknownParameter { .. })
        ));
    }
}

#[test]
fn stresses_are_derivatives_of_energies_and_tangents_of_stresses() {
    for (law, _, material) in laws() {
        let mut random = Random::new(1);
        let unit = scale_of(&*material);
        for _ in 0..4 {
            let f = random.state();
            let response = material.response(&f).expect("finite");
            let tangents = quadruples().map(|n| response.tangent[n].abs());
            let scale = tangents.fold(unit, f64::max);
            for (k, l) in (0..9).map(|n| (n / 3, n % 3)) {
                let unit = Matrix3::from_fn(|a, b| delta(a, k) * delta(b, l));
                let near = |t: f64| {
                    material
                        .response(&of(&(f.matrix() + unit * t)))
                        .expect("finite")
                };
                let error = response.first_piola[(k, l)] - differentiated(1e-3, |t| near(t).energy);
                assert!(
                    error.abs() < 1e-8 * scale,
                    "{}: P is off by {error:e} at {f:?}",
                    law.name
                );
                for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
                    let along = differentiated(1e-3, |t| near(t).first_piola[(i, j)]);
                    let error = response.tangent[(i, j, k, l)] - along;
                    assert!(
                        error.abs() < 1e-7 * scale,
                        "{}: A{i}{j}{k}{l} is off by {error:e} at {f:?}",
                        law.name
                    );
                }
            }
        }
    }
}

#[test]
fn tangents_are_symmetric_stresses_balanced_and_in_plane_parts_agree() {
    for (law, _, material) in laws() {
        let mut random = Random::new(2);
        for _ in 0..8 {
            let response = material.response(&random.state()).expect("finite");
            let a = &response.tangent;
            let scale = quadruples().map(|n| a[n].abs()).fold(0.0, f64::max);
            for (i, j, k, l) in quadruples() {
                assert!(
                    (a[(i, j, k, l)] - a[(k, l, i, j)]).abs() < 1e-13 * scale,
                    "{}",
                    law.name
                );
            }
            let cauchy = response.cauchy();
            assert!(
                (cauchy - cauchy.transpose()).amax() < 1e-12 * scale,
                "{}",
                law.name
            );
            let planar = random.planar_rotation()
                * Matrix3::from_diagonal(&Vector3::from_fn(|_, _| random.stretch(1.5)))
                * random.planar_rotation();
            let planar = of(&planar);
            let (plane, space) = (material.plane_tangent(&planar), material.response(&planar));
            let (plane, space) = (plane.expect("finite"), space.expect("finite").tangent);
            for (a, b) in (0..16).map(|n| (n / 4, n % 4)) {
                let error = plane[a][b] - space[(a / 2, a % 2, b / 2, b % 2)];
                assert!(error.abs() < 1e-12 * scale, "{}: {error:e}", law.name);
            }
        }
    }
}

/// Rotations of the reference configuration that leave the response unchanged, along material axes.
fn group(symmetry: Symmetry, random: &mut Random) -> Vec<Matrix3<f64>> {
    let about = |axis: usize, angle: f64| {
        let axis = Vector3::ith_axis(axis);
        *Rotation3::from_axis_angle(&axis, angle).matrix()
    };
    let pi = std::f64::consts::PI;
    let half_turns = (0..3).map(|axis| about(axis, pi));
    match symmetry {
        Symmetry::Isotropic => (0..3).map(|_| random.rotation()).collect(),
        Symmetry::TransverselyIsotropic => {
            let free = (0..3).map(|_| about(0, pi * random.number()));
            free.collect::<Vec<_>>()
                .into_iter()
                .chain(half_turns)
                .collect()
        }
        Symmetry::Orthotropic => half_turns.collect(),
        Symmetry::Cubic => {
            let diagonal = nalgebra::Unit::new_normalize(Vector3::new(1.0, 1.0, 1.0));
            let third = *Rotation3::from_axis_angle(&diagonal, 2.0 * pi / 3.0).matrix();
            (0..3)
                .map(|axis| about(axis, 0.5 * pi))
                .chain([third])
                .collect()
        }
    }
}

#[test]
fn energies_are_objective_and_have_the_symmetry_of_their_law() {
    for (law, given, material) in laws() {
        let mut random = Random::new(3);
        let (scale, turn) = (scale_of(&*material), turn(law, &given));
        let energy = |m: Matrix3<f64>| material.response(&of(&m)).expect("finite").energy;
        let mut differs = false;
        for _ in 0..6 {
            let f = random.state().matrix();
            let reference = energy(f);
            let tolerance = 1e-12 * reference.abs().max(scale);
            let objective = energy(random.rotation() * f) - reference;
            assert!(
                objective.abs() < tolerance,
                "{}: W(QF) - W(F) = {objective:e}",
                law.name
            );
            for rotation in group(law.symmetry, &mut random) {
                let turned = turn * rotation * turn.transpose();
                let error = energy(f * turned) - reference;
                assert!(
                    error.abs() < tolerance,
                    "{}: W(FQ) - W(F) = {error:e}",
                    law.name
                );
            }
            differs |= (energy(f * random.rotation()) - reference).abs() > 1e6 * tolerance;
        }
        assert_eq!(differs, law.symmetry != Symmetry::Isotropic, "{}", law.name);
    }
}

#[test]
fn the_angle_of_a_law_rotates_its_response() {
    for law in library() {
        if law.parameter("angle").is_none() || law.name.starts_with("holzapfel") {
            continue;
        }
        let straight = law.build(&[("angle", 0.0)]).expect("admissible");
        let turned = law.build(&[("angle", 33.0)]).expect("admissible");
        let q = turn(law, &[("angle", 33.0)]);
        let mut random = Random::new(4);
        for _ in 0..6 {
            let f = random.state();
            let [one, other] = [
                straight.response(&of(&(f.matrix() * q))).expect("finite"),
                turned.response(&f).expect("finite"),
            ];
            let error = (other.first_piola - one.first_piola * q.transpose()).amax();
            assert!(
                error < 1e-12 * scale_of(&*straight).max(one.first_piola.amax()),
                "{}",
                law.name
            );
        }
    }
}

#[test]
fn the_reference_configuration_is_free_of_stress_and_has_the_moduli_of_the_closed_form() {
    const VOIGT: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)];
    for (law, given, material) in laws() {
        let response = material
            .response(&DeformationGradient::identity())
            .expect("finite");
        let stiffness = law.small_strain_stiffness(&given).expect("admissible");
        let scale = stiffness
            .as_flattened()
            .iter()
            .fold(0.0, |a: f64, b| a.max(b.abs()));
        if law.stressed_reference.is_none() {
            let stress = response.first_piola.amax();
            assert!(stress < 1e-13 * scale, "{}: {stress:e}", law.name);
            assert!(response.energy.abs() < 1e-13 * scale, "{}", law.name);
            for (a, b) in (0..36).map(|n| (n / 6, n % 6)) {
                let ((i, j), (k, l)) = (VOIGT[a], VOIGT[b]);
                let error = response.tangent[(i, j, k, l)] - stiffness[a][b];
                assert!(
                    error.abs() < 1e-12 * scale,
                    "{}: C{a}{b} is off by {error:e}",
                    law.name
                );
            }
        }
    }
}

#[test]
fn enclosures_contain_sampled_responses() {
    for (law, _, material) in laws() {
        let mut random = Random::new(5);
        for width in [0.0, 1e-4, 1e-2] {
            let f = random.state();
            let wide = f
                .components()
                .map(|row| row.map(|x| Interval::new(x - width * 0.5, x + width)));
            let enclosure = material.enclosure(&DeformationGradient::from_components(wide));
            let scale = scale_of(&*material);
            for t in [0.0, 0.7] {
                let inside = of(&f.matrix().map(|x| x + t * width));
                let response = material.response(&inside).expect("finite");
                let near = |bounds: Interval, value: f64| {
                    let slack = 1e-11 * scale.max(value.abs());
                    bounds.low <= value + slack && value - slack <= bounds.high
                };
                assert!(near(enclosure.energy, response.energy), "{}", law.name);
                let of_stretches = OF_STRETCHES.contains(&law.name);
                let is_sharp = |bounds: Interval, value: f64| {
                    width > 0.0 || bounds.width() < 1e-9 * scale.max(value.abs())
                };
                assert!(is_sharp(enclosure.energy, response.energy), "{}", law.name);
                for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
                    let stress = enclosure.first_piola[i][j];
                    let value = response.first_piola[(i, j)];
                    assert!(near(stress, value), "{}", law.name);
                    assert!(is_sharp(stress, value), "{}: {stress:?}", law.name);
                }
                for (i, j, k, l) in quadruples() {
                    let tangent = enclosure.tangent[i][j][k][l];
                    let value = response.tangent[(i, j, k, l)];
                    assert!(near(tangent, value), "{}", law.name);
                    // For a law in principal stretches the bounds are as close as the bounds in principal axes.
                    let is_near = width > 0.0 || tangent.width() < 1e-6 * scale;
                    let known = is_sharp(tangent, value) || (of_stretches && is_near);
                    assert!(known, "{}: {tangent:?}", law.name);
                }
            }
        }
    }
}

/// Laws whose energy is a function of the principal stretches.
const OF_STRETCHES: [&str; 4] = ["ogden", "hyperfoam", "hencky", "exponentiated-hencky"];

#[test]
fn laws_in_principal_stretches_have_a_stress_at_equal_stretches() {
    for name in OF_STRETCHES {
        let law = Law::named(name)
            .expect("a law")
            .build(&[])
            .expect("defaults");
        for stretches in [[1.0; 3], [1.3, 1.3, 0.8], [0.9, 1.2, 0.9]] {
            let f = DeformationGradient::from_stretches(stretches).expect("stretches");
            let response = law.response(&f).expect("finite");
            let point = f.components().map(|row| row.map(Interval::point));
            let enclosure = law.enclosure(&DeformationGradient::from_components(point));
            assert!(enclosure.energy.width() < 1e-10, "{name}");
            for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
                let (bounds, value) = (enclosure.first_piola[i][j], response.first_piola[(i, j)]);
                let near = bounds.low - 1e-12 <= value && value <= bounds.high + 1e-12;
                assert!(near && bounds.width() < 1e-9, "{name}: {bounds:?} {value}");
            }
        }
    }
}

#[test]
fn laws_of_principal_stretches_are_proved_where_stretches_coincide_or_nearly_do() {
    let method = Method::<2>::new(KernelMethodChoices::default()).expect("a method");
    for name in OF_STRETCHES {
        let law = Law::named(name).expect("a law").build(&[]);
        let law = law.expect("defaults");
        for stretches in [
            [1.0, 1.0, 1.0],
            [1.0, 1.1, 1.0],
            [1.1, 1.1, 1.0],
            [1.1, 1.1, 1.1],
            [1.0 + 1e-14, 1.1, 1.0],
            [1.0 + 1e-9, 1.1, 1.0],
            [1.1, 0.95, 1.0],
        ] {
            let f = DeformationGradient::from_stretches(stretches).expect("a state");
            let proof = certify(&method, &*law, &f, 1e-3).expect("a state");
            let is_stable = matches!(proof.material, Certainty::Stable { .. });
            assert!(is_stable, "{name} {stretches:?}: {:?}", proof.material);
        }
    }
}

#[test]
fn a_law_without_bounds_is_neither_proved_nor_refuted() {
    /// Law known only by its floating-point response.
    struct Unbounded(Box<dyn Hyperelastic>);
    impl Hyperelastic for Unbounded {
        fn response(&self, f: &DeformationGradient) -> Result<Response, MaterialError> {
            self.0.response(f)
        }
    }
    let hencky = Law::named("hencky").expect("a law").build(&[]);
    let hencky = Unbounded(hencky.expect("defaults"));
    let method = Method::<2>::new(KernelMethodChoices::default()).expect("a method");
    for stretches in [[1.0, 1.0, 1.0], [1.1, 0.9, 1.0], [3.0, 0.3, 1.0]] {
        let f = DeformationGradient::from_stretches(stretches).expect("a state");
        let proof = certify(&method, &hencky, &f, 1e-3).expect("a state");
        assert!(matches!(proof.material, Certainty::Undecided { .. }));
        assert!(matches!(proof.discretization, Certainty::Undecided { .. }));
    }
}

#[test]
fn gent_rejects_states_beyond_locking_and_reports_the_number() {
    let gent = Law::named("gent")
        .expect("a law")
        .build(&[("jm", 2.0)])
        .expect("admissible");
    let pulled = |stretch: f64| {
        let lateral = f64::powf(stretch, -0.5);
        let f = DeformationGradient::from_stretches([stretch, lateral, lateral]);
        gent.response(&f.expect("a state"))
    };
    // lambda^2 + 2 / lambda = 5 at lambda = 2 exactly.
    assert!(pulled(1.999).is_ok());
    match pulled(2.001) {
        Err(MaterialError::OutsideDomain {
            value, expected, ..
        }) => {
            assert!(value > 2.0 && expected.contains("jm = 2.0"));
        }
        other => panic!("{other:?}"),
    }
}
