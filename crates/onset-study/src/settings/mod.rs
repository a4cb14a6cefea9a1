//! Settings of a user: material and discretization by dotted keys, from the command line or a study file, and the study itself.
//!
//! Every key is defined once, in the tables [`KEYS`], [`STATE_KEYS`] and [`MAP_KEYS`]. Parsing, suggestions, the schema and documentation follow from
//! them.

mod aliases;
mod axis;
mod blame;
mod body;
mod comparison;
mod declared;
mod effective;
mod error;
mod foreign;
mod key;
mod map;
mod material;
mod method;
mod model;
mod moduli;
mod needs;
mod notes;
pub(crate) mod presets;
#[cfg(test)]
mod readers;
mod relaxation;
mod renamed;
mod schema;
mod sections;
mod softening;
mod state;
mod study;
mod time;
mod toml;
mod trust;
pub(crate) mod units;

pub(crate) use aliases::all as aliases;
pub use aliases::is_preset;
pub use axis::{Axis, Quantity};
pub use body::{BODY_KEYS, BodySettings, GRIP_KEYS};
pub use comparison::{COMPARISON_KEYS, Candidate, CompareSettings, Comparison};
pub(crate) use effective::is_of_an_absent_term;
pub use effective::{Choice, Effective};
pub use error::{Origin, SettingError, did_you_mean};
pub(crate) use foreign::{DECK_NOTES, fields_of_keyword};
pub use foreign::{
    Program, Reading, WriteError, Writing, law_from, law_of, law_written, materials_of,
};
pub use key::{KEYS, Key, Kind, MAP_KEYS, STATE_KEYS, study_keys};
pub use map::{MapSettings, OUTPUTS, Outputs};
pub use material::{MaterialSettings, Plane};
pub(crate) use method::STEP_OF_RATES;
pub use method::{Bonds, Control, Family, MethodSettings, Shear, Unknowns, Velocities};
pub use model::{HandedLaw, Model, OwnModel};
pub use needs::{Cases, Need, Unmet};
pub use notes::notes_on_settings;
pub use onset::material::Admitted;
pub use presets::preset_names;
pub(crate) use renamed::topic as renamed_topic;
pub use renamed::{renamed_command, verdict as verdict_named};
pub use schema::schema;
pub(crate) use sections::sections;
pub use state::StateSettings;
pub use study::Study;
pub(crate) use time::{RUN_STEP, RUN_STEPPING};
pub use time::{RunStep, TimeIntegrator};
pub use trust::{TRUST_VARIABLE, Trust};
pub use units::{Units, stress_unit};

use crate::number::counted;
use declared::set_field;
use material::PLANE;
use onset::kernel::{Kernel, KernelError};
use onset::lattice::LatticeKind;
use onset::method::KernelMethodChoices;
use onset::scheme::element::ElementMesh;
use onset::time_step::Stepping;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde::de::value::{Error as ValueError, StrDeserializer};
use std::collections::{BTreeMap, BTreeSet};

/// Material and discretization, as set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Settings of the material.
    pub material: MaterialSettings,
    /// Lattice, kernel, and the settings of kernel methods.
    pub discretization: KernelMethodChoices,
    /// Family of methods, and the settings of the other families.
    pub method: MethodSettings,
    /// Time integrator, for methods that do not define their time step.
    pub integrator: TimeIntegrator,
    /// Time step of a run with another code.
    pub run: RunStep,
    /// Body of the study, if it has one.
    pub body: Option<BodySettings>,
    /// Place at which each key of the discretization was set.
    origins: BTreeMap<&'static str, Origin>,
    /// Keys of the discretization whose values have units.
    with_units: BTreeSet<&'static str>,
    /// Smoothing length divided by the spacing, if it sets the support, with its place.
    smoothing_length: Option<(f64, Origin)>,
}

