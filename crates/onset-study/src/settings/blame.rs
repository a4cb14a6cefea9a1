//! Which settings an error of a method or law is about.

use super::{Origin, SettingError, Settings};
use crate::methods::hint;
use onset::lattice::LatticeError;
use onset::material::MaterialError;
use onset::method::MethodError;

/// The keys that an error is about, the first one that was set being to blame; none for what several settings make together.
pub(super) fn keys_of(error: &MethodError) -> Vec<String> {
    let keys = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    match error {
        MethodError::Setting { name, .. } => vec![format!("discretization.{name}")],
        MethodError::Lattice(LatticeError::Aspect { .. }) => keys(&["discretization.aspect"]),
        MethodError::Lattice(LatticeError::Vectors { .. }) => {
            keys(&["discretization.vectors", "discretization.lattice"])
        }
        MethodError::Lattice(LatticeError::Dependent { .. }) => keys(&["discretization.vectors"]),
        MethodError::Lattice(LatticeError::Spacing { .. }) => keys(&["discretization.spacing"]),
        MethodError::Material(MaterialError::NoPlaneStress { .. }) => keys(&["material.plane"]),
        MethodError::Material(MaterialError::External { .. }) => {
            keys(&["material.energy", "material.model"])
        }
        // A condition on several parameters is named by a formula of theirs.
        MethodError::Material(MaterialError::Parameter { name, .. }) => {
            let is_apart = |c: char| !c.is_alphanumeric() && c != '_';
            let words = name.split(is_apart).filter(|word| !word.is_empty());
            let own = words.flat_map(parameters);
            own.chain(keys(&["material.model"])).collect()
        }
        _ => Vec::new(),
    }
}

/// The keys of a parameter in a formula, in which `mu_p` stands for `mu1`, `mu2`, ...
fn parameters(word: &str) -> Vec<String> {
    match word.strip_suffix("_p") {
        Some(series) => (1..=TERMS)
            .map(|p| format!("material.{series}{p}"))
            .collect(),
        None => vec![format!("material.{word}")],
    }
}

/// The terms of the longest series that a law has.
const TERMS: usize = 6;

impl Settings {
    /// An error of the method or law with the place of the setting that it is about; `None` where it is about none that was made.
    pub(crate) fn blamed(&self, error: &MethodError) -> Option<SettingError> {
        let keys = keys_of(error);
        // What is varied has been set by nobody, and others are not to blame for it.
        let is_varied = |key: &String| self.origin(key) == Some(&Origin::Combination);
        if keys.iter().any(is_varied) {
            return None;
        }
        let origin = keys.iter().find_map(|key| self.origin(key))?;
        let message = format!("{error}{}", hint(error));
        Some(SettingError::new(origin.clone(), message))
    }
}
