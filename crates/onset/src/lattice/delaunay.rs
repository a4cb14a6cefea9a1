//! Centers of the Delaunay cells of a periodic point set.

use super::voronoi::voronoi_cells;
use super::{BravaisLattice, Fractional, LatticeError};

/// Largest difference of lattice coordinates, from each other or from a simple fraction, that counts as zero.
const PLACE_TOLERANCE: f64 = 1e-9;
/// Coordinates of symmetric centers are multiples of one divided by this number.
const DIVISIONS: f64 = 48.0;

/// Returns the centers of the Delaunay cells of a periodic set: the points with `D + 1` or more nearest points of the set.
///
/// These are the holes of the set and the corners of its Voronoi cells. Cells with a common center, like the two triangles of a rectangle or the
/// tetrahedra of a cube, count once. `places` and the result are in lattice coordinates from 0 to 1, one period each. The centers are sorted by their
/// coordinates.
///
/// ```
/// use nalgebra::Vector3;
/// use onset::lattice::{LatticeKind, delaunay_centers};
/// // Closest packing has one octahedral and two tetrahedral holes a particle.
/// let lattice = LatticeKind::FaceCenteredCubic.lattice::<3>(1.0)?;
/// let centers = delaunay_centers(&lattice, &[Vector3::zeros()])?;
/// assert_eq!(centers, [0.25, 0.5, 0.75].map(Vector3::repeat));
/// # Ok::<(), onset::lattice::LatticeError>(())
/// ```
///
/// # Errors
/// [`LatticeError`] beyond three dimensions or if two points coincide.
pub fn delaunay_centers<const D: usize>(
    lattice: &BravaisLattice<D>,
    places: &[Fractional<D>],
) -> Result<Vec<Fractional<D>>, LatticeError> {
    let to_fractional = lattice.reciprocal().transpose() / std::f64::consts::TAU;
    let mut centers: Vec<Fractional<D>> = Vec::new();
    for (place, cell) in places.iter().zip(voronoi_cells(lattice, places)?) {
        for corner in cell.corners {
            let center = (place + to_fractional * corner).map(folded);
            let is_known = |known: &Fractional<D>| {
                (known - center)
                    .iter()
                    .all(|x| (x - x.round()).abs() < PLACE_TOLERANCE)
            };
            if !centers.iter().any(is_known) {
                centers.push(center);
            }
        }
    }
    centers.sort_by(|a, b| {
        a.as_slice()
            .partial_cmp(b.as_slice())
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    Ok(centers)
}

/// Coordinate between 0 and 1, exact if it is a simple fraction by symmetry.
fn folded(x: f64) -> f64 {
    let fraction = (x * DIVISIONS).round() / DIVISIONS;
    let x = if (x - fraction).abs() < PLACE_TOLERANCE {
        fraction
    } else {
        x
    };
    x - x.floor()
}