impl Settings {
    /// Applies assignments such as `discretization.support=1.6` to the defaults, in order.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key, a value of a wrong kind, and the errors of [`Settings::check`].
    pub fn from_assignments<S: AsRef<str>>(assignments: &[S]) -> Result<Self, SettingError> {
        let mut settings = Self::default();
        for assignment in assignments {
            settings.assign(assignment.as_ref())?;
        }
        settings.check(&[])?;
        Ok(settings)
    }

    /// Checks the names and values of assignments to a part of the settings, such as a law without a method. Settings that complete the part, files and
    /// libraries are not needed.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key, a value of a wrong kind, a parameter that the law does not have, and a key that the method never uses.
    pub fn check_part<S: AsRef<str>>(assignments: &[S]) -> Result<(), SettingError> {
        const METHOD: &str = "discretization.method";
        let mut settings = Self::default();
        for assignment in assignments {
            settings.assign(assignment.as_ref())?;
        }
        settings.material.check_names()?;
        for (key, origin) in settings.set_keys() {
            let lacking = key.lacking(METHOD, &|name| settings.value(name));
            if lacking.is_none() {
                settings.check_read(key, origin.clone(), &[])?;
            }
        }
        Ok(())
    }

    /// Checks that every key that was set has an effect; `open` are keys that will be varied.
    ///
    /// # Errors
    /// [`SettingError`] for a parameter that the model does not have, and a key that the method does not use.
    pub fn check(&self, open: &[&str]) -> Result<(), SettingError> {
        self.material.check(open)?;
        self.material.check_plane(self.dimension())?;
        for (name, origin) in self.set_keys() {
            self.check_read(name, origin.clone(), open)?;
        }
        if let (Some((_, origin)), Some(key)) = (
            &self.smoothing_length,
            Key::named(aliases::SMOOTHING_LENGTH),
        ) {
            self.check_read(key, origin.clone(), open)?;
        }
        self.check_units()?;
        self.check_values(open)
    }

    /// Checks that either all values with dimensions have units, or none.
    pub(super) fn check_units(&self) -> Result<(), SettingError> {
        let keys = KEYS.iter().filter(|key| {
            key.parts().0 == "discretization" && key.unit().and_then(units::si).is_some()
        });
        let of_discretization = keys
            .filter(|key| self.unmet(key).is_none())
            .filter_map(|key| {
                let value = self.value(key.name)?.number()?;
                let has_unit = self.with_units.contains(key.name);
                Some((*key, Some(value), has_unit, self.origins.get(key.name)))
            });
        units::check(self.material.measures().chain(of_discretization)).map(drop)
    }

    /// Returns the units of answers.
    pub fn units(&self) -> Units {
        match self.with_units.is_empty() && !self.material.units().are_si() {
            true => Units::Own,
            false => Units::Si,
        }
    }

    /// Marks the value of a key as having a unit, for values of an axis that are set later.
    pub(super) fn measure(&mut self, key: &'static Key) {
        match key.parts().0 {
            "material" => self.material.measure(key),
            _ => drop(self.with_units.insert(key.name)),
        }
    }

    /// Sets the support that follows from the smoothing length and the kernel.
    fn follow_smoothing_length(&mut self) {
        if let Some((length, _)) = self.smoothing_length {
            let per_length = self
                .discretization
                .kernel
                .nominal_smoothing_length(1.0)
                .recip();
            self.discretization.support = length * per_length;
        }
    }

    /// Refuses a support that is set both directly and by the smoothing length.
    fn check_support_is_set_once(&self, name: &str, origin: &Origin) -> Result<(), SettingError> {
        let other = match name {
            "discretization.support" => self.smoothing_length.as_ref().map(|(_, other)| other),
            aliases::SMOOTHING_LENGTH => self.origins.get("discretization.support"),
            _ => None,
        };
        match (origin, other) {
            (Origin::CommandLine(_), Some(other @ Origin::CommandLine(_)))
            | (Origin::File { .. }, Some(other @ Origin::File { .. })) => {
                let message = format!(
                    "`{name}` sets the support, which {} has set already",
                    other.place()
                );
                Err(SettingError::new(origin.clone(), message).hint(
                    "give discretization.support or discretization.smoothing-length, not both",
                ))
            }
            _ => Ok(()),
        }
    }

