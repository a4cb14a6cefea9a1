//! Short primitive vectors, and the vectors of a lattice within a distance.
//!
//! Every lattice has infinitely many bases, and results must not depend on the choice of the basis. Enumeration therefore uses a short basis, for
//! which a box of lattice coordinates is only slightly larger than the enclosed ball.

use super::{BravaisLattice, Fractional, LatticeError, LatticeKind, cells_between};
use crate::algebra::{Each, array_of};
use nalgebra::{Matrix1, Matrix2, Matrix3, SMatrix, SVector};

/// Number of steps after which a basis counts as short enough. Each step shortens a vector, and few steps are needed.
const REDUCTION_STEPS: usize = 1000;
/// Relative difference of lengths and angles that counts as rounding.
const LENGTH_TOLERANCE: f64 = 1e-9;
/// Largest lattice coordinate of a short primitive vector. Beyond it the positions of particles lose their digits.
pub(super) const SHEAR_RATIO: f64 = 1e5;
/// Largest ratio of the lengths of short primitive vectors.
pub(super) const ELONGATION_RATIO: f64 = 30.0;

/// Short primitive vectors of a lattice, with their coordinates in the given basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reduced<const D: usize> {
    /// Short vectors, as columns.
    pub(crate) vectors: SMatrix<f64, D, D>,
    /// Lattice coordinates of the short vectors in the given basis, as columns: integers with determinant of magnitude one.
    pub(crate) change: SMatrix<f64, D, D>,
    /// Inverse of `change`, also integers: maps lattice coordinates in the given basis to coordinates in the short one.
    pub(crate) inverse: SMatrix<f64, D, D>,
}

impl<const D: usize> Reduced<D> {
    /// Uses the given basis itself as the short basis.
    pub(crate) fn given(vectors: &SMatrix<f64, D, D>) -> Self {
        Self {
            vectors: *vectors,
            change: SMatrix::identity(),
            inverse: SMatrix::identity(),
        }
    }

    /// Minkowski-reduced basis: no vector becomes shorter by adding a combination of the others. Unchanged if the given basis is reduced.
    ///
    /// # Errors
    /// [`LatticeError::Sheared`] if the short vectors are combinations with very large coefficients.
    pub(crate) fn of(vectors: &SMatrix<f64, D, D>) -> Result<Self, LatticeError> {
        let mut reduced = Self::given(vectors);
        for _ in 0..REDUCTION_STEPS {
            let Some((column, factors)) = shortened(&reduced.vectors) else {
                break;
            };
            reduced.subtract(column, &factors);
            let coefficient = reduced.change.amax().max(reduced.inverse.amax());
            if coefficient > SHEAR_RATIO {
                return Err(LatticeError::Sheared {
                    coefficient,
                    limit: SHEAR_RATIO,
                });
            }
        }
        Ok(reduced)
    }

    /// Reduced basis that is independent of the basis in which the lattice is given.
    ///
    /// Among equally short vectors the order is by the inclination to the diagonal `(1, 1, 1)`: vectors inclined most nearly like the
    /// axes come first. For named lattices these are the standard vectors. The given basis is returned if it differs only in order and signs.
    ///
    /// # Errors
    /// [`LatticeError`] under the conditions of [`Reduced::of`].
    pub(crate) fn canonical(vectors: &SMatrix<f64, D, D>) -> Result<Self, LatticeError> {
        let reduced = Self::of(vectors)?;
        let Some(coordinates) = chosen(&reduced.vectors) else {
            return Ok(reduced);
        };
        let change = reduced.change * coordinates;
        let is_given = change
            .column_iter()
            .all(|column| column.iter().map(|x| x.abs()).sum::<f64>() == 1.0);
        if is_given {
            return Ok(Self::given(vectors));
        }
        let Some(back) = inverse_of(&coordinates) else {
            return Ok(reduced);
        };
        Ok(Self {
            vectors: reduced.vectors * coordinates,
            change,
            inverse: back.map(f64::round) * reduced.inverse,
        })
    }

