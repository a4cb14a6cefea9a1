//! `model = "marlow"`: an energy of the first invariant that interpolates the table of one test.

use super::super::error::SettingError;
use super::super::foreign::table_from;
use super::super::key::key;
use super::super::{Kind, MaterialSettings, Origin, Value};
use super::OwnModel;
use crate::input;
use onset::material::{Hyperelastic, MaterialError};
use std::borrow::Cow;
use std::path::Path;

pub(super) const MODEL: OwnModel = OwnModel {
    name: "marlow",
    formula: "W = w(J^(-2/3) I1 - 3) + kappa/2 (J - 1)^2, dw/dI1 a monotone cubic through a table; material.kappa is the bulk modulus",
    source: "Marlow, in Constitutive Models for Rubber III (2003) 157",
    keys: &[key(
        "material.table",
        Kind::Text,
        "file with the table: *HYPERELASTIC, MARLOW of Abaqus and its test data",
    )],
    required: &["table"],
    stresses: &["kappa", "table"],
    takes_any_parameter: true,
    check,
    build,
};

fn check(settings: &MaterialSettings) -> Result<(), SettingError> {
    for (name, _) in settings.values() {
        if name != "kappa" {
            let (_, origin) = settings.require(name)?;
            return Err(SettingError::new(
                origin.clone(),
                format!("a table has no parameter `{}`", onset_frames::cut(name)),
            )
            .hint("its only parameter is material.kappa, the bulk modulus"));
        }
    }
    settings.require("table").map(|_| ())
}

/// Builds the law from the table, or from the file that contains it.
fn law(settings: &MaterialSettings) -> Result<Box<dyn Hyperelastic>, SettingError> {
    let (value, origin) = settings.require("table")?;
    let Value::Word(place) = value else {
        return Err(SettingError::new(
            origin.clone(),
            "material.table is not a file name",
        ));
    };
    let text = match place.contains('\n') {
        true => Cow::Borrowed(place.as_str()),
        false if *origin == Origin::Question => {
            let message = "the page cannot read files";
            return Err(SettingError::new(origin.clone(), message)
                .hint("use the command, or the text of the table instead of the name"));
        }
        false => Cow::Owned(
            input::text(Path::new(place), input::MOST_TEXT).map_err(|error| {
                SettingError::new(origin.clone(), format!("cannot read {place}: {error}"))
                    .hint("material.table is a file with *HYPERELASTIC, MARLOW and its test data")
            })?,
        ),
    };
    let (table, own) = table_from(place, &text)?;
    let values = settings.values();
    let set = values.iter().find(|(name, _)| *name == "kappa");
    Ok(Box::new(
        table.with_bulk(set.map_or(own, |(_, bulk)| *bulk)),
    ))
}

fn build(settings: &MaterialSettings) -> Result<Box<dyn Hyperelastic>, MaterialError> {
    law(settings).map_err(|error| MaterialError::External {
        message: error.to_string(),
    })
}