    /// Forgets how the support was set, so that other settings can set it in either way.
    pub(super) fn with_other_support(mut self) -> Self {
        self.smoothing_length = None;
        self.origins.remove("discretization.support");
        self
    }

    /// Returns the keys of the discretization that were set, with their places, in the order of the table.
    pub(crate) fn set_keys(&self) -> impl Iterator<Item = (&'static Key, &Origin)> {
        KEYS.iter()
            .filter_map(|key| Some((key, self.origins.get(key.name)?)))
    }

    /// Returns the place at which a key was set, or `None`.
    pub(crate) fn origin(&self, name: &str) -> Option<&Origin> {
        match name.strip_prefix("material.") {
            Some(own) if own != "model" => self.material.origin(own),
            _ => match (name, &self.smoothing_length) {
                ("discretization.support" | aliases::SMOOTHING_LENGTH, Some((_, origin))) => {
                    Some(origin)
                }
                _ => self.origins.get(name),
            },
        }
    }

    /// Checks that the method admits the values that were set; `open` are keys that will be varied.
    ///
    /// # Errors
    /// [`SettingError`] for a lattice that does not fit the grid, and a control with zero coefficient.
    pub(crate) fn check_values(&self, open: &[&str]) -> Result<(), SettingError> {
        self.check_grid()?;
        let (control, coefficient) = (
            "discretization.control",
            "discretization.control-coefficient",
        );
        let is_idle = self.method.control != Control::None
            && self.method.control_coefficient == 0.0
            && !open.contains(&coefficient);
        match self.origins.get(control).filter(|_| is_idle) {
            Some(origin) => Err(SettingError::new(
                origin.clone(),
                format!("`{control}` has no effect: {coefficient} is 0"),
            )
            .hint(format!(
                "set {coefficient}, or omit `{control}`; it is used only with {coefficient} other than 0"
            ))),
            None => Ok(()),
        }
    }

    /// Checks the grid of material points, whose lattice follows from the number of dimensions.
    fn check_grid(&self) -> Result<(), SettingError> {
        let set = self.discretization.lattice;
        let grid = self.zone();
        match self.origins.get("discretization.lattice") {
            Some(origin) if self.method.method == Family::MaterialPoints && set != grid => {
                let message = format!(
                    "material points have a {} grid in {}, not a {} lattice",
                    grid.name(),
                    counted(self.dimension(), "dimension"),
                    set.name()
                );
                Err(SettingError::new(origin.clone(), message).hint(
                    "set discretization.lattice to chain, square or simple-cubic, or omit the key for a square grid",
                ))
            }
            _ => Ok(()),
        }
    }

    /// Returns the number of space dimensions of the discretization.
    pub fn dimension(&self) -> usize {
        match self.method.method {
            Family::FiniteElements => self.method.mesh.dimension(),
            _ => self.discretization.lattice.dimension(),
        }
    }

    /// Returns the lattice whose zone contains the wave vectors; for finite elements and material points it is the lattice of the nodes.
    pub fn zone(&self) -> LatticeKind {
        match (self.method.method, self.dimension()) {
            (Family::MaterialPoints, 1) => LatticeKind::Chain,
            (Family::MaterialPoints, 2) => LatticeKind::Square,
            (Family::MaterialPoints, _) => LatticeKind::SimpleCubic,
            (Family::FiniteElements, 1) => LatticeKind::Chain,
            (Family::FiniteElements, 2)
                if self.method.mesh == ElementMesh::TrianglesEquilateral =>
            {
                LatticeKind::Hexagonal
            }
            (Family::FiniteElements, 2) => LatticeKind::Square,
            (Family::FiniteElements, _) => LatticeKind::SimpleCubic,
            _ => self.discretization.lattice,
        }
    }

