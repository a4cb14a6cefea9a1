//! Library of laws, each described in one place together with its formula.

use super::laws::LIBRARY;
use super::{Hyperelastic, MaterialError, StrainEnergy};
use crate::algebra::array_of;

/// Admissible values of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Admitted {
    /// All numbers up to the largest magnitude of the unit: 1e20 with a dimension, 1e6 without, one turn for angles.
    Any,
    /// Positive numbers between the largest magnitude of the unit and its reciprocal.
    Positive,
    /// Numbers from zero up to the largest magnitude of the unit.
    NotNegative,
    /// Numbers from 0 to 1.
    Fraction,
    /// Numbers between two limits, which are excluded.
    Between(f64, f64),
    /// Numbers between two limits, which are admitted.
    Within(f64, f64),
}

/// No limit is a NaN.
impl Eq for Admitted {}

/// Largest magnitude of a number with a unit, and reciprocal of the smallest positive number: third powers of products of such numbers neither
/// overflow nor underflow, and the SI values for atoms and for planets are within these limits.
const LARGEST_DIMENSIONAL_VALUE: f64 = 1e20;
/// Largest magnitude of a number without unit, and reciprocal of the smallest positive number.
const LARGEST_DIMENSIONLESS_VALUE: f64 = 1e6;
/// Degrees of a full turn.
const TURN: f64 = 360.0;

impl Admitted {
    /// The smallest and the largest admitted number in a unit.
    pub fn limits(self, unit: &str) -> [f64; 2] {
        let largest = match unit {
            "1" => LARGEST_DIMENSIONLESS_VALUE,
            "deg" => TURN,
            "rad" => std::f64::consts::TAU,
            _ => LARGEST_DIMENSIONAL_VALUE,
        };
        match self {
            Self::Any => [-largest, largest],
            Self::Positive => [largest.recip(), largest],
            Self::NotNegative => [0.0, largest],
            Self::Fraction => [0.0, 1.0],
            Self::Between(low, high) | Self::Within(low, high) => [low, high],
        }
    }

    /// Returns true if a number in a unit is admitted.
    pub fn holds(self, value: f64, unit: &str) -> bool {
        let [low, high] = self.limits(unit);
        match self {
            Self::Between(..) => low < value && value < high,
            _ => (low..=high).contains(&value),
        }
    }

    /// Description of the admitted numbers in a unit: `a positive number from 1e-20 to 1e20`.
    pub fn expected(self, unit: &str) -> String {
        let limits = self.limits(unit);
        let [low, high] = limits.map(|limit| written(limit, unit));
        match self {
            Self::Between(..) => format!("a number above {low} and below {high}"),
            _ if limits[0] > 0.0 => format!("a positive number from {low} to {high}"),
            _ => format!("a number from {low} to {high}"),
        }
    }
}

/// Limit of a parameter in the form in which the user types it; angles in multiples of pi.
fn written(limit: f64, unit: &str) -> String {
    match limit.abs() {
        _ if unit == "rad" => format!("{} pi", limit / std::f64::consts::PI),
        0.0 | 1e-3..1e5 => limit.to_string(),
        _ => format!("{limit:e}"),
    }
}

/// Parameter of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name of the parameter, unique within the law.
    pub name: &'static str,
    /// Unit: `stress`, `deg`, or `1` if dimensionless. Equal in every law with a parameter of this name.
    pub unit: &'static str,
    /// Default value of the parameter.
    pub default: f64,
    /// Admissible values of the parameter.
    pub admitted: Admitted,
    /// Description of the parameter.
    pub meaning: &'static str,
}

impl Parameter {
    /// Creates a parameter; for the tables of laws.
    pub(crate) const fn new(
        name: &'static str,
        unit: &'static str,
        default: f64,
        admitted: Admitted,
        meaning: &'static str,
    ) -> Self {
        Self {
            name,
            unit,
            default,
            admitted,
            meaning,
        }
    }

    /// Returns true if a value is admissible for the parameter.
    pub fn holds(&self, value: f64) -> bool {
        self.admitted.holds(value, self.unit)
    }

    /// Description of the admissible values of the parameter.
    pub fn expected(&self) -> String {
        self.admitted.expected(self.unit)
    }
}

/// Symmetry group of a law: the rotations of the reference configuration that leave its response unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// Invariant under all rotations.
    Isotropic,
    /// Invariant under rotations about an axis and half turns that reverse it: one family of fibers along it.
    TransverselyIsotropic,
    /// Invariant under half turns about three orthogonal axes: planes of mirror symmetry.
    Orthotropic,
    /// Invariant under the rotations of a cube.
    Cubic,
}

impl Symmetry {
    /// Name of the symmetry in files and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Isotropic => "isotropic",
            Self::TransverselyIsotropic => "transversely isotropic",
            Self::Orthotropic => "orthotropic",
            Self::Cubic => "cubic",
        }
    }
}

/// Stiffness `dS/dE` at small strains in the reference configuration, by `[11, 22, 33, 23, 13, 12]` (Voigt, with shear angles).
pub type SmallStrainStiffness = [[f64; 6]; 6];

