//! A run: steps, what is kept of them, and how it goes on after an end before the end. The same for patches and bodies.

use super::checkpoint::{CHECKPOINT, Progress};
use super::{SimulateError, fields};
use crate::input;
use crate::output::{Files, Output, text, write};
use onset::method::MethodError;
use onset::motion::{Fault, Ground, PatchState};
use std::fmt::Write;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// How often a checkpoint is written where nobody says after how many steps.
const INTERVAL: Duration = Duration::from_secs(5);
/// Steps between two looks at the clock.
const LOOK: u64 = 64;

/// Where a run is kept.
#[derive(Clone, Debug)]
pub struct Place {
    /// The folder.
    pub folder: PathBuf,
    /// Whether to go on from the checkpoint that is there.
    pub is_resumed: bool,
    /// Whether to begin anew in spite of it.
    pub is_overwritten: bool,
    /// Steps between checkpoints; some seconds when left out.
    pub checkpoint: Option<u64>,
}

/// Whoever watches a run.
pub trait Watch {
    /// So many steps are done, of so many.
    fn advance(&self, done: u64, all: u64);

    /// Whether the run shall end here.
    fn is_interrupted(&self) -> bool;
}

/// What is run, and how long, settled before the first step.
pub(super) struct Course {
    /// Marks the checkpoints of the run.
    pub(super) mark: String,
    /// Time.
    pub(super) step: f64,
    /// The largest stable step; time.
    pub(super) critical: f64,
    pub(super) steps: u64,
    /// Steps between lines of the history.
    pub(super) every: u64,
    /// Steps between samples of the record that is fitted, and how many there are at most.
    pub(super) sampling: u32,
    pub(super) samples: u64,
    /// The steps after which fields are written.
    pub(super) fields: Vec<u64>,
    /// Whether fields are kept for a page.
    pub(super) is_shown: bool,
    /// The columns of the history, step and time first.
    pub(super) columns: &'static [&'static str],
    pub(super) start: PatchState,
    /// What to do where the motion grows beyond its law.
    pub(super) grown: &'static str,
}

/// What moves.
pub(super) trait Moving {
    /// One step.
    fn advance(&mut self) -> Result<(), Box<Fault>>;

    /// The state.
    fn state(&self) -> PatchState;

    /// A line of the history, after step and time.
    fn line(&mut self) -> Result<Vec<f64>, Box<Fault>>;

    /// A sample of the record; of what is fitted only.
    fn sample(&self) -> f64;

    /// The particles as a field of VTK.
    fn field(&mut self) -> Result<String, Box<Fault>>;
}

/// A run, kept in its folder.
pub(super) struct Keeper<'a> {
    course: &'a Course,
    place: Option<&'a Place>,
    pub(super) progress: Progress,
    /// Fields that wait for the next checkpoint.
    pending: Files,
    /// The last checkpoint, and its step.
    last: Option<(PathBuf, u64)>,
    written: Instant,
}

impl<'a> Keeper<'a> {
    /// At the start, or at the checkpoint.
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

    /// All steps that are left; tells whether it was interrupted. What moves is in the state of [`Self::progress`].
    pub(super) fn follow(
        &mut self,
        moving: &mut dyn Moving,
        watch: &dyn Watch,
    ) -> Result<bool, SimulateError> {
        let steps = self.course.steps;
        if self.progress.history.is_empty() {
            self.look(moving, 0)?;
        }
        let mut is_interrupted = false;
        for step in self.progress.state.step + 1..=steps {
            if watch.is_interrupted() {
                is_interrupted = true;
                break;
            }
            moving.advance().map_err(|fault| self.failed(fault))?;
            self.look(moving, step)?;
            if self.is_due(step) {
                self.keep(moving, Vec::new())?;
                watch.advance(step, steps);
            } else if step.is_multiple_of(LOOK) {
                watch.advance(step, steps);
            }
        }
        self.progress.state = moving.state();
        Ok(is_interrupted)
    }

    /// The table of the fields, at the end of a run with some.
    pub(super) fn collection(&self) -> Files {
        let course = self.course;
        if course.fields.is_empty() {
            return Vec::new();
        }
        let times = course.fields.iter().map(|step| *step as f64 * course.step);
        vec![text("fields.pvd", fields::pvd(&times.collect::<Vec<_>>()))]
    }

    /// Takes down what is due after a step.
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
            self.pending.push(text(fields::name(number), field));
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
            Some(None) => step.is_multiple_of(LOOK) && self.written.elapsed() >= INTERVAL,
        }
    }

    /// Writes a checkpoint with all that belongs to it.
    pub(super) fn keep(
        &mut self,
        moving: &dyn Moving,
        last: Files,
    ) -> Result<Vec<PathBuf>, SimulateError> {
        let Some(place) = self.place else {
            return Ok(Vec::new());
        };
        self.progress.state = moving.state();
        let mut files = std::mem::take(&mut self.pending);
        files.extend(last);
        files.push(text(
            "history.csv",
            history(self.course.columns, &self.progress.history),
        ));
        // Last: whatever a checkpoint counts is there before it.
        files.push(text(CHECKPOINT, self.progress.bytes(&self.course.mark)));
        let written = write(&place.folder, &files).map_err(|source| SimulateError::Output {
            source,
            checkpoint: self.last.clone(),
        })?;
        self.last = Some((place.folder.join(CHECKPOINT), self.progress.state.step));
        self.written = Instant::now();
        Ok(written)
    }

    /// What to tell of a motion that ends.
    pub(super) fn failed(&self, fault: Box<Fault>) -> SimulateError {
        let hint = match fault.ground {
            _ if self.course.step > self.course.critical => {
                "the step is above the largest stable one: leave --supercritical out"
            }
            Ground::Method(MethodError::SingularMoment { .. }) => {
                "the particle has lost its neighbors: with discretization.corrected = false it flies on as it is"
            }
            Ground::NotFinite => "choose a smaller --fraction: the motion outgrew its step",
            _ => self.course.grown,
        };
        SimulateError::Fault {
            fault,
            hint: hint.to_owned(),
            checkpoint: self.last.clone(),
        }
    }
}

/// The start, or the checkpoint.
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
            "there is a checkpoint already".to_owned(),
            "go on with --resume, begin anew with --overwrite, or choose another folder",
        ));
    }
    // A run that was ended before its first checkpoint begins anew.
    if !place.is_resumed || !path.exists() {
        // That files can be written is tried before the work.
        Output::at(&place.folder, &[CHECKPOINT, "history.csv"]).map_err(failed)?;
        return Ok(anew);
    }
    let bytes = input::bytes(&path, input::MOST_OUTPUT).map_err(|error| {
        wrong(
            format!("cannot read the checkpoint: {error}"),
            "leave --resume out to begin",
        )
    })?;
    Progress::of_bytes(&path, &bytes, &course.mark, &course.start)
}

/// The history as a table.
fn history(columns: &[&str], lines: &[f64]) -> String {
    let mut table = columns.join(",") + "\n";
    for line in lines.chunks_exact(columns.len()) {
        let numbers: Vec<String> = line.iter().map(|number| format!("{number:e}")).collect();
        let _ = writeln!(table, "{},{}", line[0], numbers[1..].join(","));
    }
    table
}
