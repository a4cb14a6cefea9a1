//! Comparisons of several methods for one material, from TOML.

use super::key::{STRETCH, key};
use super::renamed;
use super::study;
use super::toml::{File, described, in_order, list, read_keys, scalar, typed};
use super::{
    KEYS, Key, Kind, MaterialSettings, Origin, SettingError, Settings, Trust, Value, unknown_key,
};
use crate::compare::{OWN_METHOD, PANELS};
use crate::number::counted;
use onset::kinematics::STRETCHES;
use onset::material::Admitted::{Between, Positive};
use onset::verdict::WEAK_WAVE_RATIO;
use serde::Serialize;
use toml::de::{DeArray, DeTable, DeValue};

/// The keys of a comparison that apply to every method.
pub const COMPARISON_KEYS: &[Key] = &[
    key(
        "compare.stretches",
        Kind::Numbers("1", STRETCH),
        "smallest and largest stretch of the states for which verdicts are compared",
    ),
    key(
        "compare.states",
        Kind::Whole(2, 256),
        "states along each axis of the window",
    ),
    key(
        "compare.tension",
        Kind::Number("1", Between(1.0, STRETCHES.1)),
        "largest stretch of the search for onsets in tension",
    ),
    key(
        "compare.compression",
        Kind::Number("1", Between(STRETCHES.0, 1.0)),
        "smallest stretch of the search for onsets in compression",
    ),
    key(
        "compare.weak",
        Kind::Number("1", Positive),
        "waves slower than this fraction of the material's slowest wave are listed as weakly controlled",
    ),
];

/// Options of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct CompareSettings {
    /// Smallest and largest stretch of the window of states.
    pub stretches: [f64; 2],
    /// Number of states along each axis of the window.
    pub states: usize,
    /// Largest stretch in tension.
    pub tension: f64,
    /// Smallest stretch in compression.
    pub compression: f64,
    /// Largest frequency of weakly controlled waves, relative to the slowest material wave.
    pub weak: f64,
}

impl Default for CompareSettings {
    fn default() -> Self {
        Self {
            stretches: [0.7, 1.5],
            states: 12,
            tension: 3.0,
            compression: 0.4,
            weak: WEAK_WAVE_RATIO,
        }
    }
}

/// A method of a comparison.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Name in tables and figures.
    pub name: String,
    /// Settings of material and discretization.
    pub settings: Settings,
    /// Place in the file.
    pub origin: Origin,
}

/// Several methods for one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Title of the comparison.
    pub title: String,
    /// Options that apply to every method.
    pub options: CompareSettings,
    /// Settings that all methods share: material and discretization.
    pub common: Settings,
    /// Methods that are compared.
    pub candidates: Vec<Candidate>,
    /// Text of the file.
    pub text: String,
}

/// Keys, without their section, that describe the particles and their weights, which all methods of a body share.
const SHARED: &[&str] = &[
    "lattice",
    "aspect",
    "vectors",
    "basis",
    "cells",
    "perturbation",
    "seed",
    "spacing",
    "density",
    "kernel",
    "support",
];

/// Keys, without their section, that set the support. The key of a method replaces the key of the shared settings.
const SUPPORTS: [&str; 2] = ["support", "smoothing-length"];

/// Key of the family of methods.
const METHOD: &str = "discretization.method";

/// Largest number of variants of methods in one comparison.
const MOST_VARIANTS: usize = 200;

/// Example of methods for messages.
const EXAMPLE: &str = "for example\n\n    [[methods]]\n    name = \"SPH\"\n    method = \"updated-sph\"\n\n    \
                       [[methods]]\n    name = \"total-Lagrangian SPH\"\n    method = \"total-lagrangian-sph\"\n";

impl Comparison {
    /// Replaces the largest relative frequency of weakly controlled waves in the file by the value given to a command, unless that value is the default.
    pub fn override_weak(&mut self, weak: f64) {
        if weak != WEAK_WAVE_RATIO {
            self.options.weak = weak;
        }
    }

    /// Reads a comparison, and applies assignments such as `material.model=blatz-ko` or `compare.states=24` to the shared settings.
    ///
    /// # Errors
    /// [`SettingError`] with file, line and column of the error.
    pub fn parse<S: AsRef<str>>(
        name: &str,
        text: &str,
        assignments: &[S],
    ) -> Result<Self, SettingError> {
        Self::read(name, text, assignments, &[], true)
    }

