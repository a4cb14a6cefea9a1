//! Kernels in current coordinates, linearized exactly: particles, stress points and normalization move.

use crate::brute::{Patch, assert_agrees, state};
use crate::law::Law;
use nalgebra::{Complex, DMatrix};
use onset::approximation::Approximation;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::method::{
    Background, CurrentLattice, Frame, KernelMethodChoices, Linearization, SupportSize,
};
use onset::quadrature::Quadrature;

const DIAGONAL: [[f64; 2]; 2] = [[1.15, 0.0], [0.0, 0.9]];
const SHEARED: [[f64; 2]; 2] = [[1.05, 0.25], [-0.1, 0.92]];

fn eulerian(kind: LatticeKind, quadrature: Quadrature) -> KernelMethodChoices {
    KernelMethodChoices {
        lattice: kind,
        quadrature,
        // No distance in the states of this file is at the rim of the support, where the derivative of the forces has a kink that differences would
        // smear.
        support: if kind == LatticeKind::Square {
            1.9
        } else {
            1.6
        },
        frame: Frame::Eulerian,
        linearization: Linearization::Exact,
        ..KernelMethodChoices::default()
    }
}

#[test]
fn forces_of_the_patch_agree_with_the_dynamical_matrix() {
    for kind in [LatticeKind::Square, LatticeKind::Hexagonal] {
        for quadrature in [
            Quadrature::Nodal,
            Quadrature::StressPoints,
            Quadrature::StressPointsOnly,
        ] {
            let choices = eulerian(kind, quadrature);
            assert_agrees::<2>(choices.clone(), Law::MooneyRivlin, &state(DIAGONAL, 1.0));
            assert_agrees::<2>(choices, Law::BlatzKo, &state(SHEARED, 1.1));
        }
    }
}

#[test]
fn every_correction_of_the_weights_agrees_with_the_patch() {
    for approximation in [
        Approximation::Raw,
        Approximation::Shepard,
        Approximation::Mls,
    ] {
        for quadrature in [Quadrature::Nodal, Quadrature::StressPoints] {
            let choices = KernelMethodChoices {
                approximation,
                ..eulerian(LatticeKind::Hexagonal, quadrature)
            };
            assert_agrees::<2>(choices, Law::MooneyRivlin, &state(SHEARED, 1.0));
        }
    }
}

#[test]
fn every_support_and_every_current_lattice_agrees_with_the_patch() {
    for lattice in [CurrentLattice::Convected, CurrentLattice::Regular] {
        for support_size in [
            SupportSize::Fixed,
            SupportSize::Scaled,
            SupportSize::Convected,
        ] {
            for (kind, approximation) in [
                (LatticeKind::Hexagonal, Approximation::Shepard),
                (LatticeKind::Square, Approximation::Raw),
            ] {
                let choices = KernelMethodChoices {
                    current_lattice: lattice,
                    support_size,
                    approximation,
                    ..eulerian(kind, Quadrature::StressPoints)
                };
                assert_agrees::<2>(choices, Law::MooneyRivlin, &state(SHEARED, 1.0));
            }
        }
    }
}

#[test]
fn the_interpolated_background_agrees_with_the_patch() {
    for lattice in [CurrentLattice::Convected, CurrentLattice::Regular] {
        for (approximation, law) in [
            (Approximation::Shepard, Law::MooneyRivlin),
            (Approximation::Raw, Law::BlatzKo),
        ] {
            for quadrature in [Quadrature::Nodal, Quadrature::StressPoints] {
                let choices = KernelMethodChoices {
                    current_lattice: lattice,
                    approximation,
                    background: Background::Interpolated,
                    ..eulerian(LatticeKind::Hexagonal, quadrature)
                };
                assert_agrees::<2>(choices, law, &state(SHEARED, 1.0));
            }
        }
    }
}

