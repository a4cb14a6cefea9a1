//! Settings in effect: every setting that material and method use, with its value, and whether it is the default.

use super::{KEYS, Key, Settings, Study, Units, Value, Velocities, units};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

/// Setting that is in effect.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Choice {
    /// Value that is in effect.
    pub value: Value,
    /// Whether the value is the default.
    pub default: bool,
    /// SI unit, if values have units.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<&'static str>,
}

/// Every choice that material and method read, by key, in the order of the table of keys. Serializes as a map from the key to
/// `value` and `default`.
///
/// ```
/// use onset_study::settings::Settings;
/// let settings = Settings::from_assignments(&["discretization.method=updated-sph"])?;
/// let text = settings.effective().to_string();
/// assert!(text.contains("updated-sph") && !text.contains("quadrature"));
/// # Ok::<(), onset_study::settings::SettingError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Effective(Vec<(&'static str, Choice)>);

impl Serialize for Effective {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, choice) in &self.0 {
            map.serialize_entry(name, choice)?;
        }
        map.end()
    }
}

impl Settings {
    /// Returns every setting that is in effect.
    pub fn effective(&self) -> Effective {
        let of_material = self.material.entries().into_iter().map(|(name, value)| {
            let parameters = self.material.model.parameters().iter();
            let default = parameters
                .filter(|own| own.name == name)
                .any(|own| value == Value::Number(own.default));
            let key = Key::named(&format!("material.{name}"));
            let unit = key.and_then(|key| self.unit(key));
            let name = key.map_or(name, |key| key.name);
            (
                name,
                Choice {
                    value,
                    default,
                    unit,
                },
            )
        });
        let of_method = KEYS.iter().filter(|key| key.name == "material.model");
        let model = of_method.filter_map(|key| self.choice(key));
        let keys = KEYS.iter().filter(|key| {
            matches!(key.parts().0, "discretization" | "time") && self.unmet(key).is_none()
        });
        // The method goes first, because it determines which other settings exist.
        let (method, others): (Vec<_>, Vec<_>) = keys
            .filter_map(|key| self.choice(key))
            .partition(|(name, _)| *name == "discretization.method");
        Effective(
            model
                .chain(of_material)
                .chain(method)
                .chain(others)
                .collect(),
        )
    }

    /// Settings in effect except a varied one. If it is a modulus, the moduli that were set replace the parameters that follow from them.
    pub(crate) fn effective_beside(&self, varied: &str) -> Effective {
        let mut effective = self.effective();
        let (moduli, follows) = self.moduli();
        if moduli.iter().any(|(name, _)| *name == varied) {
            effective
                .0
                .retain(|(name, _)| !follows.iter().any(|own| own == name));
            let after_model = 1.min(effective.0.len());
            effective.0.splice(after_model..after_model, moduli);
        }
        effective.without(varied)
    }

    /// The moduli that were set instead of parameters, and the keys of the parameters that follow from them.
    pub(crate) fn moduli(&self) -> (Vec<(&'static str, Choice)>, Vec<String>) {
        let moduli = KEYS.iter().filter(|key| key.is_modulus());
        let moduli = moduli.filter_map(|key| {
            let choice = Choice {
                value: self.material.modulus(key.parts().1)?.clone(),
                default: false,
                unit: self.unit(key),
            };
            Some((key.name, choice))
        });
        let follows = self.material.of_moduli();
        let follows = follows.map(|name| format!("material.{name}"));
        (moduli.collect(), follows.collect())
    }

    fn choice(&self, key: &'static Key) -> Option<(&'static str, Choice)> {
        let value = self.value(key.name)?;
        let default = Some(&value) == self.default_of(key).as_ref();
        let unit = self.unit(key);
        Some((
            key.name,
            Choice {
                value,
                default,
                unit,
            },
        ))
    }

    /// SI unit of a key's value, if values have units.
    pub(crate) fn unit(&self, key: &Key) -> Option<&'static str> {
        let unit = key.unit().and_then(units::si)?;
        self.units().are_si().then_some(unit)
    }
}

impl Study {
    /// Returns the settings in effect at all states, except the varied ones.
    pub fn effective(&self) -> Effective {
        let mut effective = self.settings.effective();
        let varied = |name: &str| {
            self.axes
                .iter()
                .any(|axis| axis.quantity.key_name() == name)
        };
        let follows = self.follows();
        let follows = |name: &str| follows.iter().any(|own| own == name);
        effective
            .0
            .retain(|(name, _)| !varied(name) && !follows(name));
        effective
    }
}

impl Effective {
    /// Removes the setting of a key.
    pub fn without(mut self, name: &str) -> Self {
        self.0.retain(|(known, _)| *known != name);
        self
    }

    /// Keeps only the settings whose keys satisfy a condition.
    pub fn only(mut self, is_meant: &dyn Fn(&str) -> bool) -> Self {
        self.0.retain(|(name, _)| is_meant(name));
        self
    }

    /// Lists the settings with their names, in a line.
    pub fn told(&self) -> String {
        let is_absent = |name: &str| {
            let own = name.strip_prefix("material.");
            own.is_some_and(|own| self.is_absent(own))
        };
        let present = self.0.iter().filter(|(name, _)| !is_absent(name));
        let choices = present.map(|(name, choice)| {
            let name = name.split_once('.').map_or(*name, |(_, own)| own);
            choice.told(name)
        });
        choices.collect::<Vec<_>>().join(", ")
    }

    /// Returns the setting of a key, or `None`.
    pub fn get(&self, name: &str) -> Option<&Choice> {
        let mut choices = self.0.iter();
        Some(&choices.find(|(known, _)| *known == name)?.1)
    }

