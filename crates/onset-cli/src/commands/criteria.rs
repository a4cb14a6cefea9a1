//! `onset criteria` and `onset card`: where a law is stable, and in which sense.

use super::{Failure, law, source, with_energy, with_files};
use crate::arguments::{CardArguments, CriteriaArguments, LawArguments};
use crate::printing::print;
use onset_study::criteria::Question;
use onset_study::output::Output;
use onset_study::settings::{MaterialSettings, law_from};
use std::process::ExitCode;

/// Criteria side by side.
pub fn criteria(arguments: &CriteriaArguments) -> Result<ExitCode, Failure> {
    let question = question(&arguments.law)?;
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
    let question = question(&arguments.law)?;
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

fn question(arguments: &LawArguments) -> Result<Question, Failure> {
    let (material, notes) = material(arguments)?;
    let question =
        Question::new(&material, arguments.range, &arguments.modes).map_err(Failure::input)?;
    let question = question.with_notes(notes);
    match arguments.incompressible {
        true => question.incompressible().map_err(Failure::input),
        false => Ok(question),
    }
}

/// The law of a study, of a block of another program, or of the assignments alone, with what there is to know of it.
fn material(arguments: &LawArguments) -> Result<(MaterialSettings, Vec<String>), Failure> {
    let mut assignments = with_energy(&arguments.assignments, arguments.energy.as_deref())?;
    let trust = arguments.trust.trust();
    let (Some(program), Some(file)) = (arguments.from, arguments.file.as_deref()) else {
        let own = law(arguments.file.as_deref(), &assignments, &trust)?;
        return Ok((own, Vec::new()));
    };
    let (name, text) = source(file)?;
    let read = law_from(program, &name, &text, &assignments).map_err(Failure::input)?;
    assignments.splice(0..0, read.assignments);
    Ok((law(None, &assignments, &trust)?, read.notes))
}
