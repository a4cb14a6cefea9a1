//! The theorem: on a lattice and quadrature with an inversion center, a Lagrangian kernel cannot destabilize a strongly elliptic material. Without
//! the inversion center it can.

use crate::choices::{Case, config, lagrangian, wave_vector};
use nalgebra::{Matrix2, Vector2};
use onset::algebra::Complex;
use onset::approximation::Approximation;
use onset::bloch::{dynamical_matrix, gradient_norm};
use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::{Hyperelastic, ModifiedMooneyRivlin};
use onset::method::{Background, KernelMethodChoices, Method};
use onset::quadrature::{Quadrature, QuadraturePoint};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

proptest! {
    #![proptest_config(config(400))]
    #[test]
    fn elliptic_states_are_stable_with_lagrangian_kernels(
        case in lagrangian(),
        // Stretches far beyond moderate states, up to the boundary of ellipticity and beyond.
        stretches in prop::array::uniform2(0.4..2.2_f64),
        shear in -0.8..0.8_f64,
        waves in prop::collection::vec(wave_vector(), 8),
    ) {
        let f = [[stretches[0], shear], [0.0, stretches[1]]];
        let state = DeformationGradient::plane_strain(f, 1.0).expect("a state");
        // The theorem requires the same tangent at all points.
        let discretization = KernelMethodChoices { background: Background::Imposed, ..case.discretization };
        let case = Case { discretization, state, ..case };
        let material = case.material();
        let stiffness = Stiffness::<2>::of(&material.response(&state).expect("finite"));
        if stiffness.minimum().eigenvalue.re > 0.0 {
            let d = dynamical_matrix(&case.method(), &*material, &state).expect("finite");
            for k in &waves {
                let lowest = d.omega_squared(k)[0].re;
                prop_assert!(lowest >= -64.0 * d.noise(), "omega^2 = {lowest:e} at {k:?}");
            }
        } else {
            // The converse holds for long waves if the functions are linearly complete.
            let mls = KernelMethodChoices { approximation: Approximation::Mls, ..case.discretization };
            let method = Method::<2>::new(mls).expect("a method");
            let d = dynamical_matrix(&method, &*material, &state).expect("finite");
            prop_assert!(d.long_wave_stiffness().minimum().eigenvalue.re < 1e-9);
        }
    }
}

/// Points in the triangles that point up only, with the whole volume.
fn up_triangles(support: f64) -> Method<2> {
    let method = Method::<2>::new(KernelMethodChoices {
        support,
        ..KernelMethodChoices::default()
    })
    .expect("a method");
    let volume = method.lattice().cell_volume();
    let place = Vector2::repeat(1.0 / 3.0);
    method.with_quadrature_points(vec![QuadraturePoint::new(place, volume)])
}

#[test]
fn stress_points_on_one_family_of_triangles_are_unstable_in_elliptic_states() {
    // At K the gradient is circular, B = b (1, +-i), and omega^2 = 2 |b|^2 (c1 + c2 - |g'(J)|). Stability is lost at the equibiaxial stretch where
    // g'(J) = c1 + c2, long before the material's 1.66977.
    let material = ModifiedMooneyRivlin::default();
    let onset = 1.0068048003;
    let corners = [
        Vector2::new(4.0 * PI / 3.0, 0.0),
        Vector2::new(-4.0 * PI / 3.0, 0.0),
    ];
    for support in [1.6, 2.0, 2.2] {
        let method = up_triangles(support);
        for (stretch, is_stable) in [(onset - 1e-8, true), (onset + 1e-8, false), (1.2, false)] {
            let f = DeformationGradient::from_stretches([stretch, stretch, 1.0]).expect("a state");
            assert!(
                Stiffness::<2>::of(&material.response(&f).expect("finite")).is_strongly_elliptic()
            );
            let d = dynamical_matrix(&method, &material, &f).expect("finite");
            assert!(d.is_hermitian() && !d.is_centrosymmetric());
            let lowest = corners
                .map(|k| d.omega_squared(&k)[0].re)
                .into_iter()
                .fold(f64::INFINITY, f64::min);
            assert_eq!(
                lowest > 0.0,
                is_stable,
                "omega^2 = {lowest:e} at {stretch}, D_mx = {support}"
            );
        }
    }
}

