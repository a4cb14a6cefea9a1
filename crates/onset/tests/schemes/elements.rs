//! Finite elements: the general scheme checks, and results from textbooks.

use crate::battery::{assert_long_waves_are_those_of_the_material, assert_scheme};
use crate::random::Random;
use crate::states::{saint_venant_kirchhoff, sheared, turned};
use nalgebra::{Matrix2, SMatrix, SVector, Vector1, Vector2, Vector3};
use onset::bloch::{WaveSystem, ZoneSearch};
use onset::continuum::Stiffness;
use onset::kinematics::DeformationGradient;
use onset::lattice::{BravaisLattice, Crystal, LatticeKind, Particle, WaveGrids};
use onset::material::{BlatzKo, Hyperelastic, Law};
use onset::method::MethodError;
use onset::scheme::element::{
    ElementChoices, ElementMass, ElementMesh, ElementOrder, ElementShape, FiniteElements,
    Formulation, HourglassScale, Integration, Mesh, MeshError,
};
use onset::scheme::{Discretization, PeriodicPatch};
use onset::verdict::Survey;
use std::f64::consts::{PI, TAU};

const LAMBDA: f64 = 0.7;
const MU: f64 = 1.0;
/// Modulus `lambda + 2 mu`.
const MODULUS: f64 = LAMBDA + 2.0 * MU;
const SPACING: f64 = 0.8;
const DENSITY: f64 = 1.3;

const ONE_POINT: Formulation = Formulation {
    integration: Integration::OnePoint,
    hourglass_stiffness: 0.0,
    hourglass_viscosity: 0.0,
    hourglass_scale: HourglassScale::Gradients,
    mass: ElementMass::Lumped,
};

fn full() -> Formulation {
    Formulation::default()
}

fn consistent() -> Formulation {
    Formulation {
        mass: ElementMass::Consistent,
        ..full()
    }
}

fn mean_dilatation() -> Formulation {
    Formulation {
        integration: Integration::MeanDilatation,
        ..full()
    }
}

fn controlled(hourglass_stiffness: f64) -> Formulation {
    Formulation {
        hourglass_stiffness,
        ..ONE_POINT
    }
}

fn elements<const D: usize>(mesh: ElementMesh, formulation: Formulation) -> FiniteElements<D> {
    FiniteElements::new(&ElementChoices {
        mesh,
        spacing: SPACING,
        density: DENSITY,
        formulation,
        ..ElementChoices::default()
    })
    .expect("elements")
}

fn material() -> Box<dyn Hyperelastic> {
    saint_venant_kirchhoff(LAMBDA, MU)
}

fn at_rest<const D: usize>(scheme: &FiniteElements<D>) -> WaveSystem<D> {
    scheme
        .waves(&*material(), &DeformationGradient::identity())
        .expect("waves")
}

fn maximum_omega_squared<const D: usize>(scheme: &FiniteElements<D>) -> f64 {
    let search = ZoneSearch::of_lattice(*scheme.crystal().lattice(), MODULUS / DENSITY);
    search.summary_of(&at_rest(scheme)).maximum_omega.powi(2)
}

/// Squared frequencies `omega^2` in units of `(lambda + 2 mu) / (rho h^2)`.
fn in_units(omega_squared: f64) -> f64 {
    omega_squared * DENSITY * SPACING * SPACING / MODULUS
}

fn wave<const D: usize>(random: &mut Random) -> SVector<f64, D> {
    SVector::from_fn(|_, _| PI * random.number() / SPACING)
}

/// Checks that every mesh must pass.
fn assert_elements<const D: usize>(mesh: Mesh<D>) {
    let (material, state) = (material(), sheared::<D>());
    // Hourglass modes of a supercell are waves of infinite length with zero stiffness: the long-wave limit is undefined.
    let hides_hourglass =
        mesh.shape() == ElementShape::Multilinear && D > 1 && mesh.crystal().sites().len() > 1;
    let mut formulations = vec![full(), consistent(), ONE_POINT];
    if mesh.shape() == ElementShape::Multilinear {
        formulations.extend([controlled(0.3), mean_dilatation()]);
    }
    for formulation in formulations {
        let scheme = FiniteElements::on(mesh.clone(), DENSITY, formulation).expect("elements");
        assert_scheme(&scheme, &*material, &state);
        if !(hides_hourglass && formulation == ONE_POINT) {
            assert_long_waves_are_those_of_the_material(&scheme, &*material, &state, 1e-9);
        }
    }
}

#[test]
fn elements_of_every_kind_pass_the_scheme_checks_and_reproduce_the_long_wave_limit() {
    for mesh in ElementMesh::ALL {
        match mesh.dimension() {
            1 => assert_elements::<1>(mesh.mesh(SPACING).expect("a mesh")),
            2 => assert_elements::<2>(mesh.mesh(SPACING).expect("a mesh")),
            _ => assert_elements::<3>(mesh.mesh(SPACING).expect("a mesh")),
        }
    }
}

#[test]
fn distorted_elements_pass_the_patch_test_with_and_without_hourglass_control() {
    let bars = ElementMesh::Bars.mesh::<1>(SPACING).expect("a mesh");
    let bars = bars.supercell([3]).expect("a mesh");
    assert_elements(bars.perturbed(0.2, 1).expect("a mesh"));
    for mesh in [
        ElementMesh::Quadrilaterals,
        ElementMesh::Triangles,
        ElementMesh::TrianglesCrossed,
    ] {
        let mesh = mesh.mesh::<2>(SPACING).expect("a mesh");
        let mesh = mesh.supercell([2, 2]).expect("a mesh");
        assert_elements(mesh.perturbed(0.1, 2).expect("a mesh"));
    }
}

