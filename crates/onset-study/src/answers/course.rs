//! Paths of deformation, straight or with traction-free faces, and samples of the states along them.

use super::notes::{is_fluid, notes_on_law};
use super::path::{CrossingAnswer, PathAnswer};
use super::problem::{Problem, ProblemError, Strain};
use super::state::rows;
use crate::caption;
use crate::criteria::{EndAnswer, imposed_label};
use crate::csv::Table;
use crate::figure::{Axis, Figure, Line, Panel, Rule, palette};
use crate::number::told;
use crate::output::{Files, picture, text};
use crate::settings::Effective;
use onset::cancel::Scope;
use onset::criteria::{
    Lateral, Loading, LoadingError, LoadingPath, LoadingSection, Mode, Range, is_isotropic,
};
use onset::kinematics::{DeformationGradient, DeformationPath, StraightPath};
use onset::verdict::{SurveyedState, Verdict};
use rayon::prelude::*;
use serde::Serialize;
use std::fmt;

/// Path of deformations, straight or a loading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Course {
    /// Straight path from one state to another.
    Straight(Strain, Strain),
    /// Loading from one imposed stretch to another; the stretches of traction-free faces, if any, are computed.
    Loading {
        /// Imposed mode, and condition on the other directions.
        loading: Loading,
        /// First imposed stretch; in simple shear the amount of shear.
        from: f64,
        /// Last imposed stretch, or amount of shear.
        to: f64,
    },
}

/// Loading as it was followed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LoadingOfPath {
    /// Deformation mode that is imposed.
    pub mode: Mode,
    /// Condition on the lateral directions.
    pub lateral: Lateral,
    /// Short name of the loading.
    pub title: &'static str,
    /// Name of the imposed quantity: a stretch, or the amount of shear.
    pub imposes: &'static str,
    /// The imposed stretch, or amount of shear, at the start.
    pub from: f64,
    /// The imposed stretch, or amount of shear, at the end.
    pub to: f64,
    /// Requested imposed stretch, or amount of shear, at the start.
    pub asked_from: f64,
    /// Requested imposed stretch, or amount of shear, at the end.
    pub asked_to: f64,
    /// Reason why the path begins after the requested start; `None` if it begins there.
    pub starts_late: Option<String>,
    /// Reason why the path ends before the requested end; `None` if the path is complete.
    pub ends_early: Option<String>,
    /// Folds at which the path begins or ends: limit points of the equilibrium of the free faces.
    pub folds: Vec<f64>,
}

impl LoadingOfPath {
    pub(super) fn imposed(&self, s: f64) -> f64 {
        match s {
            1.0 => self.to,
            _ => self.from + (self.to - self.from) * s,
        }
    }

    /// Returns true if the path ends in a fold.
    pub(super) fn ends_in_fold(&self) -> bool {
        self.folds.contains(&self.to)
    }
}

impl fmt::Display for LoadingOfPath {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { title, imposes, .. } = self;
        let (from, to) = (told(self.from), told(self.to));
        write!(formatter, "Loading: {title}, ")?;
        if self.starts_late.is_none() && self.ends_early.is_none() {
            return write!(formatter, "from {imposes} {from} to {to}.");
        }
        write!(formatter, "followed from {imposes} ")?;
        match &self.starts_late {
            Some(_) => write!(
                formatter,
                "{from} only, not from {}, ",
                told(self.asked_from)
            )?,
            None => write!(formatter, "{from} ")?,
        }
        write!(formatter, "to {to}")?;
        if self.ends_early.is_some() {
            write!(formatter, " only, not to {}", told(self.asked_to))?;
        }
        let mut whys: Vec<&str> = [&self.starts_late, &self.ends_early]
            .into_iter()
            .flatten()
            .map(String::as_str)
            .collect();
        whys.dedup();
        write!(formatter, ": {}.", whys.join("; "))
    }
}

