//! `onset notions` and `onset card`: where a law is stable, and in which sense.

use super::{Failure, law, print, print_json, print_text, with_energy};
use crate::arguments::{CardArguments, LawArguments, NotionsArguments};
use onset_study::figure::Figure;
use onset_study::notions::{CardError, Question};
use onset_study::settings::MaterialSettings;
use std::path::Path;
use std::process::ExitCode;

/// Notions side by side.
pub fn notions(arguments: &NotionsArguments) -> Result<ExitCode, Failure> {
    let question = question(&arguments.law, &arguments.modes)?;
    let answer = question.answer().map_err(Failure::input)?;
    let written = match &arguments.out {
        Some(folder) => Some(write(&answer.figure(), folder)?),
        None => None,
    };
    let code = print(&answer, arguments.law.json)?;
    match written {
        Some(text) if !arguments.law.json => print_text(&text),
        _ => Ok(code),
    }
}

/// The safe range card.
pub fn card(arguments: &CardArguments) -> Result<ExitCode, Failure> {
    let card = question(&arguments.law, &[])?
        .card()
        .map_err(Failure::input)?;
    let files = card
        .write(&arguments.out)
        .map_err(|error: CardError| Failure::machine(error))?;
    if arguments.law.json {
        return print_json(&card);
    }
    let files: Vec<String> = files
        .iter()
        .map(|file| file.display().to_string())
        .collect();
    print_text(&format!("{card}\nwrote {}", files.join(", ")))
}

fn question(
    arguments: &LawArguments,
    modes: &[onset_study::notions::Mode],
) -> Result<Question, Failure> {
    let material = material(arguments)?;
    Question::new(&material, arguments.range, modes).map_err(Failure::input)
}

/// The law of a study, or of the assignments alone.
fn material(arguments: &LawArguments) -> Result<MaterialSettings, Failure> {
    let assignments = with_energy(&arguments.assignments, arguments.energy.as_deref())?;
    law(arguments.file.as_deref(), &assignments)
}

fn write(figure: &Figure, folder: &Path) -> Result<String, Failure> {
    let files = figure.write(folder, "notions").map_err(Failure::machine)?;
    let [first, second] = files.map(|file| file.display().to_string());
    Ok(format!("wrote {first} and {second}"))
}
