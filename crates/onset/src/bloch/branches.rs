//! Branches of the spectrum with their derivatives with respect to the wave vector, in closed form.
//!
//! In the plane `omega^2 = h -+ sqrt(p)`, `h = tr D / 2`, `p = ((D_11 - D_22) / 2)^2 + D_12 D_21`. Here `h` and `p` are as smooth as `D`; only the
//! square root is not smooth.

use super::dynamical_matrix::Expansion;
use crate::algebra::{Complex, Each, array_of};
use nalgebra::{SMatrix, SVector};
use std::ops::{Add, Div, Mul, Sub};

/// Relative tolerance of a double eigenvalue: product of its distances from the two others, divided by the square of the largest entry.
const DOUBLE_EIGENVALUE_TOLERANCE: f64 = 1e-9;

/// Real or complex numbers.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Mul<f64, Output = Self>
{
    /// Absolute value of the number.
    fn magnitude(self) -> f64;
}

impl Number for f64 {
    fn magnitude(self) -> f64 {
        self.abs()
    }
}

impl Number for Complex {
    fn magnitude(self) -> f64 {
        self.norm()
    }
}

/// A function of the wave vector with its first and second derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Taylor<T, const D: usize> {
    pub(super) value: T,
    pub(super) gradient: [T; D],
    pub(super) hessian: [[T; D]; D],
}

impl<T: Copy, const D: usize> Taylor<T, D> {
    /// Applies a linear map to the value and the derivatives.
    #[inline]
    pub(super) fn map<U>(&self, map: impl Fn(T) -> U) -> Taylor<U, D> {
        Taylor {
            value: map(self.value),
            gradient: std::array::from_fn(|a| map(self.gradient[a])),
            hessian: std::array::from_fn(|a| std::array::from_fn(|b| map(self.hessian[a][b]))),
        }
    }

    // Loops instead of closures over arrays, here and below: this is the innermost work of all descents.
    #[inline]
    fn zip(&self, other: &Self, sum: impl Fn(T, T) -> T) -> Self {
        let mut both = *self;
        both.value = sum(self.value, other.value);
        for a in 0..D {
            both.gradient[a] = sum(self.gradient[a], other.gradient[a]);
            for b in 0..D {
                both.hessian[a][b] = sum(self.hessian[a][b], other.hessian[a][b]);
            }
        }
        both
    }
}

impl<T: Number, const D: usize> Taylor<T, D> {
    #[inline]
    fn times(&self, other: &Self) -> Self {
        let (x, y) = (self, other);
        let mut product = *x;
        product.value = x.value * y.value;
        for a in 0..D {
            product.gradient[a] = x.gradient[a] * y.value + x.value * y.gradient[a];
            for b in 0..D {
                product.hessian[a][b] = x.hessian[a][b] * y.value
                    + x.gradient[a] * y.gradient[b]
                    + x.gradient[b] * y.gradient[a]
                    + x.value * y.hessian[a][b];
            }
        }
        product
    }

    /// Composition with a function, given its value and its first two derivatives.
    #[inline]
    fn chain(&self, value: T, first: T, second: T) -> Self {
        let mut composed = *self;
        composed.value = value;
        for a in 0..D {
            composed.gradient[a] = self.gradient[a] * first;
            for b in 0..D {
                composed.hessian[a][b] =
                    self.hessian[a][b] * first + self.gradient[a] * self.gradient[b] * second;
            }
        }
        composed
    }
}

impl<const D: usize> Taylor<Complex, D> {
    /// Real part of the squared half difference of two branches: negative for a complex pair, and smooth where real branches cross.
    pub(super) fn squared_half_difference(&self, other: &Self) -> Taylor<f64, D> {
        let half = self.zip(other, |x, y| (x - y) * 0.5);
        half.times(&half).map(|square| square.re)
    }

