//! Lattice coordinates in which the forces have the same range in all directions.
//!
//! With kernels in current coordinates, the neighbors in a strongly sheared state lie at long and oblique reference vectors. Over the reference zone
//! the spectrum then varies fast in one direction and slowly in another, and a uniform grid resolves it poorly. This module maps space so that the
//! second moment of the force constants is isotropic, and chooses a short basis there. The search runs in these coordinates, and its results are
//! mapped back.

use super::{Mode, SpectrumSummary, is_shown_reversed};
use crate::algebra::hermitian_eigen;
use crate::lattice::{BravaisLattice, Reduced, determinant, inverse_of};
use nalgebra::{DMatrix, SMatrix, SVector};

/// Largest accepted ratio of the longest basis vector to the longest vector of the reduced basis. Below it the given basis is kept. A heuristic
/// value.
const LONGEST_VECTOR_RATIO: f64 = 3.0;
/// Maximum number of basis reductions. Each reduction removes most of the obliqueness that double precision resolves.
const MAXIMUM_REDUCTIONS: usize = 8;
/// Smallest ratio of the smallest to the largest eigenvalue of the second moment of the forces that is not a rounding error.
const FLAT_EXTENT_RATIO: f64 = 1e-12;

/// Linear map `x' = map x` with `|det map| = 1` to isotropic coordinates, and the change of basis.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShortRange<const D: usize> {
    pub(super) map: SMatrix<f64, D, D>,
    /// Primitive vectors of the new lattice in lattice coordinates of the given basis, as columns of integers.
    pub(super) change: SMatrix<f64, D, D>,
    /// Inverse of `change`, also of integers.
    pub(super) inverse: SMatrix<f64, D, D>,
}

impl<const D: usize> ShortRange<D> {
    /// Computes the coordinates from the vectors along which forces act (lattice coordinates) and the magnitudes of the forces.
    ///
    /// Returns `None` if the given basis is short enough, or if the forces do not span space.
    pub(super) fn of(
        lattice: &BravaisLattice<D>,
        forces: &[(SVector<f64, D>, f64)],
    ) -> Option<Self> {
        if is_plainly_short(forces) {
            return None;
        }
        let (mut change, mut inverse) = (SMatrix::identity(), SMatrix::identity());
        for _ in 0..MAXIMUM_REDUCTIONS {
            let (vectors, is_flat) = isotropic(forces, &inverse, lattice.cell_volume())?;
            let reduced = Reduced::of(&vectors).ok()?;
            let longest =
                |m: &SMatrix<f64, D, D>| m.column_iter().map(|a| a.norm()).fold(0.0, f64::max);
            let is_short = longest(&vectors) <= LONGEST_VECTOR_RATIO * longest(&reduced.vectors);
            if is_short && !is_flat {
                if change == SMatrix::<f64, D, D>::identity() {
                    return None;
                }
                let to_given = lattice.reciprocal().transpose() / std::f64::consts::TAU;
                return Some(Self {
                    map: vectors * (inverse * to_given),
                    change,
                    inverse,
                });
            }
            if reduced.is_given() {
                return None;
            }
            change *= reduced.change;
            inverse = reduced.inverse * inverse;
        }
        None
    }

    /// Returns the lattice in these coordinates.
    pub(super) fn lattice(&self, lattice: &BravaisLattice<D>) -> Option<BravaisLattice<D>> {
        lattice.in_coordinates(&self.map, &self.change)
    }

    /// Maps the result of a search in these coordinates back to the given coordinates. `folded` moves a wave vector to the reported zone.
    pub(super) fn carried_back(
        &self,
        found: &SpectrumSummary<D>,
        folded: impl Fn(&SVector<f64, D>) -> SVector<f64, D>,
    ) -> SpectrumSummary<D> {
        let back = |mode: &Mode<D>| self.mode_carried_back(mode, &folded);
        SpectrumSummary {
            softest: back(&found.softest),
            long_wave: back(&found.long_wave),
            lowest: back(&found.lowest),
            fastest_growing: back(&found.fastest_growing),
            ..*found
        }
    }

    /// Maps one mode back to the given coordinates, as in `carried_back`.
    pub(super) fn mode_carried_back(
        &self,
        mode: &Mode<D>,
        folded: impl Fn(&SVector<f64, D>) -> SVector<f64, D>,
    ) -> Mode<D> {
        let k = self.map.transpose() * mode.wave_vector;
        if mode.is_long_wave {
            return Mode {
                wave_vector: k.normalize(),
                ..*mode
            };
        }
        let k = folded(&k);
        if is_shown_reversed(&k) {
            return Mode {
                wave_vector: -k,
                polarization: mode.polarization.map(|z| z.conj()),
                ..*mode
            };
        }
        Mode {
            wave_vector: k,
            ..*mode
        }
    }
}

/// Returns true if the second moment of the forces alone shows that the given basis is short enough.
///
/// In isotropic coordinates no basis is shorter than the side of a cube with the volume of the cell. It therefore suffices that the longest given
/// vector is at most `LONGEST_VECTOR_RATIO` times this side.
fn is_plainly_short<const D: usize>(forces: &[(SVector<f64, D>, f64)]) -> bool {
    let mut extents = SMatrix::<f64, D, D>::zeros();
    for (vector, size) in forces {
        for i in 0..D {
            for j in 0..D {
                extents[(i, j)] += vector[i] * vector[j] * size;
            }
        }
    }
    // In isotropic coordinates a basis vector has the squared length `(N^-1)_ii`, and the cell has the squared volume `1 / det N`.
    let volume = determinant(&extents).powf(1.0 / D as f64);
    let is_short = |squared: f64| {
        squared * volume <= (1.0 - 1e-6) * LONGEST_VECTOR_RATIO * LONGEST_VECTOR_RATIO
    };
    inverse_of(&extents).is_some_and(|inverse| inverse.diagonal().iter().all(|x| is_short(*x)))
}

/// Primitive vectors `N^-1/2` of a cell with the given volume, in coordinates in which `N = sum |force| R (x) R` is isotropic.
///
/// The flag is true if the given vectors are so oblique that rounding hides the range of the forces.
fn isotropic<const D: usize>(
    forces: &[(SVector<f64, D>, f64)],
    inverse: &SMatrix<f64, D, D>,
    volume: f64,
) -> Option<(SMatrix<f64, D, D>, bool)> {
    let own = |(vector, size): &(SVector<f64, D>, f64)| {
        let vector = inverse * vector;
        vector * vector.transpose() * *size
    };
    let extents: SMatrix<f64, D, D> = forces.iter().map(own).sum();
    let extents = extents / extents.amax();
    let matrix = DMatrix::from_fn(D, D, |i, j| extents[(i, j)]);
    let eigen = hermitian_eigen(matrix)?;
    let largest = eigen.eigenvalues.max();
    let is_flat = eigen
        .eigenvalues
        .iter()
        .any(|x| *x <= FLAT_EXTENT_RATIO * largest);
    let root = SMatrix::<f64, D, D>::from_fn(|i, j| {
        let along = |n: usize| {
            let extent = eigen.eigenvalues[n].max(FLAT_EXTENT_RATIO * largest);
            eigen.eigenvectors[(i, n)] * eigen.eigenvectors[(j, n)] * extent.sqrt()
        };
        (0..D).map(along).sum()
    });
    // The second moment of `u = N^-1/2 c` is `N^-1/2 N N^-1/2`, the identity.
    let vectors = inverse_of(&root)?;
    let scale = (volume / determinant(&vectors).abs()).powf(1.0 / D as f64);
    (scale.is_finite() && scale > 0.0).then_some((vectors * scale, is_flat))
}
