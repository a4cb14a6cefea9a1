//! Effect of a stabilization coefficient, and the recommended value.

use super::TuneQuestion;
use crate::answers::{Evidence, LATTICE_NOTE, Problem, ProblemError, notes, stabilization};
use crate::brief::{Brief, Short, WIDTH};
use crate::compare::{Measured, TUNING_LIMITS, Thresholds, outcome, percent};
use crate::csv::Table;
use crate::figure::{Axis, Figure, Line, Panel, Rule, palette};
use crate::number;
use crate::output::{Files, picture, text};
use crate::range::middle;
use crate::settings::{CompareSettings, Effective, Key, Settings, Shear};
use onset::cancel::Scope;
use onset::measures::StretchOnset;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt;
use std::sync::Arc;

/// Coefficients that damp waves and have no stiffness.
const DAMPING: [&str; 3] = [
    "discretization.viscosity",
    "discretization.velocity-smoothing",
    "discretization.hourglass-viscosity",
];

/// Number of bisections for the smallest sufficient value.
const HALVINGS: usize = 12;

/// Result for one value of the coefficient.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tried {
    /// Value of the coefficient.
    pub value: f64,
    /// Measured errors, or the reason why the value cannot be evaluated.
    #[serde(flatten, serialize_with = "outcome")]
    pub measured: Result<Measured, String>,
}

impl Tried {
    /// Returns true if there are no spurious modes and no false instability.
    pub fn is_sufficient(&self, limits: &Thresholds) -> bool {
        self.measured.as_ref().is_ok_and(|measured| {
            measured.zero_modes == 0
                && !measured.is_weak(limits.weak)
                && measured.fidelity.false_instability <= limits.wrong
        })
    }

    /// Returns true if the value is sufficient and does not mask.
    fn is_recommended(&self, limits: &Thresholds) -> bool {
        self.is_sufficient(limits) && !self.masks(limits)
    }

    /// Returns true if the instability of the material is masked: the discretization is stable where the material is not, or loses stability much
    /// later.
    pub fn masks(&self, limits: &Thresholds) -> bool {
        self.measured.as_ref().is_ok_and(|measured| {
            let later = measured.onsets.iter().any(|pair| {
                let is_suppressed = pair.material.stretch().is_some()
                    && matches!(pair.method, StretchOnset::NotBefore(_));
                pair.ratio() > 1.0 + limits.later || is_suppressed
            });
            later || measured.fidelity.suppressed_instability > limits.wrong
        })
    }
}

/// Answer of `onset tune`: the recommended coefficient, with all values that were tried.
#[derive(Clone, Debug, Serialize)]
pub struct TuneAnswer {
    /// The key of the coefficient.
    pub key: &'static str,
    /// The smallest value that is sufficient and does not mask, or `None`.
    pub recommended: Option<f64>,
    /// Thresholds for sufficient and masking values.
    pub thresholds: Thresholds,
    /// Recommendations for other thresholds, from the values that were tried.
    pub dependence: Vec<Dependence>,
    /// Whether any value is sufficient.
    pub is_ever_sufficient: bool,
    /// All values that were tried, in increasing order.
    pub tried: Vec<Tried>,
    /// Evidence for the recommendation: `searched`.
    pub evidence: Evidence,
    /// Notes on law and method.
    pub notes: Vec<String>,
    /// All settings in effect except the coefficient.
    pub settings: Effective,
}

/// Recommendation for a threshold that is halved or doubled.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Dependence {
    /// Name of the threshold.
    pub threshold: &'static str,
    /// Changed value of the threshold.
    pub value: f64,
    /// Smallest value tried that would then be sufficient and not mask, or `None`.
    pub recommended: Option<f64>,
}

/// Smallest recommended value of an interval.
struct Least {
    exact: f64,
    /// Value rounded up for printing, if it is recommended, too.
    printed: f64,
}

