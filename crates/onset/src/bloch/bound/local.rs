//! Test whether `P - mu Q` is positive definite on a box.

use super::jet::{Parts, monomials, parts};
use super::polynomial::Polynomial;
use crate::algebra::{Complex, Each, cholesky_factor, factorize, hermitian_eigen};

/// Polynomials of `P` and `Q` on a box.
pub(super) struct Local<const D: usize> {
    pub(super) half: [f64; D],
    pub(super) numerator: Parts,
    pub(super) denominator: Parts,
    /// Number of free displacements.
    pub(super) free: usize,
    /// Bounds of the remainders of `P` and `Q`, for free and for other displacements.
    pub(super) rest: [[f64; 2]; 2],
    /// Contribution of the second derivatives with respect to each variable.
    pub(super) bends: [f64; D],
}

/// Sign of `P - mu Q` on a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sign {
    /// Positive definite on the whole box.
    Positive,
    /// Not positive definite at the center.
    Lost,
    /// Positive definite at the center, without proof for the whole box. The box should be halved `divisions` times before the next test.
    Open { divisions: usize },
}

/// Maximum number of halvings before the next test.
const MAXIMUM_DIVISIONS: usize = 3;

impl<const D: usize> Local<D> {
    /// Tests `P - mu Q` on the box, in variables scaled with its half sides.
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
            // The remainders of the polynomials are of fourth order in the half sides.
            let is_enough = |divisions: &usize| {
                let share = 0.5_f64.powf((4 * divisions) as f64 / D as f64);
                factorize(&mut without_rest(share))
            };
            let divisions = (1..MAXIMUM_DIVISIONS).find(is_enough);
            return Sign::Open {
                divisions: divisions.unwrap_or(MAXIMUM_DIVISIONS),
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

    /// Smallest `mu` for which `P - mu Q` is singular at the center: the measure itself.
    ///
    /// At `t = 0`, `Q` acts on the free displacements alone, and the others relax. NaN if they cannot relax.
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
