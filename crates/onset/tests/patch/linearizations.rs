//! Incomplete linearizations, compared with forces with the same omission: equation (49).

use crate::brute::{Patch, assert_agrees, state};
use crate::law::Law;
use nalgebra::Vector2;
use onset::approximation::Approximation;
use onset::lattice::LatticeKind;
use onset::method::{CurrentLattice, Frame, KernelMethodChoices, Linearization};
use onset::quadrature::Quadrature;

const SHEARED: [[f64; 2]; 2] = [[1.05, 0.25], [-0.1, 0.92]];

fn choices(linearization: Linearization, quadrature: Quadrature) -> KernelMethodChoices {
    KernelMethodChoices {
        lattice: LatticeKind::Hexagonal,
        quadrature,
        support: 1.6,
        frame: Frame::Eulerian,
        linearization,
        ..KernelMethodChoices::default()
    }
}

#[test]
fn equation_49_with_nodal_quadrature_is_the_papers_linearization() {
    for approximation in [
        Approximation::Raw,
        Approximation::Shepard,
        Approximation::Mls,
    ] {
        for lattice in [CurrentLattice::Convected, CurrentLattice::Regular] {
            let choices = KernelMethodChoices {
                approximation,
                current_lattice: lattice,
                ..choices(Linearization::Paper, Quadrature::Nodal)
            };
            assert_agrees::<2>(choices, Law::MooneyRivlin, &state(SHEARED, 1.0));
        }
    }
}

#[test]
fn equation_49_agrees_with_interpolated_stress_points() {
    for approximation in [Approximation::Shepard, Approximation::Mls] {
        for quadrature in [Quadrature::StressPoints, Quadrature::StressPointsOnly] {
            for kind in [LatticeKind::Hexagonal, LatticeKind::Square] {
                let choices = KernelMethodChoices {
                    approximation,
                    lattice: kind,
                    ..choices(Linearization::PaperInterpolated, quadrature)
                };
                assert_agrees::<2>(choices, Law::MooneyRivlin, &state(SHEARED, 1.0));
            }
        }
    }
}

#[test]
fn stress_points_that_move_with_the_wave_agree_beyond_the_zone() {
    let f = state(SHEARED, 1.0);
    for linearization in [
        Linearization::Paper,
        Linearization::ExactPlaneWave,
        Linearization::FrozenNormalization,
    ] {
        for approximation in [Approximation::Shepard, Approximation::Mls] {
            let choices = KernelMethodChoices {
                approximation,
                ..choices(linearization, Quadrature::StressPoints)
            };
            let patch = Patch::<2>::new(choices.clone(), Law::MooneyRivlin, &f);
            let all = patch.commensurate();
            // The second wave vector lies beyond the first zone: it differs from the first by a sum of reciprocal vectors.
            let waves = [
                all[1],
                all[1] + (all[1] + all[6]) * 6.0,
                all[8],
                all[15],
                all[21],
            ];
            let deviation = patch.deviation_of_waves(&f, &waves);
            assert!(
                deviation < 2e-9,
                "relative deviation {deviation:e} for {choices:?}"
            );
            let (first, second) = (
                patch.dynamical_matrix(&f, &waves[0]),
                patch.dynamical_matrix(&f, &waves[1]),
            );
            let shift = (first - second).map(|entry| entry.norm()).amax();
            assert!(
                shift > 1e-3,
                "waves on stress points make the matrix non-periodic"
            );
        }
    }
}

#[test]
fn equation_49_is_not_the_exact_derivative() {
    // If they agreed, the tests above could not distinguish the linearizations.
    let f = state(SHEARED, 1.0);
    let exact = Patch::<2>::new(
        choices(Linearization::Exact, Quadrature::Nodal),
        Law::MooneyRivlin,
        &f,
    );
    let paper = Patch::<2>::new(
        choices(Linearization::Paper, Quadrature::Nodal),
        Law::MooneyRivlin,
        &f,
    );
    let k = Vector2::new(2.0, 1.1);
    let difference = exact.dynamical_matrix(&f, &k) - paper.dynamical_matrix(&f, &k);
    assert!(difference.map(|entry| entry.norm()).amax() > 1e-2);
}

#[test]
fn quadrature_without_an_inversion_center_agrees_in_both_frames() {
    // Only without an inversion center is the dynamical matrix complex.
    let f = state(SHEARED, 1.0);
    for frame in [Frame::Lagrangian, Frame::Eulerian] {
        for linearization in [Linearization::Exact, Linearization::PaperInterpolated] {
            let choices = KernelMethodChoices {
                frame,
                ..choices(linearization, Quadrature::StressPointsOnly)
            };
            let patch = Patch::<2>::with_triangles(choices.clone(), Law::MooneyRivlin, &f, true);
            let deviation = patch.deviation(&f);
            assert!(
                deviation < 2e-9,
                "relative deviation {deviation:e} for {choices:?}"
            );
            let imaginary = patch
                .dynamical_matrix(&f, &Vector2::new(2.0, 1.1))
                .map(|entry| entry.im);
            assert!(imaginary.amax() > 1e-2);
        }
    }
}
