//! Second moments of the Voronoi cell of a lattice point.

use crate::algebra::array_of;
use crate::lattice::{BravaisLattice, determinant};
use nalgebra::{SMatrix, SVector};

/// Largest distance from a bisector, in units of the lattice size, of corners that lie on it.
const PLANE_TOLERANCE: f64 = 1e-10;

/// Returns the second moments `M_jl`, integrals of `x_j x_l` over the Voronoi cell around a lattice point; length^(D+2).
///
/// The cell is divided into simplices with one corner at the lattice point. Over each simplex
/// `M = V / ((D + 1)(D + 2)) (sum_c v_c (x) v_c + s (x) s)`, `s = sum_c v_c`.
///
/// ```
/// use onset::lattice::LatticeKind;
/// use onset::quadrature::second_moments;
/// let square = second_moments(&LatticeKind::Square.lattice::<2>(2.0)?);
/// assert!((square[(0, 0)] - 16.0 / 12.0).abs() < 1e-14 && square[(0, 1)].abs() < 1e-14);
/// # Ok::<(), onset::lattice::LatticeError>(())
/// ```
pub fn second_moments<const D: usize>(lattice: &BravaisLattice<D>) -> SMatrix<f64, D, D> {
    let factorial = [1.0, 2.0, 6.0][D - 1];
    let neighbors = neighbors(lattice);
    let of_simplex = |corners: SMatrix<f64, D, D>| {
        let volume = determinant(&corners).abs() / factorial;
        let sum = corners.column_sum();
        (corners * corners.transpose() + sum * sum.transpose())
            * (volume / ((D + 1) * (D + 2)) as f64)
    };
    neighbors
        .iter()
        .flat_map(|neighbor| face(neighbor, &neighbors))
        .map(of_simplex)
        .sum()
}

/// All lattice vectors whose bisectors can bound the cell.
fn neighbors<const D: usize>(lattice: &BravaisLattice<D>) -> Vec<SVector<f64, D>> {
    // The cell lies within half of the longest diagonal. A bisector that cuts it belongs to a point within twice this distance.
    let diagonal: f64 = lattice.vectors().column_iter().map(|a| a.norm()).sum();
    let reach: [i64; D] = array_of(|i| {
        let distance_of_planes = std::f64::consts::TAU / lattice.reciprocal().column(i).norm();
        (diagonal / distance_of_planes).ceil() as i64
    });
    let count: i64 = reach.iter().map(|r| 2 * r + 1).product();
    let vector = |mut n: i64| {
        let coordinates = SVector::<f64, D>::from_fn(|i, _| {
            let side = 2 * reach[i] + 1;
            let coordinate = n % side - reach[i];
            n /= side;
            coordinate as f64
        });
        lattice.vectors() * coordinates
    };
    (0..count)
        .map(vector)
        .filter(|r| r.norm() > 0.0 && r.norm() <= diagonal * (1.0 + PLANE_TOLERANCE))
        .collect()
}

