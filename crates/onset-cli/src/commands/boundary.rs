//! `onset boundary`: the boundaries of a study as curves.

use super::{Failure, print_json, print_text, study};
use indicatif::{ProgressBar, ProgressStyle};
use onset_study::boundary::{Boundaries, Summary, Tracing, Watch, write};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// What is printed as JSON.
#[derive(Serialize)]
struct Document {
    #[serde(flatten)]
    summary: Summary,
    files: [PathBuf; 2],
}

/// How many states have been asked, on a terminal.
pub(super) struct Counter(ProgressBar);

impl Counter {
    pub(super) fn new() -> Self {
        let bar = ProgressBar::new_spinner();
        let style = ProgressStyle::with_template(
            "{spinner} tracing boundaries: {pos} states, {per_sec} ({elapsed})",
        );
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
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

/// Traces, writes and tells.
pub fn boundary(
    file: &Path,
    assignments: &[String],
    tracing: Tracing,
    out: &Path,
    json: bool,
) -> Result<ExitCode, Failure> {
    let study = study(file, assignments)?;
    // Before the work: a folder that cannot be made is told at once.
    std::fs::create_dir_all(out)
        .map_err(|error| Failure::machine(format!("cannot write {}: {error}", out.display())))?;
    let counter = Counter::new();
    let traced = Boundaries::of(&study, tracing, &counter);
    counter.finish();
    let boundaries = traced.map_err(Failure::input)?;
    let files = write(&boundaries, out).map_err(|(path, error)| {
        Failure::machine(format!("cannot write {}: {error}", path.display()))
    })?;
    let summary = boundaries.summary();
    if json {
        return print_json(&Document { summary, files });
    }
    let [first, second] = files.map(|file| file.display().to_string());
    print_text(&format!("{summary}wrote {first} and {second}"))
}
