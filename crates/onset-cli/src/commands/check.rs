//! `onset check` and `onset schema`: validation of study files, and their JSON schema.

use super::{Failure, Read, source};
use crate::arguments::BlockArguments;
use crate::printing::{Format, format, only_text, print, print_text};
use onset_study::answers::{Problem, StudySummary};
use onset_study::csv::Table;
use onset_study::settings::{
    Origin, SettingError, Study, Trust, Units, schema as schema_of_studies,
};
use onset_study::zoo::is_entry;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Result for a file.
#[derive(Serialize)]
#[serde(untagged)]
enum Entry {
    Valid(Box<StudySummary>),
    Invalid(Box<Mistake>),
}

/// Reason why a file is not a valid study.
#[derive(Serialize)]
struct Mistake {
    file: String,
    valid: bool,
    /// Line number from 1; `null` if the error has no position in the file.
    line: Option<usize>,
    column: Option<usize>,
    message: String,
    hint: Option<String>,
    /// Message for standard error.
    #[serde(skip)]
    told: String,
}

impl Mistake {
    fn new(file: &str, told: String) -> Box<Self> {
        Box::new(Self {
            file: file.to_owned(),
            valid: false,
            line: None,
            column: None,
            message: told.clone(),
            hint: None,
            told,
        })
    }

    fn of_setting(file: &str, error: SettingError) -> Box<Self> {
        let told = error.to_string();
        let (line, column) = match error.origin {
            Origin::File { line, column, .. } => (Some(line), Some(column)),
            Origin::CommandLine(_) | Origin::Question | Origin::Combination => (None, None),
        };
        Box::new(Self {
            line,
            column,
            message: error.message,
            hint: error.hint,
            ..*Self::new(file, told)
        })
    }
}

/// Files as CSV, one row for each.
fn csv(entries: &[Entry]) -> String {
    let valid = |entry: &Entry, cell: fn(&StudySummary) -> String| match entry {
        Entry::Valid(summary) => Some(cell(summary)),
        Entry::Invalid(_) => None,
    };
    let mistake = |entry: &'_ Entry, cell: fn(&Mistake) -> Option<String>| match entry {
        Entry::Valid(_) => None,
        Entry::Invalid(mistake) => cell(mistake),
    };
    Table::new(entries, Units::Own)
        .with("file", "1", |entry| match entry {
            Entry::Valid(summary) => summary.file.clone(),
            Entry::Invalid(mistake) => mistake.file.clone(),
        })
        .with("valid", "1", |entry| matches!(entry, Entry::Valid(_)))
        .with("title", "1", move |entry| {
            valid(entry, |summary| summary.title.clone())
        })
        .with("model", "1", move |entry| {
            valid(entry, |summary| summary.model.to_owned())
        })
        .with("states", "1", move |entry| {
            valid(entry, |summary| summary.states.to_string())
        })
        .with("line", "1", move |entry| {
            mistake(entry, |own| Some(own.line?.to_string()))
        })
        .with("column", "1", move |entry| {
            mistake(entry, |own| Some(own.column?.to_string()))
        })
        .with("message", "1", move |entry| {
            mistake(entry, |own| Some(own.message.clone()))
        })
        .to_string()
}

/// Checks every file, and continues after an invalid one.
pub fn check(
    files: &[PathBuf],
    assignments: &[String],
    block: &BlockArguments,
    trust: &Trust,
) -> Result<ExitCode, Failure> {
    let entries: Vec<Entry> = files
        .iter()
        .map(|file| match summary(file, assignments, block, trust) {
            Ok(summary) => Entry::Valid(Box::new(summary)),
            Err(mistake) => Entry::Invalid(mistake),
        })
        .collect();
    let (mut valid, mut told) = (Vec::new(), Vec::new());
    for entry in &entries {
        match entry {
            Entry::Valid(summary) => valid.push(summary.to_string()),
            Entry::Invalid(mistake) => told.push(mistake.told.clone()),
        }
    }
    // Errors are printed on standard error; a document contains them as entries.
    if format() != Format::Text || !valid.is_empty() {
        print(&entries, valid.join("\n").trim_end(), || csv(&entries))?;
    }
    match told.is_empty() {
        true => Ok(ExitCode::SUCCESS),
        false => Err(Failure::input(told.join("\nerror: "))),
    }
}

fn summary(
    file: &Path,
    assignments: &[String],
    block: &BlockArguments,
    trust: &Trust,
) -> Result<StudySummary, Box<Mistake>> {
    let named = file.display().to_string();
    let refused = |failure: Failure| Mistake::new(&named, failure.message);
    let (name, text) = source(file).map_err(refused)?;
    let read = Read::of_text(name.clone(), text, block, assignments.to_vec()).map_err(refused)?;
    let study = match read.is_deck {
        true => {
            let settings = read.settings(&[], trust).map_err(refused)?;
            Problem::new(settings.clone()).map_err(|error| refused(error.into()))?;
            Study::of_settings(settings)
        }
        false => Study::parse_any(&name, &read.text)
            .and_then(|study| study.override_with(assignments))
            .map_err(|error| match is_entry(&read.text) {
                true => refused(read.failure(error)),
                false => Mistake::of_setting(&name, error),
            })?
            .allowing(trust),
    };
    StudySummary::new(&name, &study)
        .map_err(|error| Mistake::new(&name, format!("{name}: {error}")))
}

/// Prints the JSON schema of studies.
pub fn schema() -> Result<ExitCode, Failure> {
    only_text("a JSON Schema")?;
    print_text(&format!("{:#}", schema_of_studies()))
}
