//! Zoo: instabilities that users of particle codes reported, with the settings that reproduce them.
//!
//! ```
//! let report = onset_study::zoo::report("trixi-371-cubic")?;
//! assert_eq!(report.verdict, "zero-energy");
//! # Ok::<(), onset_study::settings::SettingError>(())
//! ```

use crate::answers::{Problem, ProblemError, StateAnswer, Strain};
use crate::brief::{WIDTH, cut, wrapped};
use crate::csv::Table;
use crate::number::{counted, told, told_below};
use crate::settings::{Origin, SettingError, Settings, Units, did_you_mean, sections};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Published report of an instability, with the settings that reproduce it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all(deserialize = "kebab-case"))]
pub struct Report {
    /// Name of the report.
    #[serde(default)]
    pub name: String,
    /// Title of the report.
    pub title: String,
    /// Behavior described in the report.
    pub seen: String,
    /// Source of the report.
    #[serde(rename = "where")]
    pub place: String,
    /// Assumptions where the report gives no details.
    pub assumed: String,
    /// Kind of confirmation: by a run, by the linear theory only, or with a cause outside the theory.
    pub status: String,
    /// Verdict on the state of the report.
    pub verdict: String,
    /// Time step of the report, if it exceeds the critical time step.
    pub time_step: Option<f64>,
    /// Description of the known remedy.
    pub remedy: String,
    /// Verdict with the remedy, if the remedy can be expressed by settings.
    pub remedy_verdict: Option<String>,
    /// Arguments of `onset state` that reproduce the report.
    #[serde(skip_serializing)]
    question: Vec<String>,
    /// Arguments of `onset state` with the remedy.
    #[serde(skip_serializing)]
    remedy_question: Option<Vec<String>>,
}

/// State of a report: its stretches and settings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Case {
    /// Principal stretches, as for `--stretch`.
    pub stretch: String,
    /// Settings, as for `--set`.
    pub set: Vec<String>,
}

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("zoo/", $name)))),*]
    };
}

/// Names and texts of the files of the zoo.
const FILES: &[(&str, &str)] = files![
    "dualsphysics-452-law.toml",
    "dualsphysics-452.toml",
    "lammps-peri-soft.toml",
    "lammps-smd-tlsph-adjust-dt.toml",
    "lammps-smd-tlsph-zero-energy.toml",
    "lammps-smd-ulsph-gradient-correction.toml",
    "lammps-smd-ulsph-sound.toml",
    "lammps-smd-ulsph-tension.toml",
    "one-point-elements.toml",
    "peridox-5.toml",
    "physgaussian-20.toml",
    "physgaussian-33.toml",
    "pysph-tension.toml",
    "taichi-3162.toml",
    "taichi-8345.toml",
    "trixi-1233.toml",
    "trixi-371-cubic.toml",
    "trixi-371-wendland.toml",
];

/// Returns true for the text of a file of the zoo.
pub fn is_entry(text: &str) -> bool {
    toml::from_str::<Report>(text).is_ok()
}

/// Returns all reports, by name.
pub fn reports() -> Vec<Report> {
    let report = |(file, text): &(&str, &str)| {
        let report: Report = toml::from_str(text).ok()?;
        Some(Report {
            name: file.trim_end_matches(".toml").to_owned(),
            ..report
        })
    };
    FILES.iter().filter_map(report).collect()
}

/// Returns the report with the given name.
///
/// # Errors
/// [`SettingError`] for an unknown name.
pub fn report(name: &str) -> Result<Report, SettingError> {
    let all = reports();
    let meant = did_you_mean(name, all.iter().map(|report| report.name.as_str()));
    let mut own = all.into_iter().filter(|report| report.name == name);
    own.next().ok_or_else(|| {
        let message = format!("there is no report `{name}` in the zoo");
        SettingError::new(Origin::Combination, message)
            .hint(format!("`onset zoo` lists the names{meant}"))
    })
}

impl Case {
    /// Case with the arguments of `onset state`.
    fn of(arguments: &[String]) -> Self {
        let mut case = Self::default();
        for pair in arguments.chunks(2) {
            match pair {
                [option, value] if option == "--stretch" => case.stretch.clone_from(value),
                [option, value] if option == "--energy" => {
                    case.set.push("material.model=formula".to_owned());
                    case.set.push(format!("material.energy={value}"));
                }
                [_, value] => case.set.push(value.clone()),
                _ => {}
            }
        }
        case
    }

