//! A study: material, discretization, what is held fixed, what is varied, and how the map is made.

mod check;
mod file;
mod overriding;
mod problem;

pub(super) use file::{STATES, read};

use super::Plane;
use super::material::PLANE;
use super::{
    Axis, Comparison, Key, MapSettings, Origin, Quantity, SettingError, Settings, StateSettings,
    Trust, Unmet, Value,
};
use onset::kinematics::{DeformationGradient, KinematicsError};
use std::collections::BTreeMap;

/// A study as read, valid as far as can be told without computing.
///
/// ```
/// use onset_study::settings::Study;
/// let text = "[[axes]]\nquantity = 'stretch-1'\nrange = [0.5, 1.5]\nstates = 10\n\
///             [[axes]]\nquantity = 'discretization.support'\nrange = [1.4, 3.0]\nstates = 8\n";
/// let study = Study::parse("study.toml", text)?;
/// assert_eq!((study.states(), study.shape()), (80, vec![8, 10]));
/// assert_eq!(study.coordinates(1)[0], 0.65);
/// # Ok::<(), onset_study::settings::SettingError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// What it shows.
    pub title: String,
    /// Material and discretization, where no axis varies them.
    pub settings: Settings,
    /// The deformation, where no axis varies it.
    pub state: StateSettings,
    /// What is varied: two or three axes, the first running fastest.
    pub axes: Vec<Axis>,
    /// How the map is made.
    pub map: MapSettings,
    /// The file as read; after an override the study written out in full.
    pub text: String,
    /// Whether the file asks for a comparison too.
    has_methods: bool,
    origins: Origins,
}

/// Where the parts of a study were made.
#[derive(Clone, Debug, PartialEq)]
struct Origins {
    /// The beginning of the file.
    file: Origin,
    /// Of every key of `[state]` and `[map]` that was set; the others know where they were set.
    keys: BTreeMap<&'static str, Origin>,
    /// Of the axes, in their order.
    axes: Vec<AxisOrigin>,
}

/// Where an axis was made.
#[derive(Clone, Debug, PartialEq)]
struct AxisOrigin {
    quantity: Origin,
    range: Origin,
}

impl Study {
    /// Reads a study; `name` is that of the file, for messages.
    ///
    /// # Errors
    /// [`SettingError`] with line and column of what cannot be accepted, what is expected, and a hint.
    pub fn parse(name: &str, text: &str) -> Result<Self, SettingError> {
        let study = file::read(name, text)?;
        study.require_axes()?;
        study.check()?;
        if study.has_methods {
            Comparison::check(name, text)?;
        }
        Ok(study)
    }

    /// Reads a study as [`Study::parse`] does, or one that has a body and no axes.
    ///
    /// # Errors
    /// As for [`Study::parse`].
    pub fn parse_any(name: &str, text: &str) -> Result<Self, SettingError> {
        let study = file::read(name, text)?;
        match study.settings.body.is_some() && study.axes.is_empty() {
            true => study.check().map(|()| study),
            false => Self::parse(name, text),
        }
    }

    /// Reads a study and overrides some keys at once, as [`Study::override_with`] does: the text alone need not be valid.
    ///
    /// # Errors
    /// As for [`Study::parse`] and [`Study::override_with`].
    pub fn parse_with<S: AsRef<str>>(
        name: &str,
        text: &str,
        assignments: &[S],
    ) -> Result<Self, SettingError> {
        let study = file::read(name, text)?;
        study.require_axes()?;
        match assignments.is_empty() {
            true => study.check().map(|()| study),
            false => study.override_with(assignments),
        }
    }

    /// The study, of which a library may be loaded if the user allows it.
    pub fn allowing(mut self, trust: &Trust) -> Self {
        self.settings.material.allow(trust);
        self
    }

    /// Numbers of states along the axes, slowest first: the counts in reverse.
    pub fn shape(&self) -> Vec<usize> {
        self.axes.iter().rev().map(|axis| axis.count).collect()
    }

    /// The number of states.
    pub fn states(&self) -> usize {
        self.axes.iter().map(|axis| axis.count).product()
    }

    /// The coordinates of a state, in the order of the axes; the first axis runs fastest.
    pub fn coordinates(&self, index: usize) -> Vec<f64> {
        let mut rest = index;
        let coordinate = |axis: &Axis| {
            let i = rest % axis.count;
            rest /= axis.count;
            axis.coordinate(i)
        };
        self.axes.iter().map(coordinate).collect()
    }

