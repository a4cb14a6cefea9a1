//! Names and descriptions of keys, laws and verdicts for the Python package.

use crate::failure::Failure;
use onset::verdict::Mechanism;
use onset_study::Verdict;
use onset_study::settings::{self, Key, Model, Settings};
use pyo3::prelude::*;

/// Version number of the program.
#[pyfunction]
pub fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}

/// Keys of studies: name, expected values, and meaning.
#[pyfunction]
pub fn keys() -> Vec<(&'static str, String, &'static str)> {
    let told = |key: &Key| (key.name, key.expects(), key.meaning);
    settings::study_keys().map(told).collect()
}

/// Names of the built-in material laws.
#[pyfunction]
pub fn models() -> Vec<&'static str> {
    Model::all().map(Model::name).collect()
}

/// Checks the names and values of assignments to a law or to a method.
#[pyfunction]
pub fn check(assignments: Vec<String>) -> Result<(), Failure> {
    // The question that uses the settings reports the notes on them.
    Settings::check_part(&assignments)?;
    drop(settings::notes_on_settings());
    Ok(())
}

/// Notes on the settings read since the last call.
#[pyfunction]
pub fn notes() -> Vec<String> {
    settings::notes_on_settings()
}

/// Names of the mechanisms in the order of their numbers; the last name is empty, for states without one.
#[pyfunction]
pub fn mechanism_names() -> Vec<&'static str> {
    let names = Mechanism::ALL.into_iter().map(Mechanism::name);
    names.chain([""]).collect()
}

/// Names of the verdicts in the order of their numbers; the last name is for states where the method cannot be evaluated.
#[pyfunction]
pub fn verdict_names() -> Vec<&'static str> {
    let names = Verdict::ALL.into_iter().map(Verdict::name);
    names.chain(["undefined"]).collect()
}