impl Course {
    /// Creates a loading of a mode. By default the lateral faces are free, as in a test machine.
    ///
    /// # Errors
    /// Names of the lateral conditions of this mode if `lateral` is not one of them.
    pub fn of_mode(
        mode: Mode,
        lateral: Option<Lateral>,
        from: f64,
        to: f64,
    ) -> Result<Self, String> {
        let own = || {
            Loading::ALL
                .into_iter()
                .filter(|loading| loading.mode == mode)
        };
        let asked = own().find(|loading| lateral.is_none_or(|asked| loading.lateral == asked));
        let loading = asked.ok_or_else(|| {
            let known: Vec<&str> = own().map(|loading| loading.lateral.name()).collect();
            known.join(", ")
        })?;
        Ok(Self::Loading { loading, from, to })
    }

    /// Calls `answer` with the path, and with a description if the path is a loading.
    ///
    /// # Errors
    /// [`ProblemError`] when the path does not exist, and any error of `answer`.
    pub(super) fn follow<T>(
        &self,
        problem: &Problem,
        answer: impl Fn(&dyn DeformationPath, Option<LoadingOfPath>) -> Result<T, ProblemError>,
    ) -> Result<T, ProblemError> {
        let (loading, from, to) = match *self {
            Self::Straight(from, to) => return answer(&StraightPath::new(from.0, to.0)?, None),
            Self::Loading { loading, from, to } => (loading, from, to),
        };
        let material = &*problem.material;
        let refused = |reason: String| ProblemError::Loading {
            title: loading.title(),
            imposes: loading.mode.imposes(),
            from,
            to,
            reason,
            notes: notes_on_law(&problem.settings.material, material),
        };
        let is_membrane = problem.settings.material.is_membrane();
        let held = held_across(loading, material.dimension()).filter(|_| !is_membrane);
        if is_membrane && loading.mode == Mode::Hydrostatic {
            return Err(refused(
                "a two-dimensional (membrane) law has no third direction\n  hint: --mode equibiaxial".to_owned(),
            ));
        }
        if let Some(reason) = held {
            return Err(refused(reason));
        }
        // Every branch begins in the reference configuration.
        let ends = [from, to].map(|imposed| loading.mode.parameter(imposed).exp());
        let range = Range::new(
            ends[0].min(ends[1]).min(0.99),
            ends[0].max(ends[1]).max(1.01),
        )
        .map_err(|error| refused(error.to_string()))?;
        let isotropic = material.dimension() == 3 && is_isotropic(material);
        let path = LoadingPath::new(material, isotropic, loading, &range);
        let path = path.map_err(|error| match (error, is_fluid(material)) {
            (LoadingError::NoReference, true) => refused(
                "a fluid has no such state: with free faces it carries no stress, and its volume alone does not determine the lateral stretches\n  \
                 hint: --lateral held, or --mode hydrostatic"
                    .to_owned(),
            ),
            (error, _) => refused(error.to_string()),
        })?;
        let (start, starts_late) = reached(&path, from);
        let attempt = |end: f64, ends_early: Option<String>| -> Result<T, ProblemError> {
            if start == end && from != to {
                let why = starts_late.as_ref().or(ends_early.as_ref());
                let why = why.map_or("", String::as_str);
                return Err(refused(format!(
                    "the path that begins in the reference configuration ends at {} {}: {why}",
                    loading.mode.imposes(),
                    told(start)
                )));
            }
            let section = LoadingSection::new(&path, start, end)?;
            let folded = |(imposed, early): (f64, &Option<String>)| {
                let is_fold =
                    early.is_some() && path.ends_in_fold(loading.mode.parameter(imposed) > 0.0);
                is_fold.then_some(imposed)
            };
            let told = LoadingOfPath {
                mode: loading.mode,
                lateral: loading.lateral,
                title: loading.title(),
                imposes: loading.mode.imposes(),
                from: start,
                to: end,
                asked_from: from,
                asked_to: to,
                folds: [(start, &starts_late), (end, &ends_early)]
                    .into_iter()
                    .filter_map(folded)
                    .collect(),
                starts_late: starts_late.clone(),
                ends_early,
            };
            answer(&section, Some(told))
        };
        let (end, ends_early) = reached(&path, to);
        let found = attempt(end, ends_early);
        match found.as_ref().err().and_then(ProblemError::missing_state) {
            Some(missing) => attempt(
                last_state(&path, start, missing),
                Some(NO_STATE_REASON.to_owned()),
            ),
            None => found,
        }
    }

