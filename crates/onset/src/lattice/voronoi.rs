//! Volumes of the Voronoi cells of a periodic point set, equation (43).

use super::cell::{VoronoiCell, cell_of_sorted};
use super::reduction::{Ball, Reduced, covering_radius, images_within};
use super::{BravaisLattice, Fractional, LatticeError};
use crate::algebra::sort_by_value;
use nalgebra::SVector;

/// Returns the volume of the Voronoi cell of each point of a periodic set. The sum is the cell volume.
///
/// `points` are in lattice coordinates, one period of the set. Volumes are in length^D.
///
/// ```
/// use nalgebra::{Vector2, Vector3};
/// use onset::lattice::{LatticeKind, voronoi_volumes};
/// let lattice = LatticeKind::Square.lattice::<2>(1.0)?;
/// let volumes = voronoi_volumes(&lattice, &[Vector2::zeros(), Vector2::repeat(0.5)])?;
/// assert!((volumes[0] - 0.5).abs() < 1e-15 && (volumes[1] - 0.5).abs() < 1e-15);
/// // Cubes with their centers: truncated octahedra.
/// let lattice = LatticeKind::SimpleCubic.lattice::<3>(1.0)?;
/// let volumes = voronoi_volumes(&lattice, &[Vector3::zeros(), Vector3::repeat(0.5)])?;
/// assert!((volumes[0] - 0.5).abs() < 1e-15 && (volumes[1] - 0.5).abs() < 1e-15);
/// # Ok::<(), onset::lattice::LatticeError>(())
/// ```
///
/// # Errors
/// [`LatticeError`] beyond three dimensions or if two points coincide.
pub fn voronoi_volumes<const D: usize>(
    lattice: &BravaisLattice<D>,
    points: &[Fractional<D>],
) -> Result<Vec<f64>, LatticeError> {
    let cells = voronoi_cells(lattice, points)?;
    Ok(cells.into_iter().map(|cell| cell.volume).collect())
}

/// Voronoi cells of one period of a set, each with its point as the origin.
pub(super) fn voronoi_cells<const D: usize>(
    lattice: &BravaisLattice<D>,
    points: &[Fractional<D>],
) -> Result<Vec<VoronoiCell<D>>, LatticeError> {
    if !(1..=3).contains(&D) {
        return Err(LatticeError::VoronoiDimension { dimension: D });
    }
    for first in 0..points.len() {
        for second in first + 1..points.len() {
            let apart = (points[first] - points[second]).map(|x| x - x.round());
            if apart.amax() < 1e-12 {
                return Err(LatticeError::CoincidentPoints { first, second });
            }
        }
    }
    let short = Reduced::of(lattice.vectors())?;
    let radius = 2.0 * covering_radius(&short.vectors) * (1.0 + 1e-9);
    let ball = Ball::new(lattice.vectors(), radius)?;
    let cell = |center: &Fractional<D>| {
        let mut neighbors: Vec<SVector<f64, D>> = points
            .iter()
            .flat_map(|point| images_within(lattice, &ball, &(point - center), radius))
            .filter(|image| image.norm() > 1e-12 * radius)
            .collect();
        sort_by_value(&mut neighbors, SVector::norm_squared);
        cell_of_sorted(&neighbors)
    };
    Ok(points.iter().map(cell).collect())
}
