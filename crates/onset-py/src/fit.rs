//! Laws fitted to tests.

use crate::answer::Answer;
use crate::failure::Failure;
use crate::interrupt;
use crate::problem::unknown;
use onset_study::fit::{
    Arrays, Columns, FittingError, Mode, Options, Reading, Source, Tests, criteria, families,
    fitted, stable_range, weights,
};
use pyo3::prelude::*;
use std::path::PathBuf;

/// Loading, with the path of a table, or the arrays that replace it (stretches, nominal stresses and lateral stretches), or its columns by name.
type Given = (
    Option<String>,
    Option<PathBuf>,
    Vec<Vec<f64>>,
    Vec<(String, Vec<String>)>,
);

/// Tests, and the choices of the user.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Asked {
    tests: Vec<Given>,
    law: Vec<String>,
    weights: String,
    weight: Vec<(String, f64)>,
    floor: Option<f64>,
    stable: String,
    criterion: String,
    margin: f64,
    starts: usize,
    fix: Vec<(String, f64)>,
    bound: Vec<(String, [f64; 2])>,
    bulk: Option<f64>,
    unit: Option<String>,
    area: Option<f64>,
    range: Option<[f64; 2]>,
    material: Option<String>,
}

impl From<FittingError> for Failure {
    fn from(error: FittingError) -> Self {
        match error {
            FittingError::Setting(error) => error.into(),
            FittingError::Output(error) => error.into(),
            other => Self::input(other),
        }
    }
}

fn mode_named(name: &str) -> Result<Mode, Failure> {
    Mode::named(name).ok_or_else(|| unknown("loading", name, Mode::ALL.map(Mode::name)))
}

fn source((mode, path, arrays, cells): Given) -> Result<Source, Failure> {
    let known = mode.as_deref().map(mode_named).transpose()?;
    if let Some(path) = path {
        return Ok(Source::File(path, known));
    }
    let name = format!("tests[{:?}]", mode.unwrap_or_default());
    let missing = || {
        Failure::input(format!(
            "{name}: expected a loading, stretches and stresses"
        ))
    };
    let mode = known.ok_or_else(missing)?;
    if !cells.is_empty() {
        return Ok(Source::Columns(Columns { name, mode, cells }));
    }
    let mut arrays = arrays.into_iter();
    Ok(Source::Arrays(Arrays {
        mode,
        stretch: arrays.next().ok_or_else(missing)?,
        stress: arrays.next().ok_or_else(missing)?,
        lateral: arrays.next(),
        name,
    }))
}

/// Fits laws to tests.
#[pyfunction]
pub fn fit(py: Python<'_>, asked: Asked) -> PyResult<Answer> {
    interrupt::answer(py, move || {
        let range = stable_range(&asked.stable);
        let options = Options {
            weights: weights(&asked.weights, asked.floor)?,
            range: range.map_err(|error| {
                Failure::input(format!("stable is {:?}; {error}", asked.stable))
            })?,
            criteria: criteria(&asked.criterion)?,
            margin: asked.margin,
            starts: asked.starts,
            fixed: asked.fix,
            bounds: asked.bound,
        };
        let sources = asked.tests.into_iter().map(source);
        let sources = sources.collect::<Result<Vec<_>, _>>()?;
        let reading = Reading {
            unit: asked.unit,
            area: asked.area,
            range: asked.range,
            material: asked.material,
            weights: asked.weight,
        };
        let mut tests = Tests::read(&sources, &reading).map_err(FittingError::from)?;
        let families = families(&asked.law, &mut tests)?;
        let answer = fitted(tests, &families, &options, asked.bulk, &mut |_| {})?;
        let told = Answer::of(&answer, &answer, answer.csv())?;
        Ok(told.with_files(move || Ok(answer.files()?)))
    })
}
