//! Instabilities that users of particle codes reported.

use crate::answer::Answer;
use crate::failure::Failure;
use crate::interrupt;
use onset_study::zoo::{Zoo, report};
use pyo3::prelude::*;

/// Lists the reports of the zoo, or answers one.
#[pyfunction]
pub fn zoo(py: Python<'_>, name: Option<String>) -> PyResult<Answer> {
    interrupt::answer(py, move || {
        let Some(name) = name else {
            let all = Zoo::default();
            return Answer::of(&all, &all, all.csv());
        };
        let answer = report(&name)?.answer().map_err(Failure::from)?;
        Answer::of(&answer, &answer, answer.csv())
    })
}
