//! Fung's exponential laws of soft tissue.
//!
//! Isotropic (Demiray): `W = mu/(2 b) (exp(b (J^(-2/3) I1 - 3)) - 1) + kappa/2 ((J^2 - 1)/2 - ln J)`. Orthotropic: `W = c/2 (exp Q - 1)` with a
//! quadratic form `Q` in Green's strain. The stiffness at small strains is `c` times the form.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed, hooke};
use super::super::{
    InvariantEnergy, MaterialError, SmallStrainStiffness, StrainEnergy, given_by_invariants,
};
use super::quadratic::{QuadraticForm, is_positive, orthotropic, turned};
use super::volumetric::{isochoric_first, polyconvex};
use crate::algebra::array_of;
use crate::kinematics::{DeformationGradient, Invariants};
use crate::real::Real;

pub(in super::super) const ISOTROPIC: Law = Law {
    name: "fung-isotropic",
    formula: "W = mu/(2 b) (exp(b (J^(-2/3) I1 - 3)) - 1) + kappa/2 ((J^2 - 1)/2 - ln J)",
    parameters: &[
        Parameter::new("mu", "stress", 1.0, Admitted::Positive, "shear modulus"),
        Parameter::new(
            "b",
            "1",
            1.0,
            Admitted::Positive,
            "constant of the exponent",
        ),
        Parameter::new("kappa", "stress", 100.0, Admitted::Positive, "bulk modulus"),
    ],
    domain: "all J > 0; soft tissue without fibers",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus mu, bulk modulus kappa",
    source: "Fung, Am. J. Physiol. 213 (1967) 1532; Demiray, J. Biomech. 5 (1972) 309; defaults: round numbers",
    stiffness: |p| hooke(p[0], p[2]),
    make: |p| {
        boxed(Ok(Isotropic {
            mu: p[0],
            b: p[1],
            kappa: p[2],
        }))
    },
};

const fn form(name: &'static str, default: f64) -> Parameter {
    let meaning = "coefficient of Q";
    Parameter::new(name, "1", default, Admitted::Any, meaning)
}

pub(in super::super) const ORTHOTROPIC: Law = Law {
    name: "fung",
    formula: "W = c/2 (exp Q - 1), Q = b11 E11^2 + b22 E22^2 + b33 E33^2 + 2 (b23 E22 E33 + b13 E11 E33 + b12 E11 E22) + 4 (b44 E23^2 + b55 E13^2 \
              + b66 E12^2), E = (C - 1)/2",
    parameters: &[
        Parameter::new("c", "stress", 10.0, Admitted::Positive, "modulus"),
        form("b11", 5.0),
        form("b22", 3.0),
        form("b33", 2.0),
        form("b23", 0.5),
        form("b13", 0.5),
        form("b12", 1.0),
        form("b44", 0.5),
        form("b55", 0.5),
        form("b66", 1.0),
        Parameter::new(
            "angle",
            "deg",
            0.0,
            Admitted::Any,
            "angle from axis 1 to the material's axis 1, about axis 3",
        ),
    ],
    domain: "all states with a finite exp Q; soft tissue and arteries, with a positive definite form",
    symmetry: Symmetry::Orthotropic,
    stressed_reference: None,
    small_strains: "elastic constants c b11, c b22, ..., c b66",
    source: "Fung, Fronek and Patitucci, Am. J. Physiol. 237 (1979) H620; defaults: round numbers",
    stiffness: |p| turned(&scaled(p[0], p), p[10]),
    make: |p| {
        let form = scaled(1.0, p);
        if !is_positive(&form) {
            return Err(MaterialError::Parameter {
                name: "b11",
                value: p[1],
                expected: "coefficients b11 to b66 that form a positive definite matrix, so that every strain has positive energy".to_owned(),
            });
        }
        boxed(Ok(Orthotropic {
            modulus: p[0],
            form: QuadraticForm::new(form, p[10]),
        }))
    },
};

/// Stiffness `scale` times the quadratic form.
fn scaled(scale: f64, p: &[f64]) -> SmallStrainStiffness {
    let [normal, shear] = [&p[1..7], &p[7..10]];
    let normal = array_of(|n| scale * normal[n]);
    orthotropic(&normal, &array_of(|n| scale * shear[n]))
}

struct Isotropic {
    mu: f64,
    b: f64,
    kappa: f64,
}

impl InvariantEnergy for Isotropic {
    fn of_invariants<R: Real>(&self, i: &Invariants<R>) -> R {
        let growth = ((isochoric_first(i) - 3.0) * self.b).exp() - 1.0;
        growth * (0.5 * self.mu / self.b) + polyconvex(i.jacobian) * (0.5 * self.kappa)
    }
}

given_by_invariants!(Isotropic);

struct Orthotropic {
    modulus: f64,
    form: QuadraticForm,
}

impl StrainEnergy for Orthotropic {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        ((self.form.of(f) * 2.0).exp() - 1.0) * (0.5 * self.modulus)
    }
}
