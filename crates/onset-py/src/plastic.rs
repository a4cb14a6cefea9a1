//! Localization of plastic materials.

use crate::answer::Answer;
use crate::failure::Failure;
use crate::interrupt;
use onset_study::localization::{LocalizationAnswer, PlasticSettings};
use pyo3::prelude::*;

/// Finds the localization of a plastic material along a loading.
#[pyfunction]
pub fn localize(py: Python<'_>, assignments: Vec<String>) -> PyResult<Answer> {
    interrupt::answer(py, move || {
        let settings = PlasticSettings::from_assignments(&assignments)?;
        let localization = LocalizationAnswer::new(&settings).map_err(Failure::input)?;
        let answer = Answer::of(&localization, &localization, localization.csv())?;
        Ok(answer.with_files(move || Ok(localization.files())))
    })
}
