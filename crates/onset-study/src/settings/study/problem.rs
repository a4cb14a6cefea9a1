//! One material and one discretization of a study, for commands that evaluate single states.

use super::super::notes::note;
use super::super::{
    Key, MaterialSettings, Origin, Quantity, SettingError, Settings, StateSettings, Value, units,
};
use super::{Study, file};

impl Settings {
    /// Reads material and discretization of a study file, and applies assignments; `open` are keys that will be varied. A setting that an axis of the
    /// study varies must be assigned or open.
    ///
    /// # Errors
    /// [`SettingError`] like [`Study::parse`] and [`Settings::check`], and when an axis leaves a setting open.
    pub fn of_file<S: AsRef<str>>(
        name: &str,
        text: &str,
        assignments: &[S],
        open: &[&str],
    ) -> Result<Self, SettingError> {
        let study = file::read(name, text)?;
        study.check_keys_are_read()?;
        let mut settings = study.settings.clone();
        for assignment in assignments {
            settings.assign(assignment.as_ref())?;
        }
        study.check_nothing_is_left_open(|key| {
            open.contains(&key.name) || settings.origin(key.name).is_some()
        })?;
        settings.check(open)?;
        study.note_unread_state();
        Ok(settings)
    }
}

impl Study {
    /// Notes that the state of the study applies only to its maps, because the command defines the state.
    pub(in crate::settings) fn note_unread_state(&self) {
        let keys = self.origins.keys.iter();
        for (name, origin) in keys.filter(|(name, _)| name.starts_with("state.")) {
            note(format!(
                "{origin}`{name}` applies to the states of a map and has no effect here"
            ));
        }
    }
}

impl Settings {
    /// Reads material, discretization and state of a study file, with assignments, for a simulation code with fixed formulations.
    ///
    /// `dialect` are the keys that the code determines, with their values; other values of these keys are refused.
    ///
    /// # Errors
    /// [`SettingError`] like [`Settings::of_file`], and for a key of the dialect with another value.
    pub fn of_dialect<S: AsRef<str>>(
        name: &str,
        text: &str,
        dialect: &[(&'static str, &'static str)],
        assignments: &[S],
    ) -> Result<(Self, StateSettings), SettingError> {
        let study = file::read(name, text)?;
        let mut settings = study.settings.clone();
        for assignment in assignments {
            settings.assign(assignment.as_ref())?;
        }
        for (name, word) in dialect {
            settings.follow(name, word)?;
        }
        study.check_nothing_is_left_open(|key| settings.origin(key.name).is_some())?;
        settings.check(&[])?;
        study.check_given(&settings)?;
        Ok((settings, study.state))
    }

    /// Sets a key of a dialect if it has an effect and is not set yet.
    fn follow(&mut self, name: &'static str, word: &str) -> Result<(), SettingError> {
        let Some(key) = Key::named(name).filter(|key| self.unmet(key).is_none()) else {
            return Ok(());
        };
        let mut meant = self.clone();
        meant.set(
            name,
            &Value::typed(word, Some(key.kind)),
            Origin::Combination,
        )?;
        let Some(origin) = self.origin(name) else {
            *self = meant;
            return Ok(());
        };
        if self.value(name) == meant.value(name) {
            return Ok(());
        }
        let set = self
            .value(name)
            .map_or(String::new(), |value| value.to_string());
        Err(SettingError::new(
            origin.clone(),
            format!("`{name}` is {set}; the code computes with {word}"),
        )
        .hint(format!("omit `{name}` ({})", key.meaning)))
    }
}

impl MaterialSettings {
    /// Reads the material of a study file, and applies assignments, for commands that use only the law. Keys of the discretization cannot be
    /// assigned; in the file they are ignored.
    ///
    /// # Errors
    /// [`SettingError`] in the cases of [`Settings::of_file`], for an assignment outside the material, and for plane stress, which needs a body.
    pub fn of_file<S: AsRef<str>>(
        name: &str,
        text: &str,
        assignments: &[S],
    ) -> Result<Self, SettingError> {
        let study = file::read(name, text)?;
        study.check_keys_are_read()?;
        let mut settings = study.settings.clone();
        for assignment in assignments {
            let assignment = assignment.as_ref();
            let key = assignment.split_once('=').map_or("", |(key, _)| key.trim());
            if Key::named(key).is_some_and(|key| key.parts().0 == "discretization") {
                let origin = Origin::CommandLine(format!("--set {assignment}"));
                let message = format!("`{key}` has no effect: this command uses only the law");
                return Err(SettingError::new(origin, message).hint(format!(
                    "omit `{key}`; state, path, dispersion, modes, tune and limit read it"
                )));
            }
            settings.assign(assignment)?;
        }
        study.check_nothing_is_left_open(|key| {
            key.parts().0 != "material" || settings.origin(key.name).is_some()
        })?;
        settings.material.check(&[])?;
        settings.material.check_in_space()?;
        units::check(settings.material.measures())?;
        Ok(settings.material)
    }
}

impl Study {
    /// Checks that another setting determines each key that an axis varies.
    pub(in crate::settings) fn check_nothing_is_left_open(
        &self,
        is_settled: impl Fn(&Key) -> bool,
    ) -> Result<(), SettingError> {
        for (axis, origin) in self.axes.iter().zip(&self.origins.axes) {
            let Quantity::Setting(key) = axis.quantity else {
                continue;
            };
            if !is_settled(key) {
                let (low, high) = axis.range;
                let message = format!(
                    "{} is an axis of this study, from {low} to {high}; this command needs a single value",
                    key.name
                );
                return Err(SettingError::new(origin.quantity.clone(), message)
                    .hint(format!("add --set {}={low}", key.name)));
            }
        }
        Ok(())
    }
}
