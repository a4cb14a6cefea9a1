//! The material as set: a model, and what it needs by name.

use super::error::{Origin, SettingError, nearest};
use super::model::{LIBRARY, sum};
use super::{Key, Kind, Model, TRUST_VARIABLE, Trust, Value, aliases};
use crate::shell::quoted_file;
use onset::material::{Hyperelastic, MaterialError};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A material as set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialSettings {
    /// The model.
    pub model: Model,
    /// What was set, without the section, with where.
    set: BTreeMap<&'static str, (Value, Origin)>,
    /// The SHA-256 that the library of a user material must have.
    fingerprint: Option<String>,
    /// Where the library is that the user allows a file to load.
    allowed: Option<PathBuf>,
}

impl MaterialSettings {
    /// A model with parameters of one's own; those that no key has a name for are left out.
    pub fn new(model: Model, parameters: &[(&str, f64)]) -> Self {
        let set = |(name, value): &(&str, f64)| {
            let key = Key::named(&format!("material.{name}"))?;
            Some((key.parts().1, (Value::Number(*value), Origin::Combination)))
        };
        Self {
            model,
            set: parameters.iter().filter_map(set).collect(),
            fingerprint: None,
            allowed: None,
        }
    }

    /// Sets a key of the material other than its model; tells whether it takes such a value. Whether a number is admitted
    /// by the law is told by the law.
    pub(super) fn set(&mut self, key: &'static Key, value: &Value, origin: Origin) -> bool {
        let takes = match key.kind {
            Kind::Number(_) | Kind::Positive(_) => value.number().is_some(),
            kind => kind.accepts(value),
        };
        if takes {
            let name = key.parts().1;
            if name == LIBRARY {
                self.allowed = None;
            }
            self.set.insert(name, (value.clone(), origin));
        }
        takes
    }

    /// Whether all that was set belongs to the model, and the model has what it needs.
    pub(super) fn check(&self) -> Result<(), SettingError> {
        let stray = self.set.iter().find(|(name, _)| !self.model.takes(name));
        if let Some((name, (_, origin))) = stray {
            return Err(self.stray(name, origin.clone()));
        }
        match self.model {
            Model::Law(_) => Ok(()),
            Model::Own(model) => (model.check)(self),
        }
    }

    /// The error for a key that the model does not have.
    fn stray(&self, name: &str, origin: Origin) -> SettingError {
        let is_known = Model::all().any(|model| model.names().any(|known| known == name));
        if is_known {
            let message = format!("{} has no parameter `{name}`", self.model.name());
            return SettingError::new(origin, message).hint(self.model.hint());
        }
        let error = SettingError::new(origin, format!("unknown key `material.{name}`"));
        if let Some(told) = aliases::key(name) {
            return error.hint(told);
        }
        let names = std::iter::once("model").chain(self.model.names());
        let full: Vec<String> = names.map(|name| format!("material.{name}")).collect();
        match nearest(&format!("material.{name}"), full.iter().map(String::as_str)) {
            Some(nearest) => error.hint(format!("did you mean `{nearest}`?")),
            None => error.hint(format!("{}: {}", self.model.name(), self.model.hint())),
        }
    }

    /// What a key of the model was set to, with where; an error that asks for it when it was not set.
    ///
    /// # Errors
    /// [`SettingError`] when the key, named without its section, was not set.
    pub fn require(&self, name: &str) -> Result<(&Value, &Origin), SettingError> {
        match self.set.get(name) {
            Some((value, origin)) => Ok((value, origin)),
            None => Err(SettingError::new(
                Origin::Combination,
                format!(
                    "material.model is {}, which needs material.{name}",
                    self.model.name()
                ),
            )
            .hint(format!("set material.{name}"))),
        }
    }

    /// Where a key, named without its section, was set.
    pub(super) fn origin(&self, name: &str) -> Option<&Origin> {
        self.set.get(name).map(|(_, origin)| origin)
    }

    /// What a key, named without its section, was set to.
    pub fn given(&self, name: &str) -> Option<&Value> {
        self.set.get(name).map(|(value, _)| value)
    }

    /// Everything that the model is made of, by name without the section: parameters with their defaults, and what was
    /// set.
    pub fn entries(&self) -> Vec<(&'static str, Value)> {
        let parameters = self.model.parameters().iter().map(|parameter| {
            let value = self.given(parameter.name).cloned();
            (
                parameter.name,
                value.unwrap_or(Value::Number(parameter.default)),
            )
        });
        let known = |name: &str| self.model.names().any(|known| known == name);
        let own = self.model.keys().iter().filter_map(|key| {
            let name = key.parts().1;
            Some((name, self.given(name)?.clone()))
        });
        let free = self
            .set
            .iter()
            .filter(|(name, _)| self.model.takes(name) && !known(name))
            .map(|(name, (value, _))| (*name, value.clone()));
        parameters.chain(own).chain(free).collect()
    }

