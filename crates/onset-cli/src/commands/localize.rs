//! `onset localize`: localization of a plastic material along a loading path.

use super::{Failure, Read, another, with_files};
use crate::arguments::LocalizeArguments;
use crate::printing::print;
use onset_study::localization::{LocalizationAnswer, PARAMETERS, PlasticSettings};
use onset_study::settings::{MaterialSettings, Value};
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
    let law = law.map_err(|error| read.failure(error))?;
    let model = law.model.name();
    let entries = law.entries();
    let number = |wanted: &str| {
        let mut found = entries.iter().filter(|(name, _)| *name == wanted);
        found.find_map(|(_, value)| match value {
            Value::Number(number) => Some(*number),
            _ => None,
        })
    };
    let is_known = |key: &str| PARAMETERS.iter().any(|own| own.name == key);
    let others = entries
        .iter()
        .filter(|(name, _)| !["mu", "kappa"].contains(name));
    let mut keys: Vec<(String, Value)> = others
        .map(|(name, value)| (format!("plasticity.{name}"), value.clone()))
        .collect();
    let (Some(mu), Some(kappa), true) = (
        number("mu"),
        number("kappa"),
        !keys.is_empty() && keys.iter().all(|(key, _)| is_known(key)),
    ) else {
        return Err(Failure::input(format!(
            "the law of {} is {model}, whose constants `onset localize` does not read from a file\n  hint: omit the file and give the law by its keys, \
             for example --model j2 --set plasticity.strength=20 (onset localize --help)",
            file.display()
        )));
    };
    let poisson = (3.0 * kappa - 2.0 * mu) / (2.0 * (3.0 * kappa + mu));
    keys.push(("plasticity.shear-modulus".to_owned(), Value::Number(mu)));
    keys.push((
        "plasticity.poisson-ratio".to_owned(),
        Value::Number(poisson),
    ));
    let keys = keys.iter().map(|(key, value)| format!("{key}={value}"));
    Ok([format!("plasticity.model={model}")]
        .into_iter()
        .chain(keys)
        .collect())
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
