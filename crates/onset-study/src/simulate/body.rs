//! Run of a body with grips.

use super::SimulateError;
use super::picture::{MAX_DRAWN_PARTICLES, figure};
use super::plan::{
    DEFAULT_STEP_FRACTION, Duration, Pace, checked, every, fields, mark, refused, stable,
};
use super::run::{Course, Keeper, Moving, Place, Watch, grid};
use super::states::stresses;
use crate::answers::{Problem, notes_on_patch};
use crate::csv::Table;
use crate::number::{counted, told};
use crate::output::picture;
use crate::settings::{BodySettings, Effective};
use onset::kinematics::DeformationGradient;
use onset::motion::{BodyError, BodyMotion, BodyQuantities, Fault, PatchState, Start};
use serde::Serialize;
use serde_json::json;
use std::fmt;
use std::path::PathBuf;

/// Columns of the history of a body.
const COLUMNS: &[(&str, &str)] = &[
    ("step", "1"),
    ("time", "time"),
    ("kinetic_energy", "energy"),
    ("strain_energy", "energy"),
    ("energy", "energy"),
    ("work_of_grips", "energy"),
    ("momentum_1", "momentum"),
    ("momentum_2", "momentum"),
    ("momentum_3", "momentum"),
    ("angular_momentum_1", "momentum"),
    ("angular_momentum_2", "momentum"),
    ("angular_momentum_3", "momentum"),
    ("largest_displacement", "length"),
    ("smallest_volume_ratio", "1"),
    ("largest_volume_ratio", "1"),
];

/// Body to be run, with its start and duration.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyQuestion {
    /// Body and grips of the study.
    pub body: BodySettings,
    /// Homogeneous deformation at the start; `None` for the reference configuration.
    pub f: Option<DeformationGradient>,
    /// Largest random displacement along each axis at the start, in particle spacings.
    pub amplitude: f64,
    /// Seed of the random displacements.
    pub seed: u64,
    /// Duration, step size and output of the run.
    pub pace: Pace,
}

impl BodyQuestion {
    fn start(&self) -> DeformationGradient {
        self.f.unwrap_or_else(DeformationGradient::identity)
    }
}

/// Results of the run of a body.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BodyAnswer {
    /// Whether the run was interrupted.
    pub interrupted: bool,
    /// Number of particles in the body.
    pub particles: usize,
    /// Memory of the engine per particle; bytes.
    pub bytes_per_particle: f64,
    /// Time step of the run; time.
    pub time_step: f64,
    /// Lower bound on the largest stable time step at the start; time.
    pub critical_time_step: f64,
    /// Number of steps requested.
    pub steps: u64,
    /// Number of steps taken.
    pub steps_taken: u64,
    /// Kinetic energy at the end; energy, in 2D per unit thickness.
    pub kinetic_energy: f64,
    /// Strain energy at the end; energy, in 2D per unit thickness.
    pub strain_energy: f64,
    /// Work of the grips up to the end; energy, in 2D per unit thickness.
    pub work_of_grips: f64,
    /// Relative drift of the energy balance in the history.
    ///
    /// The largest change of kinetic plus strain energy minus the work of the grips, divided by the largest of these magnitudes. With a penalty the drift
    /// includes the work of the penalty forces, which have no potential.
    pub energy_drift: f64,
    /// Largest displacement of a particle in the history; length.
    pub largest_displacement: f64,
    /// Smallest and largest volume ratio of a particle in the history.
    pub volume_ratios: [f64; 2],
    /// Notes on law and method.
    pub notes: Vec<String>,
    /// All settings in effect.
    pub settings: Effective,
    /// Paths of the files written.
    #[serde(skip)]
    pub files: Vec<PathBuf>,
}

/// Runs a body, and writes its results into a folder if one is given.
///
/// # Errors
/// [`SimulateError`] for a body that cannot be run, a motion that breaks down, or files that cannot be written.
pub fn run_body(
    problem: &Problem,
    question: &BodyQuestion,
    place: Option<&Place>,
    watch: &dyn Watch,
) -> Result<BodyAnswer, SimulateError> {
    problem.settings.material.check_moves()?;
    let material = &problem.settings.material;
    if material.is_primary() {
        return Err(refused(
            "particles of a body unload, and without `material.mullins-energy` every state of the law is reached by primary loading".to_owned(),
            "set material.mullins-energy, the largest energy of the past, which stays constant in the run",
        ));
    }
    if problem.material.is_path_dependent() {
        return Err(refused(
            format!(
                "`{}` cannot be run in a body: its particles do not store the path that determines their stress",
                material.model.name()
            ),
            "choose a law with an energy: `onset list materials`",
        ));
    }
    let dimension = problem.dimension();
    let spacing = problem.analysis.spacing();
    question
        .body
        .check_units(problem.settings.effective().units())?;
    let particles = question.body.particles(dimension, spacing)?;
    let grips = question.body.grips(dimension, spacing)?;
    let contact = question.body.contact();
    let mut answer = None;
    problem
        .analysis
        .with_body(&particles, &grips, contact, &mut |body| {
            let decisive = json!({
                "version": env!("CARGO_PKG_VERSION"),
                "settings": problem.settings.effective(),
                "particles": format!("{particles:?}"),
                "grips": format!("{grips:?}"),
                "contact": contact.map(|contact| contact.stiffness),
                "state": question.start().components(),
                "amplitude": question.amplitude,
                "seed": question.seed,
            });
            let course = course(problem, question, body, decisive);
            answer =
                Some(course.and_then(|course| run(problem, question, &course, body, place, watch)));
        })?;
    answer.unwrap_or(Err(BodyError::Empty.into()))
}

