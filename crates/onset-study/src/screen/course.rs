//! Evaluation of a run: short waves predicted from the states of the particles, and short waves in the positions.

use super::actual::{Actual, Nearest, placed};
use super::agreement::Agreement;
use super::answer::Cause;
use super::neighborhoods::Neighborhoods;
use super::states::{StateRates, States, without_rotation};
use super::{Frame, Question, Run, ScreenError};
use crate::answers::{Problem, ProblemError};
use crate::methods::method;
use crate::number::{counted, told, told_with};
use nalgebra::{Matrix3, Vector3};
use onset::analysis::body_mode;
use onset::kinematics::DeformationGradient;
use onset::motion::BodyMode;
use onset::time_step::Stepping;
use rayon::prelude::*;
use serde::Serialize;
use std::cmp::Ordering;

/// Smallest integral of the growth rate that counts as growth: amplitudes have grown by five percent.
const INTEGRAL_AT_BEGINNING: f64 = 0.05;
/// Largest integral whose exponential is finite for all seeds.
const LARGEST_INTEGRAL: f64 = 500.0;
/// Largest amplitude of short waves, in spacings, at which the state of a particle is evaluated. Beyond it the neighbors have changed.
const FINAL_AMPLITUDE: f64 = 0.5;
/// Smallest acoustic eigenvalue of a strongly elliptic material, divided by its modulus; smaller values are rounding.
const ELLIPTICITY_ROUNDING: f64 = 1e-9;
/// Largest acoustic eigenvalue at which a state counts as at the limit of ellipticity, divided by the modulus.
pub(super) const ELLIPTIC_MARGIN: f64 = 0.02;
/// Smallest and largest distance of the points between which the variation of the strain is measured; spacings.
const VARIATION_SPACINGS: [f64; 2] = [2.0, 4.0];
/// Amplitude of short waves in an exact lattice; spacings.
const EXACT_LATTICE_AMPLITUDE: f64 = 1e-10;
/// Smallest motion of the neighbors of a particle that stands still, as the mean of their displacements; spacings.
const STILL_MOTION: f64 = 0.1;
/// Radius of neighborhoods in spacings, for methods without a support radius.
const RADIUS: f64 = 2.01;

/// Quantities of the run at the time of a frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Moment {
    /// Time of the frame.
    pub time: f64,
    /// Largest predicted amplitude of growing waves; spacings.
    pub predicted: f64,
    /// Predicted amplitude of the oscillation caused by a too large time step; spacings.
    pub predicted_by_step: f64,
    /// Largest amplitude of short waves in the positions; spacings.
    pub observed: f64,
    /// Root mean square of the amplitudes of short waves in the positions; spacings.
    pub observed_mean: f64,
    /// Smallest acoustic eigenvalue, divided by the modulus of the reference configuration; `None` if no particle has a state.
    pub acoustic: Option<f64>,
    /// Largest growth rate of a wave; 1/time. `None` if no particle has a state.
    pub growth: Option<f64>,
    /// Time step divided by the largest stable step of the body; `None` without a time step.
    pub step_ratio: Option<f64>,
    /// Number of points without a state: inverted, with too few neighbors, or outside the domain of the law or the method.
    pub undefined: usize,
}

/// Point and time at which an event first occurs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// Time, interpolated between the frames.
    pub time: f64,
    /// Times of the frames before and after the event.
    pub window: [f64; 2],
    /// Row of the particle or cell, from 0 in the order of the first frame.
    pub point: usize,
    /// Number of the particle in the files; `None` for cells, and for files without numbers.
    pub particle: Option<u64>,
    /// Reference position of the point; length.
    pub place: [f64; 3],
    /// Deformation gradient without rotation.
    pub f: [[f64; 3]; 3],
}

/// Limit of the time step of the body.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepLimit {
    /// Largest stable step of the infinite lattice in the reference state; time.
    pub lattice: f64,
    /// Largest stable step of the body in the reference state; time. `None` for methods whose particles have no forces at arbitrary positions.
    pub body: Option<f64>,
    /// Smallest value of the largest stable step during the run, up to the first event; time.
    pub least: f64,
    /// Time at which the step of the run first exceeds the largest stable step; `None` if it never does.
    pub exceeded: Option<f64>,
    /// Largest stable step at this time; time. Later states are distorted by the oscillation. `None` if the step never exceeds it.
    pub at_excess: Option<f64>,
    /// Growth rate of the fastest oscillation when the step first exceeds the largest stable step; 1/time.
    pub growth: f64,
    /// Particle that limits the step; `None` for methods whose particles have no forces at arbitrary positions.
    pub particle: Option<usize>,
    /// Reference position of `particle`; length. `None` without such a particle.
    pub place: Option<[f64; 3]>,
}

impl StepLimit {
    /// Largest stable step when the step of the run first exceeds it, otherwise its smallest value during the run; time.
    pub fn decisive(&self) -> f64 {
        self.at_excess.unwrap_or(self.least)
    }
}

