//! `onset localize`: localization of a plastic material along a loading path.

use super::{Failure, Read, another, with_files};
use crate::arguments::LocalizeArguments;
use crate::printing::print;
use onset_study::localization::{LocalizationAnswer, PlasticSettings};
use onset_study::settings::MaterialSettings;
use std::path::Path;
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
    let given = given.map(|(name, word)| format!("plasticity.{name}={word}"));
    let assignments: Vec<String> = match &arguments.file {
        None => given.chain(arguments.assignments.iter().cloned()).collect(),
        Some(file) => {
            let is_of_law = |own: &&String| own.trim_start().starts_with("material.");
            let (of_law, others): (Vec<&String>, Vec<&String>) =
                arguments.assignments.iter().partition(is_of_law);
            let of_law = of_law.into_iter().cloned().collect();
            let law = law_of_file(file, arguments, of_law)?;
            let others = others.into_iter().cloned();
            law.into_iter().chain(given).chain(others).collect()
        }
    };
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

/// Law of a study or of a deck, as assignments to keys of `[plasticity]`.
fn law_of_file(
    file: &Path,
    arguments: &LocalizeArguments,
    assignments: Vec<String>,
) -> Result<Vec<String>, Failure> {
    let read = Read::of(Some(file), &arguments.block, assignments)?;
    let law = MaterialSettings::of_file(&read.name, &read.text, &read.assignments);
    let law = law.and_then(|law| PlasticSettings::values_of(&law));
    let law = law.map_err(|error| read.failure(error))?.into_iter();
    Ok(law.map(|(name, value)| format!("{name}={value}")).collect())
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