/// Bisects for the smallest recommended value of an interval whose upper end is recommended and whose lower end is not.
fn refined([mut low, mut high]: [f64; 2], mut is_recommended: impl FnMut(f64) -> bool) -> Least {
    for _ in 0..HALVINGS {
        let middle = middle(low, high);
        match is_recommended(middle) {
            true => high = middle,
            false => low = middle,
        }
    }
    let rounded = rounded_up(high);
    Least {
        exact: high,
        printed: if is_recommended(rounded) {
            rounded
        } else {
            high
        },
    }
}

/// Smallest recommended value alone, for other answers; `None` if no value is recommended or can be evaluated.
///
/// The onsets and the states of a value are evaluated only if it leaves no spurious mode.
pub(crate) fn recommended(settings: &Settings, question: &TuneQuestion) -> Option<f64> {
    question.check(settings).ok()?;
    let limits = question.thresholds;
    let law = settings.law().ok()?;
    let options = options(question);
    let is_recommended = |value: f64| {
        onset::cancel::checkpoint();
        let Ok(settings) = question.settings(settings, value) else {
            return false;
        };
        let problem = Problem::with_law(settings.clone(), Arc::clone(&law));
        let spurious = problem
            .ok()
            .and_then(|own| own.analysis.spurious_modes(limits.weak).ok());
        let one = || Tried {
            value,
            measured: Measured::of(&settings, Arc::clone(&law), &options)
                .map_err(|error| error.to_string()),
        };
        spurious.is_some_and(|own| own.modes.is_empty()) && one().is_recommended(&limits)
    };
    let values = question.values();
    match values.iter().position(|value| is_recommended(*value))? {
        0 => Some(values[0]),
        n => Some(refined([values[n - 1], values[n]], is_recommended).printed),
    }
}

/// Options of the measurements. Tuning needs fewer states than a comparison.
fn options(question: &TuneQuestion) -> CompareSettings {
    CompareSettings {
        stretches: question.stretches,
        states: 8,
        weak: question.thresholds.weak,
        ..CompareSettings::default()
    }
}

impl TuneAnswer {
    /// Evaluates all values in parallel, and refines the smallest sufficient value; `told` is called with each value of the grid.
    ///
    /// # Errors
    /// [`ProblemError`] when the material is invalid, no value can be evaluated, or the method does not use the coefficient.
    pub fn new(
        settings: &Settings,
        question: &TuneQuestion,
        told: impl Fn(f64) + Sync,
    ) -> Result<Self, ProblemError> {
        question.check(settings)?;
        let limits = question.thresholds;
        let law = settings.law();
        let material = law.map_err(|error| ProblemError::of(settings, error.into()))?;
        let options = options(question);
        let measured = |value: f64| {
            let settings = question.settings(settings, value)?;
            Measured::of(&settings, Arc::clone(&material), &options)
        };
        let tried = |value: f64| Tried {
            value,
            measured: measured(value).map_err(|error| error.to_string()),
        };
        let scope = Scope::current();
        let mut all: Vec<Tried> = question
            .values()
            .into_par_iter()
            .map(|value| {
                told(value);
                scope.run(|| tried(value))
            })
            .collect();
        if all.iter().all(|one| one.measured.is_err()) {
            // The settings or the range are at fault; the error of the first value is reported.
            let [low, high] = question.range;
            measured(low).map_err(|source| ProblemError::Range {
                key: question.key(),
                low,
                high,
                source: Box::new(source),
            })?;
        }
        let first = all.iter().position(|one| one.is_recommended(&limits));
        let mut recommended = first.map(|n| all[n].value);
        if let Some(n) = first.filter(|n| *n > 0) {
            let range = [all[n - 1].value, all[n].value];
            let least = refined(range, |value| {
                let found = tried(value);
                let is_recommended = found.is_recommended(&limits);
                all.push(found);
                is_recommended
            });
            // A value that is rounded up replaces the exact one.
            if least.printed != least.exact {
                all.retain(|one| one.value != least.exact);
            }
            recommended = Some(least.printed);
        }
        all.sort_by(|a, b| a.value.total_cmp(&b.value));
        let is_ever_sufficient = all.iter().any(|one| one.is_sufficient(&limits));
        let mut notes = notes(settings, &*material);
        if !is_ever_sufficient && DAMPING.contains(&question.key()) {
            notes.push(format!(
                "{} is a damping without stiffness: it slows the growth of waves, but changes neither zero-energy modes nor the frequencies of weakly controlled modes{}",
                question.key(),
                stiffness(settings)
            ));
        }
        Ok(Self {
            key: question.key(),
            recommended,
            thresholds: limits,
            dependence: limits
                .varied(&TUNING_LIMITS)
                .into_iter()
                .map(|(threshold, value, limits)| Dependence {
                    threshold,
                    value,
                    recommended: all
                        .iter()
                        .find(|one| one.is_recommended(&limits))
                        .map(|one| one.value),
                })
                .collect(),
            is_ever_sufficient,
            tried: all,
            evidence: Evidence::Searched,
            notes,
            settings: settings.effective().without(question.key()),
        })
    }