/// All measured and predicted quantities of a run.
pub(super) struct Course {
    pub(super) moments: Vec<Moment>,
    /// First loss of strong ellipticity.
    pub(super) lost: Option<Event>,
    /// First predicted amplitude above the threshold, with the growth rates there.
    pub(super) grown: Option<(Event, StateRates)>,
    /// First amplitude in the positions above the threshold.
    pub(super) observed: Option<Event>,
    pub(super) step: Option<StepLimit>,
    /// Amplitude of the short waves when growth begins; spacings.
    pub(super) seed: f64,
    /// Number of points with states, and number of points near held particles without states.
    pub(super) points: [usize; 2],
    /// Length over which the strain varies at the first loss of ellipticity; spacings. `None` if ellipticity is not lost.
    pub(super) variation: Option<f64>,
    /// Number of states that were evaluated.
    pub(super) states: usize,
    /// Fraction of points that have fewer than nine tenths of the largest number of neighbors.
    pub(super) cut: f64,
    /// Rates of the point whose waves had grown most when the first short waves were observed.
    pub(super) growing: Option<StateRates>,
    /// Largest integral of a growth rate before the first short waves.
    pub(super) grown_until_observed: f64,
    /// Clauses about points without a state, and about particles that stand still.
    pub(super) lacking: Vec<String>,
    /// Differences of gradients and stresses in the files.
    pub(super) notes: Vec<String>,
    /// Time of each frame, and the stretch tensor of the point whose waves have grown most.
    pub(super) leading: Vec<(f64, Matrix3<f64>)>,
    /// Frames at which events first occur.
    pub(super) pictures: Vec<Picture>,
    /// Lowest modes of the body in a frame.
    pub(super) actual: Option<Actual>,
    /// Whether later frames of arrays are skipped.
    pub(super) is_cut_short: bool,
}

/// Positions and short waves at one time.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Picture {
    pub(super) time: f64,
    pub(super) x: Vec<[f64; 3]>,
    pub(super) observed: Vec<f64>,
}

/// Points of a run that have states: its particles or its elements.
struct Points {
    nodes: Neighborhoods,
    /// Neighborhoods of cells: gradients of the nodes of each cell about their mean.
    cells: Option<Vec<Vec<usize>>>,
    places: Vec<[f64; 3]>,
}

impl Points {
    fn new(run: &Run, dimension: usize, radius: f64) -> Self {
        let nodes = Neighborhoods::new(&run.reference, dimension, radius);
        let places = match &run.cells {
            None => run.reference.clone(),
            Some(cells) => cells
                .iter()
                .map(|cell| mean(cell, &run.reference))
                .collect(),
        };
        Self {
            nodes,
            cells: run.cells.clone(),
            places,
        }
    }

    /// Length over which the strain of a point varies by itself: its norm, divided by the largest change per length up to points at some distance;
    /// spacings. Points that are closer are not compared, because short waves change their strain. `None` without points with another stretch.
    fn variation(&self, point: usize, stretches: &[Option<Matrix3<f64>>]) -> Option<f64> {
        let own = stretches[point]?;
        let spacing = super::input::spacing(&self.places, self.nodes.dimension());
        let place = Vector3::from(self.places[point]);
        let change = stretches
            .iter()
            .zip(&self.places)
            .filter_map(|(other, at)| {
                let apart = (Vector3::from(*at) - place).norm() / spacing;
                let is_compared = (VARIATION_SPACINGS[0]..=VARIATION_SPACINGS[1]).contains(&apart);
                let other = other.filter(|_| is_compared)?;
                Some((other - own).norm() / apart)
            });
        let change = change.fold(0.0, f64::max);
        let strain = (own - Matrix3::identity()).norm();
        (change > 0.0).then(|| strain / change)
    }

    fn deformation(
        &self,
        point: usize,
        dimension: usize,
        reference: &[[f64; 3]],
        x: &[[f64; 3]],
    ) -> Option<Matrix3<f64>> {
        let Some(cells) = &self.cells else {
            return self.nodes.deformation(point, x);
        };
        // Least squares over the corners about their mean: the mean gradient of parallelograms and simplices.
        let cell = &cells[point];
        let (from, to) = (mean(cell, reference), mean(cell, x));
        let (mut moment, mut mixed) = (Matrix3::zeros(), Matrix3::zeros());
        for node in cell {
            for i in 0..dimension {
                let a = reference[*node][i] - from[i];
                for j in 0..dimension {
                    moment[(i, j)] += a * (reference[*node][j] - from[j]);
                    mixed[(i, j)] += (x[*node][i] - to[i]) * (reference[*node][j] - from[j]);
                }
            }
        }
        for axis in dimension..3 {
            moment[(axis, axis)] = 1.0;
            mixed[(axis, axis)] = 1.0;
        }
        Some(mixed * moment.try_inverse()?)
    }
}

fn mean(cell: &[usize], x: &[[f64; 3]]) -> [f64; 3] {
    let sum = |axis: usize| cell.iter().map(|node| x[*node][axis]).sum::<f64>();
    std::array::from_fn(|axis| sum(axis) / cell.len().max(1) as f64)
}

/// Growth rate of the waves, with the damping but without the amplification by the time integration scheme, which is attributed to the time step.
pub(super) fn own_rate(rates: &StateRates) -> f64 {
    rates
        .stepped
        .map_or(rates.growth, |stepped| stepped.min(rates.growth))
}

