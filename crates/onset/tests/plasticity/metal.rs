//! Metals as materials, compared with Drucker-Prager without friction, and with steps that use only elasticity and yield stress.

use crate::Numbers;
use nalgebra::{Matrix3, Rotation3, Vector3};
use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;
use onset::lattice::{Crystal, LatticeKind};
use onset::material::{Hyperelastic, Law, PlaneStress, Response};
use onset::plasticity::{Criterion, DruckerPrager, FiniteState, Hardening, library};
use onset::scheme::sph::{TotalLagrangianChoices, TotalLagrangianSph};
use onset::verdict::{Survey, Verdict};

const MU: f64 = 80.0;
const KAPPA: f64 = 170.0;

fn law(name: &str, given: &[(&str, f64)]) -> Box<dyn Hyperelastic> {
    let law = library().iter().find(|law| law.name == name);
    law.expect("a law").build(given).expect("admissible")
}

fn at(material: &dyn Hyperelastic, f: &Matrix3<f64>) -> Response {
    let f = DeformationGradient::new(f.transpose().into()).expect("a deformation gradient");
    material.response(&f).expect("a response")
}

/// Stretch without symmetry, beyond yield, and a rotation.
fn state(numbers: &mut Numbers, size: f64) -> Matrix3<f64> {
    let turn = numbers.rotation();
    let strains = Vector3::new(1.0, -0.3, -0.72) * size
        + Vector3::from_fn(|_, _| numbers.next()) * (0.2 * size);
    numbers.rotation() * turn * Matrix3::from_diagonal(&strains.map(f64::exp)) * turn.transpose()
}

#[test]
fn j2_equals_drucker_prager_without_friction() {
    let hardening = [("hardening-modulus", 0.9), ("saturation-stress", 0.0)];
    let steel = law("j2", &hardening);
    let root = 3.0_f64.sqrt();
    let strength = Hardening::linear(0.4 / root, 0.9 / 3.0);
    let poisson = (3.0 * KAPPA - 2.0 * MU) / (2.0 * (3.0 * KAPPA + MU));
    let other = DruckerPrager::von_mises(MU, poisson, strength).expect("a law");
    let mut numbers = Numbers(31);
    for size in [1e-3, 0.02, 0.2, 0.5] {
        let f = state(&mut numbers, size);
        let response = at(&*steel, &f);
        let gradient = response.deformation;
        let update = other
            .finite_update(&gradient, &FiniteState::default())
            .expect("a step");
        assert!(
            (response.first_piola - update.first_piola()).amax() < 1e-9,
            "{size}"
        );
        let tangent = update.continuum_tangent().expect("flow");
        for n in 0..81 {
            let place = (n / 27, n / 9 % 3, n / 3 % 3, n % 3);
            let (own, told) = (response.tangent[place], tangent[place]);
            assert!(
                (own - told).abs() < 1e-8 * MU,
                "{size} {place:?}: {own} {told}"
            );
        }
    }
}

/// Within the yield surface both are Hencky's law.
#[test]
fn a_metal_that_does_not_yield_is_elastic() {
    let hencky = Law::named("hencky").expect("a law");
    let hencky = hencky
        .build(&[("mu", MU), ("kappa", KAPPA)])
        .expect("admissible");
    let mut numbers = Numbers(32);
    for name in ["j2", "hill-1948"] {
        let strong = law(name, &[("yield-stress", 400.0)]);
        let f = state(&mut numbers, 0.3);
        let (own, elastic) = (at(&*strong, &f), at(&*hencky, &f));
        assert!((own.first_piola - elastic.first_piola).amax() < 1e-12);
        assert_eq!(own.tangent, elastic.tangent);
    }
}

/// Hill's law in steps: an independent implementation of elasticity, the yield stress and its normal, with flow by its definition.
struct Steps {
    ratios: [f64; 3],
}

impl Steps {
    fn mandel(elastic: &Matrix3<f64>) -> Matrix3<f64> {
        let squares = (elastic.transpose() * elastic).symmetric_eigen();
        let strains = squares.eigenvalues.map(|square| 0.5 * square.ln());
        let stress = strains.map(|strain| 2.0 * MU * strain + (KAPPA - MU / 1.5) * strains.sum());
        squares.eigenvectors * Matrix3::from_diagonal(&stress) * squares.eigenvectors.transpose()
    }

