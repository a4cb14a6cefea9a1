//! Schur form of complex matrices by the QR algorithm, in place: one matrix, or one in each lane.

use super::Complex;
use super::jacobi::{Pair, Selected, diagonalize};

/// Number of iterations for one eigenvalue after which the algorithm is considered not to converge.
const ITERATIONS: usize = 60;
/// Number of iterations without a new eigenvalue after which a shift that is unrelated to the matrix breaks a cycle.
const CYCLE: f64 = 10.0;
/// Numbers below are zero: their reciprocals overflow.
const TINY: f64 = f64::MIN_POSITIVE;

/// Transforms a matrix `A`, stored by columns, into the triangular factor of `A = Q T Q*`; returns false if the iteration does not converge.
///
/// If `q` is not empty, the unitary factor is written there. Otherwise only the diagonal of `T` is meaningful: rows and columns of converged
/// eigenvalues are no longer updated. Every error is of the order of rounding times the largest entry.
pub(crate) fn schur(n: usize, a: &mut [Complex], q: &mut [Complex]) -> bool {
    let largest = a
        .iter()
        .map(|z| z.re.abs().max(z.im.abs()))
        .fold(0.0, f64::max);
    // Squares of very large or small entries would over- or underflow.
    let unit = match largest > 0.0 {
        true => 2.0_f64.powi(largest.log2().clamp(-1000.0, 1000.0) as i32),
        false => 1.0,
    };
    let mut own: Vec<Pair<f64>> = a.iter().map(|z| [z.re / unit, z.im / unit]).collect();
    let mut unitary: Vec<Pair<f64>> = vec![[0.0; 2]; q.len()];
    let is_found = triangular(n, &mut own, &mut unitary);
    for (z, [re, im]) in a.iter_mut().zip(own) {
        *z = Complex::new(re * unit, im * unit);
    }
    for (z, [re, im]) in q.iter_mut().zip(unitary) {
        *z = Complex::new(re, im);
    }
    is_found
}

/// Like [`schur`], for one matrix or one in each lane; the squares of the entries must be in the range of numbers.
///
/// All lanes take the same steps. In lanes without the active block of another lane these are unitary transformations of no further use, or none.
#[inline(always)]
pub(crate) fn triangular<R: Selected>(n: usize, a: &mut [Pair<R>], q: &mut [Pair<R>]) -> bool {
    let [zero, one] = [R::constant(0.0), R::constant(1.0)];
    if !q.is_empty() {
        q.fill([zero; 2]);
        (0..n).for_each(|i| q[i + n * i] = [one, zero]);
    }
    to_hessenberg(n, a, q);
    iterate(n, a, q)
}

/// Eigenvalues with right eigenvectors, the columns of a matrix `V`, and left ones, the rows of its inverse; one matrix or one in each lane.
pub(crate) struct Eigenvectors<R> {
    pub(crate) values: Vec<Pair<R>>,
    /// Matrix `V`, stored by rows like its inverse `left`.
    pub(crate) right: Vec<Pair<R>>,
    pub(crate) left: Vec<Pair<R>>,
}

impl<R: Selected> Eigenvectors<R> {
    /// Decomposes a matrix that is stored by rows; `None` if the iteration does not converge.
    #[inline(always)]
    pub(crate) fn of(n: usize, matrix: &[Pair<R>]) -> Option<Self> {
        let zero = R::constant(0.0);
        let mut t: Vec<Pair<R>> = (0..n * n).map(|e| matrix[e % n * n + e / n]).collect();
        let mut q = vec![[zero; 2]; n * n];
        let smallest = norm(&t) * f64::EPSILON;
        if !triangular(n, &mut t, &mut q) {
            return None;
        }
        let [right, left] = eigenvectors(n, &t, &q, smallest);
        Some(Self {
            values: (0..n).map(|i| t[i + n * i]).collect(),
            right,
            left,
        })
    }

