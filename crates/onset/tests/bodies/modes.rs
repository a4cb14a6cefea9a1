//! Lowest modes of bodies in actual states, compared with numerical derivatives of their forces, and with known frequencies and buckling loads.

use super::random::Random;
use super::updated::{all_choices, disordered};
use super::{at_rest, choices, law, method, with};
use nalgebra::{DMatrix, SVector};
use onset::analysis::actual_modes;
use onset::kinematics::DeformationGradient;
use onset::lattice::LatticeKind;
use onset::material::{Hyperelastic, Law};
use onset::method::KernelMethodChoices;
use onset::motion::{ActualBody, ActualModes, BodyError, BodyParticles, PlacedParticle};
use onset::scheme::element::{ElementChoices, ElementMesh};
use onset::scheme::stabilization::PenaltyForm;
use onset::scheme::{MethodChoices, PeridynamicsChoices};
use std::f64::consts::PI;

const DIFFERENCE: f64 = 1e-5;

fn square() -> Box<KernelMethodChoices> {
    Box::new(KernelMethodChoices {
        lattice: LatticeKind::Square,
        ..KernelMethodChoices::default()
    })
}

fn grid(columns: usize, rows: usize) -> Vec<PlacedParticle> {
    let at = |n: usize| PlacedParticle {
        position: [(n % columns) as f64, (n / columns) as f64, 0.0],
        volume: 1.0,
    };
    (0..columns * rows).map(at).collect()
}

/// Quadrilaterals between the nodes of a grid, in the order of VTK.
fn quadrilaterals(columns: usize, rows: usize) -> Vec<Vec<usize>> {
    let corner = |n: usize| n % (columns - 1) + n / (columns - 1) * columns;
    let element = |n: usize| {
        let a = corner(n);
        vec![a, a + 1, a + columns + 1, a + columns]
    };
    (0..(columns - 1) * (rows - 1)).map(element).collect()
}

/// Real parts of the eigenvalues of the free components of a matrix, ascending.
fn eigenvalues(columns: &[Vec<f64>], free: &[bool]) -> Vec<f64> {
    let own: Vec<usize> = (0..free.len()).filter(|n| free[*n]).collect();
    let matrix = DMatrix::from_fn(own.len(), own.len(), |i, j| columns[own[j]][own[i]]);
    let values = matrix.complex_eigenvalues();
    let mut values: Vec<f64> = values.iter().map(|value| value.re).collect();
    values.sort_by(f64::total_cmp);
    values
}

fn assert_lowest(found: &ActualModes, expected: &[f64], tolerance: f64) {
    for (mode, expected) in found.modes.iter().zip(expected) {
        let own = mode.squared.re;
        let apart = (own - expected).abs() / found.scale;
        assert!(apart < tolerance, "{own} {expected} of {}", found.scale);
    }
}

#[test]
fn modes_of_a_distorted_body_follow_from_its_forces() {
    for form in [PenaltyForm::Published, PenaltyForm::Smd] {
        let choices = choices(2.01, 0.2, form);
        let particles = grid(7, 5);
        let held: Vec<bool> = (0..35).map(|n| n % 7 == 0).collect();
        let mut random = Random::new(3);
        let mut moved = |x: f64| 1.1 * x + 0.08 * random.number();
        let x: Vec<[f64; 3]> = particles
            .iter()
            .map(|own| [moved(own.position[0]), moved(own.position[1]), 0.0])
            .collect();
        let u = |n: usize| x[n / 2][n % 2] - particles[n / 2].position[n % 2];
        let u: Vec<f64> = (0..70).map(u).collect();
        let given = BodyParticles::Given(particles.clone());
        let columns = with(
            &*method(LatticeKind::Square, &choices),
            &given,
            &[],
            |body| {
                let mut at = |n: usize, size: f64| {
                    let mut u = u.clone();
                    u[n] += size;
                    body.put(&at_rest(u), &DeformationGradient::identity());
                    body.accelerations().expect("forces")
                };
                let column = |n: usize| -> Vec<f64> {
                    let [more, less] = [DIFFERENCE, -DIFFERENCE].map(|size| at(n, size));
                    let both = more.iter().zip(less);
                    both.map(|(a, b)| (b - a) / (2.0 * DIFFERENCE)).collect()
                };
                (0..70).map(column).collect::<Vec<_>>()
            },
        );
        let free: Vec<bool> = (0..70).map(|n| !held[n / 2]).collect();
        let expected = eigenvalues(&columns.expect("a body"), &free);
        let body = ActualBody {
            particles: &particles,
            positions: &x,
            deformations: &[],
            elements: &[],
            held: &held,
        };
        let sph = MethodChoices::TotalLagrangianSph(square(), choices);
        let found = actual_modes(&sph, &*law(), &body, 6).expect("modes");
        assert_eq!((found.unknowns, found.rigid), (60, 0));
        assert!(!found.is_symmetric);
        assert_lowest(&found, &expected, 1e-7);
    }
}