    fn phi(&self, m: &Matrix3<f64>) -> f64 {
        let [r0, r45, r90] = self.ratios;
        let (g, h) = (1.0 / (1.0 + r0), r0 / (1.0 + r0));
        let f = h / r90;
        let n = (f + g) * (0.5 + r45);
        let differences = f * (m[(1, 1)] - m[(2, 2)]).powi(2)
            + g * (m[(2, 2)] - m[(0, 0)]).powi(2)
            + h * (m[(0, 0)] - m[(1, 1)]).powi(2);
        let shear = 3.0 * (m[(1, 2)].powi(2) + m[(0, 2)].powi(2)) + 2.0 * n * m[(0, 1)].powi(2);
        (differences + shear).sqrt()
    }

    /// Gradient of `phi` by finite differences.
    fn normal(&self, m: &Matrix3<f64>) -> Matrix3<f64> {
        let size = 1e-5 * m.amax();
        Matrix3::from_fn(|i, j| {
            let along = |t: f64| {
                let mut moved = *m;
                moved[(i, j)] += 0.5 * t;
                moved[(j, i)] += 0.5 * t;
                self.phi(&moved)
            };
            (along(size) - along(-size)) / (2.0 * size)
        })
    }

    fn flow_stress(slip: f64) -> f64 {
        0.4 + 0.2 * slip + 0.2 * (1.0 - (-15.0 * slip).exp())
    }

    /// Excess of the yield function at a state.
    fn excess(&self, f: &Matrix3<f64>, inverse: &Matrix3<f64>, slip: f64) -> f64 {
        self.phi(&Self::mandel(&(f * inverse))) - Self::flow_stress(slip)
    }

    /// Plastic `F_p^-1` and slip after a step to `f`; `rest` is the remaining excess of the yield stress.
    fn step(
        &self,
        f: &Matrix3<f64>,
        (inverse, slip): &(Matrix3<f64>, f64),
        rest: f64,
    ) -> (Matrix3<f64>, f64) {
        let slip = *slip;
        let excess = |inverse: &Matrix3<f64>, slip: f64| self.excess(f, inverse, slip) - rest;
        if excess(inverse, slip) <= 0.0 {
            return (*inverse, slip);
        }
        let normal = self.normal(&Self::mandel(&(f * inverse)));
        let flowed = |rate: f64| inverse * (normal * -rate).exp();
        let (mut before, mut rate) = (0.0, excess(inverse, slip) / (3.0 * MU));
        let mut last = excess(inverse, slip);
        for _ in 0..12 {
            let now = excess(&flowed(rate), slip + rate);
            if now.abs() < 1e-13 || now == last {
                break;
            }
            let next = rate - now * (rate - before) / (now - last);
            (before, last, rate) = (rate, now, next);
        }
        (flowed(rate), slip + rate)
    }

    /// Stress `P = F_e^-T M F_p^-T`.
    fn first_piola(f: &Matrix3<f64>, inverse: &Matrix3<f64>) -> Matrix3<f64> {
        let elastic = f * inverse;
        let back = elastic.try_inverse().expect("invertible").transpose();
        back * Self::mandel(&elastic) * inverse.transpose()
    }

    /// End of the proportional path, reached in the given number of steps.
    fn follow(&self, f: &Matrix3<f64>, steps: u32) -> (Matrix3<f64>, f64) {
        let squares = (f.transpose() * f).symmetric_eigen();
        let power = |t: f64| {
            let stretches = squares.eigenvalues.map(|square| square.powf(0.5 * t));
            squares.eigenvectors
                * Matrix3::from_diagonal(&stretches)
                * squares.eigenvectors.transpose()
        };
        let mut reached = (Matrix3::identity(), 0.0);
        for n in 1..=steps {
            reached = self.step(&power(f64::from(n) / f64::from(steps)), &reached, 0.0);
        }
        reached
    }
}

