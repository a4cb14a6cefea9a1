//! Stability of an isotropic law in its principal axes.
//!
//! With `h_i = ln lambda_i`, `e_i = lambda_i^2`, the Kirchhoff stresses `t_i = dW/dh_i`, `L_ij = d^2 W/dh_i dh_j` and `g_ij = (t_i - t_j)/(e_i - e_j)`, waves with the normal
//! `N` in the reference configuration and the amplitude `m` have the stiffness `m . Q(N) m`. In `n_i = N_i/lambda_i`
//!
//! `Q_jj = (L_jj - t_j) n_j^2 + sum_(i != j) g_ij e_i n_i^2`, `Q_ij = (L_ij + (g_ij (e_i + e_j) - t_i - t_j)/2) n_i n_j`.
//!
//! These are the moduli of Ogden, Non-linear elastic deformations (1984), section 6.1. Strong ellipticity means that `Q(N)` is positive definite; for
//! incompressible response, on amplitudes normal to `n`, where the terms with `t` add up to `(sum t_i n_i m_i)(sum n_j m_j) = 0` and are omitted.
//! Only the squares `q_i = n_i^2` enter the condition: `|n|^2 tr Q - n . Q n` is a quadratic and `n . adj(Q) n` a cubic form of `q`, whose
//! coefficients in the Bernstein basis bound them over all directions.
//!
//! Drucker's inequality means that `L` is positive definite; for incompressible response, on increments without change of volume.
//!
//! An energy is a function `F` of sums over the stretches with slopes `a` and curvatures (see `sums`), so that `L` is a diagonal matrix `d` and a matrix `M` of products
//! `F_ab a_i b_j`. Only the differences `M_ii + M_jj - 2 M_ij` and the sum of all cofactors of `M` matter without change of volume; both follow from the
//! differences `a_i - a_j`, and thus without cancellation.

use crate::sums::{Curvatures, State};
use nalgebra::{Matrix3, Vector3};
use onset::real::{Jet, LANES, Lanes, Real, Work};
use serde::Serialize;
use std::sync::LazyLock;

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
    /// Criterion of the library with the same meaning.
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

/// Derivatives of an energy with respect to the logarithms of the stretches.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moduli<R> {
    squares: [R; 3],
    /// Principal Kirchhoff stresses `t_i`.
    stress: [R; 3],
    /// Diagonal part `d` of the second derivatives.
    diagonal: [R; 3],
    /// Parts `r_i = d_i - k_ij - k_ik + k_jk` of the second derivatives, with `k_ij = g_ij (e_i + e_j)/2`.
    reduced: [R; 3],
    /// Sums `r_i + r_j`; entry `k` is for the other two indices.
    pairs: [R; 3],
    /// Part `M` of the second derivatives.
    products: [[R; 3]; 3],
    /// Quotients `g_ij`; entry `k` is for the other two indices.
    quotients: [R; 3],
    /// Differences of the squared stretches; entry `k` is for the other two indices.
    differences: [R; 3],
    /// `M_ii + M_jj - 2 M_ij`; entry `k` is for the other two indices.
    relative: [R; 3],
    /// Sum of all cofactors of `M`.
    cofactors: R,
}

/// Pairs of distinct principal axes.
pub(crate) const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

impl<R: Real> Moduli<R> {
    /// Moduli of a vanishing energy.
    pub fn zero(state: &State<R>) -> Self {
        let zero = R::constant(0.0);
        Self {
            squares: state.squares,
            stress: [zero; 3],
            diagonal: [zero; 3],
            reduced: [zero; 3],
            pairs: [zero; 3],
            products: [[zero; 3]; 3],
            quotients: [zero; 3],
            differences: state.differences(),
            relative: [zero; 3],
            cofactors: zero,
        }
    }