/// Growth integrals of all points.
struct Growth<'p> {
    states: States<'p>,
    integral: Vec<f64>,
    rate: Vec<f64>,
    is_over: Vec<bool>,
}

impl<'p> Growth<'p> {
    fn new(states: States<'p>, count: usize) -> Self {
        Self {
            states,
            integral: vec![0.0; count],
            rate: vec![0.0; count],
            is_over: vec![false; count],
        }
    }

    fn add(&mut self, keys: &[Option<[i32; 6]>], interval: f64) {
        let asked = keys.iter().zip(&self.is_over);
        let asked = asked.filter_map(|(key, is_over)| key.filter(|_| !is_over));
        let asked: Vec<[i32; 6]> = asked.collect();
        self.states.ask(asked);
        for (n, key) in keys.iter().enumerate() {
            let Some(rates) = key.as_ref().filter(|_| !self.is_over[n]) else {
                continue;
            };
            let Some(rates) = self.states.of(rates) else {
                continue;
            };
            let rate = own_rate(rates);
            let grown = self.integral[n] + 0.5 * (self.rate[n] + rate) * interval;
            self.integral[n] = grown.max(0.0);
            self.rate[n] = rate;
        }
    }
}

/// Largest relative difference of values that count as equal, because they can differ by rounding.
const TIED: f64 = 1e-6;

/// Number and value of the largest of some numbered values; of equal values the one at the smallest reference position, by its coordinates in order, so that
/// the order of the particles in the files has no effect.
pub(super) fn largest(
    values: impl Iterator<Item = (usize, f64)> + Clone,
    places: &[[f64; 3]],
) -> Option<(usize, f64)> {
    let most = values.clone().map(|(_, value)| value);
    let most = most.max_by(f64::total_cmp)?;
    let tied = values.filter(|(_, value)| *value >= most - TIED * most.abs());
    tied.min_by(|(a, _), (b, _)| {
        let mut axes = (0..3).map(|i| places[*a][i].total_cmp(&places[*b][i]));
        axes.find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
    })
}

/// Fraction of an interval at which an exponentially growing amplitude crosses a limit.
pub(super) fn crossing(from: f64, to: f64, limit: f64) -> f64 {
    match from > 0.0 && to > from {
        true => (limit / from).ln() / (to / from).ln(),
        false => 1.0,
    }
}

/// Amplitude after a growth integral; finite.
pub(super) fn amplified(seed: f64, integral: f64) -> f64 {
    seed * integral.min(LARGEST_INTEGRAL).exp()
}

fn root_mean_square(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), x| (sum + x * x, count + 1));
    (sum / f64::from(count.max(1))).sqrt()
}

/// Fields of a frame, for output files.
#[derive(Debug)]
pub struct Snapshot<'s> {
    /// Number of the frame, from 0.
    pub number: usize,
    /// Time of the frame.
    pub time: f64,
    /// Number of dimensions of the positions.
    pub dimension: usize,
    /// Whether an event first occurs in this frame, or in the interval before it.
    pub is_event: bool,
    /// Current positions of the particles or nodes.
    pub x: &'s [[f64; 3]],
    /// Fields of the particles or nodes.
    pub of_nodes: Vec<(&'static str, Vec<f64>)>,
    /// Fields of the points that have states: particles or elements.
    pub of_points: Vec<(&'static str, Vec<f64>)>,
}

/// Receiver of the fields of each frame.
pub type Sink<'s> = &'s mut dyn FnMut(&Snapshot<'_>) -> Result<(), ScreenError>;

/// Follows a run from frame to frame. Two frames are in memory.
pub(super) fn follow(
    problem: &Problem,
    question: &Question,
    run: &Run,
    frames: &mut dyn Iterator<Item = Result<Frame, ScreenError>>,
    sink: Sink<'_>,
) -> Result<Course, ScreenError> {
    let mut follower = Follower::new(problem, question, run)?;
    for (number, frame) in frames.enumerate() {
        let frame = frame?;
        onset::cancel::checkpoint();
        let fields = follower.frame(&frame)?;
        sink(&Snapshot {
            number,
            time: frame.time,
            dimension: problem.dimension(),
            is_event: fields.is_event,
            x: &frame.x,
            of_nodes: vec![("noise", fields.observed)],
            of_points: vec![
                ("acoustic", fields.acoustic),
                ("growth", fields.growth),
                ("amplitude", fields.amplitude),
                ("step_ratio", fields.step_ratio),
                ("cause", fields.cause),
                ("checked", fields.checked),
            ],
        })?;
    }
    follower.finish()
}

/// Values of a frame: of each node (`observed`), or of each point.
struct Fields {
    observed: Vec<f64>,
    acoustic: Vec<f64>,
    growth: Vec<f64>,
    amplitude: Vec<f64>,
    step_ratio: Vec<f64>,
    /// Index of the cause in [`Cause::ALL`].
    cause: Vec<f64>,
    checked: Vec<f64>,
    is_event: bool,
}

/// State of [`follow`] between two frames.
struct Follower<'p> {
    problem: &'p Problem,
    question: &'p Question,
    run: &'p Run,
    points: Points,
    /// Nodes whose short waves are evaluated.
    nodes: Vec<bool>,
    /// Whether states are evaluated at a point.
    is_asked: Vec<bool>,
    growth: Growth<'p>,
    at_rest: StateRates,
    limited: Option<(StepLimit, Option<BodyMode>)>,
    speed: f64,
    agreement: Agreement,
    course: Course,
    /// Amplitude of the first frame; spacings.
    first_seed: f64,
    has_begun: bool,
    /// Frame nearest to the time for which modes are requested.
    nearest: Option<Nearest>,
    /// Integral of the growth rate caused by the time step.
    by_step: f64,
    /// First time at which a point has no state, and the reason; `None` for points that have states.
    lacks: Vec<Option<(f64, Lack)>>,
    still: Still,
}

/// Reason why a point has no state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lack {
    /// The positions of the neighbors determine no deformation gradient.
    Neighbors,
    /// `det F` is not positive.
    Inverted,
    /// Short waves exceed [`FINAL_AMPLITUDE`]: the neighbors have changed.
    Short,
    /// The law or the method is not defined.
    Undefined,
}