#[test]
fn choices_shear_stretch_and_distort_every_mesh() {
    // Images of the unit vectors, and the volume of a cell.
    let oblique = ElementChoices {
        mesh: ElementMesh::TrianglesCrossed,
        spacing: SPACING,
        vectors: vec![1.0, 0.1, 0.4, 1.2],
        ..ElementChoices::default()
    };
    let plain = ElementChoices {
        vectors: Vec::new(),
        ..oblique.clone()
    };
    let volume = |choices: &ElementChoices| {
        let mesh = choices.built_mesh::<2>().expect("a mesh");
        mesh.crystal().lattice().cell_volume()
    };
    let ratio = volume(&oblique) / volume(&plain);
    assert!((ratio - (1.2 - 0.04)).abs() < 1e-12, "{ratio}");
    for order in [ElementOrder::Linear, ElementOrder::Quadratic] {
        for mesh in [
            ElementMesh::Quadrilaterals,
            ElementMesh::TrianglesAlternating,
        ] {
            let choices = ElementChoices {
                mesh,
                order,
                spacing: SPACING,
                vectors: vec![1.0, 0.1, 0.4, 1.2],
                cells: 2,
                perturbation: 0.08,
                seed: 3,
                ..ElementChoices::default()
            };
            let mesh = choices.built_mesh::<2>().expect("a mesh");
            let scheme = FiniteElements::on(mesh, DENSITY, consistent()).expect("elements");
            let (material, state) = (material(), sheared::<2>());
            assert_scheme(&scheme, &*material, &state);
            assert_long_waves_are_those_of_the_material(&scheme, &*material, &state, 1e-9);
        }
    }
    let flat = ElementChoices {
        vectors: vec![1.0, 1.0, 1.0, 1.0],
        ..plain
    };
    assert!(matches!(
        flat.built_mesh::<2>(),
        Err(MethodError::Lattice(_))
    ));
}

#[test]
fn elements_on_any_lattice_pass_the_scheme_checks() {
    let mut random = Random::new(8);
    let vectors = SMatrix::<f64, 3, 3>::identity() + SMatrix::from_fn(|_, _| 0.3 * random.number());
    let lattice = BravaisLattice::new(vectors).expect("a lattice");
    assert_elements(Mesh::parallelepipeds(lattice));
    assert_elements(Mesh::simplices(lattice));
}

/// Mesh rotated about the origin.
fn turned_mesh<const D: usize>(mesh: &Mesh<D>, turn: &SMatrix<f64, D, D>) -> Mesh<D> {
    let crystal = mesh.crystal();
    let lattice = crystal.lattice().mapped(turn).expect("a lattice");
    let crystal = match crystal.sites().len() {
        1 => Crystal::of_lattice(lattice),
        _ => Crystal::new(lattice, crystal.sites().to_vec()).expect("a crystal"),
    };
    Mesh::new(crystal, mesh.shape(), mesh.elements().to_vec()).expect("a mesh")
}

fn assert_turns<const D: usize>(mesh: ElementMesh, formulation: Formulation) {
    let turn = turned::<D>();
    let mesh = mesh.mesh::<D>(SPACING).expect("a mesh");
    let state = sheared::<D>();
    let turned_state = state.with_leading(&(turn * state.leading::<D>() * turn.transpose()));
    // Only the relative motion of the particles counts, not the orientation in space.
    let superposed = state.with_leading(&(turn * state.leading::<D>()));
    let on = |mesh: Mesh<D>| FiniteElements::on(mesh, DENSITY, formulation).expect("elements");
    let (straight, oblique) = (on(mesh.clone()), on(turned_mesh(&mesh, &turn)));
    let waves = |scheme: &FiniteElements<D>, f| scheme.waves(&*material(), f).expect("waves");
    let expected = waves(&straight, &state);
    let mut random = Random::new(4);
    for _ in 0..3 {
        let k = wave::<D>(&mut random);
        let expected = expected.omega_squared(&k);
        for found in [
            waves(&oblique, &turned_state).omega_squared(&(turn * k)),
            waves(&straight, &superposed).omega_squared(&k),
        ] {
            for (a, b) in expected.iter().zip(found) {
                assert!((a - b).norm() < 1e-9 * MODULUS, "{a} turned is {b}");
            }
        }
    }
}

#[test]
fn frequencies_are_invariant_under_rotations_of_the_setup_and_of_the_body() {
    for mesh in [
        ElementMesh::Triangles,
        ElementMesh::TrianglesAlternating,
        ElementMesh::TrianglesCrossed,
        ElementMesh::TrianglesEquilateral,
    ] {
        assert_turns::<2>(mesh, consistent());
    }
    for mesh in [ElementMesh::Tetrahedra, ElementMesh::TetrahedraBodyCentered] {
        assert_turns::<3>(mesh, consistent());
    }
    for formulation in [controlled(0.2), mean_dilatation()] {
        assert_turns::<2>(ElementMesh::Quadrilaterals, formulation);
        assert_turns::<3>(ElementMesh::Bricks, formulation);
    }
}

