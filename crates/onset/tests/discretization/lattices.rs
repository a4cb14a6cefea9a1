//! Voronoi volumes and the first Brillouin zone.

use crate::choices::config;
use nalgebra::{Matrix2, SVector, Vector2};
use onset::lattice::{BravaisLattice, BrillouinZone, LatticeError, LatticeKind, voronoi_volumes};
use onset::quadrature::{CellRule, Quadrature};
use proptest::prelude::*;
use spade::{DelaunayTriangulation, Point2, Triangulation};

/// Voronoi areas of the points in the central cell among many periodic images, computed by the crate spade.
fn areas_by_spade(lattice: &BravaisLattice<2>, points: &[Vector2<f64>]) -> Vec<f64> {
    let reach = 7;
    let mut triangulation = DelaunayTriangulation::<Point2<f64>>::new();
    let at = |place: Vector2<f64>| {
        let x = lattice.vectors() * place;
        Point2::new(x[0], x[1])
    };
    for i in -reach..=reach {
        for j in -reach..=reach {
            for point in points {
                let place = point + Vector2::new(f64::from(i), f64::from(j));
                triangulation.insert(at(place)).expect("a finite position");
            }
        }
    }
    let area = |point: &Vector2<f64>| {
        let vertex = triangulation
            .nearest_neighbor(at(*point))
            .expect("the point");
        let corners: Vec<Point2<f64>> = vertex
            .as_voronoi_face()
            .adjacent_edges()
            .map(|edge| edge.from().position().expect("an inner cell"))
            .collect();
        (0..corners.len())
            .map(|n| {
                let (a, b) = (corners[n], corners[(n + 1) % corners.len()]);
                0.5 * (a.x * b.y - b.x * a.y)
            })
            .sum::<f64>()
            .abs()
    };
    points.iter().map(area).collect()
}

proptest! {
    #![proptest_config(config(60))]
    #[test]
    fn voronoi_volumes_of_any_point_set_agree_with_spade(
        lengths in prop::array::uniform2(0.6..1.6_f64),
        shear in -0.9..0.9_f64,
        points in prop::collection::vec(prop::array::uniform2(0.0..1.0_f64), 1..5),
    ) {
        let vectors = Matrix2::new(lengths[0], shear, 0.0, lengths[1]);
        let lattice = BravaisLattice::new(vectors).expect("independent vectors");
        let points: Vec<Vector2<f64>> = points.into_iter().map(Vector2::from).collect();
        let volumes = voronoi_volumes(&lattice, &points).expect("distinct points");
        let sum: f64 = volumes.iter().sum();
        prop_assert!((sum - lattice.cell_volume()).abs() < 1e-11, "volumes fill the cell");
        for (own, spade) in volumes.iter().zip(areas_by_spade(&lattice, &points)) {
            prop_assert!((own - spade).abs() < 1e-9, "{} against {}", own, spade);
        }
    }

    #[test]
    fn folded_wave_vectors_are_equivalent_and_the_shortest_of_their_kind(
        stretches in prop::array::uniform2(0.4..2.5_f64),
        shear in -1.5..1.5_f64,
        k in prop::array::uniform2(-40.0..40.0_f64),
    ) {
        let lattice = BravaisLattice::new(Matrix2::new(stretches[0], shear, 0.0, stretches[1])).expect("a lattice");
        let zone = BrillouinZone::new(lattice);
        let k = Vector2::from(k);
        let folded = zone.folded(&k);
        let cycles = lattice.vectors().transpose() * (k - folded) / std::f64::consts::TAU;
        prop_assert!(cycles.iter().all(|x| (x - x.round()).abs() < 1e-11), "the difference is reciprocal");
        prop_assert!(zone.contains(&folded, 1e-9));
        for i in -8..=8 {
            for j in -8..=8 {
                let g = lattice.reciprocal() * Vector2::new(f64::from(i), f64::from(j));
                prop_assert!((folded + g).norm() >= folded.norm() * (1.0 - 1e-11));
            }
        }
        // The corners are equally far from zero and from two reciprocal vectors, and enclose the volume of the zone.
        let corners = zone.corners();
        let area: f64 = (0..corners.len())
            .map(|n| corners[n].perp(&corners[(n + 1) % corners.len()]) * 0.5)
            .sum();
        prop_assert!((area / lattice.reciprocal().determinant().abs() - 1.0).abs() < 1e-9);
        prop_assert!(corners.iter().all(|corner| zone.contains(corner, 1e-9) && !zone.contains(&(corner * 1.001), 1e-9)));
    }
}

