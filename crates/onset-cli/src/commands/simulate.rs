//! `onset simulate`: predictions seen in motion.

use super::{Failure, with_files};
use crate::arguments::SimulateArguments;
use crate::interrupt;
use crate::printing::{is_quiet, print, tell};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};
use onset_study::answers::numbers;
use onset_study::simulate::{
    Duration, Place, Question, Seeded, SimulateError, Watch, simulate as run,
};
use std::process::ExitCode;
use std::str::FromStr;

impl From<SimulateError> for Failure {
    fn from(error: SimulateError) -> Self {
        match error.is_input() {
            true => Self::input(error),
            false => Self::machine(error),
        }
    }
}

/// Runs a patch.
pub fn simulate(arguments: &SimulateArguments) -> Result<ExitCode, Failure> {
    let problem = arguments.problem.build()?;
    let strain = arguments.strain.build(&problem)?;
    let seeded = match (&arguments.wave_vector, &arguments.turns, &*arguments.mode) {
        (Some(text), ..) => Seeded::Wave(numbers("--wave-vector", text)?),
        (None, Some(text), _) => Seeded::Turns(whole("--turns", text)?),
        (None, None, "noise") => Seeded::Noise,
        (None, None, _) => Seeded::Critical,
    };
    let question = Question {
        f: strain.0,
        cells: whole("--cells", &arguments.cells)?,
        seeded,
        branch: arguments.branch,
        amplitude: arguments.amplitude,
        seed: arguments.seed,
        duration: match (arguments.steps, arguments.time) {
            (Some(steps), _) => Duration::Steps(steps),
            (None, Some(time)) => Duration::Time(time),
            (None, None) => Duration::Natural,
        },
        fraction: arguments.fraction,
        time_step: arguments.time_step,
        is_supercritical: arguments.supercritical,
        stepper: arguments.integrator,
        every: arguments.every,
        fields: arguments.fields,
        tolerance: arguments.tolerance,
    };
    let place = arguments.out.as_ref().map(|folder| Place {
        folder: folder.clone(),
        is_resumed: arguments.resume,
        is_overwritten: arguments.overwrite,
        checkpoint: arguments.checkpoint,
    });
    let told = match place {
        Some(_) => "writing a checkpoint; interrupt again to end at once",
        None => "ending; interrupt again to end at once",
    };
    let at_end = match place {
        Some(_) => "interrupted; the same command with --resume goes on from the last checkpoint",
        None => "interrupted; nothing was kept: give --out",
    };
    let answer = interrupt::Answer {
        told: (!is_quiet()).then_some(told),
        at_end: Some(at_end.to_owned()),
        patience: None,
    };
    interrupt::answer_with(answer).map_err(Failure::machine)?;
    let progress = Progress::new(is_quiet());
    let answer = run(&problem, &question, place.as_ref(), &progress)?;
    progress.0.finish_and_clear();
    print(&answer, &with_files(&answer, &answer.files), None)?;
    if answer.interrupted {
        let how = match place {
            Some(_) => "the same command with --resume goes on",
            None => "nothing was kept: give --out",
        };
        tell(format_args!(
            "interrupted after {} steps; {how}",
            answer.steps_taken
        ));
        return Ok(ExitCode::from(interrupt::CODE));
    }
    Ok(ExitCode::from(answer.outcome.code()))
}

/// Whole numbers, separated by commas.
fn whole<T: FromStr>(option: &str, text: &str) -> Result<Vec<T>, Failure> {
    let each = text.split(',').map(|own| own.trim().parse::<T>());
    each.collect::<Result<_, _>>().map_err(|_| {
        Failure::input(format!(
            "{option}: expected whole numbers, not `{text}`\n  hint: one for each side of the patch, for example {option} 8,4"
        ))
    })
}

/// A progress bar on a terminal; nothing elsewhere.
struct Progress(ProgressBar);

impl Progress {
    fn new(quiet: bool) -> Self {
        let target = match quiet {
            true => ProgressDrawTarget::hidden(),
            false => ProgressDrawTarget::stderr(),
        };
        let bar = ProgressBar::with_draw_target(None, target).with_finish(ProgressFinish::AndClear);
        let style = ProgressStyle::with_template(
            "{bar:32} {percent:>3} % of {human_len} steps, {per_sec}, {eta} left",
        );
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Self(bar)
    }
}

impl Watch for Progress {
    fn advance(&self, done: u64, all: u64) {
        self.0.set_length(all);
        self.0.set_position(done);
    }

    fn is_interrupted(&self) -> bool {
        interrupt::is_asked()
    }
}
