//! Laws that lose stiffness along a loading: deformation theory and scalar damage.

use super::super::coaxial::{
    KAPPA, MODULUS, MU, RESIDUAL, SLIP, STRENGTH, coaxial, elasticity, hardening,
};
use super::super::flow::{Elasticity, Flow, FlowLaw, direction, parts};
use super::super::law::DRUCKER_PRAGER;
use super::super::metal;
use super::super::{Hardening, PlasticityError};
use crate::material::{Law, Parameter};
use nalgebra::Vector3;

pub(in super::super) const DAMAGE: Law = Law {
    name: "damage",
    formula: "(1 - D) times Hencky's law with mu, kappa for the Kirchhoff stress T, 1 - D = k/(k + mu g); sqrt(mu T : e) = k(g) with the logarithmic strain e; \
              k = residual + (strength - residual + hardening-modulus g) exp(-g/reference-slip)",
    parameters: &[
        MU,
        KAPPA,
        Parameter {
            default: 3.0,
            ..STRENGTH
        },
        Parameter {
            default: 0.0,
            ..RESIDUAL
        },
        Parameter {
            default: 0.0,
            ..MODULUS
        },
        Parameter {
            default: 0.01,
            ..SLIP
        },
    ],
    source: "damage by the energy norm of Simo and Ju, Int. J. Solids Struct. 23 (1987) 821, equal in tension and in compression; defaults: typical of a concrete in tension, MPa",
    make: |p| coaxial(damage(p), 0.0),
    ..DRUCKER_PRAGER
};

/// Damage from its parameters.
pub(in super::super) fn damage(p: &[f64]) -> Result<ScalarDamage, PlasticityError> {
    ScalarDamage::new(elasticity(p), hardening(&p[2..]))
}

pub(in super::super) const DEFORMATION_THEORY: Law = Law {
    name: "deformation-theory",
    formula: "Hencky's law with kappa and the secant shear modulus m for the Kirchhoff stress T, 1/m = 1/mu + 3 e/s(e); sqrt(3/2) |dev T| = s(e) = \
              yield-stress (1 + e/reference-strain)^exponent + hardening-modulus e + saturation-stress (1 - exp(-saturation-rate e)) beyond yield-stress",
    parameters: metal::J2.parameters,
    domain: "all J > 0, on monotonic, proportional paths from F = 1; tangent of continued loading, soft in other directions too, as at a vertex of a yield surface",
    source: "Stören and Rice, J. Mech. Phys. Solids 23 (1975) 421, and Hutchinson and Neale, in Mechanics of Sheet Metal Forming (1978) 127; defaults: typical of a mild steel, GPa",
    make: |p| coaxial(deformation_theory(p), 0.0),
    ..DRUCKER_PRAGER
};

/// Deformation theory from its parameters.
pub(in super::super) fn deformation_theory(
    p: &[f64],
) -> Result<DeformationTheory, PlasticityError> {
    DeformationTheory::new(elasticity(p), metal::strength(&p[2..]))
}

/// Multiple of the flow direction added per unit of slip `gamma` to the inelastic strain of the secant stiffness `G_s`. The strain at the strength
/// `k(gamma)` is `k/G + gamma`, so `m = 1 + k' (1/G - 1/G_s) = 1 - k' gamma / k`.
fn per_slip(hardening: &Hardening, slip: f64) -> f64 {
    1.0 - hardening.modulus(slip) * slip / hardening.strength(slip)
}

/// Ratio of stiffnesses `G_s / G = k / (k + G gamma)`.
fn remaining(hardening: &Hardening, slip: f64, shear: f64) -> f64 {
    let strength = hardening.strength(slip);
    strength / (strength + shear * slip)
}

/// J2 deformation theory: stress by total strain, `s = 2 G_s dev(e)`, with the secant shear modulus `1/G_s = 1/G + gamma/k(gamma)`.
///
/// Its rates are the rates of a law with the stiffness `G_s`, `K` that flows along `s/(2 tau)` with `1/h = 1/G_t - 1/G_s`, `1/G_t = 1/G + 1/k'`. It
/// is stiff along the stress and soft in other directions, like a yield surface with a vertex. Finite strains are logarithmic. Source: S. Stören and
/// J. R. Rice, *J. Mech. Phys. Solids* 23 (1975) 421; J. W. Hutchinson and K. W. Neale, in *Mechanics of Sheet Metal Forming* (1978) 127.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeformationTheory {
    elasticity: Elasticity,
    hardening: Hardening,
}

