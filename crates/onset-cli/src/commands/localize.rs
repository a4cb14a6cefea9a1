//! `onset localize`: where along a loading path a plastic material localizes.

use super::{Failure, print, print_json, print_text};
use crate::arguments::LocalizeArguments;
use onset_study::localization::{LocalizationAnswer, PlasticSettings};
use std::path::Path;
use std::process::ExitCode;

/// Follows the path, tells the answer, and draws it where a folder is given.
pub fn localize(arguments: &LocalizeArguments) -> Result<ExitCode, Failure> {
    let shortcuts = [
        ("model", &arguments.model),
        ("path", &arguments.path),
        ("load", &arguments.load),
    ];
    let assignments: Vec<String> = shortcuts
        .into_iter()
        .filter_map(|(name, word)| Some(format!("plasticity.{name}={}", word.as_ref()?)))
        .chain(arguments.assignments.iter().cloned())
        .collect();
    let settings = PlasticSettings::from_assignments(&assignments).map_err(Failure::input)?;
    let answer = LocalizationAnswer::new(&settings).map_err(Failure::input)?;
    let Some(out) = &arguments.out else {
        return print(&answer, arguments.json);
    };
    let files = write(&answer, out)?;
    if arguments.json {
        return print_json(&answer);
    }
    print_text(&format!("{answer}\nwrote {}", files.join(", ")))
}

/// Figure and tables.
fn write(answer: &LocalizationAnswer, out: &Path) -> Result<Vec<String>, Failure> {
    let mut files = answer
        .figure("Where the material localizes")
        .write(out, "localize")
        .map_err(Failure::machine)?
        .to_vec();
    for (name, text) in [
        ("localize.csv", answer.csv()),
        ("localize-directions.csv", answer.directions_csv()),
    ] {
        let table = out.join(name);
        std::fs::write(&table, text).map_err(|error| {
            Failure::machine(format!("cannot write {}: {error}", table.display()))
        })?;
        files.push(table);
    }
    Ok(files
        .iter()
        .map(|file| file.display().to_string())
        .collect())
}
