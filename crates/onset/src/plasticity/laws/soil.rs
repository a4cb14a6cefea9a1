//! Laws that harden by compaction: modified Cam-clay and an elliptic cap.

use super::super::PlasticityError;
use super::super::coaxial::{CONFINEMENT, KAPPA, MU, STRENGTH, coaxial, elasticity};
use super::super::flow::{Elasticity, Flow, FlowLaw, direction, parts};
use super::super::law::DRUCKER_PRAGER;
use crate::material::{Admitted, Law, Parameter};
use nalgebra::Vector3;

const PRECONSOLIDATION: Parameter = Parameter::new(
    "preconsolidation",
    "stress",
    100.0,
    Admitted::Positive,
    "pressure at which the material yields without shear at first; it grows with compaction",
);
const COMPRESSIBILITY: Parameter = Parameter::new(
    "compressibility",
    "1",
    0.05,
    Admitted::Positive,
    "plastic compaction over which the preconsolidation grows by the factor e; (lambda - kappa)/(1 + e) of soil mechanics",
);

pub(in super::super) const CAM_CLAY: Law = Law {
    name: "cam-clay",
    formula: "Hencky's law with mu, kappa for the Kirchhoff stress T; q^2/critical-slope^2 + p (p - pc) = 0, q^2 = 3/2 s:s, s = dev T, p = -tr(T)/3; associated flow; \
              pc = preconsolidation exp(c/compressibility), c the plastic compaction",
    parameters: &[
        MU,
        KAPPA,
        Parameter::new(
            "critical-slope",
            "1",
            1.0,
            Admitted::Positive,
            "slope M of the critical state line, q = M p",
        ),
        PRECONSOLIDATION,
        COMPRESSIBILITY,
        Parameter {
            default: 50.0,
            ..CONFINEMENT
        },
    ],
    stressed_reference: Some("the confinement"),
    source: "Roscoe and Burland, in Engineering Plasticity (1968) 535, with constant moduli; defaults: a stiff clay in units of a hundredth of its preconsolidation pressure",
    make: |p| coaxial(cam_clay(p), p[5]),
    ..DRUCKER_PRAGER
};

/// Cam-clay from its parameters.
pub(in super::super) fn cam_clay(p: &[f64]) -> Result<CamClay, PlasticityError> {
    CamClay::new(elasticity(p), p[2], p[3], p[4])
}

pub(in super::super) const CAP: Law = Law {
    name: "cap",
    formula: "Hencky's law with mu, kappa for the Kirchhoff stress T; (max(p - cap-start, 0)/(X - cap-start))^2 + (tau/strength)^2 = 1, tau = sqrt(s:s/2), s = dev T, \
              p = -tr(T)/3; associated flow; X = preconsolidation exp(c/compressibility), c the plastic compaction",
    parameters: &[
        MU,
        KAPPA,
        STRENGTH,
        Parameter::new(
            "cap-start",
            "stress",
            20.0,
            Admitted::NotNegative,
            "pressure at which the cap begins",
        ),
        PRECONSOLIDATION,
        COMPRESSIBILITY,
        CONFINEMENT,
    ],
    source: "ellipse of Rudnicki, J. Geophys. Res. 109 (2004) B03402, after DiMaggio and Sandler, J. Eng. Mech. Div. ASCE 97 (1971) 935; defaults: typical of a porous \
             sandstone, MPa",
    make: |p| coaxial(cap(p), p[6]),
    ..DRUCKER_PRAGER
};

/// The cap from its parameters.
pub(in super::super) fn cap(p: &[f64]) -> Result<EllipticCap, PlasticityError> {
    EllipticCap::new(elasticity(p), p[2], [p[3], p[4]], p[5])
}

/// Growth of the compaction pressure: `p_c' = p_c (-tr e_p') / c`, with `c = (lambda - kappa)/(1 + e)` of soil mechanics.
fn growth(pressure: f64, compressibility: f64, dilatancy: f64) -> f64 {
    -pressure * dilatancy / compressibility
}

fn positive(name: &'static str, value: f64) -> Result<(), PlasticityError> {
    PlasticityError::require(value > 0.0, name, value, "a positive finite number")
}

/// Modified Cam-clay with constant elastic moduli: `q^2/M^2 + p (p - p_c) = 0`, associated, `q = sqrt(3) tau`, `p = -sigma_m`.
///
/// Source: K. H. Roscoe and J. B. Burland, in *Engineering Plasticity* (1968) 535. Flow is measured by `P = s/(2 tau) + beta/3 1`,
/// `beta = -(2 p - p_c) M^2 / (6 tau)`. At the critical state `p = p_c/2` the plastic modulus vanishes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CamClay {
    elasticity: Elasticity,
    slope: f64,
    preconsolidation: f64,
    compressibility: f64,
}

impl CamClay {
    /// Creates the law from the slope `M` of the critical state line, the pressure `p_c` at first yield and the compressibility
    /// `(lambda - kappa)/(1 + e)`.
    ///
    /// # Errors
    /// [`PlasticityError::Parameter`] unless all are positive.
    pub fn new(
        elasticity: Elasticity,
        slope: f64,
        preconsolidation: f64,
        compressibility: f64,
    ) -> Result<Self, PlasticityError> {
        positive("critical-slope", slope)?;
        positive("preconsolidation", preconsolidation)?;
        positive("compressibility", compressibility)?;
        Ok(Self {
            elasticity,
            slope,
            preconsolidation,
            compressibility,
        })
    }
}

