//! Recognizes the named lattice of a lattice, independent of its basis.

use super::symmetry::bases_with;
use super::{BravaisLattice, LatticeKind, Reduced, determinant};
use crate::algebra::{array_of, sort_by_value};
use nalgebra::SMatrix;

/// Difference of lengths and angles that counts as rounding, relative to the longest vector squared.
const LENGTH_TOLERANCE: f64 = 1e-9;

impl<const D: usize> BravaisLattice<D> {
    /// Named lattice of the same shape, up to rotation and size, with the basis in which the points of its zone have their names.
    ///
    /// The given basis is returned if it has this shape, otherwise a basis of short vectors sorted by length.
    pub(crate) fn shape(&self) -> (LatticeKind, SMatrix<f64, D, D>) {
        let own = *self.vectors();
        let short = Reduced::canonical(&own).map_or(own, |reduced| reduced.vectors);
        let metric = short.transpose() * short;
        let squares: [f64; D] = array_of(|i| metric[(i, i)]);
        let least = squares.iter().copied().fold(f64::INFINITY, f64::min);
        let is_equal = |a: f64, b: f64| (a - b).abs() <= LENGTH_TOLERANCE * metric.amax();
        let fitting = |metric: SMatrix<f64, D, D>| {
            let given = own.transpose() * own - metric;
            match given.amax() <= LENGTH_TOLERANCE * metric.amax() {
                true => Some(own),
                false => bases_with(&short, &metric).into_iter().next(),
            }
        };
        let fixed: &[LatticeKind] = match D {
            1 => return (LatticeKind::Chain, own),
            2 => &[LatticeKind::Square, LatticeKind::Hexagonal],
            _ => &[
                LatticeKind::SimpleCubic,
                LatticeKind::BodyCenteredCubic,
                LatticeKind::FaceCenteredCubic,
            ],
        };
        for kind in fixed {
            let named = kind.lattice::<D>(least.sqrt());
            let metric = named.map(|named| named.vectors().transpose() * named.vectors());
            if let Some(basis) = metric.ok().and_then(fitting) {
                return (*kind, basis);
            }
        }
        // Triangular prisms: two equal vectors at sixty degrees and one normal to them.
        for axis in (0..D).filter(|_| D == 3) {
            let side = squares[(axis + 1) % D];
            let prism = SMatrix::from_fn(|i, j| match (i, j) {
                (2, 2) => squares[axis],
                (2, _) | (_, 2) => 0.0,
                _ if i == j => side,
                _ => 0.5 * side,
            });
            if let Some(basis) = fitting(prism) {
                return (LatticeKind::HexagonalClosePacked, basis);
            }
        }
        let mut columns: Vec<_> = short.column_iter().map(|own| own.into_owned()).collect();
        sort_by_value(&mut columns, |own| own.norm_squared());
        // Choose signs so that the angles are acute if possible.
        let is_obtuse = |a: f64| a < 0.0 && !is_equal(a, 0.0);
        for n in 1..D {
            let others = (0..n).map(|m| columns[m].dot(&columns[n]));
            let first = others.into_iter().find(|product| !is_equal(*product, 0.0));
            if first.is_some_and(is_obtuse) {
                columns[n] = -columns[n];
            }
        }
        let basis = SMatrix::from_fn(|i, j| columns[j][i]);
        let is_orthogonal = D == 2 && is_equal(determinant(&metric), squares.iter().product());
        let kind = match (D, is_orthogonal) {
            (2, true) => LatticeKind::Rectangular,
            (2, false) => LatticeKind::Oblique,
            _ => LatticeKind::Triclinic,
        };
        (kind, basis)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Rotation2, Rotation3, Vector3};

    #[test]
    fn a_lattice_has_its_name_in_every_basis_and_orientation() {
        let turn = *Rotation2::new(0.4).matrix();
        for (kind, expected) in [
            (LatticeKind::Square, LatticeKind::Square),
            (LatticeKind::Hexagonal, LatticeKind::Hexagonal),
            (LatticeKind::Honeycomb, LatticeKind::Hexagonal),
        ] {
            let own = *kind.lattice::<2>(1.3).expect("a lattice").vectors();
            for change in [
                Matrix2::identity(),
                Matrix2::new(1.0, 2.0, 1.0, 3.0),
                Matrix2::new(0.0, 1.0, 1.0, 0.0),
            ] {
                let lattice = BravaisLattice::new(turn * own * change).expect("a lattice");
                let (named, basis) = lattice.shape();
                assert_eq!(named, expected);
                assert!((basis.transpose() * basis - own.transpose() * own).amax() < 1e-9);
            }
        }
        for (aspect, expected) in [
            (1.0, LatticeKind::Square),
            (1.4, LatticeKind::Rectangular),
            (0.7, LatticeKind::Rectangular),
        ] {
            let lattice = LatticeKind::Rectangular
                .lattice_with::<2>(1.0, aspect, &[])
                .expect("a lattice");
            let (named, basis) = lattice.shape();
            assert_eq!(named, expected);
            assert!(basis.column(0).norm() <= basis.column(1).norm());
        }
        let turn = *Rotation3::new(Vector3::new(0.3, -0.5, 0.9)).matrix();
        for (kind, expected) in [
            (LatticeKind::SimpleCubic, LatticeKind::SimpleCubic),
            (
                LatticeKind::BodyCenteredCubic,
                LatticeKind::BodyCenteredCubic,
            ),
            (
                LatticeKind::FaceCenteredCubic,
                LatticeKind::FaceCenteredCubic,
            ),
            (LatticeKind::Diamond, LatticeKind::FaceCenteredCubic),
            (
                LatticeKind::HexagonalClosePacked,
                LatticeKind::HexagonalClosePacked,
            ),
        ] {
            let lattice = kind.lattice::<3>(1.0).expect("a lattice");
            assert_eq!(lattice.shape(), (expected, *lattice.vectors()));
            let turned = BravaisLattice::new(turn * lattice.vectors()).expect("a lattice");
            assert_eq!(turned.shape().0, expected);
        }
    }
}