    /// Figure of the errors as functions of the value.
    pub fn figure(&self) -> Figure {
        let positive: Vec<f64> = self
            .tried
            .iter()
            .map(|one| one.value)
            .filter(|x| *x > 0.0)
            .collect();
        let key = Key::named(self.key);
        let units = self.settings.units();
        let label = key.map_or_else(String::new, |key| {
            crate::caption::label(units, key.title(), key.unit().unwrap_or("1"))
        });
        let axis = || Axis::log(label.clone(), (1e-4, 1.0)).covering(positive.clone());
        let line = |number: &dyn Fn(&Measured) -> f64| {
            let points = self
                .tried
                .iter()
                .filter(|one| one.value > 0.0)
                .filter_map(|one| Some((one.value, number(one.measured.as_ref().ok()?))));
            Line::new(points.collect())
        };
        let marked = |panel: Panel| match self.recommended.filter(|value| *value > 0.0) {
            Some(value) => panel.with(
                Rule::vertical(value)
                    .dashed()
                    .named("smallest sufficient value"),
            ),
            None => panel,
        };
        let shares = Axis::linear("fraction of the window of states (%)", (0.0, 100.0))
            .covering([0.0, 100.0]);
        let measured = || {
            self.tried
                .iter()
                .filter_map(|one| one.measured.as_ref().ok())
        };
        let frequency = Axis::linear(
            "frequency relative to the material's slowest wave (−)",
            (0.0, 1.0),
        )
        .covering(
            measured()
                .map(|own| own.weakest)
                .chain([0.0, self.thresholds.weak]),
        );
        let steps = Axis::linear("c Δt / spacing (−)", (0.0, 1.0));
        let steps = steps.covering(measured().map(|own| own.courant).chain([0.0]));
        Figure::new(format!("Effect of {}", self.key))
            .columns(3)
            .with(marked(
                Panel::new("Most weakly controlled mode", axis(), frequency)
                    .with(line(&|m| m.weakest).color(palette::BLUE))
                    .with(
                        Rule::horizontal(self.thresholds.weak)
                            .dotted()
                            .named("least admitted frequency"),
                    ),
            ))
            .with(marked(
                Panel::new("Wrong verdicts", axis(), shares)
                    .with(
                        line(&|m| 100.0 * m.fidelity.false_instability)
                            .color(palette::ORANGE)
                            .named("unstable though the material is elliptic"),
                    )
                    .with(
                        line(&|m| 100.0 * m.fidelity.suppressed_instability)
                            .color(palette::BLACK)
                            .dotted()
                            .named("stable though the material is not elliptic"),
                    ),
            ))
            .with(marked(
                Panel::new("Critical time step", axis(), steps)
                    .with(line(&|m| m.courant).color(palette::GREEN)),
            ))
            .caption(crate::caption::settings(&self.settings))
    }

