//! Regions around the nodes over which gradients are averaged: Voronoi cells, boxes, and the pyramids into which both are divided.

use crate::algebra::unit_interval;
use crate::lattice::Crystal;
use nalgebra::{SMatrix, SVector};

/// Largest distance from a plane at which a corner lies on it, relative to the size of the region.
const PLANE_TOLERANCE: f64 = 1e-12;

/// Flat facet of a boundary: a point, a straight edge or a convex polygon. Positions are relative to the node.
#[derive(Clone, Debug)]
pub(super) struct Facet<const D: usize> {
    /// Corners in cyclic order.
    corners: Vec<SVector<f64, D>>,
    /// Unit normal, pointing outward.
    pub(super) normal: SVector<f64, D>,
    /// Length, area or one; length^(D-1).
    measure: f64,
}

/// Region that contains the node in its interior or on its boundary.
#[derive(Clone, Debug)]
pub(super) struct Region<const D: usize> {
    pub(super) facets: Vec<Facet<D>>,
    /// Volume of the region; length^D.
    pub(super) volume: f64,
}

impl<const D: usize> Facet<D> {
    fn new(corners: Vec<SVector<f64, D>>, normal: SVector<f64, D>) -> Self {
        let measure = match D {
            1 => 1.0,
            2 => (corners[1] - corners[0]).norm(),
            _ => fan(&corners).map(|[a, b]| triangle(&a, &b)).sum(),
        };
        Self {
            corners,
            normal,
            measure,
        }
    }

    /// Points and weights of a quadrature over the facet: Gauss's rule along an edge; along both directions of the triangles between the corners and
    /// the centroid of a polygon.
    /// Exact for linear functions with any number of points, and identical for the two regions that share the facet.
    pub(super) fn points(&self, count: usize) -> Vec<(SVector<f64, D>, f64)> {
        let along = unit_interval(count);
        match D {
            1 => vec![(self.corners[0], 1.0)],
            2 => {
                let edge = self.corners[1] - self.corners[0];
                let point = |&(t, w): &(f64, f64)| (self.corners[0] + edge * t, w * self.measure);
                along.iter().map(point).collect()
            }
            _ => {
                // The area element grows linearly with the distance from the center. Gauss's one-point rule for this weight has its point at 2/3.
                let outward: Vec<(f64, f64)> = match count {
                    1 => vec![(2.0 / 3.0, 1.0)],
                    _ => along.iter().map(|(r, w)| (*r, 2.0 * r * w)).collect(),
                };
                let middle = middle(&self.corners);
                let mut points = Vec::new();
                for [a, b] in fan(&self.corners) {
                    let area = triangle(&a, &b);
                    for (r, across) in &outward {
                        for (s, w) in &along {
                            let edge = a + (b - a) * *s;
                            points.push((middle + edge * *r, area * across * w));
                        }
                    }
                }
                points
            }
        }
    }
}

impl<const D: usize> Region<D> {
    fn of(facets: Vec<Facet<D>>) -> Self {
        // The divergence of x is D.
        let flux = |facet: &Facet<D>| facet.measure * facet.normal.dot(&facet.corners[0]);
        let volume = facets.iter().map(flux).sum::<f64>() / D as f64;
        Self { facets, volume }
    }

    /// Voronoi cell of a site of a crystal.
    pub(super) fn voronoi(crystal: &Crystal<D>, site: usize) -> Self {
        let place = crystal.sites()[site];
        let mut distance = 2.0 * crystal.nearest_distance();
        loop {
            let near = crystal.within(&place, distance, &SMatrix::identity());
            let relative =
                |particle| crystal.lattice().vectors() * (crystal.place(particle) - place);
            let neighbors: Vec<SVector<f64, D>> = near.iter().skip(1).map(relative).collect();
            let facets: Vec<Facet<D>> = neighbors
                .iter()
                .filter_map(|r| bisector(r, &neighbors, distance))
                .collect();
            // Only neighbors within twice the distance of the farthest corner can have a bisector that cuts the cell.
            let corners = facets.iter().flat_map(|facet| &facet.corners);
            let farthest = corners.map(|corner| corner.norm()).fold(0.0, f64::max);
            if facets.len() > D && 2.0 * farthest < distance {
                return Self::of(facets);
            }
            distance *= 1.5;
        }
    }

    /// Box around the node with edges along the axes.
    pub(super) fn cube(volume: f64) -> Self {
        let half = 0.5 * volume.powf(1.0 / D as f64);
        let side = |axis: usize, sign: f64| {
            let mut normal = SVector::<f64, D>::zeros();
            normal[axis] = sign;
            // The corners in cyclic order, by the signs of the other axes.
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            let corner = |signs: &[f64; 2]| {
                SVector::from_fn(|i, _| match i {
                    i if i == axis => sign * half,
                    i => signs[(i + D - axis - 1) % D] * half,
                })
            };
            let corners = corners[..1 << (D - 1)].iter().map(corner).collect();
            Facet::new(corners, normal)
        };
        let facets = (0..D).flat_map(|axis| [side(axis, -1.0), side(axis, 1.0)]);
        Self::of(facets.collect())
    }