    /// Adds the moduli of a function of two sums, by the chain rule. At constant volume at most one function of a law is nonlinear in its sums.
    pub fn add(
        &mut self,
        energy: &Jet<2, R>,
        slopes: [&[R; 3]; 2],
        curvatures: &[Curvatures<R>; 2],
    ) {
        for a in 0..2 {
            let first = energy.gradient[a];
            let own = &curvatures[a];
            for i in 0..3 {
                self.stress[i] = self.stress[i] + first * slopes[a][i];
                self.diagonal[i] = self.diagonal[i] + first * own.own[i];
                self.quotients[i] = self.quotients[i] + first * own.quotients[i];
                self.reduced[i] = self.reduced[i] + first * own.parts[i];
                self.pairs[i] = self.pairs[i] + first * own.pairs[i];
            }
        }
        let [[xx, xy], [_, yy]] = energy.hessian;
        let [x, y] = slopes;
        let form = |a: R, b: R, c: R, d: R| xx * a * c + xy * (a * d + b * c) + yy * b * d;
        for i in 0..3 {
            for j in 0..3 {
                self.products[i][j] = self.products[i][j] + form(x[i], y[i], x[j], y[j]);
            }
        }
        let steps = |quotients: &[R; 3]| -> [R; 3] {
            std::array::from_fn(|k| quotients[k] * self.differences[k])
        };
        let (x, y) = (
            steps(&curvatures[0].quotients),
            steps(&curvatures[1].quotients),
        );
        for k in 0..3 {
            let square = |a: R, b: R| xx * a * a + xy * a * b * 2.0 + yy * b * b;
            self.relative[k] = self.relative[k] + square(x[k], y[k]);
        }
        let area = x[1] * y[0] - x[0] * y[1];
        self.cofactors = self.cofactors + (xx * yy - xy * xy) * area * area;
    }

    /// Second derivative with respect to the logarithms of two stretches.
    fn logarithmic(&self, i: usize, j: usize) -> R {
        match i == j {
            true => self.products[i][i] + self.diagonal[i],
            false => self.products[i][j],
        }
    }

    /// Coefficient of `n_i^2` in `Q_jj`.
    fn shear(&self, j: usize, i: usize) -> R {
        self.quotients[3 - i - j] * self.squares[i]
    }

    /// Mean of the shear coefficients of two axes.
    fn mean_shear(&self, i: usize, j: usize) -> R {
        self.quotients[3 - i - j] * (self.squares[i] + self.squares[j]) * 0.5
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
                    let own = (self.logarithmic(j, j) - self.stress[j]) / self.squares[j];
                    sum = sum + own * (n[j] * m[j]).powi(2);
                    for i in (0..3).filter(|i| *i != j) {
                        sum = sum + self.quotients[3 - i - j] * (n[i] * m[j]).powi(2);
                    }
                }
                for (i, j) in PAIRS {
                    sum = sum + self.coupling(i, j) * (2.0 * n[i] * m[i] * n[j] * m[j]);
                }
            }
        }
        sum
    }

    /// Coefficient of `N_i N_j` in the acoustic tensor.
    fn coupling(&self, i: usize, j: usize) -> R {
        let stress = (self.stress[i] + self.stress[j]) * 0.5;
        let coupling = self.logarithmic(i, j) + self.mean_shear(i, j) - stress;
        coupling / (self.squares[i] * self.squares[j]).sqrt()
    }

    /// Shear modulus, if these are the moduli of the reference configuration.
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

    /// Trace and determinant of Drucker's matrix on increments without change of volume, up to positive factors: `sum L_ii - sum_(i<j) L_ij` and the sum of all
    /// cofactors.
    pub fn isochoric_minors(&self) -> [R; 2] {
        let (d, m) = (self.diagonal, self.relative);
        let trace = d[0] + d[1] + d[2] + (m[0] + m[1] + m[2]) * 0.5;
        let mut sum = self.cofactors;
        for (i, j) in PAIRS {
            let k = 3 - i - j;
            sum = sum + d[i] * d[j] + d[k] * m[k];
        }
        [trace, sum]
    }

    /// Forms in `q_i = n_i^2` that are positive for all directions if and only if incompressible response is strongly elliptic: the trace and the
    /// determinant of `Q(N)` on the amplitudes normal to `n`, times `|n|^2`. Coefficients in the Bernstein basis of the triangle of `q`. The parts `r_i`
    /// replace the diagonal part `d_i`, so that no terms cancel.
    pub fn elliptic_forms(&self) -> ([R; 6], [R; 10]) {
        let zero = R::constant(0.0);
        let (r, m, g, e) = (self.reduced, self.relative, self.quotients, self.squares);
        let mut trace = [zero; 6];
        let mut determinant = [zero; 10];
        let mut mixed = self.cofactors + r[0] * self.pairs[0] + r[1] * r[2];
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            trace[quadratic(i, i)] = self.shear(j, i) + self.shear(k, i);
            determinant[cubic(i, i, i)] = self.shear(j, i) * self.shear(k, i);
            let stretching = self.pairs[i] + m[i];
            let across = self.shear(i, j) + self.shear(i, k);
            trace[quadratic(j, k)] = (stretching + across) * 0.5;
            for (a, b) in [(j, k), (k, j)] {
                let sum = stretching * g[b] + g[i] * g[a] * e[b];
                determinant[cubic(a, a, b)] = e[a] * sum / 3.0;
            }
            mixed = mixed + m[i] * r[i] + g[i] * g[i] * e[j] * e[k];
        }
        determinant[cubic(0, 1, 2)] = mixed / 6.0;
        (trace, determinant)
    }
}

