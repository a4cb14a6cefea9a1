//! Execution of the commands: compute and print an answer.

mod audit;
mod boundary;
mod check;
mod compare;
mod criteria;
#[cfg(feature = "explore")]
mod explore;
mod fit;
mod limit;
mod localize;
mod modes;
mod plot;
mod screen;
mod simulate;
mod tune;
mod verify;
mod zoo;

use crate::arguments::{
    Arguments, BlockArguments, Command, CourseArguments, DetailArguments, GivenArguments,
    ProblemArguments, SetArguments, StrainArguments, ThresholdArguments, TrustArguments,
    VerifyTask,
};
use crate::drawing::DrawingArguments;
use crate::fail_on::FailOn;
use crate::patience::{self, bar};
use crate::printing::{self, Format, print_text};
use crate::{help, map};
use indicatif::ProgressBar;
use onset_study::Verdict;
use onset_study::answers::{
    Course, Diagram, PathAnswer, PathSamples, Problem, ProblemError, StateAnswer, StateQuestion,
    Strain, Waves,
};
use onset_study::boundary::Tracing;
use onset_study::catalog::{self, KeyList};
use onset_study::compare::Thresholds;
use onset_study::criteria::{Lateral, Mode};
use onset_study::figure::Sheet;
use onset_study::input;
use onset_study::kernels;
use onset_study::output::{Files, Output, OutputError, picture};
use onset_study::reproduce;
use onset_study::settings::{
    MaterialSettings, Program, Reading, SettingError, Settings, Study, Trust, did_you_mean,
    is_preset, law_of, preset_names,
};
use onset_study::zoo::is_entry;
use std::fmt::Display;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Reason why a command ended without an answer.
pub struct Failure {
    /// Message for the user.
    pub message: String,
    /// Exit code of the process.
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

/// Runs the command of the arguments.
pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    if let Some(doing) = waiting_for(&arguments.command).filter(|_| !printing::is_quiet()) {
        patience::begin(doing);
    }
    match arguments.command {
        Command::State {
            problem,
            strain,
            certify,
            tolerance,
            weak,
            detail,
            failing,
            #[cfg(feature = "explore")]
            open,
        } => {
            #[cfg(feature = "explore")]
            if open {
                return explore::at_state(&problem, &strain);
            }
            let problem = problem.build()?;
            let strain = strain.build(&problem)?;
            let question = StateQuestion {
                certified: certify.then_some(tolerance),
                weak: weak.share,
            };
            let found = StateAnswer::asked(&problem, &strain, &question);
            let answer = match (found, &failing.fail_on) {
                (Err(error), Some(fail_on)) if fail_on.has_undefined() => {
                    printing::tell(format_args!("error: {}", Failure::from(error).message));
                    return Ok(fail_on.code([(None, 1)]));
                }
                (found, _) => found?,
            };
            let printed = printing::print(&answer, &detail.text(&answer), || answer.csv())?;
            Ok(match failing.fail_on {
                Some(fail_on) => fail_on.code([(Some(answer.verdict.name()), 1)]),
                None => printed,
            })
        }
        Command::Dispersion {
            problem,
            strain,
            wave_vector,
            path,
            out,
            weak,
            drawing,
        } => {
            let output = drawing.output(
                out.as_deref(),
                "dispersion",
                &["dispersion.csv", "density-of-states.csv"],
            )?;
            let problem = problem.build()?;
            let strain = match strain.is_given() {
                true => strain.build(&problem)?,
                false => Strain::reference(),
            };
            match wave_vector {
                Some(_) if weak.share != Thresholds::default().weak => Err(Failure::input(
                    "--weak has no effect: it marks waves in the diagram\n  hint: draw the diagram with --path",
                )),
                Some(wave_vector) => {
                    let waves = Waves::new(&problem, &strain, &wave_vector)?;
                    printing::print(&waves, waves.to_string().trim_end(), || waves.csv())
                }
                None => {
                    let path = path.flatten();
                    diagram(&problem, &strain, path.as_deref(), weak.share, output)
                }
            }
        }
        Command::Path {
            given,
            course: asked,
            out,
            drawing,
            failing,
            detail,
        } => {
            let output = drawing.output(out.as_deref(), "path", &["path.csv"])?;
            let block = asked.block();
            let problem = ProblemArguments { given, block }.build()?;
            let course = course(&asked, &problem)?;
            path(&problem, &course, output, failing.fail_on.as_ref(), detail)
        }
        #[cfg(feature = "explore")]
        Command::Explore(arguments) => explore::explore(&arguments),
        Command::Localize(arguments) => localize::localize(&arguments),
        Command::Map(arguments) => map::run(&arguments),
        Command::Criteria(arguments) => criteria::criteria(&arguments),
        Command::Card(arguments) => criteria::card(&arguments),
        Command::List {
            topic,
            name,
            out,
            drawing,
        } => list(topic.as_deref(), name.as_deref(), out.as_deref(), &drawing),
        Command::Check {
            files,
            assignments,
            block,
            trust,
        } => check::check(&files, &assignments, &block, &trust.trust()),
        Command::Audit(arguments) => audit::audit(&arguments),
        Command::UmatUtilities => {
            printing::only_text("Fortran")?;
            print_text(onset_umat::UTILITIES.trim_end())
        }
        Command::LawHeader => {
            printing::only_text("C")?;
            print_text(onset_umat::LAW_HEADER.trim_end())
        }
        Command::Completions { shell } => help::completions(shell),
        Command::Man { out } => help::manual(&out),
        Command::Schema => check::schema(),
        Command::Boundary {
            file,
            assignments,
            flutter,
            out,
            block,
            trust,
        } => {
            let tracing = Tracing {
                flutter,
                fidelity: true,
            };
            let study = study(&file, &assignments, block.from, &trust.trust())?;
            boundary::boundary(&study, tracing, out.as_deref())
        }
        Command::Compare(arguments) => compare::compare(&arguments),
        Command::Modes(arguments) => modes::modes(&arguments),
        Command::Tune(arguments) => tune::tune(&arguments),
        Command::Limit(arguments) => limit::limit(&arguments),
        Command::Recommend(arguments) => compare::recommend(&arguments),
        Command::Plot(arguments) => plot::plot(&arguments),
        Command::Verify { task } => verify::verify(&task),
        Command::Screen(arguments) => screen::screen(&arguments),
        Command::Fit(arguments) => fit::fit(&arguments),
        Command::Simulate(arguments) => simulate::simulate(&arguments),
        Command::Zoo(arguments) => zoo::zoo(&arguments),
        Command::Reproduce { out, look } => reproduce(&out, look.sheet()),
    }
}

