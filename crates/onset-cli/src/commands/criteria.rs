//! `onset criteria` and `onset card`: stability of a law by several criteria.

use super::{Failure, print_with_files};
use crate::arguments::{CardArguments, CriteriaArguments, LawArguments};
use onset_study::criteria::{DEFAULT_CRITERIA, Question};
use onset_study::output::picture;
use std::process::ExitCode;

/// Evaluates all stability criteria of a law.
pub fn criteria(arguments: &CriteriaArguments) -> Result<ExitCode, Failure> {
    let question = question(&arguments.law)?;
    let drawn = match &arguments.drawn[..] {
        [] => &DEFAULT_CRITERIA[..],
        named => named,
    };
    question.check_drawn(drawn).map_err(Failure::input)?;
    let place = arguments.out.as_deref();
    let output = arguments.drawing.output(place, "criteria", &[])?;
    let answer = question.answer().map_err(Failure::input)?;
    let shown = arguments.detail.text(&answer);
    print_with_files(
        &answer,
        &shown,
        output,
        || Ok(vec![picture("criteria", answer.figure(drawn))]),
        || answer.csv(),
    )
}

/// Evaluates the safe range card of a law.
pub fn card(arguments: &CardArguments) -> Result<ExitCode, Failure> {
    let question = question(&arguments.law)?;
    let place = arguments.out.as_deref();
    let output = arguments
        .drawing
        .output(place, "card", &["card.json", "card.html"])?;
    let card = question.card().map_err(Failure::input)?;
    print_with_files(
        &card,
        &arguments.detail.text(&card),
        output,
        || card.files().map_err(Failure::machine),
        || card.csv(),
    )
}

fn question(arguments: &LawArguments) -> Result<Question, Failure> {
    let law = arguments.problem.law()?;
    let question =
        Question::new(&law, arguments.range, &arguments.modes).map_err(Failure::input)?;
    match arguments.incompressible {
        true => question.incompressible().map_err(Failure::input),
        false => Ok(question),
    }
}
