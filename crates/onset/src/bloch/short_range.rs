//! Coordinates in which forces reach equally far in all directions.
//!
//! Kernels of current coordinates make a strongly sheared reference lattice see neighbors at large and oblique reference
//! vectors: over its zone the spectrum varies fast in one direction and slowly in another. In coordinates in which the
//! forces are isotropic, and a short basis there, the same spectrum varies as that of any lattice. What is found is carried
//! back.

use super::{Mode, SpectrumSummary, is_shown_reversed};
use crate::algebra::hermitian_eigen;
use crate::lattice::{BravaisLattice, Reduced, determinant, inverse_of};
use nalgebra::{DMatrix, SMatrix, SVector};

/// A basis is left as it is unless its longest vector is this many times as long as need be.
const OBLIQUE: f64 = 3.0;
/// Rounds of reduction: each takes most of the obliqueness away that double precision shows.
const ROUNDS: usize = 8;
/// Extents of the forces below this over the largest are rounding.
const FLAT: f64 = 1e-12;

/// Such coordinates, `x' = map x`, of determinant one in magnitude, and the basis there.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShortRange<const D: usize> {
    pub(super) map: SMatrix<f64, D, D>,
    /// The lattice coordinates of its primitive vectors in the given basis, as columns: integers.
    pub(super) change: SMatrix<f64, D, D>,
    /// The inverse, integers too.
    pub(super) inverse: SMatrix<f64, D, D>,
}

impl<const D: usize> ShortRange<D> {
    /// From lattice coordinates of the vectors along which forces act, with the sizes of these forces; none where the given
    /// basis does, or where forces do not span space.
    pub(super) fn of(
        lattice: &BravaisLattice<D>,
        forces: &[(SVector<f64, D>, f64)],
    ) -> Option<Self> {
        if is_plainly_short(forces) {
            return None;
        }
        let (mut change, mut inverse) = (SMatrix::identity(), SMatrix::identity());
        for _ in 0..ROUNDS {
            let (vectors, is_flat) = isotropic(forces, &inverse, lattice.cell_volume())?;
            let reduced = Reduced::of(&vectors).ok()?;
            let longest =
                |m: &SMatrix<f64, D, D>| m.column_iter().map(|a| a.norm()).fold(0.0, f64::max);
            let is_short = longest(&vectors) <= OBLIQUE * longest(&reduced.vectors);
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

    /// The lattice in these coordinates.
    pub(super) fn lattice(&self, lattice: &BravaisLattice<D>) -> Option<BravaisLattice<D>> {
        lattice.in_coordinates(&self.map, &self.change)
    }

    /// What a search in these coordinates has found, in the given ones; `folded` brings wave vectors to the zone that is
    /// shown.
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

    /// One mode of these.
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

/// Whether the given basis is one that does, by the extents of the forces alone: in isotropic coordinates the longest of its
/// vectors is at most `OBLIQUE` times as long as the side of a cube with the volume of the cell, and the longest of no basis is
/// shorter than that side.
fn is_plainly_short<const D: usize>(forces: &[(SVector<f64, D>, f64)]) -> bool {
    let mut extents = SMatrix::<f64, D, D>::zeros();
    for (vector, size) in forces {
        for i in 0..D {
            for j in 0..D {
                extents[(i, j)] += vector[i] * vector[j] * size;
            }
        }
    }
    // A vector of the basis has the squared length `(N^-1)_ii` there, the cell the squared volume `1 / det N`.
    let volume = determinant(&extents).powf(1.0 / D as f64);
    let is_short = |squared: f64| squared * volume <= (1.0 - 1e-6) * OBLIQUE * OBLIQUE;
    inverse_of(&extents).is_some_and(|inverse| inverse.diagonal().iter().all(|x| is_short(*x)))
}

/// Primitive vectors of a cell volume in coordinates in which `sum |force| R (x) R` is isotropic, `N^-1/2` of that sum in
/// lattice coordinates; and whether these are so oblique that rounding hides how far the forces reach.
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
    let is_flat = eigen.eigenvalues.iter().any(|x| *x <= FLAT * largest);
    let root = SMatrix::<f64, D, D>::from_fn(|i, j| {
        let along = |n: usize| {
            let extent = eigen.eigenvalues[n].max(FLAT * largest);
            eigen.eigenvectors[(i, n)] * eigen.eigenvectors[(j, n)] * extent.sqrt()
        };
        (0..D).map(along).sum()
    });
    // The extents of u = N^-1/2 c are those of c times N^-1/2 on both sides: the identity.
    let vectors = inverse_of(&root)?;
    let scale = (volume / determinant(&vectors).abs()).powf(1.0 / D as f64);
    (scale.is_finite() && scale > 0.0).then_some((vectors * scale, is_flat))
}
