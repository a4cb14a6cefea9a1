//! Laws under test with their closed forms. Every listed law must pass the tests.

pub use crate::random::Random;
use nalgebra::Matrix3;
use onset::kinematics::DeformationGradient;
use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin, StrainEnergy};

/// Components of a fourth-order tensor by index.
pub type Components = Box<dyn Fn(usize, usize, usize, usize) -> f64>;

/// Stress and elasticity tensor as functions of `C`.
type Stress = fn(&Matrix3<f64>) -> Matrix3<f64>;
type Elasticity = fn(&Matrix3<f64>) -> Components;

pub struct Entry {
    pub name: &'static str,
    pub law: Box<dyn Hyperelastic>,
    /// Energy `W(F)` in plain floating point.
    pub energy: Box<dyn Fn(&DeformationGradient) -> f64>,
    /// Stress `S(C)`, derived by hand.
    pub second_piola: Stress,
    /// Tensor `C^SE(C) = 2 dS/dC`, derived by hand.
    pub second_elasticity: Elasticity,
    pub shear_modulus: f64,
    pub bulk_modulus: f64,
}

fn entry<Law: StrainEnergy + Hyperelastic + Copy + 'static>(
    name: &'static str,
    law: Law,
    (second_piola, second_elasticity): (Stress, Elasticity),
    (shear_modulus, bulk_modulus): (f64, f64),
) -> Entry {
    Entry {
        name,
        law: Box::new(law),
        energy: Box::new(move |f| law.energy(f)),
        second_piola,
        second_elasticity,
        shear_modulus,
        bulk_modulus,
    }
}

pub const C1: f64 = 0.1256;
pub const C2: f64 = 0.01012;
pub const LAMBDA: f64 = 10.12;
const MU: f64 = 32.0;

pub fn laws() -> Vec<Entry> {
    // A Poisson's ratio of one quarter makes the Lamé constants equal: K = mu + 2/3 mu.
    let blatz_ko = BlatzKo::new(MU).expect("a positive modulus");
    let mooney = ModifiedMooneyRivlin::new(C1, C2, LAMBDA).expect("a positive shear modulus");
    vec![
        entry(
            "equation (5)",
            mooney,
            (equation_7, equation_9),
            (C1 + C2, 2.0 * LAMBDA),
        ),
        entry(
            "Blatz-Ko",
            blatz_ko,
            (equation_57, equation_58),
            (MU, 5.0 / 3.0 * MU),
        ),
    ]
}

fn invariants(c: &Matrix3<f64>) -> (f64, f64, f64) {
    let i1 = c.trace();
    (i1, 0.5 * (i1 * i1 - (c * c).trace()), c.determinant())
}

fn inverse(c: &Matrix3<f64>) -> Matrix3<f64> {
    c.try_inverse().expect("C is positive definite")
}

pub fn delta(i: usize, j: usize) -> f64 {
    f64::from(u8::from(i == j))
}

/// Twice `-dC^-1/dC`: `C^-1_ik C^-1_jl + C^-1_il C^-1_jk`.
fn twice_product(inverse: &Matrix3<f64>, (i, j, k, l): (usize, usize, usize, usize)) -> f64 {
    inverse[(i, k)] * inverse[(j, l)] + inverse[(i, l)] * inverse[(j, k)]
}

fn s0(i3: f64) -> f64 {
    C1 * i3.cbrt() + 2.0 * C2 * i3.cbrt().powi(2) - LAMBDA * i3.ln()
}

fn s1(i3: f64) -> f64 {
    (C1 / 3.0 * i3.powf(-2.0 / 3.0) + 4.0 / 3.0 * C2 * i3.powf(-1.0 / 3.0) - LAMBDA / i3) * i3
}

fn equation_7(c: &Matrix3<f64>) -> Matrix3<f64> {
    let (i1, _, i3) = invariants(c);
    Matrix3::identity() * (C1 + C2 * i1) - c * C2 - inverse(c) * s0(i3)
}

