//! Overriding of a study from the command line, and writing it out in full.

use super::super::renamed;
use super::super::{
    Axis, KEYS, Key, MAP_KEYS, Origin, Quantity, STATE_KEYS, SettingError, Value, aliases,
    study_keys, units, unknown_key,
};
use super::Study;

impl Study {
    /// Overrides keys by assignments such as `discretization.support=1.6` or `map.tile=128`, in order. The text of the result is the new study
    /// written out in full.
    ///
    /// # Errors
    /// Fails like [`Study::parse`], and when an assignment sets a key that an axis varies.
    pub fn override_with<S: AsRef<str>>(&self, assignments: &[S]) -> Result<Self, SettingError> {
        let mut study = self.clone();
        if assignments.is_empty() {
            return Ok(study);
        }
        for assignment in assignments {
            study.assign(assignment.as_ref())?;
        }
        study.check()?;
        study.title = study.title_beside(self);
        study.text = study.document();
        Ok(study)
    }

    /// Title of the study. If material, method or state differ from the `original`, the title names the law and the method, with the other
    /// differences.
    fn title_beside(&self, original: &Self) -> String {
        let (own, before) = (self.effective(), original.effective());
        let differs = |name: &str| match (own.get(name), before.get(name)) {
            (Some(own), Some(before)) => own.value != before.value,
            (Some(own), None) => !own.default,
            (None, _) => false,
        };
        let state = STATE_KEYS.iter().filter_map(|key| {
            let value = self.value(key.name)?;
            (original.value(key.name)? != value).then(|| format!("{} {value}", key.parts().1))
        });
        let heads = ["material.model", "discretization.method"];
        let others = own
            .clone()
            .only(&|name| differs(name) && !heads.contains(&name));
        let others = std::iter::once(others.told())
            .chain(state)
            .filter(|told| !told.is_empty());
        let others = others.collect::<Vec<_>>().join(", ");
        if self.title.is_empty() || (others.is_empty() && !heads.into_iter().any(differs)) {
            return self.title.clone();
        }
        let [law, method] = heads.map(|name| match own.get(name).map(|own| &own.value) {
            Some(Value::Word(word)) => word.clone(),
            _ => String::new(),
        });
        match others.as_str() {
            "" => format!("{law} in {method}"),
            others => format!("{law} in {method}: {others}"),
        }
    }

    fn assign(&mut self, assignment: &str) -> Result<(), SettingError> {
        let origin = Origin::CommandLine(format!("--set {assignment}"));
        let Some((name, text)) = assignment.split_once('=') else {
            let message = format!("`{}` is not an assignment", onset_frames::cut(assignment));
            return Err(SettingError::new(origin, message)
                .hint("write --set key=value, for example --set discretization.support=1.6"));
        };
        let name = name.trim();
        let axis = self
            .axes
            .iter()
            .find(|axis| axis.name() == name || axis.quantity.key_name() == name);
        if let Some(axis) = axis {
            let (low, high) = axis.range;
            let message = format!(
                "{} is an axis of this study, from {low} to {high}",
                axis.name()
            );
            return Err(SettingError::new(origin, message)
                .hint("set another key, or change the axis in the study file"));
        }
        let text = text.trim();
        let is_measure = Value::typed(text, None).is_measure();
        let Some(key) = Key::for_setting(name, is_measure) else {
            let error = unknown_key(name, study_keys().map(|key| key.name), origin);
            return Err(match name.starts_with("axes") || name == "title" {
                true => error.hint("axes and title can be changed in the study file only"),
                false => error,
            });
        };
        self.put(key, &Value::typed(text, Some(key.kind)), origin)
    }

    /// Sets a key to a value of the expected kind.
    ///
    /// # Errors
    /// [`SettingError`] when the value is of another kind.
    pub(super) fn put(
        &mut self,
        key: &'static Key,
        value: &Value,
        origin: Origin,
    ) -> Result<(), SettingError> {
        let key = renamed::of_word(key, value);
        let wrong = |origin: Origin| {
            SettingError::new(
                origin,
                format!("`{}` cannot be {}", key.name, value.brief()),
            )
            .hint(format!("expected {} ({})", key.expects(), key.meaning))
            .nearest_word(key.name, value, key.words())
        };
        let measured = units::converted(key, value, &origin)?;
        let meant = aliases::meant(key, value, &origin)?;
        let read = measured.as_ref().unwrap_or(&*meant);
        if !key.kind.accepts(read) {
            return Err(wrong(origin));
        }
        let done = match key.parts() {
            ("state", name) => self.state.set(name, read),
            ("map", name) => self.map.set(name, read),
            _ => {
                self.settings.set(key.name, value, origin.clone())?;
                true
            }
        };
        if !done {
            return Err(wrong(origin));
        }
        if matches!(key.parts().0, "state" | "map") {
            self.origins.keys.insert(key.name, origin);
        }
        // The default stride must not forbid a small tile.
        if key.name == "map.tile" && !self.origins.keys.contains_key("map.refine-from") {
            let largest = 1 << self.map.tile.max(1).ilog2();
            self.map.refine_from = largest.min(super::MapSettings::default().refine_from);
        }
        Ok(())
    }

