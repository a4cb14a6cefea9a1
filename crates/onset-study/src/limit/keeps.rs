//! Values of a setting for which all states of a window of stretches are stable.

use super::interval::{Admitted, End, EndKind, Trial, admitted, ends_of_domain, ranges};
use super::{LimitQuestion, VALUES};
use crate::answers::{Evidence, Problem, ProblemError, notes};
use crate::csv::Table;
use crate::figure::{Axis, Figure, Line, Panel, Points, Rule, palette};
use crate::number::{counted, told, vector};
use crate::output::{Files, picture, text};
use crate::range::spread;
use crate::settings::{Effective, Key, Settings};
use onset::cancel::Scope;
use onset::kinematics::DeformationGradient;
use onset::verdict::Verdict;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt;

/// Number of stretches along each axis in one, two and three dimensions; the ends of the window are among them.
const STRETCHES: [usize; 3] = [33, 9, 5];

/// Result for one value of the setting.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Kept {
    /// Value of the setting.
    pub value: f64,
    /// Fraction of stable states; `null` if no state can be evaluated.
    pub stable_share: Option<f64>,
    /// Verdict on the first state that is not stable, or `undefined` where method or law are not defined; `None` if all states are stable.
    pub verdict: Option<&'static str>,
    /// Stretches of this state.
    pub stretches: Option<[f64; 3]>,
    /// Reason why the value cannot be evaluated; `None` if it can be evaluated.
    pub note: Option<String>,
    /// Whether the value was added by the refinement, between values of the grid.
    #[serde(skip)]
    is_refined: bool,
}

impl Trial for Kept {
    const TOLERANCE: f64 = 1e-6;

    fn value(&self) -> f64 {
        self.value
    }

    fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    fn margin(&self) -> f64 {
        match self.stable_share {
            Some(1.0) => 1.0,
            Some(_) => -1.0,
            None => f64::NAN,
        }
    }

    fn refined(mut self) -> Self {
        self.is_refined = true;
        self
    }
}

/// Answer of `onset limit --keeps stable`: the values of a setting that keep a window of states stable.
#[derive(Clone, Debug, Serialize)]
pub struct KeepsAnswer {
    /// The key of the setting.
    pub key: &'static str,
    /// Unit of the setting; `null` if values have no units.
    pub unit: Option<&'static str>,
    /// Smallest and largest principal stretch of the states, along the axes.
    pub window: [f64; 2],
    /// Number of states in the window.
    pub states: usize,
    /// Present value of the setting; `null` if the setting has no value.
    pub present: Option<Kept>,
    /// Intervals of values that keep all states stable.
    pub admitted: Vec<Admitted>,
    /// All values that were evaluated, in increasing order.
    pub tried: Vec<Kept>,
    /// Evidence for the intervals: `searched`.
    pub evidence: Evidence,
    /// Remarks on law and method for the reader.
    pub notes: Vec<String>,
    /// All settings in effect except the varied one.
    pub settings: Effective,
}

/// States with all combinations of stretches along the axes of a problem; the stretches of other axes are 1.
fn states(dimension: usize, window: [f64; 2]) -> Vec<[f64; 3]> {
    let stretches = spread(window, STRETCHES[dimension - 1]);
    let mut states = vec![[1.0; 3]];
    for axis in 0..dimension {
        let with = |state: &[f64; 3], stretch: f64| {
            let mut own = *state;
            own[axis] = stretch;
            own
        };
        states = states
            .iter()
            .flat_map(|state| stretches.iter().map(move |stretch| with(state, *stretch)))
            .collect();
    }
    states
}

/// Evaluates the states with a value of the setting.
fn measured(
    question: &LimitQuestion,
    settings: &Settings,
    window: [f64; 2],
    value: f64,
) -> Result<Kept, ProblemError> {
    let problem = Problem::new(question.settings(settings, value)?)?;
    let states = states(problem.dimension(), window);
    let scope = Scope::current();
    let verdict = |stretches: &[f64; 3]| -> Result<&'static str, ProblemError> {
        let f = DeformationGradient::from_stretches(*stretches)?;
        scope.run(|| match problem.analysis.judge(&f, None) {
            Ok(judged) => Ok(judged.verdict.name()),
            Err(error) if error.leaves_undefined() => Ok("undefined"),
            Err(error) => Err(error.into()),
        })
    };
    let verdicts: Vec<&str> = states.par_iter().map(verdict).collect::<Result<_, _>>()?;
    let is_stable = |verdict: &&str| *verdict == Verdict::Stable.name();
    let first = verdicts.iter().position(|verdict| !is_stable(verdict));
    let stable = verdicts.iter().filter(|verdict| is_stable(verdict)).count();
    Ok(Kept {
        value,
        stable_share: Some(stable as f64 / states.len() as f64),
        verdict: first.map(|at| verdicts[at]),
        stretches: first.map(|at| states[at]),
        note: None,
        is_refined: false,
    })
}