#[test]
fn without_an_inversion_center_the_matrix_is_complex_and_keeps_its_symmetries() {
    let state = DeformationGradient::plane_strain([[1.2, 0.3], [-0.1, 0.9]], 1.0).expect("a state");
    let method = up_triangles(1.9);
    let d = dynamical_matrix(&method, &ModifiedMooneyRivlin::default(), &state).expect("finite");
    let amax = |m: Matrix2<Complex>| m.iter().map(|entry| entry.norm()).fold(0.0, f64::max);
    for k in [
        Vector2::new(2.0, 1.1),
        Vector2::new(-3.7, 0.4),
        Vector2::new(0.6, -5.0),
    ] {
        let at = d.at(&k);
        let imaginary = at.map(|entry| entry.im).amax();
        assert!(imaginary > 1e-3, "complex: {imaginary:e}");
        assert!(amax(at - at.adjoint()) < 1e-13 * amax(at));
        assert!(amax(d.at(&-k) - at.conjugate()) < 1e-13 * amax(at));
        let g = method.lattice().reciprocal() * Vector2::new(1.0, -2.0);
        assert!(amax(d.at(&(k + g)) - at) < 1e-12 * amax(at));
        for axis in 0..2 {
            let h = 1e-4;
            let step = Vector2::from_fn(|i, _| if i == axis { h } else { 0.0 });
            let difference = (d.at(&(k + step)) - d.at(&(k - step))) / Complex::new(2.0 * h, 0.0);
            assert!(amax(d.gradient_at(&k)[axis] - difference) < 1e-6 * amax(at));
        }
    }
}

fn assert_zero_mode(discretization: KernelMethodChoices, k: Vector2<f64>) {
    for [l1, l2] in [[1.1, 0.95], [0.7, 1.4], [1.5, 1.5]] {
        let f = DeformationGradient::from_stretches([l1, l2, 1.0]).expect("a state");
        let method = Method::<2>::new(discretization.clone()).expect("a method");
        let d = dynamical_matrix(&method, &ModifiedMooneyRivlin::default(), &f).expect("finite");
        for omega_squared in d.omega_squared(&k) {
            assert!(
                omega_squared.norm() < 64.0 * d.noise(),
                "{omega_squared} at {k:?} for {discretization:?}"
            );
        }
        let norm = gradient_norm(&method, &f).expect("finite").at(&k)[(0, 0)].norm();
        assert!(norm < 1e-13, "gradient norm {norm:e}");
    }
}

#[test]
fn gradients_vanish_at_half_reciprocal_vectors_if_points_are_inversion_centers() {
    let m = TAU / 3.0_f64.sqrt();
    for approximation in [
        Approximation::Raw,
        Approximation::Shepard,
        Approximation::Mls,
    ] {
        for support in [1.4, 2.0, 2.7] {
            let of = |kind, quadrature| KernelMethodChoices {
                lattice: kind,
                quadrature,
                approximation,
                support,
                ..KernelMethodChoices::default()
            };
            for k in [
                (0.0, m),
                (PI, 0.5 * m),
                (-PI, 0.5 * m),
                (4.0 * PI / 3.0, 0.0),
                (-2.0 * PI / 3.0, m),
            ] {
                assert_zero_mode(
                    of(LatticeKind::Hexagonal, Quadrature::Nodal),
                    Vector2::new(k.0, k.1),
                );
            }
            for k in [(PI, 0.0), (0.0, PI), (PI, PI)] {
                assert_zero_mode(
                    of(LatticeKind::Square, Quadrature::Nodal),
                    Vector2::new(k.0, k.1),
                );
            }
            assert_zero_mode(
                of(LatticeKind::Square, Quadrature::StressPoints),
                Vector2::new(PI, PI),
            );
        }
    }
}

#[test]
fn stress_points_on_triangles_remove_the_zero_energy_modes_except_at_isolated_supports() {
    let k = Vector2::new(4.0 * PI / 3.0, 0.0);
    let norm = |support: f64| {
        let discretization = KernelMethodChoices {
            support,
            ..KernelMethodChoices::default()
        };
        let method = Method::<2>::new(discretization).expect("a method");
        let at = gradient_norm(&method, &DeformationGradient::identity())
            .expect("finite")
            .at(&k);
        at[(0, 0)].re / method.lattice().laplacian(&k)
    };
    for support in [1.2, 1.6, 2.0, 2.2, 2.5] {
        assert!(
            norm(support) > 1e-6,
            "D_mx = {support}: {:e}",
            norm(support)
        );
    }
    for support in [2.2750687324, 2.4014170277, 3.7267653927, 4.0162479014] {
        assert!(
            norm(support) < 1e-16,
            "D_mx = {support}: {:e}",
            norm(support)
        );
    }
}
