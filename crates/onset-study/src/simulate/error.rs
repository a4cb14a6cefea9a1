//! Errors of a simulation.

use crate::answers::{ProblemError, hint_on_body};
use crate::output::OutputError;
use crate::settings::SettingError;
use onset::method::MethodError;
use onset::motion::{BodyError, Fault};
use std::path::PathBuf;
use thiserror::Error;

/// Reason why a simulation gives no answer.
#[derive(Debug, Error)]
pub enum SimulateError {
    /// Error in the study.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// Error of method or law at the homogeneous state.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// Error in the settings of a body.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// Body that cannot be created.
    #[error("{source}\n  hint: {}", hint_on_body(source))]
    Body {
        /// Reason for the refusal.
        #[from]
        source: BodyError,
    },
    /// Choice that is not supported.
    #[error("{what}\n  hint: {hint}")]
    Refused {
        /// Error in the choice, as a sentence.
        what: String,
        /// Remedy for the user.
        hint: String,
    },
    /// File that is not a checkpoint, or not a checkpoint of this run.
    #[error("{}: {what}\n  hint: {hint}", path.display())]
    Checkpoint {
        /// Path of the checkpoint.
        path: PathBuf,
        /// Error in the file, as a sentence.
        what: String,
        /// Remedy for the user.
        hint: &'static str,
    },
    /// Motion that breaks down.
    #[error("{fault}\n  hint: {hint}{}", kept(checkpoint))]
    Fault {
        /// Time, position and reason of the failure.
        fault: Box<Fault>,
        /// Remedy for the user.
        hint: String,
        /// Path and step of the last checkpoint.
        checkpoint: Option<(PathBuf, u64)>,
    },
    /// File that cannot be written.
    #[error("{source}{}", kept(checkpoint))]
    Output {
        /// Error of the output.
        source: OutputError,
        /// Path and step of the last checkpoint.
        checkpoint: Option<(PathBuf, u64)>,
    },
}

impl SimulateError {
    /// Returns true for an error in the input, false for a failure of the machine or of the motion.
    pub fn is_input(&self) -> bool {
        !matches!(self, Self::Fault { .. } | Self::Output { .. })
    }
}

fn kept(checkpoint: &Option<(PathBuf, u64)>) -> String {
    match checkpoint {
        Some((path, step)) => format!(
            "\n  the last checkpoint, {}, was written at step {step}",
            path.display()
        ),
        None => String::new(),
    }
}