    /// Decomposes a Hermitian matrix, given by its upper triangle, which is overwritten.
    #[inline(always)]
    pub(crate) fn of_hermitian(n: usize, matrix: &mut [Pair<R>]) -> Self {
        let unit = |e: usize| R::constant(f64::from(u8::from(e / n == e % n)));
        let mut right: Vec<Pair<R>> = (0..n * n).map(|e| [unit(e), R::constant(0.0)]).collect();
        diagonalize(n, matrix, &mut right);
        let adjoint = |e: usize| {
            let [re, im] = right[e % n * n + e / n];
            [re, -im]
        };
        Self {
            values: (0..n)
                .map(|i| [matrix[i * n + i][0], R::constant(0.0)])
                .collect(),
            left: (0..n * n).map(adjoint).collect(),
            right,
        }
    }

    /// Product of the norms of the matrices of left and right eigenvectors.
    #[inline(always)]
    pub(crate) fn condition(&self) -> R {
        norm(&self.left) * norm(&self.right)
    }
}

/// Right eigenvectors `V = Q X` and left ones `V^-1` of a matrix `Q T Q*`, by rows. The factors are stored by columns, and the eigenvectors `X` of the
/// triangular factor follow by substitution.
///
/// Eigenvalues closer than `smallest` are separated by it: if the matrix is not diagonalizable, the length of its vectors is determined by rounding.
#[inline(always)]
pub(crate) fn eigenvectors<R: Selected>(
    n: usize,
    t: &[Pair<R>],
    q: &[Pair<R>],
    smallest: R,
) -> [Vec<Pair<R>>; 2] {
    let [zero, one] = [R::constant(0.0), R::constant(1.0)];
    let mut x = vec![[zero; 2]; n * n];
    for j in 0..n {
        x[j + n * j] = [one, zero];
        for i in (0..j).rev() {
            let mut sum = [zero; 2];
            for l in i + 1..=j {
                sum = minus(sum, times(t[i + n * l], x[l + n * j]));
            }
            let difference = minus(t[i + n * i], t[j + n * j]);
            let excess = square(difference) - smallest * smallest;
            let difference = selected(excess, 0.0, [smallest, zero], difference);
            x[i + n * j] = over(times(sum, conj(difference)), square(difference));
        }
    }
    let (mut right, mut left) = (vec![[zero; 2]; n * n], vec![[zero; 2]; n * n]);
    for i in 0..n {
        for j in 0..n {
            for l in 0..=j {
                let term = times(q[i + n * l], x[l + n * j]);
                right[i * n + j] = plus(right[i * n + j], term);
            }
        }
    }
    for i in (0..n).rev() {
        for j in 0..n {
            let mut entry = conj(q[j + n * i]);
            for l in i + 1..n {
                entry = minus(entry, times(x[i + n * l], left[l * n + j]));
            }
            left[i * n + j] = entry;
        }
    }
    [right, left]
}

#[inline(always)]
fn square<R: Selected>(z: Pair<R>) -> R {
    z[0] * z[0] + z[1] * z[1]
}

/// Product of two complex numbers.
#[inline(always)]
pub(crate) fn times<R: Selected>(x: Pair<R>, y: Pair<R>) -> Pair<R> {
    [x[0] * y[0] - x[1] * y[1], x[0] * y[1] + x[1] * y[0]]
}

#[inline(always)]
fn conj<R: Selected>(z: Pair<R>) -> Pair<R> {
    [z[0], -z[1]]
}

#[inline(always)]
fn plus<R: Selected>(x: Pair<R>, y: Pair<R>) -> Pair<R> {
    [x[0] + y[0], x[1] + y[1]]
}

#[inline(always)]
fn minus<R: Selected>(x: Pair<R>, y: Pair<R>) -> Pair<R> {
    [x[0] - y[0], x[1] - y[1]]
}

#[inline(always)]
fn scaled<R: Selected>(z: Pair<R>, by: R) -> Pair<R> {
    [z[0] * by, z[1] * by]
}

