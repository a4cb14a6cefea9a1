//! Names used by the package.

use onset_study::Verdict;
use onset_study::settings::{self, Key, Model};
use pyo3::prelude::*;

/// The version of the program.
#[pyfunction]
pub fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}

/// The keys of studies: name, what it expects, what it means.
#[pyfunction]
pub fn keys() -> Vec<(&'static str, String, &'static str)> {
    let told = |key: &Key| (key.name, key.expects(), key.meaning);
    settings::study_keys().map(told).collect()
}

/// The names of models of materials.
#[pyfunction]
pub fn models() -> Vec<&'static str> {
    Model::all().map(Model::name).collect()
}

/// What is to be told of the settings that have been read since this was asked last.
#[pyfunction]
pub fn notes() -> Vec<String> {
    settings::notes_on_settings()
}

/// The words of verdicts in the order of their numbers; the last is where the method cannot be evaluated.
#[pyfunction]
pub fn verdict_names() -> Vec<&'static str> {
    let names = Verdict::ALL.into_iter().map(Verdict::name);
    names.chain(["undefined"]).collect()
}