impl Lack {
    const ALL: [Self; 4] = [
        Self::Inverted,
        Self::Undefined,
        Self::Short,
        Self::Neighbors,
    ];

    /// Beginning of a clause about some points.
    fn told(self, points: &str) -> String {
        match self {
            Self::Neighbors => {
                format!("no deformation gradient of {points}, for lack of neighbors")
            }
            Self::Inverted => format!("det F of {points} is not positive"),
            Self::Short => {
                format!("short waves of {points} exceed {FINAL_AMPLITUDE} spacings")
            }
            Self::Undefined => format!("law or method are not defined in the states of {points}"),
        }
    }
}

/// Particles that stop, as particles of some codes do whose forces have failed.
#[derive(Clone, Debug, Default)]
struct Still {
    x: Vec<[f64; 3]>,
    has_moved: Vec<bool>,
    /// Time since which a particle stands still, and the mean position of its neighbors then; `None` for particles that move.
    since: Vec<Option<(f64, [f64; 3])>>,
}

impl Still {
    /// Follows the particles to the next frame. `before` is the time of the last frame.
    fn follow(&mut self, x: &[[f64; 3]], before: f64, near: &Neighborhoods) {
        if self.x.is_empty() {
            self.has_moved = vec![false; x.len()];
            self.since = vec![None; x.len()];
        } else {
            for (n, own) in x.iter().enumerate() {
                if *own != self.x[n] {
                    (self.has_moved[n], self.since[n]) = (true, None);
                } else if self.has_moved[n] && self.since[n].is_none() {
                    self.since[n] = Some((before, around(n, &self.x, near)));
                }
            }
        }
        self.x = x.to_vec();
    }

    /// Rows of the particles that stand still at the end although their neighbors have moved on, with the times since which they stand still.
    fn found(&self, held: &[bool], near: &Neighborhoods, spacing: f64) -> Vec<(usize, f64)> {
        let of = |n: usize| {
            let (time, from) = self.since[n].filter(|_| !held[n])?;
            let to = around(n, &self.x, near);
            let moved: f64 = (0..3).map(|i| (to[i] - from[i]).powi(2)).sum();
            (moved.sqrt() > STILL_MOTION * spacing).then_some((n, time))
        };
        (0..self.since.len()).filter_map(of).collect()
    }
}

/// Mean position of the neighbors of a particle.
fn around(n: usize, x: &[[f64; 3]], near: &Neighborhoods) -> [f64; 3] {
    let all: Vec<usize> = near.numbers(n).collect();
    mean(&all, x)
}

/// Coordinates of a place, with four digits.
pub(super) fn point(place: &[f64; 3], dimension: usize) -> String {
    let all = place[..dimension].iter().map(|x| told_with(*x, 4));
    format!("({})", all.collect::<Vec<_>>().join(", "))
}

/// Number of some points, with the first time and the place of the first point; `None` without points.
fn first_of(
    points: &[(usize, f64)],
    places: &[[f64; 3]],
    dimension: usize,
    name: &str,
) -> Option<(String, String)> {
    let time = points.iter().map(|(_, time)| *time);
    let time = time.min_by(f64::total_cmp)?;
    let at_first = points.iter().filter(|(_, own)| *own == time);
    let (point, _) = largest(at_first.map(|(n, _)| (*n, 0.0)), places)?;
    let near = self::point(&places[point], dimension);
    Some((
        counted(points.len(), name),
        format!("t = {} near {near}", told_with(time, 4)),
    ))
}

