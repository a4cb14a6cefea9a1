//! Blatz-Ko law for foamed rubber.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed, hooke};
use super::super::{InvariantEnergy, MaterialError, given_by_invariants};
use crate::kinematics::Invariants;
use crate::real::Real;

pub(in super::super) const LAW: Law = Law {
    name: "blatz-ko",
    formula: "W = mu/2 (I2 / J^2 + 2 J - 5)",
    parameters: &[Parameter::new(
        "mu",
        "stress",
        32.0,
        Admitted::Positive,
        "shear modulus",
    )],
    domain: "all J > 0; foamed rubber at large strains",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus mu, Poisson's ratio 1/4",
    source: "Blatz and Ko, Trans. Soc. Rheol. 6 (1962) 223; default: mu = 32 psi",
    stiffness: |p| hooke(p[0], p[0] * 5.0 / 3.0),
    make: |p| boxed(BlatzKo::new(p[0])),
};

/// Law of Blatz and Ko for a foamed rubber, equation (56).
///
/// `W = mu/2 (I2 / J^2 + 2 J - 5)`
///
/// It is stress-free in the reference state with shear modulus `mu` and Poisson's ratio 1/4. It loses strong ellipticity where a ratio of two
/// principal stretches reaches `2 + sqrt 3` (Knowles and Sternberg, J. Elasticity 5 (1975) 341).
///
/// `mu` is in units of stress; the default is the paper's 32 (psi). Source: Blatz and Ko, Trans. Soc. Rheol. 6 (1962) 223.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlatzKo {
    mu: f64,
}

impl BlatzKo {
    /// Creates the law from the shear modulus `mu`.
    ///
    /// # Errors
    /// [`MaterialError::Parameter`] if `mu` is not positive and finite.
    pub fn new(mu: f64) -> Result<Self, MaterialError> {
        LAW.check(&[mu])?;
        Ok(Self { mu })
    }
}

impl Default for BlatzKo {
    fn default() -> Self {
        Self {
            mu: LAW.default_of(0),
        }
    }
}

impl InvariantEnergy for BlatzKo {
    fn of_invariants<R: Real>(&self, i: &Invariants<R>) -> R {
        (i.second / i.third + i.jacobian * 2.0 - 5.0) * (0.5 * self.mu)
    }
}

given_by_invariants!(BlatzKo);
