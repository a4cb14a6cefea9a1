//! `onset compare` and `onset recommend`: comparison and ranking of methods.

use super::{Failure, print_with_files, progress, source, with_energy, with_files};
use crate::arguments::{CompareArguments, RecommendArguments};
use crate::printing::print;
use onset_study::compare::{PANELS, Recommendation, Table, Thresholds};
use onset_study::output::Output;
use onset_study::settings::{Comparison, Trust};
use std::path::Path;
use std::process::ExitCode;

/// Files of a comparison table.
const FILES: [&str; 4] = ["compare.html", "compare.csv", "compare.svg", "compare.png"];

/// Compares the methods of a file.
pub fn compare(arguments: &CompareArguments) -> Result<ExitCode, Failure> {
    let trust = arguments.trust.trust();
    let comparison = read(&arguments.file, &arguments.assignments, &trust)?;
    let output = arguments.out.as_deref();
    let output = output.map(|out| Output::at(out, &FILES)).transpose()?;
    let table = evaluated(&comparison)?;
    let shown = arguments.detail.text(&table);
    print_with_files(&table, &shown, output, || table.files(), Some(table.csv()))
}

/// Ranks the methods of a file, or all built-in methods.
pub fn recommend(arguments: &RecommendArguments) -> Result<ExitCode, Failure> {
    let mut assignments = with_energy(&arguments.assignments, arguments.energy.as_deref())?;
    if let Some((low, high)) = arguments.stretches {
        assignments.push(format!("compare.stretches={low},{high}"));
    }
    let mut comparison = match &arguments.file {
        Some(file) => read(file, &assignments, &arguments.trust.trust())?,
        None => {
            let (name, text) = PANELS[usize::from(arguments.dimension) - 1];
            Comparison::parse(name, text, &assignments).map_err(Failure::input)?
        }
    };
    let output = arguments.out.as_deref();
    let output = output.map(|out| Output::at(out, &FILES)).transpose()?;
    comparison.override_weak(arguments.thresholds.weak.share);
    let mut table = evaluated(&comparison)?;
    table.thresholds = Thresholds {
        weak: table.thresholds.weak,
        long_waves: arguments.long_waves,
        wavelength: arguments.wavelength,
        ..arguments.thresholds.thresholds()
    };
    let written = match output {
        Some(output) => output.write(&table.files().map_err(Failure::machine)?)?,
        None => Vec::new(),
    };
    let recommendation = Recommendation::new(table);
    let ranking = recommendation.csv();
    print(
        &recommendation,
        &with_files(&arguments.detail.text(&recommendation), &written),
        Some(ranking),
    )
}

fn read(file: &Path, assignments: &[String], trust: &Trust) -> Result<Comparison, Failure> {
    let (name, text) = source(file)?;
    let comparison = Comparison::parse(&name, &text, assignments).map_err(Failure::input)?;
    let comparison = comparison.allowing(trust);
    let permitted = comparison.common.material.permitted();
    permitted.map_err(Failure::input).map(|()| comparison)
}

fn evaluated(comparison: &Comparison) -> Result<Table, Failure> {
    let bar = progress(comparison.candidates.len(), "methods compared:");
    let table = Table::of(comparison, |name| {
        bar.set_message(name.to_owned());
        bar.inc(1);
    })?;
    bar.finish_and_clear();
    match table.failure() {
        Some(why) => Err(Failure::input(why)),
        None => Ok(table),
    }
}