impl<'p> Follower<'p> {
    fn new(
        problem: &'p Problem,
        question: &'p Question,
        run: &'p Run,
    ) -> Result<Self, ScreenError> {
        let analysis = &problem.analysis;
        let (dimension, spacing) = (problem.dimension(), analysis.spacing());
        let radius = match run.cells {
            Some(_) => RADIUS * spacing,
            None => neighborhood_radius(problem),
        };
        let points = Points::new(run, dimension, radius);
        let count = points.places.len();
        let (nodes, is_asked) = far_from_held(run, &points);
        let stepping = question.stepping();
        let growth = Growth::new(States::new(problem, stepping, question.bin), count);
        let at_rest = growth.states.evaluate(&Matrix3::identity());
        let at_rest = at_rest.ok_or(ScreenError::Reference)?;
        let limited = limits(problem, run, stepping, &at_rest)?;
        let speed = analysis.speed_squared().map_err(ProblemError::from)?.sqrt();
        let asked = is_asked.iter().filter(|is| **is).count();
        if asked == 0 || !nodes.contains(&true) {
            return Err(ScreenError::Run {
                what: "no particle remains to be assessed: all are held, near held particles, or outside the region".to_owned(),
                hint: "choose held particles with --held, or another --region".to_owned(),
            });
        }
        let most = (0..points.nodes.len()).map(|n| points.nodes.count(n)).max();
        let is_cut = |n: &usize| 10 * points.nodes.count(*n) < 9 * most.unwrap_or(0);
        let cut = (0..points.nodes.len()).filter(is_cut).count();
        Ok(Self {
            course: Course {
                moments: Vec::new(),
                lost: None,
                grown: None,
                observed: None,
                step: limited.as_ref().map(|(limit, _)| limit.clone()),
                seed: 0.0,
                points: [asked, count - asked],
                variation: None,
                states: 0,
                cut: cut as f64 / points.nodes.len().max(1) as f64,
                growing: None,
                grown_until_observed: 0.0,
                lacking: Vec::new(),
                notes: Vec::new(),
                leading: Vec::new(),
                pictures: Vec::new(),
                actual: None,
                is_cut_short: false,
            },
            nearest: None,
            problem,
            question,
            run,
            points,
            nodes,
            is_asked,
            growth,
            at_rest,
            limited,
            speed,
            agreement: Agreement::default(),
            first_seed: 0.0,
            has_begun: false,
            by_step: 0.0,
            lacks: vec![None; count],
            still: Still::default(),
        })
    }

    /// Amplitudes of the evaluated nodes.
    fn checked<'s>(&'s self, observed: &'s [f64]) -> impl Iterator<Item = f64> + 's {
        let all = observed.iter().zip(&self.nodes);
        all.filter(|(_, counts)| **counts)
            .map(|(observed, _)| *observed)
    }

    /// Amplitude of short waves in the first frame, from positions and velocities; spacings.
    fn first_seed(&self, frame: &Frame, mean: f64) -> f64 {
        if let Some(seed) = self.question.seed {
            return seed;
        }
        let of_velocity = frame.velocity.as_ref().map_or(0.0, |velocity| {
            let short = self.points.nodes.short_waves(velocity).amplitude;
            root_mean_square(self.checked(&short)) / self.speed
        });
        let rounding = self.run.rounding / self.problem.analysis.spacing();
        mean.max(of_velocity).max(rounding)
    }

    /// Stretch tensors of deformation gradients.
    fn stretches(&self, found: &[Option<Matrix3<f64>>]) -> Vec<Option<Matrix3<f64>>> {
        let all = found.par_iter();
        all.map(|f| without_rotation(f.as_ref()?)).collect()
    }

    fn compare(&mut self, frame: &Frame, found: &[Option<Matrix3<f64>>]) {
        let dimension = self.problem.dimension();
        if let Some(gradient) = &frame.gradient {
            self.agreement
                .compare_gradients(dimension, frame.time, gradient, found);
        }
        if let Some(stress) = &frame.stress {
            let is_given = &frame.stress_given;
            self.agreement
                .compare_stresses(self.problem, stress, is_given, found);
        }
    }