    /// Square root with a positive real part. The derivatives are not finite where it vanishes.
    fn root(&self) -> Self {
        let root = self.value.sqrt();
        let first = 0.5 / root;
        self.chain(root, first, -0.5 * first / self.value)
    }
}

impl<const D: usize> Taylor<f64, D> {
    /// Quotient with another function.
    #[inline]
    pub(super) fn over(&self, scale: &Self) -> Self {
        let inverse = 1.0 / scale.value;
        let value = self.value * inverse;
        let mut quotient = *self;
        quotient.value = value;
        for a in 0..D {
            quotient.gradient[a] = (self.gradient[a] - value * scale.gradient[a]) * inverse;
        }
        let gradient = quotient.gradient;
        for a in 0..D {
            for b in 0..D {
                quotient.hessian[a][b] = (self.hessian[a][b]
                    - gradient[a] * scale.gradient[b]
                    - gradient[b] * scale.gradient[a]
                    - value * scale.hessian[a][b])
                    * inverse;
            }
        }
        quotient
    }

    /// Gradient as a vector.
    #[inline]
    pub(super) fn slope(&self) -> SVector<f64, D> {
        SVector::from(self.gradient)
    }

    /// Second derivatives as a matrix.
    #[inline]
    pub(super) fn curvature(&self) -> SMatrix<f64, D, D> {
        SMatrix::from_fn(|a, b| self.hessian[a][b])
    }
}

impl<T: Number + nalgebra::Scalar, const D: usize> Expansion<T, D> {
    #[inline]
    fn entry(&self, i: usize, j: usize) -> Taylor<T, D> {
        Taylor {
            value: self.value[(i, j)],
            gradient: array_of(|a| self.gradient[a][(i, j)]),
            hessian: array_of(|a| array_of(|b| self.hessian[a][b][(i, j)])),
        }
    }

    /// Branch through a simple eigenvalue `lambda` in three dimensions.
    ///
    /// It is the root near zero of `e^3 - t e^2 + m e - d`, with the invariants `t`, `m`, `d` of `D(k) - lambda`. Not finite if the eigenvalue is
    /// double.
    pub(super) fn branch_through(&self, eigenvalue: T) -> Taylor<T, D> {
        let entry = |i: usize, j: usize| {
            let mut entry = self.entry(i, j);
            if i == j {
                entry.value = entry.value - eigenvalue;
            }
            entry
        };
        let m: [[Taylor<T, D>; 3]; 3] = array_of(|i| array_of(|j| entry(i, j)));
        let sum = |x: &Taylor<T, D>, y: &Taylor<T, D>| x.zip(y, |x, y| x + y);
        let minor = |i: usize, j: usize, k: usize, l: usize| {
            m[i][k]
                .times(&m[j][l])
                .zip(&m[i][l].times(&m[j][k]), |x, y| x - y)
        };
        let trace = m[0][0].value + m[1][1].value + m[2][2].value;
        let lower = minor(1, 2, 1, 2);
        let minors = sum(&sum(&minor(0, 1, 0, 1), &minor(0, 2, 0, 2)), &lower);
        let determinant = sum(
            &m[0][0].times(&lower),
            &m[0][2]
                .times(&minor(1, 2, 0, 1))
                .zip(&m[0][1].times(&minor(1, 2, 0, 2)), |x, y| x - y),
        );
        let largest = m
            .as_flattened()
            .iter()
            .map(|x| x.value.magnitude())
            .fold(0.0, f64::max);
        // Product of the distances to the other two eigenvalues.
        let mut product = minors.value;
        if product.magnitude() <= DOUBLE_EIGENVALUE_TOLERANCE * largest * largest {
            product = product * 0.0;
        }
        let slope = determinant.gradient.each(|x| x / product);
        Taylor {
            value: eigenvalue,
            gradient: slope,
            hessian: array_of(|a| {
                array_of(|b| {
                    let turning = minors.gradient[a] * slope[b] + minors.gradient[b] * slope[a];
                    (determinant.hessian[a][b] - turning + trace * slope[a] * slope[b] * 2.0)
                        / product
                })
            }),
        }
    }

