//! Stiffnesses without major symmetry, whose acoustic tensors can have complex eigenvalues.
//!
//! All eigenvalues of a real 3 x 3 matrix `M` have positive real parts if and only if (Routh and Hurwitz) its trace, its determinant, and
//! `tr M m - det M` are positive. Here `m` is the sum of the principal minors of order two. The determinant alone is not a test: two eigenvalues can
//! change sign together. For `M = Q(N) - level |N|^2` the three are homogeneous polynomials in the weights of `N = alpha a + beta b + gamma c`. In a
//! cone where all their coefficients are positive, every real part exceeds the level.

use super::cover::{Cover, Triangle, cover, octants};
use super::descent::across;
use super::form::Form;
use super::{Axes, Blocks, Minimum, dot, spread, symmetric_minimum};
use crate::algebra::{Complex, Deviator, Each, array_of, eigenvalues, sort_by_value};
use nalgebra::{Matrix3, SMatrix};

/// Number of directions at which descents of the real part start.
const STARTS: usize = 4;
/// Number of directions that are followed to the largest imaginary part.
const FLUTTERING: usize = 4;
/// Longest step of a descent, an angle.
const LONGEST_STEP: f64 = 0.2;
/// Shortest step before the best directions are known.
const COARSE_STEP: f64 = 1e-3;
/// Shortest step of a descent to a minimum.
const FINEST_STEP: f64 = 1e-9;
/// Largest number of steps of a descent.
const DESCENT_STEPS: usize = 60;
/// Distance of directions whose differences are derivatives, an angle.
const DIFFERENCE: f64 = 1e-4;
/// Largest difference between the real parts of symmetric images of one direction.
const IMAGE_TOLERANCE: f64 = 1e-13;
/// Largest number of triangles of a cover.
const BUDGET: usize = 6_000;
/// Largest number of covers that may lead to a lower value.
const COVERS: usize = 8;
/// Distances of the bound below the smallest value found. The next distance is tried if the previous bound cannot be proved.
const RESOLUTIONS: [f64; 3] = [1e-8, 1e-4, 1e-2];

type Blocks3 = [[Matrix3<f64>; 3]; 3];

pub(super) fn minimum<const D: usize>(
    blocks: &Blocks<D>,
    symmetric_part: &Form<f64>,
    below: f64,
) -> Minimum {
    let blocks = in_three_dimensions(blocks);
    let real_part = |n: &Axes<f64>| lowest_real_part(&blocks, n);
    let mut best = found(&blocks);
    let mut bound = f64::NEG_INFINITY;
    'resolutions: for (n, resolution) in RESOLUTIONS.into_iter().enumerate() {
        if n == 1 {
            // No real part is below the smallest eigenvalue of the symmetric part (Bendixson).
            bound = symmetric_minimum(symmetric_part, below).1;
        }
        for _ in 0..COVERS {
            let level = (best.0 - resolution).min(below);
            if bound >= level {
                break 'resolutions;
            }
            match cover(octants(false), BUDGET, |triangle| {
                exceeds(&blocks, level, triangle)
            }) {
                Cover::Above => bound = level,
                Cover::Fails(direction) => {
                    let n = unit(direction);
                    let end = descended((real_part(&n), n), &real_part, FINEST_STEP);
                    if end.0 >= best.0 {
                        break;
                    }
                    best = end;
                }
                Cover::Open(_) => break,
            }
        }
    }
    Minimum {
        direction: best.1,
        eigenpair: None,
        bound: bound.min(best.0),
    }
}

/// Lowest real part found by descents from the lowest of evenly spread directions, with its direction.
fn found(blocks: &Blocks3) -> (f64, Axes<f64>) {
    let real_part = |n: &Axes<f64>| lowest_real_part(blocks, n);
    let starts = spread(false).map(unit).map(|n| (real_part(&n), n));
    distinct(starts.collect())
        .into_iter()
        .take(STARTS)
        .map(|start| descended(start, &real_part, FINEST_STEP))
        .reduce(|best, end| if end.0 < best.0 { end } else { best })
        .unwrap_or((f64::NAN, [1.0, 0.0, 0.0]))
}

/// Sorts the directions by their value and keeps one of each set of symmetric images.
fn distinct(mut all: Vec<(f64, Axes<f64>)>) -> Vec<(f64, Axes<f64>)> {
    sort_by_value(&mut all, |item| item.0);
    all.dedup_by(|b, a| b.0 - a.0 <= IMAGE_TOLERANCE);
    all
}