    fn answer(&self) -> Result<StateAnswer, ProblemError> {
        let problem = Problem::new(Settings::from_assignments(&self.set)?)?;
        let strain = Strain::of_stretches("--stretch", &self.stretch, problem.extent())?;
        StateAnswer::new(&problem, &strain)
    }
}

impl Report {
    /// State of the report.
    pub fn case(&self) -> Case {
        Case::of(&self.question)
    }

    /// State with the remedy, if the remedy can be expressed by settings.
    pub fn remedied(&self) -> Option<Case> {
        self.remedy_question.as_deref().map(Case::of)
    }

    /// Study with the settings of the report.
    pub fn study(&self) -> String {
        format!(
            "# {}\ntitle = {}\n\n{}",
            self.place,
            toml::Value::from(self.title.as_str()),
            sections(&self.case().set)
        )
    }

    /// Description of the settings that the remedy changes, and of the keys that it removes.
    fn changes(&self) -> Option<String> {
        let (own, remedied) = (self.case().set, self.remedied()?.set);
        let key = |assignment: &String| assignment.split('=').next().unwrap_or("").to_owned();
        let set = remedied.iter().filter(|other| !own.contains(other));
        let set = set.map(|assignment| format!("--set {assignment}"));
        let left = own.iter().map(key);
        let left = left.filter(|name| !remedied.iter().any(|other| key(other) == *name));
        let left = left.map(|name| format!("without {name}"));
        Some(set.chain(left).collect::<Vec<_>>().join(" "))
    }

    /// Answers for the state of the report, and for the state with the remedy.
    ///
    /// # Errors
    /// [`ProblemError`] when the state cannot be assessed.
    pub fn answer(self) -> Result<ReportAnswer, ProblemError> {
        let case = self.case();
        Ok(ReportAnswer {
            stretch: case.stretch.clone(),
            study: self.study(),
            answer: case.answer()?,
            remedy_answer: self.remedied().map(|case| case.answer()).transpose()?,
            report: self,
        })
    }
}

/// Answer of `onset zoo`: all reports.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Zoo {
    /// All reports, by name.
    pub reports: Vec<Report>,
}

impl Zoo {
    /// The reports as CSV, one row each.
    pub fn csv(&self) -> String {
        csv(&self.reports)
    }
}

/// Reports as CSV, one row each.
fn csv(reports: &[Report]) -> String {
    Table::new(reports, Units::Own)
        .with("report", "1", |own| own.name.as_str())
        .with("title", "1", |own| own.title.as_str())
        .with("where", "1", |own| own.place.as_str())
        .with("verdict", "1", |own| own.verdict.as_str())
        .with("status", "1", |own| own.status.as_str())
        .with("time_step", "1", |own| own.time_step)
        .with("remedy", "1", |own| own.remedy.as_str())
        .with("remedy_verdict", "1", |own| own.remedy_verdict.clone())
        .to_string()
}

impl Default for Zoo {
    fn default() -> Self {
        Self { reports: reports() }
    }
}

impl fmt::Display for Zoo {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.reports.iter().map(|report| report.name.len());
        let name = names.max().unwrap_or(0);
        let verdict = |report: &Report| match report.time_step {
            Some(_) => format!("{}, time step", report.verdict),
            None => report.verdict.clone(),
        };
        let verdicts = self.reports.iter().map(|report| verdict(report).len());
        let width = verdicts.max().unwrap_or(0);
        writeln!(
            formatter,
            "{:name$}  {:width$}  remedy",
            "report", "verdict"
        )?;
        for report in &self.reports {
            let room = WIDTH - name - width - 4;
            writeln!(
                formatter,
                "{:name$}  {:width$}  {}",
                report.name,
                verdict(report),
                cut(&report.remedy, room)
            )?;
        }
        write!(
            formatter,
            "\n{}; \"time step\" marks a step above the critical one. `onset zoo NAME` shows one.",
            counted(self.reports.len(), "report")
        )
    }
}