    fn frame(&mut self, frame: &Frame) -> Result<Fields, ScreenError> {
        let dimension = self.problem.dimension();
        let spacing = self.problem.analysis.spacing();
        let count = self.points.places.len();
        let before = self.course.moments.last();
        let before = before.map_or(frame.time, |moment| moment.time);
        let interval = frame.time - before;
        // Short waves of the positions.
        let short = self.points.nodes.short_waves(&frame.x);
        let observed: Vec<f64> = short.amplitude.iter().map(|x| x / spacing).collect();
        // Smooth curvature does not count as a short wave, unless the body is destroyed.
        let is_short = |n: usize| !short.is_smooth[n] || observed[n] > FINAL_AMPLITUDE;
        let is_short: Vec<bool> = (0..observed.len())
            .map(|n| self.nodes[n] && is_short(n))
            .collect();
        let all_short = || {
            let all = observed.iter().copied().enumerate();
            all.filter(|(n, _)| is_short[*n])
        };
        let most_observed = all_short().map(|(_, x)| x).fold(0.0, f64::max);
        let mean_observed = root_mean_square(self.checked(&observed));
        if self.course.moments.is_empty() {
            self.first_seed = self.first_seed(frame, mean_observed);
            self.course.seed = self.first_seed;
        } else if self.first_seed < EXACT_LATTICE_AMPLITUDE && self.question.seed.is_none() {
            // Positions of an exact lattice without velocities: noise appears in a later frame.
            self.first_seed = self.first_seed.max(mean_observed);
            self.course.seed = self.first_seed;
            self.by_step = 0.0;
        }
        // States of the points follow.
        let (points, run, is_asked) = (&self.points, self.run, &self.is_asked);
        let found: Vec<Option<Matrix3<f64>>> = (0..count)
            .into_par_iter()
            .map(|point| match is_asked[point] {
                true => points.deformation(point, dimension, &run.reference, &frame.x),
                false => None,
            })
            .collect();
        if self.course.observed.is_none() {
            self.compare(frame, &found);
        }
        let stretches = self.stretches(&found);
        let growth = &mut self.growth;
        for (n, own) in stretches.iter().enumerate() {
            let is_far = self.points.cells.is_none() && observed[n] > FINAL_AMPLITUDE;
            growth.is_over[n] |= self.is_asked[n] && (own.is_none() || is_far);
        }
        let keys: Vec<Option<[i32; 6]>> = stretches
            .iter()
            .map(|own| own.as_ref().map(|u| growth.states.key(u)))
            .collect();
        growth.add(&keys, interval);
        let event = |share: f64, (point, place): (usize, [f64; 3]), f: [[f64; 3]; 3]| Event {
            time: before + share.clamp(0.0, 1.0) * interval,
            window: [before, frame.time],
            point,
            particle: None,
            place,
            f,
        };
        let at = |point: usize| (point, self.points.places[point]);
        // Predicted amplitudes start from the short waves at the beginning of growth.
        let integrals = self.growth.integral.iter().copied().enumerate();
        let (grown, integral) = largest(integrals, &self.points.places).unwrap_or((0, 0.0));
        if !self.has_begun && integral > INTEGRAL_AT_BEGINNING {
            self.has_begun = true;
            // Short waves above the threshold have already grown and are not the seed.
            let is_early =
                self.course.observed.is_none() && most_observed <= self.question.threshold;
            if is_early && self.question.seed.is_none() {
                self.course.seed = self.first_seed.max(mean_observed);
            }
        }
        if let Some(u) = stretches.get(grown).and_then(Option::as_ref) {
            self.course.leading.push((frame.time, *u));
        }
        let seed = self.course.seed;
        let predicted = amplified(seed, integral);
        let threshold = self.question.threshold;
        let mut fields = Fields {
            acoustic: vec![f64::NAN; count],
            growth: vec![f64::NAN; count],
            amplitude: vec![0.0; count],
            step_ratio: vec![f64::NAN; count],
            cause: vec![Cause::None.number(); count],
            checked: self
                .is_asked
                .iter()
                .map(|is| f64::from(u8::from(*is)))
                .collect(),
            observed: Vec::new(),
            is_event: false,
        };
        let rates_of = |point: usize| self.growth.states.of(keys[point].as_ref()?);
        let critical = self.limited.as_ref();
        let critical = critical.map(|(limit, _)| limit.body.unwrap_or(limit.lattice));
        let mut undefined = 0;
        let (mut squared, mut extra) = (0.0_f64, 0.0_f64);
        let mut fastest: Option<f64> = None;
        for point in (0..count).filter(|point| self.is_asked[*point]) {
            let rates = rates_of(point).filter(|_| !self.growth.is_over[point]);
            let Some(rates) = rates else {
                undefined += 1;
                let lack = match () {
                    () if found[point].is_none() => Lack::Neighbors,
                    () if stretches[point].is_none() => Lack::Inverted,
                    () if self.growth.is_over[point] => Lack::Short,
                    () => Lack::Undefined,
                };
                self.lacks[point].get_or_insert((frame.time, lack));
                continue;
            };
            let rate = own_rate(rates);
            fastest = Some(fastest.map_or(rate, |own| own.max(rate)));
            squared = squared.max(rates.squared);
            if let Some(stepped) = rates.stepped {
                extra = extra.max(stepped - rates.growth.max(0.0));
            }
            let amplitude = amplified(seed, self.growth.integral[point]);
            (fields.acoustic[point], fields.growth[point]) = (rates.acoustic, rate);
            fields.amplitude[point] = amplitude;
            let harder = (rates.squared / self.at_rest.squared).sqrt();
            let ratio = self.question.time_step.zip(critical);
            let ratio = ratio.map(|(step, critical)| step * harder / critical);
            fields.step_ratio[point] = ratio.unwrap_or(f64::NAN);
            fields.cause[point] = match ratio {
                _ if rates.acoustic < ELLIPTICITY_ROUNDING => Cause::Physical,
                Some(ratio) if ratio > 1.0 => Cause::TimeStep,
                _ if amplitude > threshold => Cause::Numerical,
                _ => Cause::None,
            }
            .number();
        }
        let known = fields.acoustic.iter().copied().enumerate();
        let known = known.filter(|(_, least)| !least.is_nan());
        let softest = largest(known.map(|(n, least)| (n, -least)), &self.points.places);
        let softest = softest.map(|(point, least)| (point, -least));
        let last = self.course.moments.last();
        if self.course.lost.is_none()
            && let Some((point, least)) = softest.filter(|(_, least)| *least < ELLIPTICITY_ROUNDING)
        {
            let f = rates_of(point).map_or([[0.0; 3]; 3], |rates| *rates.f.components());
            let positive = last.and_then(|own| own.acoustic).unwrap_or(0.0).max(0.0);
            self.course.lost = Some(event(positive / (positive - least), at(point), f));
            self.course.variation = self.points.variation(point, &stretches);
        }
        if self.course.grown.is_none() && self.has_begun && predicted > threshold {
            let share = last.map_or(1.0, |own| crossing(own.predicted, predicted, threshold));
            self.course.grown = rates_of(grown).map(|rates| {
                (
                    event(share, at(grown), *rates.f.components()),
                    rates.clone(),
                )
            });
        }
        if self.course.observed.is_none() {
            self.course.grown_until_observed = integral;
            self.course.growing = rates_of(grown).cloned();
            if most_observed > threshold {
                let node = largest(all_short(), &self.run.reference).map_or(0, |(n, _)| n);
                let f = self.points.nodes.deformation(node, &frame.x);
                let f = f.and_then(|f| without_rotation(&f));
                let f = f.unwrap_or_else(Matrix3::identity);
                let share =
                    last.map_or(1.0, |own| crossing(own.observed, most_observed, threshold));
                let f = std::array::from_fn(|i| std::array::from_fn(|j| f[(i, j)]));
                self.course.observed = Some(event(share, (node, self.run.reference[node]), f));
            }
        }
        let has_exceeded = |course: &Course| {
            let limit = course.step.as_ref();
            limit.is_some_and(|limit| limit.exceeded.is_some())
        };
        let was_exceeded = has_exceeded(&self.course);
        let step_ratio = self.step(before, interval, squared, extra);
        let is_exceeded = !was_exceeded && has_exceeded(&self.course);
        self.course.moments.push(Moment {
            time: frame.time,
            predicted,
            predicted_by_step: amplified(self.first_seed, self.by_step),
            observed: most_observed,
            observed_mean: mean_observed,
            acoustic: softest.map(|(_, least)| least),
            growth: fastest,
            step_ratio,
            undefined,
        });
        self.still.follow(&frame.x, before, &self.points.nodes);
        fields.is_event = self.picture(frame, &observed) || is_exceeded;
        self.keep_nearest(frame);
        fields.observed = observed;
        Ok(fields)
    }

