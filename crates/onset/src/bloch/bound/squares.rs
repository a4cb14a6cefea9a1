//! When a matrix polynomial of second order is positive definite on a box: a mean of positive definite matrices, or a sum of squares.

use crate::algebra::{Complex, array_of, hermitian_eigen};
use nalgebra::{DMatrix, DVector};

/// Of a stiff vector as much of its value goes to its slopes as these shares of what couples it with others, linear and of second
/// order. With more, less is left of the value itself, against which soft vectors relax; with less, what couples slopes is not covered.
/// Tried on boxes of which an optimal sum of squares was known.
const LINEAR: f64 = 0.1;
const ROOT: f64 = 0.2;
/// Of a stiff vector so much of its value goes to its slopes, which are zero where nothing is coupled with them.
const SLACK: f64 = 1e-7;

/// `G(u) = A + sum_a u_a B_a + sum_{a<b} u_a u_b C_ab + sum_a u_a^2 X_a` for `|u_a| <= 1`, with Hermitian matrices.
pub(super) struct Quadratic<const D: usize> {
    pub(super) constant: DMatrix<Complex>,
    pub(super) slopes: [DMatrix<Complex>; D],
    /// `C_ab` with `b < a`.
    pub(super) mixed: Vec<([usize; 2], DMatrix<Complex>)>,
    pub(super) pure: [DMatrix<Complex>; D],
}

impl<const D: usize> Quadratic<D> {
    /// Whether the polynomial is seen to be positive definite on the box.
    pub(super) fn is_positive_definite(&self) -> bool {
        let size = self.constant.nrows();
        let mut far = self.constant.clone();
        let change = self.change();
        (0..size).for_each(|i| far[(i, i)] -= Complex::new(change, 0.0));
        is_positive_definite(&mut far) || self.is_a_mean() || self.is_a_sum_of_squares()
    }

    /// Whether all coefficients in Bernstein's basis, of which the polynomial is a mean, are positive definite. Nothing is lost where it
    /// is linear, however little its slopes commute; where it is curved, a sum of squares loses less. Lower triangles are read.
    fn is_a_mean(&self) -> bool {
        (0..3_usize.pow(D as u32)).all(|number| {
            let mut rest = number;
            let point: [f64; D] = array_of(|_| {
                let place = [0.0, 1.0, -1.0][rest % 3];
                rest /= 3;
                place
            });
            is_positive_definite(&mut self.coefficient(&point))
        })
    }

    /// The coefficient of a point with components -1, 0 and 1.
    fn coefficient(&self, point: &[f64; D]) -> DMatrix<Complex> {
        let mut sum = self.constant.clone();
        let mut add = |part: &DMatrix<Complex>, factor: f64| {
            if factor != 0.0 {
                sum.zip_apply(part, |sum, entry| *sum += entry * factor);
            }
        };
        for (a, u) in point.iter().enumerate() {
            add(&self.slopes[a], *u);
            // u^2 has the coefficients 1, -1 and 1.
            add(&self.pure[a], if *u == 0.0 { -1.0 } else { 1.0 });
        }
        for ([a, b], part) in &self.mixed {
            add(part, point[*a] * point[*b]);
        }
        sum
    }