fn equation_9(c: &Matrix3<f64>) -> Components {
    let (c_inverse, i3) = (inverse(c), c.determinant());
    Box::new(move |i, j, k, l| {
        2.0 * C2 * delta(i, j) * delta(k, l)
            - C2 * (delta(i, k) * delta(j, l) + delta(i, l) * delta(j, k))
            + s0(i3) * twice_product(&c_inverse, (i, j, k, l))
            - 2.0 * s1(i3) * c_inverse[(i, j)] * c_inverse[(k, l)]
    })
}

fn equation_57(c: &Matrix3<f64>) -> Matrix3<f64> {
    let (i1, i2, i3) = invariants(c);
    let rest = Matrix3::identity() * i1 - c;
    (rest / i3 - inverse(c) * (i2 / i3 - i3.sqrt())) * MU
}

/// Equation (58) without its misprints: the last term has `I3^(1/2)`, and `2 mu` multiplies all of it.
fn equation_58(c: &Matrix3<f64>) -> Components {
    let (i1, i2, i3) = invariants(c);
    let (c, g) = (*c, inverse(c));
    Box::new(move |i, j, k, l| {
        let identity = 0.5 * (delta(i, k) * delta(j, l) + delta(i, l) * delta(j, k));
        let first = delta(i, j) * delta(k, l) - i1 * g[(i, j)] * delta(k, l) - identity
            + g[(i, j)] * c[(k, l)];
        let second =
            (i1 * delta(i, j) - c[(i, j)] - i2 * g[(i, j)]) / i3 - 0.5 * i3.sqrt() * g[(i, j)];
        let last = (i2 / i3 - i3.sqrt()) * -0.5 * twice_product(&g, (i, j, k, l));
        2.0 * MU * (first / i3 - second * g[(k, l)] - last)
    })
}

// ---- random states, the same in every run -----------------------------------------------------

impl Random {
    pub fn matrix(&mut self) -> Matrix3<f64> {
        Matrix3::from_fn(|_, _| self.number())
    }

    /// Rotation in the plane of the first two axes.
    pub fn planar_rotation(&mut self) -> Matrix3<f64> {
        let angle = std::f64::consts::PI * self.number();
        *nalgebra::Rotation3::from_axis_angle(&nalgebra::Vector3::z_axis(), angle).matrix()
    }

    /// Stretch between `1 / largest` and `largest`.
    pub fn stretch(&mut self, largest: f64) -> f64 {
        largest.powf(self.number())
    }

    /// Full, strongly deformed state.
    pub fn state(&mut self) -> DeformationGradient {
        let stretches =
            Matrix3::from_diagonal(&nalgebra::Vector3::from_fn(|_, _| self.stretch(1.6)));
        of(&(self.rotation() * stretches * self.rotation()))
    }

    /// Plane strain with the given range of stretches, rotated on both sides.
    pub fn planar_state(&mut self, largest: f64) -> DeformationGradient {
        let (l1, l2) = (self.stretch(largest), self.stretch(largest));
        let stretches = Matrix3::from_diagonal(&nalgebra::Vector3::new(l1, l2, 1.0));
        of(&(self.planar_rotation() * stretches * self.planar_rotation()))
    }
}

/// State with a matrix of components.
pub fn of(f: &Matrix3<f64>) -> DeformationGradient {
    DeformationGradient::new(std::array::from_fn(|i| std::array::from_fn(|j| f[(i, j)])))
        .expect("an admissible state")
}

/// Derivative at zero by central differences of fourth order.
pub fn differentiated(h: f64, f: impl Fn(f64) -> f64) -> f64 {
    (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
}

/// All index quadruples.
pub fn quadruples() -> impl Iterator<Item = (usize, usize, usize, usize)> {
    (0..81).map(|n| (n / 27, n / 9 % 3, n / 3 % 3, n % 3))
}