    /// Stores the positions and short waves of a frame at which an event first occurs; returns false for other frames.
    fn picture(&mut self, frame: &Frame, observed: &[f64]) -> bool {
        let at = |event: Option<&Event>| event.is_some_and(|own| own.window[1] == frame.time);
        let grown = self.course.grown.as_ref().map(|(event, _)| event);
        let happens =
            at(grown) || at(self.course.lost.as_ref()) || at(self.course.observed.as_ref());
        if happens {
            self.course.pictures.push(Picture {
                time: frame.time,
                x: frame.x.clone(),
                observed: observed.to_vec(),
            });
        }
        happens
    }

    fn keep_nearest(&mut self, frame: &Frame) {
        let Some(asked) = self.question.actual else {
            return;
        };
        let distance = |time: f64| (time - asked).abs();
        let before = self.nearest.as_ref();
        if before.is_none_or(|own| distance(frame.time) < distance(own.time)) {
            self.nearest = Some(Nearest {
                time: frame.time,
                frame: self.course.moments.len() - 1,
                x: frame.x.clone(),
            });
        }
    }

    /// Lowest modes of the body in the nearest frame.
    fn actual(&mut self) -> Result<Option<Actual>, ScreenError> {
        let Some((asked, nearest)) = self.question.actual.zip(self.nearest.take()) else {
            return Ok(None);
        };
        let times = || self.course.moments.iter().map(|moment| moment.time);
        let (first, last) = (
            times().next().unwrap_or(asked),
            times().next_back().unwrap_or(asked),
        );
        if !(first..=last).contains(&asked) {
            return Err(ScreenError::Run {
                what: format!(
                    "--actual is {}, but the frames are from t = {} to {}",
                    told(asked),
                    told(first),
                    told(last)
                ),
                hint: "choose a time of the run".to_owned(),
            });
        }
        let nodes = &self.points.nodes;
        let deformations: Vec<_> = (0..nodes.len())
            .map(|n| nodes.deformation(n, &nearest.x))
            .collect();
        Actual::new(self.problem, asked, self.run, nearest, &deformations).map(Some)
    }

    /// Adds the growth caused by the time step; returns the ratio of the step to the largest stable step of the body.
    fn step(&mut self, before: f64, interval: f64, squared: f64, extra: f64) -> Option<f64> {
        let (limit, mode) = self.limited.as_ref()?;
        let (stepping, step) = self.question.stepping()?;
        // The states change the steps of body and lattice by the same factor.
        let harder = match squared > 0.0 {
            true => squared / self.at_rest.squared,
            false => 1.0,
        };
        let critical = limit.body.unwrap_or(limit.lattice) / harder.sqrt();
        let rate = match mode {
            // States after the first short waves are distorted by them.
            _ if self.course.observed.is_some() && self.by_step < INTEGRAL_AT_BEGINNING => 0.0,
            Some(mode) if step > critical => scaled(mode, harder).growth(stepping, step).max(extra),
            _ => extra,
        };
        self.by_step = (self.by_step + rate * interval).max(0.0);
        if let Some(told) = self
            .course
            .step
            .as_mut()
            .filter(|_| self.course.observed.is_none())
        {
            told.least = told.least.min(critical);
            if told.exceeded.is_none() && step > critical {
                (told.exceeded, told.growth) = (Some(before), rate);
                told.at_excess = Some(critical);
            }
        }
        Some(step / critical)
    }

