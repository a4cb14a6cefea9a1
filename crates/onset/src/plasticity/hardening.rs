//! Hardening laws: strength as a function of plastic shear strain.

use super::PlasticityError;

/// Strength `k(gamma)`, the yield stress in pure shear, as a function of the plastic shear strain. Units of stress.
///
/// ```
/// use onset::plasticity::Hardening;
/// let law = Hardening::Voce { initial: 2.0, saturation: 1.0, reference: 0.1 };
/// assert_eq!(law.strength(0.0), 2.0);
/// assert_eq!(law.modulus(0.0), -10.0);
/// assert!((law.strength(5.0) - 1.0).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hardening {
    /// Linear hardening `k = initial + modulus gamma`. With softening the strength vanishes at a finite slip.
    Linear {
        /// Strength at first yield.
        initial: f64,
        /// Constant plastic modulus `h`.
        modulus: f64,
    },
    /// Voce hardening `k = saturation + (initial - saturation) exp(-gamma/reference)`: hardens or softens toward a limit (E. Voce, *J. Inst. Metals*
    /// 74 (1948) 537).
    Voce {
        /// Strength at first yield.
        initial: f64,
        /// Strength after large slip.
        saturation: f64,
        /// Slip over which the difference falls by the factor `1/e`.
        reference: f64,
    },
    /// Power-law hardening `k = initial (1 + gamma/reference)^exponent`.
    Power {
        /// Strength at first yield.
        initial: f64,
        /// Reference slip of the power law.
        reference: f64,
        /// Hardening exponent; negative for softening.
        exponent: f64,
    },
    /// Hardening to a peak, then softening to a residual strength: `k = residual + (initial - residual + modulus gamma) exp(-gamma/reference)`.
    Peak {
        /// Strength at first yield.
        initial: f64,
        /// Strength after large slip.
        residual: f64,
        /// Hardening slope that the exponential reduces.
        modulus: f64,
        /// Slip over which the exponential falls by the factor `1/e`.
        reference: f64,
    },
}

impl Hardening {
    /// Checks that the parameters are admissible.
    pub(in crate::plasticity) fn check(&self) -> Result<(), PlasticityError> {
        let positive = |name, value: f64| {
            PlasticityError::require(value > 0.0, name, value, "a positive finite number")
        };
        let not_negative = |name, value: f64| {
            PlasticityError::require(
                value >= 0.0,
                name,
                value,
                "zero or a positive finite number",
            )
        };
        positive("strength", self.strength(0.0))?;
        match *self {
            Self::Linear { modulus, .. } => PlasticityError::require(
                true,
                "hardening-modulus",
                modulus,
                "a finite number, negative for softening",
            ),
            Self::Voce {
                saturation,
                reference,
                ..
            } => {
                not_negative("saturation", saturation)?;
                positive("reference-slip", reference)
            }
            Self::Power {
                reference,
                exponent,
                ..
            } => {
                positive("reference-slip", reference)?;
                PlasticityError::require(
                    exponent <= 1.0,
                    "exponent",
                    exponent,
                    "a number of at most 1, negative for softening",
                )
            }
            Self::Peak {
                residual,
                modulus,
                reference,
                ..
            } => {
                not_negative("residual", residual)?;
                not_negative("hardening-modulus", modulus)?;
                positive("reference-slip", reference)
            }
        }
    }

    /// Strength `k(gamma)`. Units of stress.
    pub fn strength(&self, slip: f64) -> f64 {
        match *self {
            Self::Linear { initial, modulus } => initial + modulus * slip,
            Self::Voce {
                initial,
                saturation,
                reference,
            } => saturation + (initial - saturation) * (-slip / reference).exp(),
            Self::Power {
                initial,
                reference,
                exponent,
            } => initial * (1.0 + slip / reference).powf(exponent),
            Self::Peak {
                initial,
                residual,
                modulus,
                reference,
            } => residual + (initial - residual + modulus * slip) * (-slip / reference).exp(),
        }
    }

    /// Plastic modulus `h = dk/dgamma`. Units of stress.
    pub fn modulus(&self, slip: f64) -> f64 {
        match *self {
            Self::Linear { modulus, .. } => modulus,
            Self::Voce {
                initial,
                saturation,
                reference,
            } => (saturation - initial) / reference * (-slip / reference).exp(),
            Self::Power {
                initial,
                reference,
                exponent,
            } => initial * exponent / reference * (1.0 + slip / reference).powf(exponent - 1.0),
            Self::Peak {
                initial,
                residual,
                modulus,
                reference,
            } => {
                (modulus - (initial - residual + modulus * slip) / reference)
                    * (-slip / reference).exp()
            }
        }
    }

    /// Smallest plastic modulus over all slips, or zero if it is positive everywhere. Units of stress.
    pub fn lowest_modulus(&self) -> f64 {
        let lowest = self.modulus(0.0).min(0.0);
        match *self {
            // The slope of the modulus vanishes at `initial - residual + modulus gamma = 2 modulus reference`.
            Self::Peak {
                initial,
                residual,
                modulus,
                reference,
            } if modulus > 0.0 => {
                let steepest = 2.0 * reference - (initial - residual) / modulus;
                lowest.min(self.modulus(steepest.max(0.0)))
            }
            _ => lowest,
        }
    }
}
