//! Largest critical modulus over all directions, with a bound.
//!
//! In principal axes the critical modulus depends on the direction `n` only through `x_i = n_i^2`, a point of the triangle `x_i >= 0`, `x1 + x2 + x3
//! = 1`, where it is a quotient of cubic polynomials. Parts of the triangle are discarded by bounds from Bernstein coefficients, the remaining parts
//! are bisected, and the best point is refined by Newton's method.

use super::cubic::Cubic;
use super::{Criterion, PlasticityError, RateModuli};
use crate::algebra::{Each, array_of};
use crate::cancel::checkpoint;
use crate::real::{Jet, Real};
use nalgebra::Vector3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Largest number of parts that are examined before the search ends with the current bound.
const MAX_PARTS: usize = 4000;

/// Gap between bound and value, relative to the largest modulus, that ends the search.
const TOLERANCE: f64 = 1e-11;

/// Terms `A n . q_e^-1 B n`, `A n . q_e^-1 A n` and `B n . q_e^-1 B n` as quotients of polynomials of `x_i = n_i^2`; moduli are divided by `scale`.
struct Quotients {
    criterion: Criterion,
    determinant: Cubic,
    /// Product of the tractions of flow and loading.
    mixed: Cubic,
    /// Products of the traction of flow with itself, and of the traction of loading with itself.
    pure: [Cubic; 2],
}

/// Largest value found, with its position and an upper bound of all values.
pub(super) struct Largest {
    pub(super) point: Vector3<f64>,
    pub(super) value: f64,
    pub(super) bound: f64,
}

/// Part of the region with a bound of its values.
struct Part {
    bound: f64,
    corners: Vec<Vector3<f64>>,
}