    /// Returns every setting with its key.
    pub fn choices(&self) -> impl Iterator<Item = (&'static str, &Choice)> {
        self.0.iter().map(|(name, choice)| (*name, choice))
    }

    /// Returns the settings that are not defaults.
    pub fn chosen(&self) -> impl Iterator<Item = (&'static str, &Choice)> {
        self.choices().filter(|(_, choice)| !choice.default)
    }

    /// Returns the units of the answer's numbers.
    pub fn units(&self) -> Units {
        match self.0.iter().any(|(_, choice)| choice.unit.is_some()) {
            true => Units::Si,
            false => Units::Own,
        }
    }

    /// Returns true for a constant of a term that the law does not have.
    fn is_absent(&self, name: &str) -> bool {
        is_of_an_absent_term(name, |own| {
            self.get(&format!("material.{own}"))?.value.number()
        })
    }

    /// Two lines for a section: the model or method with the settings that are not defaults, and the defaults.
    fn lines(&self, section: &str, head: &str) -> (String, String) {
        let (mut first, mut chosen, mut defaults) = (String::new(), Vec::new(), Vec::new());
        for (name, choice) in &self.0 {
            let Some((_, name)) = name.split_once('.').filter(|(own, _)| *own == section) else {
                continue;
            };
            // An empty list carries no information.
            let is_empty = matches!(&choice.value, Value::Numbers(numbers) if numbers.is_empty());
            if is_empty || (section == "material" && self.is_absent(name)) {
                continue;
            }
            match (name == head, &choice.value, choice.default) {
                (true, Value::Word(word), true) => first = format!("{word} (default)"),
                (true, Value::Word(word), false) => first.clone_from(word),
                (_, _, false) => chosen.push(choice.told(name)),
                (_, _, true) => defaults.push(choice.told(name)),
            }
        }
        if !chosen.is_empty() {
            first = format!("{first}: {}", chosen.join(", "));
        }
        (first, defaults.join(", "))
    }

    /// Returns two texts: the model with the parameters that are not defaults, and the defaults.
    pub fn material(&self) -> (String, String) {
        self.lines("material", "model")
    }

    /// Returns two texts: the method with the settings that are not defaults, and the defaults.
    pub fn discretization(&self) -> (String, String) {
        self.lines("discretization", "method")
    }

    /// Describes the material in one line.
    pub fn law(&self) -> String {
        joined(self.material())
    }

    /// Describes the discretization in one line.
    pub fn method(&self) -> String {
        joined(self.discretization())
    }

    /// Lines below an answer in continuous time. For methods with a velocity transfer they mention the effects that are omitted.
    pub(crate) fn in_continuous_time(&self) -> String {
        let transfer = self.get("discretization.transfer");
        let left_out = match transfer.map(|choice| &choice.value) {
            Some(Value::Word(word)) if word != Velocities::Continuous.name() => format!(
                "{:<24}continuous here; onset state gives the damping of the {word} transfer and the largest step\n",
                "time"
            ),
            _ => String::new(),
        };
        format!("{self}{left_out}")
    }

    /// Describes all settings in a sentence for the caption of a figure.
    pub fn caption(&self) -> String {
        let (material, method) = (self.law(), self.method());
        let text = format!("Material: {material}. Method: {method}.");
        text.replace("kg/m^3", "kg/m³")
    }
}

/// Returns true for a constant of a term whose coefficient is zero, such as `alpha4` if `mu4` is zero, or `c20` if it is zero itself. Texts leave
/// such terms out. `value` gives the values of the law's constants.
pub(crate) fn is_of_an_absent_term(name: &str, value: impl Fn(&str) -> Option<f64>) -> bool {
    let number = name.trim_start_matches(|letter: char| !letter.is_ascii_digit());
    let coefficient = match name.strip_suffix(number) {
        _ if number.is_empty() => return false,
        // Powers of two invariants, not the elastic constants of a crystal.
        Some("c") if number.len() == 2 && number.contains('0') => name.to_owned(),
        _ => format!("mu{number}"),
    };
    value(&coefficient) == Some(0.0)
}

impl Choice {
    /// Setting with its name, as in a list.
    pub(crate) fn told(&self, name: &str) -> String {
        match &self.value {
            Value::Word(word) => format!("{name} {word}"),
            Value::Number(number) => {
                let unit = self
                    .unit
                    .map_or_else(String::new, |unit| format!(" {unit}"));
                format!("{name} {}{unit}", as_set(*number))
            }
            Value::Switch(true) => name.to_owned(),
            Value::Switch(false) => format!("not {name}"),
            other => format!("{name} {other}"),
        }
    }
}

/// Formats a number as it was set. A number with more digits than a user would type follows from others, and gets six digits.
fn as_set(number: f64) -> String {
    let exact = crate::number::exact(number);
    let digits = exact.split('e').next().unwrap_or_default();
    match digits.chars().filter(char::is_ascii_digit).count() > 12 {
        true => crate::number::told(number),
        false => exact,
    }
}

fn joined((chosen, defaults): (String, String)) -> String {
    match defaults.as_str() {
        "" => chosen,
        _ => format!("{chosen}; by default {defaults}"),
    }
}

impl std::fmt::Display for Effective {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (name, (chosen, defaults)) in [
            ("material", self.material()),
            ("discretization", self.discretization()),
        ] {
            writeln!(formatter, "{name:<24}{chosen}")?;
            if !defaults.is_empty() {
                writeln!(formatter, "  {:<22}{defaults}", "by default")?;
            }
        }
        Ok(())
    }
}
