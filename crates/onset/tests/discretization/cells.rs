//! Lattices in three dimensions: their types, Voronoi cells, centers of Delaunay cells, and Brillouin zones.

use crate::choices::config;
use nalgebra::{Matrix3, Vector3};
use onset::lattice::{
    BravaisLattice, BrillouinZone, LatticeError, LatticeKind, delaunay_centers, voronoi_volumes,
};
use onset::quadrature::{CellRule, Quadrature};
use proptest::prelude::*;

const CUBIC: [LatticeKind; 3] = [
    LatticeKind::SimpleCubic,
    LatticeKind::BodyCenteredCubic,
    LatticeKind::FaceCenteredCubic,
];

fn lattice(kind: LatticeKind) -> BravaisLattice<3> {
    kind.lattice(1.3).expect("a lattice")
}

/// All lattice points up to three cells away.
fn points_around(lattice: &BravaisLattice<3>) -> Vec<Vector3<f64>> {
    let range = || -4..=4;
    range()
        .flat_map(|i| range().flat_map(move |j| range().map(move |k| [i, j, k])))
        .map(|cell| lattice.vectors() * Vector3::from(cell.map(f64::from)))
        .collect()
}

#[test]
fn cubic_lattices_have_known_neighbors_and_volumes() {
    let h: f64 = 1.3;
    for (kind, neighbors, volume) in [
        (CUBIC[0], 6, 1.0),
        (CUBIC[1], 8, 4.0 / 27.0_f64.sqrt()),
        (CUBIC[2], 12, 0.5_f64.sqrt()),
    ] {
        let lattice = lattice(kind);
        let distances = points_around(&lattice).into_iter().map(|r| r.norm());
        let distances: Vec<f64> = distances.filter(|r| *r > 0.0).collect();
        let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((nearest - h).abs() < 1e-14, "{kind:?}");
        let count = distances.iter().filter(|r| **r < h * (1.0 + 1e-12)).count();
        assert_eq!(count, neighbors, "{kind:?}");
        assert!((lattice.cell_volume() - volume * h.powi(3)).abs() < 1e-13);
        // The cubes are aligned with the axes: a quarter turn changes nothing.
        let turned = lattice.mapped(&Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0));
        let cycles = lattice.reciprocal().transpose() * turned.expect("a lattice").vectors();
        let cycles = cycles / std::f64::consts::TAU;
        assert!(cycles.iter().all(|x| (x - x.round()).abs() < 1e-14));
    }
}

#[test]
fn holes_of_cubic_lattices_have_the_crystallographic_positions() {
    // Positions in units of the cube edge within one period, and the distance to the nearest particles in edges.
    let centers = |kind| delaunay_centers(&lattice(kind), &[Vector3::zeros()]).expect("centers");
    let edge = [1.3, 1.3 * 2.0 / 3.0_f64.sqrt(), 1.3 * 2.0_f64.sqrt()];
    for (n, expected) in [
        // The center of the cube.
        vec![(3.0_f64.sqrt() / 2.0, 8)],
        // Six tetrahedral holes, (1/2, 1/4, 0) and its equivalents.
        vec![(5.0_f64.sqrt() / 4.0, 4); 6],
        // Two tetrahedral holes and one octahedral hole.
        vec![
            (3.0_f64.sqrt() / 4.0, 4),
            (0.5, 6),
            (3.0_f64.sqrt() / 4.0, 4),
        ],
    ]
    .into_iter()
    .enumerate()
    {
        let lattice = lattice(CUBIC[n]);
        let found: Vec<(f64, usize)> = centers(CUBIC[n])
            .into_iter()
            .map(|center| {
                let place = lattice.vectors() * center;
                let distances = points_around(&lattice)
                    .into_iter()
                    .map(|r| (r - place).norm());
                let distances: Vec<f64> = distances.collect();
                let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
                let count = distances.iter().filter(|r| **r < nearest + 1e-9).count();
                (nearest / edge[n], count)
            })
            .collect();
        assert_eq!(found.len(), expected.len(), "{:?}", CUBIC[n]);
        for (found, expected) in found.iter().zip(expected) {
            assert!((found.0 - expected.0).abs() < 1e-12, "{:?}", CUBIC[n]);
            assert_eq!(found.1, expected.1);
        }
    }
}

