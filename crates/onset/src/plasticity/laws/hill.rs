//! Hill's orthotropic yield criterion of 1948.

use super::super::flow::{Elasticity, Flow, FlowLaw};
use super::super::{Hardening, PlasticityError};
use crate::algebra::array_of;
use nalgebra::Vector3;

/// Hill's law: `f = sqrt((F (s2 - s3)^2 + G (s3 - s1)^2 + H (s1 - s2)^2) / 3) - k(gamma)`, `G + H = 1`, associated.
///
/// The axes of orthotropy coincide with the axes of the path. `F`, `G`, `H` follow from the ratios `r0 = H/G` and `r90 = H/F` of width to thickness
/// strain in tension along axes 1 and 2, with axis 3 normal to the sheet. If both are 1, it is the von Mises law. The yield stress in tension along
/// axis 1 is `sqrt(3) k`. Source: R. Hill, *Proc. R. Soc. London A* 193 (1948) 281. His fourth constant, for shear in the sheet, has no effect on
/// states along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HillOrthotropic {
    elasticity: Elasticity,
    /// Hill's constants `F`, `G`, `H`.
    constants: [f64; 3],
    hardening: Hardening,
}

impl HillOrthotropic {
    /// Creates the law from the strain ratios `r0` and `r90`.
    ///
    /// # Errors
    /// [`PlasticityError::Parameter`] unless both are positive.
    pub fn new(
        elasticity: Elasticity,
        r0: f64,
        r90: f64,
        hardening: Hardening,
    ) -> Result<Self, PlasticityError> {
        for (name, value) in [("r0", r0), ("r90", r90)] {
            PlasticityError::require(value > 0.0, name, value, "a positive finite number")?;
        }
        hardening.check()?;
        let h = r0 / (1.0 + r0);
        Ok(Self {
            elasticity,
            constants: [h / r90, 1.0 / (1.0 + r0), h],
            hardening,
        })
    }

    /// Products `[F (s2 - s3), G (s3 - s1), H (s1 - s2)]` and the equivalent shear stress.
    fn differences(&self, s: &Vector3<f64>) -> ([f64; 3], f64) {
        let differences = [s[1] - s[2], s[2] - s[0], s[0] - s[1]];
        let weighted: [f64; 3] = array_of(|n| self.constants[n] * differences[n]);
        let sum: f64 = weighted.iter().zip(&differences).map(|(a, b)| a * b).sum();
        (weighted, (sum / 3.0).sqrt())
    }
}

impl FlowLaw for HillOrthotropic {
    fn elasticity(&self) -> Elasticity {
        self.elasticity
    }

    fn strength(&self) -> f64 {
        self.hardening.strength(0.0)
    }

    fn excess(&self, stress: &Vector3<f64>, slip: f64, _internal: &Vector3<f64>) -> f64 {
        self.differences(stress).1 - self.hardening.strength(slip)
    }

    fn flow(
        &self,
        stress: &Vector3<f64>,
        slip: f64,
        _internal: &Vector3<f64>,
    ) -> Result<Flow, PlasticityError> {
        self.hardening.not_exhausted(slip)?;
        let ([f, g, h], shear) = self.differences(stress);
        if shear <= 1e-14 * stress.amax() {
            return Err(PlasticityError::NoDeviator);
        }
        let normal = Vector3::new(h - g, f - h, g - f) / (3.0 * shear);
        Ok(Flow::associated(
            self.elasticity,
            normal,
            self.hardening.modulus(slip),
        ))
    }
}
