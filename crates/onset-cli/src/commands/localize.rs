//! `onset localize`: localization of a plastic material along a loading path.

use super::{Failure, another, with_files};
use crate::arguments::LocalizeArguments;
use crate::printing::print;
use onset_study::localization::{LocalizationAnswer, PlasticSettings};
use std::process::ExitCode;

/// Follows the path, prints the answer, and draws it if a folder is given.
pub fn localize(arguments: &LocalizeArguments) -> Result<ExitCode, Failure> {
    let shortcuts = [
        ("model", &arguments.model),
        ("path", &arguments.path),
        ("load", &arguments.load),
    ];
    let given = shortcuts
        .into_iter()
        .filter_map(|(name, word)| Some((name, word.as_ref()?)));
    for (name, word) in given.clone() {
        refuse_another(name, word, &arguments.assignments)?;
    }
    let assignments: Vec<String> = given
        .map(|(name, word)| format!("plasticity.{name}={word}"))
        .chain(arguments.assignments.iter().cloned())
        .collect();
    let settings = PlasticSettings::from_assignments(&assignments).map_err(Failure::input)?;
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
fn refuse_another(name: &str, word: &str, assignments: &[String]) -> Result<(), Failure> {
    match another(assignments, &format!("plasticity.{name}"), word) {
        Some(another) => Err(Failure::input(format!(
            "--{name} {word} and --set {another} are two values of plasticity.{name}\n  hint: omit one of them"
        ))),
        None => Ok(()),
    }
}
