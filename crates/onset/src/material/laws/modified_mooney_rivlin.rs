//! Compressible Mooney-Rivlin law of equation (5).

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed, hooke};
use super::super::{InvariantEnergy, MaterialError, given_by_invariants};
use crate::kinematics::Invariants;
use crate::real::Real;

pub(in super::super) const LAW: Law = Law {
    name: "modified-mooney-rivlin",
    formula: "W = c1/2 I1 + c2/2 I2 - 3/2 c1 I3^(1/3) - 3/2 c2 I3^(2/3) + lambda/4 (ln I3)^2",
    parameters: &[
        Parameter::new("c1", "stress", 0.1256, Admitted::Any, "first constant"),
        Parameter::new("c2", "stress", 0.01012, Admitted::Any, "second constant"),
        Parameter::new(
            "lambda",
            "stress",
            10.12,
            Admitted::Any,
            "volumetric constant",
        ),
    ],
    domain: "all J > 0; c1 + c2 > 0",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus c1 + c2, bulk modulus 2 lambda",
    source: "Xiao and Belytschko, Adv. Comput. Math. 23 (2005) 171, equation (5) and section 4; MPa",
    stiffness: |p| hooke(p[0] + p[1], 2.0 * p[2]),
    make: |p| boxed(ModifiedMooneyRivlin::new(p[0], p[1], p[2])),
};

/// Law of equation (5), a compressible relative of the Mooney-Rivlin law.
///
/// `W = c1/2 I1 + c2/2 I2 - 3/2 c1 I3^(1/3) - 3/2 c2 I3^(2/3) + lambda/4 (ln I3)^2`
///
/// It is stress-free in the reference state, where the shear modulus is `c1 + c2` and the bulk modulus `2 lambda`. In plane strain
/// `W = (c1 + c2)/2 |F|^2 + g(J)`, which gives its domain of strong ellipticity in closed form.
///
/// Parameters are in units of stress; the defaults are the paper's, in MPa. Source: Xiao and Belytschko, Material stability analysis of particle
/// methods, equation (5) and section 4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModifiedMooneyRivlin {
    c1: f64,
    c2: f64,
    lambda: f64,
}

impl ModifiedMooneyRivlin {
    /// Creates the law from its constants.
    ///
    /// # Errors
    /// [`MaterialError::Parameter`] if a constant is not finite, or if the shear modulus `c1 + c2` is not positive.
    pub fn new(c1: f64, c2: f64, lambda: f64) -> Result<Self, MaterialError> {
        LAW.check(&[c1, c2, lambda])?;
        MaterialError::positive("c1 + c2", c1 + c2)?;
        Ok(Self { c1, c2, lambda })
    }
}

impl Default for ModifiedMooneyRivlin {
    fn default() -> Self {
        Self {
            c1: LAW.default_of(0),
            c2: LAW.default_of(1),
            lambda: LAW.default_of(2),
        }
    }
}

impl InvariantEnergy for ModifiedMooneyRivlin {
    fn of_invariants<R: Real>(&self, i: &Invariants<R>) -> R {
        let log = i.third.ln();
        let cube_root = i.third.powf(1.0 / 3.0);
        i.first * (0.5 * self.c1) + i.second * (0.5 * self.c2)
            - cube_root * (1.5 * self.c1)
            - cube_root * cube_root * (1.5 * self.c2)
            + log * log * (0.25 * self.lambda)
    }
}

given_by_invariants!(ModifiedMooneyRivlin);