    /// All parameters that are numbers, with their values.
    pub fn values(&self) -> Vec<(&'static str, f64)> {
        let number = |(name, value): (&'static str, Value)| Some((name, value.number()?));
        self.entries().into_iter().filter_map(number).collect()
    }

    /// Lets a library that a file names be loaded, if the user allows it.
    pub fn allow(&mut self, trust: &Trust) {
        if let Some((Value::Word(library), origin @ Origin::File { .. })) =
            self.set.get_mut(LIBRARY)
            && let Some(place) = trust.admitted(Path::new(library))
        {
            self.allowed = Some(place);
            *origin = Origin::CommandLine(format!("--allow-library {library}"));
        }
    }

    /// Refuses a library that a file names and the user has not allowed.
    ///
    /// # Errors
    /// [`SettingError`] with how to allow it.
    pub fn permitted(&self) -> Result<(), SettingError> {
        match self.set.get(LIBRARY) {
            Some((Value::Word(library), origin @ Origin::File { .. })) if self.is_library() => {
                let message = format!(
                    "`material.library` is a program, {library:?}, and a file may have none run unless you allow it; nothing was \
                     loaded"
                );
                let library = quoted_file(Path::new(library));
                Err(SettingError::new(origin.clone(), message).hint(format!(
                    "if you trust it: --allow-library {library}, or for good the variable {TRUST_VARIABLE} with libraries or folders"
                )))
            }
            _ => Ok(()),
        }
    }

    /// Where the library is that the user allows a file to load, without links.
    pub(super) fn allowed(&self) -> Option<&Path> {
        self.allowed.as_deref()
    }

    /// Whether the material is a program in a shared library, which building it loads.
    pub fn is_library(&self) -> bool {
        self.umat().is_some()
    }

    /// Ties a user material to its library as it is now: with another one it cannot be built. Nothing is loaded.
    ///
    /// # Errors
    /// [`MaterialError`] when the library is not permitted, or cannot be read.
    pub fn pin(&mut self) -> Result<(), MaterialError> {
        self.fingerprint = self.umat_permitted()?.map(sum).transpose()?;
        Ok(())
    }

    /// Ties a user material to the library that a store was computed with.
    pub(crate) fn fingerprint_is(&mut self, stored: Option<&serde_json::Value>) {
        let stored = stored.and_then(serde_json::Value::as_str);
        self.fingerprint = stored.filter(|_| self.is_library()).map(str::to_owned);
    }

    /// The SHA-256 of the library that the material is tied to.
    pub fn fingerprint(&self) -> Option<&str> {
        self.fingerprint.as_deref()
    }

    /// The material.
    ///
    /// # Errors
    /// [`MaterialError`] when a parameter is not admitted.
    pub fn build(&self) -> Result<Box<dyn Hyperelastic>, MaterialError> {
        match self.model {
            Model::Law(law) => law.build(&self.values()),
            Model::Own(model) => (model.build)(self),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{MaterialSettings, Model};
    use crate::settings::{Key, Settings, Value};
    use onset::kinematics::DeformationGradient;
    use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin, library};

    #[test]
    fn default_parameters_are_those_of_the_laws() {
        let f = DeformationGradient::from_stretches([1.3, 0.8, 1.1]).expect("stretches");
        for (name, law) in [
            (
                "modified-mooney-rivlin",
                &ModifiedMooneyRivlin::default() as &dyn Hyperelastic,
            ),
            ("blatz-ko", &BlatzKo::default()),
        ] {
            let model = Model::named(name).expect("a model");
            let built = MaterialSettings::new(model, &[])
                .build()
                .expect("admissible");
            assert_eq!(built.response(&f), law.response(&f));
        }
    }

    #[test]
    fn every_parameter_of_every_law_can_be_set_and_is_what_was_set() {
        for law in library() {
            for parameter in law.parameters {
                let settings = Settings::from_assignments(&[
                    format!("material.{}={:?}", parameter.name, parameter.default * 1.25),
                    format!("material.model={}", law.name),
                ])
                .expect("a parameter of the law");
                let values = settings.material.values();
                assert!(values.contains(&(parameter.name, parameter.default * 1.25)));
                assert_eq!(values.len(), law.parameters.len());
            }
        }
    }

    #[test]
    fn parameters_of_one_name_have_one_unit_and_fit_under_a_key() {
        for law in library() {
            for parameter in law.parameters {
                let key = Key::named(&format!("material.{}", parameter.name)).expect("a key");
                assert_eq!(
                    key.unit(),
                    Some(parameter.unit),
                    "{} {}",
                    law.name,
                    parameter.name
                );
                assert!(key.kind.accepts(&Value::Number(parameter.default)));
            }
        }
    }

    #[test]
    fn a_formula_takes_numbers_under_any_name_and_a_text_as_it_is_typed() {
        let settings = Settings::from_assignments(&[
            "material.model=formula",
            "material.stiffness=3",
            "material.energy=stiffness/2*(I1 - 3)^2",
        ])
        .expect("a formula");
        let text = Value::Word("stiffness/2*(I1 - 3)^2".to_owned());
        let entries = settings.material.entries();
        assert_eq!(
            entries,
            [("energy", text), ("stiffness", Value::Number(3.0))]
        );
        let unfinished = Settings::from_assignments(&["material.model=formula"]);
        let told = unfinished.expect_err("no energy").to_string();
        assert!(told.contains("needs material.energy"), "{told}");
        let of_another = [
            "material.model=formula",
            "material.energy=I1",
            "material.library=a.so",
        ];
        assert!(Settings::from_assignments(&of_another).is_err());
    }

    #[test]
    fn a_list_of_numbers_is_typed_with_or_without_brackets() {
        for typed in ["[1, 2.5,-3e2]", "1,2.5,-3e2"] {
            let settings = Settings::from_assignments(&[
                "material.model=umat".to_owned(),
                "material.library=a.so".to_owned(),
                format!("material.properties={typed}"),
            ])
            .expect("a list");
            let properties = settings.material.given("properties");
            assert_eq!(properties, Some(&Value::Numbers(vec![1.0, 2.5, -300.0])));
        }
        for typed in ["[1, x]", "1;2", "[1", "nan"] {
            let wrong = Settings::from_assignments(&[format!("material.properties={typed}")]);
            let told = wrong.expect_err("no list of numbers").to_string();
            assert!(told.contains("a list of numbers"), "{told}");
        }
    }
}