/// Answer of `onset zoo NAME`: a report with the answers for its state and its remedy.
#[derive(Clone, Debug, Serialize)]
pub struct ReportAnswer {
    /// Report as stored in the zoo.
    #[serde(flatten)]
    pub report: Report,
    /// Principal stretches of the state.
    pub stretch: String,
    /// Study with the settings of the report.
    pub study: String,
    /// Answer for the state of the report.
    pub answer: StateAnswer,
    /// Answer for the state with the remedy; `null` if settings do not express the remedy.
    pub remedy_answer: Option<StateAnswer>,
}

impl ReportAnswer {
    /// The report as CSV: a row of the table of all reports.
    pub fn csv(&self) -> String {
        csv(std::slice::from_ref(&self.report))
    }
}

impl fmt::Display for ReportAnswer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let report = &self.report;
        writeln!(formatter, "{}.\n", report.title)?;
        let mut rows = vec![
            ("reported", report.seen.clone()),
            ("source", report.place.clone()),
            ("assumed", report.assumed.clone()),
            ("status", report.status.clone()),
            ("onset", self.answer.sentence.clone()),
        ];
        let steps = report.time_step.map(|step| {
            let d = &self.answer.discretization;
            let alone = d
                .discrete_time
                .as_ref()
                .and_then(|own| own.isolated_point_time_step);
            let critical = [d.critical_time_step, alone].into_iter().flatten();
            let critical = critical.reduce(f64::min).map_or_else(String::new, |least| {
                format!("; the critical step is {}", told_below(least))
            });
            (
                "time step",
                format!("{} in the report{critical}", told(step)),
            )
        });
        rows.extend(steps);
        rows.push(("remedy", report.remedy.clone()));
        if let (Some(changes), Some(answer)) = (report.changes(), &self.remedy_answer) {
            rows.push(("change", changes));
            rows.push(("with it", answer.sentence.clone()));
        }
        for (name, text) in rows {
            let lines = wrapped(&format!("{name:<NAME$}{text}"), NAME);
            writeln!(formatter, "{}", lines.join("\n"))?;
        }
        write!(
            formatter,
            "\nThe study (--out FILE writes it; onset state FILE --stretch {}):\n\n{}",
            self.stretch,
            self.study.trim_end()
        )
    }
}

/// Width of the names of rows.
const NAME: usize = 12;

#[cfg(test)]
mod tests {
    use super::{FILES, Report, report, reports};
    use crate::answers::{Problem, StateAnswer, Strain};
    use crate::settings::Settings;

    #[test]
    fn the_zoo_contains_all_files_of_the_repository() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../zoo");
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .expect("the zoo")
            .filter_map(|file| file.ok()?.file_name().into_string().ok())
            .filter(|name| name.ends_with(".toml"))
            .collect();
        names.sort();
        let own: Vec<&str> = FILES.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, own, "src/zoo holds copies of the files of zoo");
        for (name, text) in FILES {
            let file = std::fs::read_to_string(format!("{folder}/{name}")).expect("a file");
            assert_eq!(file, *text, "{name} is another one in src/zoo");
        }
        assert_eq!(reports().len(), names.len());
    }

    #[test]
    fn the_study_of_a_report_has_its_settings() {
        for report in reports() {
            let case = report.case();
            let own = Settings::from_assignments(&case.set).expect("settings");
            let study = Settings::of_file("study", &report.study(), &[] as &[&str], &[]);
            let study = study.unwrap_or_else(|error| panic!("{}: {error}", report.name));
            assert_eq!(study.effective(), own.effective(), "{}", report.name);
        }
    }

    #[test]
    fn a_report_is_answered_like_its_state() {
        let known: Report = report("trixi-371-cubic").expect("a report");
        let case = known.case();
        let settings = Settings::from_assignments(&case.set).expect("settings");
        let problem = Problem::new(settings).expect("a problem");
        let strain = Strain::of_stretches("--stretch", &case.stretch, problem.extent());
        let own = StateAnswer::new(&problem, &strain.expect("a state")).expect("an answer");
        let told = known.answer().expect("an answer").to_string();
        let words = told.split_whitespace().collect::<Vec<_>>().join(" ");
        for fact in [
            own.sentence.as_str(),
            "change --set discretization.penalty=0.3",
            "[discretization]",
            "kernel = \"cubic-spline\"",
        ] {
            assert!(words.contains(fact), "{fact}: {told}");
        }
        let error = report("trixi-371").expect_err("no name").to_string();
        assert!(error.contains("`onset zoo` lists the names"), "{error}");
    }
}