#[test]
fn the_largest_frequency_of_bars_is_2_or_root_12_times_the_speed_divided_by_the_length() {
    for (formulation, highest) in [(full(), 4.0), (ONE_POINT, 4.0), (consistent(), 12.0)] {
        let bars = elements::<1>(ElementMesh::Bars, formulation);
        let found = in_units(maximum_omega_squared(&bars));
        assert!((found - highest).abs() < 1e-9, "{found}");
        let k = Vector1::new(PI / SPACING);
        let found = in_units(at_rest(&bars).omega_squared(&k)[0].re);
        assert!((found - highest).abs() < 1e-12, "{found}");
    }
}

#[test]
fn one_point_quadrilaterals_have_exactly_two_hourglass_modes() {
    let squares = elements::<2>(ElementMesh::Quadrilaterals, ONE_POINT);
    let waves = at_rest(&squares);
    let corner = waves.omega_squared(&Vector2::repeat(PI / SPACING));
    assert!(
        corner.iter().all(|value| value.norm() < 1e-12),
        "{corner:?}"
    );
    let mut random = Random::new(2);
    for _ in 0..50 {
        let k = wave::<2>(&mut random);
        // The dynamical matrix is the acoustic tensor Q(s) with s = 2/h (sin x cos y, cos x sin y) with half angles.
        let (x, y) = (0.5 * k[0] * SPACING, 0.5 * k[1] * SPACING);
        let s = Vector2::new(x.sin() * y.cos(), x.cos() * y.sin()) * (2.0 / SPACING);
        let found = waves.omega_squared(&k);
        let expected = [MU, MODULUS].map(|modulus| modulus * s.norm_squared() / DENSITY);
        assert!((found[0].re - expected[0]).abs() < 1e-11);
        assert!((found[1].re - expected[1]).abs() < 1e-11);
    }
    assert!((in_units(maximum_omega_squared(&squares)) - 4.0).abs() < 1e-9);
}

#[test]
fn one_point_bricks_have_twelve_hourglass_modes() {
    // The four hourglass modes of a brick alternate along two or three axes.
    let waves = at_rest(&elements::<3>(ElementMesh::Bricks, ONE_POINT));
    let controlled = at_rest(&elements::<3>(ElementMesh::Bricks, controlled(1e-3)));
    let mut nullity = 0;
    for corner in 1..8_usize {
        let k = Vector3::from_fn(|i, _| (corner >> i & 1) as f64 * PI / SPACING);
        let zeros = |waves: &WaveSystem<3>| {
            let values = waves.omega_squared(&k).into_iter();
            values
                .filter(|value| in_units(value.norm()) < 1e-12)
                .count()
        };
        nullity += zeros(&waves);
        assert_eq!(zeros(&controlled), 0);
    }
    assert_eq!(nullity, 12);
    // The stiffness is also zero along an edge of the zone.
    for along in [0.3, 1.7] {
        let k = Vector3::new(PI, PI, along) / SPACING;
        assert!(in_units(waves.omega_squared(&k)[0].norm()) < 1e-12);
        assert!(in_units(controlled.omega_squared(&k)[0].re) > 1e-4);
    }
}

/// Stiffness and mass of a row of bars of unit length, in units of `E/h` and `rho h`: `2 - 2 cos`, `(2 + cos) / 3`.
fn row(angle: f64) -> (f64, f64) {
    (2.0 - 2.0 * angle.cos(), (2.0 + angle.cos()) / 3.0)
}

#[test]
fn fully_integrated_squares_and_cubes_are_products_of_rows_of_bars() {
    let mut random = Random::new(6);
    let squares = at_rest(&elements::<2>(ElementMesh::Quadrilaterals, full()));
    let cubes = at_rest(&elements::<3>(ElementMesh::Bricks, full()));
    let heavy = at_rest(&elements::<3>(ElementMesh::Bricks, consistent()));
    for _ in 0..20 {
        let k = wave::<3>(&mut random);
        let angles = k * SPACING;
        let (stiffness, mass): (Vec<f64>, Vec<f64>) =
            angles.iter().map(|angle| row(*angle)).unzip();
        let product = |dimension: usize, but: [usize; 2]| -> f64 {
            let axes = (0..dimension).filter(|axis| !but.contains(axis));
            axes.map(|axis| mass[axis]).product()
        };
        let entry = |dimension: usize, i: usize, j: usize| {
            let scale = SPACING.powi(dimension as i32 - 2);
            let along = |axis: usize| stiffness[axis] * product(dimension, [axis; 2]);
            let value = if i == j {
                (0..dimension)
                    .map(|axis| if axis == i { MODULUS } else { MU } * along(axis))
                    .sum()
            } else {
                (LAMBDA + MU) * angles[i].sin() * angles[j].sin() * product(dimension, [i, j])
            };
            scale * value
        };
        let (plane, space) = (
            squares.stiffness().at(&Vector2::new(k[0], k[1])),
            cubes.stiffness().at(&k),
        );
        for i in 0..3 {
            for j in 0..3 {
                assert!((space[(i, j)].re - entry(3, i, j)).abs() < 1e-12);
                if i < 2 && j < 2 {
                    assert!((plane[(i, j)].re - entry(2, i, j)).abs() < 1e-12);
                }
            }
        }
        let whole = DENSITY * SPACING.powi(3) * product(3, [3; 2]);
        assert!((heavy.mass_at(&k)[(1, 1)].re - whole).abs() < 1e-12);
    }
}

