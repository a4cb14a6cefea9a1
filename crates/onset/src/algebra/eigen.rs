//! Eigenvalues and eigenvectors of complex matrices with one to three rows.

use super::{Complex, symmetric_eigen};
use crate::algebra::{Deviator, Each, any_eigenvalues, array_of};
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector};

/// Number of sweeps after which an iterative decomposition is considered not to converge.
pub(crate) const MAXIMUM_ITERATIONS: usize = 200;

/// Returns the eigenvalues of a complex matrix, sorted by real part, then imaginary part.
///
/// For one and two rows the closed form is used. `noise` is the expected rounding error of an entry. Two eigenvalues whose difference from a real
/// double one is explained by this noise are returned as real, since otherwise its square root would appear as a spurious imaginary part.
///
/// The result is NaN if the iteration for three rows does not converge, which requires entries that are not finite.
pub fn eigenvalues<const D: usize>(matrix: &SMatrix<Complex, D, D>, noise: f64) -> [Complex; D] {
    let mut values = [Complex::new(f64::NAN, f64::NAN); D];
    match D {
        1 => {
            values[0] = matrix[(0, 0)];
            without_rounding(&mut values, 0.0, noise);
        }
        2 if matrix.iter().all(|entry| entry.im == 0.0) => {
            // The real case is treated separately, because most matrices are real and this is the innermost loop.
            let [a, b, c, d] = [(0, 0), (0, 1), (1, 0), (1, 1)].each(|index| matrix[index].re);
            let (mean, half) = (0.5 * (a + d), 0.5 * (a - d));
            let largest = half.abs().max(b.abs()).max(c.abs());
            if largest > 0.0 && !(1e-140..1e140).contains(&largest) {
                // Squares would over- or underflow.
                let scaled = matrix.map(|entry| entry / largest);
                return eigenvalues(&scaled, noise / largest).each(|value| value * largest);
            }
            let discriminant = half * half + b * c;
            let explained = 2.0 * noise * (half.abs() + b.abs() + c.abs() + noise);
            if discriminant > -explained {
                let root = discriminant.max(0.0).sqrt();
                return ordered(
                    values,
                    [mean - root, mean + root].each(|value| Complex::new(value, 0.0)),
                );
            }
            let root = (-discriminant).sqrt();
            return ordered(
                values,
                [-root, root].each(|imaginary| Complex::new(mean, imaginary)),
            );
        }
        2 => {
            let mean = (matrix[(0, 0)] + matrix[(1, 1)]) * 0.5;
            let half = (matrix[(0, 0)] - matrix[(1, 1)]) * 0.5;
            let (b, c) = (matrix[(0, 1)], matrix[(1, 0)]);
            let mut discriminant = half * half + b * c;
            let explained = 2.0 * noise * (half.norm() + b.norm() + c.norm() + noise);
            if discriminant.im.abs() <= explained {
                discriminant.im = 0.0;
            }
            if discriminant.im == 0.0 && (-explained..0.0).contains(&discriminant.re) {
                discriminant.re = 0.0;
            }
            let root = discriminant.sqrt();
            values[0] = mean - root;
            values[1] = mean + root;
        }
        3 if matrix.iter().all(|entry| entry.im == 0.0) => {
            let real = Matrix3::from_fn(|i, j| matrix[(i, j)].re);
            if let Some(found) = of_three_real(&real, noise) {
                values
                    .iter_mut()
                    .zip(found)
                    .for_each(|(value, known)| *value = known);
            }
        }
        _ => {
            let dynamic = nalgebra::DMatrix::from_fn(D, D, |i, j| matrix[(i, j)]);
            if let Some(found) = any_eigenvalues(&dynamic) {
                values
                    .iter_mut()
                    .zip(found)
                    .for_each(|(value, known)| *value = known);
                without_rounding(&mut values, matrix.norm(), noise);
            }
        }
    }
    values.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
    values
}

/// Makes eigenvalues real if rounding explains their imaginary parts. `noise` is the error of an entry of a matrix with the given norm.
///
/// By perturbation theory an eigenvalue at a distance `d` from the next eigenvalue changes by about `noise * norm / d`, and two coincident
/// eigenvalues separate by about `sqrt(noise * norm)`. A well separated eigenvalue therefore keeps an imaginary part just above the noise.
pub(crate) fn without_rounding(values: &mut [Complex], norm: f64, noise: f64) {
    const SAFETY: f64 = 32.0;
    let explained = |n: usize| {
        let others = values.iter().enumerate().filter(|(m, _)| *m != n);
        let distance = others
            .map(|(_, other)| (other - values[n]).norm())
            .fold(f64::INFINITY, f64::min);
        let sensitivity = 1.0 + norm / distance;
        SAFETY * (noise * sensitivity).min(noise + (noise * norm).sqrt())
    };
    let is_real: Vec<bool> = (0..values.len())
        .map(|n| values[n].im.abs() <= explained(n))
        .collect();
    for (value, is_real) in values.iter_mut().zip(is_real) {
        if is_real {
            value.im = 0.0;
        }
    }
}

