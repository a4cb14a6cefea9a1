//! Neighborhoods of scattered particles in the reference configuration, with deformation gradients and short waves of their positions.

use nalgebra::{DMatrix, Matrix3, Vector3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Distances that differ by less than this fraction of the radius count as equal to it.
const RIM: f64 = 1e-9;
/// Smallest ratio of the singular values of neighbors that determine a gradient.
const SINGULAR: f64 = 1e-6;

/// Smallest ratio of the eigenvalues of normal equations that determine a polynomial.
const REGULAR: f64 = 1e-4;
/// Largest distance of the mean position of the neighbors from the particle, divided by their mean distance, in a neighborhood that no face cuts.
const CUT_NEIGHBORHOOD_OFFSET: f64 = 0.2;

/// Largest fraction of the residual of a particle that the mean residual of its neighbors can have in short waves. Waves of four spacings have this
/// fraction in a square lattice; longer waves, and gradients of strain, have more.
const SHARED_RESIDUAL: f64 = 0.2;

/// Short waves of a field at the particles.
pub(super) struct ShortWaves {
    /// Amplitudes: lengths of the residuals.
    pub(super) amplitude: Vec<f64>,
    /// Whether the neighbors of a particle have a similar residual, so that the field is curved smoothly there: a gradient of strain, or a longer wave.
    pub(super) is_smooth: Vec<bool>,
}

/// Neighbors of each particle within a radius in the reference configuration.
pub(crate) struct Neighborhoods {
    dimension: usize,
    starts: Vec<usize>,
    neighbors: Vec<Neighbor>,
}

struct Neighbor {
    number: u32,
    /// Least-squares gradient: `F = sum_j (x_j - x_i) (x) gradient_j`; 1/length.
    gradient: Vector3<f64>,
    /// Weight of the neighbor in the value at the particle of a fit to the neighbors.
    fit: f64,
}

/// Least-squares gradients, and weights of a [`value_at_origin`], for neighbors at the given vectors; `None` if the vectors do not determine them.
fn fitted(vectors: &[Vector3<f64>], dimension: usize) -> Option<Vec<(Vector3<f64>, f64)>> {
    let mut moment = Matrix3::from_diagonal_element(0.0);
    for vector in vectors {
        moment += vector * vector.transpose();
    }
    let scale = moment.trace().max(f64::MIN_POSITIVE);
    for axis in dimension..3 {
        moment[(axis, axis)] = scale;
    }
    let values = moment.symmetric_eigenvalues();
    let is_regular = values.min() > SINGULAR * values.max();
    if !is_regular {
        return None;
    }
    let inverse = moment.try_inverse()?;
    let length = (scale / vectors.len() as f64).sqrt();
    let scaled: Vec<Vector3<f64>> = vectors.iter().map(|vector| vector / length).collect();
    let mean = scaled.iter().sum::<Vector3<f64>>() / scaled.len() as f64;
    let is_cut = mean.norm() > CUT_NEIGHBORHOOD_OFFSET;
    let quadratic = || {
        is_cut
            .then(|| value_at_origin(&scaled, dimension, 2))
            .flatten()
    };
    let weights = quadratic().or_else(|| value_at_origin(&scaled, dimension, 1))?;
    let gradients = vectors.iter().map(|vector| inverse * vector);
    Some(gradients.zip(weights).collect())
}

/// Weights of the neighbors in the value at the origin of a fitted polynomial of order 1 or 2; `None` if the vectors do not determine it.
fn value_at_origin(vectors: &[Vector3<f64>], dimension: usize, order: usize) -> Option<Vec<f64>> {
    let basis = |vector: &Vector3<f64>| -> Vec<f64> {
        let mut terms = vec![1.0];
        terms.extend(vector.iter().take(dimension));
        if order > 1 {
            for i in 0..dimension {
                terms.extend((i..dimension).map(|j| vector[i] * vector[j]));
            }
        }
        terms
    };
    let rows: Vec<Vec<f64>> = vectors.iter().map(basis).collect();
    let count = rows.first()?.len();
    let mut normal = DMatrix::<f64>::zeros(count, count);
    for row in &rows {
        for i in 0..count {
            for j in 0..count {
                normal[(i, j)] += row[i] * row[j];
            }
        }
    }
    let values = normal.symmetric_eigenvalues();
    let is_regular = values.min() > REGULAR * values.max();
    if !is_regular {
        return None;
    }
    let first = normal.try_inverse()?.row(0).into_owned();
    let weight = |row: &Vec<f64>| row.iter().zip(first.iter()).map(|(a, b)| a * b).sum();
    Some(rows.iter().map(weight).collect())
}

/// Numbers of the particles within a radius of each of the first `count` particles, with their vectors from it, by their numbers.
fn near(
    count: usize,
    reference: &[[f64; 3]],
    dimension: usize,
    radius: f64,
) -> impl Iterator<Item = Vec<(u32, Vector3<f64>)>> {
    let cell = move |x: &[f64; 3]| x.map(|x| (x / radius).floor() as i64);
    let mut boxes: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    for (n, x) in reference.iter().enumerate() {
        boxes.entry(cell(x)).or_default().push(n as u32);
    }
    let depth = if dimension > 2 { 1 } else { 0 };
    let height = if dimension > 1 { 1 } else { 0 };
    let all = reference.iter().enumerate().take(count);
    all.map(move |(n, x)| {
        let center = cell(x);
        let mut near: Vec<(u32, Vector3<f64>)> = Vec::new();
        for a in -1..=1 {
            for b in -height..=height {
                for c in -depth..=depth {
                    // The conversion of a huge coordinate saturates; a wrapped number finds particles that are far away.
                    let at = [(0, a), (1, b), (2, c)]
                        .map(|(axis, step): (usize, i64)| center[axis].wrapping_add(step));
                    for other in boxes.get(&at).into_iter().flatten() {
                        let y = &reference[*other as usize];
                        let mut apart = Vector3::zeros();
                        for axis in 0..dimension {
                            apart[axis] = y[axis] - x[axis];
                        }
                        let is_near = apart.norm() <= radius * (1.0 + RIM);
                        if is_near && *other as usize != n {
                            near.push((*other, apart));
                        }
                    }
                }
            }
        }
        near.sort_by_key(|(number, _)| *number);
        near
    })
}

/// Numbers of the particles within a radius of each particle, even if they determine no gradient.
pub(super) fn within(reference: &[[f64; 3]], dimension: usize, radius: f64) -> Vec<Vec<usize>> {
    let all = near(reference.len(), reference, dimension, radius);
    let numbers = |own: Vec<(u32, Vector3<f64>)>| own.iter().map(|(n, _)| *n as usize).collect();
    all.map(numbers).collect()
}

impl Neighborhoods {
    /// Finds the neighbors within a radius of each particle.
    pub(super) fn new(reference: &[[f64; 3]], dimension: usize, radius: f64) -> Self {
        Self::of_first(reference.len(), reference, dimension, radius)
    }

    /// Finds the neighbors of the first `count` particles among all particles.
    pub(crate) fn of_first(
        count: usize,
        reference: &[[f64; 3]],
        dimension: usize,
        radius: f64,
    ) -> Self {
        let (mut starts, mut neighbors) = (vec![0], Vec::new());
        for near in near(count, reference, dimension, radius) {
            let vectors: Vec<Vector3<f64>> = near.iter().map(|(_, apart)| *apart).collect();
            if let Some(fits) = fitted(&vectors, dimension) {
                let all = near.iter().zip(fits);
                neighbors.extend(all.map(|((number, _), (gradient, fit))| Neighbor {
                    number: *number,
                    gradient,
                    fit,
                }));
            }
            starts.push(neighbors.len());
        }
        Self {
            dimension,
            starts,
            neighbors,
        }
    }

    /// Number of space dimensions.
    pub(crate) fn dimension(&self) -> usize {
        self.dimension
    }

    pub(super) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    fn of(&self, particle: usize) -> &[Neighbor] {
        &self.neighbors[self.starts[particle]..self.starts[particle + 1]]
    }

    /// Number of neighbors of a particle; zero if they determine no gradient.
    pub(super) fn count(&self, particle: usize) -> usize {
        self.of(particle).len()
    }

    /// Numbers of the neighbors of a particle.
    pub(super) fn numbers(&self, particle: usize) -> impl Iterator<Item = usize> {
        self.of(particle).iter().map(|own| own.number as usize)
    }

    /// Deformation gradient of a particle, `sum_j (x_j - x_i) (x) gradient_j`, with the identity beyond the dimensions; `None` without enough neighbors.
    pub(crate) fn deformation(&self, particle: usize, x: &[[f64; 3]]) -> Option<Matrix3<f64>> {
        if self.count(particle) == 0 {
            return None;
        }
        let mut f = self.gradient(particle, x);
        for axis in self.dimension..3 {
            f[(axis, axis)] = 1.0;
        }
        Some(f)
    }

    /// Gradient of a field at a particle, `sum_j (u_j - u_i) (x) gradient_j`; zero without enough neighbors.
    pub(super) fn gradient(&self, particle: usize, x: &[[f64; 3]]) -> Matrix3<f64> {
        let mut f = Matrix3::zeros();
        let own = &x[particle];
        for neighbor in self.of(particle) {
            let other = &x[neighbor.number as usize];
            for i in 0..self.dimension {
                for j in 0..self.dimension {
                    f[(i, j)] += (other[i] - own[i]) * neighbor.gradient[j];
                }
            }
        }
        f
    }

    /// Residual of a field against fits to the neighbors: linear functions inside, quadratic ones at faces, whose neighborhoods are one-sided.
    ///
    /// A fit amplifies random noise more than a mean over the neighbors does. Residuals are divided by this factor.
    fn residual(&self, field: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let of = |n: usize| {
            let neighbors = self.of(n);
            let (mut rest, mut squares) = (field[n], 1.0);
            for neighbor in neighbors {
                rest -= field[neighbor.number as usize] * neighbor.fit;
                squares += neighbor.fit * neighbor.fit;
            }
            match neighbors.len() {
                0 => Vector3::zeros(),
                count => rest * ((1.0 + 1.0 / count as f64) / squares).sqrt(),
            }
        };
        (0..self.len()).into_par_iter().map(of).collect()
    }

    /// Amplitudes of the short waves of a field: lengths of its residuals against fits to the neighbors, taken twice.
    ///
    /// The amplitude vanishes for fields with a constant gradient, is small for smooth fields, and about `a` for particles that alternate by `a`.
    pub(super) fn short_waves(&self, field: &[[f64; 3]]) -> ShortWaves {
        let own: Vec<Vector3<f64>> = field.iter().map(|x| Vector3::from(*x)).collect();
        let twice = self.residual(&self.residual(&own));
        let is_smooth = |n: usize| {
            let near = self.of(n);
            let shared: f64 = near
                .iter()
                .map(|other| twice[n].dot(&twice[other.number as usize]))
                .sum();
            shared > SHARED_RESIDUAL * near.len() as f64 * twice[n].norm_squared()
        };
        ShortWaves {
            amplitude: twice.iter().map(|rest| rest.norm()).collect(),
            is_smooth: (0..self.len()).map(is_smooth).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Neighborhoods;

    fn lattice(side: usize) -> Vec<[f64; 3]> {
        let at = |n: usize| [(n % side) as f64, (n / side) as f64, 0.0];
        (0..side * side).map(at).collect()
    }

    #[test]
    fn the_gradient_of_a_homogeneous_deformation_is_exact_and_no_short_waves_are_found() {
        let reference = lattice(9);
        let near = Neighborhoods::new(&reference, 2, 2.01);
        let x: Vec<[f64; 3]> = reference
            .iter()
            .map(|[a, b, _]| [1.2 * a + 0.3 * b + 5.0, -0.1 * a + 0.9 * b, 0.0])
            .collect();
        for n in 0..reference.len() {
            let f = near.deformation(n, &x).expect("a gradient");
            let apart = [
                f[(0, 0)] - 1.2,
                f[(0, 1)] - 0.3,
                f[(1, 0)] + 0.1,
                f[(1, 1)] - 0.9,
            ];
            assert!(apart.iter().all(|x| x.abs() < 1e-12));
            assert_eq!(f[(2, 2)], 1.0);
        }
        assert!(near.short_waves(&x).amplitude.iter().all(|a| *a < 1e-12));
    }

    #[test]
    fn particles_at_huge_distances_are_not_neighbors() {
        let mut reference = lattice(5);
        reference.extend([[1e99, 0.0, 0.0], [-1e99, 0.0, 0.0]]);
        let near = Neighborhoods::new(&reference, 2, 2.01);
        assert_eq!((near.count(25), near.count(26)), (0, 0));
        assert!(near.count(12) > 0);
    }

    #[test]
    fn smooth_bending_adds_few_short_waves_at_faces() {
        let reference = lattice(15);
        let near = Neighborhoods::new(&reference, 2, 2.01);
        let x: Vec<[f64; 3]> = reference
            .iter()
            .map(|[a, b, _]| [a + 0.02 * a * b, b + 0.01 * a * a, 0.0])
            .collect();
        let short = near.short_waves(&x).amplitude;
        let at = |column: usize, row: usize| short[row * 15 + column];
        assert!(at(7, 7) < 1e-12);
        // A linear fit would have a residual of about 0.02.
        assert!(at(7, 0) < 2e-3, "{}", at(7, 0));
    }

    #[test]
    fn the_short_wave_measure_of_alternating_particles_is_about_their_amplitude() {
        let reference = lattice(15);
        let near = Neighborhoods::new(&reference, 2, 2.01);
        let x: Vec<[f64; 3]> = reference
            .iter()
            .map(|[a, b, _]| [a + 0.01 * (-1.0_f64).powi(*a as i32), *b, 0.0])
            .collect();
        let inside = near.short_waves(&x).amplitude[7 * 15 + 7];
        assert!((0.008..0.015).contains(&inside), "{inside}");
    }

    /// Waves along the first axis with a wavelength in spacings.
    #[test]
    fn gradients_of_strain_and_waves_longer_than_four_spacings_are_smooth() {
        let reference = lattice(25);
        let near = Neighborhoods::new(&reference, 2, 2.01);
        let is_smooth = |of: &dyn Fn(f64) -> f64| {
            let x: Vec<[f64; 3]> = reference
                .iter()
                .map(|[a, b, _]| [a + of(*a), *b, 0.0])
                .collect();
            near.short_waves(&x).is_smooth[12 * 25 + 12]
        };
        for (length, expected) in [(2.0, false), (3.0, false), (4.0, false), (6.0, true)] {
            let wave = |a: f64| 0.01 * (std::f64::consts::TAU * (a - 12.0) / length).cos();
            assert_eq!(is_smooth(&wave), expected, "{length}");
        }
        assert!(is_smooth(&|a| 2e-5 * (a - 12.0).powi(4)));
    }
}
