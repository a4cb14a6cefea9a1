//! `onset limit`: values of a setting that allow a given time step.

use super::{Failure, print_with_files, progress};
use crate::arguments::LimitArguments;
use onset_study::answers::{Problem, Strain};
use onset_study::limit::{LimitAnswer, LimitQuestion};
use std::process::ExitCode;

/// Searches for the limit of a setting.
pub fn limit(arguments: &LimitArguments) -> Result<ExitCode, Failure> {
    let question = LimitQuestion::new(&arguments.vary, &arguments.time_step);
    let open: Vec<&str> = question.iter().map(LimitQuestion::key).collect();
    let settings = arguments.problem.settings_with(&open)?;
    let strain = match arguments.strain.is_given() {
        true => arguments.strain.build(&Problem::new(settings.clone())?)?,
        false => Strain::reference(),
    };
    let question = question
        .map_err(Failure::input)?
        .between(arguments.range)
        .with_safety(arguments.safety)
        .with_integrator(arguments.integrator);
    let place = arguments.out.as_deref();
    let output = arguments.drawing.output(place, "limit", &["limit.csv"])?;
    let bar = progress(question.values(), "values tried:");
    let answer = LimitAnswer::new(&settings, &strain, &question, &|value| {
        bar.set_message(format!("{} = {value}", question.key()));
        bar.inc(1);
    })?;
    bar.finish_and_clear();
    print_with_files(
        &answer,
        &answer.to_string(),
        output,
        || Ok(answer.files()),
        || answer.csv(),
    )
}
