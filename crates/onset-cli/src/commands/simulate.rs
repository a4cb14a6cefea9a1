//! `onset simulate`: simulations of patches, compared with predictions, and of bodies.

use super::{Failure, with_files};
use crate::arguments::SimulateArguments;
use crate::drawing::is_picture;
use crate::interrupt;
use crate::patience::{self, bar};
use crate::printing::{print, tell};
use indicatif::ProgressBar;
use onset_study::answers::{Problem, numbers};
use onset_study::output::{Output, picture};
use onset_study::settings::BodySettings;
use onset_study::simulate::{
    BodyQuestion, Duration, Pace, Place, Question, Seeded, SimulateError, Watch, run_body,
    simulate as run,
};
use std::process::ExitCode;
use std::str::FromStr;
use std::sync::OnceLock;
use std::time;

/// Longest time of a step and of its checkpoint after an interrupt; afterwards the last checkpoint stands.
const PATIENCE: time::Duration = time::Duration::from_millis(200);

impl From<SimulateError> for Failure {
    fn from(error: SimulateError) -> Self {
        match error.is_input() {
            true => Self::input(error),
            false => Self::machine(error),
        }
    }
}

/// Runs a patch, or the body of the study.
pub fn simulate(arguments: &SimulateArguments) -> Result<ExitCode, Failure> {
    let problem = arguments.problem.build()?;
    let alone = figure_alone(arguments, problem.settings.body.is_some())?;
    let kept = arguments.out.as_ref().filter(|_| alone.is_none());
    let place = kept.map(|folder| Place {
        folder: folder.clone(),
        is_resumed: arguments.resume,
        is_overwritten: arguments.overwrite,
        checkpoint: arguments.checkpoint,
        sheet: arguments.drawing.sheet(),
    });
    let is_kept = place.is_some();
    if arguments.out.is_none() {
        arguments.drawing.refuse_idle("DIR")?;
    }
    match problem.settings.body.clone() {
        None => {
            let question = patch(arguments, &problem)?;
            let progress = Progress::new(is_kept);
            let answer = run(&problem, &question, place.as_ref(), &progress)?;
            progress.finish();
            let written = match alone {
                Some(output) => output.write(&vec![picture("simulate", answer.figure())])?,
                None => answer.files.clone(),
            };
            print(&answer, &with_files(&answer, &written), || answer.csv())?;
            match answer.interrupted {
                true => Ok(interrupted(answer.steps_taken, is_kept)),
                false => Ok(ExitCode::from(answer.outcome.code())),
            }
        }
        Some(body) => {
            let question = body_question(arguments, &problem, body)?;
            let progress = Progress::new(is_kept);
            let answer = run_body(&problem, &question, place.as_ref(), &progress)?;
            progress.finish();
            print(&answer, &with_files(&answer, &answer.files), || {
                answer.csv()
            })?;
            match answer.interrupted {
                true => Ok(interrupted(answer.steps_taken, is_kept)),
                false => Ok(ExitCode::SUCCESS),
            }
        }
    }
}

/// Output of the figure alone, if the path has the ending of a figure; `None` for a folder.
fn figure_alone(arguments: &SimulateArguments, is_body: bool) -> Result<Option<Output>, Failure> {
    let Some(out) = arguments.out.as_ref().filter(|out| is_picture(out)) else {
        return Ok(None);
    };
    let idle = [
        ("--resume", arguments.resume),
        ("--overwrite", arguments.overwrite),
        ("--checkpoint", arguments.checkpoint.is_some()),
        ("--fields", arguments.fields.is_some()),
    ];
    let idle = idle.iter().find(|(_, is_given)| *is_given);
    let refused = match idle {
        Some((option, _)) => format!(
            "{option} has no effect: --out {} is the figure alone",
            out.display()
        ),
        None if is_body => format!(
            "--out {} is a figure; a body is written to a folder",
            out.display()
        ),
        None => return arguments.drawing.output(Some(out), "simulate", &[]),
    };
    let hint = "give a folder, for example --out results";
    Err(Failure::input(format!("{refused}\n  hint: {hint}")))
}

fn pace(arguments: &SimulateArguments) -> Pace {
    Pace {
        duration: match (arguments.steps, arguments.time) {
            (Some(steps), _) => Duration::Steps(steps),
            (None, Some(time)) => Duration::Time(time),
            (None, None) => Duration::Natural,
        },
        fraction: arguments.fraction,
        time_step: arguments.time_step,
        is_supercritical: arguments.supercritical,
        every: arguments.every,
        fields: arguments.fields.unwrap_or(11),
    }
}

/// Seed of the noise; refused if the start is not random.
fn seed(arguments: &SimulateArguments, is_random: bool, hint: &str) -> Result<u64, Failure> {
    match arguments.seed {
        Some(_) if !is_random => Err(Failure::input(format!(
            "--seed has no effect: nothing moves at random at the start\n  hint: {hint}, or omit --seed"
        ))),
        given => Ok(given.unwrap_or(1)),
    }
}

