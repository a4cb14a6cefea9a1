//! Stable time steps from the largest frequency of a body.

use crate::algebra::{Complex, any_eigenvalues, uniform};
use crate::motion::Fault;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Largest number of vectors in the Krylov space.
const MAXIMUM_VECTORS: usize = 32;
/// Largest number of components of all vectors in the Krylov space, unless it has only [`MINIMUM_VECTORS`] vectors.
const NUMBERS: usize = 1 << 27;
/// Smallest number of vectors in the Krylov space.
const MINIMUM_VECTORS: usize = 6;
/// Largest number of matrix-vector products: the lower and upper limit, and the limit on the number of components of all images.
const IMAGES: (usize, usize, usize) = (60, 2000, 200_000_000);
/// Ratio of residual to eigenvalue at which the iteration stops.
const RESIDUAL: f64 = 5e-7;
/// Number of restarts without half the residual, and largest ratio of residual to eigenvalue, at which an iteration that stalls is ended. Maps that are not
/// symmetric can stall.
const STALLED: (usize, f64) = (8, 1e-3);
/// Number of matrix-vector products between two estimates of a bound.
const ESTIMATED_IMAGES: usize = 4;
/// Factor of the mean error of a Krylov space in these estimates: few starts have twice the mean error.
const ESTIMATE_FACTOR: f64 = 2.0;
/// Largest imaginary part of a real eigenvalue, relative to its magnitude. It is rounding.
const REAL_TOLERANCE: f64 = 1e-10;
/// Displacement for the numerical differentiation of forces, in spacings.
pub(super) const DIFFERENCE_STEP: f64 = 1e-5;

/// Image of a vector under a linear map.
type Image = Result<Vec<f64>, Box<Fault>>;

/// Returns an upper bound of the eigenvalue with the largest real part of a linear map, or zero if this part is not positive. A complex pair is
/// represented by its magnitude.
///
/// The map must be symmetric in some norm, at least nearly. The bound is the Ritz value of a restarted Krylov method plus its residual.
/// It exceeds the eigenvalue by at most [`RESIDUAL`] if the iteration converges. For long vectors the iteration is truncated, and it also ends if it
/// stalls. The result is then the Ritz value with the smallest residual, and at least the mean error of a Krylov space with a random start is added,
/// `0.103 (ln(n (k-1)^2) / (k-1))^2`.
///
/// The arguments of the map are a vector and the size of its largest component. The iteration ends as soon as an estimate of the bound lies below
/// `known`, and this estimate is then returned.
///
/// Source: Stathopoulos, Saad and Wu, SIAM J. Sci. Comput. 19 (1998) 227 (restarts); Kuczynski and Wozniakowski, SIAM J. Matrix Anal. Appl. 13 (1992)
/// 1094 (mean error).
pub(super) fn largest_eigenvalue(
    unknowns: usize,
    map: &mut dyn FnMut(&[f64], f64) -> Image,
    known: f64,
) -> Result<f64, Box<Fault>> {
    let mode = largest_mode(unknowns, map, known)?;
    Ok(mode.map_or(0.0, |(bound, _)| bound.max(0.0)))
}

/// Bound of [`largest_eigenvalue`] with its Ritz vector, a unit vector; `None` if all images vanish.
pub(super) fn largest_mode(
    unknowns: usize,
    map: &mut dyn FnMut(&[f64], f64) -> Image,
    known: f64,
) -> Result<Option<(f64, Vec<f64>)>, Box<Fault>> {
    let most = (NUMBERS / (2 * unknowns.max(1)))
        .clamp(MINIMUM_VECTORS, MAXIMUM_VECTORS)
        .min(unknowns);
    let (least, last, numbers) = IMAGES;
    let allowed = (numbers / unknowns.max(1)).clamp(least, last);
    let mut random = 1;
    let start = (0..unknowns).map(|_| 2.0 * uniform(&mut random) - 1.0);
    let mut space = Space::default();
    let mut next = unit(start.collect());
    let mut images: usize = 0;
    // Smallest residual, with its Ritz value and vector, and the number of restarts since it was halved.
    let mut best: Option<(f64, f64, Vec<f64>)> = None;
    let mut stalled = 0;
    let mean_error = |images: usize| {
        let steps = (images - 1) as f64;
        0.103 * ((unknowns as f64 * steps * steps).ln() / steps).powi(2)
    };
    loop {
        while space.vectors.len() < most {
            let Some(vector) = next.take() else { break };
            let highest = vector.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let image = map(&vector, highest)?;
            images += 1;
            space.add(vector, image);
            next = space.images.last().and_then(|image| space.beyond(image));
            if images.is_multiple_of(ESTIMATED_IMAGES)
                && let Some(ritz) = space.rightmost()
            {
                let (value, missed) = (ritz.size(), missed(&space.residuals(&ritz)));
                let bound = value + missed + ESTIMATE_FACTOR * mean_error(images) * value;
                if bound < known {
                    return Ok(Some((bound, space.mode(&ritz))));
                }
            }
        }
        let Some(ritz) = space.rightmost() else {
            return Ok(None);
        };
        let value = ritz.size();
        let residuals = space.residuals(&ritz);
        let missed = missed(&residuals);
        if missed <= RESIDUAL * value.abs() || space.vectors.len() == unknowns {
            return Ok(Some((value + missed, space.mode(&ritz))));
        }
        stalled = match &best {
            Some((smallest, ..)) if missed > 0.5 * smallest => stalled + 1,
            _ => 0,
        };
        if best
            .as_ref()
            .is_none_or(|(smallest, ..)| missed < *smallest)
        {
            best = Some((missed, value, space.mode(&ritz)));
        }
        if let Some((missed, value, mode)) = &best
            && (images >= allowed || stalled >= STALLED.0 && *missed <= STALLED.1 * value.abs())
        {
            let bound = value + missed.max(mean_error(images) * value);
            return Ok(Some((bound, mode.clone())));
        }
        let mode = space.mode(&ritz);
        space.restart(&ritz, most / 3);
        next = residuals.iter().find_map(|residual| space.beyond(residual));
        if next.is_none() {
            return Ok(Some((value + missed, mode)));
        }
    }
}

