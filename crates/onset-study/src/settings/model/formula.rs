//! `model = "formula"`: an energy of one's own, written out.

use super::super::error::SettingError;
use super::super::key::key;
use super::super::{Kind, MaterialSettings};
use super::OwnModel;
use onset::material::{Hyperelastic, MaterialError};

pub(super) const MODEL: OwnModel = OwnModel {
    name: "formula",
    formula: "W = the text of material.energy; every other material.<name> is a parameter",
    source: "your own",
    keys: &[key(
        "material.energy",
        Kind::Text,
        "the energy per reference volume, as a formula",
    )],
    required: &["energy"],
    takes_any_parameter: true,
    check,
    build,
};

fn check(settings: &MaterialSettings) -> Result<(), SettingError> {
    settings.require("energy").map(drop)
}

fn build(_settings: &MaterialSettings) -> Result<Box<dyn Hyperelastic>, MaterialError> {
    Err(MaterialError::External {
        message: "this program was built without formulas".to_owned(),
    })
}
