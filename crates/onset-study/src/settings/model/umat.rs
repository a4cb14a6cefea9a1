//! `model = "umat"`: a material of one's own in a shared library with Abaqus's interface.

use super::super::error::SettingError;
use super::super::key::key;
use super::super::{Kind, MaterialSettings, Model, Value};
use super::OwnModel;
use onset::material::{Hyperelastic, MaterialError};
use onset_umat::{Umat, UmatSettings};
use std::time::Duration;

pub(super) const MODEL: OwnModel = OwnModel {
    name: "umat",
    formula: "stress and DDSDDE of the subroutine umat_ in a shared library",
    source: "your own",
    keys: &[
        key("material.library", Kind::Text, "path of the shared library"),
        key(
            "material.properties",
            Kind::Numbers,
            "properties of the subroutine, PROPS",
        ),
        key(
            "material.state-variables",
            Kind::Whole(0, 100_000),
            "number of state variables of the subroutine, NSTATV",
        ),
        key(
            "material.increments",
            Kind::Whole(1, 100_000),
            "increments in which the subroutine reaches a state from the undeformed one",
        ),
        key(
            "material.time-limit",
            Kind::Number("s"),
            "how long the subroutine may take for a state",
        ),
    ],
    required: &["library"],
    takes_any_parameter: false,
    check,
    build,
};

/// The longest time limit, a day, in seconds.
const LONGEST: f64 = 86_400.0;

fn check(settings: &MaterialSettings) -> Result<(), SettingError> {
    settings.require("library")?;
    if let Ok((value, origin)) = settings.require("time-limit")
        && !value
            .number()
            .is_some_and(|seconds| seconds > 0.0 && seconds <= LONGEST)
    {
        let message = format!("material.time-limit must be above 0 and at most {LONGEST} seconds");
        return Err(SettingError::new(origin.clone(), message).hint("10 s when it is left out"));
    }
    Ok(())
}

impl MaterialSettings {
    /// What the user material is made of, when the model is one.
    pub fn umat(&self) -> Option<UmatSettings> {
        let (Model::Own(model), Some(Value::Word(library))) = (self.model, self.given("library"))
        else {
            return None;
        };
        if model.name != MODEL.name {
            return None;
        }
        let number = |name: &str| self.given(name).and_then(Value::number);
        let mut umat = UmatSettings::new(library, &[]);
        if let Some(Value::Numbers(properties)) = self.given("properties") {
            umat.properties.clone_from(properties);
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
        Some(umat)
    }
}

fn build(settings: &MaterialSettings) -> Result<Box<dyn Hyperelastic>, MaterialError> {
    match settings.umat() {
        Some(umat) => Ok(Box::new(Umat::new(umat)?)),
        None => Err(MaterialError::External {
            message: "material.library is missing".to_owned(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use crate::settings::Settings;
    use std::time::Duration;

    #[test]
    fn a_user_material_is_what_was_set() {
        let settings = Settings::from_assignments(&[
            "material.model=umat",
            "material.library=a.so",
            "material.properties=1,2.5",
            "material.state-variables=7",
            "material.increments=20",
            "material.time-limit=0.5",
        ])
        .expect("a user material");
        let umat = settings.material.umat().expect("a user material");
        assert_eq!(umat.library.to_str(), Some("a.so"));
        assert_eq!(umat.properties, [1.0, 2.5]);
        assert_eq!((umat.state_variables, umat.increments), (7, 20));
        assert_eq!(umat.time_limit, Duration::from_millis(500));
        let law = Settings::from_assignments(&["material.model=blatz-ko"]).expect("a law");
        assert_eq!(law.material.umat(), None);
    }

    #[test]
    fn a_time_limit_is_positive_and_no_longer_than_a_day() {
        for seconds in ["0", "-1", "1e30"] {
            let told = Settings::from_assignments(&[
                "material.model=umat".to_owned(),
                "material.library=a.so".to_owned(),
                format!("material.time-limit={seconds}"),
            ])
            .expect_err("no time limit")
            .to_string();
            assert!(told.contains("material.time-limit"), "{told}");
        }
    }
}