#[test]
fn waves_of_a_chain_agree_with_the_patch() {
    for quadrature in [
        Quadrature::Nodal,
        Quadrature::StressPoints,
        Quadrature::StressPointsOnly,
    ] {
        for (approximation, lattice, support_size) in [
            (
                Approximation::Raw,
                CurrentLattice::Convected,
                SupportSize::Fixed,
            ),
            (
                Approximation::Shepard,
                CurrentLattice::Convected,
                SupportSize::Fixed,
            ),
            (
                Approximation::Shepard,
                CurrentLattice::Regular,
                SupportSize::Scaled,
            ),
            (
                Approximation::Mls,
                CurrentLattice::Convected,
                SupportSize::Convected,
            ),
        ] {
            let choices = KernelMethodChoices {
                support: 2.3,
                approximation,
                current_lattice: lattice,
                support_size,
                background: Background::Interpolated,
                ..eulerian(LatticeKind::Chain, quadrature)
            };
            let f = DeformationGradient::from_stretches([1.2, 0.9, 1.1]).expect("a state");
            assert_agrees::<1>(choices, Law::MooneyRivlin, &f);
        }
    }
}

/// Power sums determine whether two sets of complex numbers are equal, without ordering them.
#[test]
fn power_sums_of_the_spectrum_agree_with_the_commensurate_waves() {
    let f = state(SHEARED, 1.0);
    let choices = eulerian(LatticeKind::Hexagonal, Quadrature::StressPoints);
    let patch = Patch::<2>::new(choices, Law::MooneyRivlin, &f);
    let stiffness = patch.stiffness();
    let asymmetry = (&stiffness - stiffness.transpose()).amax() / stiffness.amax();
    assert!(
        asymmetry > 1e-4,
        "the rate form has no potential, but the asymmetry is {asymmetry:e}"
    );
    let mut power = DMatrix::<f64>::identity(stiffness.nrows(), stiffness.ncols());
    let waves: Vec<_> = patch
        .commensurate()
        .iter()
        .map(|k| patch.dynamical_matrix(&f, k))
        .collect();
    let mut powers = vec![nalgebra::Matrix2::<Complex<f64>>::identity(); waves.len()];
    for exponent in 1..=6 {
        power *= &stiffness;
        powers
            .iter_mut()
            .zip(&waves)
            .for_each(|(power, d)| *power *= d);
        let expected: Complex<f64> = powers.iter().map(|power| power.trace()).sum();
        let error = (power.trace() - expected).norm() / expected.norm();
        assert!(error < 1e-8, "power {exponent}: relative error {error:e}");
    }
}

#[test]
fn every_order_and_every_corrected_derivative_agrees_with_the_patch() {
    for approximation in [
        Approximation::Mls2,
        Approximation::Mls3,
        Approximation::RandlesLibersky,
        Approximation::KrongauzBelytschko,
    ] {
        for quadrature in [Quadrature::Nodal, Quadrature::StressPoints] {
            let choices = KernelMethodChoices {
                approximation,
                support: if approximation == Approximation::Mls3 {
                    2.6
                } else {
                    2.2
                },
                ..eulerian(LatticeKind::Hexagonal, quadrature)
            };
            assert_agrees::<2>(choices, Law::MooneyRivlin, &state(SHEARED, 1.0));
        }
    }
}

#[test]
fn gauss_points_weights_and_user_defined_points_agree_with_the_patch() {
    let base = |quadrature| KernelMethodChoices {
        approximation: Approximation::KrongauzBelytschko,
        ..eulerian(LatticeKind::Square, quadrature)
    };
    let weighted = KernelMethodChoices {
        stress_point_weight: Some(0.8),
        ..base(Quadrature::StressPoints)
    };
    let points = KernelMethodChoices {
        points: vec![0.0, 0.0, 0.25, 0.3, 0.55, 0.75],
        ..base(Quadrature::Points)
    };
    for choices in [base(Quadrature::Gauss), weighted, points] {
        assert_agrees::<2>(choices, Law::BlatzKo, &state(SHEARED, 1.1));
    }
}

#[test]
fn corrected_derivatives_agree_when_only_the_point_moves() {
    for approximation in [
        Approximation::RandlesLibersky,
        Approximation::KrongauzBelytschko,
    ] {
        let choices = KernelMethodChoices {
            approximation,
            linearization: Linearization::PaperInterpolated,
            ..eulerian(LatticeKind::Hexagonal, Quadrature::StressPoints)
        };
        assert_agrees::<2>(choices, Law::MooneyRivlin, &state(SHEARED, 1.0));
    }
}
