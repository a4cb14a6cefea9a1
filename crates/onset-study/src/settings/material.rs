//! The material as set: a model with its parameters.

use super::error::{Origin, SettingError, nearest};
use super::key::ANY_DIMENSION;
use super::model::{LIBRARY, sum};
use super::relaxation::is_of_relaxation;
use super::softening::is_of_softening;
use super::{
    HandedLaw, Key, Kind, Model, Settings, TRUST_VARIABLE, Trust, Units, Value, aliases, moduli,
    units, word_of,
};
use crate::shell::quoted_file;
use onset::material::{Hyperelastic, MaterialError, Membrane, PlaneStress};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Key, without its section, for the condition on the directions beyond the dimensions of the body.
pub(super) const PLANE: &str = "plane";

/// Condition on the directions beyond the dimensions of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Plane {
    /// Prescribed strain: plane strain, in one dimension uniaxial strain.
    #[default]
    Strain,
    /// Traction-free faces: plane stress of a sheet, in one dimension uniaxial stress of a bar.
    Stress,
    /// Two-dimensional law, as for cloth. Increments stay in the plane, and formulas use the invariants of the 2x2 tensor.
    Membrane,
}

/// Settings of a material: the model and the parameters that are set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialSettings {
    /// Model of the material.
    pub model: Model,
    /// Condition on the directions beyond the dimensions of the body, if it was set.
    plane: Option<(Plane, Origin)>,
    /// Values by key without section, with the place at which each was set.
    set: BTreeMap<&'static str, (Value, Origin)>,
    /// Required SHA-256 of the library of a user material.
    fingerprint: Option<String>,
    /// Keys, without the section, whose values have units.
    with_units: BTreeSet<&'static str>,
    /// Resolved path of the library that the user allows a file to load.
    allowed: Option<PathBuf>,
    /// Law that the calling program defines.
    pub(super) handed: Option<HandedLaw>,
    /// Notes on the block of another program that defines the law.
    notes: Vec<String>,
    /// Title of the law, if it differs from the name of its model.
    title: Option<String>,
}

/// Returns true if a key, without its section, belongs to no model because every hyperelastic law can have it.
fn is_of_any_law(name: &str) -> bool {
    is_of_relaxation(name) || is_of_softening(name)
}

impl MaterialSettings {
    /// Creates a model with user-defined parameters; names that are not valid keys are skipped.
    pub fn new(model: Model, parameters: &[(&str, f64)]) -> Self {
        let set = |(name, value): &(&str, f64)| {
            let key = Key::named(&format!("material.{name}"))?;
            Some((key.parts().1, (Value::Number(*value), Origin::Combination)))
        };
        Self {
            model,
            plane: None,
            set: parameters.iter().filter_map(set).collect(),
            fingerprint: None,
            with_units: BTreeSet::new(),
            allowed: None,
            handed: None,
            notes: Vec::new(),
            title: None,
        }
    }

    /// Sets the notes and the title of a law that was read from a block of another program.
    pub fn read_with(mut self, notes: Vec<String>, title: Option<String>) -> Self {
        (self.notes, self.title) = (notes, title);
        self
    }

    /// Notes on the block of another program that defines the law.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Title of the law, if it differs from the name of its model.
    pub(crate) fn title(&self) -> Option<&str> {
        self.title.as_deref()
    }

    /// Returns true for a law of the calling program, which no file or command can name.
    pub(crate) fn is_handed(&self) -> bool {
        self.handed.is_some()
    }

    /// Marks the value of a key as having a unit.
    pub(super) fn measure(&mut self, key: &'static Key) {
        self.with_units.insert(key.parts().1);
    }

    /// Marks the value of a key as having no unit.
    pub(super) fn measure_not(&mut self, key: &Key) {
        if key.parts().0 == "material" {
            self.with_units.remove(key.parts().1);
        }
    }

    /// Returns the units of the values.
    pub fn units(&self) -> Units {
        match self.with_units.is_empty() {
            true => Units::Own,
            false => Units::Si,
        }
    }

