//! Hermitian matrices of a few rows by Jacobi rotations, one matrix or one in each lane.

use crate::real::{Lanes, Real};

/// Largest number of rows for which rotations are cheaper than a tridiagonal form.
pub(crate) const ROTATED_ROWS: usize = 12;
/// Largest number of sweeps of rotations; nine sweeps reach rounding accuracy for twelve rows.
const SWEEPS: usize = 20;
/// Squared magnitude of an entry that is zero to rounding, relative to the square of the largest entry: `(f64::EPSILON / 10)^2`.
const ZERO_SQUARE: f64 = 5e-34;

/// Number, or numbers in lanes, with a selection that needs no branch.
pub(crate) trait Selected: Real {
    /// `yes` where the number is below the threshold, otherwise `no`.
    fn select(self, threshold: f64, yes: Self, no: Self) -> Self;

    /// Larger of two numbers.
    fn larger(self, other: Self) -> Self {
        (self - other).select(0.0, other, self)
    }

    /// Returns true if all numbers are below the threshold.
    fn is_below(self, threshold: f64) -> bool;

    /// Largest of all numbers.
    fn most(self) -> f64;
}

impl Selected for f64 {
    #[inline(always)]
    fn select(self, threshold: f64, yes: Self, no: Self) -> Self {
        if self < threshold { yes } else { no }
    }

    #[inline(always)]
    fn is_below(self, threshold: f64) -> bool {
        self < threshold
    }

    #[inline(always)]
    fn most(self) -> f64 {
        self
    }
}

impl Selected for Lanes {
    #[inline(always)]
    fn select(mut self, threshold: f64, yes: Self, no: Self) -> Self {
        for ((own, yes), no) in self.0.iter_mut().zip(yes.0).zip(no.0) {
            *own = if *own < threshold { yes } else { no };
        }
        self
    }

    #[inline(always)]
    fn is_below(self, threshold: f64) -> bool {
        self.0
            .iter()
            .fold(true, |all, own| all & (*own < threshold))
    }