    /// Canonical basis with the order and the signs of the vectors of the named lattices.
    ///
    /// # Errors
    /// [`LatticeError`] under the conditions of [`Reduced::of`].
    pub(crate) fn unique(vectors: &SMatrix<f64, D, D>) -> Result<Self, LatticeError> {
        let reduced = Self::of(vectors)?;
        let Some(mut coordinates) = chosen(&reduced.vectors) else {
            return Ok(reduced);
        };
        let basis = reduced.vectors * coordinates;
        let spacing = basis.column(0).norm();
        for kind in [
            LatticeKind::BodyCenteredCubic,
            LatticeKind::FaceCenteredCubic,
        ] {
            let Ok(named) = kind.lattice::<D>(spacing) else {
                continue;
            };
            // Columns of the basis that equal a vector of the named lattice, or are opposite to it.
            let own = |n: usize, m: usize| {
                let (own, named) = (basis.column(n), named.vectors().column(m));
                let sign = own.dot(&named).signum();
                ((own * sign - named).norm() <= LENGTH_TOLERANCE * spacing).then_some((n, sign))
            };
            let order: Vec<(usize, f64)> = (0..D)
                .filter_map(|m| (0..D).find_map(|n| own(n, m)))
                .collect();
            if order.len() == D {
                let columns = coordinates;
                coordinates = SMatrix::from_fn(|i, m| order[m].1 * columns[(i, order[m].0)]);
            }
        }
        let Some(back) = inverse_of(&coordinates) else {
            return Ok(reduced);
        };
        Ok(Self {
            vectors: reduced.vectors * coordinates,
            change: reduced.change * coordinates,
            inverse: back.map(f64::round) * reduced.inverse,
        })
    }

    /// Returns true if the reduced basis is the given basis.
    pub(crate) fn is_given(&self) -> bool {
        self.change == SMatrix::<f64, D, D>::identity()
    }

    /// Subtracts a combination of the other vectors from one vector.
    fn subtract(&mut self, column: usize, factors: &SVector<f64, D>) {
        for n in (0..D).filter(|n| factors[*n] != 0.0) {
            let own = self.vectors.column(column) - self.vectors.column(n) * factors[n];
            self.vectors.set_column(column, &own);
            let own = self.change.column(column) - self.change.column(n) * factors[n];
            self.change.set_column(column, &own);
            let other = self.inverse.row(n) + self.inverse.row(column) * factors[n];
            self.inverse.set_row(n, &other);
        }
    }
}

/// Vector that can be shortened, with the multiples of the others to subtract.
fn shortened<const D: usize>(vectors: &SMatrix<f64, D, D>) -> Option<(usize, SVector<f64, D>)> {
    for column in 0..D {
        let own = vectors.column(column).into_owned();
        // Removes the component along another vector, or along a sum or difference of others.
        for combination in combinations::<D>().filter(|factors| factors[column] == 0.0) {
            let other = vectors * combination;
            let square = other.norm_squared();
            if square == 0.0 {
                continue;
            }
            let multiple = (own.dot(&other) / square).round();
            let shorter = own - other * multiple;
            if shorter.norm_squared() < own.norm_squared() * (1.0 - 1e-12) {
                return Some((column, combination * multiple));
            }
        }
    }
    None
}

/// All nonzero combinations with coefficients -1, 0 and 1, including opposite ones. For a Minkowski-reduced basis in up to three dimensions they
/// include all vectors that bound the Voronoi cell (Nguyen, Stehle, ACM Trans. Algorithms 5 (2009) 46).
pub(super) fn combinations<const D: usize>() -> impl Iterator<Item = SVector<f64, D>> {
    let count = 3_usize.pow(D as u32);
    let others = (0..count).filter(move |number| 2 * number + 1 != count);
    others.map(|mut number| {
        let mut combination = SVector::zeros();
        for n in 0..D {
            combination[n] = (number % 3) as f64 - 1.0;
            number /= 3;
        }
        combination
    })
}

