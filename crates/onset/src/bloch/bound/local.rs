//! What is known of `P - mu Q` on a box.

use super::jet::{Parts, monomials, parts};
use super::polynomial::Polynomial;
use crate::algebra::{Complex, Each, cholesky_factor, factorize, hermitian_eigen};

/// `P` and `Q` on a box.
pub(super) struct Local<const D: usize> {
    pub(super) half: [f64; D],
    pub(super) numerator: Parts,
    pub(super) denominator: Parts,
    /// How many displacements are free.
    pub(super) free: usize,
    /// Bounds of what the polynomials leave out, for free displacements and others.
    pub(super) rest: [[f64; 2]; 2],
    /// How much the second derivatives by each variable may do.
    pub(super) bends: [f64; D],
}

/// What is known of `P - mu Q` on a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sign {
    /// Positive definite.
    Positive,
    /// Not, in the middle.
    Lost,
    /// Positive definite in the middle, perhaps not everywhere: so many times the box should be halved before it is looked at again.
    Open { divisions: usize },
}

/// Halvings at once, at most.
const MOST_DIVISIONS: usize = 3;

impl<const D: usize> Local<D> {
    /// What is known of `P - mu Q` on the box, in variables scaled with its half sides.
    pub(super) fn sign(&self, mu: f64) -> Sign {
        let (p, q) = (self.numerator.part(0), self.denominator.part(0));
        let middle = p.zip_map(&q, |p, q| p - q * mu);
        if !factorize(&mut middle.clone()) {
            return Sign::Lost;
        }
        let rest = [0, 1].each(|n| self.rest[0][n] + mu.abs() * self.rest[1][n]);
        let without_rest = |share: f64| {
            let mut least = middle.clone();
            for i in 0..least.nrows() {
                least[(i, i)] -= Complex::new(share * rest[usize::from(i >= self.free)], 0.0);
            }
            least
        };
        let least = without_rest(1.0);
        if !factorize(&mut least.clone()) {
            // What is left out of polynomials is of the fourth order in the half sides.
            let is_enough = |divisions: &usize| {
                let share = 0.5_f64.powf((4 * divisions) as f64 / D as f64);
                factorize(&mut without_rest(share))
            };
            let divisions = (1..MOST_DIVISIONS).find(is_enough);
            return Sign::Open {
                divisions: divisions.unwrap_or(MOST_DIVISIONS),
            };
        }
        let (rows, columns) = self.numerator.shape();
        let mut coefficients = Parts::zeros(rows, columns, parts::<D>());
        coefficients.part_mut(0).copy_from(&least);
        let factors = monomials::<D>(&self.half);
        for (n, factor) in factors.into_iter().enumerate().take(parts::<D>()).skip(1) {
            coefficients.add_part(n, (&self.numerator, n), factor);
            coefficients.add_part(n, (&self.denominator, n), -mu * factor);
        }
        match Polynomial::<D>(coefficients).is_positive_definite() {
            true => Sign::Positive,
            false => Sign::Open { divisions: 1 },
        }
    }

    /// The smallest `mu` for which `P - mu Q` is singular at `t = 0`, where `Q` is that of free displacements alone: the others relax. Not
    /// a number where they cannot.
    pub(super) fn value(&self) -> f64 {
        let (p, q, free) = (self.numerator.part(0), self.denominator.part(0), self.free);
        let inner = p.nrows() - free;
        let stiff = p.view((free, free), (inner, inner)).into_owned();
        let mixed = p.view((free, 0), (inner, free)).into_owned();
        let smallest = || {
            let mut own = p.view((0, 0), (free, free)).into_owned();
            if inner > 0 {
                own -= mixed.adjoint() * stiff.lu().solve(&mixed)?;
            }
            let lower = cholesky_factor(q.view((0, 0), (free, free)).into_owned())?;
            let half = lower.solve_lower_triangular(&own)?;
            let own = lower.solve_lower_triangular(&half.adjoint())?;
            Some(hermitian_eigen(own)?.eigenvalues.min())
        };
        smallest().unwrap_or(f64::NAN)
    }
}
