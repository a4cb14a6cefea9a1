//! Errors in a case, a deck or an output.

use super::fit::FitError;
use crate::answers::ProblemError;
use crate::settings::{SettingError, did_you_mean};
use onset::kinematics::KinematicsError;
use onset::method::MethodError;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Reason why a code cannot be verified. All reasons are errors in the input.
#[derive(Debug, Error)]
pub enum VerifyError {
    /// Error in the study.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// Request beyond the capabilities of the code.
    #[error("{code}: {what}\n  hint: {hint}")]
    Refused {
        /// Name of the code.
        code: &'static str,
        /// Unsupported request, as a sentence.
        what: String,
        /// Remedy for the user.
        hint: String,
    },
    /// Unknown name of a code.
    #[error("no code is called `{name}`\n  hint: available: {}{}", known.join(", "), did_you_mean(name, known.iter().copied()))]
    Unknown {
        /// Name as typed by the user.
        name: String,
        /// Names of the known codes.
        known: Vec<&'static str>,
    },
    /// Wave that cannot be measured, or does not fit the block.
    #[error("{what}\n  hint: {hint}")]
    Wave {
        /// Error in the wave, as a sentence.
        what: String,
        /// Remedy for the user.
        hint: String,
    },
    /// File that cannot be read.
    #[error("cannot read {}: {source}{}", path.display(), hint_of_reading(path))]
    Unreadable {
        /// Path of the unreadable file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// File that is not a case file, or that was changed after it was written.
    #[error("{}: {what}\n  hint: write the deck again with `onset verify deck`", path.display())]
    Case {
        /// Path of the case file.
        path: PathBuf,
        /// Error in the file, as a sentence.
        what: String,
    },
    /// Output that does not belong to this case.
    #[error("{}{}: {what}\n  hint: {hint}", path.display(), line_number(*line))]
    Output {
        /// Path of the output.
        path: PathBuf,
        /// Line number from 1, or 0 for the whole file.
        line: usize,
        /// Error in the output, as a sentence.
        what: String,
        /// Remedy for the user.
        hint: &'static str,
    },
    /// Record in which no wave can be fitted.
    #[error("{}: {source}", path.display())]
    Fit {
        /// Path of the output.
        path: PathBuf,
        /// Reason why the fit fails.
        source: FitError,
    },
    /// Program that cannot be started.
    #[error("cannot start `{program}`: {source}\n  hint: {hint}")]
    NotInstalled {
        /// Name of the program.
        program: String,
        /// Error of the operating system.
        source: std::io::Error,
        /// Installation instructions for the program.
        hint: &'static str,
    },
    /// Program that ended with an error.
    #[error("`{program}` ended with {status}; its last lines are\n{tail}\n  hint: its whole output is in {}", log.display())]
    Failed {
        /// Name of the program.
        program: String,
        /// Exit status, as text.
        status: String,
        /// Last lines of its output.
        tail: String,
        /// Path of the complete log.
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
            "\n  hint: an output is read together with the case.json in its folder; name another case with --case"
        }
        false => "",
    }
}