/// Coordinates of the canonical basis in a reduced basis.
fn chosen<const D: usize>(reduced: &SMatrix<f64, D, D>) -> Option<SMatrix<f64, D, D>> {
    let candidates: Vec<(SVector<f64, D>, SVector<f64, D>)> = combinations::<D>()
        .map(|coordinates| (coordinates, reduced * coordinates))
        .filter(|(_, vector)| is_forward(vector))
        .collect();
    let mut basis = SMatrix::<f64, D, D>::zeros();
    let mut directions: Vec<SVector<f64, D>> = Vec::new();
    for column in 0..D {
        let is_free = |(_, vector): &&(SVector<f64, D>, SVector<f64, D>)| {
            let rest = directions
                .iter()
                .fold(*vector, |rest, axis| rest - axis * axis.dot(&rest));
            rest.norm() > LENGTH_TOLERANCE * vector.norm()
        };
        let (coordinates, vector) = candidates.iter().filter(is_free).reduce(|best, other| {
            if precedes(&other.1, &best.1) {
                other
            } else {
                best
            }
        })?;
        basis.set_column(column, coordinates);
        let rest = directions
            .iter()
            .fold(*vector, |rest, axis| rest - axis * axis.dot(&rest));
        directions.push(rest.normalize());
    }
    // Vectors of successive minima form a basis in up to three dimensions.
    (super::determinant(&basis).abs().round() == 1.0).then_some(basis)
}

/// Returns true for one vector of each opposite pair, which is the vector with a positive leading component.
fn is_forward<const D: usize>(vector: &SVector<f64, D>) -> bool {
    vector
        .iter()
        .find(|x| x.abs() > LENGTH_TOLERANCE * vector.norm())
        .is_some_and(|x| *x > 0.0)
}

/// Order in the selection of basis vectors.
fn precedes<const D: usize>(a: &SVector<f64, D>, b: &SVector<f64, D>) -> bool {
    // Relative deviation from an axis of the sine of the angle to the plane across the diagonal.
    let inclination = |v: &SVector<f64, D>| (v.sum().abs() / v.norm() - 1.0).abs();
    let (lengths, inclinations) = ([a, b].each(|v| v.norm()), [a, b].map(inclination));
    if (lengths[0] - lengths[1]).abs() > LENGTH_TOLERANCE * lengths[0] {
        return lengths[0] < lengths[1];
    }
    if (inclinations[0] - inclinations[1]).abs() > LENGTH_TOLERANCE {
        return inclinations[0] < inclinations[1];
    }
    let different = a
        .iter()
        .zip(b.iter())
        .find(|(x, y)| (*x - *y).abs() > LENGTH_TOLERANCE * lengths[0]);
    different.is_some_and(|(x, y)| x > y)
}

/// Inverse of a matrix; `None` if it is singular.
pub(crate) fn inverse_of<const D: usize>(m: &SMatrix<f64, D, D>) -> Option<SMatrix<f64, D, D>> {
    // Closed form in up to three dimensions, which requires a fixed dimension.
    match D {
        1 => Matrix1::from_fn(|i, j| m[(i, j)])
            .try_inverse()
            .map(|inverse| SMatrix::from_fn(|i, j| inverse[(i, j)])),
        2 => Matrix2::from_fn(|i, j| m[(i, j)])
            .try_inverse()
            .map(|inverse| SMatrix::from_fn(|i, j| inverse[(i, j)])),
        3 => Matrix3::from_fn(|i, j| m[(i, j)])
            .try_inverse()
            .map(|inverse| SMatrix::from_fn(|i, j| inverse[(i, j)])),
        _ => nalgebra::DMatrix::from_fn(D, D, |i, j| m[(i, j)])
            .try_inverse()
            .map(|inverse| SMatrix::from_fn(|i, j| inverse[(i, j)])),
    }
}

/// Lattice points in a ball, for the lattice with the columns of a matrix as primitive vectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball<const D: usize> {
    basis: Reduced<D>,
    /// Bounds of the coordinates: `|sum_i u_i a_i| < radius` implies `|u_i| < reach_i` in the short basis.
    reach: [f64; D],
    /// Ratio of the volumes of the ball and of a cell.
    volume: f64,
}

