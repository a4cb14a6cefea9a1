//! Gurson's law of porous metals.

use super::super::coaxial::{KAPPA, MU, coaxial, elasticity};
use super::super::flow::{Elasticity, Flow, FlowLaw, direction, parts};
use super::super::law::DRUCKER_PRAGER;
use super::super::metal::{EXPONENT, MODULUS, RATE, REFERENCE, SATURATION, YIELD, strength};
use super::super::{Hardening, PlasticityError};
use crate::material::{Admitted, Law, Parameter};
use nalgebra::Vector3;

pub(in super::super) const GURSON: Law = Law {
    name: "gurson",
    formula: "Hencky's law with mu, kappa for the Kirchhoff stress T; (q/q0)^2 + 2 q1 f cosh(3 q2 tr(T)/(6 q0)) = 1 + (q1 f)^2, q^2 = 3/2 s:s, s = dev T, \
              q0 = yield-stress (1 + e/reference-strain)^exponent + hardening-modulus e + saturation-stress (1 - exp(-saturation-rate e)); associated flow; \
              f' = (1 - f) tr(e_p'), (1 - f) q0 e' = T : e_p'",
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
            meaning: "flow stress of the matrix at first yield, in tension",
            ..YIELD
        },
        Parameter {
            default: 0.0,
            ..MODULUS
        },
        Parameter {
            default: 400.0,
            ..SATURATION
        },
        Parameter {
            default: 5.0,
            ..RATE
        },
        EXPONENT,
        REFERENCE,
        Parameter::new(
            "voids",
            "1",
            0.01,
            Admitted::Fraction,
            "volume fraction of voids at first yield",
        ),
        Parameter::new(
            "q1",
            "1",
            1.5,
            Admitted::Positive,
            "Tvergaard's constant q1; 1 for Gurson's law as published",
        ),
        Parameter::new(
            "q2",
            "1",
            1.0,
            Admitted::Positive,
            "Tvergaard's constant q2",
        ),
    ],
    source: "Gurson, J. Eng. Mater. Technol. 99 (1977) 2, with the constants of Tvergaard, Int. J. Fract. 17 (1981) 389; defaults: typical of a mild steel, MPa",
    make: |p| coaxial(gurson(p), 0.0),
    ..DRUCKER_PRAGER
};

/// The law from its parameters.
pub(in super::super) fn gurson(p: &[f64]) -> Result<Gurson, PlasticityError> {
    Gurson::new(elasticity(p), p[8], [p[9], p[10]], strength(&p[2..]))
}

/// Gurson's law: `(s_e/s_0)^2 + 2 q1 f cosh(3 q2 sigma_m / (2 s_0)) - 1 - (q1 f)^2 = 0`, associated.
///
/// Here `s_e = sqrt(3) tau`, and `s_0 = sqrt(3) k` is the flow stress of the matrix. Voids grow with the plastic volume, `f' = (1 - f) tr(e_p')`, and
/// the matrix hardens with the plastic work, `(1 - f) k gamma_m' = sigma : e_p'`. Nucleation and coalescence are not included. Source: A. L. Gurson,
/// *J. Eng. Mater. Technol.* 99 (1977) 2, with the constants of V. Tvergaard, *Int. J. Fract.* 17 (1981) 389; in the form of Rudnicki and Rice by H.
/// Yamamoto, *Int. J. Fract.* 14 (1978) 347. Flow is measured by `P = s/(2 tau) + beta/3 1`,
/// `beta = q1 q2 f s_0 sinh(3 q2 sigma_m / (2 s_0)) / (2 tau)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gurson {
    elasticity: Elasticity,
    voids: f64,
    q: [f64; 2],
    hardening: Hardening,
}

