//! Mooney-Rivlin law, compressible and nearly incompressible.
//!
//! Compressible: `W = c10 (I1 - 3) + c01 (I2 - 3) - 2 (c10 + 2 c01) ln J + lambda/2 (ln J)^2`; the logarithm makes the reference stress-free. Nearly
//! incompressible: the isochoric invariants alone, and `kappa/2 (J - 1)^2`. To second order in the logarithmic strain `h`,
//! `I2 - 3 - 4 ln J = 2 |h|^2 + 2 (tr h)^2`: `c01` adds `4 c01` to Lame's first constant.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed, hooke};
use super::super::{InvariantEnergy, MaterialError, given_by_invariants};
use super::volumetric::{isochoric_first, isochoric_second};
use crate::kinematics::Invariants;
use crate::real::Real;

const C10: Parameter = Parameter::new("c10", "stress", 0.4, Admitted::Any, "constant of I1");
const C01: Parameter = Parameter::new("c01", "stress", 0.1, Admitted::Any, "constant of I2");

pub(in super::super) const COMPRESSIBLE: Law = Law {
    name: "mooney-rivlin",
    formula: "W = c10 (I1 - 3) + c01 (I2 - 3) - 2 (c10 + 2 c01) ln J + lambda/2 (ln J)^2",
    parameters: &[
        C10,
        C01,
        Parameter::new(
            "lambda",
            "stress",
            1.0,
            Admitted::Any,
            "volumetric constant",
        ),
    ],
    domain: "all J > 0; rubber at moderate strains; c10 + c01 > 0",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus 2 (c10 + c01), Lame's first constant lambda + 4 c01",
    source: "Mooney, J. Appl. Phys. 11 (1940) 582; volumetric part of the neo-Hookean law of Simo and Pister, Comput. Methods Appl. Mech. Eng. 46 \
             (1984) 201; defaults: shear modulus 1, c01 / c10 = 1/4",
    stiffness: |p| {
        let mu = 2.0 * (p[0] + p[1]);
        hooke(mu, p[2] + 4.0 * p[1] + mu / 1.5)
    },
    make: |p| {
        MaterialError::positive("c10 + c01", p[0] + p[1])?;
        boxed(Ok(Compressible {
            c10: p[0],
            c01: p[1],
            lambda: p[2],
        }))
    },
};

pub(in super::super) const ISOCHORIC: Law = Law {
    name: "mooney-rivlin-isochoric",
    formula: "W = c10 (J^(-2/3) I1 - 3) + c01 (J^(-4/3) I2 - 3) + kappa/2 (J - 1)^2",
    parameters: &[
        C10,
        C01,
        Parameter::new("kappa", "stress", 100.0, Admitted::Positive, "bulk modulus"),
    ],
    domain: "all J > 0; nearly incompressible rubber at moderate strains; c10 + c01 > 0",
    small_strains: "shear modulus 2 (c10 + c01), bulk modulus kappa",
    source: "Mooney, J. Appl. Phys. 11 (1940) 582; Rivlin, Phil. Trans. R. Soc. A 241 (1948) 379; defaults: shear modulus 1, \
             c01 / c10 = 1/4, kappa = 100",
    stiffness: |p| hooke(2.0 * (p[0] + p[1]), p[2]),
    make: |p| {
        MaterialError::positive("c10 + c01", p[0] + p[1])?;
        boxed(Ok(Isochoric {
            c10: p[0],
            c01: p[1],
            kappa: p[2],
        }))
    },
    ..COMPRESSIBLE
};

struct Compressible {
    c10: f64,
    c01: f64,
    lambda: f64,
}

impl InvariantEnergy for Compressible {
    fn of_invariants<R: Real>(&self, i: &Invariants<R>) -> R {
        let log = i.jacobian.ln();
        (i.first - 3.0 - log * 2.0) * self.c10
            + (i.second - 3.0 - log * 4.0) * self.c01
            + log * log * (0.5 * self.lambda)
    }
}

given_by_invariants!(Compressible);

struct Isochoric {
    c10: f64,
    c01: f64,
    kappa: f64,
}

impl InvariantEnergy for Isochoric {
    fn of_invariants<R: Real>(&self, i: &Invariants<R>) -> R {
        let change = i.jacobian - 1.0;
        (isochoric_first(i) - 3.0) * self.c10
            + (isochoric_second(i) - 3.0) * self.c01
            + change * change * (0.5 * self.kappa)
    }
}

given_by_invariants!(Isochoric);
