//! Zoo of the repository: instabilities reported for particle codes, with settings that reproduce them.

use super::Question;
use serde::{Deserialize, Serialize};

/// Published report of an instability, with the settings that reproduce it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Entry {
    /// Title of the report.
    pub title: String,
    /// Behavior described in the report.
    pub seen: String,
    /// Source of the report.
    #[serde(rename = "where")]
    pub place: String,
    /// Assumptions where the report gives no details.
    pub assumed: String,
    /// Arguments of `onset state` that reproduce the report.
    pub question: Question,
    /// Known remedy; `None` if no remedy is known.
    pub remedy: Option<String>,
    /// Arguments of `onset state` with the remedy; `None` without a known remedy.
    pub remedy_question: Option<Question>,
}

/// File of the zoo, limited to the displayed keys.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
struct Written {
    title: String,
    seen: String,
    #[serde(rename = "where")]
    place: String,
    #[serde(default)]
    assumed: String,
    question: Vec<String>,
    remedy: Option<String>,
    remedy_question: Option<Vec<String>>,
}

macro_rules! files {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("zoo/", $name)))),*]
    };
}

/// Names and texts of the files of the zoo.
pub(super) const FILES: &[(&str, &str)] = files![
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

/// Entries about states of principal stretches, which a page can show.
pub fn entries() -> Vec<Entry> {
    FILES.iter().filter_map(|(_, text)| entry(text)).collect()
}

fn entry(text: &str) -> Option<Entry> {
    let written: Written = toml::from_str(text).ok()?;
    Some(Entry {
        title: written.title,
        seen: written.seen,
        place: written.place,
        assumed: written.assumed,
        question: question(&written.question)?,
        remedy: written.remedy,
        remedy_question: written.remedy_question.as_deref().and_then(question),
    })
}

/// Question with the arguments of `onset state`; `None` if they are not stretches and assignments only.
fn question(arguments: &[String]) -> Option<Question> {
    let mut question = Question::default();
    for pair in arguments.chunks(2) {
        match pair {
            [option, value] if option == "--set" => question.set.push(value.clone()),
            [option, value] if option == "--stretch" => question.stretch.clone_from(value),
            [option, value] if option == "--energy" => {
                question.set.push("material.model=formula".to_owned());
                question.set.push(format!("material.energy={value}"));
            }
            _ => return None,
        }
    }
    (!question.stretch.is_empty()).then_some(question)
}