    /// Material and discretization at coordinates in the order of the axes.
    ///
    /// # Errors
    /// [`SettingError`] when a key does not take its coordinate.
    pub fn settings_at(&self, coordinates: &[f64]) -> Result<Settings, SettingError> {
        let mut settings = self.settings.clone();
        for (axis, value) in self.axes.iter().zip(coordinates) {
            if let Quantity::Setting(key) = axis.quantity {
                settings.set(key.name, &Value::Number(*value), Origin::Combination)?;
            }
        }
        Ok(settings)
    }

    /// The deformation at coordinates in the order of the axes, see [`StateSettings::deformation`].
    ///
    /// # Errors
    /// [`KinematicsError`] when it is not admissible.
    pub fn deformation_at(
        &self,
        coordinates: &[f64],
    ) -> Result<DeformationGradient, KinematicsError> {
        let mut state = self.state;
        for (axis, value) in self.axes.iter().zip(coordinates) {
            match axis.quantity {
                Quantity::Stretch(number) => state.stretches[number - 1] = *value,
                Quantity::Shear => state.shear = *value,
                Quantity::Rotation => state.rotation = *value,
                Quantity::Setting(_) => {}
            }
        }
        state.deformation()
    }

    /// Whether material or discretization differ from state to state.
    pub fn varies_settings(&self) -> bool {
        let is_setting = |axis: &Axis| matches!(axis.quantity, Quantity::Setting(_));
        self.axes.iter().any(is_setting)
    }

    /// The axes of a section through the map: the first two.
    pub fn plane(&self) -> [Axis; 2] {
        [self.axes[0], self.axes[1]]
    }

    /// The axis that varies a quantity, if there is one.
    pub fn axis_of(&self, quantity: Quantity) -> Option<&Axis> {
        self.axes.iter().find(|axis| axis.quantity == quantity)
    }

    /// The same study with other ranges of its axes, in their order.
    pub fn with_ranges(mut self, ranges: &[(f64, f64)]) -> Self {
        for (axis, range) in self.axes.iter_mut().zip(ranges) {
            axis.range = *range;
        }
        self
    }

    /// Why a key is not read; `None` where it is at some state.
    fn unmet(&self, key: &Key) -> Option<Unmet> {
        key.unmet(&|name| self.value(name).filter(|_| !self.is_varied(name)))
    }

    /// Whether a key is in effect at some state.
    fn is_read(&self, key: &Key) -> bool {
        match key.parts() {
            ("material", "model") => true,
            // Plane strain is what holds where nothing is said.
            ("material", PLANE) => self.settings.material.plane() != Plane::Strain,
            ("material", name) => {
                self.settings.material.model.takes(name)
                    || self.settings.material.reads_modulus(name)
            }
            _ => self.unmet(key).is_none(),
        }
    }

    /// Whether an axis varies what a key sets.
    fn is_varied(&self, name: &str) -> bool {
        let mut axes = self.axes.iter();
        axes.any(|axis| axis.quantity.key_name() == name)
    }

    /// Where a key was set; `None` where it was not.
    fn origin(&self, name: &str) -> Option<&Origin> {
        self.origins
            .keys
            .get(name)
            .or_else(|| self.settings.origin(name))
    }

    /// The value of a key, where no axis varies it; `None` for a constant of another material.
    pub fn value(&self, name: &str) -> Option<Value> {
        let of_json = |value: &serde_json::Value| match value {
            serde_json::Value::String(word) => Some(Value::Word(word.clone())),
            serde_json::Value::Bool(on) => Some(Value::Switch(*on)),
            serde_json::Value::Array(items) => {
                let word = |item: &serde_json::Value| item.as_str().map(str::to_owned);
                items
                    .iter()
                    .map(word)
                    .collect::<Option<_>>()
                    .map(Value::Words)
            }
            other => other.as_f64().map(Value::Number),
        };
        match name.split_once('.')? {
            ("state", name) => self.state.value(name).map(Value::Number),
            ("map", name) => of_json(&serde_json::to_value(self.map).ok()?[name]),
            _ => self.settings.value(name),
        }
    }
}

#[cfg(test)]
mod tests;
