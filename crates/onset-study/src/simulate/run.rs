//! A run of a patch or a body: steps, output, and resumption from a checkpoint.

use super::SimulateError;
use super::checkpoint::{CHECKPOINT, FRESH_START, Progress};
use crate::csv::Table;
use crate::figure::Sheet;
use crate::input;
use crate::output::{Content, Files, Output, text};
use crate::settings::Units;
use crate::vtk;
use onset::method::MethodError;
use onset::motion::{Fault, Ground, PatchState};
use std::ffi::OsString;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Default time between checkpoints.
const CHECKPOINT_INTERVAL: Duration = Duration::from_secs(5);
/// Number of steps between checks of the clock.
const STEPS_BETWEEN_CLOCK_CHECKS: u64 = 64;

/// Folder for the output of a run.
#[derive(Clone, Debug)]
pub struct Place {
    /// Path of the folder.
    pub folder: PathBuf,
    /// Whether to resume from an existing checkpoint.
    pub is_resumed: bool,
    /// Whether to overwrite an existing checkpoint.
    pub is_overwritten: bool,
    /// Number of steps between checkpoints; `None` for a few seconds.
    pub checkpoint: Option<u64>,
    /// Sheet of the figures.
    pub sheet: Sheet,
}

/// Observer of a run, which may end it.
pub trait Watch {
    /// Reports that `done` of `all` steps are completed; first called after the motion has been set up.
    fn advance(&self, done: u64, all: u64);

    /// Returns true if the run should end now.
    fn is_interrupted(&self) -> bool;
}

/// Course of a run, fixed before the first step.
pub(super) struct Course {
    /// Identifier in the checkpoints of the run.
    pub(super) mark: String,
    /// Time step of the run; time.
    pub(super) step: f64,
    /// Largest stable time step; time.
    pub(super) critical: f64,
    pub(super) steps: u64,
    /// Number of steps between lines of the history.
    pub(super) every: u64,
    /// Number of steps between samples of the fitted record.
    pub(super) sampling: u32,
    pub(super) samples: u64,
    /// Steps after which fields are written.
    pub(super) fields: Vec<u64>,
    /// Whether fields are kept for a page.
    pub(super) is_shown: bool,
    /// Columns of the history with their dimensions, step and time first.
    pub(super) columns: &'static [(&'static str, &'static str)],
    /// Units of the history.
    pub(super) units: Units,
    pub(super) start: PatchState,
    /// Hint for a motion that grows beyond the domain of its law.
    pub(super) grown: &'static str,
}

/// Moving particles: a patch or a body.
pub(super) trait Moving {
    /// Advances by one step.
    fn advance(&mut self) -> Result<(), Box<Fault>>;

    fn state(&self) -> PatchState;

    /// Line of the history, after step and time.
    fn line(&mut self) -> Result<Vec<f64>, Box<Fault>>;

    /// Sample of the record; used for fitted records only.
    fn sample(&self) -> f64;

    /// Particles as a VTK field.
    fn field(&mut self) -> Result<String, Box<Fault>>;
}

/// Run with its output in a folder.
pub(super) struct Keeper<'a> {
    course: &'a Course,
    place: Option<&'a Place>,
    pub(super) progress: Progress,
    /// Fields to be written with the next checkpoint.
    pending: Files,
    /// Path and step of the last checkpoint.
    last: Option<(PathBuf, u64)>,
    written: Instant,
}

/// File name of a field.
fn field_name(number: usize) -> String {
    format!("field-{number:04}.vtu")
}

/// Particles at their current positions, with the vectors `displacement`, `velocity` and `reference` (position).
///
/// Displacements are relative to `places`; the integrator stores the velocities.
pub(super) fn grid<'g>(
    dimension: usize,
    places: &[[f64; 3]],
    reference: Vec<[f64; 3]>,
    state: &PatchState,
    positions: &'g mut Vec<[f64; 3]>,
) -> vtk::Grid<'g> {
    let of = |flat: &[f64]| -> Vec<[f64; 3]> {
        let each = flat.chunks_exact(dimension);
        each.map(|own| std::array::from_fn(|i| own.get(i).copied().unwrap_or(0.0)))
            .collect()
    };
    let displacements = of(&state.displacements);
    let both = places.iter().zip(&displacements);
    *positions = both
        .map(|(x, u)| std::array::from_fn(|i| x[i] + u[i]))
        .collect();
    vtk::Grid {
        points: positions,
        vectors: vec![
            ("displacement", displacements),
            ("velocity", of(&state.velocities)),
            ("reference", reference),
        ],
        ..vtk::Grid::default()
    }
}

