//! Lower bound over all directions together, by null Lagrangians.
//!
//! The minors `H_iJ H_kL - H_iL H_kJ` vanish at `H = g (x) N`, so any multiple of them can be added to the form `H . T H` without changing an
//! acoustic tensor. If the form with some multiples is at least `level |H|^2` for *all* `H`, every acoustic eigenvalue is at least the level, since
//! `|g (x) N| = 1`. (The quadratic energy is then polyconvex with that margin.) Finding the best level is a concave problem in nine multiples; a
//! barrier method follows its central path. In two dimensions the bound is always attained. In three dimensions it usually is; otherwise the sphere
//! has to be divided.

use super::Axes;
use super::form::{Form, MINORS, minor};
use crate::algebra::{Each, array_of, is_positive_definite, symmetric_eigen};

/// Largest number of Newton steps; about twenty are typical.
const NEWTON_STEPS: usize = 100;
/// Number of unknowns: the level and the multiples.
const UNKNOWNS: usize = 1 + MINORS;

/// Lower bound of all acoustic eigenvalues, with the multiples that prove it.
#[derive(Clone, Debug)]
pub(crate) struct Bound {
    /// Lower bound of the eigenvalues.
    pub(crate) level: f64,
    /// Multiples of the minors.
    pub(crate) factors: [f64; MINORS],
    /// Direction in which the bound suggests the minimum.
    pub(crate) suggestion: Axes<f64>,
}

/// Computes the best level and multiples, or the first level that reaches a finite `target`. The components must be of magnitude one.
pub(crate) fn bound(form: &Form<f64>, target: f64) -> Bound {
    let mut path = Path::new(form);
    for _ in 0..NEWTON_STEPS {
        if path.level >= target || !path.advance(target) {
            break;
        }
    }
    Bound {
        level: path.level - path.rounding(),
        factors: path.factors,
        suggestion: suggestion(&path.inverse),
    }
}

/// Central path of maxima of `weight level + ln det S`, `S = T - level + sum_m factors_m minor_m`. On the path the level is below the best one by
/// nine divided by the weight.
struct Path<'a> {
    form: &'a Form<f64>,
    /// Indices of the minors that are used.
    minors: Vec<usize>,
    level: f64,
    factors: [f64; MINORS],
    weight: f64,
    /// Inverse matrix `S^-1` at the current point.
    inverse: [[f64; 9]; 9],
    logarithm: f64,
}

impl<'a> Path<'a> {
    fn new(form: &'a Form<f64>) -> Self {
        // Sign changes of the axes leave an orthotropic form unchanged, but not the excluded minors.
        let is_orthotropic = form.is_orthotropic();
        let minors = (0..MINORS).filter(|m| !is_orthotropic || m / 3 == m % 3);
        // Start below all eigenvalues: the sum of their squares equals the sum of the squared components.
        let norm = form.components().map(|x| x * x).sum::<f64>().sqrt();
        let mut path = Self {
            form,
            minors: minors.collect(),
            level: -2.0 * norm,
            factors: [0.0; MINORS],
            weight: 1.0,
            inverse: [[0.0; 9]; 9],
            logarithm: f64::NEG_INFINITY,
        };
        if let Some((inverse, logarithm)) = inverted(&form.lowered(path.level, &path.factors)) {
            (path.inverse, path.logarithm) = (inverse, logarithm);
            path.weight = trace(&inverse);
        }
        path
    }

    /// Rounding error of the elimination of a 9 x 9 matrix.
    fn rounding(&self) -> f64 {
        let trace: f64 = (0..9).map(|p| self.form.at(p, p) - self.level).sum();
        16.0 * f64::EPSILON * trace
    }