    /// Half of the trace, in the plane.
    fn half_trace(&self) -> Taylor<T, D> {
        self.entry(0, 0)
            .zip(&self.entry(1, 1), |x, y| (x + y) * 0.5)
    }

    /// Discriminant `p` in the plane. For a real `D`, its sign distinguishes real from complex branches.
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

    /// Growth rate `Im omega` of the fastest growing branch, in one or two dimensions.
    pub(super) fn growth(&self) -> Taylor<f64, D> {
        if D == 1 {
            return self.entry(0, 0).growth();
        }
        let root = self.discriminant().root();
        let [low, high] = [-1.0, 1.0].each(|sign| {
            let branch = self.half_trace().zip(&root, |x, y| x + y * sign);
            branch.growth()
        });
        if low.value > high.value { low } else { high }
    }
}

impl<const D: usize> Taylor<Complex, D> {
    /// Growth rate `Im omega` of the growing root of `omega^2`.
    pub(super) fn growth(&self) -> Taylor<f64, D> {
        let frequency = self.root();
        let sign = frequency.value.im.signum();
        frequency.map(|x| sign * x.im)
    }
}

impl<const D: usize> Expansion<f64, D> {
    /// Discriminant `a^3 - h^2` in three dimensions, negative if two eigenvalues are complex, as in [`super::spatial`].
    pub(super) fn spatial_discriminant(&self) -> Taylor<f64, D> {
        let third = |x: f64, y: f64| x + y / 3.0;
        let zero = self.entry(0, 0).map(|_| 0.0);
        let mean = (0..3).fold(zero, |sum, i| sum.zip(&self.entry(i, i), third));
        let k: [[Taylor<f64, D>; 3]; 3] = array_of(|i| {
            array_of(|j| {
                let entry = self.entry(i, j);
                if i == j {
                    entry.zip(&mean, |x, y| x - y)
                } else {
                    entry
                }
            })
        });
        let minor = |i: usize, j: usize| {
            let (m, n) = ((i + 1) % 3, (i + 2) % 3);
            let (p, q) = ((j + 1) % 3, (j + 2) % 3);
            k[m][p]
                .times(&k[n][q])
                .zip(&k[m][q].times(&k[n][p]), |x, y| x - y)
        };
        // `tr K^2` is -2 times the sum of the principal minors.
        let a = (0..3)
            .fold(zero, |sum, i| sum.zip(&minor(i, i), third))
            .map(|x| -x);
        let h = (0..3).fold(zero, |sum, j| {
            sum.zip(&k[0][j].times(&minor(0, j)), |x, y| x + 0.5 * y)
        });
        a.times(&a).times(&a).zip(&h.times(&h), |x, y| x - y)
    }

    /// Converts the matrix to complex numbers.
    pub(super) fn complex(&self) -> Expansion<Complex, D> {
        let complex = |m: &SMatrix<f64, D, D>| m.map(|x| Complex::new(x, 0.0));
        Expansion {
            value: complex(&self.value),
            gradient: self.gradient.each_ref().map(complex),
            hessian: self
                .hessian
                .each_ref()
                .each(|row| row.each_ref().map(complex)),
        }
    }

    /// `Re omega^2` of the lowest (`sign` -1) or the highest branch (+1), in one or two dimensions. For a complex pair this is half of the trace.
    pub(super) fn branch(&self, sign: f64) -> Taylor<f64, D> {
        if D == 1 {
            return self.entry(0, 0);
        }
        let (mean, p) = (self.half_trace(), self.discriminant());
        if p.value < 0.0 {
            return mean;
        }
        let root = p.value.sqrt();
        let first = 0.5 / root;
        let root = p.chain(root, first, -0.5 * first / p.value);
        mean.zip(&root, |x, y| x + sign * y)
    }
}