impl<'a> Keeper<'a> {
    /// Keeper at the start of the run, or at its checkpoint.
    pub(super) fn begun(
        course: &'a Course,
        place: Option<&'a Place>,
    ) -> Result<Self, SimulateError> {
        let progress = begun(course, place)?;
        let last = match progress.history.is_empty() {
            true => None,
            false => place.map(|place| (place.folder.join(CHECKPOINT), progress.state.step)),
        };
        Ok(Self {
            course,
            place,
            progress,
            pending: Vec::new(),
            last,
            written: Instant::now(),
        })
    }

    /// Runs all remaining steps and returns true if interrupted. `moving` must be in the state of [`Self::progress`].
    pub(super) fn follow(
        &mut self,
        moving: &mut dyn Moving,
        watch: &dyn Watch,
    ) -> Result<bool, SimulateError> {
        let steps = self.course.steps;
        watch.advance(self.progress.state.step, steps);
        if self.progress.history.is_empty() {
            self.look(moving, 0)?;
        }
        let mut is_interrupted = false;
        for step in self.progress.state.step + 1..=steps {
            if watch.is_interrupted() {
                is_interrupted = true;
                break;
            }
            let moved = moving.advance().map_err(|fault| self.failed(fault));
            if let Err(error) = moved.and_then(|()| self.look(moving, step)) {
                self.keep_broken(step)?;
                return Err(error);
            }
            if self.is_due(step) {
                self.keep(moving, Vec::new())?;
                watch.advance(step, steps);
            } else if step.is_multiple_of(STEPS_BETWEEN_CLOCK_CHECKS) {
                watch.advance(step, steps);
            }
        }
        self.progress.state = moving.state();
        Ok(is_interrupted)
    }

    /// Collection of all fields of a run.
    pub(super) fn collection(&self) -> Files {
        self.collection_before(self.course.steps + 1)
    }

    /// Collection of the fields up to a step.
    fn collection_before(&self, end: u64) -> Files {
        let course = self.course;
        let steps = course.fields.iter().take_while(|step| **step < end);
        let times: Vec<f64> = steps.map(|step| *step as f64 * course.step).collect();
        if times.is_empty() {
            return Vec::new();
        }
        let names: Vec<String> = (0..times.len()).map(field_name).collect();
        let all = times.into_iter().zip(names.iter().map(String::as_str));
        vec![text("fields.pvd", vtk::pvd(all))]
    }

    /// Records the output that is due after a step.
    fn look(&mut self, moving: &mut dyn Moving, step: u64) -> Result<(), SimulateError> {
        let course = self.course;
        let time = step as f64 * course.step;
        let sampling = u64::from(course.sampling);
        let is_sampled = step.is_multiple_of(sampling) && step / sampling <= course.samples;
        let is_line = step.is_multiple_of(course.every) || step == course.steps;
        if is_sampled {
            self.progress.samples.push([time, moving.sample()]);
        }
        if is_line {
            let own = moving.line().map_err(|fault| self.failed(fault))?;
            self.progress.history.extend([step as f64, time]);
            self.progress.history.extend(own);
        }
        if self.place.is_some()
            && let Ok(number) = course.fields.binary_search(&step)
        {
            let field = moving.field().map_err(|fault| self.failed(fault))?;
            self.pending.push(text(field_name(number), field));
            if course.is_shown {
                self.progress.fields.extend(moving.state().displacements);
            }
        }
        Ok(())
    }

    fn is_due(&self, step: u64) -> bool {
        match self.place.map(|place| place.checkpoint) {
            None => false,
            Some(Some(steps)) => step.is_multiple_of(steps),
            Some(None) => {
                step.is_multiple_of(STEPS_BETWEEN_CLOCK_CHECKS)
                    && self.written.elapsed() >= CHECKPOINT_INTERVAL
            }
        }
    }

