//! Generalized Blatz-Ko law.
//!
//! `W = mu/2 f (I1 - 3 + (J^(-2 b) - 1)/b) + mu/2 (1 - f) (I2/I3 - 3 + (J^(2 b) - 1)/b)`, `b = nu / (1 - 2 nu)`. With `f = 0` and `nu = 1/4` it is
//! the law `blatz-ko`.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed, hooke};
use super::super::{InvariantEnergy, given_by_invariants};
use crate::kinematics::Invariants;
use crate::real::Real;

pub(in super::super) const LAW: Law = Law {
    name: "generalized-blatz-ko",
    formula: "W = mu/2 f (I1 - 3 + (J^(-2b) - 1)/b) + mu/2 (1 - f) (I2/I3 - 3 + (J^(2b) - 1)/b), b = nu / (1 - 2 nu)",
    parameters: &[
        Parameter::new("mu", "stress", 32.0, Admitted::Positive, "shear modulus"),
        Parameter::new(
            "f",
            "1",
            0.13,
            Admitted::Fraction,
            "fraction of the solid part",
        ),
        Parameter::new(
            "nu",
            "1",
            0.25,
            Admitted::Between(-1.0, 0.5),
            "Poisson's ratio",
        ),
    ],
    domain: "all J > 0; foamed (f near 0) to solid (f = 1) rubber at large strains",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus mu, Poisson's ratio nu",
    source: "Blatz and Ko, Trans. Soc. Rheol. 6 (1962) 223; defaults: foamed polyurethane, psi",
    stiffness: |p| hooke(p[0], 2.0 * p[0] * (1.0 + p[2]) / (3.0 * (1.0 - 2.0 * p[2]))),
    make: |p| {
        boxed(Ok(GeneralizedBlatzKo {
            mu: p[0],
            f: p[1],
            b: p[2] / (1.0 - 2.0 * p[2]),
        }))
    },
};

struct GeneralizedBlatzKo {
    mu: f64,
    f: f64,
    b: f64,
}

impl InvariantEnergy for GeneralizedBlatzKo {
    fn of_invariants<R: Real>(&self, i: &Invariants<R>) -> R {
        let log = i.jacobian.ln();
        // (J^(2 s b) - 1) / b, whose limit at b = 0 is 2 s ln J.
        let power = |sign: f64| match self.b {
            0.0 => log * (2.0 * sign),
            b => ((log * (2.0 * sign * b)).exp() - 1.0) / b,
        };
        (i.first - 3.0 + power(-1.0)) * (0.5 * self.mu * self.f)
            + (i.second / i.third - 3.0 + power(1.0)) * (0.5 * self.mu * (1.0 - self.f))
    }
}

given_by_invariants!(GeneralizedBlatzKo);