/// `yes` where a number is below a threshold, otherwise `no`.
#[inline(always)]
fn selected<R: Selected>(number: R, threshold: f64, yes: Pair<R>, no: Pair<R>) -> Pair<R> {
    [
        number.select(threshold, yes[0], no[0]),
        number.select(threshold, yes[1], no[1]),
    ]
}

/// Root of the sum of the squares of all entries.
#[inline(always)]
fn norm<R: Selected>(matrix: &[Pair<R>]) -> R {
    let mut sum = R::constant(0.0);
    for z in matrix {
        sum = sum + square(*z);
    }
    sum.sqrt()
}

/// Sum of the magnitudes of the real and imaginary part.
#[inline(always)]
fn size<R: Selected>(z: Pair<R>) -> R {
    z[0].larger(-z[0]) + z[1].larger(-z[1])
}

/// Quotient; zero where the divisor is not above the smallest positive number.
#[inline(always)]
fn over<R: Selected>(z: Pair<R>, divisor: R) -> Pair<R> {
    let [zero, one] = [R::constant(0.0), R::constant(1.0)];
    let safe = divisor.select(TINY, one, divisor);
    scaled(z, divisor.select(TINY, zero, one / safe))
}

/// Square root with a real part that is not negative.
#[inline(always)]
fn root<R: Selected>(z: Pair<R>) -> Pair<R> {
    let modulus = square(z).sqrt();
    let large = ((modulus + z[0].larger(-z[0])) * 0.5).sqrt();
    let [small, _] = over([z[1] * 0.5, z[1]], large);
    let (along, across) = (small.larger(-small), z[1].select(0.0, -large, large));
    [
        z[0].select(0.0, along, large),
        z[0].select(0.0, across, small),
    ]
}

/// Hessenberg form by reflections.
#[inline(always)]
fn to_hessenberg<R: Selected>(n: usize, a: &mut [Pair<R>], q: &mut [Pair<R>]) {
    let [zero, one] = [R::constant(0.0), R::constant(1.0)];
    let mut axis = vec![[zero; 2]; n];
    for k in 0..n.saturating_sub(2) {
        let mut below = zero;
        for i in k + 2..n {
            below = below + square(a[i + n * k]);
        }
        let first = a[k + 1 + n * k];
        let modulus = square(first).sqrt();
        let norm = (below + square(first)).sqrt();
        let phase = selected(modulus, TINY, [one, zero], over(first, modulus));
        axis[k + 1..n].copy_from_slice(&a[k + 1 + n * k..n + n * k]);
        axis[k + 1] = plus(axis[k + 1], scaled(phase, norm));
        // Columns that are zero below need no reflection.
        let [factor, _] = over([one, zero], norm * (norm + modulus));
        let factor = below.select(TINY, zero, factor);
        let axis = &axis[k + 1..n];
        for column in a.chunks_exact_mut(n).skip(k) {
            let own = &mut column[k + 1..n];
            let mut along = [zero; 2];
            for (v, x) in axis.iter().zip(own.iter()) {
                along = plus(along, times(conj(*v), *x));
            }
            let along = scaled(along, factor);
            for (x, v) in own.iter_mut().zip(axis) {
                *x = minus(*x, times(along, *v));
            }
        }
        for matrix in [&mut *a, &mut *q] {
            if matrix.is_empty() {
                continue;
            }
            for i in 0..n {
                let mut along = [zero; 2];
                for (j, v) in axis.iter().enumerate() {
                    along = plus(along, times(matrix[i + n * (k + 1 + j)], *v));
                }
                let along = scaled(along, factor);
                for (j, v) in axis.iter().enumerate() {
                    let entry = &mut matrix[i + n * (k + 1 + j)];
                    *entry = minus(*entry, times(along, conj(*v)));
                }
            }
        }
    }
}