    /// Coordinate along the path: the imposed stretch or amount of shear, a stretch that changes along the path, or the path parameter.
    pub(super) fn abscissa(&self, s: f64) -> (&'static str, f64) {
        match self {
            Self::Loading { loading, from, to } => {
                (imposed_label(loading.mode), from + (to - from) * s)
            }
            Self::Straight(from, to) => {
                let (from, to) = (from.0.components(), to.0.components());
                let shears = (0..3)
                    .any(|i| (0..3).any(|j| i != j && (from[i][j] != 0.0 || to[i][j] != 0.0)));
                let names = ["stretch λ₁ (−)", "stretch λ₂ (−)", "stretch λ₃ (−)"];
                let changing = (0..3).find(|i| from[*i][*i] != to[*i][*i]);
                match changing.filter(|_| !shears) {
                    Some(i) => (names[i], from[i][i] + (to[i][i] - from[i][i]) * s),
                    None => ("path parameter s (−)", s),
                }
            }
        }
    }
}

/// Options of a mode that leave the faces of a sheet traction-free.
fn free_faces(mode: Mode) -> String {
    let of_mode = Loading::ALL.into_iter().filter(|own| own.mode == mode);
    let free = of_mode.filter(|own| own.leaves_free(2));
    let names: Vec<&str> = free.map(|own| own.lateral.name()).collect();
    match names.is_empty() {
        true => "--mode equibiaxial".to_owned(),
        false => format!("--lateral {}", names.join(" or ")),
    }
}

/// Reason why a loading is impossible for a sheet or bar with traction-free faces: it would impose stretches that follow from equilibrium.
fn held_across(loading: Loading, dimension: usize) -> Option<String> {
    let (is_one, body, hint) = match dimension {
        3 => return None,
        2 => (
            loading.leaves_free(2),
            "a sheet in plane stress, whose thickness is computed",
            free_faces(loading.mode),
        ),
        _ => (
            loading.mode == Mode::Uniaxial && loading.lateral == Lateral::Free,
            "a bar in uniaxial stress, whose lateral stretches are computed",
            "--mode uniaxial".to_owned(),
        ),
    };
    (!is_one).then(|| {
        format!("it imposes stretches across {body}\n  hint: {hint}; or set material.plane=strain")
    })
}

/// Imposed stretch, or amount of shear, that the path reaches, with the reason if it differs from the requested value.
fn reached(path: &LoadingPath<'_>, imposed: f64) -> (f64, Option<String>) {
    let mode = path.loading.mode;
    let s = mode.parameter(imposed);
    let states = match s >= 0.0 {
        true => &path.tension,
        false => &path.compression,
    };
    if path.at(s).is_some() {
        return (imposed, None);
    }
    let last = states.last().map_or(0.0, |state| state.parameter);
    let why = EndAnswer::of(path, s >= 0.0, imposed).reason;
    let why = why.unwrap_or_else(|| "no state with free faces is found beyond it".to_owned());
    (mode.imposed(last), Some(why))
}

/// Reason why a loading ends where its states are lost in rounding, for example because the stiffness of the law has vanished.
const NO_STATE_REASON: &str = "beyond it the free faces determine no state in double precision";
/// Distance from states that are lost in rounding, as a fraction of the path up to them.
const DISTANCE_FROM_ROUNDING: f64 = 1e-3;

/// Last imposed stretch or amount of shear between `start` and a missing state, at a distance from states that rounding decides.
fn last_state(path: &LoadingPath<'_>, start: f64, missing: f64) -> f64 {
    let (mut found, mut lost) = (start, missing);
    for _ in 0..40 {
        let middle = 0.5 * (found + lost);
        match path.at(path.loading.mode.parameter(middle)) {
            Some(_) => found = middle,
            None => lost = middle,
        }
    }
    found - DISTANCE_FROM_ROUNDING * (found - start)
}

/// Largest scaled minimum that counts as a rounding error.
const SCALED_ROUNDING: f64 = 1e-12;
/// Number of states along a path.
const SAMPLES: usize = 97;
/// Number of states that are evaluated together.
const GROUP: usize = 8;

