//! Branch and bound over the sphere of directions, in triangles.
//!
//! A direction of the cone of `a`, `b`, `c` is `N = alpha a + beta b + gamma c` with nonnegative weights, and
//! `Q(N) - level |N|^2 = sum alpha^2 M(a, a) + ... + sum 2 alpha beta M(a, b)` with `M(a, b) = Q(a, b) - level a.b`. If these six matrices are
//! positive definite, every eigenvalue in the cone exceeds the level. The difference of `M(a, b)` from the value at the center is of second order in
//! the size of the triangle.

use super::form::Form;
use super::{Axes, dot};
use crate::algebra::{Each, array_of, is_positive_definite, symmetric_eigen};
use crate::real::Real;

/// Largest number of divisions of an octant that leaves the directions exact in floating point.
const DEPTH: usize = 24;

/// Directions of the corners of a triangle. They lie on the octahedron, whose points are exact in floating point, and are not unit vectors.
pub(crate) type Triangle = [Axes<f64>; 3];

/// Result of testing a level in the directions of a triangle, or in all directions.
pub(crate) enum Cover<Rest = ()> {
    /// All eigenvalues exceed the level.
    Above,
    /// Direction in which the eigenvalues do not exceed the level, to rounding.
    Fails(Axes<f64>),
    /// Undecided. For the sphere: the triangles that remain when the budget is exhausted.
    Open(Rest),
}

/// Faces of the octahedron that contain all directions up to sign: one if the coordinate planes are mirror planes, otherwise four.
pub(crate) fn octants(is_orthotropic: bool) -> Vec<Triangle> {
    let signs: &[[f64; 2]] = if is_orthotropic {
        &[[1.0, 1.0]]
    } else {
        &[[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]]
    };
    let face = |[x, y]: &[f64; 2]| [[*x, 0.0, 0.0], [0.0, *y, 0.0], [0.0, 0.0, 1.0]];
    signs.iter().map(face).collect()
}

/// Divides a triangle into four at the midpoints of its edges.
pub(crate) fn divided([a, b, c]: &Triangle) -> [Triangle; 4] {
    let middle = |p: &Axes<f64>, q: &Axes<f64>| array_of(|i| 0.5 * (p[i] + q[i]));
    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
    [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [bc, ca, ab]]
}

/// Tests whether a level is exceeded in all directions of the triangles. Undecided triangles are divided, one generation of equal size at a time.
pub(crate) fn cover(
    mut triangles: Vec<Triangle>,
    budget: usize,
    test: impl Fn(&Triangle) -> Cover,
) -> Cover<Vec<Triangle>> {
    let mut examined = triangles.len();
    for depth in 0.. {
        let mut open = Vec::new();
        for triangle in triangles {
            match test(&triangle) {
                Cover::Above => {}
                Cover::Open(()) => open.push(triangle),
                Cover::Fails(direction) => return Cover::Fails(direction),
            }
        }
        examined += 4 * open.len();
        if open.is_empty() {
            break;
        }
        if depth == DEPTH || examined > budget {
            return Cover::Open(open);
        }
        triangles = open.iter().flat_map(divided).collect();
    }
    Cover::Above
}

/// Matrix `Q(a, b) - level a.b` of a pair of corners.
fn lowered<R: Real>(form: &Form<R>, level: f64, a: &Axes<R>, b: &Axes<R>) -> [[R; 3]; 3] {
    let mut matrix = form.acoustic(a, b);
    let shift = dot(a, b) * level;
    for (i, row) in matrix.iter_mut().enumerate() {
        row[i] = row[i] - shift;
    }
    matrix
}

/// Tests whether the smallest eigenvalue exceeds a level in the directions of a triangle.
pub(crate) fn exceeds<R: Real>(form: &Form<R>, level: f64, triangle: &Triangle) -> Cover {
    let corners = triangle.each(|corner| corner.map(R::constant));
    let is_above =
        |m: usize, n: usize| is_positive_definite(&lowered(form, level, &corners[m], &corners[n]));
    if let Some(corner) = (0..3).find(|&m| !is_above(m, m)) {
        Cover::Fails(triangle[corner])
    } else if is_above(0, 1) && is_above(1, 2) && is_above(2, 0) {
        Cover::Above
    } else {
        Cover::Open(())
    }
}

/// Lower bound, at most `least`, of the smallest eigenvalue in the directions of some triangles: the largest level that passes in all of them.
pub(crate) fn lower_bound(form: &Form<f64>, triangles: &[Triangle], mut least: f64) -> f64 {
    for triangle in triangles {
        for (m, n) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)] {
            let (a, b) = (&triangle[m], &triangle[n]);
            let product = dot(a, b);
            if product <= 0.0 {
                return f64::NEG_INFINITY;
            }
            // Eigenvalues take longer than a test of definiteness and are computed only for the few pairs that lower the bound.
            if !is_positive_definite(&lowered(form, least, a, b)) {
                least = least.min(symmetric_eigen(&form.acoustic(a, b)).0[0] / product);
            }
        }
    }
    least
}
