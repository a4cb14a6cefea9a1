//! A run: steps, what is kept of them, and how it goes on after an end before the end.

use super::checkpoint::{CHECKPOINT, Line, Progress};
use super::page::page;
use super::plan::Plan;
use super::{Question, SimulateAnswer, SimulateError, fields};
use crate::answers::Problem;
use crate::output::{Files, Output, text, write};
use onset::motion::{Fault, Ground, PatchMotion};
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

/// Runs a patch; into a folder, where there is one.
///
/// # Errors
/// [`SimulateError`] for a question that cannot be run, a motion that breaks down, and files that cannot be written.
pub fn simulate(
    problem: &Problem,
    question: &Question,
    place: Option<&Place>,
    watch: &dyn Watch,
) -> Result<SimulateAnswer, SimulateError> {
    let cells = question.patch(problem)?;
    let mut answer = None;
    problem
        .analysis
        .with_motion(&question.f, &cells, &mut |patch| {
            let plan = Plan::new(problem, question, patch, cells.clone());
            answer = Some(plan.and_then(|plan| run(problem, question, &plan, patch, place, watch)));
        })?;
    answer.unwrap_or(Err(SimulateError::Method(
        onset::method::MethodError::NotFinite,
    )))
}

fn run(
    problem: &Problem,
    question: &Question,
    plan: &Plan,
    patch: &mut dyn PatchMotion,
    place: Option<&Place>,
    watch: &dyn Watch,
) -> Result<SimulateAnswer, SimulateError> {
    let mut progress = begun(plan, place)?;
    patch.put(&progress.state);
    let mut keeper = Keeper {
        plan,
        place,
        places: current(question, patch),
        pending: Vec::new(),
        last: None,
        written: Instant::now(),
    };
    if progress.history.is_empty() {
        keeper.looked_at(patch, 0, &mut progress)?;
    } else {
        keeper.last = place.map(|place| (place.folder.join(CHECKPOINT), progress.state.step));
    }
    let mut is_interrupted = false;
    for step in progress.state.step + 1..=plan.steps {
        if watch.is_interrupted() {
            is_interrupted = true;
            break;
        }
        patch
            .advance(plan.stepper, plan.step)
            .map_err(|fault| keeper.failed(fault))?;
        keeper.looked_at(patch, step, &mut progress)?;
        if keeper.is_due(step) {
            keeper.keep(patch, &mut progress, Vec::new())?;
            watch.advance(step, plan.steps);
        } else if step.is_multiple_of(LOOK) {
            watch.advance(step, plan.steps);
        }
    }
    progress.state = patch.state();
    let mut answer = SimulateAnswer::new(problem, question, plan, patch, &progress);
    answer.interrupted = is_interrupted;
    let last = match is_interrupted || plan.fields.is_empty() {
        true => Vec::new(),
        false => {
            let times = plan.fields.iter().map(|step| *step as f64 * plan.step);
            let pvd = fields::pvd(&times.collect::<Vec<_>>());
            let mut last = vec![text("fields.pvd", pvd)];
            if plan.is_shown() {
                let spacing = problem.analysis.spacing();
                let page = page(&answer, &keeper.places, &progress.fields, spacing);
                last.push(text("simulate.html", page));
            }
            last
        }
    };
    answer.files = keeper.keep(patch, &mut progress, last)?;
    Ok(answer)
}

