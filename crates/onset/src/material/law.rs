//! The library: every law described once, beside its formula.

use super::laws::LIBRARY;
use super::{Hyperelastic, MaterialError, StrainEnergy};
use crate::algebra::array_of;

/// What values a parameter admits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Admitted {
    /// Every finite number.
    Any,
    /// Positive finite numbers.
    Positive,
    /// Finite numbers from zero on.
    NotNegative,
    /// Numbers from 0 to 1.
    Fraction,
    /// Numbers between two limits, which are not admitted themselves.
    Between(f64, f64),
}

impl Admitted {
    /// Whether a value is admitted.
    pub fn holds(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Any => true,
                Self::Positive => value > 0.0,
                Self::NotNegative => value >= 0.0,
                Self::Fraction => (0.0..=1.0).contains(&value),
                Self::Between(low, high) => low < value && value < high,
            }
    }
}

impl std::fmt::Display for Admitted {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Any => write!(formatter, "a finite number"),
            Self::Positive => write!(formatter, "a positive finite number"),
            Self::NotNegative => write!(formatter, "zero or a positive finite number"),
            Self::Fraction => write!(formatter, "a number from 0 to 1"),
            Self::Between(low, high) => write!(formatter, "a number above {low} and below {high}"),
        }
    }
}

/// A parameter of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name, unique within the law.
    pub name: &'static str,
    /// Its unit: `stress`, `deg`, or `1` without dimension. The same in every law that has a parameter of this name.
    pub unit: &'static str,
    /// The value that it has when none is given.
    pub default: f64,
    /// What it may be.
    pub admitted: Admitted,
    /// What it means.
    pub meaning: &'static str,
}

impl Parameter {
    /// A parameter; for the tables of laws.
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
}

/// Which rotations of the reference change no response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// All.
    Isotropic,
    /// All about an axis, and half turns that reverse it: one family of fibers along it.
    TransverselyIsotropic,
    /// Half turns about three orthogonal axes: planes of mirror symmetry.
    Orthotropic,
    /// Those of a cube.
    Cubic,
}

impl Symmetry {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Isotropic => "isotropic",
            Self::TransverselyIsotropic => "transversely isotropic",
            Self::Orthotropic => "orthotropic",
            Self::Cubic => "cubic",
        }
    }
}

/// The stiffness at small strains in the reference, by `[11, 22, 33, 23, 13, 12]` (Voigt, with shear angles): `dS/dE`.
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

/// A material, or why it cannot be made.
pub(crate) type Made = Result<Box<dyn Hyperelastic>, MaterialError>;

/// A law of the library: what it is called, what it says, what it needs, where it holds, and how it is made.
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
    /// The word that chooses it.
    pub name: &'static str,
    /// The energy per reference volume.
    pub formula: &'static str,
    /// Its parameters, in the order of the formula.
    pub parameters: &'static [Parameter],
    /// Where it holds: states at which it is defined, and strains for which it is meant.
    pub domain: &'static str,
    /// Which rotations of the reference change nothing.
    pub symmetry: Symmetry,
    /// Why there is stress in the reference; `None` where there is none.
    pub stressed_reference: Option<&'static str>,
    /// The moduli at small strains, in words.
    pub small_strains: &'static str,
    /// Where it is from, and where its defaults are from.
    pub source: &'static str,
    /// The stiffness at small strains in closed form, from parameters in their order; units of stress.
    pub(crate) stiffness: fn(&[f64]) -> SmallStrainStiffness,
    /// The law with parameters in their order, each of them admitted.
    pub(crate) make: fn(&[f64]) -> Made,
}

/// Laws are told apart by their names.
impl PartialEq for Law {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// All laws that have a name, the default first.
///
/// ```
/// let names: Vec<&str> = onset::material::library().iter().map(|law| law.name).collect();
/// assert!(names.contains(&"modified-mooney-rivlin") && names.contains(&"blatz-ko"));
/// ```
pub fn library() -> &'static [Law] {
    LIBRARY
}

impl Law {
    /// The law with a name.
    pub fn named(name: &str) -> Option<&'static Self> {
        LIBRARY.iter().find(|law| law.name == name)
    }

    /// The parameter with a name.
    pub fn parameter(&self, name: &str) -> Option<&'static Parameter> {
        self.parameters
            .iter()
            .find(|parameter| parameter.name == name)
    }

    /// The law with some parameters given by name and defaults for the others.
    ///
    /// # Errors
    /// [`MaterialError`] when there is no parameter of a name, or a value is not admitted.
    pub fn build(&self, given: &[(&str, f64)]) -> Made {
        (self.make)(&self.checked(given)?)
    }

    /// The stiffness at small strains in the reference, in closed form; parameters as in [`Law::build`]. Units of stress.
    ///
    /// # Errors
    /// As [`Law::build`].
    pub fn small_strain_stiffness(
        &self,
        given: &[(&str, f64)],
    ) -> Result<SmallStrainStiffness, MaterialError> {
        Ok((self.stiffness)(&self.checked(given)?))
    }

    /// All parameters in their order.
    fn checked(&self, given: &[(&str, f64)]) -> Result<Vec<f64>, MaterialError> {
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
            (!parameter.admitted.holds(*value)).then(|| MaterialError::Parameter {
                name: parameter.name,
                value: *value,
                expected: parameter.admitted.to_string(),
            })
        };
        match self.parameters.iter().zip(values).find_map(refused) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }

    /// The default of a parameter; for the defaults of laws.
    pub(super) fn default_of(&self, index: usize) -> f64 {
        self.parameters[index].default
    }
}

/// A law as the rest of the program sees it.
pub(super) fn boxed<Energy: StrainEnergy + Send + Sync + 'static>(
    law: Result<Energy, MaterialError>,
) -> Made {
    Ok(Box::new(law?))
}
