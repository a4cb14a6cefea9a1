//! Stability of an isotropic law in its principal axes.
//!
//! With `e_i = lambda_i^2`, `W_i = dW/de_i`, `W_ij = d^2 W/de_i de_j` and `T_ij = 2 (W_i - W_j)/(e_i - e_j)`, waves with the normal `N` in the reference
//! and the amplitude `m` have the stiffness `m . Q(N) m` with
//!
//! `Q_jj = (4 e_j W_jj + 2 W_j) N_j^2 + sum_(i != j) (2 W_j + e_i T_ij) N_i^2`, `Q_ij = lambda_i lambda_j (4 W_ij + T_ij) N_i N_j`.
//!
//! These are the moduli of Ogden, Non-linear elastic deformations (1984), section 6.1. Strong ellipticity says that `Q(N)` is positive definite; for
//! incompressible response, on amplitudes normal to `n = F^-T N`. Only the squares `p_i = N_i^2` enter the condition: `|n|^2 tr Q - n . Q n` is a quadratic and
//! `n . adj(Q) n` a cubic form of `p`, whose coefficients in the Bernstein basis bound them over all directions.
//!
//! Drucker's inequality says that `4 e_i e_j W_ij + 4 d_ij e_i W_i`, the second derivative by the logarithms of the stretches, is positive definite; for
//! incompressible response, on increments without change of volume.

use crate::sums::{Curvatures, State};
use nalgebra::{Matrix3, Vector3};
use onset::real::{Jet, Real};
use serde::Serialize;

/// Sense in which a law is stable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Criterion {
    /// Drucker's inequality: positive second-order work.
    Drucker,
    /// Strong ellipticity: real wave speeds in all directions.
    StrongEllipticity,
}

impl Criterion {
    /// Criterion of the same meaning in the library.
    pub fn of_library(self) -> onset::criteria::Criterion {
        match self {
            Self::Drucker => onset::criteria::Criterion::Drucker,
            Self::StrongEllipticity => onset::criteria::Criterion::StrongEllipticity,
        }
    }
}

/// Perturbation that a criterion tests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Perturbation {
    /// Increment of the logarithmic strains, with unit length.
    Strain([f64; 3]),
    /// Wave with a unit normal `N` in the reference, and a unit amplitude.
    Wave([f64; 3], [f64; 3]),
}

/// Derivatives of an energy by the squares of the stretches, with the quotients that the moduli need.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moduli<R> {
    squares: [R; 3],
    first: [R; 3],
    second: [[R; 3]; 3],
    /// `T_ij`, by the third index.
    quotients: [R; 3],
}

/// Pairs of different principal axes.
pub(crate) const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

impl<R: Real> Moduli<R> {
    /// Moduli of no energy.
    pub fn zero(state: &State<R>) -> Self {
        let zero = R::constant(0.0);
        Self {
            squares: state.squares,
            first: [zero; 3],
            second: [[zero; 3]; 3],
            quotients: [zero; 3],
        }
    }

    /// Adds the moduli of a function of two sums, by the chain rule.
    pub fn add(
        &mut self,
        energy: &Jet<2, R>,
        slopes: &[(R, [R; 3]); 2],
        curvatures: &[Curvatures<R>; 2],
    ) {
        for (a, (_, slope)) in slopes.iter().enumerate() {
            let first = energy.gradient[a];
            let (second, quotients) = &curvatures[a];
            for i in 0..3 {
                self.first[i] = self.first[i] + first * slope[i];
                self.quotients[i] = self.quotients[i] + first * quotients[i] * 2.0;
                for j in 0..3 {
                    let mut sum = self.second[i][j] + first * second[i][j];
                    for (b, (_, other)) in slopes.iter().enumerate() {
                        sum = sum + energy.hessian[a][b] * slope[i] * other[j];
                    }
                    self.second[i][j] = sum;
                }
            }
        }
    }

    /// Coefficient of `N_i^2` in `Q_jj`.
    fn diagonal(&self, j: usize, i: usize) -> R {
        let own = self.first[j] * 2.0;
        match i == j {
            true => own + self.squares[j] * self.second[j][j] * 4.0,
            false => own + self.squares[i] * self.quotients[3 - i - j],
        }
    }

    /// Coupling `4 W_ij + T_ij` of two axes in the acoustic tensor.
    fn coupling(&self, i: usize, j: usize) -> R {
        self.second[i][j] * 4.0 + self.quotients[3 - i - j]
    }

    /// Minor `W_ii W_jj - W_ij^2` of the second derivatives.
    fn determinant(&self, i: usize, j: usize) -> R {
        self.second[i][i] * self.second[j][j] - self.second[i][j] * self.second[i][j]
    }

