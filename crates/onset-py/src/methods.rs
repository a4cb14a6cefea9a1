//! Methods: comparison, recommendation, tuning, and spurious modes.

use crate::answer::Answer;
use crate::failure::Failure;
use crate::function::{Assigned, Setting};
use crate::interrupt;
use crate::problem::{Source, settings};
use onset_study::compare::{PANELS, Recommendation, Table, Thresholds};
use onset_study::modes::{ModesAnswer, ModesQuestion};
use onset_study::settings::{Comparison, Trust};
use onset_study::tune::{TuneAnswer, TuneQuestion};
use pyo3::prelude::*;
use std::path::PathBuf;

/// Compares the methods of a file, or their variants: `variations` such as `discretization.penalty=0,0.1,0.5`.
#[pyfunction]
pub fn compare(
    py: Python<'_>,
    file: Source,
    given: Vec<Setting>,
    libraries: Vec<PathBuf>,
    variations: Vec<String>,
) -> PyResult<Answer> {
    let assigned = Assigned::from(given);
    interrupt::answer(py, move || {
        let comparison = comparison(&file, &assigned, &libraries, &variations)?;
        let table = evaluated(&comparison)?;
        let answer = Answer::of(&table, &table, table.csv())?;
        Ok(answer.with_files(move || Ok(table.files())))
    })
}

/// Ranks the methods of a file, or the built-in methods for a dimension. `limits` are weak, wrong, long waves and wavelength.
#[pyfunction]
pub fn recommend(
    py: Python<'_>,
    file: Option<Source>,
    dimension: usize,
    given: Vec<Setting>,
    libraries: Vec<PathBuf>,
    limits: (f64, f64, f64, f64),
) -> PyResult<Answer> {
    let assigned = Assigned::from(given);
    interrupt::answer(py, move || {
        let mut comparison = match file {
            Some(file) => comparison(&file, &assigned, &libraries, &[])?,
            None => {
                let panel = dimension.checked_sub(1).and_then(|n| PANELS.get(n));
                let (name, text) = panel.ok_or_else(|| {
                    Failure::Input(format!(
                        "dimension cannot be {dimension}\n  hint: expected 1, 2 or 3"
                    ))
                })?;
                of_law(Comparison::parse(name, text, &assigned.texts)?, &assigned)
            }
        };
        let (weak, wrong, long_waves, wavelength) = limits;
        comparison.override_weak(weak);
        let mut table = evaluated(&comparison)?;
        table.thresholds = Thresholds {
            weak: table.thresholds.weak,
            wrong,
            long_waves,
            wavelength,
            ..Thresholds::default()
        };
        let recommendation = Recommendation::new(table);
        let answer = Answer::of(&recommendation, &recommendation, recommendation.csv())?;
        Ok(answer.with_files(move || Ok(recommendation.files())))
    })
}

/// Finds the smallest sufficient coefficient of a stabilization. `limits` are weak, wrong and later.
#[pyfunction]
pub fn tune(
    py: Python<'_>,
    key: String,
    given: Vec<Setting>,
    file: Option<Source>,
    libraries: Vec<PathBuf>,
    range: (f64, f64),
    stretches: (f64, f64),
    limits: (f64, f64, f64),
) -> PyResult<Answer> {
    let assigned = Assigned::from(given);
    interrupt::answer(py, move || {
        let (weak, wrong, later) = limits;
        let question = TuneQuestion::new(&key, range, stretches)?.with_thresholds(Thresholds {
            weak,
            wrong,
            later,
            ..Thresholds::default()
        });
        let settings = settings(file.as_ref(), &assigned, &libraries, &[question.key()])?;
        let tuned = TuneAnswer::new(&settings, &question, |_| ())?;
        let answer = Answer::of(&tuned, &tuned, tuned.csv())?;
        Ok(answer.with_files(move || Ok(tuned.files())))
    })
}

/// Finds the zero-energy and weakly controlled modes of a method.
#[pyfunction]
pub fn modes(
    py: Python<'_>,
    given: Vec<Setting>,
    file: Option<Source>,
    libraries: Vec<PathBuf>,
    weak: f64,
    cells: usize,
    amplitude: f64,
) -> PyResult<Answer> {
    let assigned = Assigned::from(given);
    interrupt::answer(py, move || {
        let settings = settings(file.as_ref(), &assigned, &libraries, &[])?;
        let question = ModesQuestion {
            weak,
            cells,
            amplitude,
            is_exported: false,
        };
        let modes = ModesAnswer::new(&settings, &question)?;
        let answer = Answer::of(&modes, &modes, modes.csv())?;
        Ok(answer.with_files(move || Ok(modes.files())))
    })
}

fn comparison(
    (name, text): &Source,
    assigned: &Assigned,
    libraries: &[PathBuf],
    variations: &[String],
) -> Result<Comparison, Failure> {
    let read = Comparison::varied(name, text, &assigned.texts, variations)?;
    let comparison = of_law(read, assigned);
    let comparison = comparison.allowing(&Trust::of_user(libraries));
    comparison.common.material.permitted()?;
    Ok(comparison)
}

/// Replaces the material of a comparison by a Python law, if given.
fn of_law(comparison: Comparison, assigned: &Assigned) -> Comparison {
    match assigned.law() {
        Some(law) => comparison.of_material(law),
        None => comparison,
    }
}

fn evaluated(comparison: &Comparison) -> Result<Table, Failure> {
    let table = Table::of(comparison, |_| ())?;
    match table.failure() {
        Some(why) => Err(Failure::Input(why)),
        None => Ok(table),
    }
}
