//! Values of a setting for which all states of a window of stretches are stable.

use super::interval::{Admitted, Trial, admitted, refuse_undefined};
use super::varied::Varied;
use super::{LimitQuestion, SHORT_ROWS, VALUES};
use crate::answers::{Evidence, Problem, ProblemError, notes};
use crate::brief::{Brief, Short, WIDTH, cut};
use crate::csv::Table;
use crate::figure::{Axis, Figure, Line, Panel, palette};
use crate::number::{counted, told, vector};
use crate::output::{Files, picture, text};
use crate::range::spread;
use crate::settings::{Effective, Settings};
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
    /// Verdict on the first state that is not stable, or `undefined` if the method or the law is not defined there; `None` if all states are stable.
    pub verdict: Option<&'static str>,
    /// Stretches of the first state that is not stable.
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

    fn is_refined(&self) -> bool {
        self.is_refined
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
    /// Whether the user gave the range of values.
    #[serde(skip)]
    is_range_given: bool,
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
        let (present, [low, high]) = question.values_of(settings)?;
        let measured = |value| measured(question, settings, window, value);
        let trial = |value: f64| {
            is_told(value);
            measured(value).unwrap_or_else(|error| Kept {
                value,
                stable_share: None,
                verdict: None,
                stretches: None,
                note: Some(error.to_string()),
                is_refined: false,
            })
        };
        let grid: Vec<Kept> = spread([low, high], VALUES).into_iter().map(trial).collect();
        refuse_undefined(&grid, question.key(), present, &measured)?;
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
            is_range_given: question.range.is_some(),
        })
    }

    /// The varied setting with its results.
    fn varied(&self) -> Varied<'_, Kept> {
        Varied {
            key: self.key,
            unit: self.unit,
            units: self.settings.units(),
            admitted: &self.admitted,
            tried: &self.tried,
            present: self.present.as_ref(),
            is_range_given: self.is_range_given,
        }
    }

    /// Sentence of the answer. Ends are rounded inward, so that the printed value keeps the states stable.
    fn sentence(&self) -> String {
        let [low, high] = self.window;
        let states = format!(
            "{} with stretches from {} to {} along the axes",
            counted(self.states, "state"),
            told(low),
            told(high)
        );
        let varied = self.varied();
        if !self.admitted.is_empty() {
            return format!("All {states} are stable with {}.", varied.ranges());
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
                varied.value(told(best.value))
            )
        });
        let [first, last] = varied.ends_told();
        format!(
            "No {} from {first} to {last} keeps all {states} stable{best}.",
            self.key
        )
    }

    /// Sentence on the present value.
    fn present_sentence(&self) -> Option<String> {
        let present = self.present.as_ref()?;
        let value = self.varied().value(told(present.value));
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
        Table::new(&self.tried, self.settings.units())
            .with("value", self.varied().dimension(), |own| own.value)
            .with("stable_share", "1", |own| own.stable_share)
            .with("verdict", "1", |own| own.verdict)
            .each("stretch", 3, "1", |own, axis| {
                own.stretches.map(|own| own[axis])
            })
            .with("note", "1", |own| own.note.clone())
            .to_string()
    }

    /// Fraction of stable states as a function of the value.
    pub fn figure(&self) -> Figure {
        let varied = self.varied();
        let stable = |one: &Kept| Some(100.0 * one.stable_share?);
        let tried = self.tried.iter();
        let points: Vec<(f64, f64)> = tried
            .filter_map(|one| Some((one.value, stable(one)?)))
            .collect();
        let (x, _) = varied.axis(&points);
        let y = Axis::linear("stable states (%)", (-4.0, 104.0));
        let line = Line::new(points).color(palette::BLUE);
        let panel = Panel::new("", x, y).with(line);
        Figure::new(format!("Stable states over {}", varied.title()))
            .with(varied.marked(panel, stable))
            .caption(format!(
                "{} {}",
                self.sentence(),
                crate::caption::settings(&self.settings)
            ))
    }

    /// The answer as `limit.csv` and the figure `limit`.
    pub fn files(&self) -> Files {
        vec![
            text("limit.csv", self.csv()),
            picture("limit", self.figure()),
        ]
    }
}

/// Fraction of the states as text. Only 100 % of the states are printed as 100 %.
fn share(share: f64) -> String {
    match share {
        1.0 => "100 %".to_owned(),
        share => format!("{:.0} %", (100.0 * share).floor()),
    }
}

impl KeepsAnswer {
    /// All sentences of the answer.
    fn sentences(&self) -> String {
        let varied = self.varied();
        let present = self.present_sentence().into_iter();
        let others = present.chain(varied.ends_of_domain());
        let all: Vec<String> = [self.sentence()].into_iter().chain(others).collect();
        all.join(" ")
    }

    /// Head of the table.
    fn head(&self) -> String {
        let heading = self.varied().heading();
        format!("{heading:>14}  stable states  first state that is not, with its stretches")
    }
}

/// Row of a value.
fn row(one: &Kept) -> String {
    let told = told(one.value);
    match (one.stable_share, one.verdict, one.stretches) {
        (Some(own), Some(verdict), Some(at)) => {
            format!("{told:>14}  {:>13}  {verdict}, {}", share(own), vector(&at))
        }
        (Some(own), ..) => format!("{told:>14}  {:>13}", share(own)),
        (None, ..) => {
            let note = one.note.as_deref().unwrap_or_default();
            let note = note.lines().next().unwrap_or_default();
            format!("{told:>14}  {note}")
        }
    }
}

impl Brief for KeepsAnswer {
    fn brief(&self) -> Short {
        let rows = self.varied().rows_near_limits(SHORT_ROWS);
        let rows = rows.into_iter().map(|one| cut(&row(one), WIDTH));
        let mut short = Short::new(self.sentence()).table([self.head()].into_iter().chain(rows));
        if let Some(present) = self.present_sentence() {
            short = short.row(0, "present", present);
        }
        for sentence in self.varied().ends_of_domain() {
            short = short.row(3, "range", sentence);
        }
        short
            .notes(&self.notes)
            .settings("material", self.settings.law())
            .settings("method", self.settings.method())
    }
}

impl fmt::Display for KeepsAnswer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(formatter, "{}\n\n  {}", self.sentences(), self.head())?;
        for one in self.varied().rows() {
            writeln!(formatter, "  {}", row(one))?;
        }
        for note in &self.notes {
            writeln!(formatter, "\nnote: {note}")?;
        }
        write!(formatter, "\n{}\n{}", self.evidence, self.settings)
    }
}
