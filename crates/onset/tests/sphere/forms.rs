//! Stiffnesses for the tests.

pub use crate::random::Random;
use nalgebra::{Matrix3, Vector3};
use onset::kinematics::DeformationGradient;
use onset::material::{FourthOrder, StrainEnergy};
use onset::real::Real;

impl Random {
    /// Random stiffness with major symmetry and components up to one.
    pub fn symmetric(&mut self) -> FourthOrder {
        let mut half = [[0.0; 9]; 9];
        for p in 0..9 {
            for q in 0..=p {
                half[p][q] = self.number();
                half[q][p] = half[p][q];
            }
        }
        FourthOrder::from_fn(|i, j, k, l| half[3 * i + j][3 * k + l])
    }

    /// Random stiffness without any symmetry.
    pub fn asymmetric(&mut self) -> FourthOrder {
        let components: [f64; 81] = std::array::from_fn(|_| self.number());
        FourthOrder::from_fn(|i, j, k, l| components[27 * i + 9 * j + 3 * k + l])
    }
}

pub fn delta(i: usize, j: usize) -> f64 {
    f64::from(u8::from(i == j))
}

/// Tensor with respect to rotated axes.
pub fn turned(t: &FourthOrder, r: &Matrix3<f64>) -> FourthOrder {
    let one = |t: &dyn Fn([usize; 4]) -> f64, place: usize, index: [usize; 4]| {
        let at = |a: usize| {
            let mut other = index;
            other[place] = a;
            r[(index[place], a)] * t(other)
        };
        (0..3).map(at).sum::<f64>()
    };
    let mut current = t.clone();
    for place in 0..4 {
        let before = current.clone();
        let component = |[i, j, k, l]: [usize; 4]| before[(i, j, k, l)];
        current = FourthOrder::from_fn(|i, j, k, l| one(&component, place, [i, j, k, l]));
    }
    current
}

/// Stiffness from the coefficients of products `H_p H_q` of a quadratic form, with `H_iJ` numbered `11, 12, 13, 21, ...`.
pub fn quadratic(terms: &[(usize, usize, f64)]) -> FourthOrder {
    let mut matrix = [[0.0; 9]; 9];
    let place = |name: usize| 3 * (name / 10 - 1) + name % 10 - 1;
    for &(a, b, coefficient) in terms {
        matrix[place(a)][place(b)] += 0.5 * coefficient;
        matrix[place(b)][place(a)] += 0.5 * coefficient;
    }
    FourthOrder::from_fn(|i, j, k, l| matrix[3 * i + j][3 * k + l])
}

/// Choi's form (1975): nonnegative for all `g (x) N`, but not a sum of squares with any added minors.
pub fn choi() -> FourthOrder {
    quadratic(&[
        (11, 11, 1.0),
        (22, 22, 1.0),
        (33, 33, 1.0),
        (11, 22, -2.0),
        (22, 33, -2.0),
        (33, 11, -2.0),
        (12, 12, 2.0),
        (23, 23, 2.0),
        (31, 31, 2.0),
    ])
}

/// Isotropic linear elasticity.
pub fn isotropic(lambda: f64, mu: f64) -> FourthOrder {
    FourthOrder::from_fn(|i, j, k, l| {
        lambda * delta(i, j) * delta(k, l)
            + mu * (delta(i, k) * delta(j, l) + delta(i, l) * delta(j, k))
    })
}

/// Adds a multiple of the tensor whose acoustic tensors are unit matrices.
pub fn raised(t: &FourthOrder, level: f64) -> FourthOrder {
    FourthOrder::from_fn(|i, j, k, l| t[(i, j, k, l)] + level * delta(i, k) * delta(j, l))
}

pub fn scale(t: &FourthOrder) -> f64 {
    (0..81)
        .map(|n| t[(n / 27, n / 9 % 3, n / 3 % 3, n % 3)].abs())
        .fold(0.0, f64::max)
}

pub fn acoustic(t: &FourthOrder, n: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::from_fn(|i, k| {
        (0..9)
            .map(|m| t[(i, m / 3, k, m % 3)] * n[m / 3] * n[m % 3])
            .sum()
    })
}

/// Energy `W = H . T H / 2` of the displacement gradient `H = F - 1`, with tangent `T` at every state.
pub struct Quadratic(pub FourthOrder);

impl StrainEnergy for Quadratic {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let h = |p: usize| f.components()[p / 3][p % 3] - delta(p / 3, p % 3);
        let mut sum = R::constant(0.0);
        for p in 0..9 {
            for q in 0..9 {
                sum = sum + h(p) * h(q) * (0.5 * self.0[(p / 3, p % 3, q / 3, q % 3)]);
            }
        }
        sum
    }
}
