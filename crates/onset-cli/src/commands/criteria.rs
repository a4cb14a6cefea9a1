//! `onset criteria` and `onset card`: stability of a law by several criteria.

use super::{Failure, law, print_with_files, source, with_energy};
use crate::arguments::{CardArguments, CriteriaArguments, LawArguments};
use onset_study::criteria::Question;
use onset_study::output::Output;
use onset_study::settings::{MaterialSettings, Program, law_of};
use std::path::Path;
use std::process::ExitCode;

/// Evaluates all stability criteria of a law.
pub fn criteria(arguments: &CriteriaArguments) -> Result<ExitCode, Failure> {
    let question = question(&arguments.law)?;
    let output = arguments.out.as_deref();
    let names = ["criteria.svg", "criteria.png"];
    let output = output.map(|out| Output::at(out, &names)).transpose()?;
    let answer = question.answer().map_err(Failure::input)?;
    let shown = arguments.detail.text(&answer);
    print_with_files(
        &answer,
        &shown,
        output,
        || answer.figure().files("criteria"),
        None,
    )
}

/// Evaluates the safe range card of a law.
pub fn card(arguments: &CardArguments) -> Result<ExitCode, Failure> {
    let question = question(&arguments.law)?;
    let names = ["card.svg", "card.png", "card.json", "card.html"];
    let output = arguments.out.as_deref();
    let output = output.map(|out| Output::at(out, &names)).transpose()?;
    let card = question.card().map_err(Failure::input)?;
    print_with_files(&card, &card.to_string(), output, || card.files(), None)
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

/// Material law selected by the arguments, with its notes.
struct Asked {
    law: MaterialSettings,
    /// Name of the law, if it differs from the name of its model.
    name: Option<String>,
    /// Notes on the law.
    notes: Vec<String>,
}

/// Law of a study, of an input block of another program, or of the assignments alone, with its notes.
fn material(arguments: &LawArguments) -> Result<Asked, Failure> {
    let mut assignments = with_energy(&arguments.assignments, arguments.energy.as_deref())?;
    let trust = arguments.trust.trust();
    let (Some(program), Some(file)) = (arguments.from, arguments.file.as_deref()) else {
        let file = arguments.file.as_deref();
        let own = law(file, &assignments, &trust);
        let own = own.map_err(|failure| match file.and_then(program_of) {
            Some(program) => Failure::input(format!(
                "{} is not a study, but an input block of {program}\n  hint: add --from {program}",
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

/// Foreign program whose format a file has, or `None` for studies; standard input can be read only once and is skipped.
fn program_of(file: &Path) -> Option<&'static str> {
    let is_file = file != Path::new("-");
    let (_, text) = is_file.then(|| source(file).ok())??;
    // A study is recognized first, so that its errors are reported even if its comments mention another program.
    let is_study = text
        .lines()
        .any(|line| line.trim_start().starts_with("[material"));
    (!is_study).then(|| Program::of_text(&text).map(Program::name))?
}
