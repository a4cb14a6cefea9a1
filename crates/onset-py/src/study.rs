//! Study: its boundaries, and its map.

use crate::answer::Answer;
use crate::failure::Failure;
use crate::interrupt;
use crate::problem::{Source, trusted};
use onset_study::boundary::{self, Boundaries, Tracing, csv, files};
use onset_study::map::{Part, Plan, Summary};
use onset_study::settings;
use onset_study::store::ZarrStore;
use pyo3::prelude::*;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Study with two or three axes.
#[pyclass(frozen, module = "onset._onset")]
pub struct Study(settings::Study);

/// Boundaries in the form of the command's document.
#[derive(Serialize)]
struct Traced {
    #[serde(flatten)]
    summary: boundary::Summary,
    files: Vec<String>,
}

/// Map in the form of the command's document.
#[derive(Serialize)]
struct Mapped<'a> {
    store: String,
    #[serde(flatten)]
    summary: &'a Summary,
    interrupted: bool,
}

#[pymethods]
impl Study {
    #[new]
    fn new(
        py: Python<'_>,
        file: Source,
        assignments: Vec<String>,
        libraries: Vec<PathBuf>,
    ) -> PyResult<Self> {
        interrupt::answer(py, move || {
            let (name, text) = file;
            let study = settings::Study::parse(&name, &text)?;
            let mut study = study.override_with(&assignments)?;
            trusted(&mut study.settings.material, &libraries)?;
            Ok(Self(study))
        })
    }

    /// Text of the study: the file as read, or the complete study if assignments override the file.
    #[getter]
    fn text(&self) -> &str {
        &self.0.text
    }

    /// Number of states along each axis, slowest axis first.
    #[getter]
    fn shape(&self) -> Vec<usize> {
        self.0.shape()
    }

    fn boundary(&self, py: Python<'_>, flutter: bool) -> PyResult<Answer> {
        let study = self.0.clone();
        interrupt::answer(py, move || {
            let tracing = Tracing {
                flutter,
                fidelity: true,
            };
            let boundaries = Boundaries::of(&study, tracing, &()).map_err(Failure::input)?;
            let made = files(&boundaries).map_err(Failure::machine)?;
            let text = boundaries.summary().to_string();
            let traced = Traced {
                summary: boundaries.summary(),
                files: Vec::new(),
            };
            let answer = Answer::of(&traced, text, csv(&boundaries))?;
            Ok(answer.with_files(move || Ok(made.clone())))
        })
    }

    /// Creates or opens the store of the map without computing tiles, and returns the number of tiles.
    fn begin(
        &self,
        py: Python<'_>,
        out: PathBuf,
        resume: bool,
        overwrite: bool,
    ) -> PyResult<usize> {
        let study = self.0.clone();
        interrupt::answer(py, move || {
            let plan = Plan::new(&study)?;
            store(&plan, &out, resume, overwrite)?;
            Ok(plan.tiling().tiles())
        })
    }

    /// Computes all tiles of the map, or the given part, into a store.
    fn map(
        &self,
        py: Python<'_>,
        out: PathBuf,
        tiles: Option<String>,
        resume: bool,
        overwrite: bool,
    ) -> PyResult<Answer> {
        let study = self.0.clone();
        interrupt::answer(py, move || {
            let plan = Plan::new(&study)?;
            let asked = tiles.map(|text| text.parse::<Part>());
            let asked = asked
                .transpose()
                .map_err(|error| Failure::input(format!("tiles: {error}")))?;
            let is_part = asked.is_some();
            let tiles = plan.tiles(asked)?;
            let store = store(&plan, &out, resume || is_part, overwrite)?;
            let asked = tiles.len();
            let summary = plan.run(&store, &tiles, &())?;
            let mapped = Mapped {
                store: out.display().to_string(),
                summary: &summary,
                interrupted: summary.tiles_computed + summary.tiles_found < asked,
            };
            let text = format!("{summary}\nstore: {}", out.display());
            Answer::of(&mapped, text, summary.csv())
        })
    }
}

/// Store of a map: created, replaced or resumed.
fn store(plan: &Plan, out: &Path, resume: bool, overwrite: bool) -> Result<ZarrStore, Failure> {
    let store = if overwrite {
        ZarrStore::replace(out, plan.layout())
    } else if resume {
        ZarrStore::resume(out, plan.layout())
    } else {
        ZarrStore::create(out, plan.layout())
    };
    Ok(store?)
}
