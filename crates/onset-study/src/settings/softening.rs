//! Mullins effect: the softening by previous loading that belongs to any hyperelastic law.

use super::error::{Origin, SettingError};
use super::key::key;
use super::{Key, Kind, MaterialSettings, Plane, units};
use onset::material::{Hyperelastic, MULLINS, MaterialError, OgdenRoxburgh};
use std::sync::Arc;

/// The keys, in the order of the parameters.
pub(super) fn softening_keys() -> impl Iterator<Item = Key> {
    MULLINS.iter().map(|own| {
        let name = format!("material.{}", own.name).leak();
        key(name, Kind::Number(own.unit, own.admitted), own.meaning)
    })
}

/// Returns true if a key, without its section, belongs to the softening of a law.
pub(super) fn is_of_softening(name: &str) -> bool {
    MULLINS.iter().any(|own| own.name == name)
}

/// Assignments of the constants `[r, m, beta]`.
pub(super) fn assignments(constants: &[f64; 3]) -> Vec<String> {
    let named = MULLINS.iter().zip(constants);
    named
        .map(|(own, value)| format!("material.{}={value}", own.name))
        .collect()
}

impl MaterialSettings {
    /// Values of the keys that are set, in the order of the parameters.
    fn mullins(&self) -> [Option<f64>; 4] {
        MULLINS.map(|own| self.given(own.name)?.number())
    }

    /// Returns true if the law softens by previous loading.
    pub fn softens(&self) -> bool {
        self.given(MULLINS[0].name).is_some()
    }

    /// Returns true if the law softens by previous loading, and every state is reached by primary loading.
    pub(crate) fn is_primary(&self) -> bool {
        self.softens() && self.mullins()[3].is_none()
    }

    /// Returns true if increments of a state can be stiffer than its tangent: unloading of a law that flows or softens, fast increments of a relaxed state.
    pub(crate) fn has_stiffer_increments(&self) -> bool {
        self.model.yields() || self.is_relaxed() || self.softens()
    }

    /// Names of the softening keys that are set and have the unit of stress.
    pub(super) fn softening_stresses(&self) -> impl Iterator<Item = &'static str> {
        let stresses = MULLINS.iter().filter(|own| units::si(own.unit).is_some());
        let names = stresses.map(|own| own.name);
        names.filter(|name| self.given(name).is_some())
    }

    /// Law that softens by previous loading, in three dimensions; `None` for other laws.
    ///
    /// # Errors
    /// [`MaterialError`] when a parameter is invalid, or the law is not hyperelastic.
    pub(crate) fn softening(&self) -> Result<Option<OgdenRoxburgh>, MaterialError> {
        let [Some(r), m, beta, largest] = self.mullins() else {
            return Ok(None);
        };
        let or_default = |n: usize, value: Option<f64>| value.unwrap_or(MULLINS[n].default);
        let constants = [r, or_default(1, m), or_default(2, beta)];
        OgdenRoxburgh::new(Arc::from(self.of_model()?), constants, largest).map(Some)
    }

    /// Law of the model with its softening.
    pub(super) fn softened(&self) -> Result<Arc<dyn Hyperelastic>, MaterialError> {
        Ok(match self.softening()? {
            Some(law) => Arc::new(law),
            None => Arc::from(self.of_model()?),
        })
    }

    /// Refuses softening of laws that cannot have it, and keys without effect. Keys that are `open` will be varied.
    pub(super) fn check_softening(&self, open: &[&str]) -> Result<(), SettingError> {
        let origin = |name: &str| {
            let is_open = open
                .iter()
                .any(|key| key.strip_prefix("material.") == Some(name));
            let varied = is_open.then_some(&Origin::Combination);
            self.origin(name).or(varied).cloned()
        };
        let refused = |origin: Origin, message: String, hint: &str| {
            Err(SettingError::new(origin, message).hint(hint))
        };
        let r = MULLINS[0].name;
        let Some(own) = origin(r) else {
            let lone = MULLINS
                .iter()
                .find_map(|own| Some((own.name, origin(own.name)?)));
            return match lone {
                Some((name, origin)) => refused(
                    origin,
                    format!("`material.{name}` has no effect without `material.{r}`"),
                    "set material.mullins-r, or omit the key",
                ),
                None => Ok(()),
            };
        };
        if self.model.is_in_rate_form() || self.is_library() {
            return refused(
                own,
                format!(
                    "the Mullins effect softens a law by its strain energy, and {} is not a hyperelastic law",
                    self.model.name()
                ),
                "omit the keys material.mullins-*, or choose a hyperelastic law",
            );
        }
        if self.relaxes() {
            return refused(
                own,
                "a law with a Prony series cannot soften by the Mullins effect here".to_owned(),
                "omit material.prony, or omit the keys material.mullins-*",
            );
        }
        if self.plane() == Plane::Membrane {
            return refused(
                own,
                "`material.plane` is membrane, and a two-dimensional law has no deviatoric energy of space that softens".to_owned(),
                "set material.plane=stress for a sheet of a three-dimensional law",
            );
        }
        Ok(())
    }
}