impl FlowLaw for CamClay {
    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }

    fn strength(&self) -> f64 {
        0.5 * self.slope * self.preconsolidation / 3.0_f64.sqrt()
    }

    fn start(&self, _stress: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let own = Vector3::new(self.preconsolidation, 0.0, 0.0);
        (own, Vector3::repeat(self.preconsolidation))
    }

    fn excess(&self, stress: &Vector3<f64>, _slip: f64, internal: &Vector3<f64>) -> f64 {
        let (mean, _, shear) = parts(stress);
        let pressure = -mean;
        (3.0 * (shear / self.slope).powi(2) + pressure * (pressure - internal[0])) / internal[0]
    }

    fn flow(
        &self,
        stress: &Vector3<f64>,
        _slip: f64,
        internal: &Vector3<f64>,
    ) -> Result<Flow, PlasticityError> {
        let (unit, shear) = direction(stress)?;
        let (mean, _, _) = parts(stress);
        let (pressure, limit) = (-mean, internal[0]);
        let square = self.slope * self.slope;
        let dilatancy = -(2.0 * pressure - limit) * square / (6.0 * shear);
        let normal = unit + Vector3::repeat(dilatancy / 3.0);
        let rate = growth(limit, self.compressibility, dilatancy);
        // The gradient with respect to the stress is 6 tau / M^2 times the normal, the gradient with respect to p_c is -p.
        let hardening = pressure * rate * square / (6.0 * shear);
        Ok(Flow {
            internal: Vector3::new(rate, 0.0, 0.0),
            ..Flow::associated(self.elasticity, normal, hardening)
        })
    }
}

/// Shear strength with an elliptic cap that expands during compaction, associated.
///
/// The yield surface is `((p - L)/(X - L))^2 + (tau/k)^2 - 1 = 0` for `p >= L`, and `tau = k` for smaller pressures. Source: the ellipse of J. W.
/// Rudnicki, *J. Geophys. Res.* 109 (2004) B03402, for compaction bands, after the caps of F. L. DiMaggio and I. S. Sandler, *J. Eng. Mech. Div.
/// ASCE* 97 (1971) 935. Flow is measured by `P = s/(2 tau) + beta/3 1`, `beta = -(p - L) k^2 / (tau (X - L)^2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EllipticCap {
    elasticity: Elasticity,
    strength: f64,
    start: f64,
    end: f64,
    compressibility: f64,
}

impl EllipticCap {
    /// Creates the law from the shear strength `k`, the pressures `[L, X]` at the two ends of the cap, and the compressibility.
    ///
    /// # Errors
    /// [`PlasticityError::Parameter`] unless all except `L` are positive, `L` is nonnegative, and `X > L`.
    pub fn new(
        elasticity: Elasticity,
        strength: f64,
        [start, end]: [f64; 2],
        compressibility: f64,
    ) -> Result<Self, PlasticityError> {
        positive("strength", strength)?;
        PlasticityError::require(
            start >= 0.0,
            "cap-start",
            start,
            "zero or a positive pressure",
        )?;
        PlasticityError::require(
            end > start,
            "preconsolidation",
            end,
            "a pressure above cap-start",
        )?;
        positive("compressibility", compressibility)?;
        Ok(Self {
            elasticity,
            strength,
            start,
            end,
            compressibility,
        })
    }

    /// Pressure in excess of `L` on the cap, otherwise zero.
    fn beyond(&self, mean: f64) -> f64 {
        (-mean - self.start).max(0.0)
    }
}

impl FlowLaw for EllipticCap {
    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }

    fn strength(&self) -> f64 {
        self.strength
    }

    fn start(&self, _stress: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        (Vector3::new(self.end, 0.0, 0.0), Vector3::repeat(self.end))
    }

    fn excess(&self, stress: &Vector3<f64>, _slip: f64, internal: &Vector3<f64>) -> f64 {
        let (mean, _, shear) = parts(stress);
        let part = self.beyond(mean) / (internal[0] - self.start);
        0.5 * self.strength * (part * part + (shear / self.strength).powi(2) - 1.0)
    }

    fn flow(
        &self,
        stress: &Vector3<f64>,
        _slip: f64,
        internal: &Vector3<f64>,
    ) -> Result<Flow, PlasticityError> {
        let (unit, shear) = direction(stress)?;
        let (mean, _, _) = parts(stress);
        let (beyond, width) = (self.beyond(mean), internal[0] - self.start);
        let square = self.strength * self.strength;
        let dilatancy = -beyond * square / (shear * width * width);
        let normal = unit + Vector3::repeat(dilatancy / 3.0);
        let rate = growth(internal[0], self.compressibility, dilatancy);
        // The gradient with respect to the stress is 2 tau / k^2 times the normal, the gradient with respect to X is -2 (p - L)^2 / (X - L)^3.
        let hardening = beyond * beyond * rate * square / (shear * width.powi(3));
        Ok(Flow {
            internal: Vector3::new(rate, 0.0, 0.0),
            ..Flow::associated(self.elasticity, normal, hardening)
        })
    }
}
