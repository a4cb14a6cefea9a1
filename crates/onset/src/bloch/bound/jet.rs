//! Functions on a box: a Taylor polynomial of third order about the center, and a bound of the remainder.

use crate::algebra::{Complex, Each};
use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut};
use std::ops::{Add, Mul};

/// Number of coefficients of a polynomial of third order in three variables. The order is: value, slopes, second derivatives with respect to `a` and
/// `b <= a`, third derivatives with respect to `a`, `b <= a` and `c <= b`.
const CUBIC_PARTS: usize = 20;

/// Number of derivatives up to the fourth order in three variables, padded to a multiple of a vector register.
pub(super) const FILLED: usize = 40;

/// Number of coefficients in `D` variables up to the second order.
pub(super) const fn quadratic_parts<const D: usize>() -> usize {
    1 + D + D * (D + 1) / 2
}

/// Number of coefficients in `D` variables up to the third order.
pub(super) const fn parts<const D: usize>() -> usize {
    quadratic_parts::<D>() + D * (D + 1) * (D + 2) / 6
}

/// Index of the slope with respect to a variable.
pub(super) const fn slope(a: usize) -> usize {
    1 + a
}

/// Index of the second derivative with respect to two variables.
pub(super) const fn bend<const D: usize>(a: usize, b: usize) -> usize {
    let (a, b) = if a < b { (b, a) } else { (a, b) };
    1 + D + a * (a + 1) / 2 + b
}

/// Index of the third derivative with respect to three variables.
pub(super) fn third<const D: usize>(a: usize, b: usize, c: usize) -> usize {
    let mut by = [a, b, c];
    by.sort_unstable();
    let [c, b, a] = by;
    quadratic_parts::<D>() + a * (a + 1) * (a + 2) / 6 + b * (b + 1) / 2 + c
}

/// Pairs of variables of the second derivatives, each pair once.
pub(super) fn seconds<const D: usize>() -> impl Iterator<Item = [usize; 2]> {
    (0..D).flat_map(|a| (0..=a).map(move |b| [a, b]))
}

/// Pairs of different variables, each pair once.
pub(super) fn mixed<const D: usize>() -> impl Iterator<Item = [usize; 2]> {
    seconds::<D>().filter(|[a, b]| a != b)
}

/// Triples of variables of the third derivatives, each triple once.
pub(super) fn thirds<const D: usize>() -> impl Iterator<Item = [usize; 3]> {
    seconds::<D>().flat_map(|[a, b]| (0..=b).map(move |c| [a, b, c]))
}

/// A derivative up to the fourth order.
#[derive(Clone, Copy)]
pub(super) struct Derivative {
    /// Index of the derivative without its last variable; the variables are sorted from highest to lowest.
    before: usize,
    /// Last variable of the derivative.
    last: usize,
    /// Multiplicity of the last variable.
    times: usize,
    pub(super) order: usize,
    /// Multiplicity of the first of all variables.
    pub(super) by_first: usize,
}

/// All derivatives up to the fourth order, in their order of storage.
pub(super) const fn derivatives<const D: usize>() -> [Derivative; FILLED] {
    let none = Derivative {
        before: 0,
        last: 0,
        times: 0,
        order: 0,
        by_first: 0,
    };
    let mut derivatives = [none; FILLED];
    // Derivatives of one order lie between `start` and `end`.
    let (mut start, mut end, mut order) = (0, 1, 1);
    while order <= 4 {
        let (mut before, mut n) = (start, end);
        while before < end {
            let own = derivatives[before];
            let highest = if order == 1 { D - 1 } else { own.last };
            let mut last = 0;
            while last <= highest {
                let is_repeated = order > 1 && last == own.last;
                derivatives[n] = Derivative {
                    before,
                    last,
                    times: if is_repeated { own.times + 1 } else { 1 },
                    order,
                    by_first: own.by_first + (last == 0) as usize,
                };
                last += 1;
                n += 1;
            }
            before += 1;
        }
        (start, end, order) = (end, n, order + 1);
    }
    derivatives
}

/// Number of derivatives up to the fourth order in `D` variables, padded to a multiple of a vector register.
pub(super) const fn filled<const D: usize>() -> usize {
    let fourths = D * (D + 1) * (D + 2) * (D + 3) / 24;
    (parts::<D>() + fourths).next_multiple_of(8)
}

/// Product of the variables of each derivative.
pub(super) fn products<const D: usize>(x: &[f64; D]) -> [f64; FILLED] {
    let mut products = [0.0; FILLED];
    products[0] = 1.0;
    for (n, own) in const { derivatives::<D>() }.iter().enumerate().skip(1) {
        if own.order > 0 {
            products[n] = products[own.before] * x[own.last];
        }
    }
    products
}