impl KeepsAnswer {
    /// Evaluates all values, and refines the ends of the intervals; `is_told` is called with each value.
    ///
    /// # Errors
    /// [`ProblemError`] when settings are invalid, no value can be evaluated, or the key is not used.
    pub fn new(
        settings: &Settings,
        question: &LimitQuestion,
        window: [f64; 2],
        is_told: &(dyn Fn(f64) + Sync),
    ) -> Result<Self, ProblemError> {
        question.check(settings)?;
        let present = settings
            .value(question.key())
            .and_then(|value| value.number());
        let [low, high] = question.range(present)?;
        let trial = |value: f64| {
            is_told(value);
            measured(question, settings, window, value).unwrap_or_else(|error| Kept {
                value,
                stable_share: None,
                verdict: None,
                stretches: None,
                note: Some(error.to_string()),
                is_refined: false,
            })
        };
        let grid: Vec<Kept> = spread([low, high], VALUES).into_iter().map(trial).collect();
        if grid.iter().all(|one| one.note.is_some()) {
            // If the present value fails too, the reason is another setting and not the range.
            if let Some(present) = present {
                measured(question, settings, window, present)?;
            }
            measured(question, settings, window, low).map_err(|source| ProblemError::Range {
                key: question.key(),
                low,
                high,
                source: Box::new(source),
            })?;
        }
        let (admitted, tried) = admitted(grid, &trial);
        let problem = Problem::new(question.settings(settings, present.unwrap_or(high))?)?;
        Ok(Self {
            key: question.key(),
            unit: settings.unit(question.key),
            window,
            states: states(problem.dimension(), window).len(),
            present: present.map(trial),
            admitted,
            tried,
            evidence: Evidence::Searched,
            notes: notes(settings, &*problem.material),
            settings: settings.effective_beside(question.key()),
        })
    }

    fn value(&self, told: String) -> String {
        self.settings
            .units()
            .of(told, self.unit.unwrap_or_default())
            .trim_end()
            .to_owned()
    }

    /// The answer in a sentence. Ends are rounded inward, so that the printed value keeps the states stable.
    fn sentence(&self) -> String {
        let [low, high] = self.window;
        let states = format!(
            "{} with stretches from {} to {} along the axes",
            counted(self.states, "state"),
            told(low),
            told(high)
        );
        let ends = [self.tried.first(), self.tried.last()];
        let [first, last] = ends.map(|one| self.value(told(one.map_or(f64::NAN, |one| one.value))));
        if !self.admitted.is_empty() {
            let values = ranges(&self.admitted, self.key, &last, &|own| self.value(own));
            return format!("All {states} are stable with {values}.");
        }
        let best = self.tried.iter().filter(|one| one.stable_share.is_some());
        let best = best.max_by(|a, b| {
            a.stable_share
                .unwrap_or(0.0)
                .total_cmp(&b.stable_share.unwrap_or(0.0))
        });
        let best = best.map_or_else(String::new, |best| {
            format!(
                "; at best {} are stable, with {}",
                share(best.stable_share.unwrap_or(0.0)),
                self.value(told(best.value))
            )
        });
        format!(
            "No {} from {first} to {last} keeps all {states} stable{best}.",
            self.key
        )
    }

    /// Sentence on the present value.
    fn present_sentence(&self) -> Option<String> {
        let present = self.present.as_ref()?;
        let value = self.value(told(present.value));
        Some(match (&present.note, present.verdict, present.stretches) {
            (Some(note), ..) => format!(
                "Its present value {value} cannot be evaluated: {}.",
                note.lines().next().unwrap_or_default()
            ),
            (None, Some(verdict), Some(at)) => format!(
                "With its present value {value}, {} are stable; the verdict on the stretches {} is {verdict}.",
                share(present.stable_share.unwrap_or(0.0)),
                vector(&at)
            ),
            _ => format!("Its present value {value} does."),
        })
    }

