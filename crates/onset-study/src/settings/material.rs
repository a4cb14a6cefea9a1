//! The material as set: a model and its parameters by name.

use super::error::{Origin, SettingError};
use onset::material::{BlatzKo, Hyperelastic, MaterialError, ModifiedMooneyRivlin};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The laws by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// Equation (5).
    #[default]
    ModifiedMooneyRivlin,
    /// Equation (56).
    BlatzKo,
}

impl Model {
    /// All laws.
    pub const ALL: [Self; 2] = [Self::ModifiedMooneyRivlin, Self::BlatzKo];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::ModifiedMooneyRivlin => "modified-mooney-rivlin",
            Self::BlatzKo => "blatz-ko",
        }
    }

    /// Its parameters with their defaults.
    pub fn parameters(self) -> &'static [(&'static str, f64)] {
        match self {
            Self::ModifiedMooneyRivlin => &[("c1", 0.1256), ("c2", 0.01012), ("lambda", 10.12)],
            Self::BlatzKo => &[("mu", 32.0)],
        }
    }
}

/// A material as set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialSettings {
    /// The law.
    pub model: Model,
    /// Parameters that were set, with where.
    set: BTreeMap<String, (f64, Origin)>,
}

impl MaterialSettings {
    /// A law with parameters of one's own.
    pub fn new(model: Model, parameters: &[(&str, f64)]) -> Self {
        let set = parameters
            .iter()
            .map(|(name, value)| ((*name).to_owned(), (*value, Origin::Combination)));
        Self {
            model,
            set: set.collect(),
        }
    }

    pub(super) fn set_parameter(&mut self, name: &str, value: f64, origin: Origin) {
        self.set.insert(name.to_owned(), (value, origin));
    }

    /// Whether all parameters belong to the model.
    pub(super) fn check(&self) -> Result<(), SettingError> {
        for (name, (_, origin)) in &self.set {
            let known = self.model.parameters();
            if !known.iter().any(|(parameter, _)| parameter == name) {
                let names: Vec<&str> = known.iter().map(|(parameter, _)| *parameter).collect();
                let message = format!("{} has no parameter `{name}`", self.model.name());
                return Err(SettingError::new(origin.clone(), message).hint(format!(
                    "its parameters are {}; or set material.model",
                    names.join(", ")
                )));
            }
        }
        Ok(())
    }

    /// All parameters with their values.
    pub fn values(&self) -> Vec<(&'static str, f64)> {
        let value = |(name, default): &(&'static str, f64)| {
            (
                *name,
                self.set.get(*name).map_or(*default, |(value, _)| *value),
            )
        };
        self.model.parameters().iter().map(value).collect()
    }

    /// The law.
    ///
    /// # Errors
    /// [`MaterialError`] when a parameter is out of range.
    pub fn build(&self) -> Result<Box<dyn Hyperelastic>, MaterialError> {
        let values: Vec<f64> = self.values().into_iter().map(|(_, value)| value).collect();
        Ok(match self.model {
            Model::ModifiedMooneyRivlin => {
                Box::new(ModifiedMooneyRivlin::new(values[0], values[1], values[2])?)
            }
            Model::BlatzKo => Box::new(BlatzKo::new(values[0])?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{MaterialSettings, Model};
    use onset::kinematics::DeformationGradient;
    use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin};

    #[test]
    fn default_parameters_are_those_of_the_laws() {
        let f = DeformationGradient::from_stretches([1.3, 0.8, 1.1]).expect("stretches");
        for (model, law) in [
            (
                Model::ModifiedMooneyRivlin,
                &ModifiedMooneyRivlin::default() as &dyn Hyperelastic,
            ),
            (Model::BlatzKo, &BlatzKo::default()),
        ] {
            let built = MaterialSettings::new(model, &[])
                .build()
                .expect("admissible");
            assert_eq!(built.response(&f), law.response(&f));
        }
    }
}
