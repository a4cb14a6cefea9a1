//! `onset tune`: the smallest sufficient coefficient that masks no physical instability.

use super::{Failure, print_with_files, progress};
use crate::arguments::TuneArguments;
use onset_study::compare::Thresholds;
use onset_study::tune::{TuneAnswer, TuneQuestion};
use std::process::ExitCode;

/// Finds the smallest sufficient coefficient.
pub fn tune(arguments: &TuneArguments) -> Result<ExitCode, Failure> {
    let question = TuneQuestion::new(&arguments.key, arguments.range, arguments.stretches)
        .map_err(Failure::input)?
        .with_thresholds(Thresholds {
            later: arguments.later,
            ..arguments.thresholds.thresholds()
        });
    let settings = arguments.problem.settings_with(&[question.key()])?;
    let place = arguments.out.as_deref();
    let output = arguments.drawing.output(place, "tune", &["tune.csv"])?;
    let bar = progress(question.values().len(), "values tried:");
    let answer = TuneAnswer::new(&settings, &question, |value| {
        bar.set_message(format!("{} = {value}", question.key()));
        bar.inc(1);
    })?;
    bar.finish_and_clear();
    let shown = arguments.detail.text(&answer);
    print_with_files(
        &answer,
        &shown,
        output,
        || Ok(answer.files()),
        || answer.csv(),
    )
}