/// Eigenvalues of a real 3 x 3 matrix: in closed form if they are well separated, by rotations for symmetric matrices, and otherwise from the blocks
/// of the Schur form, so that the treatment of two rows applies.
fn of_three_real(matrix: &Matrix3<f64>, noise: f64) -> Option<[Complex; 3]> {
    let entries = array_of(|e| matrix[(e / 3, e % 3)]);
    let deviator = Deviator::of(&entries);
    if deviator.is_apart(&entries, noise) {
        return Some(deviator.all().each(|value| Complex::new(value, 0.0)));
    }
    if (matrix - matrix.transpose()).amax() <= noise {
        let mean = |i: usize, j: usize| 0.5 * (matrix[(i, j)] + matrix[(j, i)]);
        let rows: [[f64; 3]; 3] = array_of(|i| array_of(|j| mean(i, j)));
        return Some(
            symmetric_eigen(&rows)
                .0
                .each(|value| Complex::new(value, 0.0)),
        );
    }
    if !matrix.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let schur = nalgebra::Schur::try_new(*matrix, f64::EPSILON, MAXIMUM_ITERATIONS)?;
    let (_, form) = schur.unpack();
    // Start of the 2 x 2 block that may be coupled, and the remaining row.
    let (start, alone) = if form[(1, 0)] == 0.0 { (1, 0) } else { (0, 2) };
    let block: Matrix2<f64> = form.fixed_view::<2, 2>(start, start).into_owned();
    let [first, second] = eigenvalues(&block.map(|entry| Complex::new(entry, 0.0)), noise);
    Some([first, second, Complex::new(form[(alone, alone)], 0.0)])
}

/// Stores two values in an array that is known to have two elements.
fn ordered<const D: usize>(mut values: [Complex; D], pair: [Complex; 2]) -> [Complex; D] {
    values
        .iter_mut()
        .zip(pair)
        .for_each(|(value, known)| *value = known);
    values
}

/// Returns a right eigenvector of a computed eigenvalue, of unit length, with a real and positive largest component.
///
/// For a degenerate eigenvalue it is one vector of the eigenspace.
pub fn eigenvector<const D: usize>(
    matrix: &SMatrix<Complex, D, D>,
    eigenvalue: Complex,
) -> SVector<Complex, D> {
    let shifted = matrix - SMatrix::<Complex, D, D>::identity() * eigenvalue;
    let mut vector = SVector::<Complex, D>::zeros();
    match D {
        1 => vector[0] = Complex::new(1.0, 0.0),
        2 => {
            // Both rows of (M - lambda) annihilate the vector; the longer row is more accurate.
            let rows = [0, 1].each(|row| (shifted[(row, 0)], shifted[(row, 1)]));
            let length = |(a, b): (Complex, Complex)| a.norm_sqr() + b.norm_sqr();
            let (a, b) = if length(rows[0]) >= length(rows[1]) {
                rows[0]
            } else {
                rows[1]
            };
            let scale = matrix.iter().map(|entry| entry.norm()).fold(0.0, f64::max);
            if length((a, b)).sqrt() <= 1e-14 * scale || length((a, b)) == 0.0 {
                vector[0] = Complex::new(1.0, 0.0);
            } else {
                vector[0] = -b;
                vector[1] = a;
            }
        }
        _ => {
            let dynamic = nalgebra::DMatrix::from_fn(D, D, |i, j| shifted[(i, j)]);
            let svd = dynamic.try_svd(false, true, f64::EPSILON, MAXIMUM_ITERATIONS);
            if let Some((values, adjoint)) =
                svd.and_then(|svd| Some((svd.singular_values, svd.v_t?)))
            {
                let smallest = values.imin();
                for i in 0..D {
                    vector[i] = adjoint[(smallest, i)].conj();
                }
            } else {
                vector[0] = Complex::new(1.0, 0.0);
            }
        }
    }
    normalized(vector)
}

/// Returns a left eigenvector `y` with `y^T M = lambda y^T` (no conjugation), normalized as for [`eigenvector`].
pub fn left_eigenvector<const D: usize>(
    matrix: &SMatrix<Complex, D, D>,
    eigenvalue: Complex,
) -> SVector<Complex, D> {
    eigenvector(&matrix.transpose(), eigenvalue)
}

/// Unit vector with a real and positive leading component.
pub(crate) fn normalized<const D: usize>(vector: SVector<Complex, D>) -> SVector<Complex, D> {
    let length = vector
        .iter()
        .map(|component| component.norm_sqr())
        .sum::<f64>()
        .sqrt();
    // The first of nearly equal components decides, so that rounding cannot flip the sign.
    let largest = vector
        .iter()
        .map(|component| component.norm())
        .fold(0.0, f64::max);
    let leading = vector
        .iter()
        .find(|component| component.norm() >= 0.999 * largest);
    let Some(&leading) = leading.filter(|leading| leading.norm() > 0.0) else {
        return vector;
    };
    let phase = leading.conj() / leading.norm();
    let result = vector.map(|component| component * phase / length);
    // Adding zero converts the negative zeros of the rotation to positive ones.
    result.map(|component| Complex::new(component.re + 0.0, component.im + 0.0))
}