/// A state on a path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PathSample {
    /// Path parameter, 0 at the start, 1 at the end.
    pub parameter: f64,
    /// Coordinate of the state along the path, with the label [`PathSamples::abscissa`].
    pub abscissa: f64,
    /// Deformation gradient `F_iJ`, by rows.
    pub deformation_gradient: [[f64; 3]; 3],
    /// Response of the law; `None` if it cannot be evaluated.
    #[serde(skip)]
    pub material: Option<MaterialSample>,
    /// Verdict and measures of the state; `None` if the method or the law cannot be evaluated.
    #[serde(skip)]
    pub state: Option<SurveyedState<3>>,
}

/// Response of the law at a state on a path, even if the method is undefined there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialSample {
    /// Smallest acoustic eigenvalue in the dimensions of the lattice; zero if it is within rounding of zero. Units of stress.
    pub minimum_acoustic_eigenvalue: f64,
    /// Cauchy stress `sigma_ij`. Units of stress.
    pub cauchy: [[f64; 3]; 3],
}

impl MaterialSample {
    fn of(problem: &Problem, f: &DeformationGradient) -> Option<Self> {
        Some(Self {
            minimum_acoustic_eigenvalue: problem.analysis.acoustic_minimum(f).ok()?.significant(),
            cauchy: rows(&problem.material.response(f).ok()?.cauchy()),
        })
    }
}

impl PathSample {
    /// Verdict on the state; `None` if it cannot be evaluated.
    pub fn verdict(&self) -> Option<Verdict> {
        Some(self.state.as_ref()?.verdict)
    }
}

/// Samples of the states along a path, at equal distances.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PathSamples {
    /// Label of the coordinate along the path.
    pub abscissa: &'static str,
    /// States along the path.
    pub samples: Vec<PathSample>,
    /// All settings in effect.
    pub settings: Effective,
    /// Number of space dimensions.
    #[serde(skip)]
    dimension: usize,
}

fn softest(state: &SurveyedState<3>) -> f64 {
    let scaled = state.scaled_minimum;
    if scaled.abs() > SCALED_ROUNDING {
        scaled
    } else {
        0.0
    }
}

impl PathSamples {
    /// Evaluates states along a path in parallel.
    ///
    /// # Errors
    /// [`ProblemError`] when the path does not exist.
    pub fn new(problem: &Problem, course: &Course) -> Result<Self, ProblemError> {
        let (states, followed) = course.follow(problem, |path, told| {
            let last = (SAMPLES - 1) as f64;
            let state = |n: usize| {
                let s = n as f64 / last;
                Ok((s, path.at(s)?))
            };
            let states = (0..SAMPLES).map(state);
            let states = states.collect::<Result<Vec<_>, ProblemError>>()?;
            // If a loading ends early, its coordinate ends there too.
            let followed = match (course, told) {
                (Course::Loading { loading, .. }, Some(told)) => Course::Loading {
                    loading: *loading,
                    from: told.from,
                    to: told.to,
                },
                _ => *course,
            };
            Ok((states, followed))
        })?;
        let scope = Scope::current();
        // States of a group are evaluated together.
        let group = |states: &[(f64, DeformationGradient)]| {
            let deformations: Vec<DeformationGradient> = states.iter().map(|(_, f)| *f).collect();
            let surveyed = problem.analysis.states(&deformations);
            let samples = states
                .iter()
                .zip(surveyed)
                .map(|((s, f), state)| PathSample {
                    parameter: *s,
                    abscissa: followed.abscissa(*s).1,
                    deformation_gradient: *problem.found(f).components(),
                    material: MaterialSample::of(problem, f),
                    state: state.ok(),
                });
            samples.collect::<Vec<_>>()
        };
        Ok(Self {
            abscissa: followed.abscissa(0.0).0,
            samples: states
                .par_chunks(GROUP)
                .flat_map_iter(|states| scope.run(|| group(states)))
                .collect(),
            settings: problem.settings.effective(),
            dimension: problem.analysis.dimension(),
        })
    }

    /// First and last state as text.
    fn ends(&self) -> String {
        let state = |sample: Option<&PathSample>| {
            let sample =
                sample.map(|own| caption::state(&own.deformation_gradient, self.dimension));
            sample.unwrap_or_default()
        };
        let ends = [self.samples.first(), self.samples.last()].map(state);
        format!("from {} to {}", ends[0], ends[1])
    }