    /// Second derivative by the logarithms of two stretches.
    fn logarithmic(&self, i: usize, j: usize) -> R {
        let both = self.squares[i] * self.squares[j] * self.second[i][j] * 4.0;
        match i == j {
            true => both + self.squares[i] * self.first[i] * 4.0,
            false => both,
        }
    }

    /// Quadratic form of a perturbation; linear in the moduli of the law.
    pub fn form(&self, perturbation: &Perturbation) -> R {
        let mut sum = R::constant(0.0);
        match perturbation {
            Perturbation::Strain(d) => {
                for i in 0..3 {
                    for j in 0..3 {
                        sum = sum + self.logarithmic(i, j) * (d[i] * d[j]);
                    }
                }
            }
            Perturbation::Wave(n, m) => {
                for j in 0..3 {
                    for i in 0..3 {
                        sum = sum + self.diagonal(j, i) * (n[i] * m[j]).powi(2);
                    }
                }
                for (i, j) in PAIRS {
                    let root = (self.squares[i] * self.squares[j]).sqrt();
                    sum = sum + root * self.coupling(i, j) * (2.0 * n[i] * m[i] * n[j] * m[j]);
                }
            }
        }
        sum
    }

    /// Shear modulus; for the moduli of the reference.
    pub fn shear_modulus(&self) -> R {
        (self.logarithmic(0, 0) - self.logarithmic(0, 1)) * 0.5
    }

    /// Matrix of Drucker's inequality on increments without change of volume, in an orthonormal basis.
    pub fn isochoric(&self) -> [[R; 2]; 2] {
        let of = |a: &[f64; 3], b: &[f64; 3]| {
            let mut sum = R::constant(0.0);
            for i in 0..3 {
                for j in 0..3 {
                    sum = sum + self.logarithmic(i, j) * (a[i] * b[j]);
                }
            }
            sum
        };
        let [a, b] = isochoric_basis();
        let across = of(&a, &b);
        [[of(&a, &a), across], [across, of(&b, &b)]]
    }

    /// Trace and determinant of Drucker's matrix `w` on increments without change of volume, up to positive factors: `sum w_ii - sum_(i<j) w_ij` and the sum of all
    /// cofactors. Written so that terms that cancel are not added to each other.
    pub fn isochoric_minors(&self) -> [R; 2] {
        let e = self.squares;
        let w = |i: usize, j: usize| self.logarithmic(i, j);
        let trace = w(0, 0) + w(1, 1) + w(2, 2) - w(0, 1) - w(0, 2) - w(1, 2);
        let mut sum = R::constant(0.0);
        for (i, j) in PAIRS {
            let k = 3 - i - j;
            let product = e[i] * e[j];
            let stress =
                e[i] * self.second[i][i] * self.first[j] + e[j] * self.second[j][j] * self.first[i];
            sum = sum
                + product
                    * (product * self.determinant(i, j) + stress + self.first[i] * self.first[j])
                    * 16.0;
            sum = sum + (w(i, k) * w(j, k) - w(i, j) * w(k, k)) * 2.0;
        }
        [trace, sum]
    }

    /// Forms in `p_i = N_i^2` that are positive for all directions if and only if incompressible response is strongly elliptic: the trace and the
    /// determinant of `Q(N)` on the amplitudes normal to `n`, times `|n|^2`. Coefficients in the Bernstein basis of the triangle of `p`.
    pub fn elliptic_forms(&self) -> ([R; 6], [R; 10]) {
        let zero = R::constant(0.0);
        let inverse = self.squares.map(R::recip);
        let mut trace = [zero; 6];
        let mut add = |a: usize, b: usize, value: R| {
            let own = &mut trace[quadratic(a, b)];
            *own = *own + value / if a == b { 1.0 } else { 2.0 };
        };
        for k in 0..3 {
            for j in (0..3).filter(|j| *j != k) {
                for i in 0..3 {
                    add(i, k, self.diagonal(j, i) * inverse[k]);
                }
            }
        }
        for (i, j) in PAIRS {
            add(i, j, self.coupling(i, j) * -2.0);
        }
        // n . adj(Q) n with adj_kk = Q_ii Q_jj - Q_ij^2 and adj_ij = Q_ik Q_jk - Q_ij Q_kk.
        let mut determinant = [zero; 10];
        let mut add = |[a, b, c]: [usize; 3], value: R| {
            let orders = match [a == b, b == c, a == c].iter().filter(|own| **own).count() {
                0 => 6.0,
                1 => 3.0,
                _ => 1.0,
            };
            let own = &mut determinant[cubic(a, b, c)];
            *own = *own + value / orders;
        };
        let e = self.squares;
        for k in 0..3 {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let coupling = self.coupling(i, j);
            for a in 0..3 {
                for b in (0..3).filter(|b| (a, *b) != (i, j)) {
                    add(
                        [a, b, k],
                        self.diagonal(i, a) * self.diagonal(j, b) * inverse[k],
                    );
                }
                add([a, i, j], coupling * self.diagonal(k, a) * -2.0);
            }
            // Q_ii Q_jj - Q_ij^2 of the two squares, with what cancels grouped.
            let (first, second, quotient) = (self.first, self.second, self.quotients[k]);
            let stress = e[i] * second[i][i] * first[j] + e[j] * second[j][j] * first[i];
            let own = e[i]
                * e[j]
                * (self.determinant(i, j) * 16.0 - quotient * (second[i][j] * 8.0 + quotient))
                + stress * 8.0
                + first[i] * first[j] * 4.0;
            add([i, j, k], own * inverse[k]);
            add(
                [i, j, k],
                self.coupling(i, k) * self.coupling(j, k) * e[k] * 2.0,
            );
        }
        (trace, determinant)
    }
}