/// Norm of the residual of a Ritz value, given its real and imaginary part.
fn missed(residuals: &[Vec<f64>]) -> f64 {
    residuals
        .iter()
        .map(|own| dot(own, own))
        .sum::<f64>()
        .sqrt()
}

fn norm(vector: &[f64]) -> f64 {
    dot(vector, vector).sqrt()
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Normalizes a vector; `None` for the zero vector.
pub(super) fn unit(mut vector: Vec<f64>) -> Option<Vec<f64>> {
    let length = norm(&vector);
    vector.iter_mut().for_each(|x| *x /= length);
    (length > 0.0 && length.is_finite()).then_some(vector)
}

/// Approximate eigenvalue of a linear map, with its vector in coordinates of a space.
struct Ritz {
    value: Complex,
    /// Real part of the unit vector, and the imaginary part if the value is complex.
    parts: Vec<DVector<f64>>,
}

impl Ritz {
    /// Real value, or magnitude of a complex value with a positive real part.
    fn size(&self) -> f64 {
        match self.value.re > 0.0 {
            true => self.value.norm(),
            false => self.value.re,
        }
    }
}

/// Orthonormal vectors with their images under a linear map, and the projection of the map onto their space.
#[derive(Default)]
pub(super) struct Space {
    pub(super) vectors: Vec<Vec<f64>>,
    pub(super) images: Vec<Vec<f64>>,
    /// Projection of the map, `v_i . A v_j`.
    pub(super) within: DMatrix<f64>,
}

impl Space {
    pub(super) fn add(&mut self, vector: Vec<f64>, image: Vec<f64>) {
        self.vectors.push(vector);
        self.images.push(image);
        let count = self.vectors.len();
        let mut within = std::mem::take(&mut self.within).resize(count, count, 0.0);
        for n in 0..count {
            within[(n, count - 1)] = dot(&self.vectors[n], &self.images[count - 1]);
            within[(count - 1, n)] = dot(&self.vectors[count - 1], &self.images[n]);
        }
        self.within = within;
    }

    /// Normalized part of a vector that is orthogonal to the space; `None` if this part is a rounding error.
    pub(super) fn beyond(&self, vector: &[f64]) -> Option<Vec<f64>> {
        let mut rest = vector.to_vec();
        let whole = norm(&rest);
        // The second pass removes the errors of cancellation.
        for _ in 0..2 {
            for own in &self.vectors {
                let share = dot(own, &rest);
                rest.iter_mut()
                    .zip(own)
                    .for_each(|(rest, own)| *rest -= share * own);
            }
        }
        (norm(&rest) > f64::EPSILON.sqrt() * 1e-3 * whole)
            .then(|| unit(rest))
            .flatten()
    }

    /// Ritz value with the largest real part.
    fn rightmost(&self) -> Option<Ritz> {
        let count = self.within.nrows();
        let values = any_eigenvalues(&self.within.map(|x| Complex::new(x, 0.0)))?;
        let value = values.into_iter().max_by(|a, b| a.re.total_cmp(&b.re))?;
        let size = self.within.amax().max(f64::MIN_POSITIVE);
        let shift = value + Complex::new(1e-12 * size, 0.0);
        let shifted = DMatrix::from_fn(count, count, |i, j| {
            let own = Complex::new(self.within[(i, j)], 0.0);
            own - if i == j {
                shift
            } else {
                Complex::new(0.0, 0.0)
            }
        });
        let solver = shifted.lu();
        let mut ritz = DVector::from_element(count, Complex::new(1.0, 0.0));
        for _ in 0..3 {
            ritz = solver.solve(&ritz)?;
            ritz /= Complex::new(ritz.norm(), 0.0);
        }
        let largest = ritz.iter().max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
        let phase = largest.conj() / largest.norm();
        let ritz = ritz.map(|x| x * phase);
        let real = ritz.map(|x| x.re);
        Some(match value.im.abs() <= REAL_TOLERANCE * value.norm() {
            true => Ritz {
                value: value.re.into(),
                parts: vec![&real / real.norm()],
            },
            false => Ritz {
                value,
                parts: vec![real, ritz.map(|x| x.im)],
            },
        })
    }

    /// Real part of the vector of a Ritz value, normalized.
    fn mode(&self, ritz: &Ritz) -> Vec<f64> {
        let mode = Self::combined(&self.vectors, ritz.parts[0].as_slice());
        unit(mode).unwrap_or_default()
    }

    /// Linear combination of vectors.
    pub(super) fn combined(vectors: &[Vec<f64>], shares: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; vectors[0].len()];
        for (vector, share) in vectors.iter().zip(shares) {
            sum.iter_mut()
                .zip(vector)
                .for_each(|(sum, x)| *sum += share * x);
        }
        sum
    }

    /// Real and imaginary part of the residual of a Ritz value.
    fn residuals(&self, ritz: &Ritz) -> Vec<Vec<f64>> {
        let of = |vectors: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let parts = ritz.parts.iter();
            parts
                .map(|part| Self::combined(vectors, part.as_slice()))
                .collect()
        };
        let (vectors, mut images) = (of(&self.vectors), of(&self.images));
        // `(a + i b) (x + i y) = (a x - b y) + i (b x + a y)`
        let (a, b) = (ritz.value.re, ritz.value.im);
        let mut subtract = |part: usize, factor: f64, vector: &[f64]| {
            let both = images[part].iter_mut().zip(vector);
            both.for_each(|(image, x)| *image -= factor * x);
        };
        subtract(0, a, &vectors[0]);
        if let Some(imaginary) = vectors.get(1) {
            subtract(0, -b, imaginary);
            subtract(1, b, &vectors[0]);
            subtract(1, a, imaginary);
        }
        images
    }

    /// Keeps a Ritz vector, and the vectors of the largest eigenvalues of the symmetric part.
    fn restart(&mut self, ritz: &Ritz, kept: usize) {
        let symmetric = SymmetricEigen::new((&self.within + self.within.transpose()) * 0.5);
        let mut order: Vec<usize> = (0..symmetric.eigenvalues.len()).collect();
        order.sort_by(|a, b| symmetric.eigenvalues[*b].total_cmp(&symmetric.eigenvalues[*a]));
        let mut shares = Self::default();
        let columns = order.iter().take(kept.max(1));
        let columns = columns.map(|n| symmetric.eigenvectors.column(*n).into_owned());
        for column in ritz.parts.iter().cloned().chain(columns) {
            if let Some(share) = shares.beyond(column.as_slice()) {
                shares.vectors.push(share);
            }
        }
        let old = std::mem::take(self);
        for share in &shares.vectors {
            let vector = Self::combined(&old.vectors, share);
            self.add(vector, Self::combined(&old.images, share));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::largest_eigenvalue;
    use crate::algebra::uniform;
    use nalgebra::{DMatrix, DVector};

    /// Diagonal blocks `(a, b; -b, a)` have the eigenvalues `a +- i b`. They do not change under a random orthogonal transformation.
    #[test]
    fn of_a_complex_pair_the_magnitude_is_the_bound() {
        let (n, mut state) = (60, 3);
        let mut blocks = DMatrix::<f64>::zeros(n, n);
        for i in (0..n).step_by(2) {
            let (a, b) = (1.0 + i as f64, if i + 2 == n { 4.0 } else { 0.0 });
            blocks[(i, i)] = a;
            blocks[(i + 1, i + 1)] = a - 0.3 * f64::from(u8::from(b == 0.0));
            (blocks[(i, i + 1)], blocks[(i + 1, i)]) = (b, -b);
        }
        let turn = DMatrix::from_fn(n, n, |_, _| uniform(&mut state) - 0.5)
            .qr()
            .q();
        let matrix = &turn * blocks * turn.transpose();
        let mut images = 0;
        let mut image = |own: &[f64], _| {
            images += 1;
            Ok((&matrix * DVector::from_column_slice(own))
                .as_slice()
                .to_vec())
        };
        let bound = largest_eigenvalue(n, &mut image, f64::NEG_INFINITY).expect("a bound");
        let exact = (f64::from(n as u32 - 1).powi(2) + 16.0).sqrt();
        assert!(
            (0.0..1e-6 * exact).contains(&(bound - exact)),
            "{bound} {exact}"
        );
        assert!(images < 200, "{images}");
    }
}