#[test]
fn one_coefficient_of_hourglass_control_reproduces_full_integration_of_squares() {
    // Both differ from one-point integration by a multiple of sin^2 sin^2: 2 kappa (lambda + 2 mu) with control, 4/3 (lambda + 3 mu) with full integration.
    let kappa = 2.0 * (LAMBDA + 3.0 * MU) / (3.0 * MODULUS);
    let integrated = at_rest(&elements::<2>(ElementMesh::Quadrilaterals, full()));
    let controlled = at_rest(&elements::<2>(
        ElementMesh::Quadrilaterals,
        controlled(kappa),
    ));
    let mut random = Random::new(7);
    for _ in 0..20 {
        let k = wave::<2>(&mut random);
        let (a, b) = (integrated.stiffness().at(&k), controlled.stiffness().at(&k));
        assert!((a - b).norm() < 1e-12);
    }
}

#[test]
fn any_hourglass_stiffness_lifts_the_modes_and_only_values_above_two_reduce_the_time_step() {
    for kappa in [1e-6, 0.05, 1.0, 2.0, 2.2, 5.0] {
        let squares = elements::<2>(ElementMesh::Quadrilaterals, controlled(kappa));
        let corner = at_rest(&squares).omega_squared(&Vector2::repeat(PI / SPACING));
        for value in corner {
            assert!((in_units(value.re) / (2.0 * kappa) - 1.0).abs() < 1e-9);
        }
        let highest = in_units(maximum_omega_squared(&squares));
        assert!(
            (highest - 4.0_f64.max(2.0 * kappa)).abs() < 1e-8,
            "{kappa}: {highest}"
        );
    }
    let integrated = elements::<2>(ElementMesh::Quadrilaterals, full());
    assert!((in_units(maximum_omega_squared(&integrated)) - 4.0).abs() < 1e-9);
}

#[test]
fn hourglass_viscosity_damps_the_modes_without_adding_stiffness() {
    let epsilon = 0.1;
    let squares = elements::<2>(
        ElementMesh::Quadrilaterals,
        Formulation {
            hourglass_viscosity: epsilon,
            ..ONE_POINT
        },
    );
    let frequencies = at_rest(&squares).frequencies(&Vector2::repeat(PI / SPACING));
    let rate = 2.0_f64.sqrt() * epsilon * (MODULUS / DENSITY).sqrt() / SPACING;
    let expected = [0.0, 0.0, -rate, -rate];
    for (found, expected) in frequencies.iter().zip(expected) {
        assert!(
            found.re.abs() < 1e-6 && (found.im - expected).abs() < 1e-6,
            "{found}"
        );
    }
    // Waves along an axis contain no hourglass mode.
    let along = at_rest(&squares).frequencies(&Vector2::new(1.1, 0.0));
    assert!(along.iter().all(|omega| omega.im.abs() < 1e-9));
}

#[test]
fn equilateral_triangles_with_equal_lame_constants_are_a_lattice_of_springs() {
    let scheme = elements::<2>(ElementMesh::TrianglesEquilateral, full());
    let material = saint_venant_kirchhoff(MU, MU);
    let waves = scheme
        .waves(&*material, &DeformationGradient::identity())
        .expect("waves");
    let spring = 4.0 * MU / 3.0_f64.sqrt();
    let mut random = Random::new(9);
    for _ in 0..10 {
        let k = wave::<2>(&mut random);
        let of_angle = |n: usize| {
            let (sine, cosine) = (n as f64 * TAU / 6.0).sin_cos();
            let direction = Vector2::new(cosine, sine);
            let factor = 2.0 * spring * (1.0 - (k.dot(&direction) * SPACING).cos());
            direction * direction.transpose() * factor
        };
        let expected: Matrix2<f64> = (0..3).map(of_angle).sum();
        let found = waves.stiffness().at(&k);
        for i in 0..2 {
            for j in 0..2 {
                assert!((found[(i, j)].re - expected[(i, j)]).abs() < 1e-12);
            }
        }
    }
}

/// Checks `tr K = (lambda + (D + 1) mu) sum_q V_q |B_q|^2`, with the Laplacian on the same mesh.
fn assert_laplacian<const D: usize>(
    mesh: ElementMesh,
    laplacian: impl Fn(&SVector<f64, D>) -> f64,
) {
    let waves = at_rest(&elements::<D>(mesh, full()));
    let mut random = Random::new(10);
    for _ in 0..10 {
        let k = wave::<D>(&mut random);
        let found = waves.stiffness().at(&k).trace();
        let expected = (LAMBDA + (D + 1) as f64 * MU) * laplacian(&k);
        assert!(
            (found.re - expected).abs() < 1e-11,
            "{}: {found}, {expected}",
            mesh.name()
        );
    }
}

#[test]
fn the_laplacian_of_simplices_on_squares_and_cubes_is_a_difference_along_the_axes() {
    let plane = |k: &Vector2<f64>| k.iter().map(|k| row(k * SPACING).0).sum::<f64>();
    assert_laplacian::<2>(ElementMesh::Triangles, plane);
    let space = |k: &Vector3<f64>| SPACING * k.iter().map(|k| row(k * SPACING).0).sum::<f64>();
    assert_laplacian::<3>(ElementMesh::Tetrahedra, space);
    // The long edges of body-centered tetrahedra are opposite to right angles, whose cotangent is zero: the eight nearest neighbors remain.
    let edge = 2.0 * SPACING / 3.0_f64.sqrt();
    let centered = |k: &Vector3<f64>| {
        let cosines: f64 = k.iter().map(|k| (0.5 * k * edge).cos()).product();
        4.0 * edge * (1.0 - cosines)
    };
    assert_laplacian::<3>(ElementMesh::TetrahedraBodyCentered, centered);
}

