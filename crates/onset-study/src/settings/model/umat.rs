//! `model = "umat"`, `"vumat"`, `"mfront"`, `"library"`: a user-defined material in a shared library.

use super::super::error::SettingError;
use super::super::key::{ANY_DIMENSION, Key, key};
use super::super::{Kind, MaterialSettings, Model, Value};
use super::OwnModel;
use onset::material::{Hyperelastic, MaterialError};
use onset_umat::{Interface, Umat, UmatError, UmatSettings, fingerprint};
use std::path::Path;
use std::time::Duration;

/// Key of the library, without its section.
pub(in crate::settings) const LIBRARY: &str = "library";

const LIBRARY_KEY: Key = key("material.library", Kind::Text, "path of the shared library");
const PROPERTIES: Key = key(
    "material.properties",
    Kind::Numbers("1", ANY_DIMENSION),
    "properties of the routine, PROPS; of mfront the material properties in the order of the behavior",
);
const STATE_VARIABLES: Key = key(
    "material.state-variables",
    Kind::Whole(0, 100_000),
    "number of state variables of the routine, NSTATV",
);
const INCREMENTS: Key = key(
    "material.increments",
    Kind::Whole(1, 100_000),
    "increments in which the routine reaches a state from the reference state",
);
const TIME_LIMIT: Key = key(
    "material.time-limit",
    Kind::Whole(1, 86_400),
    "time limit of the routine for one state in seconds, 10 by default",
);
const MEMORY_LIMIT: Key = key(
    "material.memory-limit",
    Kind::Whole(64, 1 << 24),
    "memory limit of the routine in MiB, 4096 by default",
);

/// A behavior of finite strain that MFront has compiled.
pub(super) const MFRONT: OwnModel = OwnModel {
    name: "mfront",
    formula: "P and dP/dF of a behavior in a library of MFront with its generic interface",
    keys: &[
        LIBRARY_KEY,
        key(
            "material.behavior",
            Kind::Text,
            "name of the behavior; needed if the library has several",
        ),
        PROPERTIES,
        INCREMENTS,
        TIME_LIMIT,
        MEMORY_LIMIT,
    ],
    ..MODEL
};

/// A subroutine of Abaqus/Explicit.
pub(super) const VUMAT: OwnModel = OwnModel {
    name: "vumat",
    formula: "stress of the subroutine vumat_ in a shared library; its tangent from differences",
    ..MODEL
};

/// A function with the interface of `onset` itself.
pub(super) const FUNCTION: OwnModel = OwnModel {
    name: "library",
    formula: "P and, where set, dP/dF of the C function onset_law in a shared library",
    ..MODEL
};

pub(super) const MODEL: OwnModel = OwnModel {
    name: "umat",
    formula: "stress and DDSDDE of the subroutine umat_ in a shared library",
    source: "your own",
    keys: &[
        LIBRARY_KEY,
        PROPERTIES,
        STATE_VARIABLES,
        INCREMENTS,
        TIME_LIMIT,
        MEMORY_LIMIT,
    ],
    required: &[LIBRARY],
    stresses: &[],
    takes_any_parameter: false,
    check,
    build,
};

fn check(settings: &MaterialSettings) -> Result<(), SettingError> {
    settings.require(LIBRARY).map(|_| ())
}

impl MaterialSettings {
    /// Returns the settings of the user material, if the model is one.
    pub fn umat(&self) -> Option<UmatSettings> {
        let (Model::Own(model), Some(Value::Word(library))) = (self.model, self.given(LIBRARY))
        else {
            return None;
        };
        let interface = match model.name {
            name if name == MODEL.name => Interface::Umat,
            name if name == VUMAT.name => Interface::Vumat,
            name if name == FUNCTION.name => Interface::Law,
            name if name == MFRONT.name => Interface::Mfront,
            _ => return None,
        };
        let number = |name: &str| self.given(name).and_then(Value::number);
        let library = self.allowed().unwrap_or(Path::new(library));
        let mut umat = UmatSettings::new(library, &[]);
        umat.interface = interface;
        if let Some(Value::Numbers(properties)) = self.given("properties") {
            umat.properties.clone_from(properties);
        }
        if let Some(Value::Word(name)) = self.given("behavior") {
            umat.behavior = Some(name.clone());
        }
        if let Some(count) = number("state-variables") {
            umat.state_variables = count as usize;
        }
        if let Some(count) = number("increments") {
            umat.increments = count as u32;
        }
        if let Some(seconds) = number("time-limit") {
            umat.time_limit = Duration::from_secs_f64(seconds);
        }
        if let Some(mebibytes) = number("memory-limit") {
            umat.memory_limit = mebibytes as u64 * (1 << 20);
        }
        umat.fingerprint = self.fingerprint().map(str::to_owned);
        Some(umat)
    }

