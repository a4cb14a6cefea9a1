//! Dynamical matrices: symmetries, translations, long waves.

use crate::choices::{Case, case, config, lagrangian, planar_state, wave_vector};
use nalgebra::{Matrix2, Vector2};
use onset::algebra::Complex;
use onset::approximation::Approximation;
use onset::bloch::{DynamicalMatrix, dynamical_matrix};
use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::method::{Background, CurrentLattice, Frame, KernelMethodChoices};
use onset::quadrature::Quadrature;
use proptest::prelude::*;

fn amax(m: &Matrix2<Complex>) -> f64 {
    m.iter().map(|entry| entry.norm()).fold(0.0, f64::max)
}

fn matrix(case: &Case) -> DynamicalMatrix<2> {
    matrix_at(case, &case.state)
}

fn matrix_at(case: &Case, f: &DeformationGradient) -> DynamicalMatrix<2> {
    dynamical_matrix(&case.method(), &*case.material(), f).expect("an admissible state")
}

/// Rotates the state after or before the deformation.
fn rotated(
    after: &Matrix2<f64>,
    f: &DeformationGradient,
    before: &Matrix2<f64>,
) -> DeformationGradient {
    f.with_leading::<2>(&(after * f.leading::<2>() * before.transpose()))
}

fn rotation(angle: f64) -> Matrix2<f64> {
    *nalgebra::Rotation2::new(angle).matrix()
}

