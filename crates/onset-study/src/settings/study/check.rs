//! Checks that the parts of a study fit together, which concern several keys.

use super::super::blame::blamed;
use super::super::{
    Axis, Family, MAP_KEYS, Origin, Plane, Quantity, STATE_KEYS, SettingError, Settings,
    StateSettings, aliases,
};
use super::Study;
use crate::methods::{hint, method};
use onset::analysis::check_method;
use onset::kinematics::KinematicsError;
use onset::method::MethodError;

impl Study {
    /// Checks the study as a whole.
    pub(super) fn check(&self) -> Result<(), SettingError> {
        let varied: Vec<String> = self
            .axes
            .iter()
            .map(|axis| axis.quantity.key_name())
            .collect();
        let varied: Vec<&str> = varied.iter().map(String::as_str).collect();
        self.settings.check(&varied)?;
        self.check_keys_are_read()?;
        for number in 0..self.axes.len() {
            self.check_axis_is_alone(number)?;
            self.check_axis_has_effect(number)?;
        }
        self.check_dimension()?;
        self.check_given(&self.settings)?;
        self.check_map()?;
        self.corners()
            .iter()
            .try_for_each(|corner| self.check_corner(corner))
    }

    /// Checks that every key of `[state]` and `[map]` that was set has an effect.
    pub(super) fn check_keys_are_read(&self) -> Result<(), SettingError> {
        let set = STATE_KEYS.iter().chain(MAP_KEYS);
        let set = set.filter_map(|key| Some((key, self.origins.keys.get(key.name)?)));
        set.into_iter()
            .find_map(|(key, origin)| {
                let unmet = self.unmet(key)?;
                Some(SettingError::unread(key, &unmet, origin.clone()))
            })
            .map_or(Ok(()), Err)
    }

    /// Checks that no key is both fixed and varied by an axis.
    fn check_axis_is_alone(&self, number: usize) -> Result<(), SettingError> {
        let quantity = self.axes[number].quantity;
        let refused = |message: String| {
            let origin = self.origins.axes[number].quantity.clone();
            Err(SettingError::new(origin, message).hint("remove one of the two"))
        };
        let earlier = self.axes[..number]
            .iter()
            .position(|axis| axis.quantity == quantity);
        if let Some(earlier) = earlier {
            let first = &self.origins.axes[earlier].quantity;
            return refused(format!(
                "{} is the quantity of two axes, here and at {}",
                quantity.name(),
                first.place()
            ));
        }
        let of_support = || {
            let is_length = quantity.name() == aliases::SMOOTHING_LENGTH;
            self.origin("discretization.support").filter(|_| is_length)
        };
        match self
            .origin(quantity.key_name().as_str())
            .or_else(of_support)
        {
            Some(set) => refused(format!(
                "{} is set twice, as an axis and at {}",
                quantity.name(),
                set.place()
            )),
            None => Ok(()),
        }
    }

    /// Checks that an axis changes something.
    fn check_axis_has_effect(&self, number: usize) -> Result<(), SettingError> {
        let quantity = self.axes[number].quantity;
        let refused = |message: String, hint: String| {
            let origin = self.origins.axes[number].quantity.clone();
            Err(SettingError::new(origin, message).hint(hint))
        };
        match quantity {
            Quantity::Setting(key) if key.is_parameter() && !self.is_read(key) => {
                let model = self.settings.material.model;
                refused(
                    format!(
                        "the axis {} changes nothing: {} has no parameter `{}`",
                        key.name,
                        model.name(),
                        key.parts().1
                    ),
                    model.hint(),
                )
            }
            Quantity::Setting(key) => match self.unmet(key) {
                Some(unmet) => {
                    let told = SettingError::unread(key, &unmet, Origin::Combination);
                    refused(
                        format!("the axis {} changes nothing: {}", key.name, told.message),
                        format!("it is used only with {}; or vary something else", key.readers()),
                    )
                }
                None => Ok(()),
            },
            Quantity::Rotation if self.is_isotropic() => refused(
                "the axis rotation changes nothing: both stretches in the plane are equal everywhere, without shear"
                    .to_owned(),
                "vary stretch-1, or set state.stretch-1, state.stretch-2 or state.shear".to_owned(),
            ),
            _ => Ok(()),
        }
    }

    /// Returns true if all states are isotropic in the plane in which the lattice is rotated.
    fn is_isotropic(&self) -> bool {
        let is_varied = [Quantity::Stretch(1), Quantity::Stretch(2), Quantity::Shear]
            .into_iter()
            .any(|quantity| self.axis_of(quantity).is_some());
        let [first, second, _] = self.state.stretches;
        !is_varied && first == second && self.state.shear == 0.0
    }