    /// Returns the settings of the user material, if its library may be loaded.
    ///
    /// # Errors
    /// [`MaterialError`] when the library is not permitted.
    pub fn umat_permitted(&self) -> Result<Option<UmatSettings>, MaterialError> {
        let refused = |error: SettingError| MaterialError::External {
            message: error.to_string(),
        };
        self.permitted().map_err(refused)?;
        Ok(self.umat())
    }
}

/// SHA-256 of the library of a user material.
pub(in crate::settings) fn sum(umat: UmatSettings) -> Result<String, MaterialError> {
    if !umat.library.is_file() {
        return Err(UmatError::NoLibrary { path: umat.library }.into());
    }
    fingerprint(&umat.library).map_err(|error| {
        let path = umat.library.clone();
        let message = error.to_string();
        UmatError::Load { path, message }.into()
    })
}

fn build(settings: &MaterialSettings) -> Result<Box<dyn Hyperelastic>, MaterialError> {
    match settings.umat_permitted()? {
        Some(umat) => Ok(Box::new(Umat::new(umat)?)),
        None => Err(MaterialError::External {
            message: "material.library is missing".to_owned(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use crate::settings::{MaterialSettings, Settings, Trust};
    use std::time::Duration;

    #[test]
    #[cfg(unix)]
    fn changing_a_link_after_permission_does_not_change_the_loaded_library() {
        use std::fs;
        use std::os::unix::fs::symlink;
        let place = onset_umat::PrivateFolder::new(&std::env::temp_dir(), "onset-allowed-");
        let place = place.expect("a folder");
        // The folder for temporary files may itself be a link.
        let root = fs::canonicalize(place.path()).expect("a folder");
        let at = |name: &str| root.join(name);
        fs::create_dir(at("trusted")).expect("a folder");
        for library in ["trusted/a.so", "other.so"] {
            fs::write(at(library), library).expect("a file");
        }
        symlink(at("trusted/a.so"), at("link.so")).expect("a link");
        let text = format!(
            "[material]\nmodel = \"umat\"\nlibrary = {:?}\n",
            at("link.so").display().to_string()
        );
        let mut material =
            MaterialSettings::of_file::<&str>("study.toml", &text, &[]).expect("one");
        assert!(material.permitted().is_err());
        material.allow(&Trust::of([at("trusted")]));
        fs::remove_file(at("link.so")).expect("removable");
        symlink(at("other.so"), at("link.so")).expect("a link");
        let umat = material.umat_permitted().expect("allowed");
        assert_eq!(umat.expect("a UMAT").library, at("trusted/a.so"));
    }

    #[test]
    fn a_user_material_has_the_settings_that_were_set() {
        let settings = Settings::from_assignments(&[
            "material.model=umat",
            "material.library=a.so",
            "material.properties=1,2.5",
            "material.state-variables=7",
            "material.increments=20",
            "material.time-limit=2",
        ])
        .expect("a user material");
        let umat = settings.material.umat().expect("a user material");
        assert_eq!(umat.library.to_str(), Some("a.so"));
        assert_eq!(umat.properties, [1.0, 2.5]);
        assert_eq!((umat.state_variables, umat.increments), (7, 20));
        assert_eq!(umat.time_limit, Duration::from_secs(2));
        let law = Settings::from_assignments(&["material.model=blatz-ko"]).expect("a law");
        assert_eq!(law.material.umat(), None);
    }
}