    /// Returns the zone of methods with a grid or a regular mesh. The zone of particles, and of sheared or distorted meshes, follows from their places.
    pub(crate) fn named_zone(&self) -> Option<LatticeKind> {
        let has_grid = match self.method.method {
            Family::MaterialPoints => true,
            Family::FiniteElements => {
                let own = &self.discretization;
                own.vectors.is_empty() && own.perturbation == 0.0
            }
            _ => false,
        };
        has_grid.then(|| self.zone())
    }

    /// Applies one assignment `key=value`.
    ///
    /// # Errors
    /// Fails like [`Settings::from_assignments`]; whether parameters fit the model is checked only at the end.
    pub fn assign(&mut self, assignment: &str) -> Result<(), SettingError> {
        let origin = Origin::CommandLine(format!("--set {assignment}"));
        let Some((name, text)) = assignment.split_once('=') else {
            return Err(SettingError::new(
                origin,
                format!("`{}` is not an assignment", onset_frames::cut(assignment)),
            )
            .hint("write --set key=value, for example --set discretization.support=1.6"));
        };
        let (name, text) = (name.trim(), text.trim());
        let kind = Key::named(name).map(|key| key.kind);
        self.set(name, &Value::typed(text, kind), origin)
    }

    /// Sets one key.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown key or a value of a wrong kind.
    pub fn set(&mut self, name: &str, value: &Value, origin: Origin) -> Result<(), SettingError> {
        let of_problem =
            |key: &&Key| matches!(key.parts().0, "material" | "discretization" | "time");
        let key = Key::for_setting(name, value.is_measure());
        let Some(key) = key.filter(of_problem) else {
            if let Some(key) = study_keys().find(|key| key.name == name) {
                let message =
                    format!("`{name}` has no effect here: this command computes no map of states");
                return Err(SettingError::new(origin, message)
                    .hint(format!("omit `{name}` ({})", key.meaning)));
            }
            if BODY_KEYS
                .iter()
                .chain(GRIP_KEYS)
                .any(|key| key.name == name)
            {
                let message = format!("`{name}` has no effect here: this command computes no body");
                return Err(SettingError::new(origin, message)
                    .hint("[body] and [[grips]] are written in a study file"));
            }
            return Err(unknown_key(name, KEYS.iter().map(|key| key.name), origin));
        };
        let key = renamed::of_word(key, value);
        let (name, typed) = (key.name, value);
        let wrong = |origin: Origin| {
            // Values tried along a range are refused with the message alone.
            let (range, hint) = match (key.kind.limits(), typed.is_measure()) {
                (Some(_), true) => (
                    format!("; expected {}", key.expects()),
                    key.meaning.to_owned(),
                ),
                _ => (
                    String::new(),
                    format!("expected {} ({})", key.expects(), key.meaning),
                ),
            };
            SettingError::new(
                origin,
                format!("`{name}` cannot be {}{range}", typed.brief()),
            )
            .hint(hint)
            .nearest_word(key.name, typed, key.words())
        };
        let measured = units::converted(key, typed, &origin)?;
        let has_unit = measured.is_some();
        let meant = aliases::meant(key, typed, &origin)?;
        let value = measured.as_ref().unwrap_or(&*meant);
        self.check_support_is_set_once(name, &origin)?;
        // The law itself restricts its parameters, because a user-defined model may use the name for another parameter.
        let accepted = Some(value).filter(|value| key.kind.accepts(value));
        let number = accepted.and_then(Value::number);
        let discretization = &mut self.discretization;
        let done = match name {
            "discretization.support" => {
                self.smoothing_length = None;
                assign(&mut discretization.support, number)
            }
            aliases::SMOOTHING_LENGTH => {
                let length = number.map(|length| Some((length, origin.clone())));
                assign(&mut self.smoothing_length, length)
            }
            "discretization.kernel" => match kernel(value) {
                // The formula itself reports its errors with their position.
                Some(Err(error)) if !matches!(error, KernelError::UnknownName { .. }) => {
                    return Err(SettingError::new(origin, format!("`{name}`: {error}")));
                }
                read => assign(&mut discretization.kernel, read.and_then(Result::ok)),
            },
            time::INTEGRATOR => assign(
                &mut self.integrator,
                match value {
                    Value::Word(word) => TimeIntegrator::named(word),
                    _ => None,
                },
            ),
            time::RUN_STEP => assign(&mut self.run.step, number),
            time::RUN_STEPPING => assign(
                &mut self.run.stepping,
                match value {
                    Value::Word(word) => Stepping::ALL.into_iter().find(|own| own.name() == word),
                    _ => None,
                },
            ),
            name if name.starts_with("discretization.") => accepted.is_some_and(|value| {
                let own = key.parts().1;
                set_field(discretization, own, value) || set_field(&mut self.method, own, value)
            }),
            "material.model" => assign(
                &mut self.material.model,
                match value {
                    Value::Word(word) => Model::named(word),
                    _ => None,
                },
            ),
            _ => self.material.set(key, value, origin.clone()),
        };
        if !done {
            return Err(wrong(origin));
        }
        self.follow_smoothing_length();
        // A combination carries no unit; the unit of the value that it replaces stays.
        if has_unit {
            self.measure(key);
        } else if origin != Origin::Combination {
            self.with_units.remove(key.name);
            self.material.measure_not(key);
        }
        for (other, text) in aliases::companions(key, typed) {
            let is_length_set =
                *other == "discretization.support" && self.smoothing_length.is_some();
            if !self.origins.contains_key(other) && !is_length_set {
                let kind = Key::named(other).map(|key| key.kind);
                self.set(other, &Value::typed(text, kind), Origin::Combination)?;
                self.origins.remove(other);
            }
        }
        let is_listed = key.parts().0 != "material" && name != aliases::SMOOTHING_LENGTH;
        if is_listed || name == "material.model" {
            self.origins.insert(key.name, origin);
        }
        Ok(())
    }
}