/// Factor of each derivative in a polynomial whose variables are scaled by the half sides of a box.
pub(super) fn monomials<const D: usize>(half: &[f64; D]) -> [f64; FILLED] {
    let mut monomials = [0.0; FILLED];
    monomials[0] = 1.0;
    for (n, own) in const { derivatives::<D>() }.iter().enumerate().skip(1) {
        if own.order > 0 {
            monomials[n] = monomials[own.before] * half[own.last] / own.times as f64;
        }
    }
    monomials
}

/// A real function on a box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet<const D: usize> {
    pub(super) parts: [f64; CUBIC_PARTS],
    /// Bound of the difference from the polynomial.
    pub(super) rest: f64,
}

impl<const D: usize> Jet<D> {
    pub(super) const ZERO: Self = Self {
        parts: [0.0; CUBIC_PARTS],
        rest: 0.0,
    };

    pub(super) const ONE: Self = {
        let mut jet = Self::ZERO;
        jet.parts[0] = 1.0;
        jet
    };

    /// Coordinate function of the variable `a`, with its value at the center.
    pub(super) fn variable(a: usize, value: f64) -> Self {
        let mut jet = Self::ZERO;
        jet.parts[0] = value;
        jet.parts[slope(a)] = 1.0;
        jet
    }

    /// Product of two functions on a box with the given half sides.
    pub(super) fn times(&self, other: &Self, half: &[f64; D]) -> Self {
        let [x, y] = [self, other].each(|jet| sizes::<D>(half, jet.rest, |n| jet.parts[n].abs()));
        Self {
            parts: product::<f64, D>(&self.parts[..parts::<D>()], &other.parts[..parts::<D>()]),
            rest: rest_of_product(x, y),
        }
    }
}

/// Bounds of the terms of each order, and the remainder.
type Sizes = [f64; 5];

fn sizes<const D: usize>(half: &[f64; D], rest: f64, size: impl Fn(usize) -> f64) -> Sizes {
    let mut sizes = [size(0), 0.0, 0.0, 0.0, rest];
    for a in 0..D {
        sizes[1] += half[a] * size(slope(a));
        for b in 0..D {
            sizes[2] += half[a] * half[b] * size(bend::<D>(a, b)) / 2.0;
            for c in 0..D {
                sizes[3] += half[a] * half[b] * half[c] * size(third::<D>(a, b, c)) / 6.0;
            }
        }
    }
    sizes
}

/// Bound of the terms of a product beyond the third order.
fn rest_of_product(x: Sizes, y: Sizes) -> f64 {
    let from = |order: usize| y[order..].iter().sum::<f64>();
    (0..5).map(|order| x[order] * from(4 - order)).sum()
}

/// Product of two polynomials up to third order.
fn product<T, const D: usize>(x: &[f64], y: &[T]) -> [T; CUBIC_PARTS]
where
    T: Copy + Default + Add<Output = T> + Mul<f64, Output = T>,
{
    let mut product = [T::default(); CUBIC_PARTS];
    product[0] = y[0] * x[0];
    for a in 0..D {
        product[slope(a)] = y[slope(a)] * x[0] + y[0] * x[slope(a)];
    }
    for [a, b] in seconds::<D>() {
        let n = bend::<D>(a, b);
        product[n] =
            y[n] * x[0] + y[0] * x[n] + y[slope(a)] * x[slope(b)] + y[slope(b)] * x[slope(a)];
    }
    for [a, b, c] in thirds::<D>() {
        let n = third::<D>(a, b, c);
        product[n] = y[n] * x[0] + y[0] * x[n];
        for (single, pair) in [(a, [b, c]), (b, [a, c]), (c, [a, b])] {
            let (single, pair) = (slope(single), bend::<D>(pair[0], pair[1]));
            product[n] = product[n] + y[single] * x[pair] + y[pair] * x[single];
        }
    }
    product
}

/// Matrices of equal shape stored next to each other: the coefficients of a matrix polynomial.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    all: DMatrix<Complex>,
    columns: usize,
}

impl Parts {
    pub(super) fn zeros(rows: usize, columns: usize, count: usize) -> Self {
        Self {
            all: DMatrix::zeros(rows, columns * count),
            columns,
        }
    }

    pub(super) fn shape(&self) -> (usize, usize) {
        (self.all.nrows(), self.columns)
    }