impl DeformationTheory {
    /// Creates the law. As for the von Mises law, `hardening` is the shear strength that follows from a tension test.
    ///
    /// # Errors
    /// [`PlasticityError::Parameter`] if the hardening parameters are not admissible.
    pub fn new(elasticity: Elasticity, hardening: Hardening) -> Result<Self, PlasticityError> {
        hardening.check()?;
        Ok(Self {
            elasticity,
            hardening,
        })
    }
}

impl FlowLaw for DeformationTheory {
    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }

    fn unloads(&self) -> bool {
        false
    }

    fn strength(&self) -> f64 {
        self.hardening.strength(0.0)
    }

    fn excess(&self, stress: &Vector3<f64>, slip: f64, _internal: &Vector3<f64>) -> f64 {
        parts(stress).2 - self.hardening.strength(slip)
    }

    fn flow(
        &self,
        stress: &Vector3<f64>,
        slip: f64,
        _internal: &Vector3<f64>,
    ) -> Result<Flow, PlasticityError> {
        self.hardening.not_exhausted(slip)?;
        let (normal, _) = direction(stress)?;
        let part = remaining(&self.hardening, slip, self.elasticity.shear);
        let secant = Elasticity {
            shear: part * self.elasticity.shear,
            ..self.elasticity
        };
        Ok(Flow {
            per_slip: per_slip(&self.hardening, slip),
            ..Flow::associated(secant, normal, self.hardening.modulus(slip))
        })
    }
}

/// Scalar damage: `sigma = (1 - D) C : e`, where `D` depends on the largest equivalent shear strain `sqrt(e : C : e / G)`.
///
/// The strain at the shear stress `k(gamma)` is `k/G + gamma`, so that `1 - D = k / (k + G gamma)`. The criterion is
/// `sqrt(G sigma : C^-1 : sigma) = k`, and inelastic strain is parallel to the strain. Sources: J. C. Simo and J. W. Ju, *Int. J. Solids Struct.* 23
/// (1987) 821 (damage by the energy norm), and for localization of laws of this form J. R. Rice, in *Theoretical and Applied Mechanics* (1976) 207.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScalarDamage {
    elasticity: Elasticity,
    hardening: Hardening,
}

impl ScalarDamage {
    /// Creates the law from its strength in shear.
    ///
    /// # Errors
    /// [`PlasticityError::Parameter`] if the hardening parameters are not admissible.
    pub fn new(elasticity: Elasticity, hardening: Hardening) -> Result<Self, PlasticityError> {
        hardening.check()?;
        Ok(Self {
            elasticity,
            hardening,
        })
    }

    /// Equivalent shear stress `sqrt(G sigma : C^-1 : sigma)`.
    fn equivalent(&self, stress: &Vector3<f64>) -> f64 {
        (self.elasticity.shear * stress.dot(&self.elasticity.strain(stress))).sqrt()
    }
}

impl FlowLaw for ScalarDamage {
    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }

    fn unloading(&self, slip: f64) -> Elasticity {
        let part = remaining(&self.hardening, slip, self.elasticity.shear);
        Elasticity {
            shear: part * self.elasticity.shear,
            bulk: part * self.elasticity.bulk,
        }
    }

    fn strength(&self) -> f64 {
        self.hardening.strength(0.0)
    }

    fn excess(&self, stress: &Vector3<f64>, slip: f64, _internal: &Vector3<f64>) -> f64 {
        self.equivalent(stress) - self.hardening.strength(slip)
    }

    fn flow(
        &self,
        stress: &Vector3<f64>,
        slip: f64,
        _internal: &Vector3<f64>,
    ) -> Result<Flow, PlasticityError> {
        self.hardening.not_exhausted(slip)?;
        let shear = self.elasticity.shear;
        let normal = self.elasticity.strain(stress) * (shear / self.equivalent(stress));
        let secant = self.unloading(slip);
        Ok(Flow {
            per_slip: per_slip(&self.hardening, slip),
            ..Flow::associated(secant, normal, self.hardening.modulus(slip))
        })
    }
}
