//! Shape functions in plain or dual numbers, so that positions may carry derivatives.
//!
//! `phi_K = alpha . p(xi_K) W(xi_K)`, `xi_K = x_K - x`, with `M alpha = e_0`, `M = sum_K W p (x) p` for a basis `p` of monomials.
//! The gradient with respect to the point follows from `D_j alpha = M^-1 M_j alpha`, `M_j = sum_K (W p (x) p)_,j`. Raw weights have the constant
//! `alpha = V_K / integral of W`.
//!
//! Corrected gradients are `C^T h_K`, `h_K = W_,K - n_K sum_L W_,L`, `C = (sum_K xi_K (x) h_K)^-1`. The `n_K` are Shepard's functions, or 1 at the
//! particle that coincides with the point. The values are Shepard's functions.

use super::super::layout::{MovingWeight, Weighed};
use crate::algebra::{Each, array_of};
use crate::approximation::{Approximation, MAXIMUM_CONDITION, SingularMoment};
use crate::real::Real;

/// Correction of the weights.
#[derive(Clone, Debug)]
enum Basis<const D: usize> {
    /// Raw weights, without correction.
    Raw,
    /// Monomials, given by their exponents; the constant first.
    Monomials(Vec<[i32; D]>),
    /// A matrix that corrects the gradients of differences. Differences are taken to the particle at the point, or to an interpolated value.
    Gradients { to_particle: bool },
}

/// Rule that turns weights into shape functions.
#[derive(Clone, Debug)]
pub(super) struct Shape<const D: usize> {
    basis: Basis<D>,
    weight: MovingWeight<D>,
}

/// Values and gradients of the shape functions at a point.
#[derive(Clone, Debug)]
pub(super) struct ShapeValues<R, const D: usize> {
    /// Values `phi_K` of the functions.
    pub(super) values: Vec<R>,
    /// Gradients `phi_K,j` with respect to the point; 1/length.
    pub(super) gradients: Vec<[R; D]>,
}

impl<const D: usize> Shape<D> {
    pub(super) fn new(approximation: Approximation, weight: MovingWeight<D>) -> Self {
        let basis = match approximation {
            Approximation::Raw => Basis::Raw,
            Approximation::Shepard => Basis::Monomials(exponents(0)),
            Approximation::Mls => Basis::Monomials(exponents(1)),
            Approximation::Mls2 => Basis::Monomials(exponents(2)),
            Approximation::Mls3 => Basis::Monomials(exponents(3)),
            Approximation::RandlesLibersky => Basis::Gradients { to_particle: true },
            Approximation::KrongauzBelytschko => Basis::Gradients { to_particle: false },
        };
        let weight = match basis {
            Basis::Raw => weight.normalized(),
            Basis::Monomials(_) | Basis::Gradients { .. } => weight,
        };
        Self { basis, weight }
    }

    /// Shape functions of particles at positions relative to the point, nearest first, with their volumes there. `None` if the moment matrix is
    /// singular.
    pub(super) fn at<R: Real>(
        &self,
        positions: &[[R; D]],
        volumes: &[f64],
        is_node: bool,
    ) -> Option<ShapeValues<R, D>> {
        match &self.basis {
            Basis::Raw => Some(self.raw(positions, volumes)),
            Basis::Monomials(exponents) => self.reproducing(positions, exponents),
            Basis::Gradients { to_particle } => self
                .differences(positions, *to_particle && is_node)
                .corrected(),
        }
    }

    /// Rejects neighbors that do not determine the coefficients.
    pub(super) fn assert_regular(
        &self,
        positions: &[[f64; D]],
        is_node: bool,
    ) -> Result<(), SingularMoment> {
        let moment = match &self.basis {
            Basis::Raw => return Ok(()),
            Basis::Monomials(exponents) => {
                moment(&self.terms(positions, exponents), exponents.len())
            }
            Basis::Gradients { to_particle } => self
                .differences(positions, *to_particle && is_node)
                .moment(),
        };
        let largest = |m: &[Vec<f64>]| {
            m.iter()
                .flatten()
                .fold(0.0, |most: f64, x| most.max(x.abs()))
        };
        let condition = inverse(&moment).map_or(f64::INFINITY, |inverse| {
            largest(&inverse) * largest(&moment)
        });
        if condition < MAXIMUM_CONDITION {
            Ok(())
        } else {
            Err(SingularMoment { condition })
        }
    }

