//! `onset compare` and `onset recommend`: methods side by side, and which of them to take.

use super::{Failure, named, print_json, print_text, progress, source, with_energy};
use crate::arguments::{CompareArguments, RecommendArguments};
use onset_study::compare::{PANELS, Recommendation, Table};
use onset_study::output::Output;
use onset_study::settings::{Comparison, Trust};
use std::path::Path;
use std::process::ExitCode;

/// The files of a table.
const FILES: [&str; 4] = ["compare.html", "compare.csv", "compare.svg", "compare.png"];

/// Methods side by side.
pub fn compare(arguments: &CompareArguments) -> Result<ExitCode, Failure> {
    let trust = arguments.trust.trust();
    let comparison = read(&arguments.file, &arguments.assignments, &trust)?;
    let output = Output::at(&arguments.out, &FILES)?;
    let table = evaluated(&comparison, arguments.quiet)?;
    let files = output.write(&table.files().map_err(Failure::machine)?)?;
    if arguments.json {
        return print_json(&table);
    }
    if arguments.quiet {
        return Ok(ExitCode::SUCCESS);
    }
    print_text(&format!("{table}\nwrote {}", named(&files).join(", ")))
}

/// The methods of a file, or those that the program knows, ranked.
pub fn recommend(arguments: &RecommendArguments) -> Result<ExitCode, Failure> {
    let mut assignments = with_energy(&arguments.assignments, arguments.energy.as_deref())?;
    if let Some((low, high)) = arguments.stretches {
        assignments.push(format!("compare.stretches={low},{high}"));
    }
    let comparison = match &arguments.file {
        Some(file) => read(file, &assignments, &arguments.trust.trust())?,
        None => {
            let (name, text) = PANELS[usize::from(arguments.dimension) - 1];
            Comparison::parse(name, text, &assignments).map_err(Failure::input)?
        }
    };
    let output = arguments.out.as_deref();
    let output = output.map(|out| Output::at(out, &FILES)).transpose()?;
    let table = evaluated(&comparison, arguments.quiet)?;
    let written = match output {
        Some(output) => named(&output.write(&table.files().map_err(Failure::machine)?)?),
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

fn read(file: &Path, assignments: &[String], trust: &Trust) -> Result<Comparison, Failure> {
    let (name, text) = source(file)?;
    let comparison = Comparison::parse(&name, &text, assignments).map_err(Failure::input)?;
    let comparison = comparison.allowing(trust);
    let permitted = comparison.common.material.permitted();
    permitted.map_err(Failure::input).map(|()| comparison)
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