/// Activity shown during a long computation; `None` for commands with a progress bar.
fn waiting_for(command: &Command) -> Option<&'static str> {
    match command {
        #[cfg(feature = "explore")]
        Command::State { open: true, .. } => None,
        Command::State { .. } => Some("searching the zone"),
        Command::Dispersion { .. } => Some("computing waves"),
        Command::Path { .. } => Some("following the path"),
        Command::Map(_) => Some("preparing the map"),
        Command::Localize(_) => Some("following the loading"),
        Command::Criteria(_) => Some("following loadings"),
        Command::Zoo(_) => Some("searching the zone"),
        Command::Card(_) => Some("searching boxes of stretches"),
        Command::Audit(_) => Some("differentiating"),
        Command::Modes(_) => Some("searching the zone"),
        Command::Screen(_) => Some("reading the frames"),
        Command::Fit(_) => Some("reading the tests"),
        Command::Simulate(_) => Some("setting up the motion"),
        Command::Check { .. } => Some("looking at states"),
        Command::Verify {
            task: VerifyTask::Deck(_),
        } => Some("computing waves"),
        Command::Verify {
            task: VerifyTask::Run { .. },
        } => Some("running the deck"),
        Command::Verify {
            task: VerifyTask::Read { .. },
        } => Some("reading the output"),
        _ => None,
    }
}

