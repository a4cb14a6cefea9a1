//! Answer of the package: document, text, table and files.

use crate::failure::Failure;
use crate::interrupt;
use crate::problem::unknown;
use onset_study::figure::{Sheet, Size, Theme};
use onset_study::json;
use onset_study::output::{Content, Files, Output};
use onset_umat::readable;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde::Serialize;
use std::fmt::Display;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// Function that computes a part of an answer on demand.
type OnDemand<T> = Arc<dyn Fn() -> Result<T, Failure> + Send + Sync>;

/// Answer of a command: the printed documents, and the files.
#[pyclass(frozen, module = "onset._onset")]
pub struct Answer {
    /// Document of the option `--json`.
    #[pyo3(get)]
    json: String,
    /// Text printed by the command.
    #[pyo3(get)]
    text: String,
    table: OnDemand<String>,
    files: Option<Arc<Drawn>>,
}

/// Files of an answer, which are computed when they are first requested.
struct Drawn {
    draw: OnDemand<Files>,
    made: OnceLock<Files>,
}

impl Drawn {
    fn made(&self) -> Result<&Files, Failure> {
        match self.made.get() {
            Some(made) => Ok(made),
            None => {
                let made = (self.draw)()?;
                Ok(self.made.get_or_init(|| made))
            }
        }
    }
}

impl Answer {
    /// Answer of the study crate with its table as CSV, without files.
    ///
    /// # Errors
    /// [`Failure`] if it cannot be written as JSON.
    pub fn of<T: Serialize>(answer: &T, text: impl Display, csv: String) -> Result<Self, Failure> {
        Self::with_table(answer, text, move || Ok(csv.clone()))
    }

    /// Answer of the study crate with a table that is computed on demand, without files.
    ///
    /// # Errors
    /// [`Failure`] if it cannot be written as JSON.
    pub fn with_table<T: Serialize>(
        answer: &T,
        text: impl Display,
        csv: impl Fn() -> Result<String, Failure> + Send + Sync + 'static,
    ) -> Result<Self, Failure> {
        Ok(Self {
            json: json::document(answer).map_err(Failure::machine)?,
            text: readable(text.to_string().trim_end()),
            table: Arc::new(csv),
            files: None,
        })
    }

    /// Adds the files that the command writes with `--out`; they are computed on demand.
    pub fn with_files(
        mut self,
        draw: impl Fn() -> Result<Files, Failure> + Send + Sync + 'static,
    ) -> Self {
        self.files = Some(Arc::new(Drawn {
            draw: Arc::new(draw),
            made: OnceLock::new(),
        }));
        self
    }
}

/// Sheet of the figures from keywords.
fn sheet(
    size: Option<&str>,
    title: Option<String>,
    bare: bool,
    theme: &str,
) -> Result<Sheet, Failure> {
    let known = Theme::ALL.into_iter().find(|own| own.name() == theme);
    Ok(Sheet {
        size: size
            .map(str::parse::<Size>)
            .transpose()
            .map_err(|why| Failure::input(format!("size: {why}")))?,
        title,
        bare,
        theme: known.ok_or_else(|| unknown("theme", theme, Theme::ALL.map(Theme::name)))?,
    })
}

#[pymethods]
impl Answer {
    /// Table of the option `--format csv`.
    #[getter]
    fn csv(&self, py: Python<'_>) -> PyResult<String> {
        let table = Arc::clone(&self.table);
        interrupt::answer(py, move || Ok(table()?.trim_end().to_owned()))
    }

    /// Writes the files into a folder, all or none, and returns their paths.
    fn save(
        &self,
        py: Python<'_>,
        folder: PathBuf,
        size: Option<String>,
        title: Option<String>,
        bare: bool,
        theme: String,
    ) -> PyResult<Vec<PathBuf>> {
        let Some(files) = self.files.clone() else {
            return Ok(Vec::new());
        };
        interrupt::answer(py, move || {
            let sheet = sheet(size.as_deref(), title, bare, &theme)?;
            let output = Output::at::<&str>(&folder, &[])?.on(sheet);
            Ok(output.write(files.made()?)?)
        })
    }

    /// Files of the answer by name; empty if the command writes no files.
    fn files<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let told = PyDict::new(py);
        if let Some(files) = self.files.clone() {
            let all = interrupt::answer(py, move || {
                let sheet = Sheet::default();
                let mut all = Vec::new();
                for (name, content) in files.made()? {
                    let drawn = content.drawn(name, &sheet).map_err(Failure::machine)?;
                    all.extend(
                        drawn
                            .into_iter()
                            .map(|(name, bytes)| (name, bytes.into_owned())),
                    );
                }
                Ok(all)
            })?;
            for (name, bytes) in all {
                told.set_item(name.to_string_lossy(), PyBytes::new(py, &bytes))?;
            }
        }
        Ok(told)
    }

    /// Description of the figure as JSON; `None` without a figure.
    fn figure(&self, py: Python<'_>) -> PyResult<Option<String>> {
        let Some(files) = self.files.clone() else {
            return Ok(None);
        };
        interrupt::answer(py, move || {
            let figure = files.made()?.iter().find_map(|(_, content)| match content {
                Content::Figure(figure) => Some(figure),
                Content::Bytes(_) => None,
            });
            let document = figure.map(|figure| json::document(&figure.description()));
            document.transpose().map_err(Failure::machine)
        })
    }
}
