//! Von Mises law with kinematic hardening.

use super::super::coaxial::{KAPPA, MU, coaxial, elasticity};
use super::super::flow::{Elasticity, Flow, FlowLaw, direction, parts};
use super::super::law::DRUCKER_PRAGER;
use super::super::metal::{EXPONENT, MODULUS, RATE, REFERENCE, SATURATION, YIELD, strength};
use super::super::{Hardening, PlasticityError};
use crate::material::{Admitted, Law, Parameter};
use nalgebra::Vector3;

pub(in super::super) const KINEMATIC: Law = Law {
    name: "kinematic",
    formula: "Hencky's law with mu, kappa for the Kirchhoff stress T; x = dev T - a; sqrt(3/2) |x| = yield-stress (1 + e/reference-strain)^exponent + \
              hardening-modulus e + saturation-stress (1 - exp(-saturation-rate e)); associated flow; a' = 2/3 kinematic-modulus e_p' - recovery a e'",
    parameters: &[
        Parameter {
            default: 80_000.0,
            ..MU
        },
        Parameter {
            default: 170_000.0,
            ..KAPPA
        },
        Parameter {
            default: 400.0,
            ..YIELD
        },
        Parameter {
            default: 0.0,
            ..MODULUS
        },
        Parameter {
            default: -50.0,
            ..SATURATION
        },
        Parameter {
            default: 30.0,
            ..RATE
        },
        EXPONENT,
        REFERENCE,
        Parameter::new(
            "kinematic-modulus",
            "stress",
            600.0,
            Admitted::NotNegative,
            "slope of the back stress in tension, in addition to the flow stress",
        ),
        Parameter::new(
            "recovery",
            "1",
            1.0,
            Admitted::NotNegative,
            "recovery of the back stress, which tends to kinematic-modulus/recovery in tension; 0: no recovery",
        ),
    ],
    source: "Prager, J. Appl. Mech. 23 (1956) 493, with the recovery of Armstrong and Frederick (1966), Mater. High Temp. 24 (2007) 1; defaults: a steel, MPa",
    make: |p| coaxial(kinematic(p), 0.0),
    ..DRUCKER_PRAGER
};

/// The law from its parameters, which are measured in tension.
pub(in super::super) fn kinematic(p: &[f64]) -> Result<Kinematic, PlasticityError> {
    let (modulus, recovery) = (p[8] / 3.0, p[9] / 3.0_f64.sqrt());
    Kinematic::new(elasticity(p), modulus, recovery, strength(&p[2..]))
}

/// Kinematic hardening: `f = tau(sigma - alpha) - k(gamma)`, associated, with the back stress `alpha' = (2 c P - b alpha) gamma'`.
///
/// Without recovery `b` it is Prager's rule (W. Prager, *J. Appl. Mech.* 23 (1956) 493), with recovery the rule of C. O. Frederick and P. J.
/// Armstrong (report of 1966, *Mater. High Temp.* 24 (2007) 1). The plastic modulus is `h = dk/dgamma + c - b Q : alpha`. In pure shear the back
/// stress tends to `c/b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kinematic {
    elasticity: Elasticity,
    modulus: f64,
    recovery: f64,
    hardening: Hardening,
}

impl Kinematic {
    /// Creates the law from the kinematic modulus `c` (units of stress) and the recovery `b`, in addition to isotropic hardening.
    ///
    /// # Errors
    /// [`PlasticityError::Parameter`] unless both are nonnegative.
    pub fn new(
        elasticity: Elasticity,
        modulus: f64,
        recovery: f64,
        hardening: Hardening,
    ) -> Result<Self, PlasticityError> {
        for (name, value) in [("kinematic-modulus", modulus), ("recovery", recovery)] {
            PlasticityError::require(
                value >= 0.0,
                name,
                value,
                "zero or a positive finite number",
            )?;
        }
        hardening.check()?;
        Ok(Self {
            elasticity,
            modulus,
            recovery,
            hardening,
        })
    }
}

impl FlowLaw for Kinematic {
    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }

    fn strength(&self) -> f64 {
        self.hardening.strength(0.0)
    }

    fn start(&self, _stress: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        (Vector3::zeros(), Vector3::repeat(self.strength()))
    }

    fn excess(&self, stress: &Vector3<f64>, slip: f64, back: &Vector3<f64>) -> f64 {
        parts(&(stress - back)).2 - self.hardening.strength(slip)
    }

    fn flow(
        &self,
        stress: &Vector3<f64>,
        slip: f64,
        back: &Vector3<f64>,
    ) -> Result<Flow, PlasticityError> {
        self.hardening.not_exhausted(slip)?;
        let (normal, _) = direction(&(stress - back))?;
        let moved = normal * (2.0 * self.modulus) - back * self.recovery;
        let hardening = self.hardening.modulus(slip) + normal.dot(&moved);
        Ok(Flow {
            internal: moved,
            ..Flow::associated(self.elasticity, normal, hardening)
        })
    }
}