/// Name and text of a file, or of standard input for `-`.
pub fn source(file: &Path) -> Result<(String, String), Failure> {
    if file == Path::new("-") {
        let name = "standard input".to_owned();
        let text = input::bounded(std::io::stdin(), input::MOST_TEXT).and_then(input::decoded);
        let text = text.map_err(|error| unreadable(&name, error))?;
        return match text.trim().is_empty() {
            true => Err(Failure::input(
                "standard input is empty\n  hint: expected a study; omit - for the defaults",
            )),
            false => Ok((name, text)),
        };
    }
    let name = file.display().to_string();
    match input::text(file, input::MOST_TEXT) {
        Ok(text) => Ok((name, text)),
        Err(error) => Err(unreadable(&name, error)),
    }
}

/// Error for an unreadable study, with a hint at a likely mistake.
fn unreadable(name: &str, error: std::io::Error) -> Failure {
    let hint = if name.parse::<f64>().is_ok() {
        // A number in place of a file is probably the rest of a list that was typed with a blank.
        "numbers are written with commas between them, for example 1.2,0.9"
    } else if name.contains('=') {
        "a key is set by --set KEY=VALUE"
    } else if error.kind() == ErrorKind::InvalidData {
        "expected a study of several lines; standard input is read with -"
    } else if error.kind() == ErrorKind::IsADirectory {
        "expected a study file; `onset plot` draws stores"
    } else {
        "expected a study file, or - for standard input"
    };
    Failure::input(format!("cannot read {name}: {error}\n  hint: {hint}"))
}

/// Reads a study and applies assignments; a library is loaded only if the user allows it.
pub fn study(
    file: &Path,
    assignments: &[String],
    from: Option<Program>,
    trust: &Trust,
) -> Result<Study, Failure> {
    let (name, text) = source(file)?;
    let block = BlockArguments {
        from,
        material: None,
    };
    if let Some((program, law)) = law_of_deck(&name, &text, &block, assignments)? {
        return Err(without_axes(&name, program, &law));
    }
    let mut study = Study::parse(&name, &text)
        .and_then(|study| study.override_with(assignments))
        .map_err(|error| not_a_study(&name, &text, error))?;
    study.settings.material = permitted(study.settings.material, trust)?;
    Ok(study)
}

/// Error for a deck in place of a study with axes: the study to write.
fn without_axes(name: &str, program: Program, law: &Reading) -> Failure {
    let axis = |number: usize| {
        format!("[[axes]]\nquantity = \"stretch-{number}\"\nrange = [0.5, 2.0]\nstates = 64\n")
    };
    let study = [law.section(), axis(1), axis(2)].join("\n");
    let study: Vec<String> = study
        .lines()
        .map(|line| match line {
            "" => String::new(),
            line => format!("    {line}"),
        })
        .collect();
    Failure::input(format!(
        "{name} is {}, which has a law and no axes; this command needs a study with [[axes]]\n  hint: write a study, for example\n\n{}",
        program.deck(),
        study.join("\n")
    ))
}

/// Law of a deck in place of a study, with the program of the deck; `None` for a study.
fn law_of_deck(
    name: &str,
    text: &str,
    block: &BlockArguments,
    assignments: &[String],
) -> Result<Option<(Program, Reading)>, Failure> {
    let wanted = block.material.as_deref();
    match (block.from.or_else(|| Program::of_deck(text)), wanted) {
        (Some(program), _) => {
            let read = law_of(program, name, text, wanted, assignments);
            Ok(Some((program, read.map_err(Failure::input)?)))
        }
        (None, Some(_)) => Err(Failure::input(format!(
            "--material has no effect: {name} is not recognized as a deck of another program\n  hint: omit --material, or name the program of the deck, for example --from abaqus (in `onset path`, --read-as abaqus)"
        ))),
        (None, None) => Ok(None),
    }
}

