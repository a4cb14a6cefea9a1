//! Random methods, states and waves for `proptest`, reproducible in every run.

use nalgebra::Vector2;
use onset::approximation::Approximation;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin};
use onset::method::{
    Background, CurrentLattice, Frame, KernelMethodChoices, Linearization, Method, SupportSize,
};
use onset::quadrature::Quadrature;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

pub fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(11),
        ..ProptestConfig::default()
    }
}

/// All inputs of a dynamical matrix in the plane.
#[derive(Clone, Debug)]
pub struct Case {
    pub discretization: KernelMethodChoices,
    pub is_blatz_ko: bool,
    pub state: DeformationGradient,
}

impl Case {
    pub fn method(&self) -> Method<2> {
        Method::new(self.discretization.clone()).expect("an admissible method")
    }

    pub fn material(&self) -> Box<dyn Hyperelastic> {
        if self.is_blatz_ko {
            Box::new(BlatzKo::new(1.0).expect("a positive modulus"))
        } else {
            Box::new(ModifiedMooneyRivlin::default())
        }
    }
}

/// Moderately deformed state in plane strain.
pub fn planar_state() -> impl Strategy<Value = DeformationGradient> {
    (0.75..1.4_f64, 0.75..1.4_f64, -0.3..0.3_f64, -3.2..3.2_f64).prop_map(
        |(l1, l2, shear, angle)| {
            let (s, c) = angle.sin_cos();
            let stretched = [[l1, shear], [0.0, l2]];
            let f = std::array::from_fn(|i| {
                let rotation = [[c, -s], [s, c]][i];
                std::array::from_fn(|j| {
                    rotation[0] * stretched[0][j] + rotation[1] * stretched[1][j]
                })
            });
            DeformationGradient::plane_strain(f, 1.0).expect("a positive volume ratio")
        },
    )
}

pub fn wave_vector() -> impl Strategy<Value = Vector2<f64>> {
    (-7.0..7.0_f64, -7.0..7.0_f64).prop_map(|(x, y)| Vector2::new(x, y))
}

fn frame() -> impl Strategy<Value = (Frame, CurrentLattice, SupportSize, Linearization)> {
    use Linearization::{Exact, ExactPlaneWave, FrozenNormalization, Paper, PaperInterpolated};
    (
        prop::sample::select(vec![Frame::Lagrangian, Frame::Eulerian, Frame::Eulerian]),
        prop::sample::select(vec![CurrentLattice::Convected, CurrentLattice::Regular]),
        prop::sample::select(vec![
            SupportSize::Fixed,
            SupportSize::Scaled,
            SupportSize::Convected,
        ]),
        prop::sample::select(vec![
            Exact,
            Paper,
            ExactPlaneWave,
            PaperInterpolated,
            FrozenNormalization,
        ]),
    )
}

pub fn case() -> impl Strategy<Value = Case> {
    (
        prop::sample::select(vec![LatticeKind::Square, LatticeKind::Hexagonal]),
        prop::sample::select(vec![
            Quadrature::Nodal,
            Quadrature::StressPoints,
            Quadrature::StressPointsOnly,
        ]),
        prop::sample::select(vec![
            Approximation::Raw,
            Approximation::Shepard,
            Approximation::Mls,
        ]),
        prop::sample::select(vec![Background::Imposed, Background::Interpolated]),
        frame(),
        1.7..2.4_f64,
        any::<bool>(),
        planar_state(),
    )
        .prop_map(
            |(kind, quadrature, approximation, background, frame, support, is_blatz_ko, state)| {
                let (frame, lattice, support_size, linearization) = frame;
                let discretization = KernelMethodChoices {
                    lattice: kind,
                    quadrature,
                    approximation,
                    background,
                    frame,
                    current_lattice: lattice,
                    support_size,
                    linearization,
                    support,
                    ..KernelMethodChoices::default()
                };
                Case {
                    discretization,
                    is_blatz_ko,
                    state,
                }
            },
        )
}

pub fn lagrangian() -> impl Strategy<Value = Case> {
    case().prop_map(|case| Case {
        discretization: KernelMethodChoices {
            frame: Frame::Lagrangian,
            ..case.discretization
        },
        ..case
    })
}
