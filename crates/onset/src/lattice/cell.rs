//! Voronoi cell of one point: the region that is nearer to it than to any other point.

use crate::algebra::Each;
use nalgebra::SVector;

/// Voronoi cell around the origin.
#[derive(Clone, Debug)]
pub(super) struct VoronoiCell<const D: usize> {
    /// Volume of the cell; length^D.
    pub(super) volume: f64,
    /// Corners of the cell, counterclockwise in the plane. Corners where several faces or edges meet by symmetry can occur several times.
    pub(super) corners: Vec<SVector<f64, D>>,
}

/// Largest relative length or sine of an angle that is a rounding error; lengths are relative to the length of a polygon.
const LENGTH_ROUNDING: f64 = 1e-9;
/// Number of nearest neighbors used for the first estimate of a cell.
const FIRST_NEIGHBORS: usize = 32;

/// Cell of the origin among neighbors, which must be sorted by distance and extend beyond twice the distance of the farthest corner.
pub(super) fn cell_of_sorted<const D: usize>(neighbors: &[SVector<f64, D>]) -> VoronoiCell<D> {
    let mut count = FIRST_NEIGHBORS;
    loop {
        let nearest = &neighbors[..count.min(neighbors.len())];
        let cell = cell_among(nearest);
        // A bisector that cuts the cell belongs to a neighbor within twice the distance of the farthest corner.
        let farthest = cell
            .corners
            .iter()
            .map(|corner| corner.norm())
            .fold(0.0, f64::max);
        let is_whole = nearest.len() == neighbors.len()
            || nearest
                .last()
                .is_some_and(|last| last.norm() > 2.0 * farthest);
        if is_whole {
            return cell;
        }
        count *= 2;
    }
}

/// Cell of the origin among neighbors in any order.
pub(super) fn cell_among<const D: usize>(neighbors: &[SVector<f64, D>]) -> VoronoiCell<D> {
    match D {
        1 => segment(neighbors),
        2 => polygon(neighbors),
        _ => polyhedron(neighbors),
    }
}

fn farthest_of<const D: usize>(neighbors: &[SVector<f64, D>]) -> f64 {
    neighbors.iter().map(|r| r.norm()).fold(0.0, f64::max)
}

fn segment<const D: usize>(neighbors: &[SVector<f64, D>]) -> VoronoiCell<D> {
    let nearest = |sign: f64| {
        let along = neighbors.iter().map(|r| sign * r[0]);
        along.filter(|x| *x > 0.0).fold(f64::INFINITY, f64::min)
    };
    let ends = [-0.5 * nearest(-1.0), 0.5 * nearest(1.0)];
    VoronoiCell {
        volume: ends[1] - ends[0],
        corners: ends.map(SVector::repeat).to_vec(),
    }
}

fn polygon<const D: usize>(neighbors: &[SVector<f64, D>]) -> VoronoiCell<D> {
    let mut polygon = square(farthest_of(neighbors));
    for r in neighbors {
        polygon = clipped(&polygon, [r[0], r[1]], 0.5 * r.norm_squared());
    }
    VoronoiCell {
        volume: area(&polygon),
        corners: turning(&polygon)
            .into_iter()
            .map(|p| SVector::from_fn(|i, _| p[i]))
            .collect(),
    }
}

/// Computes the cell face by face. Each face is a polygon in the bisecting plane of one neighbor. Planes that touch an edge or a corner yield
/// polygons of zero area, independent of rounding.
fn polyhedron<const D: usize>(neighbors: &[SVector<f64, D>]) -> VoronoiCell<D> {
    let mut cell = VoronoiCell {
        volume: 0.0,
        corners: Vec::new(),
    };
    let farthest = farthest_of(neighbors);
    for r in neighbors {
        let axes = across(r);
        let face = face_in_plane(r, &axes, neighbors, farthest);
        // Volume of the pyramid from the origin.
        cell.volume += area(&face) * 0.5 * r.norm() / 3.0;
        cell.corners.extend(in_3d(r, &axes, &turning(&face)));
    }
    cell
}

/// Face of the cell in the bisecting plane of a neighbor, given by its corners in cyclic order. Three dimensions.
pub(super) fn face<const D: usize>(
    r: &SVector<f64, D>,
    neighbors: &[SVector<f64, D>],
) -> Vec<SVector<f64, D>> {
    let axes = across(r);
    let polygon = face_in_plane(r, &axes, neighbors, farthest_of(neighbors));
    in_3d(r, &axes, &turning(&polygon)).collect()
}

