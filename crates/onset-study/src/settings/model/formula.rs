//! `model = "formula"`: an energy that the user writes as a formula.

use super::super::error::SettingError;
use super::super::key::key;
use super::super::{Kind, MaterialSettings, Origin, Value};
use super::OwnModel;
use onset::formula::{Formula, FormulaError, FormulaLaw, Problem};
use onset::material::{Hyperelastic, MaterialError};

pub(super) const MODEL: OwnModel = OwnModel {
    name: "formula",
    formula: "W = the text of material.energy; every other material.<name> is a parameter",
    source: "user-defined; `onset list formula` prints the language",
    keys: &[key(
        "material.energy",
        Kind::Text,
        "the energy per reference volume, as a formula",
    )],
    required: &["energy"],
    stresses: &[],
    takes_any_parameter: true,
    check,
    build,
};

/// Reads the formula. A missing parameter is reported when the law is built, because an axis may set it.
fn check(settings: &MaterialSettings) -> Result<(), SettingError> {
    let (text, origin) = settings.require("energy")?;
    let Err(error) = law(settings, text) else {
        return Ok(());
    };
    let origin = match &error.problem {
        Problem::UnknownName { .. } | Problem::NoFiberAngle { .. } => return Ok(()),
        Problem::UnusedParameter { name, .. }
        | Problem::NotAParameter { name, .. }
        | Problem::ParameterNotFinite { name, .. } => settings.require(name)?.1,
        _ => origin,
    };
    Err(told(&error, origin))
}

fn law(settings: &MaterialSettings, text: &Value) -> Result<FormulaLaw, FormulaError> {
    let text = match text {
        Value::Word(text) => text.clone(),
        other => other.to_string(),
    };
    let formula = match settings.is_membrane() {
        true => Formula::parse_in_plane(&text),
        false => Formula::parse(&text),
    };
    formula?.with(&settings.values())
}

/// Error with the place of the setting, followed by the position within the formula.
fn told(error: &FormulaError, origin: &Origin) -> SettingError {
    let message = match &error.place {
        Some(place) => format!("energy, {place}: {}\n{}", error.problem, place.marked()),
        None => error.problem.to_string(),
    };
    let told = SettingError::new(origin.clone(), message);
    match error.problem.hint() {
        Some(hint) => told.hint(hint),
        None => told,
    }
}

fn build(settings: &MaterialSettings) -> Result<Box<dyn Hyperelastic>, MaterialError> {
    let external = |message: String| MaterialError::External { message };
    let (text, _) = settings
        .require("energy")
        .map_err(|error| external(error.to_string()))?;
    let law = law(settings, text).map_err(|error| external(error.to_string()))?;
    Ok(Box::new(law))
}