    pub(super) fn part(&self, n: usize) -> DMatrixView<'_, Complex> {
        self.all.columns(n * self.columns, self.columns)
    }

    pub(super) fn part_mut(&mut self, n: usize) -> DMatrixViewMut<'_, Complex> {
        self.all.columns_mut(n * self.columns, self.columns)
    }

    /// Entries of a coefficient, column by column.
    pub(super) fn entries(&self, n: usize) -> &[Complex] {
        let size = self.all.nrows() * self.columns;
        &self.all.as_slice()[n * size..(n + 1) * size]
    }

    pub(super) fn entries_mut(&mut self, n: usize) -> &mut [Complex] {
        let size = self.all.nrows() * self.columns;
        &mut self.all.as_mut_slice()[n * size..(n + 1) * size]
    }

    /// Adds a multiple of one coefficient to another.
    pub(super) fn add_part(&mut self, to: usize, from: (&Self, usize), factor: f64) {
        let own = self.entries_mut(to).iter_mut();
        own.zip(from.0.entries(from.1))
            .for_each(|(own, entry)| *own += entry * factor);
    }

    /// Multiplies all coefficients by `R` from the right.
    pub(super) fn times(&self, right: &DMatrix<Complex>) -> Self {
        let count = self.all.ncols().checked_div(self.columns).unwrap_or(0);
        let mut product = Self::zeros(self.all.nrows(), right.ncols(), count);
        for n in 0..count {
            self.part(n).mul_to(right, &mut product.part_mut(n));
        }
        product
    }

    /// Multiplies all coefficients by `R*` from the left.
    pub(super) fn onto_rows(&self, right: &DMatrix<Complex>) -> Self {
        Self {
            all: right.ad_mul(&self.all),
            columns: self.columns,
        }
    }
}

/// Bound of the spectral norm of a Hermitian matrix: the smaller of its largest row sum and its Frobenius norm.
pub(super) fn norm_of(matrix: &DMatrixView<'_, Complex>) -> f64 {
    let (mut squares, mut most) = (0.0, 0.0_f64);
    for row in 0..matrix.nrows() {
        let mut sum = 0.0;
        for column in 0..matrix.ncols() {
            let square = matrix[(row, column)].norm_sqr();
            squares += square;
            sum += square.sqrt();
        }
        most = most.max(sum);
    }
    most.min(squares.sqrt())
}

/// A complex matrix on a box.
#[derive(Clone, Debug)]
pub(super) struct MatrixJet<const D: usize> {
    pub(super) parts: Parts,
    /// Bound of the norm of the difference from the polynomial.
    pub(super) rest: f64,
}

impl<const D: usize> MatrixJet<D> {
    pub(super) fn zeros(rows: usize, columns: usize) -> Self {
        Self {
            parts: Parts::zeros(rows, columns, parts::<D>()),
            rest: 0.0,
        }
    }

    /// Multiple of the identity by a real function.
    pub(super) fn multiple(size: usize, factor: &Jet<D>) -> Self {
        let mut jet = Self::zeros(size, size);
        for (n, factor) in factor.parts.iter().take(parts::<D>()).enumerate() {
            jet.parts
                .part_mut(n)
                .fill_diagonal(Complex::new(*factor, 0.0));
        }
        jet.rest = factor.rest;
        jet
    }

    /// Product with a real function on a box with the given half sides.
    pub(super) fn times(&self, factor: &Jet<D>, half: &[f64; D]) -> Self {
        let own = sizes::<D>(half, self.rest, |n| self.parts.part(n).norm());
        let other = sizes::<D>(half, factor.rest, |n| factor.parts[n].abs());
        let (rows, columns) = self.parts.shape();
        let mut result = Self::zeros(rows, columns);
        result.rest = rest_of_product(own, other);
        for entry in 0..rows * columns {
            let mut own = [Complex::default(); CUBIC_PARTS];
            for n in 0..parts::<D>() {
                own[n] = self.parts.entries(n)[entry];
            }
            let products = product::<Complex, D>(&factor.parts, &own);
            for n in 0..parts::<D>() {
                result.parts.entries_mut(n)[entry] = products[n];
            }
        }
        result
    }

    /// Product `S R` with a matrix of orthonormal columns.
    pub(super) fn onto(&self, basis: &DMatrix<Complex>) -> Self {
        Self {
            parts: self.parts.times(basis),
            rest: self.rest,
        }
    }

    /// Product `R* S` with a matrix of orthonormal columns.
    pub(super) fn onto_rows(&self, basis: &DMatrix<Complex>) -> Self {
        Self {
            parts: self.parts.onto_rows(basis),
            rest: self.rest,
        }
    }
}