/// Error in a study, or the command for an entry of the zoo, whose file is not a study.
fn not_a_study(name: &str, text: &str, error: SettingError) -> Failure {
    let stem = Path::new(name).file_stem().and_then(|stem| stem.to_str());
    match stem.filter(|_| is_entry(text)) {
        Some(stem) => Failure::input(format!(
            "{name} is an entry of the zoo, not a study\n  hint: `onset zoo {stem}` shows its answer, and --out FILE writes its study"
        )),
        None => Failure::input(error),
    }
}

/// Input of a file and assignments: the text of a study, or the assignments that represent a deck of another program.
struct Read {
    name: String,
    text: String,
    assignments: Vec<String>,
    is_deck: bool,
    /// Notes on the deck, and the name of its law.
    notes: Vec<String>,
    title: Option<String>,
}

impl Read {
    /// Reads a file and applies assignments.
    fn of(
        file: Option<&Path>,
        block: &BlockArguments,
        assignments: Vec<String>,
    ) -> Result<Self, Failure> {
        let (name, text) = file.map_or_else(|| Ok(Default::default()), source)?;
        Self::of_text(name, text, block, assignments)
    }

    /// Reads the text of a file and applies assignments.
    fn of_text(
        name: String,
        text: String,
        block: &BlockArguments,
        mut assignments: Vec<String>,
    ) -> Result<Self, Failure> {
        let Some((_, read)) = law_of_deck(&name, &text, block, &assignments)? else {
            return Ok(Self {
                name,
                text,
                assignments,
                is_deck: false,
                notes: Vec::new(),
                title: None,
            });
        };
        assignments.splice(0..0, read.assignments);
        Ok(Self {
            name: String::new(),
            text: String::new(),
            assignments,
            is_deck: true,
            notes: read.notes,
            title: read.name,
        })
    }

    /// Error in the study.
    fn failure(&self, error: SettingError) -> Failure {
        not_a_study(&self.name, &self.text, error)
    }

    /// Settings in which the keys `open` will be varied.
    fn settings(self, open: &[&str], trust: &Trust) -> Result<Settings, Failure> {
        let settings = Settings::of_file(&self.name, &self.text, &self.assignments, open);
        let mut settings = settings.map_err(|error| self.failure(error))?;
        settings.material = self.law(settings.material, trust)?;
        Ok(settings)
    }

    /// Material settings with the notes on the block, if the user allows its library.
    fn law(self, material: MaterialSettings, trust: &Trust) -> Result<MaterialSettings, Failure> {
        permitted(material.read_with(self.notes, self.title), trust)
    }
}

impl ThresholdArguments {
    /// Limits with the given values, or the defaults where no value is given.
    fn thresholds(self) -> Thresholds {
        Thresholds {
            weak: self.weak.share,
            wrong: self.wrong,
            ..Thresholds::default()
        }
    }
}

impl TrustArguments {
    /// Trust of the user, for this command and permanently.
    pub fn trust(&self) -> Trust {
        Trust::of_user(&self.libraries)
    }
}

/// Material settings whose library the user allows.
fn permitted(mut material: MaterialSettings, trust: &Trust) -> Result<MaterialSettings, Failure> {
    material.allow(trust);
    material.permitted().map_err(Failure::input)?;
    Ok(material)
}

/// Assignments including those implied by `--energy`; an error if `--set` contradicts them.
fn with_energy(assignments: &[String], energy: Option<&str>) -> Result<Vec<String>, Failure> {
    let Some(energy) = energy else {
        return Ok(assignments.to_vec());
    };
    let meant = [("material.model", "formula"), ("material.energy", energy)];
    for (key, meant) in meant {
        if let Some(assignment) = another(assignments, key, meant) {
            return Err(Failure::input(format!(
                "--energy and --set {assignment} name two laws: --energy sets {key}={meant}\n  hint: omit one of them"
            )));
        }
    }
    let short_for = meant.map(|(key, value)| format!("{key}={value}"));
    Ok(assignments.iter().cloned().chain(short_for).collect())
}

