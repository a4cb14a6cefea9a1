//! Answer of the package: document, text, table and files.

use crate::failure::Failure;
use crate::interrupt;
use onset_study::json;
use onset_study::output::{Files, write};
use onset_umat::readable;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde::Serialize;
use std::fmt::Display;
use std::path::PathBuf;
use std::sync::Arc;

/// Function that computes the files of an answer.
type Draw = dyn Fn() -> Result<Files, Failure> + Send + Sync;

/// Answer of a command: the printed documents, and the files.
#[pyclass(frozen, module = "onset._onset")]
pub struct Answer {
    /// Document of the option `--json`.
    #[pyo3(get)]
    json: String,
    /// Text printed by the command.
    #[pyo3(get)]
    text: String,
    /// Table of the option `--format csv`.
    #[pyo3(get)]
    csv: String,
    draw: Option<Arc<Draw>>,
}

impl Answer {
    /// Answer of the study crate, without files.
    ///
    /// # Errors
    /// [`Failure`] if it cannot be written as JSON.
    pub fn of<T: Serialize>(answer: &T, text: impl Display) -> Result<Self, Failure> {
        Ok(Self {
            json: json::document(answer).map_err(Failure::machine)?,
            text: readable(text.to_string().trim_end()),
            csv: json::csv(answer).map_err(Failure::machine)?,
            draw: None,
        })
    }

    /// Replaces the table derived from the document.
    pub fn with_table(mut self, table: &str) -> Self {
        self.csv = table.trim_end().to_owned();
        self
    }

    /// Adds the files that the command writes with `--out`; they are computed on demand.
    pub fn with_files(
        mut self,
        draw: impl Fn() -> Result<Files, Failure> + Send + Sync + 'static,
    ) -> Self {
        self.draw = Some(Arc::new(draw));
        self
    }
}

#[pymethods]
impl Answer {
    /// Writes the files into a folder, all or none, and returns their paths.
    fn save(&self, py: Python<'_>, folder: PathBuf) -> PyResult<Vec<PathBuf>> {
        let Some(draw) = self.draw.clone() else {
            return Ok(Vec::new());
        };
        interrupt::answer(py, move || Ok(write(&folder, &draw()?)?))
    }

    /// Files of the answer by name; empty if the command writes no files.
    fn files<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let files = PyDict::new(py);
        if let Some(draw) = self.draw.clone() {
            for (name, bytes) in interrupt::answer(py, move || draw())? {
                let name = name.to_string_lossy().into_owned();
                files.set_item(name, PyBytes::new(py, &bytes))?;
            }
        }
        Ok(files)
    }
}
