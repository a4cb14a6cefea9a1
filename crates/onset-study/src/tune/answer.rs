//! What a coefficient does, and which value to take.

use super::TuneQuestion;
use crate::answers::{ProblemError, notes};
use crate::compare::{Measured, outcome};
use crate::csv;
use crate::figure::{Axis, Figure, FigureError, Line, Panel, Rule, palette};
use crate::output::{Files, text};
use crate::settings::{CompareSettings, Effective, Settings};
use onset::material::Hyperelastic;
use onset::measures::StretchOnset;
use onset::method::MethodError;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt;
use std::sync::Arc;

/// The relative frequency above which no wave counts as spurious.
const STRONG: f64 = 0.1;
/// Shares of the window of states below which verdicts count as right.
const WRONG: f64 = 0.005;
/// Onsets later than the material's by this share of its strain count as hidden.
const LATER: f64 = 0.02;
/// Halvings of the interval in which the cure begins.
const HALVINGS: usize = 12;

/// What a value of the coefficient does.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct Tried {
    /// The value.
    pub value: f64,
    /// What is measured; why not where it cannot be.
    #[serde(flatten, serialize_with = "outcome")]
    pub measured: Result<Measured, String>,
}

impl Tried {
    /// Whether there are no spurious modes, and no false instability.
    pub fn cures(&self) -> bool {
        self.measured.as_ref().is_ok_and(|measured| {
            measured.zero_modes == 0
                && measured.weakest >= STRONG
                && measured.fidelity.false_instability <= WRONG
        })
    }

    /// Whether the instability of the material is hidden: stable where it is not, or unstable clearly later.
    pub fn hides(&self) -> bool {
        self.measured.as_ref().is_ok_and(|measured| {
            let later = measured.onsets.iter().any(|pair| {
                let is_missed = pair.material.stretch().is_some()
                    && matches!(pair.method, StretchOnset::NotBefore(_));
                pair.ratio() > 1.0 + LATER || is_missed
            });
            later || measured.fidelity.missed_instability > WRONG
        })
    }
}

/// The tuned coefficient.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct TuneAnswer {
    /// The key of the coefficient.
    pub key: &'static str,
    /// The smallest value that cures and does not hide; `None` when there is none.
    pub recommended: Option<f64>,
    /// Whether some value cures at all.
    pub is_curable: bool,
    /// Everything that was tried, by increasing value.
    pub tried: Vec<Tried>,
    /// What a reader must know of law and method.
    pub notes: Vec<String>,
    /// Every choice in effect beside the coefficient.
    pub settings: Effective,
}

impl TuneAnswer {
    /// Looks at all values, on all cores, and refines where the cure begins; `told` is called with each value of the grid.
    ///
    /// # Errors
    /// [`ProblemError`] when the material is not admissible, no value is, or the method does not read the coefficient.
    pub fn new(
        settings: &Settings,
        question: &TuneQuestion,
        told: impl Fn(f64) + Sync,
    ) -> Result<Self, ProblemError> {
        question.check(settings)?;
        let material = settings.material.build().map_err(MethodError::from)?;
        let material: Arc<dyn Hyperelastic> = Arc::from(material);
        // Fewer states than a comparison takes.
        let options = CompareSettings {
            stretches: question.stretches,
            states: 8,
            ..CompareSettings::default()
        };
        let measured = |value: f64| {
            let settings = question.settings(settings, value)?;
            Measured::of(&settings, Arc::clone(&material), &options)
        };
        let tried = |value: f64| Tried {
            value,
            measured: measured(value).map_err(|error| error.to_string()),
        };
        let mut all: Vec<Tried> = question
            .values()
            .into_par_iter()
            .map(|value| {
                told(value);
                tried(value)
            })
            .collect();
        if all.iter().all(|one| one.measured.is_err()) {
            // The settings are at fault, or the range: the first value tells how.
            let [low, high] = question.range;
            measured(low).map_err(|source| ProblemError::Range {
                key: question.key(),
                low,
                high,
                source: Box::new(source),
            })?;
        }
        let first = all.iter().position(|one| one.cures() && !one.hides());
        let mut recommended = first.map(|n| all[n].value);
        if let Some(n) = first.filter(|n| *n > 0) {
            let (mut low, mut high) = (all[n - 1].value, all[n].value);
            for _ in 0..HALVINGS {
                // Between positive values in the logarithm.
                let middle = if low > 0.0 {
                    (low * high).sqrt()
                } else {
                    0.5 * (low + high)
                };
                let found = tried(middle);
                if found.cures() && !found.hides() {
                    high = middle;
                } else {
                    low = middle;
                }
                all.push(found);
            }
            recommended = Some(high);
        }
        all.sort_by(|a, b| a.value.total_cmp(&b.value));
        Ok(Self {
            key: question.key(),
            recommended,
            is_curable: all.iter().any(Tried::cures),
            tried: all,
            notes: notes(settings, &*material),
            settings: settings.effective().without(question.key()),
        })
    }

