//! Branches of the spectrum with their derivatives by the wave vector, in closed form.
//!
//! In the plane `omega^2 = h -+ sqrt(p)`, `h = tr D / 2`, `p = ((D_11 - D_22) / 2)^2 + D_12 D_21`, where `h` and `p` are
//! as smooth as `D`; what is not smooth is the root alone.

use super::dynamical_matrix::Expansion;
use crate::algebra::Complex;
use nalgebra::{SMatrix, SVector};
use std::ops::{Add, Mul, Sub};

/// Real and complex numbers.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Mul<f64, Output = Self>
{
}

impl Number for f64 {}
impl Number for Complex {}

/// A function of the wave vector with its first and second derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Taylor<T, const D: usize> {
    pub(super) value: T,
    pub(super) gradient: [T; D],
    pub(super) hessian: [[T; D]; D],
}

impl<T: Copy, const D: usize> Taylor<T, D> {
    /// Applies a linear map to value and derivatives.
    pub(super) fn map<U>(&self, map: impl Fn(T) -> U) -> Taylor<U, D> {
        Taylor {
            value: map(self.value),
            gradient: std::array::from_fn(|a| map(self.gradient[a])),
            hessian: std::array::from_fn(|a| std::array::from_fn(|b| map(self.hessian[a][b]))),
        }
    }

    fn zip(&self, other: &Self, sum: impl Fn(T, T) -> T) -> Self {
        Self {
            value: sum(self.value, other.value),
            gradient: std::array::from_fn(|a| sum(self.gradient[a], other.gradient[a])),
            hessian: std::array::from_fn(|a| {
                std::array::from_fn(|b| sum(self.hessian[a][b], other.hessian[a][b]))
            }),
        }
    }
}

impl<T: Number, const D: usize> Taylor<T, D> {
    fn times(&self, other: &Self) -> Self {
        let (x, y) = (self, other);
        Self {
            value: x.value * y.value,
            gradient: std::array::from_fn(|a| x.gradient[a] * y.value + x.value * y.gradient[a]),
            hessian: std::array::from_fn(|a| {
                std::array::from_fn(|b| {
                    x.hessian[a][b] * y.value
                        + x.gradient[a] * y.gradient[b]
                        + x.gradient[b] * y.gradient[a]
                        + x.value * y.hessian[a][b]
                })
            }),
        }
    }

    /// The composition with a function of which the value and two derivatives are given.
    fn chain(&self, value: T, first: T, second: T) -> Self {
        Self {
            value,
            gradient: self.gradient.map(|slope| slope * first),
            hessian: std::array::from_fn(|a| {
                std::array::from_fn(|b| {
                    self.hessian[a][b] * first + self.gradient[a] * self.gradient[b] * second
                })
            }),
        }
    }
}

impl<const D: usize> Taylor<Complex, D> {
    /// The root with a positive real part; derivatives that are not finite where it vanishes.
    fn root(&self) -> Self {
        let root = self.value.sqrt();
        let first = 0.5 / root;
        self.chain(root, first, -0.5 * first / self.value)
    }
}

impl<const D: usize> Taylor<f64, D> {
    /// The quotient with another function.
    pub(super) fn over(&self, scale: &Self) -> Self {
        let value = self.value / scale.value;
        let gradient: [f64; D] =
            std::array::from_fn(|a| (self.gradient[a] - value * scale.gradient[a]) / scale.value);
        Self {
            value,
            gradient,
            hessian: std::array::from_fn(|a| {
                std::array::from_fn(|b| {
                    (self.hessian[a][b]
                        - gradient[a] * scale.gradient[b]
                        - gradient[b] * scale.gradient[a]
                        - value * scale.hessian[a][b])
                        / scale.value
                })
            }),
        }
    }

    /// The gradient as a vector.
    pub(super) fn slope(&self) -> SVector<f64, D> {
        SVector::from(self.gradient)
    }

    /// The second derivatives as a matrix.
    pub(super) fn curvature(&self) -> SMatrix<f64, D, D> {
        SMatrix::from_fn(|a, b| self.hessian[a][b])
    }
}

impl<T: Number + nalgebra::Scalar, const D: usize> Expansion<T, D> {
    fn entry(&self, i: usize, j: usize) -> Taylor<T, D> {
        Taylor {
            value: self.value[(i, j)],
            gradient: std::array::from_fn(|a| self.gradient[a][(i, j)]),
            hessian: std::array::from_fn(|a| std::array::from_fn(|b| self.hessian[a][b][(i, j)])),
        }
    }

    /// Half of the trace. Planar only.
    fn half_trace(&self) -> Taylor<T, D> {
        self.entry(0, 0)
            .zip(&self.entry(1, 1), |x, y| (x + y) * 0.5)
    }

    /// `p`, whose real part tells real branches from complex ones where `D` is real. Planar only.
    pub(super) fn discriminant(&self) -> Taylor<T, D> {
        let half = self
            .entry(0, 0)
            .zip(&self.entry(1, 1), |x, y| (x - y) * 0.5);
        let mixed = self.entry(0, 1).times(&self.entry(1, 0));
        half.times(&half).zip(&mixed, |x, y| x + y)
    }
}

impl<const D: usize> Expansion<Complex, D> {
    /// `Re omega^2` of the lowest (`sign` -1) or the highest branch (+1), in one or two dimensions.
    pub(super) fn branch(&self, sign: f64) -> Taylor<f64, D> {
        if D == 1 {
            return self.entry(0, 0).map(|x| x.re);
        }
        let root = self.discriminant().root();
        self.half_trace()
            .zip(&root, |x, y| x + y * sign)
            .map(|x| x.re)
    }

    /// The growth rate `Im omega` of the growing root of a complex branch. Planar only.
    pub(super) fn growth(&self) -> Taylor<f64, D> {
        let root = self.discriminant().root();
        let frequency = self.half_trace().zip(&root, |x, y| x + y).root();
        let sign = frequency.value.im.signum();
        frequency.map(|x| sign * x.im)
    }
}

impl<const D: usize> Expansion<f64, D> {
    /// Minus the square of the growth rate of a complex pair, `(h - sqrt(det D)) / 2`; as smooth where branches are real, and
    /// positive there. Planar only.
    pub(super) fn negative_square_of_growth(&self) -> Taylor<f64, D> {
        let product = self.entry(0, 0).times(&self.entry(1, 1));
        let mixed = self.entry(0, 1).times(&self.entry(1, 0));
        let determinant = product.zip(&mixed, |x, y| x - y);
        let root = determinant.value.sqrt();
        let first = 0.5 / root;
        let root = determinant.chain(root, first, -0.5 * first / determinant.value);
        self.half_trace().zip(&root, |x, y| 0.5 * (x - y))
    }

    /// The same as for complex matrices.
    pub(super) fn branch(&self, sign: f64) -> Taylor<f64, D> {
        if D == 1 {
            return self.entry(0, 0);
        }
        let p = self.discriminant();
        if p.value < 0.0 {
            // A complex pair: the real part is half of the trace.
            return self.half_trace();
        }
        let root = p.value.sqrt();
        let first = 0.5 / root;
        let root = p.chain(root, first, -0.5 * first / p.value);
        self.half_trace().zip(&root, |x, y| x + sign * y)
    }
}
