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

/// Part of an answer, which is computed when it is first requested.
struct OnDemand<T> {
    compute: Box<dyn Fn() -> Result<T, Failure> + Send + Sync>,
    computed: OnceLock<T>,
}

impl<T> OnDemand<T> {
    fn new(compute: impl Fn() -> Result<T, Failure> + Send + Sync + 'static) -> Arc<Self> {
        Arc::new(Self {
            compute: Box::new(compute),
            computed: OnceLock::new(),
        })
    }

    fn get(&self) -> Result<&T, Failure> {
        match self.computed.get() {
            Some(computed) => Ok(computed),
            None => {
                let computed = (self.compute)()?;
                Ok(self.computed.get_or_init(|| computed))
            }
        }
    }
}

/// Answer of a command: the printed documents, and the files.
#[pyclass(frozen, module = "onset._onset")]
pub struct Answer {
    /// Document of the option `--json`.
    #[pyo3(get)]
    json: String,
    /// Text printed by the command.
    #[pyo3(get)]
    text: String,
    table: Arc<OnDemand<String>>,
    files: Option<Arc<OnDemand<Files>>>,
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
            table: OnDemand::new(csv),
            files: None,
        })
    }

    /// Adds the files that the command writes with `--out`; they are computed on demand.
    pub fn with_files(
        mut self,
        draw: impl Fn() -> Result<Files, Failure> + Send + Sync + 'static,
    ) -> Self {
        self.files = Some(OnDemand::new(draw));
        self
    }
}

/// Creates the sheet of a figure from keyword arguments.
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
        interrupt::answer(py, move || Ok(table.get()?.trim_end().to_owned()))
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
            Ok(output.write(files.get()?)?)
        })
    }

    /// Files of the answer by name; empty if the command writes no files.
    fn files<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let told = PyDict::new(py);
        if let Some(files) = self.files.clone() {
            let all = interrupt::answer(py, move || {
                let sheet = Sheet::default();
                let mut all = Vec::new();
                for (name, content) in files.get()? {
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
            let figure = files.get()?.iter().find_map(|(_, content)| match content {
                Content::Figure(figure) => Some(figure),
                Content::Bytes(_) => None,
            });
            let document = figure.map(|figure| json::document(&figure.description()));
            document.transpose().map_err(Failure::machine)
        })
    }
}