#[test]
fn alternating_and_crossed_triangles_are_the_same_mesh_rotated_by_45_degrees() {
    let alternating = at_rest(&elements::<2>(ElementMesh::TrianglesAlternating, full()));
    let crossed = at_rest(&elements::<2>(ElementMesh::TrianglesCrossed, full()));
    let (sine, cosine) = (TAU / 8.0).sin_cos();
    let turn = Matrix2::new(cosine, -sine, sine, cosine);
    let mut random = Random::new(11);
    for _ in 0..10 {
        let k = wave::<2>(&mut random);
        let turned = crossed.omega_squared(&(turn * k));
        for (a, b) in alternating.omega_squared(&k).iter().zip(turned) {
            assert!((a - b).norm() < 1e-11);
        }
    }
}

/// A descent does not terminate by itself where two branches meet. Both hourglass modes of squares have the same frequency there, and rounding
/// determines how they meet.
#[test]
fn the_lowest_hourglass_mode_is_found_where_two_branches_meet_in_any_units() {
    let f = DeformationGradient::from_stretches([1.15, 0.9, 1.0]).expect("a deformation");
    let mut random = Random::new(5);
    for _ in 0..200 {
        let [mu, density, spacing] = [0; 3].map(|_| 10.0_f64.powf(3.0 * random.number()));
        let squares = FiniteElements::<2>::new(&ElementChoices {
            mesh: ElementMesh::Quadrilaterals,
            spacing,
            density,
            formulation: controlled(0.05),
            ..ElementChoices::default()
        });
        let law = BlatzKo::new(mu).expect("a law");
        let waves = squares.expect("elements").waves(&law, &f).expect("waves");
        let search = ZoneSearch::of_lattice(*waves.crystal().lattice(), 3.0 * mu / density);
        let corner = Vector2::repeat(PI / spacing);
        let expected = waves.omega_squared(&corner)[0].re * density * spacing.powi(2) / (24.0 * mu);
        let found = search.summary_of(&waves).softest;
        assert!(
            (found.scaled - expected).abs() < 1e-12,
            "{mu} {density} {spacing}: {} {expected}",
            found.scaled
        );
    }
}

/// Returns true if no wave of the grid and no long wave grows.
fn is_stable<const D: usize>(waves: &WaveSystem<D>) -> bool {
    let grid = WaveGrids::new(*waves.crystal().lattice()).grid(12);
    let grows = |k: &SVector<f64, D>| waves.omega_squared(k)[0].re < -1e-10;
    let longest = waves.long_wave_stiffness().minimum().eigenvalue.re;
    longest > -1e-10 && !grid.wave_vectors().any(|k| grows(&k))
}

fn assert_stable_where_elliptic<const D: usize>(mesh: ElementMesh) {
    let material = material();
    let mut formulations = vec![full(), consistent(), ONE_POINT];
    if mesh.mesh::<D>(1.0).expect("a mesh").shape() == ElementShape::Multilinear {
        formulations.push(controlled(1.0));
    }
    let schemes: Vec<FiniteElements<D>> = formulations
        .into_iter()
        .map(|formulation| elements(mesh, formulation))
        .collect();
    let mut seen = [false; 2];
    for stretch in [0.45, 0.56, 0.58, 0.7, 0.9, 1.3] {
        let state = DeformationGradient::from_stretches([stretch, 1.0, 1.0]).expect("a state");
        let elliptic = Stiffness::<D>::at(&*material, &state).expect("a tangent");
        let is_elliptic = elliptic.is_strongly_elliptic();
        seen[usize::from(is_elliptic)] = true;
        for scheme in &schemes {
            let waves = scheme.waves(&*material, &state).expect("waves");
            assert_eq!(
                is_stable(&waves),
                is_elliptic,
                "{} at {stretch}",
                mesh.name()
            );
        }
    }
    assert_eq!(seen, [true; 2]);
}

#[test]
fn elements_with_one_node_per_cell_are_stable_exactly_if_the_material_is_elliptic() {
    assert_stable_where_elliptic::<1>(ElementMesh::Bars);
    assert_stable_where_elliptic::<2>(ElementMesh::Quadrilaterals);
    assert_stable_where_elliptic::<2>(ElementMesh::Triangles);
    assert_stable_where_elliptic::<2>(ElementMesh::TrianglesEquilateral);
    assert_stable_where_elliptic::<3>(ElementMesh::Bricks);
    assert_stable_where_elliptic::<3>(ElementMesh::Tetrahedra);
    assert_stable_where_elliptic::<3>(ElementMesh::TetrahedraBodyCentered);
}

#[test]
fn a_supercell_has_the_frequencies_of_the_mesh() {
    let mesh = ElementMesh::TetrahedraAlternating
        .mesh::<3>(SPACING)
        .expect("a mesh");
    let large = mesh.supercell([2, 1, 1]).expect("a mesh");
    let on = |mesh| at_rest(&FiniteElements::on(mesh, DENSITY, full()).expect("elements"));
    let (small, large) = (on(mesh), on(large));
    let k = Vector3::new(0.3, 0.7, -0.2);
    let large = large.omega_squared(&k);
    for value in small.omega_squared(&k) {
        let nearest = large.iter().map(|other| (other - value).norm());
        assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-10);
    }
}

