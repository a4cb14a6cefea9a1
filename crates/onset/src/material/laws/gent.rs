//! Gent's law, nearly incompressible.
//!
//! `W = -mu jm/2 ln(1 - (J^(-2/3) I1 - 3) / jm) + kappa/2 ((J^2 - 1)/2 - ln J)`. The chains lock where `J^(-2/3) I1 - 3` reaches `jm`. Beyond it the
//! law is undefined, and states are rejected.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed, hooke};
use super::super::{InvariantEnergy, MaterialError, given_by_invariants};
use super::volumetric::{isochoric_first, polyconvex};
use crate::kinematics::Invariants;
use crate::real::Real;

pub(in super::super) const LAW: Law = Law {
    name: "gent",
    formula: "W = -mu jm/2 ln(1 - (J^(-2/3) I1 - 3) / jm) + kappa/2 ((J^2 - 1)/2 - ln J)",
    parameters: &[
        Parameter::new("mu", "stress", 1.0, Admitted::Positive, "shear modulus"),
        Parameter::new(
            "jm",
            "1",
            97.2,
            Admitted::Positive,
            "J^(-2/3) I1 - 3 at which the chains lock",
        ),
        Parameter::new("kappa", "stress", 100.0, Admitted::Positive, "bulk modulus"),
    ],
    domain: "J^(-2/3) I1 - 3 < jm; rubber up to the locking of its chains",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus mu, bulk modulus kappa",
    source: "Gent, Rubber Chem. Technol. 69 (1996) 59; jm = 97.2 as usual for vulcanized rubber (Horgan and Saccomandi, J. Elasticity \
             68 (2002) 167)",
    stiffness: |p| hooke(p[0], p[2]),
    make: |p| {
        boxed(Ok(Gent {
            mu: p[0],
            jm: p[1],
            kappa: p[2],
        }))
    },
};

struct Gent {
    mu: f64,
    jm: f64,
    kappa: f64,
}

impl InvariantEnergy for Gent {
    fn of_invariants<R: Real>(&self, i: &Invariants<R>) -> R {
        let rest = (isochoric_first(i) - 3.0) * (-1.0 / self.jm) + 1.0;
        rest.ln() * (-0.5 * self.mu * self.jm) + polyconvex(i.jacobian) * (0.5 * self.kappa)
    }

    fn admits_invariants(&self, i: &Invariants<f64>) -> Result<(), MaterialError> {
        let value = isochoric_first(i) - 3.0;
        // The comparison also fails for NaN.
        if value < self.jm {
            return Ok(());
        }
        Err(MaterialError::OutsideDomain {
            what: "J^(-2/3) I1 - 3",
            value,
            expected: format!("the chains of gent lock at jm = {:?}", self.jm),
        })
    }
}

given_by_invariants!(Gent);