    /// Performs a step. Returns false if the iteration has converged or the target cannot be reached.
    fn advance(&mut self, target: f64) -> bool {
        let count = 1 + self.minors.len();
        let x = &self.inverse;
        let square: [[f64; 9]; 9] =
            array_of(|p| array_of(|q| (0..9).map(|r| x[p][r] * x[r][q]).sum()));
        // Gradient and negative Hessian of ln det S in the level and the multiples.
        let (mut slope, mut curvature) = ([0.0; UNKNOWNS], [[0.0; UNKNOWNS]; UNKNOWNS]);
        slope[0] = -trace(x);
        curvature[0][0] = trace(&square);
        let signs = [1.0, -1.0];
        for (a, &m) in self.minors.iter().enumerate() {
            for ((p, q), sign) in minor(m).into_iter().zip(signs) {
                slope[1 + a] += sign * x[p][q];
                curvature[1 + a][0] -= sign * square[p][q];
                for (b, &n) in self.minors.iter().enumerate().take(a + 1) {
                    for ((r, s), other) in minor(n).into_iter().zip(signs) {
                        let product = x[p][r] * x[q][s] + x[p][s] * x[q][r];
                        curvature[1 + a][1 + b] += 0.5 * sign * other * product;
                    }
                }
            }
        }
        let Some(factored) = Factored::new(curvature, count) else {
            return false;
        };
        let mut unit = [0.0; UNKNOWNS];
        unit[0] = 1.0;
        let (by_weight, by_slope) = (factored.solved(unit), factored.solved(slope));
        let centering: [f64; UNKNOWNS] = array_of(|a| self.weight * by_weight[a] + by_slope[a]);
        let decrement = (self.weight * centering[0]
            + slope.iter().zip(centering).map(|(s, d)| s * d).sum::<f64>())
        .max(0.0)
        .sqrt();
        if !decrement.is_finite() {
            return false;
        }
        if decrement > 0.5 {
            return self.centered(&centering, decrement);
        }
        // No point beyond this level exists, because the dual problem has a point of this value.
        let gap = (9.0 + 3.0 * decrement) / self.weight;
        if self.level + gap < target && gap < 0.01 * (target - self.level - gap) {
            return false;
        }
        if gap < 1e-13 {
            return false;
        }
        // The path is nearly straight in the reciprocal of the weight, so steps follow its tangent.
        let tangent: [f64; UNKNOWNS] = array_of(|a| self.weight * by_weight[a] + centering[a]);
        for short in [0.001, 0.01, 0.1, 0.25] {
            // Keep a third of the remaining distance from the point where S becomes singular.
            if self.is_inside(&tangent, 1.0 - short)
                && self.moved(&tangent, 1.0 - 3.0 * short, f64::NEG_INFINITY)
            {
                self.weight /= 3.0 * short;
                return true;
            }
        }
        // The end of the tangent is too far: increase the weight slightly and return to the path.
        self.weight *= 1.5;
        true
    }

    /// Damped Newton step toward the path, accepted if the objective increases.
    fn centered(&mut self, step: &[f64; UNKNOWNS], decrement: f64) -> bool {
        let current = self.weight * self.level + self.logarithm;
        let safe = 1.0 / (1.0 + decrement);
        let mut share = 1.0;
        while share > safe {
            if self.moved(step, share, current) {
                return true;
            }
            share *= 0.6;
        }
        self.moved(step, safe, f64::NEG_INFINITY)
    }

    /// Level and multiples after a fraction of a step.
    fn after(&self, step: &[f64; UNKNOWNS], share: f64) -> (f64, [f64; MINORS]) {
        let mut factors = self.factors;
        for (a, &m) in self.minors.iter().enumerate() {
            factors[m] += share * step[1 + a];
        }
        (self.level + share * step[0], factors)
    }

    /// Returns true if `S` is positive definite after a fraction of a step.
    fn is_inside(&self, step: &[f64; UNKNOWNS], share: f64) -> bool {
        let (level, factors) = self.after(step, share);
        is_positive_definite(&self.form.lowered(level, &factors))
    }

    /// Performs a fraction of a step if `S` remains positive definite and the objective exceeds `least`.
    fn moved(&mut self, step: &[f64; UNKNOWNS], share: f64, least: f64) -> bool {
        let (level, factors) = self.after(step, share);
        let Some((inverse, logarithm)) = inverted(&self.form.lowered(level, &factors)) else {
            return false;
        };
        if self.weight * level + logarithm <= least {
            return false;
        }
        (self.level, self.factors) = (level, factors);
        (self.inverse, self.logarithm) = (inverse, logarithm);
        true
    }
}

/// Direction `N` of the dyad `g (x) N` nearest to the softest `H`. In the limit `S^-1` consists of this dyad alone if the minimum is unique and the
/// bound is attained.
fn suggestion(inverse: &[[f64; 9]; 9]) -> Axes<f64> {
    // Power iteration for the dominant eigenvector, which need not be accurate.
    let mut h: [f64; 9] = array_of(|p| 1.0 + 0.1 * p as f64);
    for _ in 0..20 {
        let next: [f64; 9] = array_of(|p| (0..9).map(|q| inverse[p][q] * h[q]).sum());
        let largest = next.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        if !(largest > 0.0 && largest.is_finite()) {
            return [1.0, 0.0, 0.0];
        }
        h = next.each(|x| x / largest);
    }
    let gram: [[f64; 3]; 3] =
        array_of(|j| array_of(|l| (0..3).map(|i| h[3 * i + j] * h[3 * i + l]).sum()));
    symmetric_eigen(&gram).1[2]
}

fn trace(matrix: &[[f64; 9]; 9]) -> f64 {
    (0..9).map(|p| matrix[p][p]).sum()
}