    /// Reads settings or a comparison, and replaces each method by its variants: `variations` such as `discretization.penalty=0,0.1,0.5` list the
    /// values of a key of `[discretization]`, separated by commas, or lists of numbers separated by semicolons. For a key without values, all its words are compared.
    /// Several variations are combined.
    ///
    /// # Errors
    /// [`SettingError`] for a key or a value that the methods do not accept, two equal variants, and more than 200 variants.
    pub fn varied<S: AsRef<str>>(
        name: &str,
        text: &str,
        assignments: &[S],
        variations: &[S],
    ) -> Result<Self, SettingError> {
        Self::read(name, text, assignments, variations, true)
    }

    /// Replaces each method by its variants, and checks all methods.
    fn vary<S: AsRef<str>>(&mut self, variations: &[S]) -> Result<(), SettingError> {
        for variation in variations {
            self.vary_key(variation.as_ref())?;
        }
        if !variations.is_empty() {
            for candidate in &self.candidates {
                candidate.settings.check(&[])?;
                candidate.settings.check_admitted()?;
            }
        }
        self.check_dimensions()
    }

    /// Replaces each method by its variants for the values of one key.
    fn vary_key(&mut self, variation: &str) -> Result<(), SettingError> {
        let origin = Origin::CommandLine(format!("--vary {variation}"));
        let refused = |message: String, hint: &str| {
            Err(SettingError::new(origin.clone(), message).hint(hint.to_owned()))
        };
        const WRITTEN: &str =
            "write --vary KEY=VALUE,VALUE, for example --vary discretization.penalty=0,0.1,0.5";
        let (key, values) = match variation.split_once('=') {
            Some((key, values)) => (key.trim(), Some(values)),
            None => (variation.trim(), None),
        };
        if key.starts_with("material.") || key.starts_with("compare.") {
            return refused(
                format!("`{key}` is the same for all methods of a comparison"),
                "vary a key of [discretization]; `onset limit` and `onset map` vary parameters of the law",
            );
        }
        if key == "discretization.preset" || key == "preset" {
            return refused(
                format!("unknown key `{key}`"),
                "presets are values of the method: --vary discretization.method=lammps-smd-tlsph,sphinxsys-tl; `onset list presets` lists them",
            );
        }
        let Some(known) = Key::named(key) else {
            let names = KEYS.iter().map(|key| key.name);
            let names = names.filter(|name| name.starts_with("discretization."));
            return Err(unknown_key(key, names, origin));
        };
        let words = known.words();
        let values: Vec<&str> = match values {
            Some(values) => {
                let separator = if values.contains(';') { ';' } else { ',' };
                values.split(separator).map(str::trim).collect()
            }
            None if words.is_empty() => {
                return refused(format!("`{variation}` has no values"), WRITTEN);
            }
            None => words.to_vec(),
        };
        if values.iter().any(|value| value.is_empty()) {
            return refused(format!("`{variation}` has an empty value"), WRITTEN);
        }
        let count = self.candidates.len() * values.len();
        if count > MOST_VARIANTS {
            return refused(
                format!(
                    "{count} methods are too many to compare; expected at most {MOST_VARIANTS}"
                ),
                "list fewer values",
            );
        }
        let short = key.strip_prefix("discretization.").unwrap_or(key);
        let mut variants: Vec<Candidate> = Vec::new();
        for candidate in &self.candidates {
            for value in &values {
                let mut settings = candidate.settings.clone();
                if SUPPORTS.contains(&short) {
                    settings = settings.with_other_support();
                }
                settings.set(key, &Value::typed(value, Some(known.kind)), origin.clone())?;
                let own = match short {
                    "method" => (*value).to_owned(),
                    _ => format!("{short} {value}"),
                };
                let name = match candidate.name.as_str() {
                    "" => own,
                    before => format!("{before}, {own}"),
                };
                if variants.iter().any(|other| other.name == name) {
                    return refused(format!("`{value}` is listed twice"), "list each value once");
                }
                variants.push(Candidate {
                    name,
                    settings,
                    origin: origin.clone(),
                });
            }
        }
        self.candidates = variants;
        Ok(())
    }

    /// Checks `[compare]` and `[[methods]]` of a study that is mapped; settings that its axes vary may be missing.
    pub(super) fn check(name: &str, text: &str) -> Result<(), SettingError> {
        Self::read::<&str>(name, text, &[], &[], false).map(drop)
    }

