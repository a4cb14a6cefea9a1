//! `onset compare` and `onset recommend`: comparison and ranking of methods.

use super::{Failure, Read, print_with_files, progress, with_energy, with_files};
use crate::arguments::{BlockArguments, CompareArguments, RecommendArguments};
use crate::printing::print;
use onset_study::compare::{PANELS, Recommendation, Table, Thresholds};
use onset_study::settings::{Comparison, Trust};
use std::path::Path;
use std::process::ExitCode;

/// Files of a comparison table, without the figure.
const FILES: [&str; 2] = ["compare.html", "compare.csv"];

/// Compares the methods of a file.
pub fn compare(arguments: &CompareArguments) -> Result<ExitCode, Failure> {
    if arguments.file.is_none() && arguments.variations.is_empty() {
        return Err(Failure::input(
            "neither FILE nor --vary is given\n  hint: `onset compare --vary discretization.kernel` compares variants of a method, \
             `onset compare FILE` a study with the built-in methods or the [[methods]] of a file (examples in comparisons/), and \
             `onset recommend` all built-in methods",
        ));
    }
    let trust = arguments.trust.trust();
    let mut comparison = read(
        arguments.file.as_deref(),
        &arguments.block,
        None,
        arguments.assignments.clone(),
        &arguments.variations,
        &trust,
    )?;
    let place = arguments.out.as_deref();
    let output = arguments.drawing.output(place, "compare", &FILES)?;
    comparison.override_weak(arguments.weak.share);
    let table = evaluated(&comparison)?;
    let shown = arguments.detail.text(&table);
    print_with_files(&table, &shown, output, || Ok(table.files()), || table.csv())
}

/// Ranks the methods of a file, or all built-in methods.
pub fn recommend(arguments: &RecommendArguments) -> Result<ExitCode, Failure> {
    let mut assignments = with_energy(&arguments.assignments, arguments.energy.as_deref())?;
    if let Some((low, high)) = arguments.stretches {
        assignments.push(format!("compare.stretches={low},{high}"));
    }
    let mut comparison = read(
        arguments.file.as_deref(),
        &arguments.block,
        arguments.dimension,
        assignments,
        &[],
        &arguments.trust.trust(),
    )?;
    let place = arguments.out.as_deref();
    let output = arguments.drawing.output(place, "compare", &FILES)?;
    comparison.override_weak(arguments.thresholds.weak.share);
    let mut table = evaluated(&comparison)?;
    table.thresholds = Thresholds {
        weak: table.thresholds.weak,
        long_waves: arguments.long_waves,
        wavelength: arguments.wavelength,
        ..arguments.thresholds.thresholds()
    };
    let recommendation = Recommendation::new(table);
    let written = match output {
        Some(output) => output.write(&recommendation.files())?,
        None => Vec::new(),
    };
    print(
        &recommendation,
        &with_files(&arguments.detail.text(&recommendation), &written),
        || recommendation.csv(),
    )
}

/// Comparison in a file, or the built-in methods for a number of dimensions, or variants of a method.
fn read(
    file: Option<&Path>,
    block: &BlockArguments,
    dimension: Option<u8>,
    assignments: Vec<String>,
    variations: &[String],
    trust: &Trust,
) -> Result<Comparison, Failure> {
    let mut read = Read::of(file, block, assignments)?;
    let is_study = file.is_some() && !read.is_deck;
    match dimension {
        Some(_) if is_study => {
            return Err(Failure::input(
                "--dimension has no effect: the file sets the number of dimensions\n  hint: omit --dimension",
            ));
        }
        _ if is_study || !variations.is_empty() => {}
        dimension => {
            let panel = PANELS[usize::from(dimension.unwrap_or(2)) - 1];
            (read.name, read.text) = (panel.0.to_owned(), panel.1.to_owned());
        }
    }
    let (name, text) = (&read.name, &read.text);
    let comparison = Comparison::varied(name, text, &read.assignments, variations);
    let comparison = comparison.map_err(|error| read.failure(error))?;
    let mut comparison = comparison.allowing(trust);
    comparison.common.material = read.law(comparison.common.material, trust)?;
    Ok(comparison)
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