/// Index of the monomial `q_a q_b`: squares first, then the product without the axis `n - 3`.
pub(crate) fn quadratic(a: usize, b: usize) -> usize {
    match a == b {
        true => a,
        false => 3 + (3 - a - b),
    }
}

/// Index of the monomial `q_a q_b q_c`: cubes, then `q_a^2 q_b`, then the product of all three.
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

/// Number of points along an edge of the triangle of squared directions at which the search starts.
const DIRECTIONS: usize = 12;
/// Smallest step of the search. The stiffness is stationary at its minimum, so that its error is of the order of the squared step.
pub(crate) const LEAST_STEP: f64 = 1e-6;
/// Smallest step where only the order of states matters. Larger steps lead to false minima along valleys.
pub(crate) const COARSE_STEP: f64 = 1e-4;

impl Moduli<f64> {
    /// Lowest value of a criterion at a state, with its perturbation. Directions of waves are found within a smallest step.
    pub fn lowest(
        &self,
        criterion: Criterion,
        compressible: bool,
        least_step: f64,
    ) -> (f64, Perturbation) {
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
            (Criterion::StrongEllipticity, _) => self.softest_wave(compressible, least_step),
        }
    }

    fn softest_wave(&self, compressible: bool, least_step: f64) -> (f64, Perturbation) {
        let [u, v] = match compressible {
            true => softest_direction(least_step, |p| {
                let of_lane =
                    |lane: usize| lowest_root(&self.acoustic(p.map(|own| own.0[lane].sqrt())));
                Lanes(std::array::from_fn(of_lane))
            }),
            false => {
                let (trace, determinant) = self.elliptic_forms();
                Lanes::vectorized(SoftestDirection {
                    trace,
                    determinant,
                    inverse: self.squares.map(f64::recip),
                    least_step,
                })
            }
        };
        let normal = [u, v, (1.0 - u - v).max(0.0)].map(f64::sqrt);
        let (value, n, m) = self.softest_amplitude(normal, compressible);
        (value, Perturbation::Wave(n, m))
    }

    /// Acoustic tensor of a direction in the reference configuration.
    fn acoustic(&self, n: [f64; 3]) -> Matrix3<f64> {
        let own = |i: usize| (self.logarithmic(i, i) - self.stress[i]) / self.squares[i];
        Matrix3::from_fn(|i, j| match i == j {
            true => (0..3)
                .map(|k| {
                    n[k] * n[k]
                        * if k == i {
                            own(i)
                        } else {
                            self.quotients[3 - i - k]
                        }
                })
                .sum(),
            false => self.coupling(i, j) * n[i] * n[j],
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

/// Search for the direction of the softest wave of incompressible response.
struct SoftestDirection {
    trace: [f64; 6],
    determinant: [f64; 10],
    /// Reciprocals of the squared stretches.
    inverse: [f64; 3],
    least_step: f64,
}

impl Work for SoftestDirection {
    type Output = [f64; 2];

    #[inline(always)]
    fn done(self) -> [f64; 2] {
        let zero = Lanes::constant(0.0);
        // The stiffness alone is all that the search needs.
        let stiffness = |p: [Lanes; 3]| {
            let q = [
                p[0] * self.inverse[0],
                p[1] * self.inverse[1],
                p[2] * self.inverse[2],
            ];
            let unit = (q[0] + q[1] + q[2]).recip();
            let trace = quadratic_form(&self.trace, q) * unit;
            let determinant = cubic_form(&self.determinant, q) * unit;
            let square = trace * trace - determinant * 4.0;
            let root = square.switch(0.0, || zero, || square).sqrt();
            trace.switch(
                0.0,
                || (trace - root) * 0.5,
                || determinant * 2.0 / (trace + root),
            )
        };
        softest_direction(self.least_step, stiffness)
    }
}

/// Points of the triangle of squared directions at which the search starts, by lanes.
static STARTS: LazyLock<Vec<[Lanes; 2]>> = LazyLock::new(|| {
    let rows = (0..=DIRECTIONS).flat_map(|a| (0..=DIRECTIONS - a).map(move |b| [a, b]));
    let all: Vec<[f64; 2]> = rows
        .map(|own| own.map(|n| n as f64 / DIRECTIONS as f64))
        .collect();
    let of_lanes = |own: &[[f64; 2]]| {
        // The last point fills the lanes beyond the end.
        [0, 1].map(|axis| {
            Lanes(std::array::from_fn(|lane| {
                own[lane.min(own.len() - 1)][axis]
            }))
        })
    };
    all.chunks(LANES).map(of_lanes).collect()
});

/// Steps from the middle of a stencil to its points: opposite points along the edges of the triangle, and the middle itself.
const STENCIL: [[f64; 2]; LANES] = [
    [1.0, 0.0],
    [-1.0, 0.0],
    [0.0, 1.0],
    [0.0, -1.0],
    [1.0, -1.0],
    [-1.0, 1.0],
    [0.0, 0.0],
    [0.0, 0.0],
];
/// Number of the middle of a stencil.
const MIDDLE: usize = 6;
/// Largest number of stencils.
const STENCILS: usize = 200;
/// Ratio of the steps of two stencils if a parabola predicts the minimum within the first one, and otherwise.
const PREDICTED_STEP: f64 = 0.125;
const HALVED_STEP: f64 = 0.5;

/// Squared direction components `u` and `v` at which a function of the three components `u`, `v` and `1 - u - v` is lowest.
///
/// The search starts at the lowest point of a grid. Its stencil moves to the lowest of its points; around the lowest point its steps become shorter.
#[inline(always)]
fn softest_direction(least_step: f64, at: impl Fn([Lanes; 3]) -> Lanes) -> [f64; 2] {
    let values = |u: Lanes, v: Lanes| {
        let w = Lanes::constant(1.0) - u - v;
        at([u, v, w.switch(0.0, || Lanes::constant(0.0), || w)]).0
    };
    let (mut best, mut place) = (f64::INFINITY, [0.0; 2]);
    for [u, v] in STARTS.iter() {
        let own = values(*u, *v);
        for lane in 0..LANES {
            if own[lane] < best {
                (best, place) = (own[lane], [u.0[lane], v.0[lane]]);
            }
        }
    }
    let mut middle = place;
    let mut step = 0.5 / DIRECTIONS as f64;
    for _ in 0..STENCILS {
        let (mut u, mut v) = (Lanes::constant(0.0), Lanes::constant(0.0));
        for (lane, [du, dv]) in STENCIL.iter().enumerate() {
            u.0[lane] = (middle[0] + step * du).clamp(0.0, 1.0);
            v.0[lane] = (middle[1] + step * dv).clamp(0.0, 1.0 - u.0[lane]);
        }
        let own = values(u, v);
        let mut lowest = MIDDLE;
        for lane in 0..MIDDLE {
            if own[lane] < own[lowest] {
                lowest = lane;
            }
        }
        if own[lowest] < best {
            (best, place) = (own[lowest], [u.0[lowest], v.0[lowest]]);
        }
        if lowest != MIDDLE {
            middle = place;
            continue;
        }
        if step <= least_step {
            break;
        }
        let predicted = predicted_step(&own, middle, step).filter(|_| middle == place);
        middle = place;
        match predicted {
            Some([du, dv]) => {
                middle = [middle[0] + step * du, middle[1] + step * dv];
                step *= PREDICTED_STEP;
            }
            None => step *= HALVED_STEP,
        }
    }
    place
}

/// Step to the minimum of the parabola through the values of a stencil, as a multiple of its steps; along an edge of the triangle if the middle is on it.
/// `None` if there is no minimum within the stencil, or the stencil reaches beyond the triangle.
#[inline(always)]
fn predicted_step(values: &[f64; LANES], middle: [f64; 2], step: f64) -> Option<[f64; 2]> {
    let [u, v] = middle;
    let sizes = [u, v, 1.0 - u - v];
    let curvature = |pair: usize| values[2 * pair] + values[2 * pair + 1] - 2.0 * values[MIDDLE];
    let slope = |pair: usize| 0.5 * (values[2 * pair] - values[2 * pair + 1]);
    // Components that change along the pairs of opposite points.
    const CHANGED: [[usize; 2]; 3] = [[0, 2], [1, 2], [0, 1]];
    if sizes.iter().all(|own| *own >= step) {
        let (a, b) = (curvature(0), curvature(1));
        let across = 0.5 * (a + b - curvature(2));
        let determinant = a * b - across * across;
        let (x, y) = (slope(0), slope(1));
        let found = [
            (across * y - b * x) / determinant,
            (across * x - a * y) / determinant,
        ];
        let is_inside = found.iter().all(|own| own.abs() <= 1.0);
        return (a > 0.0 && determinant > 0.0 && is_inside).then_some(found);
    }
    let is_along = |pair: &usize| {
        let [a, b] = CHANGED[*pair];
        sizes[3 - a - b] <= 0.0 && sizes[a] >= step && sizes[b] >= step
    };
    let pair = (0..3).find(is_along)?;
    let length = -slope(pair) / curvature(pair);
    let [du, dv] = STENCIL[2 * pair];
    (curvature(pair) > 0.0 && length.abs() <= 1.0).then_some([length * du, length * dv])
}

/// Value of a quadratic form with coefficients in the Bernstein basis.
#[inline(always)]
fn quadratic_form(form: &[f64; 6], [a, b, c]: [Lanes; 3]) -> Lanes {
    let mixed = b * c * form[3] + c * a * form[4] + a * b * form[5];
    a * a * form[0] + b * b * form[1] + c * c * form[2] + mixed * 2.0
}

/// Value of a cubic form with coefficients in the Bernstein basis.
#[inline(always)]
fn cubic_form(form: &[f64; 10], [a, b, c]: [Lanes; 3]) -> Lanes {
    a * a * (a * form[0] + (b * form[3] + c * form[4]) * 3.0)
        + b * b * (b * form[1] + (c * form[5] + a * form[6]) * 3.0)
        + c * c * (c * form[2] + (a * form[7] + b * form[8]) * 3.0)
        + a * b * c * (6.0 * form[9])
}

/// Lowest eigenvalue of a symmetric matrix with its unit eigenvector.
fn lowest_of_two([[a, b], [_, d]]: &[[f64; 2]; 2]) -> (f64, [f64; 2]) {
    let half = 0.5 * (a - d);
    let root = half.hypot(*b);
    let value = 0.5 * (a + d) - root;
    // The rows of `M - lambda 1` are normal to the eigenvector.
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