    #[inline(always)]
    fn most(self) -> f64 {
        self.0.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Complex number by its real and imaginary part.
pub(crate) type Pair<R> = [R; 2];

/// `c x - s y conj(e)` and `s x + c y conj(e)`, the images of two entries of a row under a rotation.
#[inline(always)]
fn turned<R: Real>([c, s]: [R; 2], e: Pair<R>, x: Pair<R>, y: Pair<R>) -> [Pair<R>; 2] {
    let y = [y[0] * e[0] + y[1] * e[1], y[1] * e[0] - y[0] * e[1]];
    [
        [c * x[0] - s * y[0], c * x[1] - s * y[1]],
        [s * x[0] + c * y[0], s * x[1] + c * y[1]],
    ]
}

/// Diagonalizes a Hermitian matrix: afterwards its diagonal holds the eigenvalues, in any order.
///
/// The matrix is stored by rows, and only its upper triangle is used. `vectors`, if not empty, is an `n x n` matrix by rows whose columns are rotated
/// with the matrix: if it is the identity, it becomes the matrix of the eigenvectors as columns.
#[inline(always)]
pub(crate) fn diagonalize<R: Selected>(n: usize, a: &mut [Pair<R>], vectors: &mut [Pair<R>]) {
    let zero = R::constant(0.0);
    let conj = |z: Pair<R>| [z[0], -z[1]];
    let square = |z: Pair<R>| z[0] * z[0] + z[1] * z[1];
    let mut largest = zero;
    for i in 0..n {
        for j in i..n {
            largest = largest.larger(square(a[i * n + j]));
        }
    }
    // A matrix of zeros needs no rotation.
    let scale = largest.larger(R::constant(f64::MIN_POSITIVE));
    for _ in 0..SWEEPS {
        let mut is_diagonal = true;
        for p in 0..n {
            for q in p + 1..n {
                let off = a[p * n + q];
                let size = square(off);
                let relative = size / scale;
                if relative.is_below(ZERO_SQUARE) {
                    continue;
                }
                is_diagonal = false;
                // In lanes in which the entry is zero already, the rotation is the identity.
                let modulus = size.sqrt();
                let e = [off[0] / modulus, off[1] / modulus];
                let e = [
                    relative.select(ZERO_SQUARE, R::constant(1.0), e[0]),
                    relative.select(ZERO_SQUARE, zero, e[1]),
                ];
                let apart = a[q * n + q][0] - a[p * n + p][0];
                let root = (apart * apart + size * 4.0).sqrt();
                let tangent = modulus * 2.0 / (apart + apart.select(0.0, -root, root));
                let tangent = relative.select(ZERO_SQUARE, zero, tangent);
                let cosine = R::constant(1.0) / (tangent * tangent + 1.0).sqrt();
                let turn = [cosine, tangent * cosine];
                a[p * n + p][0] = a[p * n + p][0] - tangent * modulus;
                a[q * n + q][0] = a[q * n + q][0] + tangent * modulus;
                a[p * n + q] = [
                    relative.select(ZERO_SQUARE, off[0], zero),
                    relative.select(ZERO_SQUARE, off[1], zero),
                ];
                for k in 0..p {
                    let [x, y] = turned(turn, e, a[k * n + p], a[k * n + q]);
                    (a[k * n + p], a[k * n + q]) = (x, y);
                }
                for k in p + 1..q {
                    let [x, y] = turned(turn, e, conj(a[p * n + k]), a[k * n + q]);
                    (a[p * n + k], a[k * n + q]) = (conj(x), y);
                }
                for k in q + 1..n {
                    let [x, y] = turned(turn, e, conj(a[p * n + k]), conj(a[q * n + k]));
                    (a[p * n + k], a[q * n + k]) = (conj(x), conj(y));
                }
                for row in vectors.chunks_exact_mut(n) {
                    let [x, y] = turned(turn, e, row[p], row[q]);
                    (row[p], row[q]) = (x, y);
                }
            }
        }
        if is_diagonal {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Pair, ROTATED_ROWS, diagonalize};
    use crate::algebra::{Complex, hermitian_eigen, uniform};
    use crate::real::{LANES, Lanes, Real};
    use nalgebra::DMatrix;

    /// Random Hermitian matrix; every third matrix is a unit matrix plus a matrix of rank one, with `n - 1` equal eigenvalues.
    fn matrix(n: usize, seed: u64) -> DMatrix<Complex> {
        let mut state = seed;
        let mut number = || 2.0 * uniform(&mut state) - 1.0;
        let any = DMatrix::from_fn(n, n, |_, _| Complex::new(number(), number()));
        match seed % 3 {
            0 => DMatrix::identity(n, n) + any.column(0) * any.column(0).adjoint(),
            _ => &any + any.adjoint(),
        }
    }

    fn by_rows(matrix: &DMatrix<Complex>) -> Vec<Pair<f64>> {
        let rows = matrix.row_iter();
        let entries = rows.flat_map(|row| row.iter().map(|z| [z.re, z.im]).collect::<Vec<_>>());
        entries.collect()
    }

    #[test]
    fn eigenvectors_satisfy_their_equation() {
        for n in 1..=ROTATED_ROWS {
            for seed in 1..40 {
                let given = matrix(n, seed);
                let mut a = by_rows(&given);
                let mut vectors = by_rows(&DMatrix::identity(n, n));
                diagonalize(n, &mut a, &mut vectors);
                let v = DMatrix::from_fn(n, n, |i, j| {
                    Complex::new(vectors[i * n + j][0], vectors[i * n + j][1])
                });
                assert!((v.adjoint() * &v - DMatrix::identity(n, n)).norm() < 1e-13);
                for j in 0..n {
                    let value = Complex::from(a[j * n + j][0]);
                    let residual = &given * v.column(j) - v.column(j) * value;
                    assert!(residual.norm() < 1e-13 * given.norm(), "{n} {seed}");
                }
            }
        }
    }

    #[test]
    fn every_lane_has_the_eigenvalues_of_its_matrix() {
        for n in 1..=ROTATED_ROWS {
            // One lane is diagonal, one is zero.
            let mut given: Vec<DMatrix<Complex>> =
                (0..LANES as u64).map(|seed| matrix(n, seed + 1)).collect();
            given[2] = DMatrix::from_diagonal(&given[2].diagonal().map(|z| Complex::from(z.re)));
            given[5] = DMatrix::zeros(n, n);
            let entry = |e: usize, part: usize| {
                let mut lanes = Lanes::constant(0.0);
                for (lane, matrix) in lanes.0.iter_mut().zip(&given) {
                    let z = matrix[(e / n, e % n)];
                    *lane = [z.re, z.im][part];
                }
                lanes
            };
            let mut a: Vec<Pair<Lanes>> = (0..n * n).map(|e| [entry(e, 0), entry(e, 1)]).collect();
            diagonalize(n, &mut a, &mut []);
            for (lane, matrix) in given.iter().enumerate() {
                let mut own: Vec<f64> = (0..n).map(|j| a[j * n + j][0].0[lane]).collect();
                own.sort_by(f64::total_cmp);
                let known = hermitian_eigen(matrix.clone()).expect("finite").eigenvalues;
                let mut known: Vec<f64> = known.iter().copied().collect();
                known.sort_by(f64::total_cmp);
                for (own, known) in own.iter().zip(known) {
                    assert!((own - known).abs() < 1e-13 * (1.0 + matrix.norm()));
                }
            }
        }
    }
}
