//! Yeoh's law, nearly incompressible.
//!
//! `W = c10 x + c20 x^2 + c30 x^3 + kappa/2 (J - 1)^2`, `x = J^(-2/3) I1 - 3`. The shear modulus is `2 c10`.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed, hooke};
use super::super::{InvariantEnergy, given_by_invariants};
use super::volumetric::isochoric_first;
use crate::kinematics::Invariants;
use crate::real::Real;

pub(in super::super) const LAW: Law = Law {
    name: "yeoh",
    formula: "W = c10 x + c20 x^2 + c30 x^3 + kappa/2 (J - 1)^2, x = J^(-2/3) I1 - 3",
    parameters: &[
        Parameter::new(
            "c10",
            "stress",
            0.5,
            Admitted::Positive,
            "half the shear modulus",
        ),
        Parameter::new(
            "c20",
            "stress",
            -0.01,
            Admitted::Any,
            "constant of the second power",
        ),
        Parameter::new(
            "c30",
            "stress",
            1e-3,
            Admitted::Any,
            "constant of the third power",
        ),
        Parameter::new("kappa", "stress", 100.0, Admitted::Positive, "bulk modulus"),
    ],
    domain: "all J > 0; filled rubber up to large strains",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus 2 c10, bulk modulus kappa",
    source: "Yeoh, Rubber Chem. Technol. 66 (1993) 754; defaults: shear modulus 1, softening, then stiffening",
    stiffness: |p| hooke(2.0 * p[0], p[3]),
    make: |p| {
        boxed(Ok(Yeoh {
            c: [p[0], p[1], p[2]],
            kappa: p[3],
        }))
    },
};

struct Yeoh {
    c: [f64; 3],
    kappa: f64,
}

impl InvariantEnergy for Yeoh {
    fn of_invariants<R: Real>(&self, i: &Invariants<R>) -> R {
        let (x, change) = (isochoric_first(i) - 3.0, i.jacobian - 1.0);
        let [c1, c2, c3] = self.c;
        x * (x * (x * c3 + c2) + c1) + change * change * (0.5 * self.kappa)
    }
}

given_by_invariants!(Yeoh);