    fn read<S: AsRef<str>>(
        name: &str,
        text: &str,
        assignments: &[S],
        variations: &[S],
        settled: bool,
    ) -> Result<Self, SettingError> {
        let file = File::new(name, text);
        let table = file.table()?;
        let mut comparison = Self {
            title: String::new(),
            options: CompareSettings::default(),
            common: Settings::default(),
            candidates: Vec::new(),
            text: text.to_owned(),
        };
        let (mut methods, mut is_study) = (None, false);
        for (key, value) in in_order(table.get_ref()) {
            match (key.get_ref().as_ref(), value.get_ref()) {
                ("title", DeValue::String(title)) => comparison.title = title.to_string(),
                ("methods", DeValue::Array(items)) => methods = Some((file.of(key), items)),
                ("material" | "discretization" | "time", DeValue::Table(inner)) => {
                    let section = key.get_ref().as_ref();
                    let names = KEYS.iter().map(|key| key.name);
                    read_keys(&file, section, inner, names, |key, value, origin| {
                        comparison.common.set(key.name, value, origin)
                    })?;
                }
                ("compare", DeValue::Table(inner)) => comparison.read_options(&file, inner)?,
                // A study can also be compared; its sections for maps are checked but not used.
                ("state" | "axes" | "map" | "body" | "grips", _) => is_study = true,
                (
                    section @ ("material" | "discretization" | "time" | "compare" | "methods"),
                    other,
                ) => {
                    let message = format!("`{section}` cannot be {}", described(other));
                    let expected = match section {
                        "methods" => format!("expected [[methods]], {EXAMPLE}"),
                        _ => format!("expected a table: [{section}] with its keys below"),
                    };
                    return Err(SettingError::new(file.of(key), message).hint(expected));
                }
                ("title", other) => {
                    let message = format!("`title` cannot be {}", described(other));
                    return Err(SettingError::new(file.of(value), message)
                        .hint("expected a string in quotes"));
                }
                (other, _) => {
                    let known = [
                        "title",
                        "material",
                        "discretization",
                        "time",
                        "compare",
                        "methods",
                    ];
                    return Err(unknown_key(other, known.into_iter(), file.of(key)));
                }
            }
        }
        for assignment in assignments {
            comparison.assign(assignment.as_ref())?;
        }
        comparison.common.material.check(&[])?;
        comparison.common.check_units()?;
        if is_study {
            let study = study::read(name, text)?;
            comparison.common.body.clone_from(&study.settings.body);
            let common = &comparison.common;
            study
                .check_nothing_is_left_open(|key| !settled || common.origin(key.name).is_some())?;
            if settled {
                study.note_unread_state();
            }
        }
        let methods = methods.filter(|(_, items): &(_, &DeArray<'_>)| !items.is_empty());
        let has_method = comparison.common.origin(METHOD).is_some();
        if !variations.is_empty() && methods.is_none() {
            comparison.candidates.push(Candidate {
                name: String::new(),
                settings: comparison.common.clone(),
                origin: Origin::Combination,
            });
            comparison.vary(variations)?;
            return Ok(comparison);
        }
        if (is_study || has_method) && methods.is_none() {
            if settled {
                comparison.with_known_methods()?;
            }
            return Ok(comparison);
        }
        let Some((origin, items)) = methods else {
            let message = "the comparison has no methods; expected one or more";
            return Err(SettingError::new(file.at(0), message).hint(EXAMPLE));
        };
        for item in items.iter() {
            let DeValue::Table(table) = item.get_ref() else {
                let message = format!("a method cannot be {}", described(item.get_ref()));
                return Err(SettingError::new(origin, message).hint(EXAMPLE));
            };
            let candidate = comparison.read_method(&file, file.of(item), table)?;
            comparison.candidates.push(candidate);
        }
        // The variants of a single method differ by their varied settings.
        if variations.is_empty() || comparison.candidates.len() > 1 {
            comparison.name_by_differences();
        }
        comparison.check_names()?;
        comparison.check_dimensions()?;
        comparison.check_common_is_read()?;
        comparison.vary(variations)?;
        Ok(comparison)
    }

    /// Names each method without a name by its family and by the settings in which the methods without names differ.
    fn name_by_differences(&mut self) {
        let unnamed = self.candidates.iter().filter(|own| own.name.is_empty());
        let settings: Vec<Settings> = unnamed.map(|own| own.settings.clone()).collect();
        let value = |own: &Settings, key: &Key| {
            let is_read = own.unmet(key).is_none();
            own.value(key.name).filter(|_| is_read)
        };
        let differing: Vec<&Key> = KEYS
            .iter()
            .filter(|key| key.parts().0 == "discretization" && key.name != METHOD)
            .filter(|key| {
                let is_set = settings.iter().any(|own| own.origin(key.name).is_some());
                let mut pairs = settings.windows(2);
                is_set && pairs.any(|pair| value(&pair[0], key) != value(&pair[1], key))
            })
            .collect();
        for candidate in self.candidates.iter_mut().filter(|own| own.name.is_empty()) {
            let own = &candidate.settings;
            let family = own.value(METHOD).map(bare);
            let differences = differing.iter().filter_map(|key| {
                own.origin(key.name)?;
                Some(format!("{} {}", key.parts().1, bare(value(own, key)?)))
            });
            let parts: Vec<String> = family.into_iter().chain(differences).collect();
            candidate.name = parts.join(", ");
        }
    }

    /// Refuses two methods with the same name.
    fn check_names(&self) -> Result<(), SettingError> {
        for (n, own) in self.candidates.iter().enumerate() {
            if self.candidates[..n]
                .iter()
                .any(|other| other.name == own.name)
            {
                let message = format!("two methods are called \"{}\"", own.name);
                return Err(SettingError::new(own.origin.clone(), message)
                    .hint("give every method a different name"));
            }
        }
        Ok(())
    }

    /// Adds the built-in methods to the method of the study, with the study's material and particles.
    fn with_known_methods(&mut self) -> Result<(), SettingError> {
        self.common.check(&[])?;
        self.common.check_admitted()?;
        let dimension = self.common.dimension();
        let (name, text) = PANELS[dimension - 1];
        let panel = Self::parse::<&str>(name, text, &[])?;
        self.candidates.push(Candidate {
            name: OWN_METHOD.to_owned(),
            settings: self.common.clone(),
            origin: Origin::Combination,
        });
        for mut candidate in panel.candidates {
            candidate.settings.material = self.common.material.clone();
            for (key, origin) in self.common.set_keys() {
                let is_free = candidate.settings.origin(key.name) == panel.common.origin(key.name);
                let value = self.common.value(key.name).filter(|_| is_free);
                if let (true, Some(value)) = (SHARED.contains(&key.parts().1), value) {
                    candidate.settings.set(key.name, &value, origin.clone())?;
                }
            }
            self.candidates.push(candidate);
        }
        self.check_dimensions()
    }

    /// Refuses shared keys without effect on any method.
    fn check_common_is_read(&self) -> Result<(), SettingError> {
        for (key, origin) in self.common.set_keys() {
            let unmet = |candidate: &Candidate| candidate.settings.unmet(key);
            let mut candidates = self.candidates.iter();
            if let (Some(unmet), true) = (
                self.candidates.first().and_then(unmet),
                candidates.all(|candidate| unmet(candidate).is_some()),
            ) {
                return Err(SettingError::unread(key, &unmet, origin.clone()));
            }
        }
        Ok(())
    }

    /// Replaces the material of all methods.
    pub fn of_material(mut self, material: &MaterialSettings) -> Self {
        self.common.material.take(material);
        for candidate in &mut self.candidates {
            candidate.settings.material.take(material);
        }
        self
    }

    /// Applies the user's permissions for libraries to all methods.
    pub fn allowing(mut self, trust: &Trust) -> Self {
        let candidates = self.candidates.iter_mut();
        let all = candidates.map(|candidate| &mut candidate.settings);
        for settings in all.chain([&mut self.common]) {
            settings.material.allow(trust);
        }
        self
    }

    /// Applies one assignment `key=value`.
    fn assign(&mut self, assignment: &str) -> Result<(), SettingError> {
        let Some((name, text)) = assignment.split_once('=') else {
            return self.common.assign(assignment);
        };
        let origin = Origin::CommandLine(format!("--set {assignment}"));
        let name = renamed::key(name.trim());
        let Some(known) = COMPARISON_KEYS.iter().find(|key| key.name == name) else {
            if name.starts_with("compare.") {
                let names = COMPARISON_KEYS.iter().map(|key| key.name);
                return Err(unknown_key(name, names, origin));
            }
            return self.common.assign(assignment);
        };
        let value = Value::typed(text.trim(), Some(known.kind));
        if known.kind.accepts(&value) && self.options.set(known.parts().1, &value) {
            return Ok(());
        }
        let message = format!("`{}` cannot be {}", known.name, value.brief());
        Err(SettingError::new(origin, message).hint(expected(known)))
    }

    /// Returns the number of space dimensions of all methods.
    pub fn dimension(&self) -> usize {
        let first = self.candidates.first();
        first.map_or(2, |candidate| candidate.settings.dimension())
    }

    fn check_dimensions(&self) -> Result<(), SettingError> {
        let dimension = self.dimension();
        let other = self
            .candidates
            .iter()
            .find(|candidate| candidate.settings.dimension() != dimension);
        other.map_or(Ok(()), |other| {
            let message = format!(
                "\"{}\" has {}, the first method has {dimension}",
                other.name,
                counted(other.settings.dimension(), "dimension")
            );
            Err(SettingError::new(other.origin.clone(), message)
                .hint("compare methods of the same number of dimensions"))
        })
    }

    fn read_method(
        &self,
        file: &File<'_>,
        origin: Origin,
        table: &DeTable<'_>,
    ) -> Result<Candidate, SettingError> {
        let mut settings = self.common.clone();
        if SUPPORTS.into_iter().any(|own| table.contains_key(own)) {
            settings = settings.with_other_support();
        }
        let mut name = String::new();
        let mut own_keys = Vec::new();
        for (key, value) in in_order(table) {
            match (key.get_ref().as_ref(), value.get_ref()) {
                ("name", DeValue::String(text)) if !text.trim().is_empty() => {
                    name = text.trim().to_owned();
                }
                ("name", other) => {
                    let message = format!("`name` cannot be {}", described(other));
                    return Err(SettingError::new(file.of(value), message)
                        .hint("expected a string in quotes, for example \"SPH\""));
                }
                (own, _) => {
                    let full = format!("discretization.{own}");
                    let Some(known) = Key::named(renamed::key(&full)) else {
                        let names = KEYS.iter().filter_map(|key| {
                            let (section, name) = key.parts();
                            (section == "discretization").then_some(name)
                        });
                        return Err(unknown_key(own, names, file.of(key)));
                    };
                    let typed = typed(known, value, file)?;
                    let known = renamed::of_word(known, &typed);
                    settings.set(known.name, &typed, file.of(value))?;
                    own_keys.push((known, file.of(key)));
                }
            }
        }
        for (key, origin) in own_keys {
            settings.check_read(key, origin, &[])?;
        }
        settings.check_values(&[])?;
        settings.check_units()?;
        settings.check_admitted()?;
        Ok(Candidate {
            name,
            settings,
            origin,
        })
    }

    fn read_options(&mut self, file: &File<'_>, table: &DeTable<'_>) -> Result<(), SettingError> {
        for (key, value) in in_order(table) {
            let name = format!("compare.{}", key.get_ref());
            let now = renamed::key(&name);
            if let Some(known) = Key::named(now).filter(|_| now != name) {
                let given = typed(known, value, file)?;
                self.common.set(now, &given, file.of(value))?;
                continue;
            }
            let Some(known) = COMPARISON_KEYS.iter().find(|key| key.name == name) else {
                let names = COMPARISON_KEYS.iter().map(|key| key.name);
                return Err(unknown_key(&name, names, file.of(key)));
            };
            let given = typed(known, value, file)?;
            if !(known.kind.accepts(&given) && self.options.set(known.parts().1, &given)) {
                let message = format!("`{name}` cannot be {}", described_value(value.get_ref()));
                return Err(SettingError::new(file.of(value), message).hint(expected(known)));
            }
        }
        Ok(())
    }
}

/// A value as text; a word without quotes.
fn bare(value: Value) -> String {
    match value {
        Value::Word(word) => word,
        other => other.to_string(),
    }
}

/// Expected value and meaning of an option.
fn expected(key: &Key) -> String {
    let expects = match key.name {
        "compare.stretches" => "two positive numbers, the smaller one first".to_owned(),
        _ => key.expects(),
    };
    format!("expected {expects} ({})", key.meaning)
}

/// A value as a message shows it, with the numbers of a list.
fn described_value(value: &DeValue<'_>) -> String {
    match (scalar(value), list(value)) {
        (Some(value), _) => value.brief(),
        (_, Some(numbers)) => Value::Numbers(numbers).brief(),
        _ => described(value),
    }
}

impl CompareSettings {
    /// Sets an option; returns false if it does not accept the value.
    fn set(&mut self, name: &str, value: &Value) -> bool {
        let number = value.number();
        match (name, value, number) {
            ("stretches", Value::Numbers(ends), _) => match ends[..] {
                [low, high] if 0.0 < low && low < high => {
                    self.stretches = [low, high];
                    true
                }
                _ => false,
            },
            ("states", _, Some(count)) => {
                self.states = count as usize;
                true
            }
            ("tension", _, Some(end)) if end > 1.0 => {
                self.tension = end;
                true
            }
            ("compression", _, Some(end)) if end < 1.0 => {
                self.compression = end;
                true
            }
            ("weak", _, Some(share)) => {
                self.weak = share;
                true
            }
            _ => false,
        }
    }
}
