//! `onset localize`: localization of a plastic material along a loading path.

use super::{Failure, Read, another, with_files};
use crate::arguments::LocalizeArguments;
use crate::printing::print;
use onset_study::localization::{LocalizationAnswer, PlasticSettings};
use std::process::ExitCode;

/// Follows the path, prints the answer, and draws it if a folder is given.
pub fn localize(arguments: &LocalizeArguments) -> Result<ExitCode, Failure> {
    let shortcuts = [
        ("model", "material.model", &arguments.model),
        ("path", "plasticity.path", &arguments.path),
        ("load", "plasticity.load", &arguments.load),
    ];
    let mut assignments = arguments.assignments.clone();
    for (option, key, word) in shortcuts {
        if let Some(word) = word {
            refuse_another(option, key, word, &arguments.assignments)?;
            assignments.push(format!("{key}={word}"));
        }
    }
    let read = Read::of(arguments.file.as_deref(), &arguments.block, assignments)?;
    let trust = arguments.trust.trust();
    let settings = PlasticSettings::of_file(&read.name, &read.text, &read.assignments, &trust);
    let settings = settings.map_err(|error| read.failure(error))?;
    let place = arguments.out.as_deref();
    let names = ["localize.csv", "localize-directions.csv"];
    let output = arguments.drawing.output(place, "localize", &names)?;
    let answer = LocalizationAnswer::new(&settings).map_err(Failure::input)?;
    let written = match output {
        Some(output) => output.write(&answer.files())?,
        None => Vec::new(),
    };
    let text = with_files(&arguments.detail.text(&answer), &written);
    print(&answer, &text, || answer.csv())
}

/// Refuses an assignment that contradicts an option.
fn refuse_another(
    option: &str,
    key: &str,
    word: &str,
    assignments: &[String],
) -> Result<(), Failure> {
    match another(assignments, key, word) {
        Some(another) => Err(Failure::input(format!(
            "--{option} {word} and --set {another} are two values of {key}\n  hint: omit one of them"
        ))),
        None => Ok(()),
    }
}