/// Inverse and logarithm of the determinant of a positive definite matrix.
fn inverted(matrix: &[[f64; 9]; 9]) -> Option<([[f64; 9]; 9], f64)> {
    // S = L L^T, then S^-1 = L^-T L^-1.
    let mut lower = *matrix;
    let mut determinant = 1.0;
    for k in 0..9 {
        let pivot = lower[k][k];
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        determinant *= pivot;
        let root = pivot.sqrt();
        lower[k][k] = root;
        for i in k + 1..9 {
            lower[i][k] /= root;
        }
        for i in k + 1..9 {
            for j in k + 1..=i {
                lower[i][j] -= lower[i][k] * lower[j][k];
            }
        }
    }
    let mut reciprocal = [[0.0; 9]; 9];
    for j in 0..9 {
        reciprocal[j][j] = 1.0 / lower[j][j];
        for i in j + 1..9 {
            let sum: f64 = (j..i).map(|k| lower[i][k] * reciprocal[k][j]).sum();
            reciprocal[i][j] = -sum / lower[i][i];
        }
    }
    let mut inverse = [[0.0; 9]; 9];
    for p in 0..9 {
        for q in 0..=p {
            inverse[p][q] = (p..9).map(|k| reciprocal[k][p] * reciprocal[k][q]).sum();
            inverse[q][p] = inverse[p][q];
        }
    }
    Some((inverse, determinant.ln()))
}

/// Factorized positive definite matrix, `D^-1 L L^T D^-1`, where `D` scales the diagonal to one.
struct Factored {
    count: usize,
    scale: [f64; UNKNOWNS],
    lower: [[f64; UNKNOWNS]; UNKNOWNS],
}

impl Factored {
    /// Factorizes the leading `count` rows from the entries on and below the diagonal.
    fn new(mut matrix: [[f64; UNKNOWNS]; UNKNOWNS], count: usize) -> Option<Self> {
        let scale = array_of(|i| {
            if i < count {
                matrix[i][i].sqrt().recip()
            } else {
                1.0
            }
        });
        for i in 0..count {
            for j in 0..=i {
                matrix[i][j] *= scale[i] * scale[j];
            }
            // Guard against rounding if the matrix is nearly singular.
            matrix[i][i] += 1e-14;
        }
        for k in 0..count {
            let pivot = matrix[k][k];
            if !(pivot > 0.0 && pivot.is_finite()) {
                return None;
            }
            let root = pivot.sqrt();
            matrix[k][k] = root;
            for i in k + 1..count {
                matrix[i][k] /= root;
            }
            for i in k + 1..count {
                for j in k + 1..=i {
                    matrix[i][j] -= matrix[i][k] * matrix[j][k];
                }
            }
        }
        Some(Self {
            count,
            scale,
            lower: matrix,
        })
    }

    fn solved(&self, right: [f64; UNKNOWNS]) -> [f64; UNKNOWNS] {
        let mut x: [f64; UNKNOWNS] = array_of(|i| right[i] * self.scale[i]);
        for i in 0..self.count {
            let sum: f64 = (0..i).map(|j| self.lower[i][j] * x[j]).sum();
            x[i] = (x[i] - sum) / self.lower[i][i];
        }
        for i in (0..self.count).rev() {
            let sum: f64 = (i + 1..self.count).map(|j| self.lower[j][i] * x[j]).sum();
            x[i] = (x[i] - sum) / self.lower[i][i];
        }
        array_of(|i| x[i] * self.scale[i])
    }
}

#[cfg(test)]
mod tests {
    use super::{MINORS, bound};
    use crate::algebra::is_positive_definite;
    use crate::continuum::spherical::Form;

    fn delta(i: usize, j: usize) -> f64 {
        f64::from(u8::from(i == j))
    }

    #[test]
    fn the_bound_of_isotropic_elasticity_is_attained_though_its_energy_is_not_convex() {
        for (lambda, mu) in [(3.0, 1.0), (-1.5, 1.0), (-2.5, 1.0)] {
            let form = Form::from_fn(|i, j, k, l| {
                lambda * delta(i, j) * delta(k, l)
                    + mu * (delta(i, k) * delta(j, l) + delta(i, l) * delta(j, k))
            });
            let lowest = f64::min(mu, lambda + 2.0 * mu);
            let found = bound(&form, lowest);
            assert!((found.level - lowest).abs() < 1e-10, "{}", found.level);
            // Rotations have no energy: without the minors no level above zero is a bound.
            assert!(!is_positive_definite(&form.lowered(1e-9, &[0.0; MINORS])));
        }
    }

    #[test]
    fn chois_form_with_any_minors_is_not_a_sum_of_squares() {
        // The form is zero at some g (x) N and nonnegative everywhere.
        let form = Form::from_fn(|i, j, k, l| {
            let is_on_diagonal = i == j && k == l;
            let diagonal = if i == k { 1.0 } else { -1.0 };
            let off = if i == k && j == l && j == (i + 1) % 3 {
                2.0
            } else {
                0.0
            };
            if is_on_diagonal { diagonal } else { off }
        });
        let found = bound(&form, 0.0);
        assert!(
            (-0.5..-0.01).contains(&found.level),
            "the best level is {}",
            found.level
        );
    }
}
