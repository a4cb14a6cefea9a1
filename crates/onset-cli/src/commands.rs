//! What each command does: ask, and print the answer.

mod audit;
mod boundary;
mod check;
mod compare;
mod localize;
mod modes;
mod notions;
mod plot;
mod tune;

use crate::arguments::{Arguments, Command, ProblemArguments, StrainArguments, TrustArguments};
use crate::map;
use crate::patience;
use indicatif::{ProgressBar, ProgressStyle};
use onset_study::answers::{
    Diagram, PathAnswer, Problem, ProblemError, StateAnswer, Strain, Waves,
};
use onset_study::boundary::Tracing;
use onset_study::catalog;
use onset_study::json;
use onset_study::output::{Output, OutputError, text};
use onset_study::reproduce;
use onset_study::settings::{MaterialSettings, Settings, Study, Trust};
use onset_umat::readable;
use serde::Serialize;
use std::fmt::Display;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Why a command ended without an answer.
pub struct Failure {
    /// What to tell.
    pub message: String,
    /// The exit code.
    pub code: u8,
}

impl Failure {
    pub fn input(error: impl Display) -> Self {
        Self {
            message: error.to_string(),
            code: 2,
        }
    }

    pub fn machine(error: impl Display) -> Self {
        Self {
            message: error.to_string(),
            code: 1,
        }
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        Self::machine(error)
    }
}

impl From<ProblemError> for Failure {
    fn from(error: ProblemError) -> Self {
        Self::input(error)
    }
}

/// Runs a command.
pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    if let Some(doing) = waiting_for(&arguments.command) {
        patience::begin(doing);
    }
    match arguments.command {
        Command::State {
            problem,
            strain,
            certify,
            tolerance,
        } => {
            let json = problem.json;
            let problem = problem.build()?;
            let strain = strain.build(&problem)?;
            let answer = if certify {
                StateAnswer::certified(&problem, &strain, tolerance)?
            } else {
                StateAnswer::new(&problem, &strain)?
            };
            print(&answer, json)
        }
        Command::Dispersion {
            problem,
            strain,
            wave_vector,
            path,
            out,
        } => {
            let json = problem.json;
            let problem = problem.build()?;
            let strain = strain.build(&problem)?;
            match wave_vector {
                Some(wave_vector) => print(&Waves::new(&problem, &strain, &wave_vector)?, json),
                None => diagram(&problem, &strain, path.flatten().as_deref(), &out, json),
            }
        }
        Command::Path { problem, from, to } => {
            let json = problem.json;
            let problem = problem.build()?;
            let from = Strain::of_either("--from", &from, problem.dimension())?;
            let to = Strain::of_either("--to", &to, problem.dimension())?;
            print(&PathAnswer::new(&problem, &from, &to)?, json)
        }
        Command::Localize(arguments) => localize::localize(&arguments),
        Command::Map(arguments) => map::run(&arguments),
        Command::Notions(arguments) => notions::notions(&arguments),
        Command::Card(arguments) => notions::card(&arguments),
        Command::List { topic, json } => list(topic.as_deref(), json),
        Command::Check {
            files,
            assignments,
            json,
            trust,
        } => check::check(&files, &assignments, &trust.trust(), json),
        Command::Audit(arguments) => audit::audit(&arguments),
        Command::UmatUtilities => print_text(onset_umat::UTILITIES.trim_end()),
        Command::Schema => check::schema(),
        Command::Boundary {
            file,
            assignments,
            flutter,
            out,
            json,
            trust,
        } => {
            let tracing = Tracing {
                flutter,
                fidelity: true,
                until: None,
            };
            let study = study(&file, &assignments, &trust.trust())?;
            boundary::boundary(&study, tracing, &out, json)
        }
        Command::Compare(arguments) => compare::compare(&arguments),
        Command::Modes(arguments) => modes::modes(&arguments),
        Command::Tune(arguments) => tune::tune(&arguments),
        Command::Recommend(arguments) => compare::recommend(&arguments),
        Command::Plot(arguments) => plot::plot(&arguments),
        Command::Reproduce { out, json } => reproduce(&out, json),
    }
}