/// Index of the monomial `p_a p_b`: squares first, then the product without the axis `n - 3`.
pub(crate) fn quadratic(a: usize, b: usize) -> usize {
    match a == b {
        true => a,
        false => 3 + (3 - a - b),
    }
}

/// Index of the monomial `p_a p_b p_c`: cubes, then `p_a^2 p_b`, then the product of all three.
pub(crate) fn cubic(a: usize, b: usize, c: usize) -> usize {
    let mut sorted = [a, b, c];
    sorted.sort_unstable();
    let [a, b, c] = sorted;
    match (a == b, b == c) {
        (true, true) => a,
        (false, false) => 9,
        (true, false) => 3 + 2 * a + usize::from(c == (a + 2) % 3),
        (false, true) => 3 + 2 * c + usize::from(a == (c + 2) % 3),
    }
}

/// Orthonormal basis of increments of the logarithmic strains without change of volume.
pub(crate) fn isochoric_basis() -> [[f64; 3]; 2] {
    let (a, b) = (0.5_f64.sqrt(), 6.0_f64.sqrt().recip());
    [[a, -a, 0.0], [b, b, -2.0 * b]]
}

/// Points along an edge of the triangle of squared directions that are tried first.
const DIRECTIONS: usize = 12;

impl Moduli<f64> {
    /// Lowest value of a criterion at a state, with its perturbation.
    pub fn lowest(&self, criterion: Criterion, compressible: bool) -> (f64, Perturbation) {
        match (criterion, compressible) {
            (Criterion::Drucker, false) => {
                let matrix = self.isochoric();
                let (value, [x, y]) = lowest_of_two(&matrix);
                let [a, b] = isochoric_basis();
                let strain = std::array::from_fn(|i| x * a[i] + y * b[i]);
                (value, Perturbation::Strain(strain))
            }
            (Criterion::Drucker, true) => {
                let matrix = Matrix3::from_fn(|i, j| self.logarithmic(i, j));
                let (value, vector) = lowest_of(matrix);
                (value, Perturbation::Strain(vector))
            }
            (Criterion::StrongEllipticity, _) => self.softest_wave(compressible),
        }
    }

    fn softest_wave(&self, compressible: bool) -> (f64, Perturbation) {
        // Stiffness alone, which is all that the search over directions needs.
        let (trace, determinant) = self.elliptic_forms();
        let inverse = self.squares.map(f64::recip);
        let at = |p: [f64; 3]| match compressible {
            true => lowest_root(&self.acoustic(p.map(f64::sqrt))),
            false => {
                let length = p[0] * inverse[0] + p[1] * inverse[1] + p[2] * inverse[2];
                let trace = quadratic_form(&trace, p) / length;
                let determinant = cubic_form(&determinant, p) / length;
                let root = (trace * trace - 4.0 * determinant).max(0.0).sqrt();
                match trace > 0.0 {
                    true => 2.0 * determinant / (trace + root),
                    false => 0.5 * (trace - root),
                }
            }
        };
        let (mut best, mut place) = (f64::INFINITY, [0.0; 2]);
        for a in 0..=DIRECTIONS {
            for b in 0..=DIRECTIONS - a {
                let [u, v] = [a, b].map(|n| n as f64 / DIRECTIONS as f64);
                let found = at([u, v, (1.0 - u - v).max(0.0)]);
                if found < best {
                    (best, place) = (found, [u, v]);
                }
            }
        }
        let mut step = 0.5 / DIRECTIONS as f64;
        while step > 1e-6 {
            let before = best;
            for [du, dv] in [
                [1.0, 0.0],
                [-1.0, 0.0],
                [0.0, 1.0],
                [0.0, -1.0],
                [1.0, -1.0],
                [-1.0, 1.0],
            ] {
                let u = (place[0] + step * du).clamp(0.0, 1.0);
                let v = (place[1] + step * dv).clamp(0.0, 1.0 - u);
                let found = at([u, v, (1.0 - u - v).max(0.0)]);
                if found < best {
                    (best, place) = (found, [u, v]);
                }
            }
            if best >= before {
                step *= 0.5;
            }
        }
        let [u, v] = place;
        let normal = [u, v, (1.0 - u - v).max(0.0)].map(f64::sqrt);
        let (value, n, m) = self.softest_amplitude(normal, compressible);
        (value, Perturbation::Wave(n, m))
    }

