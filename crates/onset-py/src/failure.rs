//! Errors as exceptions of the package.

use onset_study::answers::ProblemError;
use onset_study::map::MapError;
use onset_study::output::OutputError;
use onset_study::settings::{Origin, SettingError};
use onset_study::simulate::SimulateError;
use onset_study::store::StoreError;
use onset_umat::message;
use pyo3::prelude::*;
use std::fmt::Display;

/// Reason why there is no answer. Messages and hints agree with the command.
#[derive(Debug)]
pub enum Failure {
    /// Invalid setting, raised as `onset.SettingError`.
    Setting(Box<SettingError>),
    /// Other invalid input, raised as `onset.InputError`.
    Input(String),
    /// Failure of the machine, or a motion that breaks down, raised as `onset.MachineError`.
    Machine(String),
    /// Defect of the program, raised as `onset.OnsetError`.
    Defect(String),
    /// Exception of a Python function that the caller passed, raised unchanged.
    Raised(PyErr),
    /// Call that the user cancelled.
    Ended,
}

/// File, line and column of a setting.
type Place = (String, usize, usize);

impl Failure {
    /// Failure caused by the input.
    pub fn input(error: impl Display) -> Self {
        Self::Input(error.to_string())
    }

    /// Failure with valid input.
    pub fn machine(error: impl Display) -> Self {
        Self::Machine(error.to_string())
    }

    /// Creates the exception; an error if this fails.
    fn raised(self, py: Python<'_>) -> PyResult<PyErr> {
        let (class, text, key, place) = match self {
            Self::Raised(error) => return Ok(error),
            Self::Setting(error) => {
                let (key, place) = origin(&error);
                ("SettingError", error.to_string(), key, place)
            }
            Self::Input(text) => ("InputError", text, None, None),
            Self::Machine(text) => ("MachineError", text, None, None),
            Self::Defect(text) => ("OnsetError", text, None, None),
            Self::Ended => (
                "OnsetError",
                "the computation was cancelled".to_owned(),
                None,
                None,
            ),
        };
        let class = py.import("onset._errors")?.getattr(class)?;
        let text = message(&text);
        let exception = match (key, place) {
            (None, None) => class.call1((text,))?,
            (key, place) => class.call1((text, key, place))?,
        };
        Ok(PyErr::from_value(exception))
    }
}

/// Key of an assignment, and its position in a file.
fn origin(error: &SettingError) -> (Option<String>, Option<Place>) {
    match &error.origin {
        Origin::CommandLine(argument) => {
            let assignment = argument.strip_prefix("--set ").unwrap_or(argument);
            let key = assignment.split('=').next().unwrap_or_default();
            (Some(key.trim().to_owned()), None)
        }
        Origin::File { name, line, column } => {
            // Messages about files name the key first, as `section.key`.
            let named = error.message.split('`').nth(1);
            let key = named.filter(|key| key.contains('.') && !key.contains(' '));
            (key.map(str::to_owned), Some((name.clone(), *line, *column)))
        }
        Origin::Question | Origin::Combination => (None, None),
    }
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        Python::attach(|py| failure.raised(py).unwrap_or_else(|error| error))
    }
}

impl From<SettingError> for Failure {
    fn from(error: SettingError) -> Self {
        Self::Setting(Box::new(error))
    }
}

impl From<ProblemError> for Failure {
    fn from(error: ProblemError) -> Self {
        match error {
            ProblemError::Setting(error) => error.into(),
            other => Self::input(other),
        }
    }
}

impl From<MapError> for Failure {
    fn from(error: MapError) -> Self {
        match error {
            MapError::Problem(error) => error.into(),
            other if other.is_input() => Self::input(other),
            other => Self::machine(other),
        }
    }
}

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Self {
        MapError::from(error).into()
    }
}

impl From<SimulateError> for Failure {
    fn from(error: SimulateError) -> Self {
        match error {
            SimulateError::Problem(error) => error.into(),
            other if other.is_input() => Self::input(other),
            other => Self::machine(other),
        }
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        Self::machine(error)
    }
}
