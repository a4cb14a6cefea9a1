//! The rotations and reflections that map a lattice onto itself.

use super::reduction::combinations;
use super::{BravaisLattice, Reduced, inverse_of};
use crate::algebra::sort_by_value;
use nalgebra::{SMatrix, SVector};

/// Lengths and angles that differ by less, relative to the longest vector squared, are equal but for rounding.
const EQUAL: f64 = 1e-9;

impl<const D: usize> BravaisLattice<D> {
    /// Halves of the reciprocal vectors, each once: the waves in which neighbors move oppositely, which what is symmetric about its points
    /// does not see. 1/length.
    pub(crate) fn alternating(&self) -> impl Iterator<Item = SVector<f64, D>> {
        let reciprocal = *self.reciprocal();
        (1..1_usize << D).map(move |bits| {
            reciprocal * SVector::from_fn(|i, _| 0.5 * f64::from(u8::from(bits >> i & 1 == 1)))
        })
    }

    /// The holohedry of the lattice: all orthogonal maps `R` that take every lattice vector to a lattice vector, the identity first. They
    /// map the reciprocal lattice onto itself too, so that `R k` is defined for wave vectors.
    ///
    /// Between Minkowski-reduced bases all coordinates are -1, 0 or 1 in up to three dimensions, which leaves finitely many maps to try.
    ///
    /// ```
    /// use onset::lattice::LatticeKind;
    /// assert_eq!(LatticeKind::Square.lattice::<2>(1.0)?.holohedry().len(), 8);
    /// assert_eq!(LatticeKind::Hexagonal.lattice::<2>(1.0)?.holohedry().len(), 12);
    /// assert_eq!(LatticeKind::FaceCenteredCubic.lattice::<3>(1.0)?.holohedry().len(), 48);
    /// # Ok::<(), onset::lattice::LatticeError>(())
    /// ```
    pub fn holohedry(&self) -> Vec<SMatrix<f64, D, D>> {
        let identity = SMatrix::identity();
        let short = Reduced::of(self.vectors()).map_or(*self.vectors(), |reduced| reduced.vectors);
        let Some(inverse) = inverse_of(&short) else {
            return vec![identity];
        };
        let metric = short.transpose() * short;
        let equal = |a: f64, b: f64| (a - b).abs() <= EQUAL * metric.amax();
        // Image after image of the primitive vectors, with the lengths and angles that they have.
        let mut images: Vec<Vec<SVector<f64, D>>> = vec![Vec::new()];
        for column in 0..D {
            let candidates: Vec<SVector<f64, D>> = combinations()
                .map(|factors| short * factors)
                .filter(|vector| equal(vector.norm_squared(), metric[(column, column)]))
                .collect();
            images = images
                .iter()
                .flat_map(|known| {
                    let fits = |vector: &&SVector<f64, D>| {
                        let mut before = known.iter().enumerate();
                        before.all(|(n, other)| equal(vector.dot(other), metric[(n, column)]))
                    };
                    let longer = |vector: &SVector<f64, D>| {
                        known.iter().chain([vector]).copied().collect::<Vec<_>>()
                    };
                    candidates
                        .iter()
                        .filter(fits)
                        .map(longer)
                        .collect::<Vec<_>>()
                })
                .collect();
        }
        let map = |image: &Vec<SVector<f64, D>>| {
            SMatrix::from_fn(|i, j| (0..D).map(|n| image[n][i] * inverse[(n, j)]).sum())
        };
        let mut maps: Vec<SMatrix<f64, D, D>> = images.iter().map(map).collect();
        sort_by_value(&mut maps, |map| (map - identity).norm());
        maps
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::LatticeKind;

    fn is_group<const D: usize>(lattice: &BravaisLattice<D>, order: usize) {
        let maps = lattice.holohedry();
        assert_eq!(maps.len(), order);
        let is_in = |m: &SMatrix<f64, D, D>| maps.iter().any(|other| (other - m).amax() < 1e-9);
        for a in &maps {
            assert!((a.transpose() * a - SMatrix::identity()).amax() < 1e-9);
            assert!(maps.iter().all(|b| is_in(&(a * b))), "not closed");
            // Lattice vectors stay lattice vectors.
            let moved = lattice.reciprocal().transpose() * a * lattice.vectors();
            let coordinates = moved / std::f64::consts::TAU;
            assert!((coordinates - coordinates.map(f64::round)).amax() < 1e-9);
        }
    }

    #[test]
    fn the_holohedry_of_each_lattice_is_a_group_of_the_known_order() {
        is_group(&LatticeKind::Chain.lattice::<1>(1.0).unwrap(), 2);
        for (kind, order) in [
            (LatticeKind::Square, 8),
            (LatticeKind::Hexagonal, 12),
            (LatticeKind::Honeycomb, 12),
        ] {
            is_group(&kind.lattice::<2>(0.7).unwrap(), order);
        }
        let rectangles = LatticeKind::Rectangular.lattice_with::<2>(1.0, 1.3, &[]);
        is_group(&rectangles.unwrap(), 4);
        let oblique = LatticeKind::Oblique.lattice_with::<2>(1.0, 1.0, &[1.0, 0.0, 2.3, 1.1]);
        is_group(&oblique.unwrap(), 2);
        for (kind, order) in [
            (LatticeKind::SimpleCubic, 48),
            (LatticeKind::BodyCenteredCubic, 48),
            (LatticeKind::FaceCenteredCubic, 48),
            (LatticeKind::Diamond, 48),
            (LatticeKind::HexagonalClosePacked, 24),
        ] {
            is_group(&kind.lattice::<3>(1.0).unwrap(), order);
        }
        let skewed = [1.0, 0.0, 0.0, 0.2, 1.1, 0.0, 0.3, 0.4, 0.9];
        let triclinic = LatticeKind::Triclinic.lattice_with::<3>(1.0, 1.0, &skewed);
        is_group(&triclinic.unwrap(), 2);
    }

    #[test]
    fn a_basis_of_long_vectors_describes_the_same_symmetry() {
        let square = BravaisLattice::<2>::new(SMatrix::from_row_slice(&[1.0, 7.0, 0.0, 1.0]));
        is_group(&square.unwrap(), 8);
    }
}
