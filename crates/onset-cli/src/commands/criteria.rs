//! `onset criteria` and `onset card`: where a law is stable, and in which sense.

use super::{Failure, law, print_with_files, source, with_energy};
use crate::arguments::{CardArguments, CriteriaArguments, LawArguments};
use onset_study::criteria::Question;
use onset_study::output::Output;
use onset_study::settings::{MaterialSettings, Program, law_of};
use std::path::Path;
use std::process::ExitCode;

/// Criteria side by side.
pub fn criteria(arguments: &CriteriaArguments) -> Result<ExitCode, Failure> {
    let question = question(&arguments.law)?;
    let output = arguments.out.as_deref();
    let names = ["criteria.svg", "criteria.png"];
    let output = output.map(|out| Output::at(out, &names)).transpose()?;
    let answer = question.answer().map_err(Failure::input)?;
    print_with_files(&answer, output, || answer.figure().files("criteria"), None)
}

/// The safe range card.
pub fn card(arguments: &CardArguments) -> Result<ExitCode, Failure> {
    let question = question(&arguments.law)?;
    let names = ["card.svg", "card.png", "card.json", "card.html"];
    let output = arguments.out.as_deref();
    let output = output.map(|out| Output::at(out, &names)).transpose()?;
    let card = question.card().map_err(Failure::input)?;
    print_with_files(&card, output, || card.files(), None)
}

fn question(arguments: &LawArguments) -> Result<Question, Failure> {
    let asked = material(arguments)?;
    let question =
        Question::new(&asked.law, arguments.range, &arguments.modes).map_err(Failure::input)?;
    let question = question.with_notes(asked.notes).with_name(asked.name);
    match arguments.incompressible {
        true => question.incompressible().map_err(Failure::input),
        false => Ok(question),
    }
}

/// A law that is asked of.
struct Asked {
    law: MaterialSettings,
    /// What it is called, where that is not its model.
    name: Option<String>,
    /// What there is to know of it.
    notes: Vec<String>,
}

/// The law of a study, of a block of another program, or of the assignments alone, with what there is to know of it.
fn material(arguments: &LawArguments) -> Result<Asked, Failure> {
    let mut assignments = with_energy(&arguments.assignments, arguments.energy.as_deref())?;
    let trust = arguments.trust.trust();
    let (Some(program), Some(file)) = (arguments.from, arguments.file.as_deref()) else {
        let file = arguments.file.as_deref();
        let own = law(file, &assignments, &trust);
        let own = own.map_err(|failure| match file.and_then(program_of) {
            Some(program) => Failure::input(format!(
                "{} is no study, but a block of {program}\n  hint: add --from {program}",
                file.unwrap_or(Path::new("-")).display()
            )),
            None => failure,
        })?;
        return Ok(Asked {
            law: own,
            name: None,
            notes: Vec::new(),
        });
    };
    let (name, text) = source(file)?;
    let wanted = arguments.material.as_deref();
    let read = law_of(program, &name, &text, wanted, &assignments).map_err(Failure::input)?;
    assignments.splice(0..0, read.assignments);
    Ok(Asked {
        law: law(None, &assignments, &trust)?,
        name: read.name,
        notes: read.notes,
    })
}

/// The program that a file is written for, where it is none of this program's studies; standard input is read but once.
fn program_of(file: &Path) -> Option<&'static str> {
    let is_file = file != Path::new("-");
    let (_, text) = is_file.then(|| source(file).ok())??;
    // What is wrong with a study is said of it, whatever its comments speak of.
    let is_study = text
        .lines()
        .any(|line| line.trim_start().starts_with("[material"));
    (!is_study).then(|| Program::of_text(&text).map(Program::name))?
}