/// What takes its time without a progress bar of its own.
fn waiting_for(command: &Command) -> Option<&'static str> {
    match command {
        Command::State { .. } => Some("searching the zone"),
        Command::Dispersion { .. } => Some("computing waves"),
        Command::Path { .. } => Some("following the path"),
        Command::Localize(_) => Some("following the loading"),
        Command::Notions(_) => Some("following loadings"),
        Command::Card(_) => Some("searching boxes of stretches"),
        Command::Audit(_) => Some("differentiating"),
        Command::Modes(_) => Some("searching the zone"),
        Command::Check { .. } => Some("looking at states"),
        _ => None,
    }
}

/// Name and text of a file; of standard input where the file is `-`.
pub fn source(file: &Path) -> Result<(String, String), Failure> {
    let (name, text) = match file == Path::new("-") {
        true => (
            "standard input".to_owned(),
            std::io::read_to_string(std::io::stdin()),
        ),
        false => (file.display().to_string(), std::fs::read_to_string(file)),
    };
    // A number in the place of a file is one of a list with a blank in it.
    let hint = match name.parse::<f64>() {
        Ok(_) => "\n  hint: numbers are written with commas between them, for example 1.2,0.9",
        Err(_) => "",
    };
    let text =
        text.map_err(|error| Failure::input(format!("cannot read {name}: {error}{hint}")))?;
    Ok((name, text))
}

/// Reads a study, changed by assignments, of which a library may be loaded if the user allows it.
pub fn study(file: &Path, assignments: &[String], trust: &Trust) -> Result<Study, Failure> {
    let (name, text) = source(file)?;
    let mut study = Study::parse(&name, &text)
        .and_then(|study| study.override_with(assignments))
        .map_err(Failure::input)?;
    study.settings.material = permitted(study.settings.material, trust)?;
    Ok(study)
}

impl TrustArguments {
    /// What the user allows, here and for good.
    pub fn trust(&self) -> Trust {
        Trust::of_user(&self.libraries)
    }
}

/// The law of a study file or of the defaults, changed by assignments, of which a library may be loaded if the user allows it.
fn law(
    file: Option<&Path>,
    assignments: &[String],
    trust: &Trust,
) -> Result<MaterialSettings, Failure> {
    let (name, text) = match file {
        Some(file) => source(file)?,
        None => Default::default(),
    };
    let law = MaterialSettings::of_file(&name, &text, assignments);
    permitted(law.map_err(Failure::input)?, trust)
}

/// A material of which the user allows what it loads.
fn permitted(mut material: MaterialSettings, trust: &Trust) -> Result<MaterialSettings, Failure> {
    material.allow(trust);
    material.permitted().map_err(Failure::input)?;
    Ok(material)
}

/// The assignments with those that `--energy` is short for; an error where `--set` says otherwise.
fn with_energy(assignments: &[String], energy: Option<&str>) -> Result<Vec<String>, Failure> {
    let Some(energy) = energy else {
        return Ok(assignments.to_vec());
    };
    let meant = [("material.model", "formula"), ("material.energy", energy)];
    for assignment in assignments {
        let (name, value) = assignment.split_once('=').unwrap_or((assignment, ""));
        let value = value.trim().trim_matches('"');
        let other = meant
            .iter()
            .find(|(key, meant)| *key == name.trim() && *meant != value);
        if let Some((key, meant)) = other {
            return Err(Failure::input(format!(
                "--energy and --set {assignment} name two laws: --energy sets {key}={meant}\n  hint: leave out one of them"
            )));
        }
    }
    let short_for = meant.map(|(key, value)| format!("{key}={value}"));
    Ok(assignments.iter().cloned().chain(short_for).collect())
}

impl ProblemArguments {
    fn build(&self) -> Result<Problem, Failure> {
        Ok(Problem::new(self.settings()?)?)
    }

    fn settings(&self) -> Result<Settings, Failure> {
        self.settings_with(&[])
    }

    /// The law alone.
    fn law(&self) -> Result<MaterialSettings, Failure> {
        let assignments = with_energy(&self.assignments, self.energy.as_deref())?;
        law(self.file.as_deref(), &assignments, &self.trust.trust())
    }

    /// The settings, where some keys are about to be varied.
    fn settings_with(&self, open: &[&str]) -> Result<Settings, Failure> {
        let assignments = with_energy(&self.assignments, self.energy.as_deref())?;
        let (name, text) = match &self.file {
            Some(file) => source(file)?,
            None => Default::default(),
        };
        let settings = Settings::of_file(&name, &text, &assignments, open);
        let mut settings = settings.map_err(Failure::input)?;
        settings.material = permitted(settings.material, &self.trust.trust())?;
        Ok(settings)
    }
}