/// Rotation of the rows `i`, `i + 1`, which become `c x + s y` and `-conj(s) x + c y`.
#[derive(Clone, Copy)]
struct Rotation<R> {
    c: R,
    s: Pair<R>,
}

impl<R: Selected> Rotation<R> {
    /// Rotation that makes `y` zero.
    #[inline(always)]
    fn of(x: Pair<R>, y: Pair<R>) -> Self {
        let [zero, one] = [R::constant(0.0), R::constant(1.0)];
        let modulus = square(x).sqrt();
        let norm = (square(x) + square(y)).sqrt();
        let phase = selected(modulus, TINY, [one, zero], over(x, modulus));
        let [cosine, _] = over([modulus, zero], norm);
        // A zero above becomes the whole entry below.
        let whole = selected(norm, TINY, [zero; 2], [one, zero]);
        Self {
            c: norm.select(TINY, one, cosine),
            s: selected(modulus, TINY, whole, over(times(phase, conj(y)), norm)),
        }
    }

    /// Rotates two columns in some of their rows.
    #[inline(always)]
    fn across(&self, columns: &mut [Pair<R>], rows: std::ops::Range<usize>) {
        let (first, second) = columns.split_at_mut(columns.len() / 2);
        for (x, y) in first[rows.clone()].iter_mut().zip(&mut second[rows]) {
            let turned = plus(scaled(*x, self.c), times(conj(self.s), *y));
            *y = minus(scaled(*y, self.c), times(self.s, *x));
            *x = turned;
        }
    }
}

/// Rows of the lowest block, in each lane, that is not yet triangular.
struct Active<R> {
    first: R,
    /// Zero in lanes that are triangular.
    last: R,
}

impl<R: Selected> Active<R> {
    /// Sets entries below the diagonal that are zero to rounding to zero, and returns the lowest block.
    #[inline(always)]
    fn of(n: usize, a: &mut [Pair<R>], whole: R) -> Self {
        let [zero, one] = [R::constant(0.0), R::constant(1.0)];
        let (mut first, mut last, mut is_open) = (R::constant(n as f64), zero, zero);
        for i in (1..n).rev() {
            let place = i + n * (i - 1);
            let beside = size(a[i - 1 + n * (i - 1)]) + size(a[i + n * i]);
            let excess = size(a[place]) - beside.larger(whole * 0.1) * f64::EPSILON;
            a[place] = selected(excess, TINY, [zero; 2], a[place]);
            let (row, is_coupled) = (R::constant(i as f64), excess.select(TINY, zero, one));
            let opens = last.select(0.5, is_coupled, zero);
            last = opens.select(0.5, last, row);
            is_open = opens.select(0.5, is_open, one);
            let closes = is_coupled.select(0.5, is_open, zero);
            first = closes.select(0.5, first, row);
            is_open = closes.select(0.5, is_open, zero);
        }
        first = is_open.select(0.5, first, zero);
        Self { first, last }
    }

    /// A number in the rows of the block, zero elsewhere.
    #[inline(always)]
    fn within(&self, row: usize, number: R) -> R {
        let (zero, row) = (R::constant(0.0), R::constant(row as f64));
        let below = (row - self.last).select(0.5, number, zero);
        (self.first - row).select(0.5, below, zero)
    }

    /// The eigenvalue of the last two rows of the block that is nearer to the last diagonal entry; or, where `is_stalled`, an unrelated number.
    #[inline(always)]
    fn shift(&self, n: usize, a: &[Pair<R>], range: [usize; 2], is_stalled: R) -> Pair<R> {
        let zero = [R::constant(0.0); 2];
        let [mut end, mut before, mut above, mut below] = [zero; 4];
        for i in (range[0] + 1)..=range[1] {
            let apart = self.last - i as f64;
            let apart = apart.larger(-apart);
            end = selected(apart, 0.5, a[i + n * i], end);
            before = selected(apart, 0.5, a[i - 1 + n * (i - 1)], before);
            above = selected(apart, 0.5, a[i - 1 + n * i], above);
            below = selected(apart, 0.5, a[i + n * (i - 1)], below);
        }
        let half = scaled(minus(before, end), R::constant(0.5));
        let product = times(above, below);
        let root = root(plus(times(half, half), product));
        let along = half[0] * root[0] + half[1] * root[1];
        let far = plus(half, selected(along, 0.0, [-root[0], -root[1]], root));
        let usual = minus(end, over(times(product, conj(far)), square(far)));
        let other = [end[0] + size(below), end[1]];
        selected(is_stalled, 0.5, usual, other)
    }
}

