//! What `material.model` can be: a law of the library, or a user-defined model that is more than numbers.

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

/// A user-defined model: the keys that it needs, and how it is made from them.
#[derive(Debug)]
pub struct OwnModel {
    /// The word that chooses it.
    pub name: &'static str,
    /// What it is, as a formula or in words.
    pub formula: &'static str,
    /// Where to read on.
    pub source: &'static str,
    /// Its keys, parameters apart.
    pub keys: &'static [Key],
    /// Names of the keys, without their section, that must be set.
    pub required: &'static [&'static str],
    /// Whether numbers under any other name are its parameters.
    pub takes_any_parameter: bool,
    /// What is wrong with what was set, with the place.
    pub check: fn(&MaterialSettings) -> Result<(), SettingError>,
    /// The material.
    pub build: fn(&MaterialSettings) -> Result<Box<dyn Hyperelastic>, MaterialError>,
}

/// The user-defined models.
const OWN: &[OwnModel] = &[formula::MODEL, table::MODEL, umat::MODEL];

/// A model.
#[derive(Clone, Copy, Debug)]
pub enum Model {
    /// A law of the library, hyperelastic or in rate form.
    Law(&'static Law),
    /// A user-defined one.
    Own(&'static OwnModel),
}

/// Models are told apart by their names.
impl PartialEq for Model {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

/// The first law of the library.
impl Default for Model {
    fn default() -> Self {
        Self::Law(&library()[0])
    }
}

/// By its name.
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

    /// The model with a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|model| model.name() == name)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Law(law) => law.name,
            Self::Own(model) => model.name,
        }
    }

    /// Whether it is one of the laws in rate form, whose tangent is that of what goes on from the end of a path.
    pub fn is_in_rate_form(self) -> bool {
        matches!(self, Self::Law(law) if plasticity::library().contains(law))
    }

    /// Whether it is one of those that flow.
    pub fn is_elastic_plastic(self) -> bool {
        matches!(self, Self::Law(law) if self.is_in_rate_form() && law.parameter("yield-stress").is_some())
    }

    /// Whether it is a law of the library without axes of its own, whatever its parameters.
    pub fn is_isotropic(self) -> bool {
        matches!(self, Self::Law(law) if law.symmetry == Symmetry::Isotropic)
    }

    /// Its parameters; none of a model that names them itself.
    pub fn parameters(self) -> &'static [Parameter] {
        match self {
            Self::Law(law) => law.parameters,
            Self::Own(_) => &[],
        }
    }

    /// Its keys that are no parameters.
    pub fn keys(self) -> &'static [Key] {
        match self {
            Self::Law(_) => &[],
            Self::Own(model) => model.keys,
        }
    }

    /// The names of its keys without their section, parameters first.
    pub fn names(self) -> impl Iterator<Item = &'static str> + Clone {
        let parameters = self.parameters().iter().map(|parameter| parameter.name);
        parameters.chain(self.keys().iter().map(|key| key.parts().1))
    }

    /// Whether numbers under any name are its parameters.
    pub fn takes_any_parameter(self) -> bool {
        matches!(self, Self::Own(model) if model.takes_any_parameter)
    }

    /// Whether a key of a name, without its section, is one of the model's.
    pub fn takes(self, name: &str) -> bool {
        let is_of_another = || {
            Self::all()
                .flat_map(Self::keys)
                .any(|key| key.parts().1 == name)
        };
        self.names().any(|known| known == name)
            || (self.takes_any_parameter() && name != PLANE && !is_of_another())
    }

    /// What it takes, as a hint.
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