#[test]
fn voronoi_volumes_of_symmetric_sets_agree_with_closed_forms() {
    let [simple, body, face] = CUBIC.map(lattice);
    let at = Vector3::repeat;
    let shares = |lattice: &BravaisLattice<3>, points: &[Vector3<f64>]| -> Vec<f64> {
        let volumes = voronoi_volumes(lattice, points).expect("distinct points");
        volumes.iter().map(|v| v / lattice.cell_volume()).collect()
    };
    let equal = |shares: Vec<f64>| {
        let share = 1.0 / shares.len() as f64;
        assert!(
            shares.iter().all(|x| (x - share).abs() < 1e-14),
            "{shares:?}"
        );
    };
    for lattice in [&simple, &body, &face] {
        equal(shares(lattice, &[Vector3::zeros()]));
    }
    // Diamond, rock salt, and all holes of the closest packing together, which form a body-centered lattice.
    equal(shares(&face, &[at(0.0), at(0.25)]));
    equal(shares(&face, &[at(0.0), at(0.5)]));
    equal(shares(&face, &[at(0.0), at(0.25), at(0.5), at(0.75)]));
    // Layers at any heights: slabs between the midplanes.
    let heights = [0.0, 0.2, 0.5];
    let slabs = shares(&simple, &heights.map(|z| Vector3::new(0.3, 0.1, z)));
    for (slab, expected) in slabs.iter().zip([0.35, 0.25, 0.4]) {
        assert!((slab - expected).abs() < 1e-14);
    }
    // Fluorite with unit edges: the bisectors toward the four particles around a tetrahedral hole cut tetrahedra with legs of 3/8 from four corners
    // of the cube of edge 1/2 around the hole.
    let hole = 4.0 * (1.0 / 8.0 - 4.0 * (3.0_f64 / 8.0).powi(3) / 6.0);
    let fluorite = shares(&face, &[at(0.0), at(0.25), at(0.75)]);
    for (share, expected) in fluorite.iter().zip([1.0 - 2.0 * hole, hole, hole]) {
        assert!((share - expected).abs() < 1e-14, "{fluorite:?}");
    }
}

fn bases() -> impl Strategy<Value = Matrix3<f64>> {
    // Products of shears: integer matrices of determinant one.
    let shear = (0..6_usize, -2..=2_i32).prop_map(|(n, amount)| {
        let mut shear = Matrix3::identity();
        let (i, j) = [(0, 1), (1, 0), (0, 2), (2, 0), (1, 2), (2, 1)][n];
        shear[(i, j)] = f64::from(amount);
        shear
    });
    prop::collection::vec(shear, 1..4)
        .prop_map(|shears| shears.into_iter().fold(Matrix3::identity(), |m, s| m * s))
}

fn vectors() -> impl Strategy<Value = Matrix3<f64>> {
    (
        prop::array::uniform3(0.6..1.6_f64),
        prop::array::uniform3(-0.9..0.9_f64),
    )
        .prop_map(|(d, s)| Matrix3::new(d[0], s[0], s[1], 0.0, d[1], s[2], 0.0, 0.0, d[2]))
}

proptest! {
    #![proptest_config(config(40))]
    #[test]
    fn voronoi_volumes_fill_the_cell_for_any_basis_and_origin(
        vectors in vectors(),
        basis in bases(),
        points in prop::collection::vec(prop::array::uniform3(0.0..1.0_f64), 1..6),
        shift in prop::array::uniform3(-2.0..2.0_f64),
    ) {
        let lattice = BravaisLattice::new(vectors).expect("independent vectors");
        let points: Vec<Vector3<f64>> = points.into_iter().map(Vector3::from).collect();
        let volumes = voronoi_volumes(&lattice, &points).expect("distinct points");
        let sum: f64 = volumes.iter().sum();
        prop_assert!((sum / lattice.cell_volume() - 1.0).abs() < 1e-12, "volumes fill the cell: {}", sum);
        let other = BravaisLattice::new(vectors * basis).expect("a lattice");
        let inverse = basis.try_inverse().expect("a basis");
        let moved: Vec<Vector3<f64>> = points.iter().map(|p| inverse * (p + Vector3::from(shift))).collect();
        let again = voronoi_volumes(&other, &moved).expect("distinct points");
        for (a, b) in volumes.iter().zip(again) {
            prop_assert!((a - b).abs() < 1e-11, "{} against {}", a, b);
        }
    }

    #[test]
    fn delaunay_centers_have_four_nearest_points_and_none_closer(
        vectors in vectors(),
        points in prop::collection::vec(prop::array::uniform3(0.0..1.0_f64), 1..4),
    ) {
        let lattice = BravaisLattice::new(vectors).expect("independent vectors");
        let points: Vec<Vector3<f64>> = points.into_iter().map(Vector3::from).collect();
        let centers = delaunay_centers(&lattice, &points).expect("centers");
        let around = points_around(&lattice);
        // Simplices fill space: in general position there are more than five tetrahedra per point.
        prop_assert!(centers.len() >= 6 * points.len() || points.len() == 1);
        for center in &centers {
            let place = lattice.vectors() * center;
            let mut distances: Vec<f64> = points
                .iter()
                .flat_map(|p| around.iter().map(move |r| (r, p)))
                .map(|(r, p)| (lattice.vectors() * p + r - place).norm())
                .collect();
            distances.sort_by(f64::total_cmp);
            prop_assert!(distances[3] - distances[0] < 1e-7, "{:?}", &distances[..5]);
        }
    }
}