#[test]
fn hill_1948_is_the_limit_of_small_steps_of_flow_and_its_tangent_belongs_to_the_next_step() {
    let ratios = [1.8, 1.3, 2.1];
    let steps = Steps { ratios };
    let sheet = law("hill-1948", &[]);
    let mut numbers = Numbers(33);
    for size in [0.01, 0.1] {
        let f = state(&mut numbers, size);
        let response = at(&*sheet, &f);
        // Errors are linear in the step size, so that two sizes are extrapolated.
        let [coarse, fine] = [1500, 3000].map(|count| steps.follow(&f, count));
        let [rough, close] = [&coarse, &fine].map(|reached| Steps::first_piola(&f, &reached.0));
        let error = (response.first_piola - (close * 2.0 - rough)).amax();
        assert!(
            error < 2e-5 && (close - rough).amax() < 1e-2,
            "{size}: {error:e}"
        );
        // An additional step along the path with a component in each direction. While it loads, the stress is initially linear in it.
        let end = (fine.0 * 2.0 - coarse.0, fine.1 * 2.0 - coarse.1);
        let rest = steps.excess(&f, &end.0, end.1);
        let start = Steps::first_piola(&f, &end.0);
        let rate = |along: &Matrix3<f64>| {
            let after = |t: f64| {
                let moved = f + along * t;
                Steps::first_piola(&moved, &steps.step(&moved, &end, rest).0) - start
            };
            let size = 2e-6;
            (after(size) * 4.0 - after(2.0 * size)) / (2.0 * size)
        };
        // The path satisfies dF/dt = F ln U.
        let squares = (f.transpose() * f).symmetric_eigen();
        let logarithms = squares.eigenvalues.map(|square| 0.5 * square.ln() / size);
        let logarithm = squares.eigenvectors
            * Matrix3::from_diagonal(&logarithms)
            * squares.eigenvectors.transpose();
        let loading = f * logarithm;
        for (k, l) in (0..9).map(|n| (n / 3, n % 3)) {
            let mut along = loading;
            along[(k, l)] += 0.1;
            let found = rate(&along);
            let told = Matrix3::from_fn(|i, j| {
                (0..9)
                    .map(|n| response.tangent[(i, j, n / 3, n % 3)] * along[(n / 3, n % 3)])
                    .sum()
            });
            let error = (found - told).amax();
            assert!(
                error < 3e-3 * told.amax().max(0.1 * MU),
                "{size} {k}{l}: {error:e} of {told}"
            );
        }
    }
}

#[test]
fn hill_with_equal_ratios_is_j2_and_rotates_with_its_axes_and_the_body() {
    let mut numbers = Numbers(34);
    let plain = law("j2", &[]);
    // A ratio close to 1 uses the general branch.
    let near = law(
        "hill-1948",
        &[("r0", 1.0 + 1e-12), ("r45", 1.0), ("r90", 1.0)],
    );
    let [straight, turned] = [0.0, 25.0].map(|angle| law("hill-1948", &[("angle", angle)]));
    for size in [0.005, 0.3] {
        let f = state(&mut numbers, size);
        let (one, other) = (at(&*plain, &f), at(&*near, &f));
        assert!((one.first_piola - other.first_piola).amax() < 1e-8);
        for n in 0..81 {
            let place = (n / 27, n / 9 % 3, n / 3 % 3, n % 3);
            let (own, told) = (one.tangent[place], other.tangent[place]);
            assert!(
                (own - told).abs() < 1e-6 * MU,
                "{size} {place:?}: {own} {told}"
            );
            let reverse = one.tangent[(place.2, place.3, place.0, place.1)];
            assert!((own - reverse).abs() < 1e-12 * MU);
        }
        let axes = *Rotation3::from_axis_angle(&Vector3::z_axis(), 25_f64.to_radians()).matrix();
        let along = at(&*straight, &(f * axes)).first_piola * axes.transpose();
        assert!((at(&*turned, &f).first_piola - along).amax() < 1e-9);
        let body = numbers.rotation();
        let moved = at(&*straight, &(body * f)).first_piola;
        assert!((moved - body * at(&*straight, &f).first_piola).amax() < 1e-8);
    }
}

/// Stretches along the axes of a metal are integrated in four numbers. Rotated by a right angle, which rounding makes inexact, they are integrated in
/// ten.
#[test]
fn stretches_along_and_slightly_off_the_material_axes_have_equal_responses() {
    let along = law("hill-1948", &[]);
    let turned = law("hill-1948", &[("angle", 90.0)]);
    let quarter = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    for stretches in [[1.02, 0.97, 1.01], [1.4, 0.8, 0.95], [0.5, 1.1, 1.6]] {
        let f = Matrix3::from_diagonal(&Vector3::from(stretches));
        let one = at(&*along, &f);
        let other = at(&*turned, &(quarter * f * quarter.transpose()));
        let back = quarter.transpose() * other.first_piola * quarter;
        assert!((one.first_piola - back).amax() < 1e-9, "{stretches:?}");
        // A right angle maps the first axis to the second, and the second to the first.
        let places = [1, 0, 2];
        for (i, k) in (0..9).map(|n| (n / 3, n % 3)) {
            let own = one.tangent[(i, i, k, k)];
            let [i, k] = [places[i], places[k]];
            assert!(
                (own - other.tangent[(i, i, k, k)]).abs() < 1e-7 * MU,
                "{stretches:?} {i}{k}"
            );
        }
    }
}

