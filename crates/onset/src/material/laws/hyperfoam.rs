//! Foam of Ogden, Hill and Storakers with three terms.
//!
//! `W = sum_p 2 mu_p / alpha_p^2 (lambda_1^alpha_p + lambda_2^alpha_p + lambda_3^alpha_p - 3 + (J^(-alpha_p beta_p) - 1) / beta_p)`. Shear modulus
//! `sum_p mu_p`, bulk modulus `sum_p 2 mu_p (1/3 + beta_p)`; `beta_p = nu / (1 - 2 nu)` for a given Poisson's ratio. Terms with `mu_p = 0` are
//! ignored.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed, hooke};
use super::super::{LaneStress, MaterialError, PrincipalEnergy, StrainEnergy, energy_of_stretches};
use super::exponentials::beyond_linear;
use crate::algebra::Each;
use crate::kinematics::DeformationGradient;
use crate::real::{Lanes, Real};

const fn modulus(name: &'static str, default: f64) -> Parameter {
    let meaning = "modulus of the term, of either sign";
    Parameter::new(name, "stress", default, Admitted::Any, meaning)
}

const fn exponent(name: &'static str, default: f64) -> Parameter {
    Parameter::new(
        name,
        "1",
        default,
        Admitted::Any,
        "exponent of the term, not 0",
    )
}

const fn volumetric(name: &'static str) -> Parameter {
    let meaning = "volumetric exponent of the term, nu / (1 - 2 nu)";
    Parameter::new(name, "1", 0.0, Admitted::Any, meaning)
}

pub(in super::super) const LAW: Law = Law {
    name: "hyperfoam",
    formula: "W = sum_(p=1..3) 2 mu_p / alpha_p^2 (lambda_1^alpha_p + lambda_2^alpha_p + lambda_3^alpha_p - 3 + (J^(-alpha_p beta_p) - 1) / beta_p)",
    parameters: &[
        modulus("mu1", 1.0),
        exponent("alpha1", 8.0),
        volumetric("beta1"),
        modulus("mu2", 0.0),
        exponent("alpha2", 2.0),
        volumetric("beta2"),
        modulus("mu3", 0.0),
        exponent("alpha3", 2.0),
        volumetric("beta3"),
    ],
    domain: "all J > 0; highly compressible foam; sum of mu_p > 0, sum of mu_p (1/3 + beta_p) > 0",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus sum_p mu_p, bulk modulus sum_p 2 mu_p (1/3 + beta_p)",
    source: "Storakers, J. Mech. Phys. Solids 34 (1986) 125; Hill, Adv. Appl. Mech. 18 (1978) 1; defaults: shear modulus 1, no lateral \
             strain",
    stiffness: |p| hooke(shear_modulus(p), bulk_modulus(p)),
    make: |p| boxed(Hyperfoam::new(p)),
};

struct Term {
    mu: f64,
    alpha: f64,
    beta: f64,
}

/// Terms with nonzero modulus.
fn terms(p: &[f64]) -> impl Iterator<Item = Term> {
    let term = |p: &[f64]| Term {
        mu: p[0],
        alpha: p[1],
        beta: p[2],
    };
    p.chunks_exact(3).map(term).filter(|term| term.mu != 0.0)
}

fn shear_modulus(p: &[f64]) -> f64 {
    terms(p).map(|term| term.mu).sum()
}

fn bulk_modulus(p: &[f64]) -> f64 {
    terms(p)
        .map(|term| 2.0 * term.mu * (1.0 / 3.0 + term.beta))
        .sum()
}

struct Hyperfoam {
    terms: Vec<Term>,
}

impl Hyperfoam {
    fn new(p: &[f64]) -> Result<Self, MaterialError> {
        let terms: Vec<Term> = terms(p).collect();
        if terms.iter().any(|term| term.alpha == 0.0) {
            return Err(MaterialError::Parameter {
                name: "an exponent of hyperfoam",
                value: 0.0,
                expected: "a nonzero number if the modulus is nonzero".to_owned(),
            });
        }
        MaterialError::positive("mu1 + mu2 + mu3", shear_modulus(p))?;
        MaterialError::positive("the sum of 2 mu_p (1/3 + beta_p)", bulk_modulus(p))?;
        Ok(Self { terms })
    }
}

impl PrincipalEnergy for Hyperfoam {
    fn of_stretches<R: Real>(&self, stretches: [R; 3]) -> R {
        let logs = stretches.map(R::ln);
        let volume = logs[0] + logs[1] + logs[2];
        self.terms.iter().fold(R::constant(0.0), |sum, term| {
            // Terms linear in the logarithms cancel: alpha ln J of the stretches, and -alpha ln J of (J^(-alpha beta) - 1) / beta, which has no other
            // terms at beta = 0.
            let [a, b, c] = logs.each(|log| beyond_linear(log * term.alpha));
            let foam = match term.beta {
                0.0 => R::constant(0.0),
                beta => beyond_linear(volume * (-term.alpha * beta)) / beta,
            };
            sum + (a + b + c + foam) * (2.0 * term.mu / (term.alpha * term.alpha))
        })
    }
}

impl StrainEnergy for Hyperfoam {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        energy_of_stretches(self, f)
    }

    fn lane_stress(&self, states: &DeformationGradient<Lanes>, dimension: usize) -> LaneStress {
        LaneStress::one_by_one(self, states, dimension)
    }
}
