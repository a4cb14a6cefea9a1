//! The compressible law of equation (5).

use super::{MaterialError, StrainEnergy};
use crate::kinematics::DeformationGradient;
use crate::real::Real;

/// The law of equation (5), a compressible relative of the Mooney-Rivlin law:
///
/// `W = c1/2 I1 + c2/2 I2 - 3/2 c1 I3^(1/3) - 3/2 c2 I3^(2/3) + lambda/4 (ln I3)^2`
///
/// Stress-free in the reference state, where the shear modulus is `c1 + c2` and the bulk modulus
/// `2 lambda`. In plane strain `W = (c1 + c2)/2 |F|^2 + g(J)`, from which its domain of strong
/// ellipticity follows in closed form.
///
/// Parameters in units of stress; the defaults are the paper's, in MPa. Source: Xiao and
/// Belytschko, Material stability analysis of particle methods, equation (5) and section 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModifiedMooneyRivlin {
    c1: f64,
    c2: f64,
    lambda: f64,
}

impl ModifiedMooneyRivlin {
    /// The law with the given constants.
    ///
    /// # Errors
    /// [`MaterialError::Parameter`] when one is not finite, or when the shear modulus `c1 + c2` is
    /// not positive.
    pub fn new(c1: f64, c2: f64, lambda: f64) -> Result<Self, MaterialError> {
        MaterialError::finite("c1", c1)?;
        MaterialError::finite("c2", c2)?;
        MaterialError::finite("lambda", lambda)?;
        MaterialError::positive("c1 + c2", c1 + c2)?;
        Ok(Self { c1, c2, lambda })
    }
}

impl Default for ModifiedMooneyRivlin {
    fn default() -> Self {
        Self {
            c1: 0.1256,
            c2: 0.01012,
            lambda: 10.12,
        }
    }
}

impl StrainEnergy for ModifiedMooneyRivlin {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let i = f.invariants();
        let log = i.third.ln();
        let cube_root = i.third.powf(1.0 / 3.0);
        i.first * (0.5 * self.c1) + i.second * (0.5 * self.c2)
            - cube_root * (1.5 * self.c1)
            - cube_root * cube_root * (1.5 * self.c2)
            + log * log * (0.25 * self.lambda)
    }
}