impl Quotients {
    fn new(moduli: &RateModuli, criterion: Criterion, scale: f64) -> Self {
        let axis = |i: usize| Vector3::ith(i, 1.0);
        let diagonal = |i: usize| Vector3::from_fn(|j, _| moduli.wave_stiffness(i, j) / scale);
        let coupling = |i: usize, j: usize| moduli.coupling(i, j) / scale;
        let mut determinant = Cubic::default();
        determinant.add([diagonal(0), diagonal(1), diagonal(2)]);
        let product = coupling(0, 1) * coupling(1, 2) * coupling(2, 0);
        determinant.add([axis(0) * (2.0 * product), axis(1), axis(2)]);
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            let square = coupling(j, k) * coupling(k, j);
            determinant.add([diagonal(i) * -square, axis(j), axis(k)]);
        }
        // u . adj(q) v with u = (u_i n_i): entries of the adjugate times n_i n_j are quadratic in x too.
        let form = |u: &Vector3<f64>, v: &Vector3<f64>| {
            let mut sum = Cubic::default();
            for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
                let weight = u[i] / scale * (v[i] / scale);
                let square = coupling(j, k) * coupling(k, j);
                sum.add([axis(i) * weight, diagonal(j), diagonal(k)]);
                sum.add([axis(i) * (-weight * square), axis(j), axis(k)]);
                let weight = u[i] / scale * (v[j] / scale) + u[j] / scale * (v[i] / scale);
                sum.add([
                    axis(i) * weight,
                    axis(j),
                    axis(k) * (coupling(i, k) * coupling(k, j)) - diagonal(k) * coupling(i, j),
                ]);
            }
            sum
        };
        Self {
            criterion,
            determinant,
            mixed: form(&moduli.flow, &moduli.loading),
            pure: [
                form(&moduli.flow, &moduli.flow),
                form(&moduli.loading, &moduli.loading),
            ],
        }
    }

    fn at<R: Real>(&self, x: &[R; 3]) -> R {
        let mixed = self.mixed.at(x);
        let numerator = match self.criterion {
            Criterion::Ellipticity => mixed,
            Criterion::StrongEllipticity => {
                let [flow, loading] = self.pure.each(|form| form.at(x));
                (mixed + (flow * loading).sqrt()) * 0.5
            }
        };
        numerator / self.determinant.at(x)
    }

    /// Upper bound of the values on a simplex; infinite if the determinant is not known to be positive.
    fn bound(&self, corners: &[Vector3<f64>]) -> f64 {
        let denominators = self.determinant.coefficients(corners);
        if denominators.iter().any(|value| *value <= 0.0) {
            return f64::INFINITY;
        }
        let mut numerators = self.mixed.coefficients(corners);
        if self.criterion == Criterion::StrongEllipticity {
            // sqrt(a b) <= (psi a + b/psi)/2 for every psi > 0, with equality at psi = sqrt(b/a).
            let center = corners.iter().sum::<Vector3<f64>>() / corners.len() as f64;
            let [flow, loading] = self
                .pure
                .each(|form| form.at(&[center[0], center[1], center[2]]));
            let psi = (loading / flow).sqrt();
            let psi = if psi.is_normal() { psi } else { 1.0 };
            let [flow, loading] = self.pure.map(|form| form.coefficients(corners));
            for (n, numerator) in numerators.iter_mut().enumerate() {
                *numerator = 0.5 * *numerator + 0.25 * (psi * flow[n] + loading[n] / psi);
            }
        }
        numerators
            .iter()
            .zip(&denominators)
            .map(|(numerator, denominator)| numerator / denominator)
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Newton's method for a maximum inside a simplex.
    fn climb(&self, corners: &[Vector3<f64>]) -> (Vector3<f64>, f64) {
        let dimension = corners.len() - 1;
        let point = |w: &[f64; 2]| {
            let mut x = corners[0];
            for d in 0..dimension {
                x += (corners[d + 1] - corners[0]) * w[d];
            }
            x
        };
        let value = |w: &[f64; 2]| {
            let x = point(w);
            self.at(&[x[0], x[1], x[2]])
        };
        let mut w = if dimension == 1 {
            [0.5, 0.0]
        } else {
            [1.0 / 3.0; 2]
        };
        let mut best = value(&w);
        for _ in 0..60 {
            let variables = Jet::<2>::variables(w);
            let x = array_of(|i| {
                let mut sum = Jet::constant(corners[0][i]);
                for d in 0..dimension {
                    sum = sum + variables[d] * (corners[d + 1][i] - corners[0][i]);
                }
                sum
            });
            let jet = self.at(&x);
            let step = newton_step(&jet, dimension);
            if !step.iter().all(|value| value.is_finite()) {
                break;
            }
            let mut length = longest_step(&w, &step, dimension);
            let mut moved = false;
            for _ in 0..50 {
                let next = [w[0] + length * step[0], w[1] + length * step[1]];
                let reached = value(&next);
                if reached >= best - 2.0 * f64::EPSILON * best.abs() {
                    (w, best, moved) = (next, reached.max(best), true);
                    break;
                }
                length *= 0.5;
            }
            let size = length * step[0].abs().max(step[1].abs());
            if !moved || size <= 1e-16 {
                break;
            }
        }
        let x = point(&w);
        (x, self.at(&[x[0], x[1], x[2]]))
    }

    /// Best of the corners and of the maxima inside and on the edges.
    fn best_of(&self, corners: &[Vector3<f64>]) -> (Vector3<f64>, f64) {
        let mut candidates: Vec<_> = corners
            .iter()
            .map(|x| (*x, self.at(&[x[0], x[1], x[2]])))
            .collect();
        candidates.push(self.climb(corners));
        if let [a, b, c] = corners {
            for edge in [[*a, *b], [*b, *c], [*c, *a]] {
                candidates.push(self.climb(&edge));
            }
        }
        candidates
            .into_iter()
            .filter(|(_, value)| value.is_finite())
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or((corners[0], f64::NEG_INFINITY))
    }
}