fn face_in_plane<const D: usize>(
    r: &SVector<f64, D>,
    axes: &[SVector<f64, D>; 2],
    neighbors: &[SVector<f64, D>],
    farthest: f64,
) -> Vec<[f64; 2]> {
    let mut face = square(farthest);
    for other in neighbors.iter().filter(|other| *other != r) {
        if face.is_empty() {
            break;
        }
        // other . (r / 2 + u e + v f) <= |other|^2 / 2.
        let offset = 0.5 * other.dot(&(other - r));
        face = clipped(&face, axes.each(|axis| axis.dot(other)), offset);
    }
    face
}

fn in_3d<'a, const D: usize>(
    r: &'a SVector<f64, D>,
    axes: &'a [SVector<f64, D>; 2],
    face: &'a [[f64; 2]],
) -> impl Iterator<Item = SVector<f64, D>> + 'a {
    face.iter()
        .map(move |[u, v]| r * 0.5 + axes[0] * *u + axes[1] * *v)
}

/// Two unit vectors orthogonal to a vector and to each other, right-handed with it. Three dimensions.
fn across<const D: usize>(r: &SVector<f64, D>) -> [SVector<f64, D>; 2] {
    let cross = |a: &SVector<f64, D>, b: &SVector<f64, D>| {
        SVector::<f64, D>::from_fn(|i, _| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            a[j] * b[k] - a[k] * b[j]
        })
    };
    let smallest = r.iamin();
    let axis = SVector::from_fn(|i, _| f64::from(u8::from(i == smallest)));
    let first = cross(&axis, r).normalize();
    let second = cross(r, &first).normalize();
    [first, second]
}

/// Corners at which a polygon changes direction. Lines that coincide to rounding intersect at arbitrary points of an edge. Empty if the polygon has
/// zero area.
fn turning(polygon: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let apart = |a: [f64; 2], b: [f64; 2]| [b[0] - a[0], b[1] - a[1]];
    let length = |a: [f64; 2]| a[0].hypot(a[1]);
    let size = polygon
        .iter()
        .map(|p| length(apart(polygon[0], *p)))
        .fold(0.0, f64::max);
    let mut corners = polygon.to_vec();
    corners.dedup_by(|a, b| length(apart(*a, *b)) < LENGTH_ROUNDING * size);
    if let [first, .., last] = corners[..]
        && length(apart(first, last)) < LENGTH_ROUNDING * size
    {
        corners.pop();
    }
    let count = corners.len();
    let turns = |n: &usize| {
        let before = apart(corners[(n + count - 1) % count], corners[*n]);
        let after = apart(corners[*n], corners[(n + 1) % count]);
        before[0] * after[1] - before[1] * after[0]
            > LENGTH_ROUNDING * length(before) * length(after)
    };
    let turning: Vec<[f64; 2]> = (0..count).filter(turns).map(|n| corners[n]).collect();
    if area(&turning) > LENGTH_ROUNDING * size * size {
        turning
    } else {
        Vec::new()
    }
}

fn square(half: f64) -> Vec<[f64; 2]> {
    [[-half, -half], [half, -half], [half, half], [-half, half]].to_vec()
}

fn area(polygon: &[[f64; 2]]) -> f64 {
    let corner = |n: usize| polygon[n % polygon.len()];
    (0..polygon.len())
        .map(|n| 0.5 * (corner(n)[0] * corner(n + 1)[1] - corner(n + 1)[0] * corner(n)[1]))
        .sum()
}

/// Part of a convex polygon in the half plane `normal . x <= offset`.
fn clipped(polygon: &[[f64; 2]], normal: [f64; 2], offset: f64) -> Vec<[f64; 2]> {
    let excess = |p: [f64; 2]| normal[0] * p[0] + normal[1] * p[1] - offset;
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for n in 0..polygon.len() {
        let (from, to) = (polygon[n], polygon[(n + 1) % polygon.len()]);
        let (start, end) = (excess(from), excess(to));
        if start <= 0.0 {
            kept.push(from);
        }
        if (start < 0.0 && end > 0.0) || (start > 0.0 && end < 0.0) {
            let t = start / (start - end);
            kept.push([
                from[0] + t * (to[0] - from[0]),
                from[1] + t * (to[1] - from[1]),
            ]);
        }
    }
    kept
}
