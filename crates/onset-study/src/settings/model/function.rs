//! Law defined by the calling program, for example a Python function. No file and no assignment can name it.

use super::{Model, OwnModel};
use crate::settings::MaterialSettings;
use onset::material::{Hyperelastic, MaterialError};
use std::fmt;
use std::sync::Arc;

/// Builds the law from values of its parameters.
type Make =
    dyn Fn(&[(&'static str, f64)]) -> Result<Box<dyn Hyperelastic>, MaterialError> + Send + Sync;

/// Law of the calling program.
#[derive(Clone)]
pub struct HandedLaw(Arc<Make>);

impl HandedLaw {
    /// Creates the law from a function that builds it from values of its parameters.
    pub fn new(
        make: impl Fn(&[(&'static str, f64)]) -> Result<Box<dyn Hyperelastic>, MaterialError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        Self(Arc::new(make))
    }
}

impl fmt::Debug for HandedLaw {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("HandedLaw")
    }
}

/// Functions are equal only if they are the same object.
impl PartialEq for HandedLaw {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// This model is not in the list of models that can be selected by name.
static MODEL: OwnModel = OwnModel {
    name: "function",
    formula: "energy, stress and tangent computed by a function of the calling program",
    source: "your own",
    keys: &[],
    required: &[],
    stresses: &[],
    takes_any_parameter: true,
    check: |_| Ok(()),
    build,
};

impl MaterialSettings {
    /// Creates settings for a law of the calling program with its parameters; names that are not valid keys are skipped.
    ///
    /// ```
    /// use onset::material::library;
    /// use onset_study::settings::{HandedLaw, MaterialSettings};
    /// let (law, first) = (&library()[0], &library()[0].parameters[0]);
    /// let handed = HandedLaw::new(|parameters| law.build(parameters));
    /// let material = MaterialSettings::handed(handed, &[(first.name, 2.0)]);
    /// assert_eq!(material.values(), [(first.name, 2.0)]);
    /// assert!(material.build().is_ok());
    /// ```
    pub fn handed(law: HandedLaw, parameters: &[(&str, f64)]) -> Self {
        let mut settings = Self::new(Model::Own(&MODEL), parameters);
        settings.handed = Some(law);
        settings
    }
}

fn build(settings: &MaterialSettings) -> Result<Box<dyn Hyperelastic>, MaterialError> {
    let HandedLaw(make) = settings
        .handed
        .as_ref()
        .ok_or_else(|| MaterialError::External {
            message: "the function of the material is missing".to_owned(),
        })?;
    make(&settings.values())
}