    /// Returns the unit of a parameter, named without its section, if values have units.
    pub fn unit(&self, name: &str) -> Option<&'static str> {
        let key = Key::named(&format!("material.{name}"))?;
        let unit = key.unit().and_then(units::si)?;
        self.units().are_si().then_some(unit)
    }

    /// Values of a law with dimensions: key, value (`None` for a file of numbers), whether it has a unit, and the place at which it was set. For a
    /// user-defined model, only values of known dimension are returned: its stresses, and values with units.
    pub(crate) fn measures(
        &self,
    ) -> impl Iterator<Item = (Key, Option<f64>, bool, Option<&Origin>)> {
        let is_law = matches!(self.model, Model::Law(_));
        // Parameters that follow from moduli have their units.
        let of_moduli: Vec<&str> = self.of_moduli().collect();
        let moduli = self
            .set
            .keys()
            .copied()
            .filter(|name| self.reads_modulus(name));
        let parameters = self
            .model
            .parameters()
            .iter()
            .map(|parameter| parameter.name);
        let names = parameters
            .filter(move |name| !of_moduli.contains(name))
            .chain(moduli)
            .chain(self.softening_stresses());
        let values = self.entries();
        let stresses = match self.model {
            Model::Own(model) => model.stresses,
            Model::Law(_) => &[],
        };
        let measured = self.with_units.iter().copied();
        let measured = measured.filter(|name| !stresses.contains(name) && !is_of_softening(name));
        let own = measured
            .chain(stresses.iter().copied())
            .chain(self.softening_stresses());
        names
            .filter(move |_| is_law)
            .chain(own.filter(move |_| !is_law))
            .filter_map(move |name| {
                let key = Key::named(&format!("material.{name}"))?;
                if is_law {
                    key.unit().and_then(units::si)?;
                }
                let known = values
                    .iter()
                    .find(|(own, _)| *own == name)
                    .map(|(_, value)| value);
                let value = known.or_else(|| self.given(name))?.number();
                if is_law {
                    value?;
                }
                Some((
                    *key,
                    value,
                    self.with_units.contains(name),
                    self.origin(name),
                ))
            })
            .chain(self.relaxation_times())
    }

    /// Returns true if a modulus, named without its section, determines parameters of the law.
    pub(crate) fn reads_modulus(&self, name: &str) -> bool {
        moduli::is_modulus(name) && matches!(self.model, Model::Law(_)) && !self.model.takes(name)
    }

    /// Value of a modulus, named without its section, if it determines parameters.
    pub(super) fn modulus(&self, name: &str) -> Option<&Value> {
        self.given(name).filter(|_| self.reads_modulus(name))
    }

    /// Moduli that were set instead of parameters.
    fn moduli(&self) -> Vec<(&'static str, f64)> {
        let given = self.set.iter().filter(|(name, _)| self.reads_modulus(name));
        given
            .filter_map(|(name, (value, _))| Some((*name, value.number()?)))
            .collect()
    }

    /// Parameters that follow from moduli.
    fn derived(&self) -> Result<Vec<(&'static str, f64)>, String> {
        let (Model::Law(law), given) = (self.model, self.moduli()) else {
            return Ok(Vec::new());
        };
        if given.is_empty() {
            return Ok(Vec::new());
        }
        let own = law
            .parameters
            .iter()
            .filter_map(|parameter| Some((parameter.name, self.given(parameter.name)?.number()?)));
        moduli::parameters(law, &own.collect::<Vec<_>>(), &given)
    }

    /// Names of the parameters that follow from moduli.
    pub(super) fn of_moduli(&self) -> impl Iterator<Item = &'static str> {
        let derived = self.derived().unwrap_or_default();
        derived.into_iter().map(|(name, _)| name)
    }

    /// Sets a key of the material other than its model; returns false if the value is of a wrong kind. The law itself checks numbers.
    pub(super) fn set(&mut self, key: &'static Key, value: &Value, origin: Origin) -> bool {
        let takes = match key.kind {
            Kind::Number(..) => value
                .number()
                .is_some_and(|number| ANY_DIMENSION.holds(number, "1")),
            kind => kind.accepts(value),
        };
        let name = key.parts().1;
        if name == PLANE {
            let read = value.word().map(|plane| (plane, origin));
            self.plane = read.or(self.plane.take().filter(|_| takes));
            return takes;
        }
        if takes {
            if name == LIBRARY {
                self.allowed = None;
            }
            self.set.insert(name, (value.clone(), origin));
        }
        takes
    }

    /// Checks that every key that was set belongs to the model, and that the model has all required keys.
    ///
    /// Moduli that are `open` will be varied: the parameters that follow from them are checked later.
    pub(super) fn check(&self, open: &[&str]) -> Result<(), SettingError> {
        self.check_names()?;
        self.check_relaxation()?;
        self.check_softening(open)?;
        let is_open = open
            .iter()
            .filter_map(|name| name.strip_prefix("material."))
            .any(moduli::is_modulus);
        if let (Err(told), false) = (self.derived(), is_open) {
            let set = self.set.iter();
            let moduli: Vec<_> = set.filter(|(name, _)| self.reads_modulus(name)).collect();
            // The modulus at the beginning of the message, if any.
            let blamed = moduli
                .iter()
                .find(|(name, _)| told.starts_with(&format!("material.{name} is ")));
            let blamed = blamed.or(moduli.first());
            let origin = blamed.map_or(Origin::Combination, |(_, (_, origin))| origin.clone());
            return Err(SettingError::new(origin, told).hint(
                "give two of young, poisson, bulk and shear, or the law's own parameters (`onset list materials`)",
            ));
        }
        match self.model {
            Model::Law(_) => Ok(()),
            Model::Own(model) => (model.check)(self),
        }
    }

    /// Checks that every key that was set belongs to the model.
    pub(super) fn check_names(&self) -> Result<(), SettingError> {
        let mut set = self.set.iter();
        set.try_for_each(|(name, (_, origin))| self.check_taken(name, origin))
    }

    /// Returns true for keys, without the section, that the law reads.
    pub(super) fn takes(&self, name: &str) -> bool {
        self.model.takes(name) || self.reads_modulus(name) || is_of_any_law(name)
    }

    /// Checks that the model has a parameter, or that it is a modulus of the law.
    pub(super) fn check_taken(&self, name: &str, origin: &Origin) -> Result<(), SettingError> {
        match self.takes(name) {
            true => Ok(()),
            false => Err(self.stray(name, origin.clone())),
        }
    }

    /// Error for a key that the model does not have.
    fn stray(&self, name: &str, origin: Origin) -> SettingError {
        let is_known = Model::all().any(|model| model.names().any(|known| known == name));
        if is_known {
            let message = format!(
                "{} has no parameter `{}`",
                self.model.name(),
                onset_frames::cut(name)
            );
            return SettingError::new(origin, message).hint(self.model.hint());
        }
        let error = SettingError::new(
            origin,
            format!("unknown key `material.{}`", onset_frames::cut(name)),
        );
        if let Some(told) = aliases::hint(name) {
            return error.hint(told);
        }
        let names = std::iter::once("model").chain(self.model.names());
        let full: Vec<String> = names.map(|name| format!("material.{name}")).collect();
        match nearest(&format!("material.{name}"), full.iter().map(String::as_str)) {
            Some(nearest) => error.hint(format!("did you mean `{nearest}`?")),
            None => error.hint(format!("{}: {}", self.model.name(), self.model.hint())),
        }
    }

    /// Returns the value of a key of the model, with its place.
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

    /// Place at which a key, named without its section, was set.
    pub(super) fn origin(&self, name: &str) -> Option<&Origin> {
        match (name, &self.plane) {
            (PLANE, plane) => plane.as_ref().map(|(_, origin)| origin),
            _ => self.set.get(name).map(|(_, origin)| origin),
        }
    }

    /// Returns the value of a key, named without its section, if it was set.
    pub fn given(&self, name: &str) -> Option<&Value> {
        self.set.get(name).map(|(value, _)| value)
    }

    /// Returns the condition on the directions beyond the dimensions of the body.
    pub fn plane(&self) -> Plane {
        self.plane
            .as_ref()
            .map_or_else(Plane::default, |(plane, _)| *plane)
    }

    /// Replaces the law, but keeps the condition on the directions beyond the dimensions of the body.
    pub fn take(&mut self, law: &Self) {
        let plane = self.plane.take();
        self.clone_from(law);
        self.plane = plane.or_else(|| law.plane.clone());
    }

    /// Returns the law for a body in three dimensions.
    pub(crate) fn in_space(mut self) -> Self {
        self.plane = None;
        self
    }

    /// Returns true for a two-dimensional law.
    pub fn is_membrane(&self) -> bool {
        self.plane() == Plane::Membrane
    }

    /// Returns true if the faces of a body of one or two dimensions are traction-free.
    pub fn is_plane_stress(&self) -> bool {
        self.plane() == Plane::Stress
    }

    /// Returns all entries of the model, by name without the section: parameters with their defaults, other keys that were set, and last the
    /// condition on the other directions.
    pub fn entries(&self) -> Vec<(&'static str, Value)> {
        let derived = self.derived().unwrap_or_default();
        let parameters = self.model.parameters().iter().map(|parameter| {
            let followed = derived.iter().find(|(name, _)| *name == parameter.name);
            let value = followed.map(|(_, value)| Value::Number(*value));
            let value = value.or_else(|| self.given(parameter.name).cloned());
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
            .filter(|(name, _)| self.model.takes(name) && !known(name) && !is_of_any_law(name))
            .map(|(name, (value, _))| (*name, value.clone()));
        let of_any_law = self
            .set
            .iter()
            .filter(|(name, _)| is_of_any_law(name))
            .map(|(name, (value, _))| (*name, value.clone()));
        let plane =
            (self.plane() != Plane::Strain).then(|| (PLANE, Value::Word(word_of(&self.plane()))));
        let others = own.chain(free).chain(of_any_law).chain(plane);
        parameters.chain(others).collect()
    }

    /// Returns all numeric parameters of the model with their values.
    pub fn values(&self) -> Vec<(&'static str, f64)> {
        let number = |(name, value): (&'static str, Value)| Some((name, value.number()?));
        let entries = self.entries().into_iter();
        let own = entries.filter(|(name, _)| !is_of_softening(name));
        own.filter_map(number).collect()
    }

    /// Marks the files that a request of the browser page names as possibly not chosen by the user.
    pub(crate) fn of_question(&mut self) {
        for file in [LIBRARY, "table"] {
            if let Some((_, origin)) = self.set.get_mut(file) {
                *origin = Origin::Question;
            }
        }
    }

    /// Permits the library that a file or a request names, if the user allows it.
    pub fn allow(&mut self, trust: &Trust) {
        if let Some((Value::Word(library), origin)) = self.set.get_mut(LIBRARY)
            && origin.can_be_a_strangers()
            && let Some(place) = trust.admitted(Path::new(library))
        {
            self.allowed = Some(place);
            *origin = Origin::CommandLine(format!("--allow-library {library}"));
        }
    }

    /// Refuses a library that a file or a request names unless the user allows it.
    ///
    /// # Errors
    /// [`SettingError`] with instructions to allow the library.
    pub fn permitted(&self) -> Result<(), SettingError> {
        let Some((Value::Word(library), origin)) = self.set.get(LIBRARY) else {
            return Ok(());
        };
        if !self.is_library() || !origin.can_be_a_strangers() {
            return Ok(());
        }
        let (bearer, command) = match origin {
            Origin::Question => ("page", "onset explore "),
            _ => ("file", ""),
        };
        let message = format!(
            "`material.library` is a program, {library:?}, and a {bearer} may not run programs unless you allow it; nothing was \
             loaded"
        );
        let library = quoted_file(Path::new(library));
        Err(SettingError::new(origin.clone(), message).hint(format!(
            "if you trust it: {command}--allow-library {library}, or permanently with the environment variable {TRUST_VARIABLE} (libraries or folders)"
        )))
    }

    /// Path of the library that the user allows a file to load, with links resolved.
    pub(super) fn allowed(&self) -> Option<&Path> {
        self.allowed.as_deref()
    }

    /// Returns true if the material is a program in a shared library, which is loaded to build it.
    pub fn is_library(&self) -> bool {
        self.umat().is_some()
    }

    /// Ties a user material to the current contents of its library; with other contents it cannot be built. Nothing is loaded.
    ///
    /// # Errors
    /// [`MaterialError`] when the library is not permitted, or cannot be read.
    pub fn pin(&mut self) -> Result<(), MaterialError> {
        self.fingerprint = self.umat_permitted()?.map(sum).transpose()?;
        Ok(())
    }

    /// Ties a user material to the library that computed a store.
    pub(crate) fn fingerprint_is(&mut self, stored: Option<&serde_json::Value>) {
        let stored = stored.and_then(serde_json::Value::as_str);
        self.fingerprint = stored.filter(|_| self.is_library()).map(str::to_owned);
    }

    /// Returns the required SHA-256 of the library of the material; `None` if any contents are accepted.
    pub fn fingerprint(&self) -> Option<&str> {
        self.fingerprint.as_deref()
    }

    /// Refuses traction-free faces for bodies or laws that cannot have them.
    pub(super) fn check_plane(&self, dimension: usize) -> Result<(), SettingError> {
        let Some((plane @ (Plane::Stress | Plane::Membrane), origin)) = &self.plane else {
            return Ok(());
        };
        let refused = |message: String, hint: &str| {
            Err(SettingError::new(origin.clone(), message).hint(hint))
        };
        if *plane == Plane::Membrane {
            return match dimension {
                2 => Ok(()),
                _ => refused(
                    format!(
                        "`material.plane` is membrane, and the discretization has {dimension} dimensions"
                    ),
                    "omit material.plane, or set a lattice of two dimensions",
                ),
            };
        }
        if dimension > 2 {
            return refused(
                "`material.plane` is stress, and the discretization has three dimensions and no out-of-plane direction".to_owned(),
                "omit material.plane, or set a lattice of two dimensions (a sheet) or a chain (a bar)",
            );
        }
        if self.model.is_in_rate_form() && !self.model.yields() {
            return refused(
                format!(
                    "`material.plane` is stress, which is not supported with {}: its stress is integrated in time, along which the faces would have \
                     to be free of traction",
                    self.model.name()
                ),
                "set material.plane=strain, or choose a hyperelastic law or a metal",
            );
        }
        Ok(())
    }

    /// Refuses plane stress for commands that evaluate the law in three dimensions.
    pub(super) fn check_in_space(&self) -> Result<(), SettingError> {
        match &self.plane {
            Some((Plane::Stress, origin)) => Err(SettingError::new(
                origin.clone(),
                "`material.plane` is stress, but this command evaluates the law in three dimensions",
            )
            .hint(
                "omit material.plane, or set material.plane=strain; state, path, map and others of particles read it, and `onset criteria` follows \
                 equibiaxial and planar loading in plane stress",
            )),
            _ => Ok(()),
        }
    }

    /// Builds the law for a body of the given dimension: three-dimensional, in plane or uniaxial stress, or two-dimensional.
    ///
    /// # Errors
    /// [`MaterialError`] when a parameter is invalid, or the law has no plane stress.
    pub(crate) fn law_in(&self, dimension: usize) -> Result<Arc<dyn Hyperelastic>, MaterialError> {
        self.in_dimension(self.build()?, dimension)
    }

    /// Law for a body of the given dimension.
    pub(crate) fn in_dimension(
        &self,
        law: Arc<dyn Hyperelastic>,
        dimension: usize,
    ) -> Result<Arc<dyn Hyperelastic>, MaterialError> {
        match self.plane() {
            Plane::Strain => Ok(law),
            Plane::Stress => Ok(Arc::new(PlaneStress::new(law, dimension)?)),
            Plane::Membrane => Ok(Arc::new(Membrane::new(law))),
        }
    }

    /// Builds the three-dimensional law.
    ///
    /// # Errors
    /// [`MaterialError`] when a parameter is invalid.
    pub fn build(&self) -> Result<Arc<dyn Hyperelastic>, MaterialError> {
        self.as_loaded()
    }

    /// Builds the law of the model, without relaxation and softening.
    pub(super) fn of_model(&self) -> Result<Box<dyn Hyperelastic>, MaterialError> {
        match self.model {
            // Moduli that an axis varies may be inadmissible at some states.
            Model::Law(law) => match self.derived() {
                Ok(_) => law.build(&self.values()),
                Err(message) => Err(MaterialError::External { message }),
            },
            Model::Own(model) => (model.build)(self),
        }
    }
}

impl Settings {
    /// Builds the law for the dimension of the discretization: three-dimensional, or in plane or uniaxial stress.
    ///
    /// # Errors
    /// [`MaterialError`] when a parameter is invalid, or the law has no plane stress.
    pub fn law(&self) -> Result<Arc<dyn Hyperelastic>, MaterialError> {
        self.material.law_in(self.dimension())
    }
}

#[cfg(test)]
mod tests {
    use super::{MaterialSettings, Model};
    use crate::settings::{Key, Settings, Value};
    use onset::kinematics::DeformationGradient;
    use onset::material::{BlatzKo, Hyperelastic, ModifiedMooneyRivlin, library};

    #[test]
    fn default_parameters_agree_with_the_laws() {
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
    fn every_parameter_of_every_law_can_be_set_and_read_back() {
        for law in library().iter().chain(onset::plasticity::library()) {
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
    fn parameters_with_the_same_name_have_the_same_unit_and_are_valid_keys() {
        for law in library().iter().chain(onset::plasticity::library()) {
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
    fn a_formula_accepts_parameters_of_any_name() {
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
    fn a_list_of_numbers_may_be_typed_with_or_without_brackets() {
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