impl SetArguments {
    /// All assignments, those implied by `--preset` and `--energy` included; an error if `--set` contradicts them.
    fn all(&self) -> Result<Vec<String>, Failure> {
        let mut assignments = with_energy(&self.assignments, self.energy.as_deref())?;
        if let Some(preset) = &self.preset {
            if !is_preset(preset) {
                let known: Vec<&str> = preset_names().collect();
                return Err(Failure::input(format!(
                    "--preset {preset}: unknown code\n  hint: expected {} (onset list presets)",
                    known.join(", ")
                )));
            }
            let key = "discretization.method";
            if let Some(assignment) = another(&assignments, key, preset) {
                return Err(Failure::input(format!(
                    "--preset and --set {assignment} name two methods: --preset sets {key}={preset}\n  hint: omit one of them"
                )));
            }
            assignments.insert(0, format!("{key}={preset}"));
        }
        Ok(assignments)
    }
}

/// First assignment that gives a key a different value.
fn another<'a>(assignments: &'a [String], key: &str, meant: &str) -> Option<&'a String> {
    assignments.iter().find(|assignment| {
        let (name, value) = assignment.split_once('=').unwrap_or((assignment, ""));
        name.trim() == key && value.trim().trim_matches('"') != meant
    })
}

impl ProblemArguments {
    fn build(&self) -> Result<Problem, Failure> {
        Ok(Problem::new(self.settings()?)?)
    }

    fn settings(&self) -> Result<Settings, Failure> {
        self.settings_with(&[])
    }

    /// Study or block, with assignments applied.
    fn read(&self) -> Result<Read, Failure> {
        let GivenArguments { file, set, .. } = &self.given;
        Read::of(file.as_deref(), &self.block, set.all()?)
    }

    /// Settings of a material without a method.
    fn law(&self) -> Result<MaterialSettings, Failure> {
        let read = self.read()?;
        let law = MaterialSettings::of_file(&read.name, &read.text, &read.assignments);
        let law = law.map_err(|error| read.failure(error))?;
        let law = read.law(law, &self.given.trust.trust())?;
        law.check_parameters().map_err(Failure::input)?;
        Ok(law)
    }

    /// Settings in which the keys `open` will be varied.
    fn settings_with(&self, open: &[&str]) -> Result<Settings, Failure> {
        self.read()?.settings(open, &self.given.trust.trust())
    }
}

impl StrainArguments {
    fn is_given(&self) -> bool {
        self.stretch.is_some() || self.deformation_gradient.is_some()
    }

    fn build(&self, problem: &Problem) -> Result<Strain, Failure> {
        let extent = problem.extent();
        match (&self.stretch, &self.deformation_gradient) {
            (Some(stretches), _) => Ok(Strain::of_stretches("--stretch", stretches, extent)?),
            (None, Some(components)) => Ok(Strain::of_components(
                "--deformation-gradient",
                components,
                extent,
            )?),
            (None, None) => Err(Failure::input(
                "no state is given: expected --stretch or --deformation-gradient\n  hint: for example --stretch 1.2,0.9",
            )),
        }
    }
}

fn diagram(
    problem: &Problem,
    strain: &Strain,
    path: Option<&str>,
    weak: f64,
    output: Option<Output>,
) -> Result<ExitCode, Failure> {
    let diagram = Diagram::new(problem, strain, path)?.weak_below(weak);
    let written = match output {
        Some(output) => output.write(&diagram.files())?,
        None => Vec::new(),
    };
    let told = format!("{}{}", wrote_before(&written), diagram.told());
    printing::print(&diagram, told.trim_end(), || diagram.csv())
}

/// Prepends a paragraph that lists the written files to a text.
fn wrote_before(files: &[PathBuf]) -> String {
    match files {
        [] => String::new(),
        files => format!("{}\n\n", wrote(files)),
    }
}

