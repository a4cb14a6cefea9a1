//! `onset map`: verdicts on all states of a study, written to a store.

use crate::arguments::MapArguments;
use crate::commands::{Failure, study};
use crate::interrupt;
use crate::patience::{self, bar};
use crate::printing::{print, tell};
use indicatif::ProgressBar;
use onset_study::map::{MapError, Plan, Summary, Watch};
use onset_study::shell::{quoted, quoted_file};
use onset_study::store::{StoreError, ZarrStore};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Time after an interrupt for states in progress.
const PATIENCE: Duration = Duration::from_millis(200);

impl From<MapError> for Failure {
    fn from(error: MapError) -> Self {
        if error.is_input() {
            Self::input(error)
        } else {
            Self::machine(error)
        }
    }
}

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Self {
        MapError::from(error).into()
    }
}

/// Summary of the run, with the path of the store.
#[derive(Serialize)]
struct Answer<'a> {
    store: String,
    #[serde(flatten)]
    summary: &'a Summary,
    interrupted: bool,
}

/// Computes a map, or the requested tiles.
pub fn run(arguments: &MapArguments) -> Result<ExitCode, Failure> {
    let trust = arguments.trust.trust();
    let study = study(
        &arguments.file,
        &arguments.assignments,
        arguments.block.from,
        &trust,
    )?;
    let plan = Plan::new(&study)?;
    let tiles = plan.tiles(arguments.tiles.clone())?;
    let path = arguments
        .out
        .clone()
        .unwrap_or_else(|| default_place(&arguments.file));
    let again = format!("interrupted; resume with\n  {}", resuming(arguments, &path));
    let answer = interrupt::Answer {
        at_end: Some(again.clone()),
        patience: PATIENCE,
    };
    interrupt::answer_with(answer);
    let store = if arguments.overwrite {
        ZarrStore::replace(&path, plan.layout())
    } else if arguments.resume || arguments.tiles.is_some() {
        ZarrStore::resume(&path, plan.layout())
    } else {
        ZarrStore::create(&path, plan.layout())
    }?;
    let states = tiles
        .iter()
        .map(|tile| plan.tiling().at(*tile).states() as u64)
        .sum();
    let template =
        "{bar:32} {percent:>3} % of {human_len} states, {per_sec}, {eta} left ({elapsed})";
    patience::end();
    let progress = Progress(bar(states, template));
    let asked = tiles.len();
    let summary = plan.run(&store, &tiles, &progress)?;
    interrupt::is_ending();
    progress.0.finish_and_clear();
    let is_interrupted = summary.tiles_computed + summary.tiles_found < asked;
    let answer = Answer {
        store: path.display().to_string(),
        summary: &summary,
        interrupted: is_interrupted,
    };
    let text = format!("{summary}\nstore: {}", path.display());
    print(&answer, &text, || summary.csv())?;
    if is_interrupted {
        tell(again);
        return Ok(ExitCode::from(interrupt::CODE));
    }
    Ok(match &arguments.failing.fail_on {
        Some(fail_on) => {
            let verdicts = summary.verdicts.iter();
            fail_on.code(verdicts.map(|(name, share)| (Some(*name), share.states)))
        }
        None => ExitCode::SUCCESS,
    })
}

/// Default store: the name of the study file with `.zarr`, in the current folder.
fn default_place(file: &Path) -> PathBuf {
    let mut name = file.file_stem().unwrap_or_default().to_owned();
    name.push(".zarr");
    PathBuf::from(name)
}

/// Command that resumes the map.
fn resuming(arguments: &MapArguments, path: &Path) -> String {
    let mut command = format!(
        "onset map {} --out {} --resume",
        match arguments.file.as_os_str() == "-" {
            true => "- < STUDY".to_owned(),
            false => quoted_file(&arguments.file),
        },
        quoted_file(path)
    );
    if let Some(tiles) = &arguments.tiles {
        command.push_str(&format!(" --tiles {tiles}"));
    }
    for assignment in &arguments.assignments {
        command.push_str(&format!(" --set {}", quoted(assignment.as_ref())));
    }
    for library in &arguments.trust.libraries {
        command.push_str(&format!(" --allow-library {}", quoted_file(library)));
    }
    command
}

/// Number of finished states, on a terminal.
struct Progress(ProgressBar);

impl Watch for Progress {
    fn advance(&self, states: u64) {
        self.0.inc(states);
    }

    fn is_interrupted(&self) -> bool {
        interrupt::is_asked()
    }

    fn is_out_of_time(&self) -> bool {
        interrupt::is_asked()
    }
}