    /// Acoustic tensor of a direction in the reference.
    fn acoustic(&self, n: [f64; 3]) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| match i == j {
            true => (0..3).map(|k| self.diagonal(i, k) * n[k] * n[k]).sum(),
            false => (self.squares[i] * self.squares[j]).sqrt() * self.coupling(i, j) * n[i] * n[j],
        })
    }

    /// Lowest stiffness of waves in a direction, with direction and amplitude.
    fn softest_amplitude(&self, n: [f64; 3], compressible: bool) -> (f64, [f64; 3], [f64; 3]) {
        let tensor = self.acoustic(n);
        if compressible {
            let (value, vector) = lowest_of(tensor);
            return (value, n, vector);
        }
        let normal = Vector3::from_fn(|i, _| n[i] / self.squares[i].sqrt()).normalize();
        let least = (0..3).fold(0, |best, i| if normal[i] < normal[best] { i } else { best });
        let first = normal.cross(&Vector3::ith(least, 1.0)).normalize();
        let second = normal.cross(&first);
        let image = [tensor * first, tensor * second];
        let across = first.dot(&image[1]);
        let (value, [x, y]) = lowest_of_two(&[
            [first.dot(&image[0]), across],
            [across, second.dot(&image[1])],
        ]);
        (value, n, (first * x + second * y).into())
    }
}

/// Value of a quadratic form with coefficients in the Bernstein basis.
fn quadratic_form(form: &[f64; 6], [a, b, c]: [f64; 3]) -> f64 {
    form[0] * a * a
        + form[1] * b * b
        + form[2] * c * c
        + 2.0 * (form[3] * b * c + form[4] * c * a + form[5] * a * b)
}

/// Value of a cubic form with coefficients in the Bernstein basis.
fn cubic_form(form: &[f64; 10], p: [f64; 3]) -> f64 {
    let mut sum = 6.0 * form[9] * p[0] * p[1] * p[2];
    for a in 0..3 {
        sum += form[a] * p[a] * p[a] * p[a];
        for b in (0..3).filter(|b| *b != a) {
            sum += 3.0 * form[cubic(a, a, b)] * p[a] * p[a] * p[b];
        }
    }
    sum
}

/// Lowest eigenvalue of a symmetric matrix with its unit eigenvector.
fn lowest_of_two([[a, b], [_, d]]: &[[f64; 2]; 2]) -> (f64, [f64; 2]) {
    let half = 0.5 * (a - d);
    let root = half.hypot(*b);
    let value = 0.5 * (a + d) - root;
    // Rows of the matrix less the eigenvalue are normal to the eigenvector.
    let vector = match half > 0.0 {
        true => [-b, half + root],
        false => [root - half, -b],
    };
    let size = vector[0].hypot(vector[1]);
    match size > 0.0 {
        true => (value, vector.map(|own| own / size)),
        false => (value, [1.0, 0.0]),
    }
}

/// Lowest eigenvalue of a symmetric matrix, as the lowest root of its characteristic polynomial.
fn lowest_root(matrix: &Matrix3<f64>) -> f64 {
    let mean = matrix.trace() / 3.0;
    let shifted = matrix - Matrix3::identity() * mean;
    let size = (shifted.norm_squared() / 6.0).sqrt();
    if size == 0.0 || !size.is_finite() {
        return mean;
    }
    let cosine = (0.5 * shifted.determinant() / (size * size * size)).clamp(-1.0, 1.0);
    mean + 2.0 * size * (cosine.acos() / 3.0 + 2.0 * std::f64::consts::FRAC_PI_3).cos()
}

fn lowest_of(matrix: Matrix3<f64>) -> (f64, [f64; 3]) {
    let eigen = matrix.symmetric_eigen();
    let n = eigen.eigenvalues.imin();
    let vector = eigen.eigenvectors.column(n);
    (eigen.eigenvalues[n], [vector[0], vector[1], vector[2]])
}