    /// Whether the polynomial is seen to be a sum of squares.
    ///
    /// With `U = (1, u_1, ..., u_D)`, for any `T_a >= 0`
    ///
    /// `G(u) = (U x I)* S (U x I) + sum_a (1 - u_a^2) T_a`,
    ///
    /// where `S` has the blocks `S_00 = A - sum_a T_a`, `S_aa = X_a + T_a`, and further ones with `S_a0 + S_0a = B_a` and
    /// `S_ab + S_ba = C_ab`. If `S` is positive definite, then so is `G` on the box. In the eigenvectors of `A`, of which some are soft,
    /// what couples a soft one with a stiff one is given to the slope of the soft one: its Schur complement is then the second derivative
    /// of the soft eigenvalue, so that nothing is lost around a minimum.
    fn is_a_sum_of_squares(&self) -> bool {
        let size = self.constant.nrows();
        let eigen = hermitian_eigen(self.constant.clone());
        let Some(eigen) = eigen.filter(|eigen| eigen.eigenvalues.min() > 0.0) else {
            return false;
        };
        let own = self.in_basis(&eigen.eigenvectors);
        let values = eigen.eigenvalues;
        let steep = |i: usize| {
            own.slopes
                .iter()
                .map(|slope| row_sum(slope, i))
                .sum::<f64>()
        };
        let (soft, stiff): (Vec<usize>, Vec<usize>) =
            (0..size).partition(|i| values[*i] < steep(*i));
        let mut squares = own.squares(&values, &stiff, &soft);
        let Some(mut soft) = eliminated(&mut squares, (D + 1) * stiff.len()) else {
            return false;
        };
        make_blocks_hermitian(&mut soft, D + 1);
        [false, true]
            .into_iter()
            .any(|is_mixed| is_positive_definite(&mut slackened::<D>(&soft, is_mixed)))
            || Self::of_squares(&soft).is_a_mean()
    }

    /// The lower triangles of a polynomial whose `S` has Hermitian blocks.
    fn of_squares(squares: &DMatrix<Complex>) -> Self {
        let count = squares.nrows() / (D + 1);
        let block = |a: usize, b: usize, factor: f64| {
            let own = squares.view((a * count, b * count), (count, count));
            own.map(|entry| entry * factor)
        };
        Self {
            constant: block(0, 0, 1.0),
            slopes: std::array::from_fn(|a| block(a + 1, 0, 2.0)),
            mixed: pairs::<D>()
                .map(|[a, b]| ([a, b], block(a + 1, b + 1, 2.0)))
                .collect(),
            pure: std::array::from_fn(|a| block(a + 1, a + 1, 1.0)),
        }
    }

    /// A bound of the norm of the difference from the constant.
    fn change(&self) -> f64 {
        let mixed = self.mixed.iter().map(|(_, part)| part);
        let all = self.slopes.iter().chain(&self.pure).chain(mixed);
        all.map(|part| part.norm()).sum()
    }

    fn in_basis(&self, basis: &DMatrix<Complex>) -> Self {
        let adjoint = basis.adjoint();
        let seen = |part: &DMatrix<Complex>| &adjoint * part * basis;
        Self {
            constant: DMatrix::zeros(0, 0),
            slopes: std::array::from_fn(|a| seen(&self.slopes[a])),
            mixed: self
                .mixed
                .iter()
                .map(|(ab, part)| (*ab, seen(part)))
                .collect(),
            pure: std::array::from_fn(|a| seen(&self.pure[a])),
        }
    }

    /// The lower triangle of `S`, first the rows of stiff vectors, with a `T_a` that covers what their slopes are coupled with, then those
    /// of soft ones, without.
    fn squares(&self, values: &DVector<f64>, stiff: &[usize], soft: &[usize]) -> DMatrix<Complex> {
        let slack = |a: usize, i: usize| {
            let crossed = self.mixed.iter().filter(|(ab, _)| ab.contains(&a));
            let second = row_sum(&self.pure[a], i)
                + 0.5 * crossed.map(|(_, part)| row_sum(part, i)).sum::<f64>();
            let linear: f64 = stiff.iter().map(|j| self.slopes[a][(i, *j)].norm()).sum();
            LINEAR * linear + second + ROOT * (values[i] * second).sqrt() + SLACK * values[i]
        };
        let slacks: Vec<[f64; D]> = stiff.iter().map(|i| array_of(|a| slack(a, *i))).collect();
        let size = values.len();
        let mut squares = DMatrix::zeros(size * (D + 1), size * (D + 1));
        let place = |block: usize, n: usize| match n.checked_sub(stiff.len()) {
            None => block * stiff.len() + n,
            Some(n) => (D + 1) * stiff.len() + block * soft.len() + n,
        };
        let mut set = |row: usize, column: usize, value: Complex| {
            let (row, column, value) = match row < column {
                true => (column, row, value.conj()),
                false => (row, column, value),
            };
            squares[(row, column)] = value;
        };
        let real = |x: f64| Complex::new(x, 0.0);
        let vectors = || stiff.iter().chain(soft).enumerate();
        for (m, i) in vectors() {
            let own = slacks.get(m).copied().unwrap_or([0.0; D]);
            set(
                place(0, m),
                place(0, m),
                real(values[*i] - own.iter().sum::<f64>()),
            );
            for (n, j) in vectors() {
                let share = match (m < stiff.len(), n < stiff.len()) {
                    (false, true) => 1.0,
                    (true, false) => 0.0,
                    _ => 0.5,
                };
                for a in 0..D {
                    set(
                        place(a + 1, m),
                        place(0, n),
                        self.slopes[a][(*i, *j)] * share,
                    );
                    let given = if m == n { own[a] } else { 0.0 };
                    let second = self.pure[a][(*i, *j)] + real(given);
                    set(place(a + 1, m), place(a + 1, n), second);
                }
                for ([a, b], part) in &self.mixed {
                    set(place(a + 1, m), place(b + 1, n), part[(*i, *j)] * 0.5);
                }
            }
        }
        squares
    }
}

