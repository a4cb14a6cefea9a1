//! Hencky's law: quadratic in the logarithmic strain `h_i = ln lambda_i`.
//!
//! `W = mu |dev h|^2 + kappa/2 (tr h)^2`. The principal Kirchhoff stresses are `2 mu dev h_i + kappa tr h`.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed, hooke};
use super::super::{LaneStress, PrincipalEnergy, StrainEnergy, energy_of_stretches};
use super::volumetric::logarithmic;
use crate::algebra::Each;
use crate::kinematics::DeformationGradient;
use crate::real::{Lanes, Real};

pub(in super::super) const LAW: Law = Law {
    name: "hencky",
    formula: "W = mu |dev h|^2 + kappa/2 (tr h)^2, h_i = ln lambda_i",
    parameters: &[
        Parameter::new("mu", "stress", 1.0, Admitted::Positive, "shear modulus"),
        Parameter::new(
            "kappa",
            "stress",
            5.0 / 3.0,
            Admitted::Positive,
            "bulk modulus",
        ),
    ],
    domain: "all J > 0; metals and polymers at small to moderate strains; loses strong ellipticity at moderate strains",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus mu, bulk modulus kappa",
    source: "Hencky, Z. Techn. Phys. 9 (1928) 215; defaults: Poisson's ratio 1/4, any unit of stress",
    stiffness: |p| hooke(p[0], p[1]),
    make: |p| {
        boxed(Ok(Hencky {
            mu: p[0],
            kappa: p[1],
        }))
    },
};

struct Hencky {
    mu: f64,
    kappa: f64,
}

/// Invariant `|dev h|^2` of the logarithmic strain.
pub(super) fn logarithmic_shape<R: Real>(stretches: [R; 3]) -> R {
    let h = stretches.map(R::ln);
    let trace = h[0] + h[1] + h[2];
    let [a, b, c] = h.each(|h| h - trace / 3.0);
    a * a + b * b + c * c
}

/// Energy of the change of shape.
impl PrincipalEnergy for Hencky {
    fn of_stretches<R: Real>(&self, stretches: [R; 3]) -> R {
        logarithmic_shape(stretches) * self.mu
    }
}

impl StrainEnergy for Hencky {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let volume = logarithmic(f);
        energy_of_stretches(self, f) + volume * volume * (0.5 * self.kappa)
    }

    fn lane_stress(&self, states: &DeformationGradient<Lanes>, dimension: usize) -> LaneStress {
        LaneStress::one_by_one(self, states, dimension)
    }
}
