//! What is wrong with a simulation.

use crate::answers::{ProblemError, hint_on_body};
use crate::output::OutputError;
use crate::settings::SettingError;
use onset::method::MethodError;
use onset::motion::{BodyError, Fault};
use std::path::PathBuf;
use thiserror::Error;

/// Why there is no answer.
#[derive(Debug, Error)]
pub enum SimulateError {
    /// The study.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The method or the law at the homogeneous state.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// A body as a study has it.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// A body that cannot be.
    #[error("{source}\n  hint: {}", hint_on_body(source))]
    Body {
        /// Why.
        #[from]
        source: BodyError,
    },
    /// A choice that cannot be.
    #[error("{what}\n  hint: {hint}")]
    Refused {
        /// What is wrong.
        what: String,
        /// What to do.
        hint: String,
    },
    /// A checkpoint that is none, or not of this run.
    #[error("{}: {what}\n  hint: {hint}", path.display())]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
        /// What to do.
        hint: &'static str,
    },
    /// A motion that cannot go on.
    #[error("{fault}\n  hint: {hint}{}", kept(checkpoint))]
    Fault {
        /// When and where.
        fault: Box<Fault>,
        /// What to do.
        hint: String,
        /// The last checkpoint: the file, and its step.
        checkpoint: Option<(PathBuf, u64)>,
    },
    /// A file that cannot be written.
    #[error("{source}{}", kept(checkpoint))]
    Output {
        /// What is in the way.
        source: OutputError,
        /// The last checkpoint.
        checkpoint: Option<(PathBuf, u64)>,
    },
}

impl SimulateError {
    /// Whether the input is at fault, not the machine or the motion.
    pub fn is_input(&self) -> bool {
        !matches!(self, Self::Fault { .. } | Self::Output { .. })
    }
}

fn kept(checkpoint: &Option<(PathBuf, u64)>) -> String {
    match checkpoint {
        Some((path, step)) => format!(
            "\n  the last checkpoint, {}, is of step {step}",
            path.display()
        ),
        None => String::new(),
    }
}