/// Face of the cell in the bisector of one neighbor, as simplices: a point, a segment, triangles.
fn face<const D: usize>(
    neighbor: &SVector<f64, D>,
    neighbors: &[SVector<f64, D>],
) -> Vec<SMatrix<f64, D, D>> {
    let middle = neighbor * 0.5;
    let size = neighbors.iter().map(|r| r.norm()).fold(0.0, f64::max);
    let along = tangents(neighbor);
    let corner = |signs: &[f64]| {
        let tangents = along.iter().zip(signs);
        tangents.fold(middle, |sum, (t, sign)| sum + t * (sign * size))
    };
    let mut corners: Vec<SVector<f64, D>> = match D {
        1 => vec![middle],
        2 => [[-1.0], [1.0]].iter().map(|s| corner(s)).collect(),
        _ => [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
            .iter()
            .map(|s| corner(s))
            .collect(),
    };
    for other in neighbors {
        if (other - neighbor).norm() > PLANE_TOLERANCE * size {
            corners = clipped(&corners, other, PLANE_TOLERANCE * size * size);
        }
    }
    if corners.len() < D {
        return Vec::new();
    }
    // A fan from the first corner; in one and two dimensions the face is one simplex.
    (D - 1..corners.len().max(D))
        .map(|last| {
            SMatrix::from_fn(|i, c| match c {
                0 => corners[0][i],
                c => corners[last + 1 + c - D][i],
            })
        })
        .collect()
}

/// Unit vectors that span the space perpendicular to a vector.
fn tangents<const D: usize>(normal: &SVector<f64, D>) -> Vec<SVector<f64, D>> {
    let mut spanned = vec![normal.normalize()];
    let mut axes: Vec<usize> = (0..D).collect();
    axes.sort_by(|&a, &b| normal[a].abs().total_cmp(&normal[b].abs()));
    for &axis in &axes[..D - 1] {
        let mut tangent = SVector::from_fn(|i, _| f64::from(u8::from(i == axis)));
        for known in &spanned {
            tangent -= known * known.dot(&tangent);
        }
        spanned.push(tangent.normalize());
    }
    spanned.split_off(1)
}

/// Part of a convex face that is closer to the origin than to a neighbor.
fn clipped<const D: usize>(
    corners: &[SVector<f64, D>],
    neighbor: &SVector<f64, D>,
    tolerance: f64,
) -> Vec<SVector<f64, D>> {
    let excess = |x: &SVector<f64, D>| x.dot(neighbor) - 0.5 * neighbor.norm_squared();
    let is_in = |x: &SVector<f64, D>| excess(x) <= tolerance;
    let mut left = Vec::new();
    for (n, from) in corners.iter().enumerate() {
        if is_in(from) {
            left.push(*from);
        }
        // A segment has one edge, a polygon one for each corner.
        let is_edge = D == 3 || n + 1 < corners.len();
        let to = &corners[(n + 1) % corners.len()];
        if is_edge && is_in(from) != is_in(to) {
            let (a, b) = (excess(from), excess(to));
            left.push(from + (to - from) * (a / (a - b)));
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::{determinant, face, neighbors, second_moments};
    use crate::lattice::BravaisLattice;
    use nalgebra::{Matrix1, Matrix2, Matrix3, SMatrix, SVector};

    fn lattice<const D: usize>(vectors: SMatrix<f64, D, D>) -> BravaisLattice<D> {
        BravaisLattice::new(vectors).expect("independent vectors")
    }

    /// Conway and Sloane's dimensionless second moment, `1/D tr M / V^(1 + 2/D)`.
    fn dimensionless<const D: usize>(lattice: &BravaisLattice<D>) -> f64 {
        let volume = lattice.cell_volume();
        second_moments(lattice).trace() / (D as f64 * volume.powf(1.0 + 2.0 / D as f64))
    }

    #[test]
    fn second_moments_of_known_cells_have_published_values() {
        let cubic = 1.0 / 12.0;
        assert!((dimensionless(&lattice(Matrix1::new(0.7))) - cubic).abs() < 1e-14);
        assert!((dimensionless(&lattice(Matrix2::identity() * 3.0)) - cubic).abs() < 1e-14);
        assert!((dimensionless(&lattice(Matrix3::identity() * 0.2)) - cubic).abs() < 1e-14);
        let hexagon = Matrix2::new(1.0, 0.5, 0.0, 0.75_f64.sqrt());
        let expected = 5.0 / (36.0 * 3.0_f64.sqrt());
        assert!((dimensionless(&lattice(hexagon)) - expected).abs() < 1e-14);
        // Conway and Sloane, Sphere Packings, Lattices and Groups, chapter 21: rhombic dodecahedron and truncated octahedron.
        let face_centered = Matrix3::new(0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0);
        let expected = 2.0_f64.powf(-11.0 / 3.0);
        assert!((dimensionless(&lattice(face_centered)) - expected).abs() < 1e-12);
        let body_centered = Matrix3::new(-1.0, 1.0, 1.0, 1.0, -1.0, 1.0, 1.0, 1.0, -1.0);
        let expected = 19.0 / (192.0 * 2.0_f64.cbrt());
        assert!((dimensionless(&lattice(body_centered)) - expected).abs() < 1e-12);
    }

    #[test]
    fn second_moments_of_a_box_follow_from_its_sides() {
        let moments = second_moments(&lattice(Matrix3::from_diagonal(&[1.0, 2.0, 0.5].into())));
        for (i, side) in [1.0_f64, 2.0, 0.5].into_iter().enumerate() {
            assert!((moments[(i, i)] - side * side / 12.0).abs() < 1e-13);
        }
        assert!(moments[(0, 1)].abs() < 1e-14);
    }

    #[test]
    fn simplices_fill_an_oblique_cell_and_second_moments_do_not_depend_on_the_basis() {
        let oblique = Matrix3::new(1.0, 0.3, 0.2, 0.0, 0.9, -0.4, 0.1, 0.0, 1.2);
        let cell = lattice(oblique);
        let all = neighbors(&cell);
        let volume: f64 = all
            .iter()
            .flat_map(|r| face(r, &all))
            .map(|corners| determinant(&corners).abs() / 6.0)
            .sum();
        assert!((volume - cell.cell_volume()).abs() < 1e-12);
        let turned = oblique * Matrix3::new(1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 1.0);
        let difference = second_moments(&lattice(turned)) - second_moments(&cell);
        assert!(difference.amax() < 1e-12);
    }

    /// The definition: the mean square over the primitive cell of the distance to the nearest lattice point.
    #[test]
    fn second_moments_are_mean_squares_of_the_vector_from_the_nearest_lattice_point() {
        let cell = lattice(Matrix2::new(1.0, 0.35, 0.1, 0.8));
        let near = neighbors(&cell);
        let side = 400;
        let mut sum = Matrix2::zeros();
        for n in 0..side * side {
            let place = SVector::<f64, 2>::new((n % side) as f64, (n / side) as f64);
            let x = cell.vectors() * ((place.add_scalar(0.5)) / f64::from(side));
            let nearest = near.iter().map(|r| x - r).fold(x, |best, left| {
                if left.norm() < best.norm() {
                    left
                } else {
                    best
                }
            });
            sum += nearest * nearest.transpose();
        }
        let mean = sum * (cell.cell_volume() / f64::from(side * side));
        assert!((mean - second_moments(&cell)).amax() < 2e-5, "{mean}");
    }
}
