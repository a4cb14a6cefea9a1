//! Schur form of complex matrices by the QR algorithm, in place.

use super::Complex;

/// Number of iterations for one eigenvalue after which the algorithm is considered not to converge.
const ITERATIONS: usize = 60;
/// Number of iterations after which a shift that is unrelated to the matrix breaks a cycle.
const CYCLE: usize = 10;

/// Transforms a matrix `A`, stored by columns, into the triangular factor of `A = Q T Q*`; returns false if the iteration does not converge.
///
/// If `q` is not empty, the unitary factor is written there. Otherwise only the diagonal of `T` is meaningful: rows and columns of converged
/// eigenvalues are no longer updated. Every error is of the order of rounding times the largest entry.
pub(crate) fn schur(n: usize, a: &mut [Complex], q: &mut [Complex]) -> bool {
    let largest = a
        .iter()
        .map(|z| z.re.abs().max(z.im.abs()))
        .fold(0.0, f64::max);
    if !q.is_empty() {
        q.fill(Complex::default());
        (0..n).for_each(|i| q[i + n * i] = Complex::from(1.0));
    }
    if largest == 0.0 || n < 2 {
        return true;
    }
    // Squares of very large or small entries would over- or underflow.
    let unit = 2.0_f64.powi(largest.log2().clamp(-1000.0, 1000.0) as i32);
    a.iter_mut().for_each(|z| *z /= unit);
    to_hessenberg(n, a, q);
    let is_found = iterate(n, a, q);
    a.iter_mut().for_each(|z| *z *= unit);
    is_found
}

/// Hessenberg form by reflections.
fn to_hessenberg(n: usize, a: &mut [Complex], q: &mut [Complex]) {
    let mut axis = vec![Complex::default(); n];
    for k in 0..n.saturating_sub(2) {
        let below: f64 = (k + 2..n).map(|i| a[i + n * k].norm_sqr()).sum();
        if below == 0.0 {
            continue;
        }
        let first = a[k + 1 + n * k];
        let norm = (below + first.norm_sqr()).sqrt();
        let modulus = first.norm_sqr().sqrt();
        let phase = match modulus > 0.0 {
            true => first / modulus,
            false => Complex::from(1.0),
        };
        axis[k + 1..n].copy_from_slice(&a[k + 1 + n * k..n + n * k]);
        axis[k + 1] += phase * norm;
        let factor = 1.0 / (norm * (norm + modulus));
        let axis = &axis[k + 1..n];
        for column in a.chunks_exact_mut(n).skip(k) {
            let own = &mut column[k + 1..n];
            let along: Complex = axis.iter().zip(own.iter()).map(|(v, x)| v.conj() * x).sum();
            let along = along * factor;
            own.iter_mut().zip(axis).for_each(|(x, v)| *x -= along * v);
        }
        for matrix in [&mut *a, &mut *q] {
            if matrix.is_empty() {
                continue;
            }
            for i in 0..n {
                let along: Complex = (0..axis.len())
                    .map(|j| matrix[i + n * (k + 1 + j)] * axis[j])
                    .sum();
                let along = along * factor;
                for (j, v) in axis.iter().enumerate() {
                    matrix[i + n * (k + 1 + j)] -= along * v.conj();
                }
            }
        }
    }
}

/// Rotation of the rows `i`, `i + 1`, which become `c x + s y` and `-conj(s) x + c y`.
#[derive(Clone, Copy)]
struct Rotation {
    c: f64,
    s: Complex,
}

/// Shifted QR steps until every entry below the diagonal is zero to rounding.
fn iterate(n: usize, a: &mut [Complex], q: &mut [Complex]) -> bool {
    let size = |z: Complex| z.re.abs() + z.im.abs();
    let with_vectors = !q.is_empty();
    let whole = a.iter().map(|z| size(*z)).fold(0.0, f64::max);
    let mut rotations = vec![
        Rotation {
            c: 1.0,
            s: Complex::default()
        };
        n
    ];
    let (mut last, mut count) = (n - 1, 0);
    while last > 0 {
        let mut first = last;
        while first > 0 {
            let beside = size(a[first - 1 + n * (first - 1)]) + size(a[first + n * first]);
            let zero = f64::EPSILON * beside.max(0.1 * whole);
            if size(a[first + n * (first - 1)]) <= zero {
                a[first + n * (first - 1)] = Complex::default();
                break;
            }
            first -= 1;
        }
        if first == last {
            (last, count) = (last - 1, 0);
            continue;
        }
        count += 1;
        if count > ITERATIONS || !size(a[last + n * last]).is_finite() {
            return false;
        }
        let shift = match count % CYCLE {
            0 => a[last + n * last] + size(a[last + n * (last - 1)]),
            _ => nearer_eigenvalue(n, a, last),
        };
        (first..=last).for_each(|i| a[i + n * i] -= shift);
        let end = if with_vectors { n } else { last + 1 };
        for k in first..last {
            let (x, y) = (a[k + n * k], a[k + 1 + n * k]);
            let norm = (x.norm_sqr() + y.norm_sqr()).sqrt();
            let modulus = x.norm_sqr().sqrt();
            let turn = match modulus > 0.0 {
                true => Rotation {
                    c: modulus / norm,
                    s: x / modulus * y.conj() / norm,
                },
                false => Rotation {
                    c: 0.0,
                    s: Complex::from(1.0),
                },
            };
            rotations[k] = turn;
            for j in k..end {
                let (x, y) = (a[k + n * j], a[k + 1 + n * j]);
                a[k + n * j] = x * turn.c + turn.s * y;
                a[k + 1 + n * j] = y * turn.c - turn.s.conj() * x;
            }
            a[k + 1 + n * k] = Complex::default();
        }
        let begin = if with_vectors { 0 } else { first };
        for k in first..last {
            let turn = rotations[k];
            let across = |matrix: &mut [Complex], rows: std::ops::Range<usize>| {
                for i in rows {
                    let (x, y) = (matrix[i + n * k], matrix[i + n * (k + 1)]);
                    matrix[i + n * k] = x * turn.c + turn.s.conj() * y;
                    matrix[i + n * (k + 1)] = y * turn.c - turn.s * x;
                }
            };
            across(a, begin..k + 2);
            if with_vectors {
                across(q, 0..n);
            }
        }
        (first..=last).for_each(|i| a[i + n * i] += shift);
    }
    true
}

/// Eigenvalue of the last two rows of the active part that is nearer to the last diagonal entry.
fn nearer_eigenvalue(n: usize, a: &[Complex], last: usize) -> Complex {
    let end = a[last + n * last];
    let half = (a[last - 1 + n * (last - 1)] - end) * 0.5;
    let product = a[last - 1 + n * last] * a[last + n * (last - 1)];
    let root = (half * half + product).sqrt();
    let far = match (half.conj() * root).re < 0.0 {
        true => half - root,
        false => half + root,
    };
    match far.norm_sqr() > 0.0 {
        true => end - product / far,
        false => end,
    }
}

#[cfg(test)]
mod tests {
    use super::schur;
    use crate::algebra::{Complex, uniform};
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
        }
    }
}
