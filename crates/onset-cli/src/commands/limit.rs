//! `onset limit`: values of a setting that allow a given time step, or keep a window of states stable.

use super::{Failure, print_with_files, progress};
use crate::arguments::LimitArguments;
use onset_study::answers::{Problem, Strain};
use onset_study::limit::{KeepsAnswer, LimitAnswer, LimitQuestion, USUAL_STRETCHES};
use std::process::ExitCode;

/// Searches for the limit of a setting.
pub fn limit(arguments: &LimitArguments) -> Result<ExitCode, Failure> {
    let question = LimitQuestion::new(&arguments.vary);
    let open: Vec<&str> = question.iter().map(LimitQuestion::key).collect();
    let mut settings = arguments.problem.settings_with(&open)?;
    if let Some(name) = &arguments.integrator {
        settings = settings.with_integrator(name).map_err(Failure::input)?;
    }
    let strain = match arguments.strain.is_given() {
        true => arguments.strain.build(&Problem::new(settings.clone())?)?,
        false => Strain::reference(),
    };
    let question = question
        .map_err(Failure::input)?
        .between(arguments.range)
        .with_safety(arguments.safety);
    let place = arguments.out.as_deref();
    let output = arguments.drawing.output(place, "limit", &["limit.csv"])?;
    let bar = progress(question.values(), "values tried:");
    let is_told = |value| {
        bar.set_message(format!("{} = {value}", question.key()));
        bar.inc(1);
    };
    let Some(step) = &arguments.time_step else {
        let (low, high) = arguments.stretches.unwrap_or(USUAL_STRETCHES);
        let answer = KeepsAnswer::new(&settings, &question, [low, high], &is_told)?;
        bar.finish_and_clear();
        let text = arguments.detail.text(&answer);
        return print_with_files(
            &answer,
            &text,
            output,
            || Ok(answer.files()),
            || answer.csv(),
        );
    };
    let answer = LimitAnswer::new(&settings, &strain, &question, step, &is_told)?;
    bar.finish_and_clear();
    let text = arguments.detail.text(&answer);
    print_with_files(
        &answer,
        &text,
        output,
        || Ok(answer.files()),
        || answer.csv(),
    )
}
