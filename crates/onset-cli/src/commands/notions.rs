//! `onset notions` and `onset card`: where a law is stable, and in which sense.

use super::{Failure, law, named, print, print_json, print_text, with_energy};
use crate::arguments::{CardArguments, LawArguments, NotionsArguments};
use onset_study::notions::Question;
use onset_study::output::Output;
use onset_study::settings::MaterialSettings;
use std::process::ExitCode;

/// Notions side by side.
pub fn notions(arguments: &NotionsArguments) -> Result<ExitCode, Failure> {
    let question = question(&arguments.law, &arguments.modes)?;
    let output = arguments.out.as_deref();
    let names = ["notions.svg", "notions.png"];
    let output = output.map(|out| Output::at(out, &names)).transpose()?;
    let answer = question.answer().map_err(Failure::input)?;
    let written = match output {
        Some(output) => {
            let files = answer.figure().files("notions").map_err(Failure::machine)?;
            let files = named(&output.write(&files)?);
            Some(format!("wrote {}", files.join(" and ")))
        }
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
    let question = question(&arguments.law, &[])?;
    let names = ["card.svg", "card.png", "card.json", "card.html"];
    let output = Output::at(&arguments.out, &names)?;
    let card = question.card().map_err(Failure::input)?;
    let files = output.write(&card.files().map_err(Failure::machine)?)?;
    if arguments.law.json {
        return print_json(&card);
    }
    print_text(&format!("{card}\nwrote {}", named(&files).join(", ")))
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
    law(
        arguments.file.as_deref(),
        &assignments,
        &arguments.trust.trust(),
    )
}
