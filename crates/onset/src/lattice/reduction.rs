//! Short primitive vectors, and the vectors of a lattice within a distance.

use super::BravaisLattice;
use nalgebra::{SMatrix, SVector};

/// Steps after which a basis counts as short enough; each shortens a vector, and few are needed.
const STEPS: usize = 1000;

/// Short primitive vectors of the same lattice, as columns: none becomes shorter by a combination of the others with
/// coefficients up to one in magnitude.
pub(super) fn reduced<const D: usize>(lattice: &BravaisLattice<D>) -> SMatrix<f64, D, D> {
    let mut vectors = *lattice.vectors();
    for _ in 0..STEPS {
        let Some((column, shorter)) = shortened(&vectors) else {
            break;
        };
        vectors.set_column(column, &shorter);
    }
    vectors
}

/// A vector that can be replaced by a shorter one.
fn shortened<const D: usize>(vectors: &SMatrix<f64, D, D>) -> Option<(usize, SVector<f64, D>)> {
    for column in 0..D {
        let own = vectors.column(column).into_owned();
        // Without what is along another vector, or along a sum or difference of others.
        for combination in 1..3_usize.pow(D as u32) {
            let coefficient = |n: usize| (combination / 3_usize.pow(n as u32) % 3) as f64 - 1.0;
            if coefficient(column) != 0.0 {
                continue;
            }
            let other: SVector<f64, D> = (0..D).map(|n| vectors.column(n) * coefficient(n)).sum();
            let square = other.norm_squared();
            if square == 0.0 {
                continue;
            }
            let shorter = own - other * (own.dot(&other) / square).round();
            if shorter.norm_squared() < own.norm_squared() * (1.0 - 1e-12) {
                return Some((column, shorter));
            }
        }
    }
    None
}

/// A distance within which every place has a lattice point: half of the diagonal of the box with the edges of a reduced
/// basis (Babai's nearest plane).
pub(super) fn covering_radius<const D: usize>(reduced: &SMatrix<f64, D, D>) -> f64 {
    0.5 * reduced.norm()
}

/// The differences `place + R` of all lattice vectors `R` that are not longer than a radius.
pub(super) fn images_within<const D: usize>(
    reduced: &BravaisLattice<D>,
    place: &SVector<f64, D>,
    radius: f64,
) -> Vec<SVector<f64, D>> {
    let cycles = reduced.reciprocal().transpose() * place / std::f64::consts::TAU;
    let folded = cycles.map(|x| x - x.round());
    // |sum_i (n_i + f_i) a_i| <= radius bounds |n_i + f_i| by radius |b_i| / (2 pi).
    let reach: [f64; D] = std::array::from_fn(|i| {
        radius * reduced.reciprocal().column(i).norm() / std::f64::consts::TAU
    });
    let low: [i64; D] = std::array::from_fn(|i| (-reach[i] - folded[i]).floor() as i64);
    let high: [i64; D] = std::array::from_fn(|i| (reach[i] - folded[i]).ceil() as i64);
    let mut images = Vec::new();
    let mut cell = low;
    loop {
        let shifted = SVector::<f64, D>::from_fn(|i, _| cell[i] as f64 + folded[i]);
        let image = reduced.vectors() * shifted;
        if image.norm() <= radius {
            images.push(image);
        }
        let Some(axis) = (0..D).find(|&i| cell[i] < high[i]) else {
            return images;
        };
        cell[..axis].copy_from_slice(&low[..axis]);
        cell[axis] += 1;
    }
}
