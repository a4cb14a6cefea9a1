//! `onset compare` and `onset recommend`: methods side by side, and which of them to take.

use super::{Failure, print_json, print_text, progress, source, with_energy};
use crate::arguments::{CompareArguments, RecommendArguments};
use onset_study::compare::{PANELS, Recommendation, Table};
use onset_study::settings::Comparison;
use std::path::Path;
use std::process::ExitCode;

/// Methods side by side.
pub fn compare(arguments: &CompareArguments) -> Result<ExitCode, Failure> {
    let comparison = read(&arguments.file, &arguments.assignments)?;
    let table = evaluated(&comparison, arguments.quiet)?;
    let files = table.write(&arguments.out).map_err(Failure::machine)?;
    if arguments.json {
        return print_json(&table);
    }
    if arguments.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    print_text(&format!("{table}\nwrote {}", files.join(", ")))
}

/// The methods of a file, or those that the program knows, ranked.
pub fn recommend(arguments: &RecommendArguments) -> Result<ExitCode, Failure> {
    let mut assignments = with_energy(&arguments.assignments, arguments.energy.as_deref())?;
    if let Some((low, high)) = arguments.stretches {
        assignments.push(format!("compare.stretches={low},{high}"));
    }
    let comparison = match &arguments.file {
        Some(file) => read(file, &assignments)?,
        None => {
            let (name, text) = PANELS[usize::from(arguments.dimension) - 1];
            Comparison::parse(name, text, &assignments).map_err(Failure::input)?
        }
    };
    let table = evaluated(&comparison, arguments.quiet)?;
    let written = match &arguments.out {
        Some(out) => table.write(out).map_err(Failure::machine)?,
        None => Vec::new(),
    };
    let recommendation = Recommendation::from(table);
    if arguments.json {
        return print_json(&recommendation);
    }
    let mut text = recommendation.to_string();
    if !written.is_empty() {
        text.push_str(&format!("\nwrote {}", written.join(", ")));
    }
    print_text(text.trim_end())
}

fn read(file: &Path, assignments: &[String]) -> Result<Comparison, Failure> {
    let (name, text) = source(file)?;
    Comparison::parse(&name, &text, assignments).map_err(Failure::input)
}

fn evaluated(comparison: &Comparison, quiet: bool) -> Result<Table, Failure> {
    let bar = progress(comparison.candidates.len(), quiet);
    let table = Table::of(comparison, |name| {
        bar.set_message(name.to_owned());
        bar.inc(1);
    })?;
    bar.finish_and_clear();
    let first = table.rows.first();
    let failed = first.and_then(|row| Some((&row.name, row.measured.as_ref().err()?)));
    match failed.filter(|_| table.rows.iter().all(|row| row.measured.is_err())) {
        Some((name, why)) => Err(Failure::input(format!(
            "none of the methods can be evaluated; \"{name}\": {why}"
        ))),
        None => Ok(table),
    }
}
