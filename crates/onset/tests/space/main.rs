//! Particles in three dimensions: dynamical matrices compared with the forces of displaced particles, and the search over the zone.

mod forces;
mod laws;
mod search;

use nalgebra::{Matrix3, Vector3};
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::method::{Frame, KernelMethodChoices};
use onset::quadrature::Quadrature;
use proptest::prelude::*;
use proptest::test_runner::{Config, FileFailurePersistence};

const CUBIC: [LatticeKind; 3] = [
    LatticeKind::SimpleCubic,
    LatticeKind::BodyCenteredCubic,
    LatticeKind::FaceCenteredCubic,
];

fn config(cases: u32) -> Config {
    Config {
        cases,
        failure_persistence: Some(Box::new(FileFailurePersistence::Off)),
        ..Config::default()
    }
}

fn state(components: &Matrix3<f64>) -> DeformationGradient {
    let rows = std::array::from_fn(|i| std::array::from_fn(|j| components[(i, j)]));
    DeformationGradient::new(rows).expect("a positive determinant")
}

/// Methods on the cubic lattices, with supports whose rim contains no shell of neighbors.
fn discretization(kind: LatticeKind, frame: Frame, quadrature: Quadrature) -> KernelMethodChoices {
    KernelMethodChoices {
        lattice: kind,
        frame,
        quadrature,
        support: 1.65,
        ..KernelMethodChoices::default()
    }
}

fn deformation() -> impl Strategy<Value = Matrix3<f64>> {
    (
        prop::array::uniform3(0.8..1.25_f64),
        prop::array::uniform3(-0.2..0.2_f64),
        prop::array::uniform3(-0.1..0.1_f64),
    )
        .prop_map(|(d, upper, lower)| {
            Matrix3::new(
                d[0], upper[0], upper[1], lower[0], d[1], upper[2], lower[1], lower[2], d[2],
            )
        })
}

fn wave_vector() -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-4.0..4.0_f64).prop_map(Vector3::from)
}
