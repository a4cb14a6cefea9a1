//! Neo-Hookean laws with four volumetric parts.
//!
//! `W = mu/2 (I1 - 3) - mu ln J + lambda U(J)` with `U = (ln J)^2 / 2`, `(J - 1)^2 / 2` or `((J^2 - 1)/2 - ln J) / 2`, and, for nearly incompressible
//! rubber, `W = mu/2 (J^(-2/3) I1 - 3) + kappa/2 ((J^2 - 1)/2 - ln J)`. All are stress-free in the reference configuration. With `(ln J)^2` the energy is not
//! convex in `J`, and uniaxial strain loses strong ellipticity at `J = exp(1 + 2 mu / lambda)` or before; the other two are polyconvex.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed, hooke};
use super::super::{InvariantEnergy, MaterialError, given_by_invariants};
use super::volumetric::{isochoric_first, polyconvex};
use crate::kinematics::Invariants;
use crate::real::Real;

const MU: Parameter = Parameter::new("mu", "stress", 1.0, Admitted::Positive, "shear modulus");
const LAMBDA: Parameter = Parameter::new(
    "lambda",
    "stress",
    1.0,
    Admitted::Any,
    "Lame's first constant",
);
const KAPPA: Parameter =
    Parameter::new("kappa", "stress", 100.0, Admitted::Positive, "bulk modulus");

const DEFAULTS: &str = "defaults: mu = lambda, Poisson's ratio 1/4, any unit of stress";

pub(in super::super) const LOGARITHMIC: Law = Law {
    name: "neo-hooke",
    formula: "W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2",
    parameters: &[MU, LAMBDA],
    domain: "all J > 0; rubber at moderate strains; lambda > -2/3 mu",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "Lame's constants lambda and mu",
    source: "Simo and Pister, Comput. Methods Appl. Mech. Eng. 46 (1984) 201; defaults: mu = lambda, Poisson's ratio 1/4",
    stiffness: |p| hooke(p[0], p[1] + p[0] / 1.5),
    make: |p| boxed(NeoHooke::new(p, Volumetric::Logarithmic)),
};

pub(in super::super) const QUADRATIC: Law = Law {
    name: "neo-hooke-quadratic",
    formula: "W = mu/2 (I1 - 3) - mu ln J + lambda/2 (J - 1)^2",
    domain: "all J > 0; rubber at moderate strains; polyconvex for lambda >= 0; lambda > -2/3 mu",
    source: DEFAULTS,
    make: |p| boxed(NeoHooke::new(p, Volumetric::Quadratic)),
    ..LOGARITHMIC
};

pub(in super::super) const POLYCONVEX: Law = Law {
    name: "neo-hooke-polyconvex",
    formula: "W = mu/2 (I1 - 3) - mu ln J + lambda/2 ((J^2 - 1)/2 - ln J)",
    domain: "all J > 0; rubber at moderate strains; polyconvex for lambda >= 0; lambda > -2/3 mu",
    source: "Simo and Taylor, Comput. Methods Appl. Mech. Eng. 85 (1991) 273; defaults: mu = lambda, Poisson's ratio 1/4",
    make: |p| boxed(NeoHooke::new(p, Volumetric::Polyconvex)),
    ..LOGARITHMIC
};

pub(in super::super) const ISOCHORIC: Law = Law {
    name: "neo-hooke-isochoric",
    formula: "W = mu/2 (J^(-2/3) I1 - 3) + kappa/2 ((J^2 - 1)/2 - ln J)",
    parameters: &[MU, KAPPA],
    domain: "all J > 0; nearly incompressible rubber at moderate strains",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus mu, bulk modulus kappa",
    source: "Simo and Taylor, Comput. Methods Appl. Mech. Eng. 85 (1991) 273; defaults: kappa = 100 mu, any unit of stress",
    stiffness: |p| hooke(p[0], p[1]),
    make: |p| {
        boxed(Ok(Isochoric {
            mu: p[0],
            kappa: p[1],
        }))
    },
};

#[derive(Clone, Copy)]
enum Volumetric {
    Logarithmic,
    Quadratic,
    Polyconvex,
}

struct NeoHooke {
    mu: f64,
    lambda: f64,
    volumetric: Volumetric,
}

impl NeoHooke {
    fn new(p: &[f64], volumetric: Volumetric) -> Result<Self, MaterialError> {
        MaterialError::positive("lambda + 2/3 mu", p[1] + p[0] / 1.5)?;
        Ok(Self {
            mu: p[0],
            lambda: p[1],
            volumetric,
        })
    }
}

impl InvariantEnergy for NeoHooke {
    fn of_invariants<R: Real>(&self, i: &Invariants<R>) -> R {
        let (j, log) = (i.jacobian, i.jacobian.ln());
        let volumetric = match self.volumetric {
            Volumetric::Logarithmic => log * log,
            Volumetric::Quadratic => (j - 1.0) * (j - 1.0),
            Volumetric::Polyconvex => polyconvex(j),
        };
        ((i.first - 3.0) * 0.5 - log) * self.mu + volumetric * (0.5 * self.lambda)
    }
}

given_by_invariants!(NeoHooke);

struct Isochoric {
    mu: f64,
    kappa: f64,
}

impl InvariantEnergy for Isochoric {
    fn of_invariants<R: Real>(&self, i: &Invariants<R>) -> R {
        (isochoric_first(i) - 3.0) * (0.5 * self.mu) + polyconvex(i.jacobian) * (0.5 * self.kappa)
    }
}

given_by_invariants!(Isochoric);