/// Sentence that lists the written files: all of them if they are few, otherwise the first and the last.
pub fn wrote(files: &[PathBuf]) -> String {
    match &named(files)[..] {
        [] => String::new(),
        [only] => format!("wrote {only}"),
        [first, second] => format!("wrote {first} and {second}"),
        [first, .., last] if files.len() > 6 => {
            format!("wrote {} files, {first} to {last}", files.len())
        }
        [others @ .., last] => format!("wrote {} and {last}", others.join(", ")),
    }
}

/// Text followed by the files written.
fn with_files(answer: &impl Display, files: &[PathBuf]) -> String {
    let told = answer.to_string();
    match files {
        [] => told.trim_end().to_owned(),
        files => format!("{}\n\n{}", told.trim_end(), wrote(files)),
    }
}

/// Writes the files of an answer if requested, then prints the answer, or its table.
fn print_with_files(
    answer: &impl serde::Serialize,
    answer_text: &str,
    output: Option<Output>,
    files: impl FnOnce() -> Result<Files, Failure>,
    csv: impl FnOnce() -> String,
) -> Result<ExitCode, Failure> {
    let written = match output {
        Some(output) => output.write(&files()?)?,
        None => Vec::new(),
    };
    printing::print(answer, &with_files(&answer_text, &written), csv)
}

impl CourseArguments {
    /// Deck of another program in place of a study.
    fn block(&self) -> BlockArguments {
        BlockArguments {
            from: self.read_as,
            material: self.material.clone(),
        }
    }
}

/// Loading path of the arguments.
fn course(arguments: &CourseArguments, problem: &Problem) -> Result<Course, Failure> {
    let extent = problem.extent();
    let from = arguments.from.as_deref();
    if let Some(program) = from.filter(|from| from.parse::<Program>().is_ok()) {
        return Err(Failure::input(format!(
            "--from {program}: in `onset path`, --from is the start of the path\n  hint: a deck is recognized; to name its program, write --read-as {program}"
        )));
    }
    let Some(mode) = arguments.mode else {
        let from = Strain::of_either("--from", from.unwrap_or_default(), extent)?;
        let to = Strain::of_either("--to", &arguments.to, extent)?;
        return Ok(Course::Straight(from, to));
    };
    let (start, example) = match mode {
        Mode::SimpleShear => ("0", "0.5"),
        _ => ("1", "2"),
    };
    let imposed = |name: &str, text: &str| {
        let number = text.trim().parse::<f64>().ok();
        let admitted = |x: &f64| x.is_finite() && mode.parameter(*x).is_finite();
        number.filter(admitted).ok_or_else(|| {
            let expected = match mode {
                Mode::SimpleShear => "one number, the amount of shear gamma",
                _ => "one imposed stretch, a positive number",
            };
            Failure::input(format!(
                "{name} is `{text}`; with --mode {0} expected {expected}\n  hint: for example --mode {0} --to {example}",
                mode.name()
            ))
        })
    };
    let from = imposed("--from", from.unwrap_or(start))?;
    let to = imposed("--to", &arguments.to)?;
    Course::of_mode(mode, arguments.lateral, from, to).map_err(|known| {
        let asked = arguments.lateral.map_or("", Lateral::name);
        Failure::input(format!(
            "--lateral {asked} is not supported with {} loading\n  hint: supported: {known}",
            mode.name()
        ))
    })
}

fn path(
    problem: &Problem,
    course: &Course,
    output: Option<Output>,
    fail_on: Option<&FailOn>,
    detail: DetailArguments,
) -> Result<ExitCode, Failure> {
    let answer = PathAnswer::along(problem, course)?;
    let is_table = printing::format() == Format::Csv;
    // States next to the onsets are evaluated only if they are used.
    let samples = match output.is_some() || fail_on.is_some() || is_table {
        true => Some(PathSamples::new(problem, course)?),
        false => None,
    };
    let mut written = Vec::new();
    if let (Some(output), Some(samples)) = (output, &samples) {
        written = output.write(&samples.files(&answer))?;
    }
    let table = || samples.as_ref().map(PathSamples::csv).unwrap_or_default();
    let text = with_files(&detail.text(&answer), &written);
    let printed = printing::print(&answer, &text, table)?;
    Ok(match (fail_on, &samples) {
        (Some(fail_on), Some(samples)) => {
            let states = samples.samples.iter();
            fail_on.code(states.map(|sample| (sample.verdict().map(Verdict::name), 1)))
        }
        _ => printed,
    })
}