/// Hooke's stiffness `C_IJKL = (K - 2/3 mu) d_IJ d_KL + mu (d_IK d_JL + d_IL d_JK)`.
pub(crate) fn hooke(shear_modulus: f64, bulk_modulus: f64) -> SmallStrainStiffness {
    let lambda = bulk_modulus - shear_modulus / 1.5;
    array_of(|a| {
        array_of(|b| match (a, b) {
            _ if a != b => f64::from(u8::from(a < 3 && b < 3)) * lambda,
            (0..3, _) => lambda + 2.0 * shear_modulus,
            _ => shear_modulus,
        })
    })
}

/// A material, or the error that prevents its creation.
pub(crate) type Made = Result<Box<dyn Hyperelastic>, MaterialError>;

/// Law of the library: its name, formula, parameters, domain, symmetry, source and constructor.
///
/// ```
/// use onset::kinematics::DeformationGradient;
/// use onset::material::Law;
/// let law = Law::named("blatz-ko").ok_or("no such law")?;
/// let rubber = law.build(&[("mu", 2.0)])?;
/// let stretched = DeformationGradient::from_stretches([2.0, 1.0, 1.0])?;
/// // P11 = mu (J - I2 / J^2 + ...) = mu (1 - lambda^-3)
/// let stress = rubber.response(&stretched)?.first_piola[(0, 0)];
/// assert!((stress - 2.0 * (1.0 - 0.125)).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Law {
    /// Name that selects the law.
    pub name: &'static str,
    /// Energy per reference volume as a formula.
    pub formula: &'static str,
    /// Parameters in the order of the formula.
    pub parameters: &'static [Parameter],
    /// Domain: the states at which the law is defined, and the strains for which it is intended.
    pub domain: &'static str,
    /// Rotations of the reference configuration that leave the law unchanged.
    pub symmetry: Symmetry,
    /// Reason for stress in the reference configuration; `None` if there is no stress.
    pub stressed_reference: Option<&'static str>,
    /// Description of the moduli at small strains.
    pub small_strains: &'static str,
    /// References of the law and of its default values.
    pub source: &'static str,
    /// Stiffness at small strains in closed form, from the parameters in their order; units of stress.
    pub(crate) stiffness: fn(&[f64]) -> SmallStrainStiffness,
    /// Constructor from admissible parameters in their order.
    pub(crate) make: fn(&[f64]) -> Made,
}

/// Laws are identified by their names.
impl PartialEq for Law {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// All named laws, the default first.
///
/// ```
/// let names: Vec<&str> = onset::material::library().iter().map(|law| law.name).collect();
/// assert!(names.contains(&"modified-mooney-rivlin") && names.contains(&"blatz-ko"));
/// ```
pub fn library() -> &'static [Law] {
    LIBRARY
}

impl Law {
    /// Returns the law with the given name, or `None`.
    pub fn named(name: &str) -> Option<&'static Self> {
        LIBRARY.iter().find(|law| law.name == name)
    }

    /// Returns the parameter with the given name, or `None`.
    pub fn parameter(&self, name: &str) -> Option<&'static Parameter> {
        self.parameters
            .iter()
            .find(|parameter| parameter.name == name)
    }

    /// Creates the law from some parameters given by name, with defaults for the others.
    ///
    /// # Errors
    /// [`MaterialError`] if no parameter has a given name, or if a value is not admissible.
    pub fn build(&self, given: &[(&str, f64)]) -> Made {
        (self.make)(&self.checked(given)?)
    }

    /// Stiffness at small strains in the reference configuration, in closed form; parameters as for [`Law::build`]. Units of stress.
    ///
    /// # Errors
    /// [`MaterialError`] under the conditions of [`Law::build`].
    pub fn small_strain_stiffness(
        &self,
        given: &[(&str, f64)],
    ) -> Result<SmallStrainStiffness, MaterialError> {
        Ok((self.stiffness)(&self.checked(given)?))
    }

    /// Returns all parameters in their order, with a check.
    pub(crate) fn checked(&self, given: &[(&str, f64)]) -> Result<Vec<f64>, MaterialError> {
        if let Some((name, _)) = given
            .iter()
            .find(|(name, _)| self.parameter(name).is_none())
        {
            return Err(MaterialError::UnknownParameter {
                law: self.name,
                name: (*name).to_owned(),
            });
        }
        let value = |parameter: &Parameter| {
            let named = given.iter().rev().find(|(name, _)| *name == parameter.name);
            named.map_or(parameter.default, |(_, value)| *value)
        };
        let values: Vec<f64> = self.parameters.iter().map(value).collect();
        self.check(&values)?;
        Ok(values)
    }

    /// Checks parameters in their order; for the constructors of laws.
    pub(super) fn check(&self, values: &[f64]) -> Result<(), MaterialError> {
        let refused = |(parameter, value): (&Parameter, &f64)| {
            (!parameter.holds(*value)).then(|| MaterialError::Parameter {
                name: parameter.name,
                value: *value,
                expected: parameter.expected(),
            })
        };
        match self.parameters.iter().zip(values).find_map(refused) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }

    /// Default value of a parameter; for the defaults of laws.
    pub(super) fn default_of(&self, index: usize) -> f64 {
        self.parameters[index].default
    }
}

/// Converts a law to the object-safe interface.
pub(super) fn boxed<Energy: StrainEnergy + Send + Sync + 'static>(
    law: Result<Energy, MaterialError>,
) -> Made {
    Ok(Box::new(law?))
}