#[test]
fn tangents_of_moving_kernels_equal_sums_over_all_pairs() {
    for choices in all_choices(2.3) {
        if choices.velocity_smoothing != 0.0 {
            continue;
        }
        let (given, mut sums) = disordered::<2>(&choices, 25);
        let BodyParticles::Given(particles) = given else {
            unreachable!("particles are given")
        };
        // A weak disorder, in which most eigenvalues are real.
        for (x, own) in sums.x.iter_mut().zip(&particles) {
            *x = 0.2 * *x + 0.8 * SVector::from_fn(|i, _| own.position[i]);
        }
        for f in &mut sums.f {
            *f = 0.3 * *f + 0.7 * nalgebra::SMatrix::identity();
        }
        sums.v.iter_mut().for_each(|v| *v *= 0.0);
        let (places, states) = (sums.x.clone(), sums.f.clone());
        let mut at = |n: usize, size: f64| {
            (sums.x, sums.f) = (places.clone(), states.clone());
            let mut along = vec![SVector::<f64, 2>::zeros(); places.len()];
            along[n / 2][n % 2] = size;
            let gradients: Vec<_> = (0..places.len())
                .map(|i| sums.gradient_of(i, &along))
                .collect();
            for (f, l) in sums.f.iter_mut().zip(gradients) {
                *f += l * *f;
            }
            sums.x[n / 2][n % 2] += size;
            sums.accelerations()
        };
        let column = |n: usize| -> Vec<f64> {
            let [more, less] = [DIFFERENCE, -DIFFERENCE].map(|size| at(n, size));
            let both = more.iter().zip(less);
            both.map(|(a, b)| (b - a) / (2.0 * DIFFERENCE)).collect()
        };
        let columns: Vec<Vec<f64>> = (0..50).map(column).collect();
        let held: Vec<bool> = (0..25).map(|n| n % 5 == 0).collect();
        let free: Vec<bool> = (0..50).map(|n| !held[n / 2]).collect();
        let expected = eigenvalues(&columns, &free);
        let positions: Vec<[f64; 3]> = places.iter().map(|x| [x[0], x[1], 0.0]).collect();
        let deformation = |f: &nalgebra::SMatrix<f64, 2, 2>| {
            let f = [[f[(0, 0)], f[(0, 1)], 0.0], [f[(1, 0)], f[(1, 1)], 0.0]];
            DeformationGradient::new([f[0], f[1], [0.0, 0.0, 1.0]]).ok()
        };
        let deformations: Vec<_> = states.iter().map(deformation).collect();
        let body = ActualBody {
            particles: &particles,
            positions: &positions,
            deformations: &deformations,
            elements: &[],
            held: &held,
        };
        let sph = MethodChoices::UpdatedSph(square(), choices.clone());
        let found = actual_modes(&sph, &*law(), &body, 6).expect("modes");
        let lowest = found.modes[0].squared.re;
        let apart = (lowest - expected[0]).abs() / found.scale;
        assert!(apart < 1e-6, "{lowest} {}: {choices:?}", expected[0]);
        for mode in &found.modes {
            let own = mode.squared.re;
            let apart = expected.iter().map(|value| (own - value).abs());
            let apart = apart.fold(f64::INFINITY, f64::min) / found.scale;
            assert!(apart < 1e-6, "{own}: {choices:?}");
        }
    }
}

fn elastic(poisson: f64) -> Box<dyn Hyperelastic> {
    let law = Law::named("saint-venant-kirchhoff").expect("a law");
    let (lambda, mu) = (
        poisson / (1.0 + poisson) / (1.0 - 2.0 * poisson),
        0.5 / (1.0 + poisson),
    );
    law.build(&[("lambda", lambda), ("mu", mu)])
        .expect("a material")
}

fn elements(mesh: ElementMesh) -> MethodChoices {
    MethodChoices::FiniteElements(ElementChoices {
        mesh,
        ..ElementChoices::default()
    })
}

