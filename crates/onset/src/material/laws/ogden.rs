//! Ogden's law, nearly incompressible, with up to six terms.
//!
//! `W = sum_p mu_p / alpha_p (l1^alpha_p + l2^alpha_p + l3^alpha_p - 3) + kappa/2 (J - 1)^2`, `l_i = J^(-1/3) lambda_i`. The shear modulus is
//! `1/2 sum_p mu_p alpha_p`. Terms with `mu_p = 0` are ignored.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed, hooke};
use super::super::{LaneStress, MaterialError, PrincipalEnergy, StrainEnergy, energy_of_stretches};
use super::exponentials::beyond_linear;
use super::volumetric::logarithmic;
use crate::algebra::Each;
use crate::kinematics::DeformationGradient;
use crate::real::{Lanes, Real};

const MODULUS: &str = "modulus of the term, of either sign";
const EXPONENT: &str = "exponent of the term, not 0";

const fn modulus(name: &'static str, default: f64) -> Parameter {
    Parameter::new(name, "stress", default, Admitted::Any, MODULUS)
}

const fn exponent(name: &'static str, default: f64) -> Parameter {
    Parameter::new(name, "1", default, Admitted::Any, EXPONENT)
}

pub(in super::super) const LAW: Law = Law {
    name: "ogden",
    formula: "W = sum_(p=1..6) mu_p / alpha_p (l1^alpha_p + l2^alpha_p + l3^alpha_p - 3) + kappa/2 (J - 1)^2, l_i = J^(-1/3) lambda_i",
    parameters: &[
        modulus("mu1", 0.6178),
        exponent("alpha1", 1.3),
        modulus("mu2", 0.001_177),
        exponent("alpha2", 5.0),
        modulus("mu3", -0.009_807),
        exponent("alpha3", -2.0),
        modulus("mu4", 0.0),
        exponent("alpha4", 2.0),
        modulus("mu5", 0.0),
        exponent("alpha5", 2.0),
        modulus("mu6", 0.0),
        exponent("alpha6", 2.0),
        Parameter::new("kappa", "stress", 100.0, Admitted::Positive, "bulk modulus"),
    ],
    domain: "all J > 0; nearly incompressible rubber up to large strains; sum of mu_p alpha_p > 0",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus 1/2 sum_p mu_p alpha_p, bulk modulus kappa",
    source: "Ogden, Proc. R. Soc. London A 326 (1972) 565: 6.3, 0.012 and -0.1 kg/cm^2 (of 0.0980665 MPa) for Treloar's rubber; kappa chosen",
    stiffness: |p| hooke(shear_modulus(p), p[12]),
    make: |p| boxed(Ogden::new(p)),
};

/// Moduli and exponents of the terms with nonzero modulus.
fn terms(p: &[f64]) -> impl Iterator<Item = (f64, f64)> {
    let pairs = p[..12].chunks_exact(2).map(|pair| (pair[0], pair[1]));
    pairs.filter(|(modulus, _)| *modulus != 0.0)
}

fn shear_modulus(p: &[f64]) -> f64 {
    0.5 * terms(p).map(|(mu, alpha)| mu * alpha).sum::<f64>()
}

struct Ogden {
    terms: Vec<(f64, f64)>,
    kappa: f64,
}

impl Ogden {
    fn new(p: &[f64]) -> Result<Self, MaterialError> {
        let terms: Vec<(f64, f64)> = terms(p).collect();
        if terms.iter().any(|(_, alpha)| *alpha == 0.0) {
            return Err(MaterialError::Parameter {
                name: "an exponent of ogden",
                value: 0.0,
                expected: "a nonzero number if the modulus is nonzero".to_owned(),
            });
        }
        MaterialError::positive("1/2 sum of mu_p alpha_p", shear_modulus(p))?;
        Ok(Self {
            terms,
            kappa: p[12],
        })
    }
}

/// Energy of the change of shape.
impl PrincipalEnergy for Ogden {
    fn of_stretches<R: Real>(&self, [a, b, c]: [R; 3]) -> R {
        let logs = [a.ln(), b.ln(), c.ln()];
        let volume = logs[0] + logs[1] + logs[2];
        let deviators = logs.each(|log| log - volume / 3.0);
        self.terms
            .iter()
            .fold(R::constant(0.0), |sum, (mu, alpha)| {
                // The deviators sum to zero, so linear terms cancel and small exponents keep their digits.
                let [a, b, c] = deviators.each(|log| beyond_linear(log * *alpha));
                sum + (a + b + c) * (mu / alpha)
            })
    }
}

impl StrainEnergy for Ogden {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let change = logarithmic(f).exp() - 1.0;
        energy_of_stretches(self, f) + change * change * (0.5 * self.kappa)
    }

    fn lane_stress(&self, states: &DeformationGradient<Lanes>, dimension: usize) -> LaneStress {
        LaneStress::one_by_one(self, states, dimension)
    }
}