/// Direction of the largest imaginary part found; an arbitrary direction if all eigenvalues are real.
pub(in crate::continuum) fn fluttering_direction<const D: usize>(blocks: &Blocks<D>) -> Axes<f64> {
    let blocks = in_three_dimensions(blocks);
    let discriminant = |n: &Axes<f64>| discriminant(&combined(&blocks, n, n));
    let imaginary = |n: &Axes<f64>| {
        let values = acoustic_eigenvalues(&blocks, n);
        -values
            .iter()
            .fold(0.0_f64, |most, value| most.max(value.im))
    };
    let ends = spread(false).map(unit).map(|n| {
        let (value, n) = descended((discriminant(&n), n), &discriminant, COARSE_STEP);
        match imaginary(&n) {
            // Directions with real eigenvalues are sorted by the discriminant, lowest first.
            0.0 => (value.max(0.0), n),
            found => descended((found, n), &imaginary, COARSE_STEP),
        }
    });
    let mut ends: Vec<(f64, Axes<f64>)> = ends.collect();
    sort_by_value(&mut ends, |item| item.0);
    let followed = ends.iter().take(FLUTTERING).map(|end| match end.0 < 0.0 {
        true => descended(*end, &imaginary, FINEST_STEP),
        // Complex eigenvalues in a narrow range between real eigenvalues are found only by minimizing the discriminant.
        false => {
            let (_, n) = descended((discriminant(&end.1), end.1), &discriminant, FINEST_STEP);
            descended((imaginary(&n), n), &imaginary, FINEST_STEP)
        }
    });
    let best = followed.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or([1.0, 0.0, 0.0], |best| best.1)
}

/// Discriminant of the characteristic polynomial up to a factor; negative if two eigenvalues are complex.
fn discriminant(tensor: &Matrix3<f64>) -> f64 {
    Deviator::of(&array_of(|e| tensor[(e / 3, e % 3)])).discriminant()
}

fn lowest_real_part(blocks: &Blocks3, n: &Axes<f64>) -> f64 {
    acoustic_eigenvalues(blocks, n)[0].re
}

/// Eigenvalues of the acoustic tensor, sorted by real part.
fn acoustic_eigenvalues(blocks: &Blocks3, n: &Axes<f64>) -> [Complex; 3] {
    let tensor = combined(blocks, n, n).map(|entry| Complex::new(entry, 0.0));
    eigenvalues(&tensor, 0.0)
}

fn in_three_dimensions<const D: usize>(blocks: &Blocks<D>) -> Blocks3 {
    array_of(|j| array_of(|l| SMatrix::from_fn(|i, k| blocks[j][l][(i, k)])))
}

/// Contraction `T_iJkL a_J b_L`, symmetric in `a` and `b` because the stiffness is symmetric in `J` and `L`.
fn combined(blocks: &Blocks3, a: &Axes<f64>, b: &Axes<f64>) -> Matrix3<f64> {
    let mut sum = Matrix3::zeros();
    for j in 0..3 {
        for l in 0..3 {
            sum += blocks[j][l] * (a[j] * b[l]);
        }
    }
    sum
}

fn unit(n: Axes<f64>) -> Axes<f64> {
    let length = dot(&n, &n).sqrt();
    n.each(|component| component / length)
}

/// Newton's method on the sphere, with derivatives from differences, until no step longer than `finest` decreases the value.
///
/// Steps do not depend on the axes. Where the curvature is negative, the longest step is taken. Where eigenvalues cross, the lowest has a ridge, and
/// every step along the mean slope descends.
fn descended(
    (mut value, mut direction): (f64, Axes<f64>),
    objective: &impl Fn(&Axes<f64>) -> f64,
    finest: f64,
) -> (f64, Axes<f64>) {
    for _ in 0..DESCENT_STEPS {
        let [a, b] = across(&direction);
        let at = |x: f64, y: f64| unit(array_of(|i| direction[i] + x * a[i] + y * b[i]));
        let step = newton_step(value, |x, y| objective(&at(x, y)));
        let length = step[0].hypot(step[1]);
        let shares = std::iter::successors(Some(1.0), |share| Some(0.25 * share));
        let mut trials = shares
            .take_while(|share| share * length > finest)
            .map(|share| at(share * step[0], share * step[1]))
            .map(|n| (objective(&n), n));
        let Some(lower) = trials.find(|trial| trial.0 < value) else {
            return (value, direction);
        };
        (value, direction) = lower;
    }
    (value, direction)
}