    /// Pyramids between the node and each facet: halves of a segment in 1D, triangles in 2D.
    pub(super) fn pyramids(&self) -> Vec<Self> {
        let pyramid = |base: &Facet<D>| {
            let count = base.corners.len();
            let corner = |n: usize| base.corners[n % count];
            let sides: Vec<Vec<SVector<f64, D>>> = match D {
                1 => vec![Vec::new()],
                2 => vec![vec![corner(0)], vec![corner(1)]],
                _ => (0..count).map(|n| vec![corner(n), corner(n + 1)]).collect(),
            };
            let inside = middle(&base.corners);
            let side = |edges: Vec<SVector<f64, D>>| {
                let normal = -across(&inside, &edges);
                let corners = std::iter::once(SVector::zeros()).chain(edges);
                Facet::new(corners.collect(), normal)
            };
            let facets = std::iter::once(base.clone()).chain(sides.into_iter().map(side));
            Self::of(facets.collect())
        };
        self.facets.iter().map(pyramid).collect()
    }
}

/// Facet of the cell around the origin in the bisecting plane of a neighbor, or `None` if the plane does not touch the cell.
fn bisector<const D: usize>(
    r: &SVector<f64, D>,
    neighbors: &[SVector<f64, D>],
    distance: f64,
) -> Option<Facet<D>> {
    let center = r * 0.5;
    let axes: Vec<SVector<f64, D>> = axes_across(r).into_iter().map(|e| e * distance).collect();
    let mut corners: Vec<SVector<f64, D>> = match axes[..] {
        [] => vec![center],
        [e] => vec![center - e, center + e],
        [e, f, ..] => vec![
            center - e - f,
            center + e - f,
            center + e + f,
            center - e + f,
        ],
    };
    for other in neighbors.iter().filter(|other| *other != r) {
        let rounding = PLANE_TOLERANCE * distance * other.norm();
        corners = clipped(&corners, other, 0.5 * other.norm_squared(), rounding);
    }
    let same = |a: &SVector<f64, D>, b: &SVector<f64, D>| (a - b).norm() < 1e-9 * distance;
    corners.dedup_by(|a, b| same(a, b));
    while corners.len() > 1 && same(&corners[0], &corners[corners.len() - 1]) {
        corners.pop();
    }
    (corners.len() >= D).then(|| Facet::new(corners, r.normalize()))
}

/// Part of a convex polygon, segment or point in the half space `normal . x <= offset`. Corners within `rounding` of the plane lie on it: a plane that only
/// touches an edge leaves no corner in its middle, which would move the center of the facet.
fn clipped<const D: usize>(
    corners: &[SVector<f64, D>],
    normal: &SVector<f64, D>,
    offset: f64,
    rounding: f64,
) -> Vec<SVector<f64, D>> {
    let excess = |x: &SVector<f64, D>| match normal.dot(x) - offset {
        excess if excess.abs() <= rounding => 0.0,
        excess => excess,
    };
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for (n, from) in corners.iter().enumerate() {
        let to = &corners[(n + 1) % corners.len()];
        let (start, end) = (excess(from), excess(to));
        if start <= 0.0 {
            kept.push(*from);
        }
        if (start < 0.0 && end > 0.0) || (start > 0.0 && end < 0.0) {
            kept.push(from + (to - from) * (start / (start - end)));
        }
    }
    kept
}

/// Unit vectors orthogonal to a vector and to each other.
fn axes_across<const D: usize>(r: &SVector<f64, D>) -> Vec<SVector<f64, D>> {
    let mut known = vec![*r];
    let largest = r.iamax();
    for i in (0..D).filter(|i| *i != largest) {
        let axis = SVector::from_fn(|j, _| f64::from(u8::from(i == j)));
        known.push(across(&axis, &known));
    }
    known.split_off(1)
}

/// Unit vector along the part of a vector that is orthogonal to others.
fn across<const D: usize>(x: &SVector<f64, D>, others: &[SVector<f64, D>]) -> SVector<f64, D> {
    let mut orthogonal: Vec<SVector<f64, D>> = Vec::with_capacity(others.len());
    let without = |x: &SVector<f64, D>, known: &[SVector<f64, D>]| {
        known.iter().fold(*x, |rest, e| rest - e * e.dot(&rest))
    };
    for other in others {
        let rest = without(other, &orthogonal);
        orthogonal.push(rest.normalize());
    }
    without(x, &orthogonal).normalize()
}