    /// Smallest Courant number of the body of the study, as text.
    fn body(&self) -> String {
        let measured = self
            .tried
            .iter()
            .filter_map(|one| one.measured.as_ref().ok());
        let least = measured.filter_map(|m| m.body_courant).reduce(f64::min);
        least.map_or_else(String::new, |least| {
            format!(
                "\n\
                     body of the study: with all of these values at least {}",
                number::told_below(least)
            )
        })
    }

    /// All values as CSV.
    pub fn csv(&self) -> String {
        let dimension = Key::named(self.key).and_then(|key| key.unit());
        let measured =
            |own: &Tried, value: &dyn Fn(&Measured) -> f64| own.measured.as_ref().ok().map(value);
        let limits = &self.thresholds;
        Table::new(&self.tried, self.settings.units())
            .with("value", dimension.unwrap_or("1"), |own| own.value)
            .with("zero_modes", "1", |own| {
                own.measured.as_ref().ok().map(|m| m.zero_modes)
            })
            .with("zero_modes_complete", "1", |own| {
                own.measured.as_ref().ok().map(|m| m.zero_modes_complete)
            })
            .with("weakest", "1", |own| measured(own, &|m| m.weakest))
            .with("false_instability", "1", |own| {
                measured(own, &|m| m.fidelity.false_instability)
            })
            .with("suppressed_instability", "1", |own| {
                measured(own, &|m| m.fidelity.suppressed_instability)
            })
            .with("courant", "1", |own| measured(own, &|m| m.courant))
            .with("dispersion_8", "1", |own| {
                measured(own, &|m| m.dispersion_at(8.0))
            })
            .with("sufficient", "1", |own| {
                own.measured.is_ok().then(|| own.is_sufficient(limits))
            })
            .with("masks", "1", |own| {
                own.measured.is_ok().then(|| own.masks(limits))
            })
            .with("note", "1", |own| own.measured.as_ref().err().cloned())
            .to_string()
    }

    /// The answer as `tune.csv` and the figure `tune`.
    pub fn files(&self) -> Files {
        vec![text("tune.csv", self.csv()), picture("tune", self.figure())]
    }
}

/// Clause on a stiffness that replaces a damping, or an empty text.
fn stiffness(settings: &Settings) -> String {
    // Artificial stress has no stiffness in a body without stress.
    let key = match (stabilization(settings, true), settings.method.shear_forces) {
        (Some("discretization.artificial-stress"), Shear::Stress) => Some("discretization.penalty"),
        (Some("discretization.artificial-stress"), Shear::Pairs) => None,
        (key, _) => key,
    };
    key.map_or_else(String::new, |key| {
        format!("; {key} is a stiffness that can be tuned")
    })
}

/// Smallest number of six digits that is not below a positive number.
fn rounded_up(value: f64) -> f64 {
    let unit = 10.0_f64.powf(value.log10().floor() - 5.0);
    let rounded = format!("{:.5e}", (value / unit).ceil() * unit);
    rounded.parse().unwrap_or(value)
}

impl TuneAnswer {
    /// Sentence of the answer.
    fn sentence(&self) -> String {
        let key = self.key;
        match self.recommended {
            Some(value) => format!(
                "{key} = {}: the smallest value found that removes the spurious modes and does not mask the material's instability",
                number::told(value)
            ),
            None if self.is_ever_sufficient => format!(
                "No value of {key} removes the spurious modes without masking the material's instability"
            ),
            None => format!("No value of {key} in the range removes the spurious modes"),
        }
    }