    /// Keys of the parameters that follow from moduli which an axis varies.
    pub(in crate::settings) fn follows(&self) -> Vec<String> {
        let is_modulus =
            |axis: &Axis| matches!(axis.quantity, Quantity::Setting(key) if key.is_modulus());
        if !self.axes.iter().any(is_modulus) {
            return Vec::new();
        }
        let Ok(first) = self.settings_at(&self.coordinates(0)) else {
            return Vec::new();
        };
        let names = first.material.of_moduli();
        names.map(|name| format!("material.{name}")).collect()
    }

    /// Writes the study as a file with every key that has an effect. Equivalent studies are written identically, independent of omitted defaults and
    /// of comments.
    pub fn document(&self) -> String {
        let mut text = format!("title = {}\n", toml::Value::from(self.title.as_str()));
        let mut varied: Vec<String> = self
            .axes
            .iter()
            .map(|axis| axis.quantity.key_name())
            .collect();
        // The smoothing length determines the support, and moduli determine parameters, so these vary too.
        if varied.iter().any(|name| name == aliases::SMOOTHING_LENGTH) {
            varied.push("discretization.support".to_owned());
        }
        let follows = self.follows();
        let moduli_vary = !follows.is_empty();
        varied.extend(follows);
        let (of_material, of_discretization): (Vec<&Key>, Vec<&Key>) =
            KEYS.iter().partition(|key| key.parts().0 == "material");
        // User-defined parameters are not in the tables.
        let entries = self.settings.material.entries();
        let own = entries.iter().filter_map(|(name, _)| {
            let key = Key::named(&format!("material.{name}"))?;
            (key.is_parameter() && !KEYS.contains(key)).then_some(key)
        });
        for (table, keys) in [
            ("", of_material.into_iter().chain(own).collect()),
            ("", of_discretization),
            ("state", STATE_KEYS.iter().collect()),
            ("axes", Vec::new()),
            ("map", MAP_KEYS.iter().collect()),
        ] {
            if table == "axes" {
                self.axes.iter().for_each(|axis| {
                    let (low, high) = axis.range;
                    let end = |end: f64| match axis
                        .si_unit()
                        .filter(|_| self.settings.units().are_si())
                    {
                        Some(unit) => format!("\"{end:?} {unit}\""),
                        None => format!("{end:?}"),
                    };
                    text.push_str(&format!(
                        "\n[[axes]]\nquantity = \"{}\"\nrange = [{}, {}]\nstates = {}\n",
                        axis.name(),
                        end(low),
                        end(high),
                        axis.count
                    ));
                });
            }
            let mut section = "";
            for key in keys {
                let is_left_out = key.is_modulus() && !moduli_vary;
                let is_varied = varied.iter().any(|name| name == key.name);
                let written = !is_varied && !is_left_out && self.is_read(key);
                let Some(value) = self.value(key.name).filter(|_| written) else {
                    continue;
                };
                if key.parts().0 != section {
                    section = key.parts().0;
                    text.push_str(&format!("\n[{section}]\n"));
                }
                let si = key.unit().and_then(units::si);
                let value = match (value, key.unit()) {
                    (Value::Number(number), Some(_))
                        if self.settings.units().are_si() && si.is_some() =>
                    {
                        toml::Value::from(format!("{number:?} {}", si.unwrap_or_default()))
                            .to_string()
                    }
                    (Value::Number(number), Some(_)) => format!("{number:?}"),
                    (Value::Word(text), _) => toml::Value::from(text).to_string(),
                    (other, _) => other.to_string(),
                };
                text.push_str(&format!("{} = {value}\n", key.parts().1));
            }
        }
        text
    }
}
