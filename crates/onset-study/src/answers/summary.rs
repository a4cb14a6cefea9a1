//! Summary of a study before it is computed.

use super::finite_body::BodyStepAnswer;
use super::notes::{note_on_mapped_body, notes};
use super::problem::{Problem, ProblemError};
use crate::map::{Forecast, PATIENCE, edge, tiling};
use crate::number::{counted, told_below};
use crate::settings::{Axis, Effective, MapSettings, Quantity, Study, Units, Value};
use onset::kinematics::DeformationGradient;
use onset::method::MethodError;
use onset::time_step::Integrator;
use serde::Serialize;
use std::collections::BTreeMap;

/// Summary of a study, with warnings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StudySummary {
    /// Path of the study file.
    pub file: String,
    /// Always `true`; the entry of an invalid file has `false`.
    pub valid: bool,
    /// Title of the study.
    pub title: String,
    /// Name of the law.
    pub model: &'static str,
    /// Parameters of the law that no axis varies.
    pub parameters: BTreeMap<&'static str, Value>,
    /// All settings in effect that no axis varies.
    pub settings: Effective,
    /// Components of the deformation that no axis varies.
    pub held_fixed: BTreeMap<&'static str, f64>,
    /// Axes of the map.
    pub axes: Vec<AxisSummary>,
    /// Critical step of the body of the study in the reference configuration; `None` without a body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<BodyStepAnswer>,
    /// Settings of the map.
    pub map: MapSettings,
    /// Number of states of the map, zero without axes.
    pub states: usize,
    /// Number of tiles of the map.
    pub tiles: usize,
    /// Number of sampled states at which discretization and material were evaluated.
    pub sampled: usize,
    /// Number of sampled states without a verdict.
    pub undefined: usize,
    /// Estimated number of states that will be computed, from a trial run on sampled states; the remaining states are filled in. `null` if a library
    /// must be allowed first.
    pub evaluations: Option<u64>,
    /// Processor time of one computed state, the mean over the sampled states; seconds. `null` if a library must be allowed first.
    pub seconds_per_state: Option<f64>,
    /// Processor time of the whole map; seconds. `null` if a library must be allowed first.
    pub seconds: Option<f64>,
    /// Notes on law and method.
    pub notes: Vec<String>,
    /// Warnings about the study.
    pub warnings: Vec<String>,
}

/// Axis of a map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisSummary {
    /// Quantity that the axis varies.
    pub quantity: &'static str,
    /// First and last value of the axis.
    pub range: (f64, f64),
    /// Unit of the quantity on the axis.
    pub unit: &'static str,
    /// Number of states along the axis.
    pub states: usize,
}

