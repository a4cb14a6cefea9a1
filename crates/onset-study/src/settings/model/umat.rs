//! `model = "umat"`: a material of one's own in a shared library with Abaqus's interface.

use super::super::error::SettingError;
use super::super::key::key;
use super::super::{Kind, MaterialSettings};
use super::OwnModel;
use onset::material::{Hyperelastic, MaterialError};

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
    ],
    required: &["library"],
    takes_any_parameter: false,
    check,
    build,
};

fn check(settings: &MaterialSettings) -> Result<(), SettingError> {
    settings.require("library").map(drop)
}

fn build(_settings: &MaterialSettings) -> Result<Box<dyn Hyperelastic>, MaterialError> {
    Err(MaterialError::External {
        message: "this program was built without user subroutines".to_owned(),
    })
}
