//! `onset verify`: acceptance tests for particle codes.

use super::{Failure, with_files};
use crate::arguments::{DeckArguments, VerifyTask};
use crate::printing::print;
use onset_study::answers::{Strain, numbers};
use onset_study::output::Output;
use onset_study::settings::{Settings, StateSettings};
use onset_study::verify::{
    CASE_FILE, Case, Code, Codes, Judgment, Question, VerifyError, named, read, run,
};
use std::process::ExitCode;

impl From<VerifyError> for Failure {
    fn from(error: VerifyError) -> Self {
        Self::input(error)
    }
}

/// Writes, runs or reads a deck.
pub fn verify(task: &VerifyTask) -> Result<ExitCode, Failure> {
    match task {
        VerifyTask::Deck(arguments) => deck(arguments),
        VerifyTask::Run { deck, program } => told(&run(deck, program.as_deref())?),
        VerifyTask::Read { output, case } => told(&read(output, case.as_deref())?),
        VerifyTask::Codes => {
            let codes = Codes::all();
            print(&codes, &codes.to_string(), || codes.csv())
        }
    }
}

fn told(judgment: &Judgment) -> Result<ExitCode, Failure> {
    print(judgment, &judgment.to_string(), || judgment.csv())?;
    Ok(ExitCode::from(judgment.outcome.code()))
}

fn deck(arguments: &DeckArguments) -> Result<ExitCode, Failure> {
    let code = named(&arguments.code)?;
    if arguments.stepping.is_some() && code.program().is_some() {
        return Err(Failure::input(format!(
            "--stepping has no effect: the time stepping of {} is known\n  hint: omit --stepping; only --code plain reads it",
            code.name()
        )));
    }
    let (settings, state) = settings(code, arguments)?;
    let question = Question {
        stretches: stretches(arguments, &settings, &state)?,
        wave_vector: numbers("--wave-vector", &arguments.wave_vector)?,
        branch: arguments.branch,
        time_step: arguments.time_step,
        steps: arguments.steps.map(|steps| steps as usize),
        tolerance: arguments.tolerance,
        stepping: arguments.stepping,
    };
    let output = Output::at(&arguments.out, &[CASE_FILE])?;
    let (case, files) = Case::new(code, settings, &question)?;
    let written = output.write(&files)?;
    let next = match code.program() {
        Some(_) => format!("next         onset verify run {}", arguments.out.display()),
        None => format!(
            "next         run the code as {} says, then onset verify read {}",
            arguments.out.join("PROTOCOL.txt").display(),
            arguments.out.display()
        ),
    };
    let text = format!("{case}\n{next}");
    print(&case, &with_files(&text, &written), || case.csv())
}

fn settings(
    code: &dyn Code,
    arguments: &DeckArguments,
) -> Result<(Settings, StateSettings), Failure> {
    let problem = &arguments.problem;
    let given = problem.read()?;
    let dialect: Vec<(&str, &str)> = code
        .dialect()
        .iter()
        .map(|choice| (choice.key, choice.value))
        .collect();
    let read = Settings::of_dialect(&given.name, &given.text, &dialect, &given.assignments);
    let (mut settings, state) = read.map_err(|error| given.failure(error))?;
    settings.material = given.law(settings.material, &problem.given.trust.trust())?;
    Ok((settings, state))
}

/// Stretches of the state, which must be along the axes.
fn stretches(
    arguments: &DeckArguments,
    settings: &Settings,
    state: &StateSettings,
) -> Result<[f64; 3], Failure> {
    if let Some(text) = &arguments.stretch {
        let strain = Strain::of_stretches("--stretch", text, settings.extent())?;
        let f = strain.0.components();
        return Ok([f[0][0], f[1][1], f[2][2]]);
    }
    if state.shear != 0.0 || state.rotation != 0.0 {
        return Err(Failure::input(
            "decks support only stretches along the axes; this study has a shear or a rotation\n  hint: give --stretch",
        ));
    }
    Ok(state.stretches)
}