fn course(
    problem: &Problem,
    question: &BodyQuestion,
    body: &mut dyn BodyMotion,
    mut decisive: serde_json::Value,
) -> Result<Course, SimulateError> {
    let start = Start {
        f: question.start(),
        noise: question.amplitude * problem.analysis.spacing(),
        seed: question.seed,
    };
    let unstarted = |fault| {
        SimulateError::Fault {
        fault,
        hint: "the initial state is already inadmissible: choose a smaller --amplitude, or another --stretch"
            .to_owned(),
        checkpoint: None,
    }
    };
    body.start(&start, 0.0).map_err(unstarted)?;
    let critical = body.critical_time_step().map_err(unstarted)?;
    let step = match (question.pace.time_step, question.pace.fraction) {
        (Some(step), _) => step,
        (None, fraction) => fraction.unwrap_or(DEFAULT_STEP_FRACTION) * critical,
    };
    if !step.is_finite() {
        return Err(refused(
            "no motion of the body oscillates, so that no largest stable step exists",
            "give --time-step",
        ));
    }
    let step = stable(step, critical, question.pace.is_supercritical)?;
    let steps = match question.pace.duration {
        Duration::Steps(count) => checked(count as f64, step)?,
        Duration::Time(time) => checked((time / step).round(), step)?,
        Duration::Natural => {
            return Err(refused(
                "the body needs a duration",
                "set --steps or --time",
            ));
        }
    };
    let every = every(question.pace.every, steps)?;
    let fields = fields(question.pace.fields, steps);
    body.start(&start, step).map_err(unstarted)?;
    decisive["run"] = json!({ "step": step, "steps": steps, "every": every, "fields": fields });
    Ok(Course {
        mark: mark(&decisive),
        step,
        critical,
        steps,
        every,
        sampling: 1,
        samples: 0,
        fields,
        is_shown: false,
        columns: COLUMNS,
        units: problem.settings.effective().units(),
        start: body.state(),
        grown: "the body is deformed beyond its law, or zero-energy modes have grown: stretch it less, refine it, or set a discretization.penalty",
    })
}

fn run(
    problem: &Problem,
    question: &BodyQuestion,
    course: &Course,
    body: &mut dyn BodyMotion,
    place: Option<&Place>,
    watch: &dyn Watch,
) -> Result<BodyAnswer, SimulateError> {
    let mut keeper = Keeper::begun(course, place)?;
    body.put(&keeper.progress.state, &question.start());
    let mut moving = MovingBody {
        problem,
        places: body.positions(),
        step: course.step,
        body,
    };
    let is_interrupted = keeper.follow(&mut moving, watch)?;
    let mut last = Vec::new();
    if !is_interrupted {
        last = keeper.collection();
        if place.is_some() && problem.dimension() == 2 && moving.places.len() <= MAX_DRAWN_PARTICLES
        {
            // If the run was already complete, no forces have been evaluated yet.
            let evaluated = moving.body.quantities(course.step);
            evaluated.map_err(|fault| keeper.failed(fault))?;
            let time = course.step * course.steps as f64;
            let units = problem.settings.effective().units();
            last.push(picture("body", figure(&*moving.body, time, units)));
        }
    }
    let files = keeper.keep(&moving, last)?;
    let lines = || keeper.progress.history.chunks_exact(COLUMNS.len());
    let largest = |of: &dyn Fn(&[f64]) -> f64| lines().map(of).fold(0.0, f64::max);
    let kept = |line: &[f64]| line[4] - line[5];
    let first = lines().next().map_or(0.0, kept);
    let size = largest(&|line| line[2].abs() + line[3].abs() + line[5].abs());
    let changed = largest(&|line| (kept(line) - first).abs());
    let end = lines().last().unwrap_or(&[0.0; 15]).to_vec();
    Ok(BodyAnswer {
        interrupted: is_interrupted,
        particles: moving.places.len(),
        bytes_per_particle: moving.body.bytes_per_particle(),
        time_step: course.step,
        critical_time_step: course.critical,
        steps: course.steps,
        steps_taken: keeper.progress.state.step,
        kinetic_energy: end[2],
        strain_energy: end[3],
        work_of_grips: end[5],
        energy_drift: if size > 0.0 { changed / size } else { 0.0 },
        largest_displacement: largest(&|line| line[12]),
        volume_ratios: [
            lines().map(|line| line[13]).fold(f64::INFINITY, f64::min),
            largest(&|line| line[14]),
        ],
        notes: notes_on_patch(&problem.settings, &*problem.material),
        settings: problem.settings.effective(),
        files,
    })
}

