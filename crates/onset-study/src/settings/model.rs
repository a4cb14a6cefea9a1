//! Possible values of `material.model`: a law of the library, or a user-defined model that needs more than numbers.

mod formula;
mod function;
mod table;
mod umat;

pub use function::HandedLaw;
pub(super) use umat::{LIBRARY, sum};

use super::error::SettingError;
use super::material::PLANE;
use super::{Key, MaterialSettings};
use onset::material::{Hyperelastic, Law, MaterialError, Parameter, Symmetry, library};
use onset::plasticity;
use serde::{Serialize, Serializer};

/// User-defined model: the keys that it needs, and how it is built from them.
#[derive(Debug)]
pub struct OwnModel {
    /// Word that selects the model.
    pub name: &'static str,
    /// Formula or description of the model.
    pub formula: &'static str,
    /// Reference for further reading.
    pub source: &'static str,
    /// Keys of the model, without parameters.
    pub keys: &'static [Key],
    /// Names of the required keys, without their section.
    pub required: &'static [&'static str],
    /// Names of the keys, without their section, that hold stresses: numbers, or files of numbers without units. Dimensions of other values are
    /// unknown.
    pub stresses: &'static [&'static str],
    /// Whether numbers under any other name are its parameters.
    pub takes_any_parameter: bool,
    /// Check of the settings, which returns an error with its place.
    pub check: fn(&MaterialSettings) -> Result<(), SettingError>,
    /// Construction of the material.
    pub build: fn(&MaterialSettings) -> Result<Box<dyn Hyperelastic>, MaterialError>,
}

/// The user-defined models.
const OWN: &[OwnModel] = &[
    formula::MODEL,
    table::MODEL,
    umat::MODEL,
    umat::VUMAT,
    umat::MFRONT,
    umat::FUNCTION,
];

/// Model of a material.
#[derive(Clone, Copy, Debug)]
pub enum Model {
    /// Law of the library, hyperelastic or in rate form.
    Law(&'static Law),
    /// Model that the user defines.
    Own(&'static OwnModel),
}

/// Models are identified by their names.
impl PartialEq for Model {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

/// The default is the first law of the library.
impl Default for Model {
    fn default() -> Self {
        Self::Law(&library()[0])
    }
}

/// Models are serialized as their names.
impl Serialize for Model {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl Model {
    /// All models, in the order of the documentation.
    pub fn all() -> impl Iterator<Item = Self> + Clone {
        let laws = library().iter().chain(plasticity::library());
        laws.map(Self::Law).chain(OWN.iter().map(Self::Own))
    }

    /// Returns the model with this name, or `None`.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|model| model.name() == name)
    }

    /// Name of the model.
    pub fn name(self) -> &'static str {
        match self {
            Self::Law(law) => law.name,
            Self::Own(model) => model.name,
        }
    }

    /// Returns true for laws in rate form, whose tangent describes continued deformation from the end of the path.
    pub fn is_in_rate_form(self) -> bool {
        matches!(self, Self::Law(law) if plasticity::library().contains(law))
    }

    /// Returns true for laws that yield, by plastic flow or damage.
    pub fn yields(self) -> bool {
        matches!(self, Self::Law(law) if plasticity::yielding().contains(law))
    }

    /// Returns true for isotropic laws of the library, for any parameters.
    pub fn is_isotropic(self) -> bool {
        matches!(self, Self::Law(law) if law.symmetry == Symmetry::Isotropic)
    }

    /// Parameters of the model; empty if the user names the parameters.
    pub fn parameters(self) -> &'static [Parameter] {
        match self {
            Self::Law(law) => law.parameters,
            Self::Own(_) => &[],
        }
    }

    /// Keys of the model that are not parameters.
    pub fn keys(self) -> &'static [Key] {
        match self {
            Self::Law(_) => &[],
            Self::Own(model) => model.keys,
        }
    }

    /// Names of the keys without their section, parameters first.
    pub fn names(self) -> impl Iterator<Item = &'static str> + Clone {
        let parameters = self.parameters().iter().map(|parameter| parameter.name);
        parameters.chain(self.keys().iter().map(|key| key.parts().1))
    }

    /// Returns true if numbers under any name are parameters of the model.
    pub fn takes_any_parameter(self) -> bool {
        matches!(self, Self::Own(model) if model.takes_any_parameter)
    }

    /// Returns true if the model accepts a key, given without its section.
    pub fn takes(self, name: &str) -> bool {
        let is_of_another = || {
            Self::all()
                .flat_map(Self::keys)
                .any(|key| key.parts().1 == name)
        };
        self.names().any(|known| known == name)
            || (self.takes_any_parameter() && name != PLANE && !is_of_another())
    }

    /// Hint that lists the keys of the model.
    pub(super) fn hint(self) -> String {
        let names: Vec<&str> = self.names().collect();
        match self.parameters() {
            [] => format!("its keys are {}; or set material.model", names.join(", ")),
            _ => format!(
                "its parameters are {}; or set material.model",
                names.join(", ")
            ),
        }
    }
}