#[test]
fn voronoi_volumes_agree_with_nearest_points_on_a_fine_grid() {
    let lattice = lattice(LatticeKind::BodyCenteredCubic);
    let points = [[0.1, 0.2, 0.3], [0.7, 0.3, 0.9], [0.4, 0.9, 0.5]].map(Vector3::from);
    let volumes = voronoi_volumes(&lattice, &points).expect("distinct points");
    let side = 36;
    let mut counts = [0.0; 3];
    let images: Vec<Vector3<f64>> = points_around(&lattice)
        .into_iter()
        .filter(|r| r.norm() < 4.5)
        .collect();
    for index in 0..side * side * side {
        let cell = [index % side, index / side % side, index / side / side];
        let place = lattice.vectors() * Vector3::from(cell.map(|n| n as f64 / side as f64));
        let distance = |n: &usize| {
            let from = lattice.vectors() * points[*n] - place;
            images
                .iter()
                .map(|r| (from + r).norm_squared())
                .fold(f64::INFINITY, f64::min)
        };
        let nearest = (0..3).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        counts[nearest.expect("three points")] += lattice.cell_volume() / (side as f64).powi(3);
    }
    for (volume, count) in volumes.iter().zip(counts) {
        assert!(
            (volume - count).abs() < 4e-3 * lattice.cell_volume(),
            "{volume} {count}"
        );
    }
}

#[test]
fn corners_of_cubic_zones_and_the_named_points_lie_on_their_boundaries() {
    for (kind, corners) in CUBIC.into_iter().zip([8, 14, 24]) {
        let lattice = lattice(kind);
        let zone = BrillouinZone::new(lattice);
        let mut distinct: Vec<Vector3<f64>> = Vec::new();
        for corner in zone.corners() {
            assert!(zone.contains(&corner, 1e-9) && !zone.contains(&(corner * 1.001), 1e-9));
            if distinct.iter().all(|known| (known - corner).norm() > 1e-6) {
                distinct.push(corner);
            }
        }
        // The zones are a cube, a rhombic dodecahedron and a truncated octahedron.
        assert_eq!(distinct.len(), corners, "{kind:?}");
        for (name, fractional) in kind.zone_path::<3>() {
            let k = zone.wave_vector(&fractional);
            if name == "Γ" {
                assert_eq!(k.norm(), 0.0);
                continue;
            }
            let shortest = zone.folded(&k);
            assert!(
                (shortest.norm() - k.norm()).abs() < 1e-12,
                "{name} is in the zone"
            );
            assert!(
                zone.contains(&k, 1e-9) && !zone.contains(&(k * 1.001), 1e-9),
                "{name}"
            );
        }
    }
}

#[test]
fn lattices_from_vectors_equal_named_lattices() {
    let hexagonal = LatticeKind::Hexagonal.lattice::<2>(0.7).expect("a lattice");
    let oblique =
        LatticeKind::Oblique.lattice_with::<2>(0.7, 1.0, &[1.0, 0.0, 0.5, 0.75_f64.sqrt()]);
    assert!((oblique.expect("a lattice").vectors() - hexagonal.vectors()).amax() < 1e-15);
    let halves = [-1.0, 1.0, 1.0, 1.0, -1.0, 1.0, 1.0, 1.0, -1.0].map(|x| x / 3.0_f64.sqrt());
    let body = LatticeKind::BodyCenteredCubic
        .lattice::<3>(0.7)
        .expect("a lattice");
    let triclinic = LatticeKind::Triclinic.lattice_with::<3>(0.7, 1.0, &halves);
    assert!((triclinic.expect("a lattice").vectors() - body.vectors()).amax() < 1e-15);
    let rectangular = LatticeKind::Rectangular
        .lattice_with::<2>(2.0, 1.5, &[])
        .expect("a lattice");
    assert_eq!(
        rectangular.vectors(),
        &nalgebra::Matrix2::new(2.0, 0.0, 0.0, 3.0)
    );
    let rule = CellRule::default();
    for points in [
        Quadrature::StressPoints
            .points(&rectangular, &rule)
            .expect("points"),
        Quadrature::StressPoints
            .points(
                &LatticeKind::Square.lattice::<2>(2.0).expect("a lattice"),
                &rule,
            )
            .expect("points"),
    ] {
        assert_eq!(points.len(), 2);
        assert_eq!(points[1].place, nalgebra::Vector2::repeat(0.5));
    }
}

#[test]
fn missing_or_dependent_vectors_and_zero_sides_are_rejected() {
    let refused = |kind: LatticeKind, aspect: f64, vectors: &[f64]| {
        kind.lattice_with::<2>(1.0, aspect, vectors)
            .expect_err("no lattice")
    };
    assert!(matches!(
        refused(LatticeKind::Rectangular, 0.0, &[]),
        LatticeError::Aspect { value: 0.0 }
    ));
    assert!(matches!(
        refused(LatticeKind::Oblique, 1.0, &[1.0, 0.0]),
        LatticeError::Vectors {
            expected: 4,
            given: 2,
            ..
        }
    ));
    for dependent in [
        [1.0, 2.0, 2.0, 4.0],
        [0.0; 4],
        [f64::NAN, 0.0, 0.0, 1.0],
        [1e200, 0.0, 0.0, 1e200],
    ] {
        assert!(matches!(
            refused(LatticeKind::Oblique, 1.0, &dependent),
            LatticeError::Dependent { .. }
        ));
    }
    assert!(matches!(
        refused(LatticeKind::Triclinic, 1.0, &[]),
        LatticeError::Dimension {
            actual: 3,
            requested: 2,
            ..
        }
    ));
}