/// The start, or the checkpoint.
fn begun(plan: &Plan, place: Option<&Place>) -> Result<Progress, SimulateError> {
    let anew = Progress {
        state: plan.start.clone(),
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
    if !place.is_resumed {
        if path.exists() && !place.is_overwritten {
            return Err(wrong(
                "there is a checkpoint already".to_owned(),
                "go on with --resume, begin anew with --overwrite, or choose another folder",
            ));
        }
        // That files can be written is tried before the work.
        Output::at(&place.folder, &[CHECKPOINT, "history.csv"]).map_err(failed)?;
        return Ok(anew);
    }
    let bytes = std::fs::read(&path).map_err(|error| {
        wrong(
            format!("cannot read the checkpoint: {error}"),
            "leave --resume out to begin",
        )
    })?;
    Progress::of_bytes(&path, &bytes, &plan.mark, plan.start.displacements.len())
}

/// Where the particles of the homogeneous state are; length.
fn current(question: &Question, patch: &dyn PatchMotion) -> Vec<[f64; 3]> {
    let f = question.f.components();
    let dimension = patch.dimension();
    let moved = |x: [f64; 3]| {
        std::array::from_fn(|i| match i < dimension {
            true => (0..dimension).map(|j| f[i][j] * x[j]).sum(),
            false => 0.0,
        })
    };
    patch.positions().into_iter().map(moved).collect()
}

/// What keeps a run in its folder.
struct Keeper<'a> {
    plan: &'a Plan,
    place: Option<&'a Place>,
    /// Of the homogeneous state.
    places: Vec<[f64; 3]>,
    /// Fields that wait for the next checkpoint.
    pending: Files,
    /// The last checkpoint, and its step.
    last: Option<(PathBuf, u64)>,
    written: Instant,
}

impl Keeper<'_> {
    /// Takes down what is due after a step.
    fn looked_at(
        &mut self,
        patch: &dyn PatchMotion,
        step: u64,
        progress: &mut Progress,
    ) -> Result<(), SimulateError> {
        let plan = self.plan;
        let time = step as f64 * plan.step;
        let sampling = u64::from(plan.sampling);
        let is_sampled = step.is_multiple_of(sampling) && step / sampling <= plan.samples;
        let is_line = step.is_multiple_of(plan.every) || step == plan.steps;
        if is_sampled {
            progress.samples.push([time, patch.amplitude(&plan.wave)]);
        }
        if is_line {
            let own = patch.quantities(plan.stepper, plan.step);
            let own = own.map_err(|fault| self.failed(fault))?;
            let [px, py, pz] = own.momentum;
            progress.history.push([
                step as f64,
                time,
                own.kinetic,
                own.potential,
                own.kinetic + own.potential,
                px,
                py,
                pz,
                own.largest,
                patch.amplitude(&plan.wave),
            ]);
        }
        if self.place.is_some()
            && let Ok(number) = plan.fields.binary_search(&step)
        {
            let state = patch.state();
            let field = fields::vtu(patch.dimension(), &self.places, &state);
            self.pending.push(text(fields::name(number), field));
            if plan.is_shown() {
                progress.fields.extend(state.displacements);
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
    fn keep(
        &mut self,
        patch: &dyn PatchMotion,
        progress: &mut Progress,
        last: Files,
    ) -> Result<Vec<PathBuf>, SimulateError> {
        let Some(place) = self.place else {
            return Ok(Vec::new());
        };
        progress.state = patch.state();
        let mut files = std::mem::take(&mut self.pending);
        files.extend(last);
        files.push(text("history.csv", history(&progress.history)));
        // Last: whatever a checkpoint counts is there before it.
        files.push(text(CHECKPOINT, progress.bytes(&self.plan.mark)));
        let written = write(&place.folder, &files).map_err(|source| SimulateError::Output {
            source,
            checkpoint: self.last.clone(),
        })?;
        self.last = Some((place.folder.join(CHECKPOINT), progress.state.step));
        self.written = Instant::now();
        Ok(written)
    }

    fn failed(&self, fault: Box<Fault>) -> SimulateError {
        let hint = match fault.ground {
            _ if self.plan.step > self.plan.critical => {
                "the step is above the largest stable one: leave --supercritical out"
            }
            Ground::NotFinite => "choose a smaller --fraction: the motion outgrew its step",
            _ => {
                "a wave that grows has left the small perturbations, or --amplitude is large: choose fewer --steps or a smaller --amplitude"
            }
        };
        SimulateError::Fault {
            fault,
            hint: hint.to_owned(),
            checkpoint: self.last.clone(),
        }
    }
}

/// The history as a table.
fn history(lines: &[Line]) -> String {
    let mut table = String::from(
        "step,time,kinetic_energy,potential_energy,energy,momentum_1,momentum_2,momentum_3,largest_displacement,amplitude\n",
    );
    for line in lines {
        let numbers: Vec<String> = line.iter().map(|number| format!("{number:e}")).collect();
        let _ = writeln!(table, "{},{}", line[0], numbers[1..].join(","));
    }
    table
}