#[test]
fn invalid_meshes_are_rejected() {
    let square = LatticeKind::Square.lattice::<2>(1.0).expect("a lattice");
    let node = |cell| Particle { site: 0, cell };
    let made = |shape, nodes: &[[i32; 2]]| {
        let nodes = nodes.iter().map(|cell| node(*cell)).collect();
        Mesh::new(Crystal::of_lattice(square), shape, vec![nodes])
    };
    let (triangle, quadrilateral) = (ElementShape::Simplex, ElementShape::Multilinear);
    let (o, x, y, xy) = ([0, 0], [1, 0], [0, 1], [1, 1]);
    assert!(made(quadrilateral, &[o, x, y, xy]).is_ok());
    let gap = made(triangle, &[o, x, y]);
    assert!(matches!(gap, Err(MeshError::Volume { .. })), "{gap:?}");
    let around = made(quadrilateral, &[o, x, xy, y]);
    assert!(matches!(around, Err(MeshError::Distorted { element: 0 })));
    let flat = made(triangle, &[o, x, [2, 0]]);
    assert!(matches!(flat, Err(MeshError::Distorted { element: 0 })));
    let short = made(triangle, &[o, x]);
    assert!(matches!(
        short,
        Err(MeshError::NodeCount {
            nodes: 2,
            needed: 3,
            ..
        })
    ));
    let mesh = Mesh::parallelepipeds(square);
    let needless = Formulation {
        hourglass_stiffness: 0.1,
        ..full()
    };
    let refused = FiniteElements::on(mesh.clone(), 1.0, needless);
    assert!(matches!(
        refused,
        Err(MethodError::Mesh(MeshError::NeedlessControl))
    ));
    let refused = FiniteElements::on(mesh.clone(), 1.0, controlled(-1.0));
    assert!(matches!(
        refused,
        Err(MethodError::Setting {
            name: "hourglass-stiffness",
            ..
        })
    ));
    assert!(FiniteElements::on(mesh, 0.0, full()).is_err());
    assert!(ElementMesh::Bricks.mesh::<2>(1.0).is_err());
    assert!(ElementMesh::Bricks.mesh::<3>(-1.0).is_err());
}

/// Waves in the reference configuration with a law of given constants.
fn at_rest_with<const D: usize>(
    mesh: ElementMesh,
    formulation: Formulation,
    lambda: f64,
    mu: f64,
) -> WaveSystem<D> {
    let material = saint_venant_kirchhoff(lambda, mu);
    let waves =
        elements::<D>(mesh, formulation).waves(&*material, &DeformationGradient::identity());
    waves.expect("waves")
}

fn assert_mean_dilatation_at_small_strains<const D: usize>(mesh: ElementMesh) {
    // The energy is mu |dev eps|^2 at the points of full integration, and (lambda + 2 mu / D) / 2 (mean div u)^2: a sum of stiffnesses linear in both constants.
    let of = |formulation, lambda, mu| at_rest_with::<D>(mesh, formulation, lambda, mu);
    let mean = of(mean_dilatation(), LAMBDA, MU);
    let full = [(0.5, MU), (1.5, MU)].map(|(lambda, mu)| of(full(), lambda, mu));
    let one = [(0.5, MU), (1.5, MU)].map(|(lambda, mu)| of(ONE_POINT, lambda, mu));
    let mut random = Random::new(12);
    for _ in 0..10 {
        let k = wave::<D>(&mut random);
        let [a, b, c, d] = [&full[0], &full[1], &one[0], &one[1]].map(|own| own.stiffness().at(&k));
        let per_lambda = &b - &a;
        let of_shear = a - per_lambda.scale(0.5 + 2.0 * MU / D as f64);
        let expected = of_shear + (d - c).scale(LAMBDA + 2.0 * MU / D as f64);
        assert!((mean.stiffness().at(&k) - expected).norm() < 1e-11);
    }
}

#[test]
fn a_mean_dilatation_is_b_bar_at_small_strains() {
    assert_mean_dilatation_at_small_strains::<2>(ElementMesh::Quadrilaterals);
    assert_mean_dilatation_at_small_strains::<3>(ElementMesh::Bricks);
}

/// Checks the slowest wave of six elements in length for three ratios of lambda to mu: `rho omega^2 / (mu k^2)`, which is 1 in the material, with full
/// integration and with a mean dilatation.
fn assert_locking<const D: usize>(mesh: ElementMesh, locked: [f64; 3], free: f64) {
    let k = SVector::<f64, D>::from_fn(|i, _| [1.0, 0.3, 0.2][i] / SPACING);
    let ratio = |formulation, lambda| {
        let waves = at_rest_with::<D>(mesh, formulation, lambda, MU);
        waves.omega_squared(&k)[0].re * DENSITY / (MU * k.norm_squared())
    };
    for (lambda, locked) in [1e2, 1e4, 1e6].into_iter().zip(locked) {
        for (formulation, expected) in [(full(), locked), (mean_dilatation(), free)] {
            let found = ratio(formulation, lambda);
            assert!((found / expected - 1.0).abs() < 1e-8, "{lambda}: {found}");
        }
    }
}

#[test]
fn shear_waves_of_nearly_incompressible_laws_lock_with_full_integration_and_not_with_a_mean_dilatation()
 {
    // Strains at the Gauss points of one element, summed in NumPy.
    let squares = [1.534_478_100_07, 63.694_709_999_7, 6_279.717_899_964];
    assert_locking::<2>(ElementMesh::Quadrilaterals, squares, 0.900_318_158_469);
    let cubes = [0.914_204_071_067, 3.080_092_826_64, 219.668_968_384];
    assert_locking::<3>(ElementMesh::Bricks, cubes, 0.892_180_652_866);
}

