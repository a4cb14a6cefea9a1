//! The dynamical matrix of several particles with its derivatives with respect to the wave vector, and the Taylor expansions of its branches.

use super::{Mass, WaveSystem};
use crate::algebra::{Complex, Decomposition, array_of};
use crate::bloch::Expansion;
use crate::bloch::branches::Taylor;
use nalgebra::{DMatrix, SVector};

/// A matrix with its first and second derivatives with respect to the components of the wave vector.
#[derive(Clone, Debug)]
pub(in crate::bloch) struct MatrixExpansion<const D: usize> {
    pub(in crate::bloch) value: DMatrix<Complex>,
    pub(super) gradient: [DMatrix<Complex>; D],
    pub(super) hessian: [[DMatrix<Complex>; D]; D],
}

impl<T: Copy + Into<Complex>, const D: usize> From<Expansion<T, D>> for MatrixExpansion<D> {
    fn from(of: Expansion<T, D>) -> Self {
        Self::from_parts(|indices| {
            let part = match *indices {
                [] => &of.value,
                [a] => &of.gradient[a],
                [a, b, ..] => &of.hessian[a][b],
            };
            DMatrix::from_fn(D, D, |i, j| part[(i, j)].into())
        })
    }
}

impl<const D: usize> MatrixExpansion<D> {
    /// Builds the expansion from a function of the derivative indices: `[]` is the value, `[a]` a first and `[a, b]` a second derivative.
    pub(super) fn from_parts(mut part: impl FnMut(&[usize]) -> DMatrix<Complex>) -> Self {
        let mut hessian: [[DMatrix<Complex>; D]; D] =
            std::array::from_fn(|_| std::array::from_fn(|_| DMatrix::zeros(0, 0)));
        for a in 0..D {
            for b in 0..=a {
                hessian[a][b] = part(&[a, b]);
                hessian[b][a] = hessian[a][b].clone();
            }
        }
        Self {
            value: part(&[]),
            gradient: std::array::from_fn(|a| part(&[a])),
            hessian,
        }
    }

    /// Product of two expansions by Leibniz' rule.
    pub(super) fn times(&self, other: &Self) -> Self {
        let (x, y) = (self, other);
        Self::from_parts(|indices| match *indices {
            [] => &x.value * &y.value,
            [a] => &x.gradient[a] * &y.value + &x.value * &y.gradient[a],
            [a, b, ..] => {
                &x.hessian[a][b] * &y.value
                    + &x.gradient[a] * &y.gradient[b]
                    + &x.gradient[b] * &y.gradient[a]
                    + &x.value * &y.hessian[a][b]
            }
        })
    }
}

impl<const D: usize> WaveSystem<D> {
    /// Eigenvalues and eigenvectors of the value of [`Self::expansion_at`].
    pub(super) fn decomposed(&self, expansion: &MatrixExpansion<D>) -> Option<Decomposition> {
        let matrix = expansion.value.clone();
        match (&self.mass, self.is_hermitian) {
            (Mass::Lumped(_), true) => Decomposition::of_hermitian(matrix),
            _ => Decomposition::new(matrix),
        }
    }

    /// Computes a matrix with the eigenvalues of `D(k)`, and its derivatives. It is Hermitian if the system is Hermitian and masses are lumped;
    /// otherwise it is `D(k)` itself.
    pub(super) fn expansion_at(&self, k: &SVector<f64, D>) -> MatrixExpansion<D> {
        let stiffness = self.stiffness.expansion_at(k);
        let moved = match &self.drift {
            Some(drift) => stiffness.times(&drift.expansion_at(k)),
            None => stiffness,
        };
        match &self.mass {
            Mass::Lumped(masses) => {
                let of_row = |i: usize, j: usize| {
                    let (own, other) = (masses[i / D], masses[j / D]);
                    let mass = if self.is_hermitian {
                        (own * other).sqrt()
                    } else {
                        own
                    };
                    Complex::new(mass.recip(), 0.0)
                };
                let size = self.size();
                let divisors = DMatrix::from_fn(size, size, of_row);
                MatrixExpansion::from_parts(|indices| moved.part(indices).component_mul(&divisors))
            }
            Mass::Consistent(mass) => {
                // The equation `M D = N` is differentiated.
                let mass = mass.expansion_at(k);
                let divided = |matrix: DMatrix<Complex>| self.divided_by_mass(k, matrix);
                let value = divided(moved.value);
                let gradient: [DMatrix<Complex>; D] = std::array::from_fn(|a| {
                    divided(&moved.gradient[a] - &mass.gradient[a] * &value)
                });
                MatrixExpansion::from_parts(|indices| match *indices {
                    [] => value.clone(),
                    [a] => gradient[a].clone(),
                    [a, b, ..] => divided(
                        &moved.hessian[a][b]
                            - &mass.hessian[a][b] * &value
                            - &mass.gradient[a] * &gradient[b]
                            - &mass.gradient[b] * &gradient[a],
                    ),
                })
            }
        }
    }
}

impl<const D: usize> MatrixExpansion<D> {
    fn part(&self, indices: &[usize]) -> &DMatrix<Complex> {
        match *indices {
            [] => &self.value,
            [a] => &self.gradient[a],
            [a, b, ..] => &self.hessian[a][b],
        }
    }

    /// First derivative along a vector.
    pub(in crate::bloch) fn slope(&self, along: &SVector<f64, D>) -> DMatrix<Complex> {
        let zeros = DMatrix::zeros(self.value.nrows(), self.value.ncols());
        (0..D).fold(zeros, |sum, a| {
            sum + &self.gradient[a] * Complex::from(along[a])
        })
    }

    /// Second derivative along a vector.
    pub(in crate::bloch) fn curvature(&self, along: &SVector<f64, D>) -> DMatrix<Complex> {
        let mut sum = DMatrix::zeros(self.value.nrows(), self.value.ncols());
        for a in 0..D {
            for b in 0..D {
                sum += &self.hessian[a][b] * Complex::from(along[a] * along[b]);
            }
        }
        sum
    }

    /// Taylor expansion of the branch through an eigenvalue, by second-order perturbation theory.
    ///
    /// `lambda_,a = w D_,a v`, `lambda_,ab = w D_,ab v + sum_m (w D_,a v_m w_m D_,b v + w D_,b v_m w_m D_,a v) / (lambda - lambda_m)`.
    ///
    /// Not finite, or very large, where branches meet.
    pub(in crate::bloch) fn branch(&self, of: &Decomposition, number: usize) -> Taylor<Complex, D> {
        let value = of.values[number];
        let (row, column) = (of.left.row(number), of.right.column(number));
        let to: [_; D] = std::array::from_fn(|a| row * &self.gradient[a] * &of.right);
        let from: [_; D] = std::array::from_fn(|a| &of.left * (&self.gradient[a] * column));
        let curvature = |a: usize, b: usize| {
            let own = (row * (&self.hessian[a][b] * column))[(0, 0)];
            let others = (0..of.values.len())
                .filter(|m| *m != number)
                .map(|m| (to[a][m] * from[b][m] + to[b][m] * from[a][m]) / (value - of.values[m]));
            own + others.sum::<Complex>()
        };
        Taylor {
            value,
            gradient: array_of(|a| to[a][number]),
            hessian: array_of(|a| array_of(|b| curvature(a, b))),
        }
    }
}
