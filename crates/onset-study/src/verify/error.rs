//! What is wrong with a case, a deck or an output.

use super::fit::FitError;
use crate::answers::ProblemError;
use crate::settings::{SettingError, did_you_mean};
use onset::kinematics::KinematicsError;
use onset::method::MethodError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a code cannot be verified. Always the input's fault, and said so.
#[derive(Debug, Error)]
pub enum VerifyError {
    /// The study.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// What a code cannot compute.
    #[error("{code}: {what}\n  hint: {hint}")]
    Refused {
        /// The code.
        code: &'static str,
        /// What it cannot.
        what: String,
        /// What to do.
        hint: String,
    },
    /// A code that nobody knows.
    #[error("no code is called `{name}`\n  hint: available are {}{}", known.join(", "), did_you_mean(name, known.iter().copied()))]
    Unknown {
        /// What was typed.
        name: String,
        /// The codes.
        known: Vec<&'static str>,
    },
    /// The wave that is asked for.
    #[error("{what}\n  hint: {hint}")]
    Wave {
        /// What is wrong with it.
        what: String,
        /// What to do.
        hint: String,
    },
    /// A file that cannot be read.
    #[error("cannot read {}: {source}{}", path.display(), hint_of_reading(path))]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// A case file that is none, or was changed.
    #[error("{}: {what}\n  hint: write the deck again with `onset verify deck`", path.display())]
    Case {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// An output that is not one of this case.
    #[error("{}{}: {what}\n  hint: {hint}", path.display(), line_number(*line))]
    Output {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1; 0 for the whole file.
        line: usize,
        /// What is wrong.
        what: String,
        /// What to do.
        hint: &'static str,
    },
    /// A record in which no wave can be fitted.
    #[error("{}: {source}", path.display())]
    Fit {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: FitError,
    },
    /// A program that cannot be started.
    #[error("cannot start `{program}`: {source}\n  hint: {hint}")]
    NotInstalled {
        /// The program.
        program: String,
        /// What the operating system says.
        source: std::io::Error,
        /// How it is installed.
        hint: &'static str,
    },
    /// A program that ended with an error.
    #[error("`{program}` ended with {status}; its last lines are\n{tail}\n  hint: all that it printed is in {}", log.display())]
    Failed {
        /// The program.
        program: String,
        /// How it ended.
        status: String,
        /// The end of what it printed.
        tail: String,
        /// All of it.
        log: PathBuf,
    },
}

impl From<SettingError> for VerifyError {
    fn from(error: SettingError) -> Self {
        Self::Problem(error.into())
    }
}

impl From<MethodError> for VerifyError {
    fn from(error: MethodError) -> Self {
        Self::Problem(error.into())
    }
}

impl From<KinematicsError> for VerifyError {
    fn from(error: KinematicsError) -> Self {
        Self::Problem(error.into())
    }
}

fn line_number(line: usize) -> String {
    match line {
        0 => String::new(),
        line => format!(":{line}"),
    }
}

fn hint_of_reading(path: &Path) -> &'static str {
    match path.ends_with(super::CASE_FILE) {
        true => {
            "\n  hint: an output is read beside the case.json of its deck; name another place with --case"
        }
        false => "",
    }
}