    /// Shepard's functions and the gradients `h_K` of differences.
    fn differences<R: Real>(&self, positions: &[[R; D]], to_particle: bool) -> Differences<R, D> {
        let zero = R::constant(0.0);
        let weighed: Vec<_> = positions.iter().map(|x| self.weight.at(x)).collect();
        let sum = weighed.iter().fold(zero, |sum, w| sum + w.value);
        let total: [R; D] = array_of(|j| weighed.iter().fold(zero, |sum, w| sum + w.gradient[j]));
        let values: Vec<R> = weighed.iter().map(|w| w.value / sum).collect();
        let share = |number: usize| match (to_particle, number) {
            (true, 0) => R::constant(1.0),
            (true, _) => zero,
            (false, _) => values[number],
        };
        let difference = |(number, w): (usize, &Weighed<R, D>)| -> [R; D] {
            array_of(|j| w.gradient[j] - share(number) * total[j])
        };
        Differences {
            positions: positions.to_vec(),
            differences: weighed.iter().enumerate().map(difference).collect(),
            values,
        }
    }

    fn raw<R: Real>(&self, positions: &[[R; D]], volumes: &[f64]) -> ShapeValues<R, D> {
        let weighed = positions.iter().map(|x| self.weight.at(x));
        let (values, gradients) = weighed
            .zip(volumes)
            .map(|(w, volume)| (w.value * *volume, w.gradient.each(|slope| slope * -volume)))
            .unzip();
        ShapeValues { values, gradients }
    }

    fn reproducing<R: Real>(
        &self,
        positions: &[[R; D]],
        exponents: &[[i32; D]],
    ) -> Option<ShapeValues<R, D>> {
        let size = exponents.len();
        let terms = self.terms(positions, exponents);
        let inverse = inverse(&moment(&terms, size))?;
        let alpha: Vec<R> = (0..size).map(|a| inverse[a][0]).collect();
        let slopes: [Vec<R>; D] = std::array::from_fn(|j| {
            // Product `M_j alpha`.
            let mut sum = vec![R::constant(0.0); size];
            for term in &terms {
                let (along, slope) = (dot(&term.p, &alpha), dot(&term.slopes[j], &alpha));
                for (a, entry) in sum.iter_mut().enumerate() {
                    // (W p (x) p)_,j alpha = (W p)_,j (p . alpha) + p W (p_,j . alpha).
                    let own = term.weight * term.p[a];
                    *entry = *entry + term.weighted_slopes[j][a] * along + own * slope;
                }
            }
            inverse.iter().map(|row| dot(row, &sum)).collect()
        });
        let value = |term: &Term<R, D>| dot(&term.p, &alpha) * term.weight;
        let gradient = |term: &Term<R, D>| -> [R; D] {
            array_of(|j| {
                dot(&slopes[j], &term.p) * term.weight - dot(&alpha, &term.weighted_slopes[j])
            })
        };
        Some(ShapeValues {
            values: terms.iter().map(value).collect(),
            gradients: terms.iter().map(gradient).collect(),
        })
    }

    fn terms<R: Real>(&self, positions: &[[R; D]], exponents: &[[i32; D]]) -> Vec<Term<R, D>> {
        let length = self.weight.radius();
        let term = |x: &[R; D]| {
            let weighed = self.weight.at(x);
            let scaled = x.each(|component| component / length);
            let monomial = |e: &[i32; D]| {
                (0..D).fold(R::constant(1.0), |product, i| match e[i] {
                    0 => product,
                    n => product * scaled[i].powi(n),
                })
            };
            let slope = |e: &[i32; D], j: usize| {
                let mut lower = *e;
                lower[j] -= 1;
                match e[j] {
                    0 => R::constant(0.0),
                    n => monomial(&lower) * (f64::from(n) / length),
                }
            };
            let p: Vec<R> = exponents.iter().map(monomial).collect();
            let slopes: [Vec<R>; D] =
                std::array::from_fn(|j| exponents.iter().map(|e| slope(e, j)).collect());
            let weighted_slopes = std::array::from_fn(|j| {
                let both = slopes[j].iter().zip(&p);
                both.map(|(slope, p)| *slope * weighed.value + *p * weighed.gradient[j])
                    .collect()
            });
            Term {
                weight: weighed.value,
                p,
                slopes,
                weighted_slopes,
            }
        };
        positions.iter().map(term).collect()
    }
}

