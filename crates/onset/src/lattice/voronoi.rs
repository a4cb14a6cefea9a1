//! Volumes of the Voronoi cells of a periodic point set, equation (43).

use super::{BravaisLattice, Fractional, LatticeError};
use nalgebra::SVector;

/// The volume of the Voronoi cell of each point of a periodic set; their sum is the cell volume.
///
/// `points` in lattice coordinates, one period of the set. Volumes in length^D.
///
/// ```
/// use nalgebra::Vector2;
/// use onset::lattice::{Arrangement, voronoi_volumes};
/// let lattice = Arrangement::Square.lattice::<2>(1.0)?;
/// let volumes = voronoi_volumes(&lattice, &[Vector2::zeros(), Vector2::repeat(0.5)])?;
/// assert!((volumes[0] - 0.5).abs() < 1e-15 && (volumes[1] - 0.5).abs() < 1e-15);
/// # Ok::<(), onset::lattice::LatticeError>(())
/// ```
///
/// # Errors
/// [`LatticeError`] in three dimensions or when two points coincide.
pub fn voronoi_volumes<const D: usize>(
    lattice: &BravaisLattice<D>,
    points: &[Fractional<D>],
) -> Result<Vec<f64>, LatticeError> {
    let positions: Vec<SVector<f64, D>> = points.iter().map(|p| lattice.vectors() * p).collect();
    for first in 0..points.len() {
        for second in first + 1..points.len() {
            let apart = (points[first] - points[second]).map(|x| x - x.round());
            if apart.amax() < 1e-12 {
                return Err(LatticeError::CoincidentPoints { first, second });
            }
        }
    }
    let neighbors = |center: usize| relative_images(lattice, &positions, center);
    let volume: fn(&[SVector<f64, D>]) -> f64 = match D {
        1 => cell_length,
        2 => cell_area,
        dimension => return Err(LatticeError::VoronoiDimension { dimension }),
    };
    Ok((0..points.len())
        .map(|center| volume(&neighbors(center)))
        .collect())
}

/// The vectors from one point to all others and their images near enough to shape its cell.
fn relative_images<const D: usize>(
    lattice: &BravaisLattice<D>,
    positions: &[SVector<f64, D>],
    center: usize,
) -> Vec<SVector<f64, D>> {
    // The cell lies within half of the longest cell diagonal around its point, and a bisector that
    // cuts it belongs to a point within twice that distance.
    let diagonal: f64 = lattice.vectors().column_iter().map(|a| a.norm()).sum();
    let reach: [i64; D] = std::array::from_fn(|i| {
        let spacing_of_planes = std::f64::consts::TAU / lattice.reciprocal().column(i).norm();
        (2.0 * diagonal / spacing_of_planes).ceil() as i64 + 1
    });
    let mut images = Vec::new();
    let mut cell = reach.map(|r| -r);
    loop {
        let shift = lattice.vectors() * SVector::<f64, D>::from_fn(|i, _| cell[i] as f64);
        for position in positions {
            let relative = position + shift - positions[center];
            if relative.norm() > 1e-12 * diagonal {
                images.push(relative);
            }
        }
        let Some(axis) = (0..D).find(|&i| cell[i] < reach[i]) else {
            return images;
        };
        for lower in 0..axis {
            cell[lower] = -reach[lower];
        }
        cell[axis] += 1;
    }
}

fn cell_length<const D: usize>(neighbors: &[SVector<f64, D>]) -> f64 {
    let nearest = |sign: f64| {
        neighbors
            .iter()
            .map(|r| sign * r[0])
            .filter(|&x| x > 0.0)
            .fold(f64::INFINITY, f64::min)
    };
    0.5 * (nearest(1.0) + nearest(-1.0))
}

fn cell_area<const D: usize>(neighbors: &[SVector<f64, D>]) -> f64 {
    let farthest = neighbors.iter().map(|r| r.norm()).fold(0.0, f64::max);
    let mut polygon: Vec<[f64; 2]> = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|p| p.map(|x| x * farthest))
        .to_vec();
    for r in neighbors {
        polygon = super::zone::clipped(&polygon, [r[0], r[1]], 0.5 * r.norm_squared());
    }
    let corner = |n: usize| polygon[n % polygon.len()];
    (0..polygon.len())
        .map(|n| 0.5 * (corner(n)[0] * corner(n + 1)[1] - corner(n + 1)[0] * corner(n)[1]))
        .sum()
}
