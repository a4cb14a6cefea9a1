//! Stiffness with major symmetry as a quadratic form of displacement gradients.

use super::Axes;
use crate::algebra::array_of;
use crate::real::Real;

/// Pairs `i < k` of rows or `J < L` of columns of a minor.
const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

/// Number of minors `H_iJ H_kL - H_iL H_kJ`.
pub(crate) const MINORS: usize = 9;

/// Minor `H_iJ H_kL - H_iL H_kJ`, given by the positions of its four components, `(i J, k L)` and `(i L, k J)`.
pub(crate) fn minor(m: usize) -> [(usize, usize); 2] {
    let ((i, k), (j, l)) = (PAIRS[m / 3], PAIRS[m % 3]);
    [(3 * i + j, 3 * k + l), (3 * i + l, 3 * k + j)]
}

/// Quadratic form `H . T H` of displacement gradients `H`, whose components `H_iJ` are numbered `3 i + J`. Its values at `H = g (x) N` are
/// `g . Q(N) g`.
#[derive(Clone, Debug)]
pub(crate) struct Form<R>([[R; 9]; 9]);

impl<R: Real> Form<R> {
    /// Creates the form from its components `component(i, J, k, L)`, evaluated for `3 i + J <= 3 k + L` only.
    pub(crate) fn from_fn(component: impl Fn(usize, usize, usize, usize) -> R) -> Self {
        Self(array_of(|p| {
            array_of(|q| {
                let (p, q) = (p.min(q), p.max(q));
                component(p / 3, p % 3, q / 3, q % 3)
            })
        }))
    }

    /// Converts the components to another number type.
    pub(crate) fn map<S>(&self, number: impl Fn(R) -> S) -> Form<S> {
        Form(self.0.map(|row| row.map(&number)))
    }

    /// Component at two index positions.
    pub(crate) fn at(&self, p: usize, q: usize) -> R {
        self.0[p][q]
    }

    /// All components of the form.
    pub(crate) fn components(&self) -> impl Iterator<Item = R> {
        self.0.as_flattened().iter().copied()
    }

    /// Matrix `Q(a, b)_ik = T_iJkL (a_J b_L + b_J a_L) / 2`; `Q(N, N)` is the acoustic tensor.
    pub(crate) fn acoustic(&self, a: &Axes<R>, b: &Axes<R>) -> [[R; 3]; 3] {
        let weight: Axes<Axes<R>> = array_of(|j| array_of(|l| (a[j] * b[l] + b[j] * a[l]) * 0.5));
        let mut q = [[R::constant(0.0); 3]; 3];
        for i in 0..3 {
            for k in 0..=i {
                let mut sum = self.0[3 * i][3 * k] * weight[0][0];
                for place in 1..9 {
                    let (j, l) = (place / 3, place % 3);
                    sum = sum + self.0[3 * i + j][3 * k + l] * weight[j][l];
                }
                q[i][k] = sum;
                q[k][i] = sum;
            }
        }
        q
    }

    /// Components of the form `H . T H - level |H|^2 + sum_m factors_m minor_m(H)`.
    pub(crate) fn lowered(&self, level: f64, factors: &[f64; MINORS]) -> [[R; 9]; 9] {
        let mut shifted = self.0;
        for (p, row) in shifted.iter_mut().enumerate() {
            row[p] = row[p] - level;
        }
        for (m, factor) in factors.iter().enumerate() {
            // A product of two different components has two positions in the matrix.
            for ((p, q), sign) in minor(m).into_iter().zip([0.5, -0.5]) {
                shifted[p][q] = shifted[p][q] + sign * factor;
                shifted[q][p] = shifted[q][p] + sign * factor;
            }
        }
        shifted
    }

    /// Returns true if the coordinate planes are mirror planes.
    ///
    /// No component has an index that occurs an odd number of times, so changing the sign of a component of the direction does not change the
    /// eigenvalues.
    pub(crate) fn is_orthotropic(&self) -> bool {
        let counts = |p: usize, q: usize| [p / 3, p % 3, q / 3, q % 3];
        (0..81).all(|n| {
            let (p, q) = (n / 9, n % 9);
            let is_even = |axis: usize| {
                let count = counts(p, q)
                    .into_iter()
                    .filter(|index| *index == axis)
                    .count();
                count.is_multiple_of(2)
            };
            (0..3).all(is_even) || is_zero(self.0[p][q])
        })
    }
}

fn is_zero<R: Real>(x: R) -> bool {
    // An interval is zero only if it contains nothing else.
    x.side(0.0).is_some() && (-x).side(0.0).is_some() && x.value() == 0.0
}