impl Settings {
    /// Returns the reason why a key of the discretization has no effect, or `None`.
    pub fn unmet(&self, key: &Key) -> Option<Unmet> {
        key.unmet(&|name| self.value(name))
    }

    /// Refuses a key that has no effect with the method and its other settings; `open` are keys that will be varied.
    ///
    /// # Errors
    /// [`SettingError`] with the settings under which the key is used.
    pub fn check_read(&self, key: &Key, origin: Origin, open: &[&str]) -> Result<(), SettingError> {
        if let ("material", name) = key.parts()
            && key.is_parameter()
        {
            return self.material.check_taken(name, &origin);
        }
        let value = |name: &str| self.value(name).filter(|_| !open.contains(&name));
        match key.unmet(&value) {
            None => Ok(()),
            Some(unmet) => Err(SettingError::unread(key, &unmet, origin)),
        }
    }

    /// Default value of a key of the discretization.
    fn default_of(&self, key: &Key) -> Option<Value> {
        match key.name {
            // A grid has only one lattice.
            "discretization.lattice" if self.method.method == Family::MaterialPoints => {
                let plane = self.dimension() == 2;
                plane.then(|| Value::Word(self.zone().name().to_owned()))
            }
            "discretization.stress-point-weight" | "discretization.shear-coefficient" => None,
            name => Self::default().value(name),
        }
    }

