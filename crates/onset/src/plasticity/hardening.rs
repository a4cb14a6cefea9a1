//! Hardening laws: flow stress or strength as a function of plastic strain.

use super::PlasticityError;

/// Flow stress of a metal as a function of its plastic strain,
///
/// `s(e) = initial (1 + e/reference)^exponent + modulus e + saturation (1 - exp(-rate e))`,
///
/// the sum of the laws of Swift (*J. Mech. Phys. Solids* 1 (1952) 1), linear hardening, and Voce (*J. Inst. Metals* 74 (1948) 537).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowStress {
    /// Flow stress at first yield.
    pub initial: f64,
    /// Exponent of the power law; 0 for none, negative for softening.
    pub exponent: f64,
    /// Reference strain of the power law.
    pub reference: f64,
    /// Slope at large plastic strain.
    pub modulus: f64,
    /// Increase by saturation, in addition to the other parts.
    pub saturation: f64,
    /// Reciprocal of the plastic strain after which 1/e of the saturation is left.
    pub rate: f64,
}

impl FlowStress {
    /// Flow stress that does not change.
    const fn constant(initial: f64) -> Self {
        Self {
            initial,
            exponent: 0.0,
            reference: 1.0,
            modulus: 0.0,
            saturation: 0.0,
            rate: 0.0,
        }
    }

    /// Flow stress `s(e)`. Units of stress.
    pub fn at(&self, strain: f64) -> f64 {
        self.initial * (1.0 + strain / self.reference).powf(self.exponent) + self.modulus * strain
            - self.saturation * (-self.rate * strain).exp_m1()
    }

    /// Slope `ds/de`. Units of stress.
    pub fn slope(&self, strain: f64) -> f64 {
        let power = self.exponent * (1.0 + strain / self.reference).powf(self.exponent - 1.0);
        self.initial / self.reference * power
            + self.modulus
            + self.saturation * self.rate * (-self.rate * strain).exp()
    }

    /// Lower bound of the slope at all strains, which is attained unless power law and saturation have different signs. Units of stress.
    pub(super) fn lowest_slope(&self) -> f64 {
        let power = self.initial / self.reference * self.exponent.min(0.0);
        self.modulus + power + (self.saturation * self.rate).min(0.0)
    }

    /// Strength in shear of a flow stress in tension by the von Mises criterion: stress `s/sqrt(3)` at the shear strain `sqrt(3) e`.
    pub fn in_shear(self) -> Self {
        let root = 3.0_f64.sqrt();
        Self {
            initial: self.initial / root,
            reference: self.reference * root,
            modulus: self.modulus / 3.0,
            saturation: self.saturation / root,
            rate: self.rate / root,
            ..self
        }
    }
}

/// Strength `k(gamma)`, the yield stress in pure shear, as a function of the plastic shear strain. Units of stress.
///
/// ```
/// use onset::plasticity::Hardening;
/// let law = Hardening::voce(2.0, 1.0, 0.1);
/// assert_eq!(law.strength(0.0), 2.0);
/// assert_eq!(law.modulus(0.0), -10.0);
/// assert!((law.strength(5.0) - 1.0).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hardening {
    /// Strength of a metal: its flow stress in shear.
    Metal(FlowStress),
    /// Hardening to a peak, then softening to a residual strength: `k = residual + (initial - residual + modulus gamma) exp(-gamma/reference)`.
    Peak {
        /// Strength at first yield.
        initial: f64,
        /// Strength after large slip.
        residual: f64,
        /// Hardening slope that the exponential reduces; negative for additional softening.
        modulus: f64,
        /// Slip over which the exponential falls by the factor `1/e`.
        reference: f64,
    },
}

impl Hardening {
    /// Linear hardening `k = initial + modulus gamma`. With softening the strength vanishes at a finite slip.
    pub const fn linear(initial: f64, modulus: f64) -> Self {
        Self::Metal(FlowStress {
            modulus,
            ..FlowStress::constant(initial)
        })
    }

    /// Voce hardening `k = saturation + (initial - saturation) exp(-gamma/reference)`, with the strength `saturation` after large slip.
    pub const fn voce(initial: f64, saturation: f64, reference: f64) -> Self {
        Self::Metal(FlowStress {
            saturation: saturation - initial,
            rate: 1.0 / reference,
            ..FlowStress::constant(initial)
        })
    }

    /// Power-law hardening `k = initial (1 + gamma/reference)^exponent`.
    pub const fn power(initial: f64, reference: f64, exponent: f64) -> Self {
        Self::Metal(FlowStress {
            exponent,
            reference,
            ..FlowStress::constant(initial)
        })
    }

    /// Checks that the parameters are admissible.
    pub(in crate::plasticity) fn check(&self) -> Result<(), PlasticityError> {
        let require = PlasticityError::require;
        let positive =
            |name, value: f64| require(value > 0.0, name, value, "a positive finite number");
        match *self {
            Self::Metal(FlowStress {
                initial,
                exponent,
                reference,
                modulus,
                saturation,
                rate,
            }) => {
                positive("yield-stress", initial)?;
                require(
                    exponent <= 1.0,
                    "exponent",
                    exponent,
                    "a number of at most 1, negative for softening",
                )?;
                positive("reference-strain", reference)?;
                let any = "a finite number, negative for softening";
                require(true, "hardening-modulus", modulus, any)?;
                require(true, "saturation-stress", saturation, any)?;
                let expected = "zero or a positive finite number";
                require(rate >= 0.0, "saturation-rate", rate, expected)
            }
            Self::Peak {
                initial,
                residual,
                modulus,
                reference,
            } => {
                positive("strength", initial)?;
                let expected = "zero or a positive finite number";
                require(residual >= 0.0, "residual", residual, expected)?;
                let any = "a finite number, negative for softening";
                require(true, "hardening-modulus", modulus, any)?;
                positive("reference-slip", reference)
            }
        }
    }

    /// Strength `k(gamma)`. Units of stress.
    pub fn strength(&self, slip: f64) -> f64 {
        match *self {
            Self::Metal(flow_stress) => flow_stress.at(slip),
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
            Self::Metal(flow_stress) => flow_stress.slope(slip),
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

    /// Lower bound of the plastic modulus over all slips, or zero if it is positive everywhere. Units of stress.
    pub fn lowest_modulus(&self) -> f64 {
        let lowest = self.modulus(0.0).min(0.0);
        match *self {
            Self::Metal(flow_stress) => flow_stress.lowest_slope().min(0.0),
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
            Self::Peak { .. } => lowest,
        }
    }
}