impl<const D: usize> Ball<D> {
    /// Creates a ball with a given radius.
    ///
    /// # Errors
    /// [`LatticeError::Dependent`] if the columns do not span space, [`LatticeError::Sheared`] if they are too long and nearly parallel for double
    /// precision to resolve the lattice.
    pub(crate) fn new(vectors: &SMatrix<f64, D, D>, radius: f64) -> Result<Self, LatticeError> {
        let basis = Reduced::of(vectors)?;
        let inverse = inverse_of(&basis.vectors)
            .filter(|inverse| inverse.iter().all(|x| x.is_finite()))
            .ok_or_else(|| LatticeError::Dependent {
                vectors: vectors.iter().copied().collect(),
            })?;
        let unit = [2.0, std::f64::consts::PI, 4.0 / 3.0 * std::f64::consts::PI][D - 1];
        Ok(Self {
            basis,
            reach: array_of(|i| radius * inverse.row(i).norm()),
            volume: unit * radius.powi(D as i32) / super::determinant(vectors).abs(),
        })
    }

    /// Short basis of the enumeration.
    pub(crate) fn basis(&self) -> &Reduced<D> {
        &self.basis
    }

    /// Mean number of lattice points in the ball, averaged over all centers.
    pub(crate) fn mean_count(&self) -> f64 {
        self.volume
    }

    /// Number of lattice points that the enumeration examines. It is only slightly larger than [`Ball::mean_count`] if the ball is wider than the
    /// cell.
    pub(crate) fn places(&self) -> f64 {
        self.reach.iter().map(|reach| 2.0 * reach + 1.0).product()
    }

    /// Cells whose lattice points can lie within the radius of a position; the last coordinate varies slowest.
    pub(crate) fn cells(&self, place: &Fractional<D>) -> Vec<[i32; D]> {
        let own = self.basis.inverse * place;
        let low = array_of(|i| (own[i] - self.reach[i]).floor() as i32);
        let high = array_of(|i| (own[i] + self.reach[i]).ceil() as i32);
        let mut cells = cells_between(&low, &high);
        if !self.basis.is_given() {
            for cell in &mut cells {
                let given = self.basis.change * SVector::from(cell.map(f64::from));
                *cell = array_of(|i| given[i] as i32);
            }
            cells.sort_by(|a, b| a.iter().rev().cmp(b.iter().rev()));
        }
        cells
    }
}

/// Distance within which every position has a lattice point: half the diagonal of the box with the edges of a reduced basis (Babai's nearest plane).
pub(super) fn covering_radius<const D: usize>(reduced: &SMatrix<f64, D, D>) -> f64 {
    0.5 * reduced.norm()
}

