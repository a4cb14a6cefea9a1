//! Properties of every method on a three-dimensional lattice.

use crate::{CUBIC, config, deformation, discretization, state, wave_vector};
use nalgebra::{Matrix3, Rotation3, Vector3};
use onset::algebra::Complex;
use onset::approximation::Approximation;
use onset::bloch::dynamical_matrix;
use onset::continuum::Stiffness;
use onset::lattice::LatticeKind;
use onset::material::{Hyperelastic, ModifiedMooneyRivlin};
use onset::method::{Frame, KernelMethodChoices, Method};
use onset::quadrature::Quadrature;
use onset::verdict::assess;
use proptest::prelude::*;

fn any() -> impl Strategy<Value = KernelMethodChoices> {
    (
        prop::sample::select(CUBIC.to_vec()),
        prop::sample::select(vec![Frame::Lagrangian, Frame::Eulerian]),
        prop::sample::select(vec![Quadrature::Nodal, Quadrature::StressPoints]),
    )
        .prop_map(|(kind, frame, quadrature)| discretization(kind, frame, quadrature))
}

/// Lattice described by other primitive vectors.
fn with_vectors(
    discretization: &KernelMethodChoices,
    vectors: &Matrix3<f64>,
) -> KernelMethodChoices {
    KernelMethodChoices {
        lattice: LatticeKind::Triclinic,
        vectors: vectors.iter().copied().collect(),
        ..discretization.clone()
    }
}

proptest! {
    #![proptest_config(config(12))]

    #[test]
    fn results_do_not_depend_on_primitive_vectors_and_rotations(
        choices in any(),
        f in deformation(),
        k in wave_vector(),
        axis in prop::array::uniform3(0.1..2.0_f64),
    ) {
        let law = ModifiedMooneyRivlin::default();
        let method = Method::<3>::new(choices.clone()).expect("a method");
        let d = dynamical_matrix(&method, &law, &state(&f)).expect("finite");
        let basis = Matrix3::new(1.0, 1.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0);
        let turn = *Rotation3::from_scaled_axis(Vector3::from(axis)).matrix();
        let vectors = turn * method.lattice().vectors() * basis;
        let turned = Method::<3>::new(with_vectors(&choices, &vectors)).expect("a method");
        prop_assert_eq!(turned.quadrature_points().len(), method.quadrature_points().len());
        let other = dynamical_matrix(&turned, &law, &state(&(turn * f * turn.transpose()))).expect("finite");
        let complex = turn.map(|x| Complex::new(x, 0.0));
        let expected = complex * d.at(&k) * complex.transpose();
        let largest = expected.iter().map(|x| x.norm()).fold(1e-3, f64::max);
        for (a, b) in expected.iter().zip(other.at(&(turn * k)).iter()) {
            prop_assert!((a - b).norm() < 1e-10 * largest, "{} against {}", a, b);
        }
    }

    #[test]
    fn long_waves_of_linearly_complete_functions_agree_with_the_material(
        kind in prop::sample::select(CUBIC.to_vec()),
        f in deformation(),
        n in wave_vector(),
    ) {
        let law = ModifiedMooneyRivlin::default();
        let choices = discretization(kind, Frame::Lagrangian, Quadrature::Nodal);
        let method = Method::<3>::new(KernelMethodChoices { approximation: Approximation::Mls, ..choices });
        let d = dynamical_matrix(&method.expect("a method"), &law, &state(&f)).expect("finite");
        let material = Stiffness::<3>::of(&law.response(&state(&f)).expect("finite"));
        let (q, expected) = (d.long_wave_stiffness().acoustic_tensor(&n), material.acoustic_tensor(&n));
        prop_assert!((q - expected).amax() < 1e-10 * expected.amax());
    }

    #[test]
    fn lagrangian_kernels_are_stable_exactly_if_the_material_is_elliptic(
        kind in prop::sample::select(CUBIC.to_vec()),
        quadrature in prop::sample::select(vec![Quadrature::Nodal, Quadrature::StressPoints]),
        stretches in prop::array::uniform3(0.5..2.0_f64),
    ) {
        let law = ModifiedMooneyRivlin::default();
        let f = state(&Matrix3::from_diagonal(&Vector3::from(stretches)));
        let choices = discretization(kind, Frame::Lagrangian, quadrature);
        let choices = KernelMethodChoices { approximation: Approximation::Mls, support: 1.7, ..choices };
        let method = Method::<3>::new(choices).expect("a method");
        let d = dynamical_matrix(&method, &law, &f).expect("finite");
        prop_assert!(d.is_centrosymmetric() && d.is_hermitian());
        let assessment = assess(&method, &law, &f).expect("a verdict");
        let minimum = assessment.material.minimum.eigenvalue.re;
        prop_assume!(minimum.abs() > 1e-6);
        prop_assert_eq!(assessment.spectrum.is_stable(), assessment.material.ellipticity.is_elliptic(), "{}", minimum);
    }
}