    /// Returns the value of a key; `None` if the key does not exist, or is a parameter of another material.
    pub fn value(&self, name: &str) -> Option<Value> {
        match name.split_once('.')? {
            ("time", "integrator") => Some(Value::Word(self.integrator.name().to_owned())),
            ("time", "step") => Some(Value::Number(self.run.step)),
            ("time", "stepping") => Some(Value::Word(self.run.stepping.name().to_owned())),
            ("material", "model") => Some(Value::Word(self.material.model.name().to_owned())),
            ("material", PLANE) => Some(Value::Word(word_of(&self.material.plane()))),
            ("material", name) => {
                let mut entries = self.material.entries().into_iter();
                match entries.find(|(entry, _)| *entry == name) {
                    Some((_, value)) => Some(value),
                    None => self.material.modulus(name).cloned(),
                }
            }
            ("discretization", "lattice") if self.method.method == Family::MaterialPoints => {
                Some(Value::Word(self.zone().name().to_owned()))
            }
            ("discretization", name) => {
                let own = serde_json::to_value(&self.discretization).ok()?;
                let others = serde_json::to_value(&self.method).ok()?;
                match own.get(name).or_else(|| others.get(name))? {
                    serde_json::Value::Bool(on) => Some(Value::Switch(*on)),
                    serde_json::Value::String(word) => Some(Value::Word(word.clone())),
                    serde_json::Value::Array(numbers) => {
                        let numbers = numbers.iter().map(serde_json::Value::as_f64);
                        numbers.collect::<Option<_>>().map(Value::Numbers)
                    }
                    other => other.as_f64().map(Value::Number),
                }
            }
            _ => None,
        }
    }
}

/// The kernel with a name or formula.
fn kernel(value: &Value) -> Option<Result<Kernel, KernelError>> {
    match value {
        Value::Word(text) => Some(text.parse()),
        _ => None,
    }
}

/// Assigns a value if it exists, and returns whether it exists.
fn assign<T>(target: &mut T, read: Option<T>) -> bool {
    let done = read.is_some();
    if let Some(value) = read {
        *target = value;
    }
    done
}

/// A value as typed.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Value {
    /// A number without a unit.
    Number(f64),
    /// A word, a text, or a number with a unit.
    Word(String),
    /// A Boolean, `true` or `false`.
    Switch(bool),
    /// A list of numbers.
    Numbers(Vec<f64>),
    /// A list of words.
    Words(Vec<String>),
}

impl Value {
    /// Interprets a text of the command line, given the expected kind of value.
    pub(crate) fn typed(text: &str, expected: Option<Kind>) -> Self {
        let word = || Self::Word(text.trim_matches('"').to_owned());
        match (expected, text, text.parse()) {
            (Some(Kind::Text), _, _) => word(),
            (Some(Kind::Numbers(..)), _, _) => numbers(text).map_or_else(word, Self::Numbers),
            (Some(Kind::Subset(_)), _, _) => Self::Words(words(text)),
            (_, "true", _) => Self::Switch(true),
            (_, "false", _) => Self::Switch(false),
            (_, _, Ok(number)) => Self::Number(number),
            (_, _, Err(_)) => word(),
        }
    }

    /// Returns true for a number with or without a unit.
    pub(crate) fn is_measure(&self) -> bool {
        match self {
            Self::Word(text) => units::split(text).is_some(),
            other => other.number().is_some(),
        }
    }

    pub(crate) fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            _ => None,
        }
    }

    /// Interprets the value as a named option; the name is the one used in serialization.
    pub(crate) fn word<T: DeserializeOwned>(&self) -> Option<T> {
        match self {
            Self::Word(word) => T::deserialize(StrDeserializer::<ValueError>::new(word)).ok(),
            _ => None,
        }
    }
}

/// A list of numbers as typed, with or without brackets.
fn numbers(text: &str) -> Option<Vec<f64>> {
    let inner = match text.strip_prefix('[') {
        Some(rest) => rest.strip_suffix(']')?,
        None => text,
    };
    match inner.trim() {
        "" => Some(Vec::new()),
        inner => inner.split(',').map(|n| n.trim().parse().ok()).collect(),
    }
}

/// A list of words as typed, with or without brackets and quotes.
fn words(text: &str) -> Vec<String> {
    let inner = text.trim_start_matches('[').trim_end_matches(']');
    let words = inner.split(',').map(|word| word.trim().trim_matches('"'));
    words
        .filter(|word| !word.is_empty())
        .map(str::to_owned)
        .collect()
}