fn middle<const D: usize>(corners: &[SVector<f64, D>]) -> SVector<f64, D> {
    corners.iter().sum::<SVector<f64, D>>() / corners.len() as f64
}

/// Triangles between the center of a polygon and its edges, each by its two vectors from the center.
fn fan<const D: usize>(corners: &[SVector<f64, D>]) -> impl Iterator<Item = [SVector<f64, D>; 2]> {
    let middle = middle(corners);
    let corner = move |n: usize| corners[n % corners.len()] - middle;
    (0..corners.len()).map(move |n| [corner(n), corner(n + 1)])
}

/// Area of the triangle that two vectors span.
fn triangle<const D: usize>(a: &SVector<f64, D>, b: &SVector<f64, D>) -> f64 {
    let height = b - a * (a.dot(b) / a.norm_squared());
    0.5 * a.norm() * height.norm()
}

#[cfg(test)]
mod tests {
    use super::Region;
    use crate::lattice::{BravaisLattice, Crystal, LatticeKind};
    use nalgebra::{SMatrix, SVector};

    fn assert_sound<const D: usize>(crystal: &Crystal<D>, facets: &[usize]) {
        for (site, volume) in crystal.volumes().iter().enumerate() {
            let cell = Region::voronoi(crystal, site);
            let cube = Region::cube(*volume);
            if !facets.is_empty() {
                assert_eq!(cell.facets.len(), facets[site]);
            }
            for region in [&cell, &cube] {
                assert!((region.volume - volume).abs() < 1e-12);
                let parts = region.pyramids();
                let sum: f64 = parts.iter().map(|part| part.volume).sum();
                assert!((sum - volume).abs() < 1e-12);
                parts.iter().for_each(assert_closed);
                assert_closed(region);
            }
        }
    }

    /// Checks `int n dS = 0` and `int x (x) n dS = V 1` for any number of points.
    fn assert_closed<const D: usize>(region: &Region<D>) {
        for count in 1..4 {
            let (mut sum, mut moment) = (SVector::<f64, D>::zeros(), SMatrix::<f64, D, D>::zeros());
            for facet in &region.facets {
                assert!((facet.normal.norm() - 1.0).abs() < 1e-14);
                for (x, weight) in facet.points(count) {
                    assert!(weight > 0.0);
                    sum += facet.normal * weight;
                    moment += x * facet.normal.transpose() * weight;
                }
            }
            assert!(sum.amax() < 1e-13);
            let expected = SMatrix::<f64, D, D>::identity() * region.volume;
            assert!((moment - expected).amax() < 1e-13);
        }
    }

    #[test]
    fn voronoi_cells_boxes_and_their_pyramids_are_closed_and_fill_space() {
        let chain = LatticeKind::Chain.lattice::<1>(0.7).expect("a lattice");
        assert_sound(&Crystal::of_lattice(chain), &[2]);
        let square = Crystal::of_lattice(LatticeKind::Square.lattice::<2>(1.1).expect("a lattice"));
        assert_sound(&square, &[4]);
        let hexagonal = LatticeKind::Hexagonal.lattice::<2>(1.1).expect("a lattice");
        assert_sound(&Crystal::of_lattice(hexagonal), &[6]);
        assert_sound(
            &Crystal::<2>::of(LatticeKind::Honeycomb, 1.0).expect("a crystal"),
            &[3, 3],
        );
        let large = square.supercell([3, 3]).expect("a crystal");
        assert_sound(&large.perturbed(0.3, 5).expect("a crystal"), &[]);
    }

    #[test]
    fn voronoi_cells_of_cubic_lattices_are_cubes_truncated_octahedra_and_rhombic_dodecahedra() {
        let crystal = |diagonal: f64, rest: f64| {
            let vectors =
                SMatrix::<f64, 3, 3>::from_fn(|i, j| if i == j { diagonal } else { rest });
            Crystal::of_lattice(BravaisLattice::new(vectors).expect("a lattice"))
        };
        assert_sound(&crystal(1.0, 0.0), &[6]);
        assert_sound(&crystal(-0.5, 0.5), &[14]);
        assert_sound(&crystal(0.0, 0.5), &[12]);
    }

    #[test]
    fn facets_of_a_rotated_cube_have_four_corners() {
        for angle in 0..40 {
            let angle = f64::from(angle);
            let axis = nalgebra::Unit::new_normalize(nalgebra::Vector3::new(1.0, angle, 2.0));
            let turn = nalgebra::Rotation3::from_axis_angle(&axis, 0.1 + angle);
            let lattice = BravaisLattice::new(*turn.matrix()).expect("a lattice");
            let cell = Region::voronoi(&Crystal::of_lattice(lattice), 0);
            let corners: Vec<usize> = cell.facets.iter().map(|own| own.corners.len()).collect();
            assert_eq!(corners, [4; 6]);
        }
    }
}
