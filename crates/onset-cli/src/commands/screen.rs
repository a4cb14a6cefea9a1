//! `onset screen`: the first cause of an instability in a run of another code.

use super::{Failure, wrote};
use crate::arguments::{BlockArguments, GivenArguments, ProblemArguments, ScreenArguments};
use crate::fail_on;
use crate::patience::{self, bar};
use crate::printing::{print, tell};
use onset_study::answers::Problem;
use onset_study::screen::{
    Question, Recording, ScreenAnswer, ScreenChecks, ScreenError, ScreenFiles, Source, missing,
};
use onset_study::settings::Family;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, SystemTime};

impl From<ScreenError> for Failure {
    fn from(error: ScreenError) -> Self {
        match error {
            ScreenError::Output(error) => Self::machine(error),
            error => Self::input(error),
        }
    }
}

/// Time between two checks of the files of a running simulation.
const WATCH_INTERVAL: Duration = Duration::from_millis(500);

/// Screens a run, once or whenever its files have grown.
pub fn screen(arguments: &ScreenArguments) -> Result<ExitCode, Failure> {
    if !arguments.watch {
        return once(arguments, "").map(|(code, _, _)| code);
    }
    let mut last = String::new();
    loop {
        let before = extents(&arguments.files);
        match once(arguments, &last) {
            Ok((code, true, _)) => return Ok(code),
            Ok((_, false, shown)) => last = shown,
            // A frame that is being written can be damaged for a moment.
            Err(failure) if !last.is_empty() => tell(format_args!("waiting: {}", failure.message)),
            Err(failure) => return Err(failure),
        }
        while extents(&arguments.files) == before {
            std::thread::sleep(WATCH_INTERVAL);
        }
    }
}

/// Sizes and modification times of the files, and modification times of the folders in which new frames appear.
fn extents(files: &[PathBuf]) -> Vec<(u64, Option<SystemTime>)> {
    let of = |path: &Path| {
        let metadata = std::fs::metadata(path);
        metadata.map_or((0, None), |own| (own.len(), own.modified().ok()))
    };
    let folder = |path: &PathBuf| match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => of(parent),
        _ => of(Path::new(".")),
    };
    files
        .iter()
        .flat_map(|path| [of(path), folder(path)])
        .collect()
}

/// Screens the files as they are, or prints only their recognized contents. Returns the exit code, whether it is due to `--fail-on`, and the text, which is
/// printed unless it equals `last`.
fn once(arguments: &ScreenArguments, last: &str) -> Result<(ExitCode, bool, String), Failure> {
    let (problem, files) = problem(arguments)?;
    let source = source(arguments, files)?;
    let place = arguments.out.as_deref().filter(|_| !arguments.check);
    let output = arguments
        .drawing
        .output(place, "screen", &ScreenFiles::NAMES)?;
    let dimension = problem.dimension();
    let has_elements = problem.settings.method.method == Family::FiniteElements;
    let (recording, run, mut series) = Recording::open(&source, dimension, has_elements)?;
    if arguments.check {
        let checks = ScreenChecks::new(&problem, recording, &run);
        let text = checks.to_string();
        return Ok((print(&checks, &text, || checks.csv())?, false, text));
    }
    if missing(&problem.settings).len() > 1 {
        return Err(Failure::input(
            "neither the law nor the method of the run is given\n  hint: name a study (STUDY.toml), or set material.model and discretization.method by --set, or --preset; `onset screen FILES --check` reads the files alone",
        ));
    }
    let question = Question {
        time_step: arguments.time_step,
        stepping: arguments.stepping,
        threshold: arguments.threshold,
        seed: arguments.seed,
        bin: arguments.bin,
        actual: arguments.actual,
        weak: arguments.weak.share,
    };
    patience::end();
    let progress = bar(
        recording.frames as u64,
        "{bar:32} frame {pos} of {len}, {eta} left",
    );
    let files = output.map(|output| ScreenFiles::new(output, &run, arguments.fields));
    let mut files = files.transpose()?;
    let mut frames = recording.frames(&mut series, dimension);
    let answer = ScreenAnswer::new(
        &problem,
        &question,
        &run,
        Some(&recording),
        &mut frames,
        &mut |snapshot| {
            progress.set_position(snapshot.number as u64 + 1);
            match &mut files {
                Some(files) => files.add(snapshot, recording.frames),
                None => Ok(()),
            }
        },
    );
    progress.finish_and_clear();
    let answer = answer?;
    let written = match files {
        Some(files) => files.finish(&answer)?,
        None => Vec::new(),
    };
    let shown = match written.as_slice() {
        [] => arguments.detail.text(&answer),
        files => format!("{}\n\n{}", arguments.detail.text(&answer), wrote(files)),
    };
    if shown != last {
        print(&answer, &shown, || answer.csv())?;
    }
    match arguments.fail_on.contains(&answer.cause) {
        true => {
            tell(format_args!(
                "fails by --fail-on: the first cause is {} (exit code {})",
                answer.cause.name(),
                fail_on::CODE
            ));
            Ok((ExitCode::from(fail_on::CODE), true, shown))
        }
        false => Ok((ExitCode::SUCCESS, false, shown)),
    }
}

/// Problem of a study among the files or of the settings, and the other files.
fn problem(arguments: &ScreenArguments) -> Result<(Problem, Vec<PathBuf>), Failure> {
    let is_study = |path: &PathBuf| path.extension().is_some_and(|own| own == "toml");
    let (studies, files): (Vec<PathBuf>, Vec<PathBuf>) =
        arguments.files.iter().cloned().partition(is_study);
    if studies.len() > 1 {
        return Err(Failure::input(
            "several studies are given\n  hint: name one file that ends with .toml, and the output files of the run",
        ));
    }
    if files.is_empty() {
        return Err(Failure::input(
            "no output file of a run is given\n  hint: for example onset screen STUDY.toml dump.*.gz, or run.pvd",
        ));
    }
    let problem = ProblemArguments {
        given: GivenArguments {
            file: studies.into_iter().next(),
            set: arguments.set.clone(),
            trust: arguments.trust.clone(),
        },
        block: BlockArguments::default(),
    };
    Ok((problem.build()?, files))
}

fn source(arguments: &ScreenArguments, files: Vec<PathBuf>) -> Result<Source, Failure> {
    let mut source = Source {
        files,
        reference: arguments.reference.clone(),
        held: arguments.held.clone(),
        region: arguments.region.clone(),
        ..Source::default()
    };
    source.reading.time_step = arguments.time_step;
    source.reading.frames = arguments.frames;
    if let Some(columns) = &arguments.columns {
        source.reading = source
            .reading
            .with_columns(columns)
            .map_err(Failure::input)?;
    }
    Ok(source)
}
