//! Exponentiated Hencky law for large strains.
//!
//! `W = mu/k (exp(k |dev h|^2) - 1) + kappa/(2 k2) (exp(k2 (tr h)^2) - 1)`, `h_i = ln lambda_i`. The energy of two dimensions, with the deviator
//! `h - tr h/2` in the plane, is rank-one convex for `k >= 1/4` and `khat >= 1/8`. This does not apply to plane strain of the present law, whose
//! deviator is three-dimensional. In three dimensions the law is not elliptic everywhere for any constants.

use super::super::law::{Admitted, Law, Parameter, Symmetry, boxed, hooke};
use super::super::{LaneStress, PrincipalEnergy, StrainEnergy, energy_of_stretches};
use super::hencky::logarithmic_shape;
use super::volumetric::logarithmic;
use crate::kinematics::DeformationGradient;
use crate::real::{Lanes, Real};

pub(in super::super) const LAW: Law = Law {
    name: "exponentiated-hencky",
    formula: "W = mu/k (exp(k |dev h|^2) - 1) + kappa/(2 khat) (exp(khat (tr h)^2) - 1), h_i = ln lambda_i",
    parameters: &[
        Parameter::new("mu", "stress", 1.0, Admitted::Positive, "shear modulus"),
        Parameter::new(
            "kappa",
            "stress",
            5.0 / 3.0,
            Admitted::Positive,
            "bulk modulus",
        ),
        Parameter::new(
            "k",
            "1",
            0.25,
            Admitted::Positive,
            "coefficient of the exponent of the isochoric part",
        ),
        Parameter::new(
            "khat",
            "1",
            0.125,
            Admitted::Positive,
            "coefficient of the exponent of the volumetric part",
        ),
    ],
    domain: "all J > 0; moderate to large strains",
    symmetry: Symmetry::Isotropic,
    stressed_reference: None,
    small_strains: "shear modulus mu, bulk modulus kappa",
    source: "Neff, Ghiba and Lankeit, J. Elasticity 121 (2015) 143; k = 1/4 and khat = 1/8, the smallest values for which the two-dimensional energy \
             (in-plane deviator) is rank-one convex",
    stiffness: |p| hooke(p[0], p[1]),
    make: |p| {
        boxed(Ok(ExponentiatedHencky {
            mu: p[0],
            kappa: p[1],
            shape: p[2],
            volume: p[3],
        }))
    },
};

struct ExponentiatedHencky {
    mu: f64,
    kappa: f64,
    shape: f64,
    volume: f64,
}

/// Energy of the change of shape.
impl PrincipalEnergy for ExponentiatedHencky {
    fn of_stretches<R: Real>(&self, stretches: [R; 3]) -> R {
        let shape = logarithmic_shape(stretches);
        ((shape * self.shape).exp() - 1.0) * (self.mu / self.shape)
    }
}

impl StrainEnergy for ExponentiatedHencky {
    fn energy<R: Real>(&self, f: &DeformationGradient<R>) -> R {
        let volume = logarithmic(f);
        energy_of_stretches(self, f)
            + ((volume * volume * self.volume).exp() - 1.0) * (0.5 * self.kappa / self.volume)
    }

    fn lane_stress(&self, states: &DeformationGradient<Lanes>, dimension: usize) -> LaneStress {
        LaneStress::one_by_one(self, states, dimension)
    }
}