#[test]
fn elements_with_a_mean_dilatation_have_an_energy_and_no_zero_energy_modes() {
    let squares = elements::<2>(ElementMesh::Quadrilaterals, mean_dilatation());
    let system = squares.waves(&*material(), &sheared::<2>()).expect("waves");
    let mut random = Random::new(13);
    for _ in 0..10 {
        let stiffness = system.stiffness().at(&wave::<2>(&mut random));
        assert!((&stiffness - stiffness.adjoint()).norm() < 1e-12);
    }
    for corner in 1..8_usize {
        let k = Vector3::from_fn(|i, _| (corner >> i & 1) as f64 * PI / SPACING);
        let bricks = at_rest(&elements::<3>(ElementMesh::Bricks, mean_dilatation()));
        let lowest = bricks.omega_squared(&k)[0].re;
        assert!(in_units(lowest) > 0.1, "{corner}: {lowest}");
    }
}

/// Energy of a patch of squares with a mean dilatation, computed explicitly from the displacements of `CELLS` by `CELLS` nodes.
fn energy_of_mean_dilatation(
    material: &dyn Hyperelastic,
    state: &DeformationGradient,
    displacement: &dyn Fn(i32, i32) -> Vector2<f64>,
) -> f64 {
    let place = 0.5 / 3.0_f64.sqrt();
    let mut energy = 0.0;
    for (x, y) in (0..CELLS * CELLS).map(|n| (n % CELLS, n / CELLS)) {
        let mut points = Vec::new();
        for (right, up) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let (a, b) = (0.5 + right * place, 0.5 + up * place);
            let corners = [
                (0, 0, [-(1.0 - b), -(1.0 - a)]),
                (1, 0, [1.0 - b, -a]),
                (0, 1, [-b, 1.0 - a]),
                (1, 1, [b, a]),
            ];
            let mut f: Matrix2<f64> = state.leading::<2>();
            for (i, j, slope) in corners {
                f += displacement(x + i, y + j) * Vector2::from(slope).transpose() / SPACING;
            }
            points.push(f);
        }
        let mean = points.iter().map(Matrix2::determinant).sum::<f64>() / 4.0;
        for f in points {
            let own = state.with_leading(&(f * (mean / f.determinant()).sqrt()));
            let density = material.response(&own).expect("a state").energy;
            energy += density * SPACING * SPACING / 4.0;
        }
    }
    energy
}

/// Number of cells along each side of a patch.
const CELLS: i32 = 3;

#[test]
fn forces_with_a_mean_dilatation_are_derivatives_of_the_energy_at_large_displacements() {
    let (material, state) = (BlatzKo::new(MU).expect("a law"), sheared::<2>());
    let squares = elements::<2>(ElementMesh::Quadrilaterals, mean_dilatation());
    let patch = PeriodicPatch::new(squares.crystal(), [CELLS as usize; 2]);
    let mut random = Random::new(14);
    let displacements: Vec<Vector2<f64>> = (0..patch.len())
        .map(|_| Vector2::from_fn(|_, _| 0.1 * SPACING * random.number()))
        .collect();
    let forces = squares.forces(&material, &state, &patch, &displacements);
    for (node, force) in forces.expect("forces").iter().enumerate() {
        for i in 0..2 {
            let at = |step: f64| {
                let moved = |x: i32, y: i32| {
                    let n = patch.number(&Particle {
                        site: 0,
                        cell: [x, y],
                    });
                    let mut own = displacements[n];
                    own[i] += if n == node { step } else { 0.0 };
                    own
                };
                energy_of_mean_dilatation(&material, &state, &moved)
            };
            let h = 1e-5;
            let slope = (at(h) - at(-h)) / (2.0 * h);
            assert!(
                (force[i] + slope).abs() < 1e-8,
                "{node}: {} {slope}",
                force[i]
            );
        }
    }
}

#[test]
fn simplices_have_a_constant_dilatation_so_that_its_mean_changes_nothing() {
    let [mean, usual] = [mean_dilatation(), full()].map(|formulation| {
        let triangles = elements::<2>(ElementMesh::Triangles, formulation);
        triangles
            .waves(&*material(), &sheared::<2>())
            .expect("waves")
    });
    let k = Vector2::new(1.1, -0.4);
    assert_eq!(mean.stiffness().at(&k), usual.stiffness().at(&k));
}

/// Quadratic elements on a named mesh.
fn quadratic<const D: usize>(
    mesh: ElementMesh,
    mass: ElementMass,
) -> Result<FiniteElements<D>, MethodError> {
    FiniteElements::new(&ElementChoices {
        mesh,
        order: ElementOrder::Quadratic,
        spacing: SPACING,
        density: DENSITY,
        formulation: Formulation { mass, ..full() },
        ..ElementChoices::default()
    })
}

fn assert_quadratic<const D: usize>(mesh: ElementMesh) {
    for mass in [ElementMass::Hrz, ElementMass::Consistent] {
        let scheme = quadratic::<D>(mesh, mass).expect("elements");
        assert_scheme(&scheme, &*material(), &sheared::<D>());
        assert_long_waves_are_those_of_the_material(&scheme, &*material(), &sheared::<D>(), 1e-7);
    }
}

#[test]
fn quadratic_elements_pass_the_scheme_checks_and_reproduce_the_long_wave_limit() {
    assert_quadratic::<1>(ElementMesh::Bars);
    for mesh in [
        ElementMesh::Quadrilaterals,
        ElementMesh::Triangles,
        ElementMesh::TrianglesEquilateral,
    ] {
        assert_quadratic::<2>(mesh);
    }
    for mesh in [ElementMesh::Bricks, ElementMesh::Tetrahedra] {
        assert_quadratic::<3>(mesh);
    }
}