#[test]
fn particles_and_stress_points_share_the_cell_equally() {
    let rule = CellRule::default();
    for (kind, quadrature, parts) in [
        (LatticeKind::Square, Quadrature::Nodal, 1),
        (LatticeKind::Square, Quadrature::StressPoints, 2),
        (LatticeKind::Square, Quadrature::StressPointsOnly, 1),
        (LatticeKind::Hexagonal, Quadrature::Nodal, 1),
        (LatticeKind::Hexagonal, Quadrature::StressPoints, 3),
        (LatticeKind::Hexagonal, Quadrature::StressPointsOnly, 2),
    ] {
        let lattice = kind.lattice::<2>(1.7).expect("a lattice");
        let expected = lattice.cell_volume() / f64::from(parts);
        let points = quadrature.points(&lattice, &rule).expect("volumes");
        assert_eq!(points.len() as i32, parts);
        let places: Vec<Vector2<f64>> = points.iter().map(|point| point.place).collect();
        for point in points {
            assert!(
                (point.volume - expected).abs() < 1e-13,
                "{kind:?}, {quadrature:?}"
            );
        }
        // Affine images of a Bravais lattice of points keep equal shares; the honeycomb keeps them by inversion.
        let sheared = lattice
            .mapped(&Matrix2::new(1.2, 0.4, -0.1, 0.8))
            .expect("a lattice");
        for volume in voronoi_volumes(&sheared, &places).expect("volumes") {
            assert!((volume * f64::from(parts) - sheared.cell_volume()).abs() < 1e-13);
        }
    }
    let chain = LatticeKind::Chain.lattice::<1>(0.3).expect("a lattice");
    for point in Quadrature::StressPoints
        .points(&chain, &rule)
        .expect("volumes")
    {
        assert!((point.volume - 0.15).abs() < 1e-15);
    }
}

#[test]
fn coincident_or_nonfinite_points_have_no_voronoi_volumes() {
    let lattice = LatticeKind::Square.lattice::<2>(1.0).expect("a lattice");
    let twice = [
        Vector2::new(0.25, 0.5),
        Vector2::new(0.0, 0.0),
        Vector2::new(1.25, -0.5),
    ];
    assert_eq!(
        voronoi_volumes(&lattice, &twice),
        Err(LatticeError::CoincidentPoints {
            first: 0,
            second: 2
        })
    );
    let beyond = BravaisLattice::<4>::new(nalgebra::Matrix4::identity()).expect("a lattice");
    assert_eq!(
        voronoi_volumes(&beyond, &[SVector::<f64, 4>::zeros()]),
        Err(LatticeError::VoronoiDimension { dimension: 4 })
    );
}

#[test]
fn the_lattice_laplacian_is_periodic_and_tends_to_the_squared_wave_number_of_long_waves() {
    for kind in [LatticeKind::Square, LatticeKind::Hexagonal] {
        let lattice = kind.lattice::<2>(0.8).expect("a lattice");
        let k = Vector2::new(0.9, -1.7);
        for n in 0..2 {
            let moved = k + lattice.reciprocal().column(n);
            assert!((lattice.laplacian(&moved) - lattice.laplacian(&k)).abs() < 1e-12);
        }
        let metric = k.dot(&(lattice.long_wave_metric() * k));
        assert!((lattice.laplacian(&(k * 1e-4)) * 1e8 - metric).abs() < 1e-6 * metric);
        for axis in 0..2 {
            let step = Vector2::from_fn(|i, _| if i == axis { 1e-5 } else { 0.0 });
            let difference =
                (lattice.laplacian(&(k + step)) - lattice.laplacian(&(k - step))) / 2e-5;
            assert!((difference - lattice.laplacian_gradient(&k)[axis]).abs() < 1e-8);
        }
    }
}
