//! What is known of `P - mu Q` on a box.

use super::jet::{bend, slope};
use super::squares::{Quadratic, is_positive_definite, pairs};
use crate::algebra::{Complex, Each, hermitian_eigen};
use nalgebra::DMatrix;

/// `P` and `Q` on a box.
pub(super) struct Local<const D: usize> {
    pub(super) half: [f64; D],
    pub(super) numerator: Vec<DMatrix<Complex>>,
    pub(super) denominator: Vec<DMatrix<Complex>>,
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
    /// Positive definite in the middle, perhaps not everywhere.
    Open,
}

impl<const D: usize> Local<D> {
    /// What is known of `P - mu Q` on the box, in variables scaled with its half sides.
    pub(super) fn sign(&self, mu: f64) -> Sign {
        let mut middle = self.part(0, mu, 1.0);
        if !is_positive_definite(&mut middle.clone()) {
            return Sign::Lost;
        }
        let rest = [0, 1].each(|n| self.rest[0][n] + mu.abs() * self.rest[1][n]);
        for i in 0..middle.nrows() {
            middle[(i, i)] -= Complex::new(rest[usize::from(i >= self.free)], 0.0);
        }
        if !is_positive_definite(&mut middle.clone()) {
            return Sign::Open;
        }
        let half = &self.half;
        let second = |a: usize, b: usize, factor: f64| {
            self.part(bend::<D>(a, b), mu, factor * half[a] * half[b])
        };
        let quadratic = Quadratic::<D> {
            constant: middle,
            slopes: std::array::from_fn(|a| self.part(slope(a), mu, half[a])),
            mixed: pairs::<D>()
                .map(|[a, b]| ([a, b], second(a, b, 1.0)))
                .collect(),
            pure: std::array::from_fn(|a| second(a, a, 0.5)),
        };
        if quadratic.is_positive_definite() {
            Sign::Positive
        } else {
            Sign::Open
        }
    }

    /// The smallest `mu` for which `P - mu Q` is singular at `t = 0`, where `Q` is that of free displacements alone: the others relax. Not
    /// a number where they cannot.
    pub(super) fn value(&self) -> f64 {
        let (p, q, free) = (&self.numerator[0], &self.denominator[0], self.free);
        let inner = p.nrows() - free;
        let stiff = p.view((free, free), (inner, inner)).into_owned();
        let mixed = p.view((free, 0), (inner, free)).into_owned();
        let smallest = || {
            let mut own = p.view((0, 0), (free, free)).into_owned();
            if inner > 0 {
                own -= mixed.adjoint() * stiff.lu().solve(&mixed)?;
            }
            let lower = q
                .view((0, 0), (free, free))
                .into_owned()
                .cholesky()?
                .unpack();
            let half = lower.solve_lower_triangular(&own)?;
            let own = lower.solve_lower_triangular(&half.adjoint())?;
            Some(hermitian_eigen(own)?.eigenvalues.min())
        };
        smallest().unwrap_or(f64::NAN)
    }

    /// A part of `P - mu Q`, multiplied with a factor.
    fn part(&self, n: usize, mu: f64, factor: f64) -> DMatrix<Complex> {
        self.numerator[n].zip_map(&self.denominator[n], |p, q| (p - q * mu) * factor)
    }
}