/// Shepard's functions with the uncorrected gradients of differences.
struct Differences<R, const D: usize> {
    positions: Vec<[R; D]>,
    values: Vec<R>,
    /// Gradients `h_K` of differences.
    differences: Vec<[R; D]>,
}

impl<R: Real, const D: usize> Differences<R, D> {
    /// Uncorrected moment matrix `sum_K xi_K (x) h_K`.
    fn moment(&self) -> Vec<Vec<R>> {
        let both = || self.positions.iter().zip(&self.differences);
        let entry =
            |i: usize, j: usize| both().fold(R::constant(0.0), |sum, (x, h)| sum + x[i] * h[j]);
        (0..D)
            .map(|i| (0..D).map(|j| entry(i, j)).collect())
            .collect()
    }

    fn corrected(self) -> Option<ShapeValues<R, D>> {
        let inverse = inverse(&self.moment())?;
        let gradient = |h: &[R; D]| -> [R; D] {
            array_of(|i| (0..D).fold(R::constant(0.0), |sum, j| sum + inverse[j][i] * h[j]))
        };
        Some(ShapeValues {
            gradients: self.differences.iter().map(gradient).collect(),
            values: self.values,
        })
    }
}

/// Contribution of a neighbor to the moment matrix.
struct Term<R, const D: usize> {
    /// Value of the weight `W`.
    weight: R,
    /// Values of the monomials `p`.
    p: Vec<R>,
    /// Derivatives `p_,j` of the monomials.
    slopes: [Vec<R>; D],
    /// Derivatives `(W p)_,j` of the weighted monomials.
    weighted_slopes: [Vec<R>; D],
}

/// Exponents of all monomials up to a degree, the constant first.
fn exponents<const D: usize>(degree: i32) -> Vec<[i32; D]> {
    let cells = crate::lattice::cells_between(&[0; D], &[degree; D]);
    let mut exponents: Vec<[i32; D]> = cells
        .into_iter()
        .filter(|e| e.iter().sum::<i32>() <= degree)
        .collect();
    exponents.sort_by_key(|e| e.iter().sum::<i32>());
    exponents
}

fn dot<R: Real>(a: &[R], b: &[R]) -> R {
    let products = a.iter().zip(b).map(|(x, y)| *x * *y);
    products.fold(R::constant(0.0), |sum, product| sum + product)
}

/// Moment matrix of the weights, `M = sum_K W p (x) p`.
fn moment<R: Real, const D: usize>(terms: &[Term<R, D>], size: usize) -> Vec<Vec<R>> {
    let mut moment = vec![vec![R::constant(0.0); size]; size];
    for term in terms {
        for (row, a) in moment.iter_mut().zip(&term.p) {
            for (entry, b) in row.iter_mut().zip(&term.p) {
                *entry = *entry + term.weight * *a * *b;
            }
        }
    }
    moment
}

/// Inverse by Gauss-Jordan elimination, with pivots chosen by their values. `None` if a pivot vanishes.
fn inverse<R: Real>(matrix: &[Vec<R>]) -> Option<Vec<Vec<R>>> {
    let size = matrix.len();
    let mut left = matrix.to_vec();
    let unit = |i: usize, j: usize| R::constant(f64::from(u8::from(i == j)));
    let mut right: Vec<Vec<R>> = (0..size)
        .map(|i| (0..size).map(|j| unit(i, j)).collect())
        .collect();
    for column in 0..size {
        let magnitude = |row: usize| left[row][column].value().abs();
        let pivot = (column..size).max_by(|a, b| magnitude(*a).total_cmp(&magnitude(*b)))?;
        if magnitude(pivot) == 0.0 || !magnitude(pivot).is_finite() {
            return None;
        }
        left.swap(column, pivot);
        right.swap(column, pivot);
        let scale = left[column][column].recip();
        for half in [&mut left, &mut right] {
            half[column].iter_mut().for_each(|x| *x = *x * scale);
        }
        for row in (0..size).filter(|row| *row != column) {
            let factor = left[row][column];
            for half in [&mut left, &mut right] {
                for j in 0..size {
                    half[row][j] = half[row][j] - half[column][j] * factor;
                }
            }
        }
    }
    Some(right)
}
