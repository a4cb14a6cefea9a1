//! `onset criteria` and `onset card`: where a law is stable, and in which sense.

use super::{Failure, law, with_energy, with_files};
use crate::arguments::{CardArguments, CriteriaArguments, LawArguments};
use crate::printing::print;
use onset_study::criteria::Question;
use onset_study::output::Output;
use onset_study::settings::MaterialSettings;
use std::process::ExitCode;

/// Criteria side by side.
pub fn criteria(arguments: &CriteriaArguments) -> Result<ExitCode, Failure> {
    let question = question(&arguments.law, &arguments.modes)?;
    let output = arguments.out.as_deref();
    let names = ["criteria.svg", "criteria.png"];
    let output = output.map(|out| Output::at(out, &names)).transpose()?;
    let answer = question.answer().map_err(Failure::input)?;
    let written = match output {
        Some(output) => {
            let files = answer
                .figure()
                .files("criteria")
                .map_err(Failure::machine)?;
            output.write(&files)?
        }
        None => Vec::new(),
    };
    print(&answer, &with_files(&answer, &written), None)
}

/// The safe range card.
pub fn card(arguments: &CardArguments) -> Result<ExitCode, Failure> {
    let question = question(&arguments.law, &[])?;
    let names = ["card.svg", "card.png", "card.json", "card.html"];
    let output = arguments.out.as_deref();
    let output = output.map(|out| Output::at(out, &names)).transpose()?;
    let card = question.card().map_err(Failure::input)?;
    let files = match output {
        Some(output) => output.write(&card.files().map_err(Failure::machine)?)?,
        None => Vec::new(),
    };
    print(&card, &with_files(&card, &files), None)
}

fn question(
    arguments: &LawArguments,
    modes: &[onset_study::criteria::Mode],
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