    /// The states as CSV.
    pub fn csv(&self) -> String {
        let of_state = |sample: &PathSample, value: fn(&SurveyedState<3>) -> f64| {
            sample.state.as_ref().map(value)
        };
        let stress =
            |sample: &PathSample, i: usize, j: usize| Some(sample.material.as_ref()?.cauchy[i][j]);
        Table::new(&self.samples, self.settings.units())
            .with("parameter", "1", |own| own.parameter)
            .with("abscissa", "1", |own| own.abscissa)
            .tensor("F", "1", |own| &own.deformation_gradient)
            .with("verdict", "1", |own| {
                own.verdict().map_or("undefined", Verdict::name)
            })
            .with("minimum_scaled", "1", move |own| of_state(own, softest))
            .with("minimum_omega_squared", "1/time^2", move |own| {
                of_state(own, |state| state.lowest_omega_squared)
            })
            .with("growth_rate", "1/time", move |own| {
                of_state(own, |state| state.growth_rate)
            })
            .with("minimum_acoustic_eigenvalue", "stress", |own| {
                Some(own.material.as_ref()?.minimum_acoustic_eigenvalue)
            })
            .with("s11", "stress", move |own| stress(own, 0, 0))
            .with("s22", "stress", move |own| stress(own, 1, 1))
            .with("s33", "stress", move |own| stress(own, 2, 2))
            .with("s12", "stress", move |own| stress(own, 0, 1))
            .to_string()
    }

    /// Draws the softest mode of the discretization and the smallest acoustic eigenvalue of the material along the path.
    ///
    /// `changes` are the parameters at which the stability of discretization and material changes.
    pub fn figure(&self, title: &str, changes: [&[f64]; 2]) -> Figure {
        let values = |value: &dyn Fn(&PathSample) -> Option<f64>| -> Vec<(f64, f64)> {
            let samples = self.samples.iter();
            samples
                .map(|sample| (sample.abscissa, value(sample).unwrap_or(f64::NAN)))
                .collect()
        };
        let ends = [self.samples.first(), self.samples.last()];
        let ends = ends.map(|end| end.map_or(0.0, |sample| sample.abscissa));
        let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let at = |parameter: &f64| ends[0] + (ends[1] - ends[0]) * parameter;
        let panel = |name: &str, label: String, points: Vec<(f64, f64)>, changes: &[f64], color| {
            let heights = points.iter().map(|point| point.1).chain([0.0]);
            let y = Axis::linear(label, (0.0, 1.0)).covering(heights.collect::<Vec<_>>());
            let x = Axis::linear(self.abscissa, (low, high));
            let mut panel =
                Panel::new(name, x, y).with(Rule::horizontal(0.0).color(palette::BLACK));
            for parameter in changes {
                let rule = Rule::vertical(at(parameter)).color(palette::GREY).dashed();
                panel = panel.with(rule.named("change of stability"));
            }
            panel.with(Line::new(points).color(color))
        };
        let units = self.settings.units();
        let stress = caption::label(units, "smallest acoustic eigenvalue", "stress");
        Figure::new(title)
            .columns(2)
            .with(panel(
                "Softest mode of the particles",
                "min Re ω² / (c² |k|²) (−)".to_owned(),
                values(&|sample| sample.state.as_ref().map(softest)),
                changes[0],
                palette::BLUE,
            ))
            .with(panel(
                "Material",
                stress,
                values(&|sample| Some(sample.material?.minimum_acoustic_eigenvalue)),
                changes[1],
                palette::VERMILION,
            ))
            .caption(format!(
                "States {}. {}",
                self.ends(),
                caption::settings(&self.settings)
            ))
    }

    /// The states as `path.csv`, and the figure `path` with the changes of an answer.
    pub fn files(&self, answer: &PathAnswer) -> Files {
        let parameters = |crossings: &[CrossingAnswer]| -> Vec<f64> {
            let parameters = crossings.iter().map(|crossing| crossing.parameter);
            parameters.collect()
        };
        let particles = parameters(&answer.discretization_crossings);
        let material = parameters(&answer.material_crossings);
        let title = match &answer.loading {
            Some(loading) => format!("Stability under loading: {}", loading.title),
            None => format!("Stability along a path {}", self.ends()),
        };
        let figure = self.figure(&title, [&particles, &material]);
        vec![text("path.csv", self.csv()), picture("path", figure)]
    }
}