    /// What each value does, as a figure.
    pub fn figure(&self) -> Figure {
        let positive: Vec<f64> = self
            .tried
            .iter()
            .map(|one| one.value)
            .filter(|x| *x > 0.0)
            .collect();
        let axis = || Axis::log(self.key, (1e-4, 1.0)).covering(positive.clone());
        let line = |number: &dyn Fn(&Measured) -> f64| {
            let points = self
                .tried
                .iter()
                .filter(|one| one.value > 0.0)
                .filter_map(|one| Some((one.value, number(one.measured.as_ref().ok()?))));
            Line::new(points.collect())
        };
        let marked = |panel: Panel| match self.recommended.filter(|value| *value > 0.0) {
            Some(value) => panel.with(Rule::vertical(value).dashed().named("recommended")),
            None => panel,
        };
        let shares =
            Axis::linear("share of the window of states (%)", (0.0, 100.0)).covering([0.0, 100.0]);
        let unit = || Axis::linear("relative frequency (−)", (0.0, 1.0)).covering([0.0, 1.0]);
        let steps = Axis::linear("c Δt / spacing (−)", (0.0, 1.0));
        let steps = steps.covering(
            self.tried
                .iter()
                .filter_map(|one| Some(one.measured.as_ref().ok()?.courant))
                .chain([0.0]),
        );
        Figure::new(format!("What {} does", self.key))
            .columns(3)
            .with(marked(
                Panel::new("Weakest wave of the undeformed body", axis(), unit())
                    .with(line(&|m| m.weakest).color(palette::BLUE))
                    .with(Rule::horizontal(STRONG).dotted().named("strong enough")),
            ))
            .with(marked(
                Panel::new("Wrong verdicts", axis(), shares)
                    .with(
                        line(&|m| 100.0 * m.fidelity.false_instability)
                            .color(palette::ORANGE)
                            .named("falsely unstable"),
                    )
                    .with(
                        line(&|m| 100.0 * m.fidelity.missed_instability)
                            .color(palette::BLACK)
                            .dotted()
                            .named("instability missed"),
                    ),
            ))
            .with(marked(
                Panel::new("Critical time step", axis(), steps)
                    .with(line(&|m| m.courant).color(palette::GREEN)),
            ))
            .caption(self.settings.caption())
    }

    /// All values as CSV.
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "value,zero_modes,weakest,false_instability,missed_instability,courant,dispersion_8,cures,hides,note\n",
        );
        for one in &self.tried {
            let (cures, hides) = (one.cures(), one.hides());
            let cells = match &one.measured {
                Ok(m) => format!(
                    "{},{:.16e},{:.16e},{:.16e},{:.16e},{:.16e},{cures},{hides},",
                    m.zero_modes,
                    m.weakest,
                    m.fidelity.false_instability,
                    m.fidelity.missed_instability,
                    m.courant,
                    m.dispersion_at(8.0)
                ),
                Err(why) => format!(",,,,,,,,{}", csv::text(why)),
            };
            text.push_str(&format!("{:.16e},{cells}\n", one.value));
        }
        text
    }

    /// The answer as `tune.csv`, `tune.svg` and `tune.png`.
    ///
    /// # Errors
    /// [`FigureError`] when the figure is too large.
    pub fn files(&self) -> Result<Files, FigureError> {
        let mut files = vec![text("tune.csv", self.csv())];
        files.extend(self.figure().files("tune")?);
        Ok(files)
    }
}

impl fmt::Display for TuneAnswer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.recommended {
            Some(value) => writeln!(
                formatter,
                "{} = {}: the smallest value found that removes the spurious modes and does not hide the material's instability\n",
                self.key,
                crate::number::told(value)
            )?,
            None if self.is_curable => writeln!(
                formatter,
                "no value of {} removes the spurious modes without hiding the material's instability\n",
                self.key
            )?,
            None => writeln!(
                formatter,
                "no value of {} in the range removes the spurious modes\n",
                self.key
            )?,
        }
        writeln!(
            formatter,
            "  {:>10}  {:>10}  {:>8}  {:>8}  {:>8}  {:>8}  verdict",
            "value", "zero modes", "weakest", "false", "missed", "Courant"
        )?;
        for one in &self.tried {
            match &one.measured {
                Ok(m) => writeln!(
                    formatter,
                    "  {:>10.4e}  {:>10}  {:>8.4}  {:>6.2} %  {:>6.2} %  {:>8.4}  {}",
                    one.value,
                    m.zero_modes,
                    m.weakest,
                    100.0 * m.fidelity.false_instability,
                    100.0 * m.fidelity.missed_instability,
                    m.courant,
                    match (one.cures(), one.hides()) {
                        (true, false) => "cures",
                        (true, true) => "cures, but hides",
                        (false, false) => "does not cure",
                        (false, true) => "does not cure, and hides",
                    }
                )?,
                Err(why) => writeln!(
                    formatter,
                    "  {:>10.4e}  {}",
                    one.value,
                    why.lines().next().unwrap_or_default()
                )?,
            }
        }
        writeln!(
            formatter,
            "\ncured: no modes without energy, no wave slower than {:.0} % of the material's slowest, at most {:.1} % of the states falsely unstable\n\
             hidden: more than {:.1} % of the states stable though the material is not elliptic, or onset later than the material's by more than {:.0} % of its strain",
            100.0 * STRONG,
            100.0 * WRONG,
            100.0 * WRONG,
            100.0 * LATER
        )?;
        for note in &self.notes {
            writeln!(formatter, "\n\nnote: {note}")?;
        }
        write!(formatter, "\n\n{}", self.settings)
    }
}
