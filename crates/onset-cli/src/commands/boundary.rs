//! `onset boundary`: stability boundaries of a study as curves.

use super::{Failure, named, wrote};
use crate::patience::bar;
use crate::printing::print;
use indicatif::ProgressBar;
use onset_study::boundary::{Boundaries, Summary, Tracing, Watch, csv, files};
use onset_study::output::Output;
use onset_study::settings::Study;
use serde::Serialize;
use std::path::Path;
use std::process::ExitCode;

/// Document printed as JSON.
#[derive(Serialize)]
struct Document {
    #[serde(flatten)]
    summary: Summary,
    files: Vec<String>,
}

/// Counter of evaluated states, on a terminal.
pub(super) struct Counter(ProgressBar);

impl Counter {
    pub(super) fn new() -> Self {
        let template = "{spinner} tracing boundaries: {pos} states, {per_sec} ({elapsed})";
        Self(bar(0, template))
    }

    pub(super) fn finish(&self) {
        self.0.finish_and_clear();
    }
}

impl Watch for Counter {
    fn asked(&self, states: u64) {
        self.0.inc(states);
    }
}

/// Traces the boundaries, writes files, and prints the summary.
pub fn boundary(study: &Study, tracing: Tracing, out: Option<&Path>) -> Result<ExitCode, Failure> {
    let output = out.map(|out| Output::at(out, &["boundary.geojson", "boundary.csv"]));
    let output = output.transpose()?;
    let counter = Counter::new();
    let traced = Boundaries::of(study, tracing, &counter);
    counter.finish();
    let boundaries = traced.map_err(Failure::input)?;
    let made = files(&boundaries).map_err(Failure::machine)?;
    let written = match output {
        Some(output) => output.write(&made)?,
        None => Vec::new(),
    };
    let summary = boundaries.summary();
    let text = format!("{summary}{}", wrote(&written));
    // File names are printed as text, so that names that are not UTF-8 cause no error after everything is written.
    let files = named(&written);
    print(&Document { summary, files }, text.trim_end(), || {
        csv(&boundaries)
    })
}
