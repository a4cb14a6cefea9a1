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
        // A condition on several parameters is named by their sum.
        MethodError::Material(MaterialError::Parameter { name, .. }) => {
            let own = name.split(" + ").map(|name| format!("material.{name}"));
            own.chain(keys(&["material.model"])).collect()
        }
        _ => Vec::new(),
    }
}

impl Settings {
    /// An error of the method or law with the place of the setting that it is about; `None` where it is about none that was made.
    pub(crate) fn blamed(&self, error: &MethodError) -> Option<SettingError> {
        let keys = keys_of(error);
        let origin = keys.iter().find_map(|key| self.origin(key))?;
        let message = format!("{error}{}", hint(error));
        (*origin != Origin::Combination).then(|| SettingError::new(origin.clone(), message))
    }
}
