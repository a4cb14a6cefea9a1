//! Mohr-Coulomb law, with Tresca as its frictionless case.

use super::super::coaxial::{
    CONFINEMENT, KAPPA, MODULUS, MU, RESIDUAL, SLIP, STRENGTH, coaxial, elasticity, hardening,
};
use super::super::flow::{Elasticity, Flow, FlowLaw};
use super::super::law::DRUCKER_PRAGER;
use super::super::{Hardening, PlasticityError};
use crate::algebra::Each;
use crate::material::{Admitted, Law, Parameter};
use nalgebra::Vector3;

pub(in super::super) const MOHR_COULOMB: Law = Law {
    name: "mohr-coulomb",
    formula: "Hencky's law with mu, kappa for the Kirchhoff stress T; (T1 - T3)/2 + (T1 + T3)/2 sin(friction-angle) = k(g) with the largest and the smallest \
              principal value of T, k = c cos(friction-angle) with the cohesion c at first; flow along the derivative of the same function of the \
              dilation-angle; k = residual + (strength - residual + hardening-modulus g) exp(-g/reference-slip)",
    parameters: &[
        MU,
        KAPPA,
        Parameter::new(
            "friction-angle",
            "deg",
            30.0,
            Admitted::Within(0.0, 89.0),
            "angle of friction",
        ),
        Parameter::new(
            "dilation-angle",
            "deg",
            10.0,
            Admitted::Within(-89.0, 89.0),
            "dilation angle of the flow; equal to the friction angle for associated flow",
        ),
        STRENGTH,
        RESIDUAL,
        MODULUS,
        SLIP,
        CONFINEMENT,
    ],
    domain: "all J > 0, on monotonic, proportional paths from F = 1 along which no two of the extreme and the intermediate principal stress become equal during flow; tangent of \
             continued flow",
    source: "Mohr-Coulomb in the form of Vermeer and de Borst, Heron 29(3) (1984); defaults: typical of a soft rock, MPa",
    make: |p| coaxial(mohr_coulomb(p), p[8]),
    ..DRUCKER_PRAGER
};

/// The law from its parameters.
pub(in super::super) fn mohr_coulomb(p: &[f64]) -> Result<MohrCoulomb, PlasticityError> {
    MohrCoulomb::new(elasticity(p), p[2], p[3], hardening(&p[4..]))
}

/// Mohr-Coulomb law: `f = (sigma_1 - sigma_3)/2 + (sigma_1 + sigma_3)/2 sin(phi) - k(gamma)`, `k = c cos(phi)`.
///
/// The principal stresses are sorted, `sigma_1 >= sigma_2 >= sigma_3`, tension positive. The plastic potential has the form of `f` with the dilation
/// angle `psi` in place of `phi`.
///
/// Source: P. A. Vermeer and R. de Borst, *Heron* 29(3) (1984), for this form. If two principal stresses are equal at first yield (triaxial
/// compression), both faces of the corner flow equally. If the intermediate stress later becomes equal to the largest or the smallest stress, the
/// path ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MohrCoulomb {
    elasticity: Elasticity,
    sine_of_friction: f64,
    sine_of_dilation: f64,
    hardening: Hardening,
}

/// Largest relative difference of principal stresses that count as equal.
const STRESS_TOLERANCE: f64 = 1e-9;

impl MohrCoulomb {
    /// Creates the law; angles are in degrees.
    ///
    /// # Errors
    /// [`PlasticityError::Parameter`] unless `0 <= phi < 90`, `-90 < psi < 90`, and the hardening parameters are admissible.
    pub fn new(
        elasticity: Elasticity,
        friction_angle: f64,
        dilation_angle: f64,
        hardening: Hardening,
    ) -> Result<Self, PlasticityError> {
        PlasticityError::require(
            (0.0..90.0).contains(&friction_angle),
            "friction-angle",
            friction_angle,
            "degrees from 0 to less than 90",
        )?;
        PlasticityError::require(
            dilation_angle.abs() < 90.0,
            "dilation-angle",
            dilation_angle,
            "degrees above -90 and below 90",
        )?;
        hardening.check()?;
        Ok(Self {
            elasticity,
            sine_of_friction: friction_angle.to_radians().sin(),
            sine_of_dilation: dilation_angle.to_radians().sin(),
            hardening,
        })
    }

    /// Weights of the axes in the largest and in the smallest principal stress. Axes with equal stresses have equal weights.
    fn shares(stress: &Vector3<f64>) -> [Vector3<f64>; 2] {
        let size = STRESS_TOLERANCE * stress.amax();
        [stress.max(), stress.min()].each(|extreme| {
            let own = stress.map(|s| f64::from(u8::from((s - extreme).abs() <= size)));
            own / own.sum()
        })
    }

    fn gradient(shares: &[Vector3<f64>; 2], sine: f64) -> Vector3<f64> {
        (shares[0] * (1.0 + sine) - shares[1] * (1.0 - sine)) * 0.5
    }
}

impl FlowLaw for MohrCoulomb {
    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }

    fn strength(&self) -> f64 {
        self.hardening.strength(0.0)
    }

    /// Weights of the axes in the largest and the smallest stress. They select the faces that flow, which remain the same along a path.
    fn start(&self, stress: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let [largest, smallest] = Self::shares(stress);
        (largest - smallest, Vector3::repeat(1.0))
    }

    fn faces(&self, internal: &Vector3<f64>) -> usize {
        let count = |sign: f64| internal.iter().filter(|x| **x * sign > 0.0).count();
        count(1.0) * count(-1.0)
    }

    fn excess(&self, stress: &Vector3<f64>, slip: f64, _internal: &Vector3<f64>) -> f64 {
        let (largest, smallest) = (stress.max(), stress.min());
        0.5 * (largest - smallest) + 0.5 * (largest + smallest) * self.sine_of_friction
            - self.hardening.strength(slip)
    }

    fn flow(
        &self,
        stress: &Vector3<f64>,
        slip: f64,
        internal: &Vector3<f64>,
    ) -> Result<Flow, PlasticityError> {
        self.hardening.not_exhausted(slip)?;
        let shares = [
            internal.map(|x| x.max(0.0)),
            internal.map(|x| (-x).max(0.0)),
        ];
        let size = 1e3 * STRESS_TOLERANCE * stress.amax();
        if stress.max() - stress.min() <= size {
            return Err(PlasticityError::NoDeviator);
        }
        // An axis with the intermediate stress must keep it.
        let [largest, smallest] = [0, 1].each(|n: usize| shares[n].dot(stress));
        if stress.max() > largest + size || stress.min() < smallest - size {
            return Err(PlasticityError::Corner);
        }
        Ok(Flow {
            direction: Self::gradient(&shares, self.sine_of_dilation),
            ..Flow::associated(
                self.elasticity,
                Self::gradient(&shares, self.sine_of_friction),
                self.hardening.modulus(slip),
            )
        })
    }
}