impl Value {
    /// Beginning of a value in a message; values of files are not repeated at length.
    pub(crate) fn brief(&self) -> String {
        match self {
            Self::Word(word) => format!("\"{}\"", onset_frames::brief(word)),
            Self::Numbers(numbers) if numbers.len() > 9 => {
                format!("a list of {}", counted(numbers.len(), "number"))
            }
            Self::Words(words) => format!("a list of {}", counted(words.len(), "word")),
            other => other.to_string(),
        }
    }
}

impl std::fmt::Display for Value {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            // An exponent avoids hundreds of digits.
            Self::Number(number)
                if number.abs() >= 1e16 || (*number != 0.0 && number.abs() < 1e-6) =>
            {
                write!(formatter, "{number:e}")
            }
            Self::Number(number) => write!(formatter, "{number}"),
            Self::Word(word) => write!(formatter, "\"{word}\""),
            Self::Switch(on) => write!(formatter, "{on}"),
            Self::Numbers(numbers) => write!(formatter, "{numbers:?}"),
            Self::Words(words) => write!(formatter, "{words:?}"),
        }
    }
}

/// Error for the unknown name of a key that must be of a kind. A name without its section is completed, also if it is the name of another kind.
pub(crate) fn unknown_key_of(
    name: &str,
    is_of_kind: impl Fn(&Key) -> bool,
    origin: Origin,
) -> SettingError {
    let is_meant = |key: &&Key| is_of_kind(key) || key.parts().1 == name;
    let names = KEYS.iter().filter(is_meant).map(|key| key.name);
    unknown_key(name, names.collect::<Vec<_>>().into_iter(), origin)
}

/// Error for an unknown key, with the most similar known key.
pub(crate) fn unknown_key<'a>(
    name: &str,
    known: impl Iterator<Item = &'a str> + Clone,
    origin: Origin,
) -> SettingError {
    let told = match name.split_once('.') {
        Some((section, key)) => {
            format!("{}.{}", onset_frames::cut(section), onset_frames::cut(key))
        }
        None => onset_frames::cut(name),
    };
    let error = SettingError::new(origin, format!("unknown key `{told}`"));
    if let Some(told) = aliases::hint(name) {
        return error.hint(told);
    }
    // A key typed without its section is completed.
    let completed = known
        .clone()
        .find(|key| key.rsplit('.').next() == Some(name));
    // A mistyped key without its section is completed too.
    let own = |key: &'a str| key.rsplit('.').next().unwrap_or(key);
    let mistyped = || {
        let nearest = error::nearest(name, known.clone().map(own))?;
        known.clone().find(|key| own(key) == nearest)
    };
    let nearest = completed.or_else(|| error::nearest(name, known.clone()));
    match nearest.or_else(mistyped) {
        Some(nearest) => error.hint(format!("did you mean `{nearest}`?")),
        None => error.hint(format!("known keys: {}", listed(known))),
    }
}

/// Largest number of keys that a hint lists; of more it names the sections.
const LISTED_KEYS: usize = 40;

/// Names for a hint; the parameters of all laws are summarized.
fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let is_parameter = |name: &str| {
        KEYS.iter()
            .any(|key| key.name == name && key.is_parameter())
    };
    let mut listed: Vec<&str> = names
        .map(|name| match is_parameter(name) {
            true => "material.<parameter of the law>",
            false => name,
        })
        .collect();
    listed.dedup();
    if listed.len() > LISTED_KEYS {
        let mut sections: Vec<&str> = listed
            .iter()
            .filter_map(|name| Some(name.split_once('.')?.0))
            .collect();
        sections.dedup();
        let sections = sections.join(", ");
        return format!(
            "those of the sections {sections}; `onset list method NAME` has the keys of a method"
        );
    }
    listed.join(", ")
}

