//! Stability of an isotropic law in its principal axes.
//!
//! With `e_i = lambda_i^2`, `W_i = dW/de_i`, `W_ij = d^2 W/de_i de_j` and `T_ij = 2 (W_i - W_j)/(e_i - e_j)`, waves with the normal `N` in the reference
//! and the amplitude `m` have the stiffness `m . Q(N) m` with
//!
//! `Q_jj = (4 e_j W_jj + 2 W_j) N_j^2 + sum_(i != j) (2 W_j + e_i T_ij) N_i^2`, `Q_ij = lambda_i lambda_j (4 W_ij + T_ij) N_i N_j`.
//!
//! These are the moduli of Ogden, Non-linear elastic deformations (1984), section 6.1. Strong ellipticity means that `Q(N)` is positive definite; for
//! incompressible response, on amplitudes normal to `n = F^-T N`. Only the squares `p_i = N_i^2` enter the condition: `|n|^2 tr Q - n . Q n` is a quadratic and
//! `n . adj(Q) n` a cubic form of `p`, whose coefficients in the Bernstein basis bound them over all directions.
//!
//! Drucker's inequality means that `4 e_i e_j W_ij + 4 d_ij e_i W_i`, the second derivative by the logarithms of the stretches, is positive definite; for
//! incompressible response, on increments without change of volume.

use nalgebra::{Matrix2, Matrix3, Vector3};
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
    /// Wave with a unit normal `N` in the reference configuration, and a unit amplitude.
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

/// Squares closer than this part have the derivative in place of the quotient, whose error is of second order in the difference.
const SQUARE_TOLERANCE: f64 = 1e-5;

/// Pairs of different principal axes.
pub(crate) const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

impl<R: Real> Moduli<R> {
    /// Moduli from the derivatives of an energy.
    pub fn new(energy: &Jet<3, R>, squares: [f64; 3]) -> Self {
        let quotient = |i: usize, j: usize| {
            let difference = squares[i] - squares[j];
            if difference.abs() < SQUARE_TOLERANCE * squares[i] {
                let second = &energy.hessian;
                second[i][i] + second[j][j] - second[i][j] * 2.0
            } else {
                (energy.gradient[i] - energy.gradient[j]) * 2.0 / difference
            }
        };
        Self::with_quotients(energy, squares.map(R::constant), quotient)
    }

    /// Moduli with given quotients `T_ij`.
    pub fn with_quotients(
        energy: &Jet<3, R>,
        squares: [R; 3],
        quotient: impl Fn(usize, usize) -> R,
    ) -> Self {
        Self {
            squares,
            first: energy.gradient,
            second: energy.hessian,
            quotients: [quotient(1, 2), quotient(0, 2), quotient(0, 1)],
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

    /// Shear modulus; for the moduli of the reference configuration.
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
        let at = |p: [f64; 3]| self.softest_amplitude(p.map(f64::sqrt), compressible);
        let mut best = (f64::INFINITY, [0.0; 3], [0.0; 3]);
        let mut place = [0.0; 2];
        for a in 0..=DIRECTIONS {
            for b in 0..=DIRECTIONS - a {
                let [u, v] = [a, b].map(|n| n as f64 / DIRECTIONS as f64);
                let found = at([u, v, (1.0 - u - v).max(0.0)]);
                if found.0 < best.0 {
                    (best, place) = (found, [u, v]);
                }
            }
        }
        let mut step = 0.5 / DIRECTIONS as f64;
        while step > 1e-6 {
            let before = best.0;
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
                if found.0 < best.0 {
                    (best, place) = (found, [u, v]);
                }
            }
            if best.0 >= before {
                step *= 0.5;
            }
        }
        (best.0, Perturbation::Wave(best.1, best.2))
    }

    /// Lowest stiffness of waves in a direction, with direction and amplitude.
    fn softest_amplitude(&self, n: [f64; 3], compressible: bool) -> (f64, [f64; 3], [f64; 3]) {
        let q = |i: usize, j: usize| match i == j {
            true => (0..3).map(|k| self.diagonal(i, k) * n[k] * n[k]).sum(),
            false => (self.squares[i] * self.squares[j]).sqrt() * self.coupling(i, j) * n[i] * n[j],
        };
        if compressible {
            let (value, vector) = lowest_of(Matrix3::from_fn(q));
            return (value, n, vector);
        }
        let normal = Vector3::from_fn(|i, _| n[i] / self.squares[i].sqrt()).normalize();
        let least = (0..3).fold(0, |best, i| if normal[i] < normal[best] { i } else { best });
        let first = normal.cross(&Vector3::ith(least, 1.0)).normalize();
        let second = normal.cross(&first);
        let tensor = Matrix3::from_fn(q);
        let image = [tensor * first, tensor * second];
        let across = first.dot(&image[1]);
        let (value, [x, y]) = lowest_of_two(&[
            [first.dot(&image[0]), across],
            [across, second.dot(&image[1])],
        ]);
        (value, n, (first * x + second * y).into())
    }
}

/// Lowest eigenvalue of a symmetric matrix with its unit eigenvector.
fn lowest_of_two([[a, b], [_, d]]: &[[f64; 2]; 2]) -> (f64, [f64; 2]) {
    let eigen = Matrix2::new(*a, *b, *b, *d).symmetric_eigen();
    let n = usize::from(eigen.eigenvalues[1] < eigen.eigenvalues[0]);
    let vector = eigen.eigenvectors.column(n);
    (eigen.eigenvalues[n], [vector[0], vector[1]])
}

fn lowest_of(matrix: Matrix3<f64>) -> (f64, [f64; 3]) {
    let eigen = matrix.symmetric_eigen();
    let n = eigen.eigenvalues.imin();
    let vector = eigen.eigenvectors.column(n);
    (eigen.eigenvalues[n], [vector[0], vector[1], vector[2]])
}