fn patch(arguments: &SimulateArguments, problem: &Problem) -> Result<Question, Failure> {
    let seeded = match (
        &arguments.wave_vector,
        &arguments.turns,
        arguments.mode.as_deref(),
    ) {
        (Some(text), ..) => Seeded::Wave(numbers("--wave-vector", text)?),
        (None, Some(text), _) => Seeded::Turns(whole("--turns", text)?),
        (None, None, Some("noise")) => Seeded::Noise,
        (None, None, _) => Seeded::Critical,
    };
    let is_noise = matches!(seeded, Seeded::Noise);
    Ok(Question {
        f: arguments.strain.build(problem)?.0,
        cells: whole("--cells", arguments.cells.as_deref().unwrap_or("8"))?,
        seeded,
        branch: arguments.branch.unwrap_or(1),
        amplitude: arguments.amplitude.unwrap_or(1e-6),
        seed: seed(arguments, is_noise, "give --mode noise")?,
        pace: pace(arguments),
        stepper: arguments.integrator,
        tolerance: arguments.tolerance.unwrap_or(1e-6),
    })
}

/// Question about a body; refuses options for waves.
fn body_question(
    arguments: &SimulateArguments,
    problem: &Problem,
    body: BodySettings,
) -> Result<BodyQuestion, Failure> {
    let idle = [
        ("--cells", arguments.cells.is_some()),
        ("--mode", arguments.mode.is_some()),
        ("--wave-vector", arguments.wave_vector.is_some()),
        ("--turns", arguments.turns.is_some()),
        ("--branch", arguments.branch.is_some()),
        ("--tolerance", arguments.tolerance.is_some()),
        (
            "--integrator",
            arguments
                .integrator
                .is_some_and(|own| own.name() != "central-differences"),
        ),
    ];
    if let Some(name) = problem.settings.integrator_of_other_steps() {
        return Err(Failure::input(format!(
            "time.integrator = {name} has no effect on a body, which moves by central differences\n  hint: omit time.integrator, or remove [body] from the study"
        )));
    }
    if let Some((option, _)) = idle.iter().find(|(_, is_given)| *is_given) {
        return Err(Failure::input(format!(
            "{option} has no effect on a body, which moves by central differences and is not compared with waves\n  hint: omit {option}, or remove [body] from the study"
        )));
    }
    let amplitude = arguments.amplitude.unwrap_or(0.0);
    Ok(BodyQuestion {
        body,
        f: match arguments.strain.is_given() {
            true => Some(arguments.strain.build(problem)?.0),
            false => None,
        },
        amplitude,
        seed: seed(arguments, amplitude != 0.0, "give --amplitude")?,
        pace: pace(arguments),
    })
}

fn interrupted(steps: u64, is_kept: bool) -> ExitCode {
    let how = match is_kept {
        true => "the same command with --resume continues",
        false => "nothing was kept: give --out",
    };
    tell(format_args!("interrupted after {steps} steps; {how}"));
    ExitCode::from(interrupt::CODE)
}

/// Parses whole numbers, separated by commas.
fn whole<T: FromStr>(option: &str, text: &str) -> Result<Vec<T>, Failure> {
    let each = text.split(',').map(|own| own.trim().parse::<T>());
    each.collect::<Result<_, _>>().map_err(|_| {
        Failure::input(format!(
            "{option}: expected whole numbers, not `{text}`\n  hint: one for each side of the patch, for example {option} 8,4"
        ))
    })
}

/// Progress of a run on a terminal; an interrupt saves the run.
struct Progress {
    bar: OnceLock<ProgressBar>,
    is_kept: bool,
}

impl Progress {
    fn new(is_kept: bool) -> Self {
        let bar = OnceLock::new();
        Self { bar, is_kept }
    }

    /// Ends the setup phase and shows the progress bar.
    fn begun(&self, steps: u64) -> ProgressBar {
        patience::end();
        self.answer_interrupts();
        let template = "{bar:32} {percent:>3} % of {human_len} steps, {per_sec}, {eta} left";
        bar(steps, template)
    }

    fn finish(&self) {
        interrupt::is_ending();
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }

    /// Lets an interrupt end the run after the current step. A long step is abandoned.
    fn answer_interrupts(&self) {
        let at_end = match self.is_kept {
            true => {
                "interrupted; the same command with --resume continues from the last checkpoint"
            }
            false => "interrupted; nothing was kept: give --out",
        };
        interrupt::answer_with(interrupt::Answer {
            at_end: Some(at_end.to_owned()),
            patience: PATIENCE,
        });
    }
}

impl Watch for Progress {
    fn advance(&self, done: u64, all: u64) {
        let bar = self.bar.get_or_init(|| self.begun(all));
        bar.set_position(done);
    }

    fn is_interrupted(&self) -> bool {
        interrupt::is_asked()
    }
}