    /// All evaluated values as CSV.
    pub fn csv(&self) -> String {
        let dimension = Key::named(self.key).and_then(|key| key.unit());
        Table::new(&self.tried, self.settings.units())
            .with("value", dimension.unwrap_or("1"), |own| own.value)
            .with("stable_share", "1", |own| own.stable_share)
            .with("verdict", "1", |own| own.verdict)
            .each("stretch", 3, "1", |own, axis| {
                own.stretches.map(|own| own[axis])
            })
            .with("note", "1", |own| own.note.clone())
            .to_string()
    }

    /// Fraction of stable states over the values.
    pub fn figure(&self) -> Figure {
        let label = match self.unit {
            Some(unit) => format!("{} ({unit})", self.key),
            None => self.key.to_owned(),
        };
        let tried = self.tried.iter();
        let points: Vec<(f64, f64)> = tried
            .filter_map(|one| Some((one.value, 100.0 * one.stable_share?)))
            .collect();
        let values = points.iter().map(|point| point.0);
        let x = match self.tried.first().is_some_and(|one| one.value > 0.0) {
            true => Axis::log(label, (1e-4, 1.0)).covering(values),
            false => Axis::linear(label, (0.0, 1.0)).covering(values),
        };
        let y = Axis::linear("stable states (%)", (-4.0, 104.0));
        let mut panel = Panel::new("", x, y).with(Line::new(points).color(palette::BLUE));
        if let Some((present, share)) = self
            .present
            .as_ref()
            .and_then(|own| Some((own.value, own.stable_share?)))
        {
            let at = vec![(present, 100.0 * share)];
            panel = panel.with(Points::new(at).named("present value"));
        }
        let ends = self.admitted.iter().flat_map(|own| [&own.from, &own.to]);
        let limits = ends.filter(|end: &&End| end.kind == EndKind::Limit);
        for (n, end) in limits.enumerate() {
            let rule = Rule::vertical(end.value).dotted();
            // One entry of the legend for all limits.
            panel = panel.with(match n {
                0 => rule.named("limit"),
                _ => rule,
            });
        }
        Figure::new(format!("Stable states over {}", self.key))
            .with(panel)
            .caption(format!("{} {}", self.sentence(), self.settings.caption()))
    }

    /// The answer as `limit.csv` and the figure `limit`.
    pub fn files(&self) -> Files {
        vec![
            text("limit.csv", self.csv()),
            picture("limit", self.figure()),
        ]
    }
}

/// Fraction of the states in words. Only all states are 100 %.
fn share(share: f64) -> String {
    match share {
        1.0 => "100 %".to_owned(),
        share => format!("{:.0} %", (100.0 * share).floor()),
    }
}

impl fmt::Display for KeepsAnswer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", self.sentence())?;
        for sentence in self
            .present_sentence()
            .into_iter()
            .chain(ends_of_domain(&self.admitted, &|own| self.value(own)))
        {
            write!(formatter, " {sentence}")?;
        }
        let heading = match self.unit {
            Some(unit) => format!("value ({unit})"),
            None => "value".to_owned(),
        };
        writeln!(
            formatter,
            "\n\n  {heading:>14}  stable states  first that is not, at stretches"
        )?;
        let ends = self.admitted.iter();
        let ends: Vec<f64> = ends
            .flat_map(|own| [own.from.value, own.to.value])
            .collect();
        for one in &self.tried {
            if one.is_refined && !ends.contains(&one.value) {
                continue;
            }
            let told = told(one.value);
            match (one.stable_share, one.verdict, one.stretches) {
                (Some(own), Some(verdict), Some(at)) => writeln!(
                    formatter,
                    "  {told:>14}  {:>13}  {verdict}, {}",
                    share(own),
                    vector(&at)
                )?,
                (Some(own), ..) => writeln!(formatter, "  {told:>14}  {:>13}", share(own))?,
                (None, ..) => {
                    let note = one.note.as_deref().unwrap_or_default();
                    let note = note.lines().next().unwrap_or_default();
                    writeln!(formatter, "  {told:>14}  {note}")?;
                }
            }
        }
        for note in &self.notes {
            writeln!(formatter, "\nnote: {note}")?;
        }
        write!(formatter, "\n{}\n{}", self.evidence, self.settings)
    }
}