/// Shifted QR steps until every entry below the diagonal is zero to rounding.
#[inline(always)]
fn iterate<R: Selected>(n: usize, a: &mut [Pair<R>], q: &mut [Pair<R>]) -> bool {
    let [zero, one] = [R::constant(0.0), R::constant(1.0)];
    let with_vectors = !q.is_empty();
    let (mut total, mut whole) = (zero, zero);
    for z in a.iter() {
        total = total + size(*z);
        whole = whole.larger(size(*z));
    }
    // Infinities and NaN times zero are NaN.
    if !(total * 0.0).is_below(0.5) {
        return false;
    }
    let idle = Rotation {
        c: one,
        s: [zero; 2],
    };
    let mut rotations = vec![idle; n];
    let mut shifts = vec![[zero; 2]; n];
    let (mut known, mut stalled) = (zero, zero);
    for _ in 0..ITERATIONS * n.max(1) {
        let active = Active::of(n, a, whole);
        let [lowest, highest] = [-(-active.first).most(), active.last.most()];
        if highest < 0.5 {
            return true;
        }
        let (first, last) = (lowest as usize, highest as usize);
        let moved = active.last - known;
        stalled = moved.larger(-moved).select(0.5, stalled + 1.0, zero);
        known = active.last;
        let is_stalled = stalled.select(CYCLE - 0.5, zero, one);
        stalled = is_stalled.select(0.5, stalled, zero);
        let shift = active.shift(n, a, [first, last], is_stalled);
        for i in first..=last {
            shifts[i] = [active.within(i, shift[0]), active.within(i, shift[1])];
            a[i + n * i] = minus(a[i + n * i], shifts[i]);
        }
        let end = if with_vectors { n } else { last + 1 };
        for k in first..last {
            let turn = Rotation::of(a[k + n * k], a[k + 1 + n * k]);
            rotations[k] = turn;
            for j in k..end {
                let (x, y) = (a[k + n * j], a[k + 1 + n * j]);
                a[k + n * j] = plus(scaled(x, turn.c), times(turn.s, y));
                a[k + 1 + n * j] = minus(scaled(y, turn.c), times(conj(turn.s), x));
            }
            a[k + 1 + n * k] = [zero; 2];
        }
        let begin = if with_vectors { 0 } else { first };
        for k in first..last {
            let turn = rotations[k];
            turn.across(&mut a[n * k..n * (k + 2)], begin..k + 2);
            if with_vectors {
                turn.across(&mut q[n * k..n * (k + 2)], 0..n);
            }
        }
        for i in first..=last {
            a[i + n * i] = plus(a[i + n * i], shifts[i]);
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::{Eigenvectors, schur, triangular};
    use crate::algebra::{Complex, Pair, uniform};
    use crate::real::{LANES, Lanes};
    use nalgebra::DMatrix;

    fn assert_is_decomposed(matrix: &DMatrix<Complex>) {
        let n = matrix.nrows();
        let (mut t, mut q) = (matrix.clone(), DMatrix::zeros(n, n));
        assert!(schur(n, t.as_mut_slice(), q.as_mut_slice()));
        t.fill_lower_triangle(Complex::default(), 1);
        let largest = |matrix: &DMatrix<Complex>| {
            let parts = matrix.iter().map(|z| z.re.abs().max(z.im.abs()));
            parts.fold(0.0, f64::max)
        };
        let scale = 1e-14 * (n as f64) * largest(matrix);
        assert!(largest(&(&q * &t * q.adjoint() - matrix)) <= scale);
        assert!((q.adjoint() * &q - DMatrix::identity(n, n)).norm() < 1e-13);
        // Without the unitary factor the diagonal is the same apart from rounding, which equal eigenvalues amplify.
        let mut own = matrix.clone();
        assert!(schur(n, own.as_mut_slice(), &mut []));
        let trace: Complex = own.diagonal().iter().sum();
        let change = trace - matrix.trace();
        assert!(change.re.abs().max(change.im.abs()) <= scale);
    }

    #[test]
    fn matrices_of_all_kinds_become_triangular() {
        let mut state = 3;
        let mut number = || 2.0 * uniform(&mut state) - 1.0;
        for n in 1..14 {
            let any = DMatrix::from_fn(n, n, |_, _| Complex::new(number(), number()));
            let rank_one = any.column(0) * any.row(0);
            let cycle = DMatrix::from_fn(n, n, |i, j| {
                Complex::from(f64::from(u8::from((i + 1) % n == j)))
            });
            let nilpotent = any.upper_triangle() - DMatrix::from_diagonal(&any.diagonal());
            let mixed = &any * &nilpotent * any.clone().try_inverse().expect("regular");
            for matrix in [&any, &rank_one, &cycle, &nilpotent, &mixed] {
                assert_is_decomposed(matrix);
                assert_is_decomposed(&(matrix * Complex::from(1e-200)));
                assert_is_decomposed(&(matrix * Complex::from(1e200)));
            }
            assert_is_decomposed(&(&any + any.adjoint()));
            assert_is_decomposed(&DMatrix::zeros(n, n));
            let all = [&any, &rank_one, &cycle, &nilpotent, &mixed];
            assert_lanes_are_alike(&all.map(Clone::clone));
        }
    }

    /// The eigenvalues and eigenvectors in a lane are independent of the matrices in the other lanes.
    fn assert_lanes_are_alike(matrices: &[DMatrix<Complex>]) {
        let n = matrices[0].nrows();
        let of_lane = |lane: usize| &matrices[lane % matrices.len()];
        let entry = |e: usize| {
            let part = |of: fn(&Complex) -> f64| {
                Lanes(std::array::from_fn(|lane| {
                    of(&of_lane(lane)[(e / n, e % n)])
                }))
            };
            [part(|z| z.re), part(|z| z.im)]
        };
        let packed: Vec<Pair<Lanes>> = (0..n * n).map(entry).collect();
        let mut triangle: Vec<Pair<Lanes>> =
            (0..n * n).map(|e| packed[e % n * n + e / n]).collect();
        assert!(triangular(n, &mut triangle, &mut []));
        let all = Eigenvectors::of(n, &packed).expect("eigenvectors");
        let at = |z: Pair<Lanes>, lane: usize| Complex::new(z[0].0[lane], z[1].0[lane]);
        for lane in 0..LANES {
            let matrix = of_lane(lane);
            let scale = 1e-13 * matrix.norm();
            let trace: Complex = (0..n).map(|i| at(triangle[i + n * i], lane)).sum();
            assert!((trace - matrix.trace()).norm() <= scale);
            let [right, left] = [&all.right, &all.left]
                .map(|own| DMatrix::from_fn(n, n, |i, j| at(own[i * n + j], lane)));
            let values = DMatrix::from_fn(n, n, |i, j| match i == j {
                true => at(all.values[i], lane),
                false => Complex::default(),
            });
            assert!((matrix * &right - &right * &values).norm() <= scale * right.norm());
            // Nearly dependent vectors amplify rounding in their inverse.
            let condition = all.condition().0[lane];
            assert!((&left * matrix - &values * &left).norm() <= scale * condition);
            let product = &left * &right - DMatrix::identity(n, n);
            assert!(product.norm() <= 1e-13 * condition);
        }
    }
}