    /// Clauses about points without a state, and about particles that stand still.
    fn lacking(&self) -> Vec<String> {
        let dimension = self.problem.dimension();
        let points = |lack: Lack| -> Vec<(usize, f64)> {
            let all = self.lacks.iter().enumerate();
            let own = all.filter_map(|(n, own)| Some((n, (*own)?)));
            let own = own.filter(|(_, (_, own))| *own == lack);
            own.map(|(n, (time, _))| (n, time)).collect()
        };
        let mut lacking: Vec<String> = Vec::new();
        for lack in Lack::ALL {
            let found = first_of(&points(lack), &self.points.places, dimension, "point");
            lacking.extend(found.map(|(count, first)| {
                format!(
                    "{}, first at {first}: no state is assessed there",
                    lack.told(&count)
                )
            }));
        }
        let spacing = self.problem.analysis.spacing();
        let still = self
            .still
            .found(&self.run.held, &self.points.nodes, spacing);
        let found = first_of(&still, &self.run.reference, dimension, "particle");
        lacking.extend(found.map(|(count, first)| {
            let verb = if still.len() == 1 { "stands" } else { "stand" };
            format!(
                "{count} {verb} still while the neighbors move, first from {first}: forces that have failed, or held particles"
            )
        }));
        lacking
    }

    fn finish(mut self) -> Result<Course, ScreenError> {
        self.course.states = self.growth.states.len();
        if self.course.states == 0 {
            return Err(ScreenError::Run {
                what: "no particle has a state in any frame: the determinant of the deformation gradient from the reference positions is not positive"
                    .to_owned(),
                hint: "check the columns of positions and of reference positions with --check; exchanged axes and mirrored positions have this effect"
                    .to_owned(),
            });
        }
        self.course.lacking = self.lacking();
        self.course.notes = self.agreement.notes(self.problem);
        self.course.actual = self.actual()?;
        match self.course.moments.len() {
            count @ 0..=1 => Err(ScreenError::TooFewFrames { count, why: None }),
            _ => Ok(self.course),
        }
    }
}

/// Mode with all stiffnesses multiplied by a factor.
fn scaled(mode: &BodyMode, factor: f64) -> BodyMode {
    let mut mode = mode.clone();
    mode.squared *= factor;
    mode.parts.positions *= onset::algebra::Complex::new(factor, 0.0);
    mode.parts.stress *= onset::algebra::Complex::new(factor, 0.0);
    mode.parts.density *= onset::algebra::Complex::new(factor, 0.0);
    mode
}

/// Largest stable steps in the reference state, with the mode of the body that limits it; `None` without a time step.
fn limits(
    problem: &Problem,
    run: &Run,
    stepping: Option<(Stepping, f64)>,
    at_rest: &StateRates,
) -> Result<Option<(StepLimit, Option<BodyMode>)>, ScreenError> {
    let Some((stepping, _)) = stepping else {
        return Ok(None);
    };
    let volume = problem.analysis.spacing().powi(problem.dimension() as i32);
    let particles = placed(run, volume);
    let mode = body_mode(
        &method(&problem.settings),
        &*problem.material,
        &particles,
        &run.held,
        &DeformationGradient::identity(),
        stepping,
    );
    let mode = mode.map_err(ProblemError::from)?;
    let body = mode.as_ref().map(|mode| mode.critical_time_step(stepping));
    let lattice = stepping.critical_step(at_rest.squared, 0.0);
    let limit = StepLimit {
        lattice,
        body,
        least: body.unwrap_or(lattice),
        exceeded: None,
        at_excess: None,
        growth: 0.0,
        particle: mode.as_ref().map(|mode| mode.particle),
        place: mode.as_ref().map(|mode| run.reference[mode.particle]),
    };
    Ok(Some((limit, mode)))
}

/// Radius of the neighborhoods of particles; length.
pub(crate) fn neighborhood_radius(problem: &Problem) -> f64 {
    problem.settings.discretization.support.clamp(1.5, 4.0) * problem.analysis.spacing()
}

/// Nodes whose short waves are evaluated, and points with states. Neither the points nor their neighbors are held; for short waves the neighbors of
/// neighbors are not held either.
fn far_from_held(run: &Run, points: &Points) -> (Vec<bool>, Vec<bool>) {
    let spread = |held: &[bool]| -> Vec<bool> {
        let near = |n: usize| held[n] || points.nodes.numbers(n).any(|other| held[other]);
        (0..held.len()).map(near).collect()
    };
    let near = spread(&run.held);
    let nearer = spread(&near);
    let is_in = |x: &[f64; 3]| run.region.as_ref().is_none_or(|region| region.contains(x));
    let is_free = |near: &[bool]| -> Vec<bool> {
        let all = near.iter().zip(&run.reference);
        all.map(|(near, x)| !near && is_in(x)).collect()
    };
    let asked = match &points.cells {
        None => is_free(&near),
        Some(cells) => {
            // The gradient of an element needs no neighbors.
            let is_held = |cell: &[usize]| cell.iter().all(|node| run.held[*node]);
            let all = cells.iter().zip(&points.places);
            all.map(|(cell, x)| !is_held(cell) && is_in(x)).collect()
        }
    };
    (is_free(&nearer), asked)
}
