//! Functions on a box: a Taylor polynomial of second order about the middle, and a bound of what is left.

use crate::algebra::{Complex, Each};
use nalgebra::DMatrix;
use std::ops::{Add, Mul};

/// The parts of a polynomial of second order in up to three variables: value, slopes, and second derivatives by `a` and `b <= a`.
const MOST: usize = 10;

/// How many parts there are in `D` variables.
pub(super) const fn parts<const D: usize>() -> usize {
    1 + D + D * (D + 1) / 2
}

/// The place of the slope by a variable.
pub(super) const fn slope(a: usize) -> usize {
    1 + a
}

/// The place of the second derivative by two variables.
pub(super) const fn bend<const D: usize>(a: usize, b: usize) -> usize {
    let (a, b) = if a < b { (b, a) } else { (a, b) };
    1 + D + a * (a + 1) / 2 + b
}

/// A real function on a box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet<const D: usize> {
    pub(super) parts: [f64; MOST],
    /// A bound of the difference from the polynomial.
    pub(super) rest: f64,
}

impl<const D: usize> Jet<D> {
    pub(super) const ZERO: Self = Self {
        parts: [0.0; MOST],
        rest: 0.0,
    };

    /// The variable `a` itself, at its value in the middle.
    pub(super) fn variable(a: usize, value: f64) -> Self {
        let mut jet = Self::ZERO;
        jet.parts[0] = value;
        jet.parts[slope(a)] = 1.0;
        jet
    }

    /// The product on a box with given half sides.
    pub(super) fn times(&self, other: &Self, half: &[f64; D]) -> Self {
        let [x, y] = [self, other].each(|jet| sizes::<D>(half, jet.rest, |n| jet.parts[n].abs()));
        Self {
            parts: product::<f64, D>(&self.parts[..parts::<D>()], &other.parts[..parts::<D>()]),
            rest: rest_of_product(x, y),
        }
    }
}

/// Bounds of the terms of each order, and the rest.
type Sizes = [f64; 4];

fn sizes<const D: usize>(half: &[f64; D], rest: f64, size: impl Fn(usize) -> f64) -> Sizes {
    let mut sizes = [size(0), 0.0, 0.0, rest];
    for a in 0..D {
        sizes[1] += half[a] * size(slope(a));
        for b in 0..D {
            sizes[2] += 0.5 * half[a] * half[b] * size(bend::<D>(a, b));
        }
    }
    sizes
}

/// What a product has beyond the second order.
fn rest_of_product(x: Sizes, y: Sizes) -> f64 {
    let all = |s: &Sizes| s.iter().sum::<f64>();
    x[0] * y[3] + x[1] * (y[2] + y[3]) + x[2] * (y[1] + y[2] + y[3]) + x[3] * all(&y)
}

/// The product of polynomials to second order.
fn product<T, const D: usize>(x: &[f64], y: &[T]) -> [T; MOST]
where
    T: Copy + Default + Add<Output = T> + Mul<f64, Output = T>,
{
    let mut product = [T::default(); MOST];
    product[0] = y[0] * x[0];
    for a in 0..D {
        product[slope(a)] = y[slope(a)] * x[0] + y[0] * x[slope(a)];
        for b in 0..=a {
            let n = bend::<D>(a, b);
            product[n] =
                y[n] * x[0] + y[0] * x[n] + y[slope(a)] * x[slope(b)] + y[slope(b)] * x[slope(a)];
        }
    }
    product
}

/// A complex matrix on a box.
#[derive(Clone, Debug)]
pub(super) struct MatrixJet<const D: usize> {
    pub(super) parts: Vec<DMatrix<Complex>>,
    /// A bound of the norm of the difference from the polynomial.
    pub(super) rest: f64,
}

impl<const D: usize> MatrixJet<D> {
    pub(super) fn zeros(rows: usize, columns: usize) -> Self {
        Self {
            parts: vec![DMatrix::zeros(rows, columns); parts::<D>()],
            rest: 0.0,
        }
    }

    pub(super) fn identity(size: usize) -> Self {
        let mut jet = Self::zeros(size, size);
        jet.parts[0].fill_with_identity();
        jet
    }

    /// Adds to the block that begins in a row and a column the product of a real block with parts.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        (row, column): (usize, usize),
        block: &nalgebra::SMatrix<f64, D, D>,
        phase: &[Complex; MOST],
    ) {
        let rows = self.parts[0].nrows();
        for (matrix, phase) in self.parts.iter_mut().zip(phase) {
            let entries = matrix.as_mut_slice();
            for j in 0..D {
                let start = (column + j) * rows + row;
                for (entry, x) in entries[start..start + D]
                    .iter_mut()
                    .zip(block.column(j).iter())
                {
                    *entry += phase * x;
                }
            }
        }
    }

    /// Adds the adjoint.
    pub(super) fn symmetrize(&mut self) {
        for part in &mut self.parts {
            let adjoint = part.adjoint();
            *part += adjoint;
        }
    }

    /// The product with a real function on a box with given half sides.
    pub(super) fn times(&self, factor: &Jet<D>, half: &[f64; D]) -> Self {
        let own = sizes::<D>(half, self.rest, |n| self.parts[n].norm());
        let other = sizes::<D>(half, factor.rest, |n| factor.parts[n].abs());
        let (rows, columns) = self.parts[0].shape();
        let mut result = Self::zeros(rows, columns);
        result.rest = rest_of_product(own, other);
        for entry in 0..rows * columns {
            let mut own = [Complex::default(); MOST];
            for (own, part) in own.iter_mut().zip(&self.parts) {
                *own = part[entry];
            }
            let products = product::<Complex, D>(&factor.parts, &own);
            for (part, product) in result.parts.iter_mut().zip(products) {
                part[entry] = product;
            }
        }
        result
    }

    /// `S R` with a matrix whose columns are orthonormal.
    pub(super) fn onto(&self, basis: &DMatrix<Complex>) -> Self {
        Self {
            parts: self.parts.iter().map(|part| part * basis).collect(),
            rest: self.rest,
        }
    }

    /// `R* S`.
    pub(super) fn onto_rows(&self, basis: &DMatrix<Complex>) -> Self {
        let adjoint = basis.adjoint();
        Self {
            parts: self.parts.iter().map(|part| &adjoint * part).collect(),
            rest: self.rest,
        }
    }
}