impl StrainArguments {
    fn build(&self, problem: &Problem) -> Result<Strain, Failure> {
        let dimension = problem.dimension();
        match (&self.stretch, &self.deformation_gradient) {
            (Some(stretches), _) => Ok(Strain::of_stretches("--stretch", stretches, dimension)?),
            (None, Some(components)) => Ok(Strain::of_components(
                "--deformation-gradient",
                components,
                dimension,
            )?),
            (None, None) => Err(Failure::input("give --stretch or --deformation-gradient")),
        }
    }
}

fn diagram(
    problem: &Problem,
    strain: &Strain,
    path: Option<&str>,
    out: &Path,
    json: bool,
) -> Result<ExitCode, Failure> {
    let names = [
        "dispersion.svg",
        "dispersion.png",
        "dispersion.csv",
        "density-of-states.csv",
    ];
    let output = Output::at(out, &names)?;
    let diagram = Diagram::new(problem, strain, path)?;
    let mut files = diagram
        .figure("Waves in the particles and in the continuum")
        .files("dispersion")
        .map_err(Failure::machine)?;
    files.push(text("dispersion.csv", diagram.csv()));
    files.push(text("density-of-states.csv", diagram.density_csv()));
    let written = output.write(&files)?;
    if json {
        return print_json(&diagram);
    }
    print_text(&format!(
        "wrote {}\n\n{}",
        named(&written).join(", "),
        diagram.told()
    ))
}

/// The names of files, to be told.
fn named(files: &[PathBuf]) -> Vec<String> {
    files
        .iter()
        .map(|file| file.display().to_string())
        .collect()
}

fn list(topic: Option<&str>, json: bool) -> Result<ExitCode, Failure> {
    let unknown = |names: Vec<&str>| {
        let name = topic.unwrap_or_default();
        Failure::input(format!(
            "there is no topic `{name}`\n  hint: topics are {}",
            names.join(", ")
        ))
    };
    let topics = match topic {
        Some(name) => vec![catalog::topic(name).map_err(unknown)?],
        None => catalog::topics(),
    };
    if json {
        return print_json(&topics);
    }
    let text: Vec<String> = topics.iter().map(ToString::to_string).collect();
    print_text(&format!(
        "{}\n\nThe paper: {}",
        text.join("\n").trim_end(),
        catalog::PAPER
    ))
}

/// A bar for a number of named steps; hidden where nothing shall be shown.
fn progress(steps: usize, is_quiet: bool) -> ProgressBar {
    if is_quiet {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:32} {pos:>2}/{len} {msg} ({elapsed})");
    ProgressBar::new(steps as u64)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

fn reproduce(out: &Path, json: bool) -> Result<ExitCode, Failure> {
    let bar = progress(reproduce::STEPS, false);
    let report = reproduce::run(out, &|step| {
        bar.set_message(step.to_owned());
        bar.inc(1);
    })
    .map_err(Failure::machine)?;
    bar.finish_and_clear();
    let printed = if json {
        print_json(&report)?
    } else {
        print_text(&report.to_string())?
    };
    Ok(if report.is_as_recorded() {
        printed
    } else {
        ExitCode::from(1)
    })
}

fn print<T: Serialize + Display>(answer: &T, json: bool) -> Result<ExitCode, Failure> {
    if json {
        print_json(answer)
    } else {
        print_text(answer.to_string().trim_end())
    }
}

pub fn print_json<T: Serialize>(answer: &T) -> Result<ExitCode, Failure> {
    print_text(&json::document(answer).map_err(Failure::machine)?)
}

/// Tells the person at the terminal; that nobody listens (a closed pipe) is no failure.
pub fn tell(text: impl Display) {
    patience::end();
    // What a file says must not command the terminal.
    let _ = writeln!(std::io::stderr(), "{}", readable(&text.to_string()));
}

/// Prints a line; a reader that has closed the pipe (`| head`) is no error.
pub fn print_text(text: &str) -> Result<ExitCode, Failure> {
    patience::end();
    match writeln!(std::io::stdout(), "{}", readable(text)) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::machine(format!(
            "cannot print the answer: {error}"
        ))),
        _ => Ok(ExitCode::SUCCESS),
    }
}