#[test]
fn quadratic_bars_have_the_two_branches_of_textbooks() {
    // Elements of the length l = 2 h, where the middle moves against the ends: 24 c^2/l^2 with the masses 1/6, 2/3, 1/6, and 60 c^2/l^2 with consistent ones.
    for (mass, optical) in [(ElementMass::Lumped, 6.0), (ElementMass::Consistent, 15.0)] {
        let bars = quadratic::<1>(ElementMesh::Bars, mass).expect("bars");
        let values = at_rest(&bars).omega_squared(&Vector1::zeros());
        assert!(in_units(values[0].norm()) < 1e-12);
        let found = in_units(values[1].re);
        assert!((found - optical).abs() < 1e-9, "{mass:?}: {found}");
    }
}

#[test]
fn lumped_masses_of_quadratic_elements_have_the_textbook_fractions() {
    // Zienkiewicz and Taylor: triangles of six nodes 3/57 and 16/57; quadrilaterals of eight nodes with 3 by 3 points 3/76 and 16/76.
    for (mesh, corner, middle, elements_at_corner) in [
        (ElementMesh::Quadrilaterals, 3.0 / 76.0, 16.0 / 76.0, 4.0),
        (ElementMesh::Triangles, 3.0 / 57.0, 16.0 / 57.0, 6.0),
    ] {
        let scheme = quadratic::<2>(mesh, ElementMass::Hrz).expect("elements");
        let cell = 4.0 * SPACING * SPACING * DENSITY;
        let element = cell / scheme.mesh().elements().len() as f64;
        let masses = scheme.masses();
        assert!((masses[0] / element - elements_at_corner * corner).abs() < 1e-12);
        for own in &masses[1..] {
            assert!((own / element - 2.0 * middle).abs() < 1e-12, "{masses:?}");
        }
        assert!((masses.iter().sum::<f64>() / cell - 1.0).abs() < 1e-12);
    }
}

#[test]
fn row_sums_of_quadratic_elements_that_are_not_positive_are_refused() {
    // Corners of quadrilaterals have -1/12 of each of four elements, corners of triangles have zero mass.
    let refused = |mesh| match quadratic::<2>(mesh, ElementMass::Lumped) {
        Err(MethodError::Mesh(MeshError::Massless { site: 0, share })) => share,
        other => panic!("{other:?}"),
    };
    assert!((refused(ElementMesh::Quadrilaterals) + 1.0 / 3.0).abs() < 1e-12);
    assert!(refused(ElementMesh::Triangles).abs() < 1e-12);
    assert!(quadratic::<3>(ElementMesh::Bricks, ElementMass::Lumped).is_err());
    let one_point = FiniteElements::<2>::new(&ElementChoices {
        order: ElementOrder::Quadratic,
        formulation: ONE_POINT,
        ..ElementChoices::default()
    });
    assert!(matches!(one_point, Err(MethodError::Incompatible { .. })));
}

#[test]
fn errors_of_frequencies_are_of_second_order_with_linear_and_of_fourth_order_with_quadratic_elements()
 {
    let error = |order, mesh, size: f64| {
        let scheme = FiniteElements::<2>::new(&ElementChoices {
            mesh,
            order,
            spacing: SPACING,
            density: DENSITY,
            formulation: consistent(),
            ..ElementChoices::default()
        });
        let k = Vector2::new(0.8, 0.6) * size;
        let found = at_rest(&scheme.expect("elements")).omega_squared(&k)[0].re;
        found * DENSITY / (MU * size * size) - 1.0
    };
    for mesh in [ElementMesh::Quadrilaterals, ElementMesh::Triangles] {
        let ratio = |order| error(order, mesh, 0.4) / error(order, mesh, 0.2);
        let (linear, quadratic) = (ratio(ElementOrder::Linear), ratio(ElementOrder::Quadratic));
        assert!((linear - 4.0).abs() < 0.3, "{mesh:?}: {linear}");
        assert!((quadratic - 16.0).abs() < 1.5, "{mesh:?}: {quadratic}");
    }
}

#[test]
fn the_softest_wave_of_mean_dilatation_does_not_depend_on_the_bulk_modulus() {
    let f = DeformationGradient::from_stretches([1.2, 0.9, 0.95]).expect("a state");
    let scheme = elements::<3>(ElementMesh::Bricks, mean_dilatation());
    let law = Law::named("neo-hooke-isochoric").expect("a law");
    let mut squares = Vec::new();
    for kappa in [1e4, 1e6, 1e8, 1e9, 1e10, 1e11, 1e12] {
        let material = law.build(&[("mu", 1.0), ("kappa", kappa)]);
        let material = material.expect("a material");
        let survey = Survey::new(&scheme, &*material).expect("a survey");
        let softest = survey.spectrum(&f).expect("a spectrum").softest;
        // Nodes move against all of their neighbors, which changes no volume of an element.
        let apart = softest.wave_vector.map(|x| (x * SPACING).abs() - PI);
        assert!(apart.amax() < 1e-6, "{kappa:e}: {:?}", softest.wave_vector);
        squares.push(softest.omega_squared.re);
        let error = softest.omega_squared.re / squares[0] - 1.0;
        assert!(error.abs() < 1e-6 + 1e-15 * kappa, "{kappa:e}: {error:e}");
    }
}