#[test]
fn a_chain_of_bars_has_its_known_frequencies() {
    let count = 300;
    let particles = grid(count + 1, 1);
    let positions: Vec<[f64; 3]> = particles.iter().map(|own| own.position).collect();
    let chain: Vec<Vec<usize>> = (0..count).map(|n| vec![n, n + 1]).collect();
    let held: Vec<bool> = (0..=count).map(|n| n == 0 || n == count).collect();
    let mut body = ActualBody {
        particles: &particles,
        positions: &positions,
        deformations: &[],
        elements: &chain,
        held: &held,
    };
    let bars = elements(ElementMesh::Bars);
    let found = actual_modes(&bars, &*elastic(0.0), &body, 6).expect("modes");
    assert!(found.is_symmetric);
    for (n, mode) in found.modes.iter().enumerate() {
        let expected = (2.0 * ((n + 1) as f64 * PI / (2.0 * count as f64)).sin()).powi(2);
        let own = mode.squared.re;
        assert!((own / expected - 1.0).abs() < 1e-6, "{own} {expected}");
        assert_eq!(mode.growth(), 0.0);
    }
    // A free chain has one rigid motion.
    let free = vec![false; count + 1];
    body.held = &free;
    let found = actual_modes(&bars, &*elastic(0.0), &body, 2).expect("modes");
    assert_eq!(found.rigid, 1);
    let expected = (2.0 * (PI / (2.0 * (count + 1) as f64)).sin()).powi(2);
    // The tolerance allows for the half masses at the ends.
    assert!((found.modes[0].squared.re / expected - 1.0).abs() < 0.02);
}

#[test]
fn a_clamped_plate_buckles_at_the_load_of_euler() {
    let (columns, rows) = (61, 4);
    let particles = grid(columns, rows);
    let mesh = quadrilaterals(columns, rows);
    let held: Vec<bool> = (0..columns * rows)
        .map(|n| n % columns == 0 || n % columns == columns - 1)
        .collect();
    let lowest = |strain: f64| {
        let positions = particles.iter().map(|own| {
            let [x, y, _] = own.position;
            [(1.0 - strain) * x, y, 0.0]
        });
        let positions: Vec<[f64; 3]> = positions.collect();
        let body = ActualBody {
            particles: &particles,
            positions: &positions,
            deformations: &[],
            elements: &mesh,
            held: &held,
        };
        let quadrilaterals = elements(ElementMesh::Quadrilaterals);
        let found = actual_modes(&quadrilaterals, &*elastic(0.0), &body, 2).expect("modes");
        assert_eq!(found.rigid, 0);
        found.modes[0].squared.re
    };
    // Critical strain of a bar with clamped ends: 4 pi^2 E I / L^2 divided by E A.
    let euler = (PI * 3.0 / 60.0).powi(2) / 3.0;
    assert!(lowest(0.0) > 0.0);
    assert!(lowest(0.8 * euler) > 0.0);
    assert!(lowest(1.3 * euler) < 0.0);
}

#[test]
fn rigid_motions_of_free_bodies_are_excluded() {
    let particles = grid(9, 6);
    let held = vec![false; particles.len()];
    let (sine, cosine) = 0.7_f64.sin_cos();
    let turned = particles.iter().map(|own| {
        let [x, y, _] = own.position;
        [cosine * x - sine * y + 3.0, sine * x + cosine * y, 0.0]
    });
    let turned: Vec<[f64; 3]> = turned.collect();
    let body = ActualBody {
        particles: &particles,
        positions: &turned,
        deformations: &[],
        elements: &[],
        held: &held,
    };
    let methods = [
        MethodChoices::TotalLagrangianSph(square(), choices(2.01, 0.2, PenaltyForm::Smd)),
        MethodChoices::Peridynamics(square(), PeridynamicsChoices::default()),
    ];
    for method in methods {
        let found = actual_modes(&method, &*law(), &body, 4).expect("modes");
        assert_eq!((found.rigid, found.modes.len()), (3, 4));
        let least = found.modes[0].squared.re;
        assert!(least > 1e-4 * found.scale, "{method:?}: {least}");
    }
}

#[test]
fn methods_without_a_tangent_and_undefined_states_are_refused() {
    let particles = grid(5, 4);
    let positions: Vec<[f64; 3]> = particles.iter().map(|own| own.position).collect();
    let held = vec![false; particles.len()];
    let mut body = ActualBody {
        particles: &particles,
        positions: &positions,
        deformations: &[None; 20],
        elements: &[],
        held: &held,
    };
    let of = |method: &MethodChoices, body: &ActualBody<'_>| {
        actual_modes(method, &*law(), body, 3).err()
    };
    let conforming = MethodChoices::Conforming(square(), Default::default());
    assert_eq!(of(&conforming, &body), Some(BodyError::NoTangent));
    let moving = MethodChoices::UpdatedSph(square(), Default::default());
    assert!(matches!(
        of(&moving, &body),
        Some(BodyError::NoStress { particle: 0, .. })
    ));
    let mesh = quadrilaterals(5, 4);
    body.elements = &mesh;
    assert!(matches!(
        of(&elements(ElementMesh::Triangles), &body),
        Some(BodyError::OtherElement {
            nodes: 4,
            needed: 3,
            ..
        })
    ));
    // The first element is turned inside out.
    let mut folded = positions.clone();
    folded[0] = [2.5, 2.5, 0.0];
    body.positions = &folded;
    assert!(matches!(
        of(&elements(ElementMesh::Quadrilaterals), &body),
        Some(BodyError::NoStress { .. })
    ));
}