    /// One line of the table, for one value.
    fn line(&self, one: &Tried) -> String {
        let value = number::told(one.value);
        match &one.measured {
            Ok(m) => format!(
                "  {value:>11}  {:>10}  {:>8.4}  {:>6.2} %  {:>8.2} %  {:>8.4}  {}",
                m.zero_modes,
                m.weakest,
                100.0 * m.fidelity.false_instability,
                100.0 * m.fidelity.suppressed_instability,
                m.courant,
                match (
                    one.is_sufficient(&self.thresholds),
                    one.masks(&self.thresholds)
                ) {
                    (true, false) => "sufficient",
                    (true, true) => "sufficient, but masks",
                    (false, false) => "not sufficient",
                    (false, true) => "not sufficient, and masks",
                }
            ),
            Err(why) => format!("  {value:>11}  {}", why.lines().next().unwrap_or_default()),
        }
    }

    /// Head of the table.
    fn head() -> String {
        format!(
            "  {:>11}  {:>10}  {:>8}  {:>8}  {:>10}  {:>8}  verdict",
            "value", "zero modes", "weakest", "false", "suppressed", "Courant"
        )
    }

    /// Most important values: the ends of the range, the recommended value and its neighbors.
    fn decisive(&self) -> Vec<&Tried> {
        let recommended = self
            .recommended
            .and_then(|value| self.tried.iter().position(|one| one.value == value));
        let last = self.tried.len().saturating_sub(1);
        let kept = |n: usize| {
            n == 0 || n == last || recommended.map_or(n == last / 2, |at| n.abs_diff(at) <= 1)
        };
        let tried = self.tried.iter().enumerate();
        tried
            .filter(|(n, _)| kept(*n))
            .map(|(_, one)| one)
            .collect()
    }
}

impl Brief for TuneAnswer {
    fn brief(&self) -> Short {
        if !self.is_ever_sufficient && DAMPING.contains(&self.key) {
            // Every value gives the same answer, so that no table is needed.
            return Short::new(format!("{}.", self.sentence()))
                .notes(&self.notes)
                .settings("settings", self.settings.caption());
        }
        let limits = &self.thresholds;
        let shown = self.decisive();
        let lines = shown.iter().map(|one| {
            let line = self.line(one);
            match line.chars().count() > WIDTH {
                true => line.chars().take(WIDTH - 1).chain(['…']).collect(),
                false => line,
            }
        });
        let mut short = Short::new(format!("{}.", self.sentence()))
            .table(std::iter::once(Self::head()).chain(lines))
            .row(
                0,
                "limits",
                format!(
                    "weakest at least {} (--weak), false and suppressed at most {} (--wrong)",
                    percent(limits.weak),
                    percent(limits.wrong)
                ),
            )
            .row(1, "Courant", format!("c dt / h; {LATTICE_NOTE}"));
        if self.tried.len() > shown.len() {
            let others = self.tried.len() - shown.len();
            short = short.row(2, "values", format!("{} others: --all", others));
        }
        short
            .notes(&self.notes)
            .settings("settings", self.settings.caption())
    }
}

impl fmt::Display for TuneAnswer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(formatter, "{}\n", self.sentence())?;
        writeln!(formatter, "{}", Self::head())?;
        for one in &self.tried {
            writeln!(formatter, "{}", self.line(one))?;
        }
        let limits = &self.thresholds;
        writeln!(
            formatter,
            "\nsufficient: no zero-energy modes, no wave slower than {} of the material's slowest (--weak), at most {} of the states falsely \
             unstable (--wrong)\n\
             masks: more than {} of the states stable though the material is not elliptic (--wrong), or onset later than the material's by \
             more than {} of its strain (--later)\n\
             Courant: critical time step times speed of sound over the particle spacing; {LATTICE_NOTE}{}\n\nwith other limits, of the values above",
            percent(limits.weak),
            percent(limits.wrong),
            percent(limits.wrong),
            percent(limits.later),
            self.body()
        )?;
        for one in &self.dependence {
            let value = one.recommended.map_or("none".to_owned(), number::told);
            let limit = number::told(one.value);
            writeln!(formatter, "  --{} {limit}: {value}", one.threshold)?;
        }
        for note in &self.notes {
            writeln!(formatter, "\n\nnote: {note}")?;
        }
        write!(formatter, "\n\n{}\n{}", self.evidence, self.settings)
    }
}