/// Name of an option, as it is written.
pub fn word_of<T: serde::Serialize>(choice: &T) -> String {
    match serde_json::to_value(choice) {
        Ok(serde_json::Value::String(word)) => word,
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error_of(assignment: &str) -> String {
        Settings::from_assignments(&[assignment])
            .expect_err("a wrong assignment")
            .to_string()
    }

    #[test]
    fn every_key_accepts_each_of_its_words() {
        for key in KEYS.iter() {
            let words: Vec<String> = match (key.words(), key.kind) {
                ([], Kind::Whole(least, _)) => vec![least.max(2).to_string()],
                ([], Kind::Switch) => vec!["true".to_owned()],
                ([], _) => vec!["0.4".to_owned()],
                (words, _) => words.iter().map(|word| (*word).to_owned()).collect(),
            };
            for word in words {
                let mut settings = Settings::default();
                settings
                    .assign(&format!("{}={word}", key.name))
                    .expect("a documented value");
            }
        }
    }

    #[test]
    fn assigned_words_are_the_names_that_serialization_uses() {
        let settings = Settings::from_assignments(&[
            "discretization.frame=eulerian",
            "discretization.support-size=scaled",
            "discretization.linearization=paper",
            "discretization.quadrature=stress-points-only",
        ])
        .expect("valid");
        let json = serde_json::to_value(&settings.discretization).expect("serializable");
        let method = serde_json::to_value(&settings.method).expect("serializable");
        assert_eq!(json["support-size"], "scaled");
        assert_eq!(json["quadrature"], "stress-points-only");
        assert_eq!(word_of(&settings.discretization.linearization), "paper");
        let keys: Vec<&str> = KEYS
            .iter()
            .filter_map(|key| key.name.strip_prefix("discretization."))
            .collect();
        let fields: Vec<&str> = [&json, &method]
            .into_iter()
            .filter_map(|value| value.as_object())
            .flat_map(|table| table.keys().map(String::as_str))
            .collect();
        assert_eq!(fields, keys, "the table of keys is the structure");
    }

    #[test]
    fn errors_for_unknown_keys_and_words_suggest_the_most_similar_one() {
        assert!(
            error_of("discretization.suport=2").contains("did you mean `discretization.support`?")
        );
        assert!(error_of("material.modle=blatz-ko").contains("`material.model`"));
        assert!(error_of("discretization.frame=lagrangan").contains("`lagrangian`"));
        assert!(error_of("discretization.support=wide").contains("expected a positive number"));
        assert!(error_of("discretization.support").contains("not an assignment"));
        assert!(error_of("zzz=1").contains("known keys"));
        assert!(error_of("body.contact=1").contains("written in a study file"));
    }

    #[test]
    fn a_kernel_is_a_name_or_a_formula() {
        let formula = "(1 - q)^5*(1 + 5*q)";
        let set = |text: &str| {
            Settings::from_assignments(&[format!("discretization.kernel={text}")])
                .expect("a kernel")
        };
        let settings = set(formula);
        let value = settings.value("discretization.kernel");
        assert_eq!(value, Some(Value::Word(formula.to_owned())));
        let json = serde_json::to_string(&settings.discretization).expect("serializable");
        let read: KernelMethodChoices = serde_json::from_str(&json).expect("the same");
        assert_eq!(read, settings.discretization);
        for kernel in Kernel::ALL {
            assert_eq!(set(kernel.name()).discretization.kernel, kernel);
        }
        let refused = error_of("discretization.kernel=(1 - q)^2*(1 + r)");
        assert!(
            refused.contains("column 16: `r` has no meaning here"),
            "{refused}"
        );
        assert!(
            error_of("discretization.kernel=cubc-spline").contains("did you mean `cubic-spline`")
        );
        assert!(error_of("discretization.kernel=1 - q/2").contains("0.5 at q = 1"));
    }

    #[test]
    fn parameters_of_another_model_are_refused() {
        assert!(error_of("material.mu=3").contains("modified-mooney-rivlin has no parameter `mu`"));
        assert!(Settings::from_assignments(&["material.mu=3", "material.model=blatz-ko"]).is_ok());
    }
}