/// All differences `place + R` with lattice vectors `R` whose length does not exceed a radius.
pub(super) fn images_within<const D: usize>(
    lattice: &BravaisLattice<D>,
    ball: &Ball<D>,
    place: &Fractional<D>,
    radius: f64,
) -> Vec<SVector<f64, D>> {
    let folded = place.map(|x| x - x.round());
    let cells = ball.cells(&-folded).into_iter();
    cells
        .map(|cell| lattice.vectors() * (SVector::from(cell.map(f64::from)) + folded))
        .filter(|image| image.norm() <= radius)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{Ball, Reduced};
    use crate::lattice::{LatticeError, LatticeKind, determinant};
    use nalgebra::{Matrix2, Matrix3, SMatrix, Vector2};

    /// Integer matrix of determinant one: a product of shears.
    fn unimodular<const D: usize>(state: &mut u64, steps: usize) -> SMatrix<f64, D, D> {
        let mut next = |bound: u64| {
            *state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (*state >> 33) % bound
        };
        let mut product = SMatrix::<f64, D, D>::identity();
        for _ in 0..steps {
            let (i, j) = (next(D as u64) as usize, next(D as u64) as usize);
            let multiple = next(9) as f64 - 4.0;
            if i == j {
                product.column_mut(i).neg_mut();
            } else {
                let column = product.column(i) + product.column(j) * multiple;
                product.set_column(i, &column);
            }
        }
        product
    }

    fn same_set<const D: usize>(a: &SMatrix<f64, D, D>, b: &SMatrix<f64, D, D>) -> bool {
        a.column_iter().all(|x| {
            b.column_iter()
                .any(|y| (x - y).norm().min((x + y).norm()) < 1e-8 * x.norm())
        })
    }

    fn assert_own<const D: usize>(kind: LatticeKind, state: &mut u64) {
        let vectors = match kind {
            LatticeKind::Rectangular => kind.lattice_with::<D>(0.7, 1.3, &[]),
            _ => kind.lattice::<D>(0.7),
        };
        let vectors = *vectors.expect("a lattice").vectors();
        let own = Reduced::canonical(&vectors).expect("short vectors");
        assert!(own.is_given(), "{kind:?}");
        for steps in 0..12 {
            let other = vectors * unimodular::<D>(state, steps);
            let reduced = Reduced::canonical(&other).expect("short vectors");
            assert!(same_set(&reduced.vectors, &vectors), "{kind:?}");
            assert!((other * reduced.change - reduced.vectors).amax() < 1e-9);
            assert!((reduced.change * reduced.inverse - SMatrix::identity()).amax() == 0.0);
        }
    }

    #[test]
    fn every_basis_of_a_named_lattice_reduces_to_its_standard_vectors() {
        let mut state = 3;
        for _ in 0..20 {
            for kind in LatticeKind::ALL {
                match (kind.takes_vectors(), kind.dimension()) {
                    (true, _) | (_, 1) => {}
                    (_, 2) => assert_own::<2>(kind, &mut state),
                    _ => assert_own::<3>(kind, &mut state),
                }
            }
        }
    }

    #[test]
    fn every_basis_of_a_random_lattice_is_reduced_to_the_same_vectors() {
        let mut state = 11;
        let mut number = || {
            let columns = unimodular::<3>(&mut state, 7);
            (columns[(0, 1)] * 0.618_034 + columns[(2, 0)] * 0.414_214).fract()
        };
        for case in 0..200 {
            let vectors = Matrix3::from_fn(|i, j| number() + f64::from(u8::from(i == j)));
            if determinant(&vectors).abs() < 0.05 {
                continue;
            }
            let mut state = case;
            let other = vectors * unimodular::<3>(&mut state, 6);
            let short = Reduced::canonical(&vectors).expect("short vectors").vectors;
            let again = Reduced::canonical(&other).expect("short vectors").vectors;
            assert!(same_set(&short, &again), "{short} {again}");
        }
    }

    #[test]
    fn a_ball_has_the_same_points_in_every_basis() {
        let (short, place) = (Matrix2::new(1.0, 0.3, 0.0, 0.9), Vector2::new(0.2, 0.7));
        let mut state = 5;
        let points = |vectors: Matrix2<f64>, place: Vector2<f64>| {
            let ball = Ball::new(&vectors, 2.3).expect("a lattice");
            assert!(ball.places() < 80.0 && (ball.mean_count() - 18.46).abs() < 0.1);
            let cells = ball.cells(&place).into_iter();
            let apart =
                cells.map(|cell| (vectors * (Vector2::from(cell.map(f64::from)) - place)).norm());
            let mut near: Vec<f64> = apart.filter(|d| *d < 2.3).collect();
            near.sort_by(f64::total_cmp);
            near
        };
        let expected = points(short, place);
        for _ in 0..50 {
            let change = unimodular::<2>(&mut state, 6);
            let inverse = change.try_inverse().expect("unimodular");
            let found = points(short * change, inverse * place);
            assert_eq!(found.len(), expected.len());
            assert!(
                found
                    .iter()
                    .zip(&expected)
                    .all(|(a, b)| (a - b).abs() < 1e-8)
            );
        }
    }

    #[test]
    fn a_basis_not_resolved_in_double_precision_is_rejected() {
        for vectors in [
            Matrix2::new(6986.29, 3.0, 1e5, 1e100),
            Matrix2::new(1.0, 1e9, 0.0, 1.0),
        ] {
            let refused = Reduced::of(&vectors);
            assert!(
                matches!(refused, Err(LatticeError::Sheared { .. })),
                "{refused:?}"
            );
        }
    }
}
