//! Study: material, discretization, fixed and varied quantities, and the settings of the map.

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

/// Study as read; all checks that need no computation have passed.
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
    /// Title of the study.
    pub title: String,
    /// Material and discretization, for settings that no axis varies.
    pub settings: Settings,
    /// Deformation, for components that no axis varies.
    pub state: StateSettings,
    /// Two or three axes, the first running fastest.
    pub axes: Vec<Axis>,
    /// Settings of the map.
    pub map: MapSettings,
    /// Text of the file; after an override, the new study written out in full.
    pub text: String,
    /// Whether the file also describes a comparison.
    has_methods: bool,
    origins: Origins,
}

/// Places at which the parts of a study were set.
#[derive(Clone, Debug, PartialEq)]
struct Origins {
    /// Beginning of the file.
    file: Origin,
    /// Places of the keys of `[state]` and `[map]`; other settings store their places themselves.
    keys: BTreeMap<&'static str, Origin>,
    /// Places of the axes, in their order.
    axes: Vec<AxisOrigin>,
}

/// Places of the parts of an axis.
#[derive(Clone, Debug, PartialEq)]
struct AxisOrigin {
    quantity: Origin,
    range: Origin,
}

impl Study {
    /// Reads a study; `name` is the name of the file, for messages.
    ///
    /// # Errors
    /// [`SettingError`] with line and column of the error, the expected value, and a hint.
    pub fn parse(name: &str, text: &str) -> Result<Self, SettingError> {
        let study = file::read(name, text)?;
        study.require_axes()?;
        study.check()?;
        if study.has_methods {
            Comparison::check(name, text)?;
        }
        Ok(study)
    }

    /// Reads a study like [`Study::parse`], but also accepts a study with a body and no axes.
    ///
    /// # Errors
    /// Fails like [`Study::parse`].
    pub fn parse_any(name: &str, text: &str) -> Result<Self, SettingError> {
        let study = file::read(name, text)?;
        match study.settings.body.is_some() && study.axes.is_empty() {
            true => study.check().map(|()| study),
            false => Self::parse(name, text),
        }
    }

    /// Study of settings alone, without axes and title.
    pub fn of_settings(settings: Settings) -> Self {
        Self {
            title: String::new(),
            settings,
            state: StateSettings::default(),
            axes: Vec::new(),
            map: MapSettings::default(),
            text: String::new(),
            has_methods: false,
            origins: Origins {
                file: Origin::Combination,
                keys: BTreeMap::new(),
                axes: Vec::new(),
            },
        }
    }

    /// Reads a study and overrides some keys, like [`Study::override_with`]. The text alone need not be valid.
    ///
    /// # Errors
    /// Fails like [`Study::parse`] and [`Study::override_with`].
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

    /// Applies the user's permissions for libraries to the study.
    pub fn allowing(mut self, trust: &Trust) -> Self {
        self.settings.material.allow(trust);
        self
    }

    /// Returns the numbers of states along the axes in reverse order: the axis that varies slowest comes first.
    pub fn shape(&self) -> Vec<usize> {
        self.axes.iter().rev().map(|axis| axis.count).collect()
    }

    /// Returns the total number of states.
    pub fn states(&self) -> usize {
        self.axes.iter().map(|axis| axis.count).product()
    }

    /// Returns the coordinates of a state, in the order of the axes; the first axis varies fastest.
    pub fn coordinates(&self, index: usize) -> Vec<f64> {
        let mut rest = index;
        let coordinate = |axis: &Axis| {
            let i = rest % axis.count;
            rest /= axis.count;
            axis.coordinate(i)
        };
        self.axes.iter().map(coordinate).collect()
    }

    /// Returns the settings at coordinates in the order of the axes.
    ///
    /// # Errors
    /// [`SettingError`] when a key does not accept its coordinate.
    pub fn settings_at(&self, coordinates: &[f64]) -> Result<Settings, SettingError> {
        let mut settings = self.settings.clone();
        for (axis, value) in self.axes.iter().zip(coordinates) {
            if let Quantity::Setting(key) = axis.quantity {
                settings.set(key.name, &Value::Number(*value), Origin::Combination)?;
            }
        }
        Ok(settings)
    }

    /// Returns the deformation at coordinates in the order of the axes, like [`StateSettings::deformation`].
    ///
    /// # Errors
    /// [`KinematicsError`] when the deformation is inadmissible.
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

    /// Returns true if material or discretization differ from state to state.
    pub fn varies_settings(&self) -> bool {
        let is_setting = |axis: &Axis| matches!(axis.quantity, Quantity::Setting(_));
        self.axes.iter().any(is_setting)
    }

    /// Returns the axes of a section through the map: the first two.
    pub fn plane(&self) -> [Axis; 2] {
        [self.axes[0], self.axes[1]]
    }

    /// Returns the axis that varies a quantity, or `None`.
    pub fn axis_of(&self, quantity: Quantity) -> Option<&Axis> {
        self.axes.iter().find(|axis| axis.quantity == quantity)
    }

    /// Replaces the ranges of the axes, in their order.
    pub fn with_ranges(mut self, ranges: &[(f64, f64)]) -> Self {
        for (axis, range) in self.axes.iter_mut().zip(ranges) {
            axis.range = *range;
        }
        self
    }

    /// Returns a condition that a key violates; `None` if it has an effect at some state.
    fn unmet(&self, key: &Key) -> Option<Unmet> {
        key.unmet(&|name| self.value(name).filter(|_| !self.is_varied(name)))
    }

    /// Returns true if a key is in effect at some state.
    fn is_read(&self, key: &Key) -> bool {
        match key.parts() {
            ("material", "model") => true,
            // Plane strain is the default.
            ("material", PLANE) => self.settings.material.plane() != Plane::Strain,
            ("material", name) => self.settings.material.takes(name),
            _ => self.unmet(key).is_none(),
        }
    }

    /// Returns true if an axis varies this key.
    fn is_varied(&self, name: &str) -> bool {
        let mut axes = self.axes.iter();
        axes.any(|axis| axis.quantity.key_name() == name)
    }

    /// Place at which a key was set, or `None`.
    fn origin(&self, name: &str) -> Option<&Origin> {
        self.origins
            .keys
            .get(name)
            .or_else(|| self.settings.origin(name))
    }

    /// Returns the value of a key that no axis varies; `None` for a parameter of another material.
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