/// Size of the entries, estimated from a few waves.
fn scale(d: &DynamicalMatrix<2>) -> f64 {
    [(3.0, 0.0), (0.0, 3.0), (1.5, 1.5), (2.0, -1.0)]
        .iter()
        .map(|k| amax(&d.at(&Vector2::new(k.0, k.1))))
        .fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(config(300))]

    #[test]
    fn lagrangian_matrices_are_hermitian(case in lagrangian(), k in wave_vector()) {
        let d = matrix(&case);
        prop_assert!(d.is_hermitian());
        prop_assert!(amax(&(d.at(&k) - d.at(&k).adjoint())) < 1e-12 * scale(&d));
    }

    #[test]
    fn opposite_waves_have_conjugate_matrices(case in case(), k in wave_vector()) {
        let d = matrix(&case);
        prop_assert!(amax(&(d.at(&-k) - d.at(&k).conjugate())) < 1e-13 * scale(&d));
        // All these lattices have an inversion center, so that the matrix is real.
        prop_assert!(d.is_centrosymmetric());
    }

    #[test]
    fn waves_that_differ_by_a_reciprocal_vector_are_equal(
        case in case(), k in wave_vector(), n in prop::array::uniform2(-2..3_i32),
    ) {
        let (method, d) = (case.method(), matrix(&case));
        let g = method.lattice().reciprocal() * Vector2::from(n.map(f64::from));
        if method.is_periodic() {
            prop_assert!(amax(&(d.at(&(k + g)) - d.at(&k))) < 1e-11 * scale(&d));
        }
    }

    #[test]
    fn translations_cost_no_energy(case in case()) {
        // Raw weights on a distorted lattice are not a partition of unity.
        let d = matrix(&case);
        let is_partition = case.discretization.approximation != Approximation::Raw
            || case.discretization.frame == Frame::Lagrangian;
        if is_partition {
            prop_assert_eq!(d.rigid_translation(), &Matrix2::zeros());
        }
        prop_assert!(amax(&(d.at(&Vector2::zeros()) - d.rigid_translation().map(|x| Complex::new(x, 0.0)))) == 0.0);
    }

    #[test]
    fn derivatives_with_respect_to_the_wave_vector_agree_with_finite_differences(case in case(), k in wave_vector()) {
        let d = matrix(&case);
        let h = 1e-3;
        for axis in 0..2 {
            let step = Vector2::from_fn(|i, _| if i == axis { h } else { 0.0 });
            let at = |t: f64| d.at(&(k + step * t));
            let difference = ((at(1.0) - at(-1.0)) * Complex::new(8.0, 0.0) - (at(2.0) - at(-2.0)))
                / Complex::new(12.0 * h, 0.0);
            prop_assert!(amax(&(d.gradient_at(&k)[axis] - difference)) < 1e-8 * scale(&d));
        }
    }

    #[test]
    fn long_waves_tend_to_the_long_wave_stiffness(case in case(), angle in 0.0..3.2_f64) {
        let d = matrix(&case);
        if d.rigid_translation() == &Matrix2::zeros() {
            let n = Vector2::new(angle.cos(), angle.sin());
            let limit = d.long_wave_stiffness().acoustic_tensor(&n).map(|x| Complex::new(x, 0.0));
            let (mut error, tolerance) = ([0.0; 2], 3e-3 * scale(&d));
            for (n_th, length) in [0.02, 0.01].into_iter().enumerate() {
                let quotient = d.at(&(n * length)) / Complex::new(length * length, 0.0);
                error[n_th] = amax(&(quotient - limit));
            }
            prop_assert!(error[1] < tolerance, "{:?} at scale {}", error, scale(&d));
            // The next term is of fourth order in k: halving the wave vector reduces the error to a quarter.
            prop_assert!((error[1] - error[0] / 4.0).abs() < 0.02 * error[0] + 1e-9 * scale(&d));
        }
    }

    #[test]
    fn long_waves_of_linearly_complete_lagrangian_kernels_agree_with_the_material(case in lagrangian()) {
        let discretization = KernelMethodChoices { approximation: Approximation::Mls, density: 1.7, ..case.discretization };
        let case = Case { discretization, ..case };
        let response = case.material().response(&case.state).expect("finite");
        let (material, particles) = (Stiffness::<2>::of(&response), matrix(&case).long_wave_stiffness());
        for n in 0..8 {
            let angle = 0.4 * f64::from(n);
            let n = Vector2::new(angle.cos(), angle.sin());
            let (exact, discrete) = (material.acoustic_tensor(&n) / 1.7, particles.acoustic_tensor(&n));
            prop_assert!((exact - discrete).amax() < 1e-11 * exact.amax());
        }
    }

    #[test]
    fn rotating_the_deformed_body_rotates_the_polarizations(
        case in case(), k in wave_vector(), angle in -3.0..3.0_f64,
    ) {
        // On the regular lattice particles do not rotate with the stress. The interpolated background of functions without linear completeness treats
        // a rotation as a strain.
        let KernelMethodChoices { frame, current_lattice: lattice, .. } = case.discretization;
        if frame == Frame::Eulerian && lattice == CurrentLattice::Regular {
            return Ok(());
        }
        let discretization = KernelMethodChoices { background: Background::Imposed, ..case.discretization };
        let case = Case { discretization, ..case };
        let q = rotation(angle);
        let (d, turned) = (matrix(&case), matrix_at(&case, &rotated(&q, &case.state, &Matrix2::identity())));
        let q = q.map(|x| Complex::new(x, 0.0));
        prop_assert!(amax(&(turned.at(&k) - q * d.at(&k) * q.transpose())) < 1e-10 * scale(&d));
    }

    #[test]
    fn rotations_that_map_the_lattice_onto_itself_rotate_waves_with_the_state(
        case in case(), k in wave_vector(), turns in 1..6_i32,
    ) {
        let KernelMethodChoices { frame, current_lattice: lattice, lattice: kind, .. } = case.discretization;
        if frame == Frame::Eulerian && lattice == CurrentLattice::Regular {
            return Ok(());
        }
        let discretization = KernelMethodChoices { background: Background::Imposed, ..case.discretization };
        let case = Case { discretization, ..case };
        let fold = if kind == LatticeKind::Hexagonal { 6.0 } else { 4.0 };
        let r = rotation(std::f64::consts::TAU * f64::from(turns) / fold);
        let (d, turned) = (matrix(&case), matrix_at(&case, &rotated(&Matrix2::identity(), &case.state, &r)));
        prop_assert!(amax(&(turned.at(&(r * k)) - d.at(&k))) < 1e-10 * scale(&d));
    }

    #[test]
    fn waves_of_the_reference_configuration_are_equal_in_both_frames(case in case(), k in wave_vector()) {
        // Without stress the motion of the kernel does no work.
        let rest = DeformationGradient::identity();
        let d = [Frame::Lagrangian, Frame::Eulerian].map(|frame| {
            let discretization = KernelMethodChoices { frame, ..case.discretization.clone() };
            matrix_at(&Case { discretization, ..case.clone() }, &rest)
        });
        prop_assert!(amax(&(d[0].at(&k) - d[1].at(&k))) < 1e-11 * scale(&d[0]));
    }

    #[test]
    fn a_chain_is_the_uniaxial_limit(
        stretch in 0.7..1.5_f64, support in 1.6..3.3_f64, length in 1e-3..2e-3_f64,
    ) {
        let discretization = KernelMethodChoices {
            lattice: LatticeKind::Chain,
            quadrature: Quadrature::StressPoints,
            approximation: Approximation::Mls,
            support,
            ..KernelMethodChoices::default()
        };
        let method = onset::method::Method::<1>::new(discretization).expect("a chain");
        let material = onset::material::ModifiedMooneyRivlin::default();
        let f = DeformationGradient::from_stretches([stretch, 1.0, 1.0]).expect("a state");
        let d = dynamical_matrix(&method, &material, &f).expect("finite");
        let a = onset::material::Hyperelastic::response(&material, &f).expect("finite").tangent[(0, 0, 0, 0)];
        let omega_squared = d.omega_squared(&nalgebra::Vector1::new(length))[0].re;
        prop_assert!((omega_squared / (a * length * length) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_plane_state_is_determined_by_its_leading_block_and_its_remaining_diagonal(f in planar_state()) {
        prop_assert!(f.is_block_diagonal::<2>());
        prop_assert_eq!(f.with_leading::<2>(&f.leading::<2>()), f);
    }
}

#[test]
fn stress_points_that_move_with_the_plane_wave_make_the_matrix_non_periodic() {
    let discretization = KernelMethodChoices {
        frame: Frame::Eulerian,
        linearization: onset::method::Linearization::Paper,
        ..KernelMethodChoices::default()
    };
    let method = onset::method::Method::<2>::new(discretization).expect("a method");
    assert!(!method.is_periodic());
    let f = DeformationGradient::from_stretches([1.1, 0.95, 1.0]).expect("a state");
    let material = onset::material::ModifiedMooneyRivlin::default();
    let d = dynamical_matrix(&method, &material, &f).expect("finite");
    let k = Vector2::new(1.0, 0.4);
    let g = method.lattice().reciprocal().column(0).into_owned();
    assert!(amax(&(d.at(&(k + g)) - d.at(&k))) > 1e-3);
}
