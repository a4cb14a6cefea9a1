//! Run of a patch around a homogeneous state, compared with its prediction.

use super::page::page;
use super::plan::Plan;
use super::run::{Keeper, Moving, Place, Watch, grid};
use super::states::{PatchNeighborhoods, stresses};
use super::{Question, SimulateAnswer, SimulateError};
use crate::answers::Problem;
use crate::methods::reduced;
use crate::output::{picture, text};
use onset::method::MethodError;
use onset::motion::{Fault, PatchMotion, PatchState};

/// Runs a patch, and writes its results into a folder if one is given.
///
/// # Errors
/// [`SimulateError`] for a patch that cannot be run, a motion that breaks down, or files that cannot be written.
pub fn simulate(
    problem: &Problem,
    question: &Question,
    place: Option<&Place>,
    watch: &dyn Watch,
) -> Result<SimulateAnswer, SimulateError> {
    problem.settings.material.check_moves()?;
    // Patches are built from the cell in the settings, not from a reduced cell.
    let described = match reduced(&problem.settings) {
        Some(_) => Some(problem.described()?),
        None => None,
    };
    let problem = described.as_ref().unwrap_or(problem);
    let cells = question.patch(problem)?;
    let mut answer = None;
    problem
        .analysis
        .with_motion(&question.f, &cells, &mut |patch| {
            let plan = Plan::new(problem, question, patch, cells.clone());
            answer = Some(plan.and_then(|plan| run(problem, question, &plan, patch, place, watch)));
        })?;
    answer.unwrap_or(Err(SimulateError::Method(MethodError::NotFinite)))
}

fn run(
    problem: &Problem,
    question: &Question,
    plan: &Plan,
    patch: &mut dyn PatchMotion,
    place: Option<&Place>,
    watch: &dyn Watch,
) -> Result<SimulateAnswer, SimulateError> {
    let mut keeper = Keeper::begun(&plan.course, place)?;
    patch.put(&keeper.progress.state);
    let mut moving = MovingPatch {
        problem,
        question,
        plan,
        neighborhoods: None,
        places: current(question, patch),
        patch,
    };
    let is_interrupted = keeper.follow(&mut moving, watch)?;
    let mut answer = SimulateAnswer::new(problem, question, plan, &*moving.patch, &keeper.progress);
    answer.interrupted = is_interrupted;
    let mut last = Vec::new();
    if !is_interrupted {
        last = keeper.collection();
        last.push(picture("simulate", answer.figure()));
        if plan.course.is_shown {
            let spacing = problem.analysis.spacing();
            let page = page(&answer, &moving.places, &keeper.progress.fields, spacing);
            last.push(text("simulate.html", page));
        }
    }
    answer.files = keeper.keep(&moving, last)?;
    Ok(answer)
}

/// Positions of the particles in the homogeneous state; length.
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

struct MovingPatch<'a> {
    problem: &'a Problem,
    question: &'a Question,
    plan: &'a Plan,
    /// Neighborhoods for gradients in fields, from the first field on.
    neighborhoods: Option<PatchNeighborhoods>,
    /// Positions of the particles in the homogeneous state.
    places: Vec<[f64; 3]>,
    patch: &'a mut dyn PatchMotion,
}

impl Moving for MovingPatch<'_> {
    fn advance(&mut self) -> Result<(), Box<Fault>> {
        self.patch.advance(self.plan.stepper, self.plan.course.step)
    }

    fn state(&self) -> PatchState {
        self.patch.state()
    }

    fn line(&mut self) -> Result<Vec<f64>, Box<Fault>> {
        let own = self
            .patch
            .quantities(self.plan.stepper, self.plan.course.step)?;
        let [px, py, pz] = own.momentum;
        Ok(vec![
            own.kinetic,
            own.potential,
            own.kinetic + own.potential,
            px,
            py,
            pz,
            own.largest,
            self.sample(),
        ])
    }

    fn sample(&self) -> f64 {
        self.patch.amplitude(&self.plan.wave)
    }

    fn field(&mut self) -> Result<String, Box<Fault>> {
        let state = self.patch.state();
        let (dimension, reference) = (self.patch.dimension(), self.patch.positions());
        let neighborhoods = self.neighborhoods.get_or_insert_with(|| {
            PatchNeighborhoods::new(self.problem, &reference, &self.plan.cells)
        });
        let mut positions = Vec::new();
        let mut grid = grid(dimension, &self.places, reference, &state, &mut positions);
        let gradients = neighborhoods.gradients(grid.points, &self.question.f);
        let stresses = stresses(self.problem, &gradients);
        grid.matrices = vec![("F", gradients), ("stress", stresses)];
        Ok(grid.vtu())
    }
}