impl StudySummary {
    /// Summarizes a study: evaluates a coarse grid of its states, and computes some of them like the map.
    ///
    /// # Errors
    /// [`ProblemError`] when material or method are invalid at one of these states.
    pub fn new(file: &str, study: &Study) -> Result<Self, ProblemError> {
        // Without permission no library is loaded, so no state can be evaluated.
        let not_loaded = study.settings.material.permitted().err();
        let is_mapped = !study.axes.is_empty();
        let (samples, forecast) = match not_loaded {
            None if is_mapped => (Samples::of(study)?, Some(Forecast::of(study, PATIENCE)?)),
            _ => (Samples::default(), None),
        };
        let body = match (&not_loaded, &study.settings.body) {
            (None, Some(_)) => {
                let problem = Problem::new(study.settings.clone())?;
                let rest = DeformationGradient::identity();
                let stiffer = problem.stiffer_at(&rest)?;
                let limiting = stiffer.as_ref().unwrap_or(&problem);
                BodyStepAnswer::new(limiting, &rest, Integrator::CentralDifferences)?
            }
            _ => None,
        };
        let varied = |name: &str| {
            study
                .axes
                .iter()
                .any(|axis| axis.quantity.key_name() == name)
        };
        // In plane stress the stretch across the sheet follows from equilibrium.
        let extent = study.settings.extent();
        let is_found = |quantity: &Quantity| {
            let across = extent.dimension + 1..=3;
            extent.leaves_none_beyond()
                && matches!(quantity, Quantity::Stretch(n) if across.contains(n))
        };
        let fixed = Quantity::OF_STATE
            .into_iter()
            .filter(|quantity| !is_found(quantity))
            .filter(|quantity| !varied(&quantity.key_name()))
            .filter_map(|quantity| Some((quantity.name(), study.state.value(quantity.name())?)));
        let parameters = study.settings.material.entries().into_iter();
        Ok(Self {
            file: file.to_owned(),
            valid: true,
            title: study.title.clone(),
            model: study.settings.material.model.name(),
            parameters: parameters
                .filter(|(name, _)| !varied(&format!("material.{name}")))
                .collect(),
            settings: study.effective(),
            held_fixed: fixed.collect(),
            axes: study
                .axes
                .iter()
                .map(|axis| AxisSummary::of(axis, study.settings.units()))
                .collect(),
            body,
            map: study.map,
            states: if is_mapped { study.states() } else { 0 },
            tiles: if is_mapped { tiling(study).tiles() } else { 0 },
            sampled: samples.looked_at,
            undefined: samples.undefined,
            evaluations: forecast.map(|forecast| forecast.evaluations),
            seconds_per_state: forecast.map(|forecast| forecast.seconds_per_state),
            seconds: forecast.map(|forecast| forecast.seconds()),
            notes: study
                .settings
                .law()
                .map_or_else(
                    |_| Vec::new(),
                    |material| notes(&study.settings, &*material),
                )
                .into_iter()
                .chain(note_on_mapped_body(study))
                .collect(),
            warnings: warnings(study, &samples)
                .into_iter()
                .chain(not_loaded.map(|error| error.to_string()))
                .collect(),
        })
    }
}

impl AxisSummary {
    fn of(axis: &Axis, units: Units) -> Self {
        Self {
            quantity: axis.name(),
            range: axis.range,
            unit: units.unit(axis.unit()),
            states: axis.count,
        }
    }
}

/// Test evaluation of some states.
#[derive(Default)]
struct Samples {
    looked_at: usize,
    undefined: usize,
    /// The first reason, with the state.
    reason: Option<String>,
}

impl Samples {
    /// Evaluates a coarse grid of states over all axes.
    fn of(study: &Study) -> Result<Self, ProblemError> {
        let along = if study.axes.len() == 2 { 9 } else { 5 };
        let mut samples = Self {
            looked_at: 0,
            undefined: 0,
            reason: None,
        };
        for coordinates in sampled(study, along) {
            samples.looked_at += 1;
            let problem = Problem::new(study.settings_at(&coordinates)?)?;
            let f = study.deformation_at(&coordinates)?;
            if let Err(error) = look(&problem, &f) {
                samples.undefined += 1;
                samples
                    .reason
                    .get_or_insert_with(|| format!("at {}: {error}", named(study, &coordinates)));
            }
        }
        Ok(samples)
    }
}

/// Coordinates of at most `along` states along each axis, including the first and the last.
fn sampled(study: &Study, along: usize) -> Vec<Vec<f64>> {
    let mut grid = vec![Vec::new()];
    for axis in &study.axes {
        let some = along.min(axis.count);
        let states = (0..some).map(|n| axis.coordinate(n * (axis.count - 1) / (some - 1).max(1)));
        let states: Vec<f64> = states.collect();
        grid = grid
            .iter()
            .flat_map(|start: &Vec<f64>| {
                states
                    .iter()
                    .map(|state| start.iter().chain([state]).copied().collect())
            })
            .collect();
    }
    grid
}

/// Checks that discretization and material can be evaluated at a state.
fn look(problem: &Problem, f: &DeformationGradient) -> Result<(), ProblemError> {
    problem.material.response(f).map_err(MethodError::from)?;
    problem.analysis.waves(f)?;
    Ok(())
}

