//! Screening of a run whose frames are given by a Python function.

use crate::answer::Answer;
use crate::failure::Failure;
use crate::interrupt;
use crate::pool::evaluating;
use crate::problem::Problem;
use onset::cancel::checkpoint;
use onset_study::screen::{
    Actual, Frame, Question, Region, Run, ScreenAnswer, ScreenError, Snapshot, Stepping,
    stepping_named, told_repeats,
};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::cell::RefCell;
use std::sync::Arc;

/// Time and fields of a frame: positions, velocities, gradients and stresses as bytes of doubles.
type Fields<'py> = (
    f64,
    Bound<'py, PyBytes>,
    Option<Bound<'py, PyBytes>>,
    Option<Bound<'py, PyBytes>>,
    Option<Bound<'py, PyBytes>>,
);

/// Particles of a run, and the choices of the user.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Asked {
    reference: Vec<[f64; 3]>,
    held: Vec<bool>,
    volumes: Option<Vec<f64>>,
    elements: Option<Vec<Vec<usize>>>,
    region: Option<String>,
    stress_given: [bool; 6],
    time_step: Option<f64>,
    stepping: String,
    threshold: f64,
    seed: Option<f64>,
    bin: f64,
    actual: Option<f64>,
    repeated: usize,
}

/// Rows of a field from bytes of doubles.
fn rows<const N: usize>(data: &Bound<'_, PyBytes>) -> Vec<[f64; N]> {
    let (numbers, _) = data.as_bytes().as_chunks();
    let numbers: Vec<f64> = numbers.iter().copied().map(f64::from_ne_bytes).collect();
    numbers.as_chunks().0.to_vec()
}

fn frame(py: Python<'_>, give: &Py<PyAny>, number: usize, given: [bool; 6]) -> PyResult<Frame> {
    let answer = evaluating(|| give.call1(py, (number,)))?;
    let (time, x, velocity, gradient, stress): Fields<'_> = answer.extract(py)?;
    Ok(Frame {
        time,
        x: rows(&x),
        velocity: velocity.as_ref().map(rows),
        gradient: gradient.as_ref().map(rows),
        stress: stress.as_ref().map(rows),
        stress_given: given,
    })
}

fn keep(py: Python<'_>, take: &Py<PyAny>, snapshot: &Snapshot<'_>) -> PyResult<()> {
    let fields = PyDict::new(py);
    for (name, values) in snapshot.of_nodes.iter().chain(&snapshot.of_points) {
        fields.set_item(name, crate::arrays::bytes(py, values)?)?;
    }
    evaluating(|| take.call1(py, (snapshot.number, snapshot.time, fields)))?;
    Ok(())
}

fn keep_modes(py: Python<'_>, take: &Py<PyAny>, actual: &Actual) -> PyResult<()> {
    for mode in &actual.modes {
        let displacements = crate::arrays::bytes(py, mode.displacements.as_flattened())?;
        evaluating(|| take.call1(py, (displacements,)))?;
    }
    Ok(())
}

/// Screens a run of `count` frames. `give` returns the fields of a frame, `take` receives the results, and `modes` the displacements of each mode.
#[pyfunction]
pub fn screen(
    py: Python<'_>,
    problem: &Problem,
    asked: Asked,
    count: usize,
    give: Py<PyAny>,
    take: Option<Py<PyAny>>,
    modes: Py<PyAny>,
) -> PyResult<Answer> {
    let problem = Arc::clone(&problem.0);
    interrupt::answer(py, move || {
        let stepping = stepping_named(&asked.stepping).ok_or_else(|| {
            let known = Stepping::ALL.map(Stepping::name).join(", ");
            Failure::input(format!(
                "stepping is {:?}; expected one of {known}",
                asked.stepping
            ))
        })?;
        let question = Question {
            time_step: asked.time_step,
            stepping,
            threshold: asked.threshold,
            seed: asked.seed,
            bin: asked.bin,
            actual: asked.actual,
            ..Question::default()
        };
        let region = asked.region.as_deref().map(str::parse::<Region>);
        let run = Run {
            reference: asked.reference,
            volumes: asked.volumes,
            held: asked.held,
            cells: asked.elements,
            rounding: 0.0,
            region: region.transpose().map_err(Failure::input)?,
        };
        // The exception of a Python function is raised unchanged.
        let raised = RefCell::new(None);
        let failed = |error: PyErr| {
            *raised.borrow_mut() = Some(error);
            ScreenError::TooFewFrames { count, why: None }
        };
        let ended = || {
            failed(pyo3::exceptions::PyRuntimeError::new_err(
                "the interpreter ends",
            ))
        };
        let given = asked.stress_given;
        let mut frames = (0..count).map(|number| {
            checkpoint();
            let frame = Python::try_attach(|py| frame(py, &give, number, given));
            frame.ok_or_else(ended)?.map_err(failed)
        });
        let mut sink = |snapshot: &Snapshot<'_>| match &take {
            None => Ok(()),
            Some(take) => {
                let kept = Python::try_attach(|py| keep(py, take, snapshot));
                kept.ok_or_else(ended)?.map_err(failed)
            }
        };
        let answer = ScreenAnswer::new(&problem, &question, &run, None, &mut frames, &mut sink);
        if let Ok(answer) = &answer
            && let Some(actual) = &answer.actual
        {
            let kept = Python::try_attach(|py| keep_modes(py, &modes, actual));
            *raised.borrow_mut() = kept.and_then(Result::err);
        }
        let answer = match (answer, raised.take()) {
            (_, Some(error)) => return Err(Failure::Raised(error)),
            (Ok(mut answer), None) => {
                answer.notes.splice(0..0, told_repeats(asked.repeated));
                answer
            }
            (Err(error), None) => return Err(Failure::input(error)),
        };
        let told = Answer::of(&answer, &answer, answer.csv())?;
        Ok(told.with_files(move || Ok(answer.files())))
    })
}