/// Step of Newton's method from a function of two coordinates at zero, where it has a given value.
fn newton_step(value: f64, function: impl Fn(f64, f64) -> f64) -> [f64; 2] {
    let h = DIFFERENCE;
    let [right, left] = [function(h, 0.0), function(-h, 0.0)];
    let [above, below] = [function(0.0, h), function(0.0, -h)];
    let slope = [0.5 * (right - left) / h, 0.5 * (above - below) / h];
    let xx = (right - 2.0 * value + left) / (h * h);
    let yy = (above - 2.0 * value + below) / (h * h);
    let along = value + h * (slope[0] + slope[1]) + 0.5 * h * h * (xx + yy);
    let xy = (function(h, h) - along) / (h * h);
    let (mean, difference) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    let (sine, cosine) = (0.5 * xy.atan2(0.5 * (xx - yy))).sin_cos();
    let principal = [
        (mean + difference, [cosine, sine]),
        (mean - difference, [-sine, cosine]),
    ];
    let mut step = [0.0; 2];
    for (curvature, axis) in principal {
        let slope = axis[0] * slope[0] + axis[1] * slope[1];
        let length = match curvature > 0.0 {
            true => (-slope / curvature).clamp(-LONGEST_STEP, LONGEST_STEP),
            false => LONGEST_STEP.copysign(-slope),
        };
        (0..2).for_each(|i| step[i] += length * axis[i]);
    }
    step
}

/// Tests whether the real parts of all eigenvalues exceed a level in the directions of a triangle.
fn exceeds(blocks: &Blocks3, level: f64, triangle: &Triangle) -> Cover {
    let coefficient = |m: usize, n: usize| {
        let (a, b) = (&triangle[m], &triangle[n]);
        combined(blocks, a, b) - Matrix3::identity() * (level * dot(a, b))
    };
    let [aa, bb, cc] = [0, 1, 2].each(|m| coefficient(m, m));
    let [ab, bc, ca] = [(0, 1), (1, 2), (2, 0)].each(|(m, n)| coefficient(m, n) * 2.0);
    let m = |i: usize, k: usize| {
        let mut entry = Ternary::zero(2);
        for (alpha, beta, block) in [
            (2, 0, aa),
            (0, 2, bb),
            (0, 0, cc),
            (1, 1, ab),
            (0, 1, bc),
            (1, 0, ca),
        ] {
            entry.coefficients[alpha][beta] = block[(i, k)];
        }
        entry
    };
    let m: [[Ternary; 3]; 3] = array_of(|i| array_of(|k| m(i, k)));
    let minor = |i: usize, k: usize, j: usize, l: usize| {
        m[i][j].times(&m[k][l]).minus(&m[i][l].times(&m[k][j]))
    };
    let trace = m[0][0].plus(&m[1][1]).plus(&m[2][2]);
    let minors = minor(0, 1, 0, 1)
        .plus(&minor(0, 2, 0, 2))
        .plus(&minor(1, 2, 1, 2));
    let determinant = m[0][0]
        .times(&minor(1, 2, 1, 2))
        .minus(&m[0][1].times(&minor(1, 2, 0, 2)))
        .plus(&m[0][2].times(&minor(1, 2, 0, 1)));
    let pairs = trace.times(&minors).minus(&determinant);
    let conditions = [trace, determinant, pairs];
    let corner = (0..3).find(|&corner| !conditions.iter().all(|p| p.at_corner(corner) > 0.0));
    if let Some(corner) = corner {
        Cover::Fails(triangle[corner])
    } else if conditions.iter().all(Ternary::is_positive) {
        Cover::Above
    } else {
        Cover::Open(())
    }
}

/// Homogeneous polynomial of degree up to six in three weights: the coefficients of `alpha^i beta^j gamma^(degree - i - j)`.
#[derive(Clone, Copy)]
struct Ternary {
    degree: usize,
    coefficients: [[f64; 7]; 7],
}

impl Ternary {
    fn zero(degree: usize) -> Self {
        Self {
            degree,
            coefficients: [[0.0; 7]; 7],
        }
    }

    /// Exponents of `alpha` and `beta`.
    fn powers(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let degree = self.degree;
        (0..=degree).flat_map(move |i| (0..=degree - i).map(move |j| (i, j)))
    }

    fn times(&self, other: &Self) -> Self {
        let mut product = Self::zero(self.degree + other.degree);
        for (i, j) in self.powers() {
            for (k, l) in other.powers() {
                product.coefficients[i + k][j + l] +=
                    self.coefficients[i][j] * other.coefficients[k][l];
            }
        }
        product
    }

    fn combined(&self, other: &Self, factor: f64) -> Self {
        let mut sum = *self;
        for (i, j) in self.powers() {
            sum.coefficients[i][j] += factor * other.coefficients[i][j];
        }
        sum
    }

    fn plus(&self, other: &Self) -> Self {
        self.combined(other, 1.0)
    }

    fn minus(&self, other: &Self) -> Self {
        self.combined(other, -1.0)
    }

    fn at_corner(&self, corner: usize) -> f64 {
        match corner {
            0 => self.coefficients[self.degree][0],
            1 => self.coefficients[0][self.degree],
            _ => self.coefficients[0][0],
        }
    }

    /// Returns true if all coefficients are positive.
    fn is_positive(&self) -> bool {
        self.powers().all(|(i, j)| self.coefficients[i][j] > 0.0)
    }
}