/// Tension of a sheet by Lankford's definition: the strain ratios under stress along an axis, from the free stretches.
#[test]
fn hills_ratios_are_the_plastic_strain_ratios_in_tension() {
    let given = [("hardening-modulus", 0.0), ("saturation-stress", 0.0)];
    for (angle, ratio) in [(0.0, 1.8), (45.0, 1.3), (90.0, 2.1)] {
        let sheet = law("hill-1948", &[&given[..], &[("angle", angle)]].concat());
        // Large strains, where the elastic part is small; plastic flow preserves the volume.
        let pull = 0.4_f64;
        let (across, thick) = (-pull * ratio / (1.0 + ratio), -pull / (1.0 + ratio));
        let f = Matrix3::from_diagonal(&Vector3::new(pull.exp(), across.exp(), thick.exp()));
        let cauchy = at(&*sheet, &f).cauchy();
        let lateral = cauchy[(1, 1)] - cauchy[(2, 2)];
        assert!(
            lateral.abs() < 2e-2 * (cauchy[(0, 0)] - cauchy[(2, 2)]),
            "{angle}: {cauchy}"
        );
        // With other ratios the lateral stress does not vanish.
        let off = law(
            "hill-1948",
            &[
                &given[..],
                &[("angle", angle), ("r0", 1.0), ("r45", 1.0), ("r90", 1.0)],
            ]
            .concat(),
        );
        let cauchy = at(&*off, &f).cauchy();
        assert!((cauchy[(1, 1)] - cauchy[(2, 2)]).abs() > 5e-2 * (cauchy[(0, 0)] - cauchy[(2, 2)]));
    }
}

/// The localization analysis finds a band at the hardening modulus at which a wave speed of the continuum vanishes.
#[test]
fn a_wave_speed_vanishes_at_the_critical_hardening_modulus() {
    let root = 3.0_f64.sqrt();
    let (first, slope) = (0.8, 1.0);
    let poisson = (3.0 * KAPPA - 2.0 * MU) / (2.0 * (3.0 * KAPPA + MU));
    let strength = Hardening::linear(first / root, slope / 3.0);
    let other = DruckerPrager::von_mises(MU, poisson, strength).expect("a law");
    let f = Matrix3::from_diagonal(&Vector3::new(1.12, 0.9, 1.0));
    let gradient = DeformationGradient::from_stretches([1.12, 0.9, 1.0]).expect("a state");
    let update = other
        .finite_update(&gradient, &FiniteState::default())
        .expect("a step");
    let slip = update.state.slip / root;
    let moduli = update.rate_moduli().expect("flow");
    let critical = 3.0
        * moduli
            .critical(Criterion::StrongEllipticity)
            .expect("a band")
            .modulus;
    let smallest = |modulus: f64| {
        // Laws with equal flow stress at this slip, and different slopes.
        let given = [
            ("yield-stress", first + (slope - modulus) * slip),
            ("hardening-modulus", modulus),
            ("saturation-stress", 0.0),
        ];
        Stiffness::<3>::of(&at(&*law("j2", &given), &f))
            .minimum()
            .eigenvalue
            .re
    };
    assert!(
        smallest(critical).abs() < 1e-7 * MU,
        "{critical}: {}",
        smallest(critical)
    );
    assert!(smallest(critical + 0.02) > 1e-4 * MU * 0.02 && smallest(critical - 0.02) < 0.0);
}