struct MovingBody<'a> {
    problem: &'a Problem,
    places: Vec<[f64; 3]>,
    step: f64,
    body: &'a mut dyn BodyMotion,
}

impl Moving for MovingBody<'_> {
    fn advance(&mut self) -> Result<(), Box<Fault>> {
        self.body.advance(self.step)
    }

    fn state(&self) -> PatchState {
        self.body.state()
    }

    fn line(&mut self) -> Result<Vec<f64>, Box<Fault>> {
        let BodyQuantities {
            kinetic,
            strain,
            work,
            momentum,
            angular_momentum,
            largest,
            volume_ratios,
        } = self.body.quantities(self.step)?;
        let mut line = vec![kinetic, strain, kinetic + strain, work];
        line.extend(momentum);
        line.extend(angular_momentum);
        line.push(largest);
        line.extend(volume_ratios);
        Ok(line)
    }

    fn sample(&self) -> f64 {
        0.0
    }

    fn field(&mut self) -> Result<String, Box<Fault>> {
        self.body.quantities(self.step)?;
        let f = self.body.deformations();
        let of = |value: &dyn Fn(&[[f64; 3]; 3]) -> f64| f.iter().map(value).collect::<Vec<_>>();
        let ratio = |f: &[[f64; 3]; 3]| DeformationGradient::from_components(*f).determinant();
        // The Green-Lagrange shear strain of the first two axes.
        let shear = |f: &[[f64; 3]; 3]| 0.5 * (0..3).map(|i| f[i][0] * f[i][1]).sum::<f64>();
        let (ratios, shears) = (of(&ratio), of(&shear));
        let state = self.body.state();
        let mut positions = Vec::new();
        let reference = self.body.positions();
        let dimension = self.body.dimension();
        let mut grid = grid(dimension, &self.places, reference, &state, &mut positions);
        let flat = |f: &[[f64; 3]; 3]| std::array::from_fn(|n| f[n / 3][n % 3]);
        let gradients: Vec<[f64; 9]> = f.iter().map(flat).collect();
        let stresses = stresses(self.problem, &gradients);
        grid.matrices = vec![("F", gradients), ("stress", stresses)];
        grid.scalars = vec![("volume_ratio", &ratios), ("shear_strain", &shears)];
        Ok(grid.vtu())
    }
}

impl BodyAnswer {
    /// The run as CSV, in one row.
    pub fn csv(&self) -> String {
        Table::new(std::slice::from_ref(self), self.settings.units())
            .with("particles", "1", |own| own.particles)
            .with("time_step", "time", |own| own.time_step)
            .with("critical_time_step", "time", |own| own.critical_time_step)
            .with("steps", "1", |own| own.steps)
            .with("steps_taken", "1", |own| own.steps_taken)
            .with("kinetic_energy", "energy", |own| own.kinetic_energy)
            .with("strain_energy", "energy", |own| own.strain_energy)
            .with("work_of_grips", "energy", |own| own.work_of_grips)
            .with("energy_drift", "1", |own| own.energy_drift)
            .with("largest_displacement", "length", |own| {
                own.largest_displacement
            })
            .with("smallest_volume_ratio", "1", |own| own.volume_ratios[0])
            .with("largest_volume_ratio", "1", |own| own.volume_ratios[1])
            .to_string()
    }
}

impl fmt::Display for BodyAnswer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let units = self.settings.units();
        writeln!(
            formatter,
            "body         {}, {:.0} bytes each",
            counted(self.particles, "particle"),
            self.bytes_per_particle
        )?;
        writeln!(
            formatter,
            "run          {} of {} steps of {} ({} of the largest stable step), central-differences",
            self.steps_taken,
            self.steps,
            units.of(told(self.time_step), "s"),
            told(self.time_step / self.critical_time_step),
        )?;
        writeln!(
            formatter,
            "energy       kinetic {}, strain {}, work of grips {}; drift {:.1e}",
            told(self.kinetic_energy),
            told(self.strain_energy),
            told(self.work_of_grips),
            self.energy_drift
        )?;
        let [low, high] = self.volume_ratios;
        writeln!(
            formatter,
            "deformation  displacements up to {}, volume ratios from {} to {}",
            units.of(told(self.largest_displacement), "m"),
            told(low),
            told(high)
        )?;
        for note in &self.notes {
            writeln!(formatter, "\nnote: {note}")?;
        }
        write!(formatter, "\n{}", self.settings)
    }
}