    /// Writes a checkpoint with all pending output.
    pub(super) fn keep(
        &mut self,
        moving: &dyn Moving,
        last: Files,
    ) -> Result<Vec<PathBuf>, SimulateError> {
        let Some(place) = self.place else {
            return Ok(Vec::new());
        };
        self.progress.state = moving.state();
        // The checkpoint is written last, so that everything it counts exists.
        let checkpoint = text(CHECKPOINT, self.progress.bytes(&self.course.mark));
        let written = self.write(place, last, Some(checkpoint))?;
        self.last = Some((place.folder.join(CHECKPOINT), self.progress.state.step));
        self.written = Instant::now();
        Ok(written)
    }

    /// Writes the fields and the history of a motion that breaks down in a step. The last checkpoint is kept.
    fn keep_broken(&mut self, step: u64) -> Result<(), SimulateError> {
        if let Some(place) = self.place {
            let collection = self.collection_before(step);
            self.write(place, collection, None)?;
        }
        Ok(())
    }

    /// Writes pending fields, other files, and the history.
    fn write(
        &mut self,
        place: &Place,
        others: Files,
        checkpoint: Option<(OsString, Content)>,
    ) -> Result<Vec<PathBuf>, SimulateError> {
        // An ended run, whose caller no longer waits for it, leaves the files to the next one.
        onset::cancel::checkpoint();
        let mut files = std::mem::take(&mut self.pending);
        files.extend(others);
        files.push(text(
            "history.csv",
            history(self.course, &self.progress.history),
        ));
        files.extend(checkpoint);
        let output = Output::at::<&str>(&place.folder, &[]);
        let written = output.and_then(|output| output.on(place.sheet.clone()).write(&files));
        written.map_err(|source| SimulateError::Output {
            source,
            checkpoint: self.last.clone(),
        })
    }

    /// Error for a motion that breaks down.
    pub(super) fn failed(&self, fault: Box<Fault>) -> SimulateError {
        let hint = match fault.ground {
            _ if self.course.step > self.course.critical => {
                "the step is above the largest stable step: omit --supercritical"
            }
            Ground::Method(MethodError::SingularMoment { .. }) => {
                "the particle has lost its neighbors: with discretization.corrected = false it would continue as a free particle"
            }
            Ground::NotFinite => {
                "choose a smaller --fraction: the motion has become too fast for the time step"
            }
            _ => self.course.grown,
        };
        SimulateError::Fault {
            fault,
            hint: hint.to_owned(),
            checkpoint: self.last.clone(),
        }
    }
}

/// Progress at the start, or at the checkpoint.
fn begun(course: &Course, place: Option<&Place>) -> Result<Progress, SimulateError> {
    let anew = Progress {
        state: course.start.clone(),
        ..Progress::default()
    };
    let Some(place) = place else {
        return Ok(anew);
    };
    let failed = |source| SimulateError::Output {
        source,
        checkpoint: None,
    };
    let path = place.folder.join(CHECKPOINT);
    let wrong = |what: String, hint| SimulateError::Checkpoint {
        path: path.clone(),
        what,
        hint,
    };
    if !place.is_resumed && path.exists() && !place.is_overwritten {
        return Err(wrong(
            "the folder already contains a checkpoint".to_owned(),
            "continue with --resume, start afresh with --overwrite, or choose another folder",
        ));
    }
    // A run that ended before its first checkpoint starts over.
    if !place.is_resumed || !path.exists() {
        // Tests that files can be written before the work starts.
        Output::at(&place.folder, &[CHECKPOINT, "history.csv"]).map_err(failed)?;
        return Ok(anew);
    }
    let bytes = input::bytes(&path, input::MOST_OUTPUT)
        .map_err(|error| wrong(format!("cannot read the checkpoint: {error}"), FRESH_START))?;
    Progress::of_bytes(&path, &bytes, &course.mark, &course.start)
}

/// History as a CSV table.
fn history(course: &Course, lines: &[f64]) -> String {
    let lines: Vec<&[f64]> = lines.chunks_exact(course.columns.len()).collect();
    let columns = course.columns.iter().enumerate();
    columns
        .fold(
            Table::new(&lines, course.units),
            |table, (n, (name, dimension))| table.with(name, dimension, move |line| line[n]),
        )
        .to_string()
}