/// Largest value of the quotient of a criterion on a simplex of directions `x_i = n_i^2`, in units of `scale`.
pub(super) fn largest(
    moduli: &RateModuli,
    criterion: Criterion,
    corners: &[Vector3<f64>],
    scale: f64,
) -> Result<Largest, PlasticityError> {
    checkpoint();
    let quotients = Quotients::new(moduli, criterion, scale);
    let elastic = |x: &Vector3<f64>| quotients.determinant.at(&[x[0], x[1], x[2]]) > 0.0;
    // The elastic acoustic tensor is diagonal along the axes. It stays positive definite while its determinant is positive.
    let first = corners[0].imax();
    if !(corners.iter().all(elastic) && (0..3).all(|i| moduli.wave_stiffness(i, first) > 0.0)) {
        return Err(PlasticityError::ElasticNotElliptic);
    }
    let (mut point, mut value) = quotients.best_of(corners);
    let mut parts = BinaryHeap::from([Part {
        bound: quotients.bound(corners),
        corners: corners.to_vec(),
    }]);
    let mut bound = value;
    for count in 0.. {
        let Some(part) = parts.pop() else { break };
        bound = part.bound.max(value);
        if part.bound <= value + TOLERANCE || count == MAX_PARTS {
            break;
        }
        let halves = halves(&part.corners);
        if !elastic(&halves[0].1) {
            return Err(PlasticityError::ElasticNotElliptic);
        }
        for (corners, middle) in halves {
            let reached = quotients.at(&[middle[0], middle[1], middle[2]]);
            if reached > value + TOLERANCE {
                let climbed = quotients.best_of(&corners);
                if climbed.1 > value {
                    (point, value) = climbed;
                }
            }
            parts.push(Part {
                bound: quotients.bound(&corners).min(part.bound),
                corners,
            });
        }
    }
    if bound.is_finite() {
        Ok(Largest {
            point,
            value,
            bound,
        })
    } else {
        Err(PlasticityError::ElasticNotElliptic)
    }
}

/// Bisects a simplex across its longest edge. Each half includes the midpoint of that edge.
fn halves(corners: &[Vector3<f64>]) -> [(Vec<Vector3<f64>>, Vector3<f64>); 2] {
    let (mut first, mut second, mut longest) = (0, 1, 0.0);
    for i in 0..corners.len() {
        for j in i + 1..corners.len() {
            let length = (corners[i] - corners[j]).norm_squared();
            if length > longest {
                (first, second, longest) = (i, j, length);
            }
        }
    }
    let middle = (corners[first] + corners[second]) * 0.5;
    [first, second].map(|replaced| {
        let mut half = corners.to_vec();
        half[replaced] = middle;
        (half, middle)
    })
}

/// Newton step toward a maximum, or a gradient step if the function is not concave.
fn newton_step(jet: &Jet<2>, dimension: usize) -> [f64; 2] {
    let ([g0, g1], [[a, b], [_, c]]) = (jet.gradient, jet.hessian);
    if dimension == 1 {
        return [if a < 0.0 { -g0 / a } else { 0.25 * g0.signum() }, 0.0];
    }
    let determinant = a * c - b * b;
    if a < 0.0 && determinant > 0.0 {
        [
            -(c * g0 - b * g1) / determinant,
            -(a * g1 - b * g0) / determinant,
        ]
    } else {
        let length = g0.hypot(g1);
        [0.25 * g0 / length, 0.25 * g1 / length]
    }
}

/// Largest fraction of a step, at most one, that stays within the simplex.
fn longest_step(w: &[f64; 2], step: &[f64; 2], dimension: usize) -> f64 {
    let mut length = 1.0_f64;
    let mut limit = |weight: f64, change: f64| {
        if change < 0.0 {
            length = length.min(weight / -change);
        }
    };
    for d in 0..dimension {
        limit(w[d], step[d]);
    }
    let sum = |values: &[f64; 2]| values[..dimension].iter().sum::<f64>();
    limit(1.0 - sum(w), -sum(step));
    length
}

impl PartialEq for Part {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Part {}
impl PartialOrd for Part {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Part {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}