    /// Checks that a study of a chain uses only quantities that exist in one dimension.
    fn check_dimension(&self) -> Result<(), SettingError> {
        if self.settings.dimension() > 1 {
            return Ok(());
        }
        let (name, other) = match self.settings.method.method {
            Family::FiniteElements => ("mesh of bars", "mesh = \"quadrilaterals\""),
            _ => ("chain", "lattice = \"hexagonal\""),
        };
        let refused = |origin: &Origin, what: &str| {
            let message = format!("{what} needs two dimensions; a {name} has one");
            Err(SettingError::new(origin.clone(), message).hint(format!(
                "a chain can be varied in stretch-1 and in numbers of material and discretization; or set \
                 discretization.{other}"
            )))
        };
        for (axis, origin) in self.axes.iter().zip(&self.origins.axes) {
            if matches!(
                axis.quantity,
                Quantity::Stretch(2 | 3) | Quantity::Shear | Quantity::Rotation
            ) {
                return refused(&origin.quantity, &format!("the axis {}", axis.name()));
            }
        }
        for (name, value) in [
            ("state.shear", self.state.shear),
            ("state.rotation", self.state.rotation),
        ] {
            if value != 0.0 {
                return refused(&self.origin_of(name), name);
            }
        }
        Ok(())
    }

    /// Refuses stretches that follow from equilibrium, in plane stress or uniaxial stress.
    pub(super) fn check_given(&self, settings: &Settings) -> Result<(), SettingError> {
        let why = match settings.material.plane() {
            Plane::Strain => return Ok(()),
            Plane::Stress => "material.plane is stress, so that this stretch is computed",
            Plane::Membrane => "material.plane is membrane, a law without a third direction",
        };
        let refused = |name: &str, origin: &Origin| {
            let message = format!("{name} is given, and {why}");
            Err(SettingError::new(origin.clone(), message)
                .hint(format!("omit {name}, or set material.plane = \"strain\"")))
        };
        for number in settings.dimension() + 1..=3 {
            let name = format!("state.stretch-{number}");
            if let Some(origin) = self.origins.keys.get(name.as_str()) {
                return refused(&name, origin);
            }
            let is_axis = |axis: &Axis| axis.quantity == Quantity::Stretch(number);
            if let Some(axis) = self.axes.iter().position(is_axis) {
                return refused(
                    &format!("the axis stretch-{number}"),
                    &self.origins.axes[axis].quantity,
                );
            }
        }
        Ok(())
    }

    fn check_map(&self) -> Result<(), SettingError> {
        if self.map.refine_from > self.map.tile {
            let message = format!(
                "`map.refine-from` is {}, more than the {} states along an edge of a tile",
                self.map.refine_from, self.map.tile
            );
            return Err(
                SettingError::new(self.origin_of("map.refine-from"), message)
                    .hint("reduce map.refine-from, or enlarge map.tile"),
            );
        }
        Ok(())
    }

    /// Corners of the map, at the ends of the ranges.
    fn corners(&self) -> Vec<Vec<f64>> {
        let corner = |bits: usize| {
            let end = |(number, (low, high)): (usize, (f64, f64))| {
                if bits >> number & 1 == 0 { low } else { high }
            };
            self.axes
                .iter()
                .map(|axis| axis.range)
                .enumerate()
                .map(end)
                .collect()
        };
        (0..1 << self.axes.len()).map(corner).collect()
    }

    /// Checks that material, method and deformation are admissible at a corner of the map.
    fn check_corner(&self, corner: &[f64]) -> Result<(), SettingError> {
        let settings = self.settings_at(corner)?;
        built(&settings).map_err(|error| {
            let anywhere = || {
                let message = format!("{error}{}", hint(&error));
                SettingError::new(self.origins.file.clone(), message)
            };
            blamed(&error, |key| self.made(key)).unwrap_or_else(anywhere)
        })?;
        self.deformation_at(corner)
            .map(drop)
            .map_err(|error| self.kinematics_error(corner, &error))
    }

    fn kinematics_error(&self, corner: &[f64], error: &KinematicsError) -> SettingError {
        // An axis is at fault if the state would be admissible without it.
        let is_to_blame = |number: &usize| {
            let name = self.axes[*number].name();
            let undeformed = StateSettings::default().value(name);
            undeformed.is_some_and(|value| {
                let mut without = corner.to_vec();
                without[*number] = value;
                self.deformation_at(&without).is_ok()
            })
        };
        let of_axis = (0..self.axes.len())
            .find(is_to_blame)
            .map(|number| self.origins.axes[number].range.clone());
        let of_state = || {
            let mut keys = self.origins.keys.iter();
            let origin = keys.find(|(name, _)| name.starts_with("state."));
            origin.map_or_else(|| self.origins.file.clone(), |(_, origin)| origin.clone())
        };
        let at: Vec<String> = self
            .axes
            .iter()
            .zip(corner)
            .map(|(axis, value)| format!("{} = {value}", axis.name()))
            .collect();
        SettingError::new(
            of_axis.unwrap_or_else(of_state),
            format!("at {}: {error}", at.join(", ")),
        )
        .hint("narrow the ranges, or change [state]")
    }

    /// Place at which a key was set or varied.
    fn made(&self, name: &str) -> Option<&Origin> {
        let mut axes = self.axes.iter().zip(&self.origins.axes);
        let axis = axes.find(|(axis, _)| axis.quantity.key_name() == name);
        self.origin(name).or(axis.map(|(_, origin)| &origin.range))
    }

    /// Place at which a key was set or varied, or the beginning of the file.
    fn origin_of(&self, name: &str) -> Origin {
        self.made(name).unwrap_or(&self.origins.file).clone()
    }
}

/// Builds material and method. A library is not loaded for this check.
fn built(settings: &Settings) -> Result<(), MethodError> {
    if !settings.material.is_library() {
        settings.law()?;
    }
    check_method(&method(settings))
}
