//! Kernels in material coordinates.

use crate::brute::{Patch, assert_agrees, state};
use crate::law::Law;
use onset::algebra::eigenvalues;
use onset::approximation::Approximation;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::method::{Background, Frame, KernelMethodChoices};
use onset::quadrature::Quadrature;

const DIAGONAL: [[f64; 2]; 2] = [[1.2, 0.0], [0.0, 0.9]];
const SHEARED: [[f64; 2]; 2] = [[1.1, 0.35], [-0.2, 0.85]];

fn lagrangian(
    kind: LatticeKind,
    quadrature: Quadrature,
    approximation: Approximation,
    background: Background,
) -> KernelMethodChoices {
    let support = if kind == LatticeKind::Square {
        1.9
    } else {
        1.6
    };
    KernelMethodChoices {
        lattice: kind,
        quadrature,
        approximation,
        background,
        support,
        frame: Frame::Lagrangian,
        ..KernelMethodChoices::default()
    }
}

#[test]
fn forces_of_the_patch_agree_with_the_dynamical_matrix() {
    use Approximation::{Mls, Raw, Shepard};
    for kind in [LatticeKind::Square, LatticeKind::Hexagonal] {
        for quadrature in [
            Quadrature::Nodal,
            Quadrature::StressPoints,
            Quadrature::StressPointsOnly,
        ] {
            for (approximation, background, law, f) in [
                (Shepard, Background::Imposed, Law::MooneyRivlin, DIAGONAL),
                (
                    Shepard,
                    Background::Interpolated,
                    Law::MooneyRivlin,
                    SHEARED,
                ),
                (Mls, Background::Imposed, Law::BlatzKo, SHEARED),
                (Raw, Background::Interpolated, Law::BlatzKo, DIAGONAL),
            ] {
                let choices = lagrangian(kind, quadrature, approximation, background);
                assert_agrees::<2>(choices, law, &state(f, 1.0));
            }
        }
    }
}

#[test]
fn out_of_plane_stretches_and_units_of_length_and_mass_are_respected() {
    let choices = KernelMethodChoices {
        spacing: 0.013,
        density: 1130.0,
        ..lagrangian(
            LatticeKind::Hexagonal,
            Quadrature::StressPoints,
            Approximation::Shepard,
            Background::Imposed,
        )
    };
    assert_agrees::<2>(choices, Law::BlatzKo, &state(SHEARED, 1.3));
}

#[test]
fn waves_of_a_chain_agree_with_the_patch() {
    for quadrature in [
        Quadrature::Nodal,
        Quadrature::StressPoints,
        Quadrature::StressPointsOnly,
    ] {
        for approximation in [
            Approximation::Raw,
            Approximation::Shepard,
            Approximation::Mls,
        ] {
            let choices = KernelMethodChoices {
                support: 2.3,
                ..lagrangian(
                    LatticeKind::Chain,
                    quadrature,
                    approximation,
                    Background::Interpolated,
                )
            };
            let f = DeformationGradient::from_stretches([1.3, 0.9, 1.1]).expect("a state");
            assert_agrees::<1>(choices, Law::MooneyRivlin, &f);
        }
    }
}

#[test]
fn the_spectrum_of_the_patch_is_the_union_over_the_commensurate_waves() {
    let f = state(SHEARED, 1.0);
    let choices = lagrangian(
        LatticeKind::Hexagonal,
        Quadrature::StressPoints,
        Approximation::Shepard,
        Background::Imposed,
    );
    let patch = Patch::<2>::new(choices, Law::MooneyRivlin, &f);
    let stiffness = patch.stiffness();
    let symmetric = (&stiffness + stiffness.transpose()) * 0.5;
    assert!(
        (&stiffness - &symmetric).amax() < 1e-9 * stiffness.amax(),
        "the forces have a potential"
    );
    let mut of_patch: Vec<f64> = symmetric.symmetric_eigenvalues().iter().copied().collect();
    let mut of_waves: Vec<f64> = patch
        .commensurate()
        .iter()
        .flat_map(|k| eigenvalues(&patch.dynamical_matrix(&f, k), 0.0).map(|value| value.re))
        .collect();
    of_patch.sort_by(f64::total_cmp);
    of_waves.sort_by(f64::total_cmp);
    assert_eq!(of_patch.len(), of_waves.len());
    let largest = of_waves[of_waves.len() - 1];
    for (a, b) in of_patch.iter().zip(&of_waves) {
        assert!((a - b).abs() < 1e-9 * largest, "{a} against {b}");
    }
}

const APPROXIMATIONS: [Approximation; 4] = [
    Approximation::Mls2,
    Approximation::Mls3,
    Approximation::RandlesLibersky,
    Approximation::KrongauzBelytschko,
];

/// Quadratures other than particles and stress points with Voronoi volumes.
fn quadratures(base: &KernelMethodChoices) -> Vec<KernelMethodChoices> {
    let gauss = [1, 2, 3, 4].map(|gauss_points| KernelMethodChoices {
        quadrature: Quadrature::Gauss,
        gauss_points,
        ..base.clone()
    });
    let weighted = KernelMethodChoices {
        quadrature: Quadrature::StressPoints,
        stress_point_weight: Some(0.3),
        ..base.clone()
    };
    let stabilized = KernelMethodChoices {
        quadrature: Quadrature::NodalStabilized,
        ..base.clone()
    };
    let points = KernelMethodChoices {
        quadrature: Quadrature::Points,
        points: match base.lattice {
            LatticeKind::Chain => vec![0.0, 0.4, 0.3, 0.6],
            _ => vec![0.0, 0.0, 0.25, 0.3, 0.55, 0.5, 0.8, 0.1, 0.25],
        },
        ..base.clone()
    };
    gauss
        .into_iter()
        .chain([weighted, stabilized, points])
        .collect()
}

#[test]
fn every_order_and_every_corrected_derivative_agrees_with_the_patch() {
    for approximation in APPROXIMATIONS {
        for quadrature in [Quadrature::Nodal, Quadrature::StressPoints] {
            let base = lagrangian(
                LatticeKind::Hexagonal,
                quadrature,
                approximation,
                Background::Interpolated,
            );
            let choices = KernelMethodChoices {
                support: if approximation == Approximation::Mls3 {
                    2.6
                } else {
                    2.2
                },
                ..base
            };
            assert_agrees::<2>(choices, Law::MooneyRivlin, &state(SHEARED, 1.0));
        }
    }
}

#[test]
fn every_quadrature_agrees_with_the_patch() {
    for (kind, approximation) in [
        (LatticeKind::Hexagonal, Approximation::Shepard),
        (LatticeKind::Square, Approximation::Mls),
        (LatticeKind::Square, Approximation::KrongauzBelytschko),
    ] {
        let base = lagrangian(
            kind,
            Quadrature::Nodal,
            approximation,
            Background::Interpolated,
        );
        for choices in quadratures(&base) {
            assert_agrees::<2>(choices, Law::BlatzKo, &state(SHEARED, 1.1));
        }
    }
    let base = KernelMethodChoices {
        support: 2.3,
        ..lagrangian(
            LatticeKind::Chain,
            Quadrature::Nodal,
            Approximation::Mls2,
            Background::Imposed,
        )
    };
    let f = DeformationGradient::from_stretches([1.3, 0.9, 1.1]).expect("a state");
    for choices in quadratures(&base) {
        assert_agrees::<1>(choices, Law::MooneyRivlin, &f);
    }
}
