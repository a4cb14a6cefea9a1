//! Bases of monomials and the contributions of neighbors to moment matrices.

use crate::algebra::array_of;
use crate::kernel::Weight;
use nalgebra::SVector;

/// Number of monomials of `D` variables up to a degree, `(D + degree)! / (D! degree!)`.
///
/// ```
/// use onset::approximation::basis_size;
/// assert_eq!([basis_size(1, 3), basis_size(2, 2), basis_size(3, 3)], [4, 6, 20]);
/// ```
pub const fn basis_size(dimension: usize, degree: usize) -> usize {
    let (mut size, mut i) = (1, 1);
    while i <= dimension {
        size = size * (degree + i) / i;
        i += 1;
    }
    size
}

/// Basis `p` at a neighbor with its derivatives.
pub(super) struct BasisValue<const D: usize, const B: usize> {
    value: SVector<f64, B>,
    gradient: [SVector<f64, B>; D],
    hessian: [[SVector<f64, B>; D]; D],
}

impl<const D: usize, const B: usize> BasisValue<D, B> {
    /// Basis of constants, `p = (1)`.
    pub(super) fn constant() -> Self {
        Self {
            value: SVector::repeat(1.0),
            gradient: [SVector::zeros(); D],
            hessian: [[SVector::zeros(); D]; D],
        }
    }
}

/// Exponents of `B` monomials by increasing degree: first 1, then the components.
pub(super) struct Monomials<const D: usize, const B: usize> {
    exponents: [[u8; D]; B],
}

impl<const D: usize, const B: usize> Monomials<D, B> {
    pub(super) fn new() -> Self {
        let mut all = (0..).flat_map(of_degree::<D>);
        Self {
            exponents: array_of(|_| all.next().unwrap_or([0; D])),
        }
    }

    /// Monomials of `xi / length` with their derivatives with respect to `xi`.
    pub(super) fn at(&self, xi: &SVector<f64, D>, length: f64) -> BasisValue<D, B> {
        let unit = xi / length;
        let derived = |by: [u8; D], scale: f64| {
            SVector::from_fn(|b, _| scale * derivative(&self.exponents[b], &by, &unit))
        };
        let axis = |j: usize| array_of(|i| u8::from(i == j));
        let both = |j: usize, t: usize| array_of(|i| u8::from(i == j) + u8::from(i == t));
        BasisValue {
            value: derived([0; D], 1.0),
            gradient: array_of(|j| derived(axis(j), 1.0 / length)),
            hessian: array_of(|j| array_of(|t| derived(both(j, t), 1.0 / (length * length)))),
        }
    }
}

/// Exponents of all monomials of one degree, with decreasing powers of the first component.
fn of_degree<const D: usize>(degree: u8) -> Vec<[u8; D]> {
    let mut found = Vec::new();
    let count = (usize::from(degree) + 1).pow(D as u32);
    for n in (0..count).rev() {
        let mut rest = n;
        let mut exponents = [0; D];
        for exponent in exponents.iter_mut().rev() {
            // The remainder is at most the degree, which is small.
            *exponent = (rest % (usize::from(degree) + 1)) as u8;
            rest /= usize::from(degree) + 1;
        }
        if exponents.iter().sum::<u8>() == degree {
            found.push(exponents);
        }
    }
    found
}

/// Derivative of a monomial, `by_i` times along each axis.
fn derivative<const D: usize>(exponents: &[u8; D], by: &[u8; D], x: &SVector<f64, D>) -> f64 {
    let factor = |i: usize| {
        if by[i] > exponents[i] {
            return 0.0;
        }
        let left = exponents[i] - by[i];
        let falling: f64 = (left + 1..=exponents[i]).map(f64::from).product();
        falling * x[i].powi(i32::from(left))
    };
    (0..D).map(factor).product()
}

/// Contribution of one neighbor to the moments `W p (x) p = p (x) a`: the basis `p` and `a = p W`, differentiated with respect to `xi`.
pub(super) struct Term<const D: usize, const B: usize> {
    pub(super) p: SVector<f64, B>,
    pub(super) p1: [SVector<f64, B>; D],
    pub(super) p2: [[SVector<f64, B>; D]; D],
    pub(super) a: SVector<f64, B>,
    pub(super) a1: [SVector<f64, B>; D],
    pub(super) a2: [[SVector<f64, B>; D]; D],
}

impl<const D: usize, const B: usize> Term<D, B> {
    pub(super) fn new(basis: BasisValue<D, B>, w: &Weight<D>) -> Self {
        let BasisValue {
            value: p,
            gradient: p1,
            hessian: p2,
        } = basis;
        Self {
            a: p * w.value,
            a1: array_of(|j| p1[j] * w.value + p * w.gradient[j]),
            a2: array_of(|j| {
                array_of(|t| {
                    p2[j][t] * w.value
                        + p1[j] * w.gradient[t]
                        + p1[t] * w.gradient[j]
                        + p * w.hessian[(j, t)]
                })
            }),
            p,
            p1,
            p2,
        }
    }

    /// Derivative of the moment, `(p (x) a)_,j v`.
    pub(super) fn moment1_times(&self, j: usize, v: &SVector<f64, B>) -> SVector<f64, B> {
        self.p1[j] * self.a.dot(v) + self.p * self.a1[j].dot(v)
    }

    /// Second derivative of the moment, `(p (x) a)_,jt v`.
    pub(super) fn moment2_times(&self, j: usize, t: usize, v: &SVector<f64, B>) -> SVector<f64, B> {
        self.p2[j][t] * self.a.dot(v)
            + self.p1[j] * self.a1[t].dot(v)
            + self.p1[t] * self.a1[j].dot(v)
            + self.p * self.a2[j][t].dot(v)
    }
}