/// Names of files for display.
fn named(files: &[PathBuf]) -> Vec<String> {
    files
        .iter()
        .map(|file| file.display().to_string())
        .collect()
}

/// Prints topics, and draws the figure of the kernels to the path `out`.
fn list(
    topic: Option<&str>,
    name: Option<&str>,
    out: Option<&Path>,
    drawing: &DrawingArguments,
) -> Result<ExitCode, Failure> {
    if let Some(topic) = topic.filter(|topic| out.is_some() && *topic != "kernels") {
        return Err(Failure::input(format!(
            "`onset list {topic}` has no figure\n  hint: `onset list kernels --out FOLDER` draws all kernels"
        )));
    }
    let unknown = |names: Vec<&str>| {
        let name = topic.unwrap_or_default();
        Failure::input(format!(
            "there is no topic `{name}`\n  hint: the topics are {}, keys{}",
            names.join(", "),
            did_you_mean(name, names.iter().copied().chain(["keys"]))
        ))
    };
    if let Some((keys, method)) = topic.and_then(|topic| keys_of(topic, name)) {
        let keys =
            keys.map_err(|error| Failure::input(format!("{error}{}", of_methods(method))))?;
        return printing::print(&keys, keys.to_string().trim_end(), || keys.csv());
    }
    if let (Some(topic), Some(name)) = (topic, name) {
        return Err(Failure::input(format!(
            "`onset list {topic}` takes no name such as `{name}`\n  hint: `onset list method NAME` lists the keys that a method reads"
        )));
    }
    let topics = match topic {
        Some(name) => vec![catalog::topic(name).map_err(unknown)?],
        None => catalog::topics(),
    };
    let text: Vec<String> = topics.iter().map(ToString::to_string).collect();
    let text = format!(
        "{}\n\nThe paper: {}",
        text.join("\n").trim_end(),
        catalog::PAPER
    );
    let output = drawing.output(out, "kernels", &[])?;
    let gallery = || Ok(vec![picture("kernels", kernels::gallery())]);
    print_with_files(&topics, &text, output, gallery, || catalog::csv(&topics))
}

/// List of keys for a topic, and whether it lists the keys of a method.
fn keys_of(topic: &str, name: Option<&str>) -> Option<(Result<KeyList, SettingError>, bool)> {
    match (topic, name) {
        ("keys", None) => Some((Ok(KeyList::all()), false)),
        ("method" | "methods", Some(name)) => Some((KeyList::of_method(name), true)),
        _ => None,
    }
}

fn of_methods(method: bool) -> &'static str {
    match method {
        true => "\n  `onset list methods` describes them",
        false => "",
    }
}

/// Progress bar for a number of named steps; hidden if output is quiet.
fn progress(steps: usize, what: &'static str) -> ProgressBar {
    let bar = bar(
        steps as u64,
        "{bar:32} {pos:>2}/{len} {prefix} {msg} ({elapsed})",
    );
    bar.set_prefix(what);
    bar
}

fn reproduce(out: &Path, sheet: Sheet) -> Result<ExitCode, Failure> {
    let bar = progress(reproduce::STEP_COUNT, "steps:");
    let report = reproduce::run(out, sheet, &|step| {
        bar.set_message(step.to_owned());
        bar.inc(1);
    })
    .map_err(Failure::machine)?;
    bar.finish_and_clear();
    let printed = printing::print(&report, &report.to_string(), || report.csv())?;
    Ok(if report.is_as_recorded() {
        printed
    } else {
        ExitCode::from(1)
    })
}
