//! Numbering of the points of a grid over a cell of the reciprocal lattice, with the same number of points along each reciprocal vector.

use crate::algebra::Each;

/// Coordinates of a grid point; the first coordinate varies slowest.
pub(crate) fn coordinates<const D: usize>(number: usize, resolution: usize) -> [usize; D] {
    let mut rest = number;
    let mut coordinates = [0; D];
    for i in (0..D).rev() {
        coordinates[i] = rest % resolution;
        rest /= resolution;
    }
    coordinates
}

/// Index of a grid point with given coordinates.
pub(crate) fn index<const D: usize>(coordinates: [usize; D], resolution: usize) -> usize {
    coordinates
        .into_iter()
        .fold(0, |sum, j| sum * resolution + j)
}

/// Index of the grid point `-k`.
pub(crate) fn opposite<const D: usize>(number: usize, resolution: usize) -> usize {
    let own = coordinates::<D>(number, resolution);
    index(own.each(|j| (resolution - j) % resolution), resolution)
}