/// Two different variables, each pair once.
pub(super) fn pairs<const D: usize>() -> impl Iterator<Item = [usize; 2]> {
    (0..D).flat_map(|a| (0..a).map(move |b| [a, b]))
}

/// Takes the Hermitian parts of the blocks below the diagonal: the polynomial has only these.
fn make_blocks_hermitian(matrix: &mut DMatrix<Complex>, blocks: usize) {
    let count = matrix.nrows() / blocks;
    for a in 0..blocks {
        for b in 0..a {
            let block = matrix
                .view((a * count, b * count), (count, count))
                .into_owned();
            let hermitian = (&block + block.adjoint()) * Complex::new(0.5, 0.0);
            matrix
                .view_mut((a * count, b * count), (count, count))
                .copy_from(&hermitian);
        }
    }
}

/// With a diagonal `T_a` for soft vectors. Of one alone `max(0, |B_a| / 2 - X_a)` is the best one where nothing is mixed.
fn slackened<const D: usize>(squares: &DMatrix<Complex>, is_mixed: bool) -> DMatrix<Complex> {
    let count = squares.nrows() / (D + 1);
    let mut slackened = squares.clone();
    let entry = |row: usize, column: usize| match row < column {
        true => squares[(column, row)].norm(),
        false => squares[(row, column)].norm(),
    };
    for row in count..squares.nrows() {
        let linear: f64 = (0..count).map(|column| entry(row, column)).sum();
        let others = (count..squares.nrows()).filter(|column| *column != row);
        let mixed: f64 = others.map(|column| entry(row, column)).sum();
        let wanted = linear + if is_mixed { mixed } else { 0.0 };
        let slack = (wanted - squares[(row, row)].re).max(0.0);
        slackened[(row, row)] += slack;
        slackened[(row % count, row % count)] -= slack;
    }
    slackened
}

/// The Schur complement without the leading rows of a Hermitian matrix of which the lower triangle is read and overwritten; `None`
/// unless these are positive definite.
fn eliminated(matrix: &mut DMatrix<Complex>, leading: usize) -> Option<DMatrix<Complex>> {
    let size = matrix.nrows();
    for j in 0..leading {
        let mut pivot = matrix[(j, j)].re;
        for k in 0..j {
            pivot -= matrix[(j, k)].norm_sqr();
        }
        if !pivot.is_finite() || pivot <= 0.0 {
            return None;
        }
        let root = pivot.sqrt();
        for i in j + 1..size {
            let mut entry = matrix[(i, j)];
            for k in 0..j {
                entry -= matrix[(i, k)] * matrix[(j, k)].conj();
            }
            matrix[(i, j)] = entry / root;
        }
    }
    let rest = DMatrix::from_fn(size - leading, size - leading, |i, j| {
        let (i, j) = (leading + i, leading + j);
        if i < j {
            return Complex::new(0.0, 0.0);
        }
        let own = matrix[(i, j)];
        (0..leading).fold(own, |sum, k| sum - matrix[(i, k)] * matrix[(j, k)].conj())
    });
    Some(rest)
}

