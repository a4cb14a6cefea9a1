//! First Piola-Kirchhoff stresses in closed form, differentiated by hand.

use nalgebra::Matrix3;
use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin};

#[derive(Clone, Copy, Debug)]
pub enum Law {
    /// Equation (5) with the paper's constants.
    MooneyRivlin,
    /// Equation (56) with `mu = 1`.
    BlatzKo,
}

impl Law {
    /// First Piola-Kirchhoff stress `P = dW/dF`.
    pub fn first_piola(self, f: &Matrix3<f64>) -> Matrix3<f64> {
        let j = f.determinant();
        let inverse_transpose = f
            .try_inverse()
            .expect("an invertible deformation")
            .transpose();
        let c = f.transpose() * f;
        let i1 = c.trace();
        let i2 = 0.5 * (i1 * i1 - (c * c).trace());
        // Derivatives of the invariants: dI1/dF = 2 F, dI2/dF = 2 (I1 F - F C), dJ/dF = J F^-T.
        let half_i2 = f * i1 - f * c;
        match self {
            Self::MooneyRivlin => {
                let (c1, c2, lambda) = (0.1256, 0.01012, 10.12);
                let volumetric =
                    2.0 * lambda * j.ln() - c1 * j.powf(2.0 / 3.0) - 2.0 * c2 * j.powf(4.0 / 3.0);
                f * c1 + half_i2 * c2 + inverse_transpose * volumetric
            }
            Self::BlatzKo => half_i2 / (j * j) + inverse_transpose * (j - i2 / (j * j)),
        }
    }

    /// Cauchy stress `sigma = P F^T / J`.
    pub fn cauchy(self, f: &Matrix3<f64>) -> Matrix3<f64> {
        self.first_piola(f) * f.transpose() / f.determinant()
    }

    /// Law of the same name in the crate.
    pub fn material(self) -> Box<dyn Hyperelastic> {
        match self {
            Self::MooneyRivlin => Box::new(ModifiedMooneyRivlin::default()),
            Self::BlatzKo => Box::new(BlatzKo::new(1.0).expect("a positive modulus")),
        }
    }
}