fn named(study: &Study, coordinates: &[f64]) -> String {
    let value = |(axis, value): (&Axis, &f64)| format!("{} = {value:.4}", axis.name());
    let values: Vec<String> = study.axes.iter().zip(coordinates).map(value).collect();
    values.join(", ")
}

fn listed<T: std::fmt::Display>(values: &BTreeMap<&'static str, T>) -> String {
    let value = |(name, value): (&&str, &T)| format!("{name} = {value}");
    values.iter().map(value).collect::<Vec<_>>().join(", ")
}

fn warnings(study: &Study, samples: &Samples) -> Vec<String> {
    let mut warnings = Vec::new();
    for name in ["discretization.spacing", "discretization.density"] {
        if study.axes.iter().any(|axis| axis.name() == name) {
            warnings.push(format!(
                "the axis {name} moves no boundary of stability; it scales frequencies only"
            ));
        }
    }
    if let Some(reason) = &samples.reason {
        warnings.push(format!(
            "{} of {} sampled states have no verdict; the first {reason}",
            samples.undefined, samples.looked_at
        ));
    }
    warnings
}

impl std::fmt::Display for StudySummary {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut line = |name: &str, text: String| writeln!(formatter, "{name:<16}{text}");
        let axis = |axis: &AxisSummary| {
            let unit = if axis.unit == "1" { "" } else { axis.unit };
            let ends = format!(
                "{} from {} to {} {unit}",
                axis.quantity, axis.range.0, axis.range.1
            );
            format!("{}, {} states", ends.trim_end(), axis.states)
        };
        line("valid", self.file.clone())?;
        if !self.title.is_empty() {
            line("title", self.title.clone())?;
        }
        for (name, (chosen, defaults)) in [
            ("material", self.settings.material()),
            ("discretization", self.settings.discretization()),
        ] {
            line(name, chosen)?;
            if !defaults.is_empty() {
                line("  by default", defaults)?;
            }
        }
        if let Some(body) = &self.body {
            let units = self.settings.units();
            let step = body.time_step.map_or_else(String::new, |step| {
                let step = units.of(told_below(step), "s");
                format!("; central differences need a time step below {step}")
            });
            let particles = counted(body.particles, "particle");
            line("body", format!("{particles}{step}"))?;
        }
        if !self.axes.is_empty() {
            line("held fixed", listed(&self.held_fixed))?;
        }
        for (number, summary) in self.axes.iter().enumerate() {
            line(if number == 0 { "axes" } else { "" }, axis(summary))?;
        }
        if !self.axes.is_empty() {
            line("map", self.map_words())?;
        }
        if let (Some(seconds), Some(each)) = (self.seconds, self.seconds_per_state) {
            let computed = self.evaluations.unwrap_or(0);
            let filled = match computed < self.states as u64 {
                true => format!("; about {computed} states are computed, the others filled in"),
                false => String::new(),
            };
            let work = format!(
                "{} of processor time, {} a state{filled}",
                duration(seconds),
                duration(each)
            );
            line("estimated work", work)?;
        }
        self.notes
            .iter()
            .try_for_each(|note| line("note", note.clone()))?;
        self.warnings
            .iter()
            .try_for_each(|warning| line("warning", warning.clone()))
    }
}

impl StudySummary {
    fn map_words(&self) -> String {
        let axes = self.axes.len();
        let edge = vec![edge(self.map.tile, axes).to_string(); axes].join(" x ");
        let way = match self.map.adaptive {
            true => format!("adaptive from a stride of {}", self.map.refine_from),
            false => "every state".to_owned(),
        };
        let certified = match self.map.certify {
            true => format!(", certified to {:e}", self.map.tolerance),
            false => String::new(),
        };
        format!(
            "{} states in {} of {edge}, {way}{certified}",
            self.states,
            counted(self.tiles, "tile")
        )
    }
}

/// A duration to two digits.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1e-4 => format!("{:.1} µs", 1e6 * s),
        s if s < 0.01 => format!("{:.2} ms", 1e3 * s),
        s if s < 1.0 => format!("{:.0} ms", 1e3 * s),
        s if s < 120.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