fn row_sum(matrix: &DMatrix<Complex>, row: usize) -> f64 {
    matrix.row(row).iter().map(|entry| entry.norm()).sum()
}

/// Whether a Hermitian matrix, of which the lower triangle is read and overwritten, has a factor of Cholesky's.
pub(super) fn is_positive_definite(matrix: &mut DMatrix<Complex>) -> bool {
    let size = matrix.nrows();
    eliminated(matrix, size).is_some()
}

#[cfg(test)]
mod tests {
    use super::{Quadratic, is_positive_definite};
    use crate::algebra::Complex;
    use nalgebra::{DMatrix, SVector};
    use proptest::prelude::*;

    fn hermitian(size: usize, entries: &[f64]) -> DMatrix<Complex> {
        let part = DMatrix::from_fn(size, size, |i, j| {
            Complex::new(entries[i * size + j], entries[size * size + i * size + j])
        });
        &part + part.adjoint()
    }

    impl Quadratic<2> {
        fn at(&self, u: [f64; 2]) -> DMatrix<Complex> {
            let real = |x: f64| Complex::new(x, 0.0);
            let mut sum = self.constant.clone();
            for a in 0..2 {
                sum += &self.slopes[a] * real(u[a]) + &self.pure[a] * real(u[a] * u[a]);
            }
            sum + &self.mixed[0].1 * real(u[0] * u[1])
        }
    }

    proptest! {
        #[test]
        fn what_is_seen_to_be_positive_definite_is(
            entries in proptest::collection::vec(-1.0..1.0f64, 6 * 18),
            shift in 0.0..12.0f64,
        ) {
            let of = |n: usize| hermitian(3, &entries[18 * n..18 * (n + 1)]);
            let polynomial = Quadratic::<2> {
                constant: of(0) + DMatrix::identity(3, 3) * Complex::new(shift, 0.0),
                slopes: [of(1), of(2)],
                mixed: vec![([1, 0], of(3))],
                pure: [of(4), of(5)],
            };
            if polynomial.is_positive_definite() {
                for n in 0..400 {
                    let u = [n % 20, n / 20].map(|i| i as f64 / 9.5 - 1.0);
                    prop_assert!(is_positive_definite(&mut polynomial.at(u)), "{u:?}");
                }
            }
        }
    }

    /// `(u - u0).H (u - u0) + floor` of a soft vector that is coupled with a stiff one: the box is as high as its floor.
    #[test]
    fn nothing_is_lost_around_the_minimum_of_a_soft_vector() {
        let bottom = SVector::from([0.3, -0.4]);
        let h = nalgebra::Matrix2::new(2e-4, 1.2e-4, 1.2e-4, 1e-4);
        let coupling = [Complex::new(0.02, 0.01), Complex::new(-0.015, 0.02)];
        let sees = |floor: f64| {
            let soft = |x: f64| {
                let mut part = DMatrix::<Complex>::zeros(2, 2);
                part[(0, 0)] = Complex::new(x, 0.0);
                part
            };
            let bent = |a: usize, b: usize| h[(a, b)] + (coupling[a] * coupling[b].conj()).re;
            let slope = -2.0 * h * bottom;
            let mut constant = soft(bottom.dot(&(h * bottom)) + floor);
            constant[(1, 1)] = Complex::new(1.0, 0.0);
            let coupled = |a: usize| {
                let mut part = soft(slope[a]);
                part[(0, 1)] = coupling[a];
                part[(1, 0)] = coupling[a].conj();
                part
            };
            let polynomial = Quadratic::<2> {
                constant,
                slopes: [coupled(0), coupled(1)],
                mixed: vec![([1, 0], soft(2.0 * bent(0, 1)))],
                pure: [soft(bent(0, 0)), soft(bent(1, 1))],
            };
            polynomial.is_positive_definite()
        };
        assert!(sees(1e-9));
        assert!(!sees(-1e-9));
    }
}