impl Gurson {
    /// Creates the law from the volume fraction of voids at first yield, `[q1, q2]`, and the strength of the matrix.
    ///
    /// # Errors
    /// [`PlasticityError::Parameter`] unless `0 <= f`, `q1 f < 1`, and `q1`, `q2` are positive.
    pub fn new(
        elasticity: Elasticity,
        voids: f64,
        q: [f64; 2],
        hardening: Hardening,
    ) -> Result<Self, PlasticityError> {
        for (name, value) in [("q1", q[0]), ("q2", q[1])] {
            PlasticityError::require(value > 0.0, name, value, "a positive finite number")?;
        }
        PlasticityError::require(
            voids >= 0.0 && q[0] * voids < 1.0,
            "voids",
            voids,
            "a volume fraction of at least 0 and below 1/q1",
        )?;
        hardening.check()?;
        Ok(Self {
            elasticity,
            voids,
            q,
            hardening,
        })
    }

    /// Weakening by voids, `2 q1 f cosh x - (q1 f)^2`, with `x`.
    fn weakening(&self, mean: f64, flow_stress: f64, voids: f64) -> (f64, f64) {
        let x = 1.5 * self.q[1] * mean / flow_stress;
        let part = self.q[0] * voids;
        (2.0 * part * x.cosh() - part * part, x)
    }
}

impl FlowLaw for Gurson {
    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }

    fn strength(&self) -> f64 {
        self.hardening.strength(0.0)
    }

    /// Slip of the matrix and volume fraction of voids at first yield.
    fn start(&self, _stress: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let strain = self.strength() / self.elasticity.shear;
        (
            Vector3::new(0.0, self.voids, 0.0),
            Vector3::new(strain, strain, 1.0),
        )
    }

    fn excess(&self, stress: &Vector3<f64>, _slip: f64, internal: &Vector3<f64>) -> f64 {
        let (mean, _, shear) = parts(stress);
        let strength = self.hardening.strength(internal[0]);
        let flow_stress = 3.0_f64.sqrt() * strength;
        let (weakening, _) = self.weakening(mean, flow_stress, internal[1]);
        0.5 * strength * ((shear / strength).powi(2) + weakening - 1.0)
    }

    fn flow(
        &self,
        stress: &Vector3<f64>,
        _slip: f64,
        internal: &Vector3<f64>,
    ) -> Result<Flow, PlasticityError> {
        let (matrix, voids) = (internal[0], internal[1]);
        self.hardening.not_exhausted(matrix)?;
        let [q1, q2] = self.q;
        if q1 * voids >= 1.0 || voids >= 1.0 {
            return Err(PlasticityError::Exhausted { slip: matrix });
        }
        let (unit, shear) = direction(stress)?;
        let (mean, _, _) = parts(stress);
        let strength = self.hardening.strength(matrix);
        let flow_stress = 3.0_f64.sqrt() * strength;
        let (_, x) = self.weakening(mean, flow_stress, voids);
        // The gradient with respect to the stress is 6 tau / s_0^2 times this normal.
        let dilatancy = 0.5 * q1 * q2 * voids * flow_stress * x.sinh() / shear;
        let normal = unit + Vector3::repeat(dilatancy / 3.0);
        let scale = 6.0 * shear / (flow_stress * flow_stress);
        let matrix_rate = stress.dot(&normal) / ((1.0 - voids) * strength);
        let voids_rate = (1.0 - voids) * dilatancy;
        let by_flow_stress = -6.0 * shear * shear / flow_stress.powi(3)
            - 2.0 * q1 * voids * x.sinh() * x / flow_stress;
        let by_voids = 2.0 * q1 * x.cosh() - 2.0 * q1 * q1 * voids;
        let flow_stress_rate = 3.0_f64.sqrt() * self.hardening.modulus(matrix) * matrix_rate;
        let hardening = -(by_flow_stress * flow_stress_rate + by_voids * voids_rate) / scale;
        Ok(Flow {
            internal: Vector3::new(matrix_rate, voids_rate, 0.0),
            ..Flow::associated(self.elasticity, normal, hardening)
        })
    }
}