/// The thickness of a metal sheet makes the faces of the three-dimensional metal traction-free, and its tangent belongs to steps of flow that keep
/// them free.
#[test]
fn a_metal_sheet_equals_the_three_dimensional_metal_with_free_faces_in_stress_and_continued_flow() {
    let plane = Matrix3::new(1.1, 0.03, 0.0, -0.02, 0.95, 0.0, 0.0, 0.0, 1.0);
    for (name, given) in [
        (
            "j2",
            vec![("hardening-modulus", 0.9), ("saturation-stress", 0.0)],
        ),
        ("hill-1948", vec![]),
        ("hill-1948", vec![("angle", 30.0)]),
    ] {
        let metal = law(name, &given);
        let sheet = PlaneStress::new(law(name, &given).into(), 2).expect("a sheet");
        let own = at(&sheet, &plane);
        let of_space = metal.response(&own.deformation).expect("a response");
        let p = &of_space.first_piola;
        for i in 0..3 {
            assert!(p[(i, 2)].abs() < 1e-11, "{name}: {p}");
            for j in 0..2 {
                assert!(
                    (own.first_piola[(i, j)] - if i < 2 { p[(i, j)] } else { 0.0 }).abs() < 1e-11
                );
            }
        }
        // The state is beyond yield and nearly isochoric.
        let volume = own.deformation.jacobian();
        assert!((volume - 1.0).abs() < 2e-3, "{name}: {volume}");
        let a = &of_space.tangent;
        let across = Matrix3::from_fn(|m, n| a[(m, 2, n, 2)]);
        let inverse = across.try_inverse().expect("a stiffness");
        for (i, j, k, l) in (0..16).map(|n| (n / 8, n / 4 % 2, n / 2 % 2, n % 2)) {
            let relaxed =
                (0..9).map(|n| a[(i, j, n / 3, 2)] * inverse[(n / 3, n % 3)] * a[(n % 3, 2, k, l)]);
            let expected = a[(i, j, k, l)] - relaxed.sum::<f64>();
            assert!(
                (own.tangent[(i, j, k, l)] - expected).abs() < 1e-9 * MU,
                "{name}"
            );
        }
    }
    // J2 by finite differences: a step of the return mapping from the state, with the thickness that keeps the faces free.
    let strength = Hardening::linear(0.4 / 3.0_f64.sqrt(), 0.9 / 3.0);
    let poisson = (3.0 * KAPPA - 2.0 * MU) / (2.0 * (3.0 * KAPPA + MU));
    let mapping = DruckerPrager::von_mises(MU, poisson, strength).expect("a law");
    let sheet = law(
        "j2",
        &[("hardening-modulus", 0.9), ("saturation-stress", 0.0)],
    );
    let sheet = PlaneStress::new(sheet.into(), 2).expect("a sheet");
    let own = at(&sheet, &plane);
    let start = mapping.finite_update(&own.deformation, &FiniteState::default());
    let start = start.expect("a step");
    let along = own.deformation.matrix() - Matrix3::identity();
    for (first, second) in [(1.0, 0.0), (1.0, 0.4), (0.8, -0.3)] {
        let rate = Matrix3::new(
            first * along[(0, 0)],
            0.3 * along[(0, 1)],
            0.0,
            along[(1, 0)],
            second * along[(1, 1)],
            0.0,
            0.0,
            0.0,
            0.0,
        );
        let step = 1e-5;
        let mut f = own.deformation.matrix() + rate * step;
        let update = |f: &Matrix3<f64>| {
            let f = DeformationGradient::new(f.transpose().into()).expect("a state");
            mapping
                .finite_update(&f, &start.state)
                .expect("a step")
                .first_piola()
        };
        for _ in 0..8 {
            let mut beside = f;
            beside[(2, 2)] += 1e-7;
            let traction = update(&f)[(2, 2)];
            f[(2, 2)] -= traction * 1e-7 / (update(&beside)[(2, 2)] - traction);
        }
        let found = (update(&f) - start.first_piola()) / step;
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let expected: f64 = (0..4)
                .map(|n| own.tangent[(i, j, n / 2, n % 2)] * rate[(n / 2, n % 2)])
                .sum();
            assert!(
                (found[(i, j)] - expected).abs() < 1e-3 * MU * rate.norm(),
                "{found} {expected}"
            );
        }
    }
}

/// The band leaves the loading axis on both sides, so that the axis is a maximum between two close minima.
#[test]
fn a_band_that_leaves_the_axis_is_found_in_the_long_waves_of_a_method() {
    let metal = law("j2", &[]);
    let square = LatticeKind::Square.lattice::<2>(1.0).expect("a lattice");
    let sph = TotalLagrangianSph::new(
        Crystal::of_lattice(square),
        TotalLagrangianChoices {
            penalty: 0.5,
            ..TotalLagrangianChoices::default()
        },
    );
    let sph = sph.expect("a method");
    let survey = Survey::new(&sph, &*metal).expect("a survey");
    for (stretch, verdict) in [(2.71189, Verdict::Stable), (2.711898, Verdict::Physical)] {
        let f = DeformationGradient::from_stretches([stretch, 1.0, 1.0]).expect("a state");
        let found = survey.assess(&f).expect("a state");
        assert_eq!(found.verdict, verdict, "{stretch}");
        let direction = found.material.minimum.direction;
        assert!(direction[1].abs() > 0.01, "{direction}");
        let long_wave = found.spectrum.long_wave.wave_vector.normalize();
        assert!(
            (long_wave[1].abs() - direction[1].abs()).abs() < 1e-5,
            "{long_wave}"
        );
    }
}
