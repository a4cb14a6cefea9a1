//! Critical time steps as a function of a setting, and the intervals of values for which a step is stable.

use super::interval::{Admitted, EndKind, Trial, admitted, refuse_undefined};
use super::varied::Varied;
use super::{LimitQuestion, SHORT_ROWS, VALUES};
use crate::answers::{
    BodyStepAnswer, Evidence, FiniteBodyAnswer, LATTICE_NOTE, Problem, ProblemError, Strain, notes,
};
use crate::brief::{Brief, Short, WIDTH, cut};
use crate::caption;
use crate::csv::Table;
use crate::figure::{Axis, Figure, Line, Panel, Rule, palette};
use crate::number::told;
use crate::output::{Files, picture, text};
use crate::range::{middle, spread};
use crate::settings::{Effective, Settings, Units};
use onset::analysis::{Analysis, SteppedWaves};
use onset::bloch::SpectrumSummary;
use onset::cancel::Scope;
use onset::method::MethodError;
use onset::time_step::{Integrator, undamped_time_step};
use onset::verdict::Verdict;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeSet;
use std::fmt;

/// Tolerance of the logarithm of the step ratio at a limit, and of the relative width of the bracket.
const LIMIT_TOLERANCE: f64 = 1e-10;

/// Result for one value of the setting.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tried {
    /// Value of the setting.
    pub value: f64,
    /// Critical time step of the state: the smaller of the steps of the infinite lattice and of finite bodies, or of the body of the study.
    ///
    /// Zero if no step is stable. `null` if every step is stable because no mode oscillates, or if the value cannot be evaluated. Time.
    #[serde(serialize_with = "finite")]
    pub critical_time_step: f64,
    /// Critical step of the infinite lattice; `null` as above. Time.
    #[serde(serialize_with = "finite")]
    pub lattice_time_step: f64,
    /// Step that is stable for finite bodies; `null` if it is unknown, and for a study with a body. Time.
    pub finite_body_time_step: Option<f64>,
    /// Whether the step of finite bodies is interpolated, as a ratio to the step of the lattice, between values at which it was computed.
    pub is_interpolated: bool,
    /// Verdict on the state. For an unstable state the step belongs to the waves that do not grow. `null` if the value cannot be evaluated.
    pub verdict: Option<Verdict>,
    /// Critical step of the body of the study at the state; `null` without a body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<BodyStepAnswer>,
    /// Critical step of an isolated material point, for methods with a transfer; time. `null` for other methods.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub isolated_point_time_step: Option<f64>,
    /// Reason why the value cannot be evaluated; `None` if it can be evaluated.
    pub note: Option<String>,
    /// Whether the value was added by the refinement, between values of the grid.
    #[serde(skip)]
    is_refined: bool,
    /// Logarithm of the ratio of the critical to the needed step; NaN if the value cannot be evaluated.
    #[serde(skip)]
    margin: f64,
}

/// Serializes numbers that are not finite as `null`.
fn finite<S: serde::Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    Some(*value)
        .filter(|value| value.is_finite())
        .serialize(serializer)
}

impl Trial for Tried {
    const TOLERANCE: f64 = LIMIT_TOLERANCE;

    fn value(&self) -> f64 {
        self.value
    }

    fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    fn margin(&self) -> f64 {
        self.margin
    }

    fn refined(mut self) -> Self {
        self.is_refined = true;
        self
    }

    fn is_refined(&self) -> bool {
        self.is_refined
    }
}

/// Answer of `onset limit`: the values of a setting that admit a time step.
#[derive(Clone, Debug, Serialize)]
pub struct LimitAnswer {
    /// The key of the setting.
    pub key: &'static str,
    /// Unit of the setting; `null` if values have no units.
    pub unit: Option<&'static str>,
    /// The time step that must be stable. Time.
    pub time_step: f64,
    /// Maximum ratio of the step to the critical step.
    pub safety: f64,
    /// Time integrator; `null` for a method with a transfer, which defines its step.
    pub integrator: Option<&'static str>,
    /// Kind of body of the critical steps: finite bodies, infinite lattice, or body of the study.
    pub critical_time_step_of: String,
    /// Stable step of finite bodies with the present value; `null` if it is unknown.
    pub finite_bodies: Option<FiniteBodyAnswer>,
    /// Deformation gradient `F_iJ` of the state, by rows.
    pub deformation_gradient: [[f64; 3]; 3],
    /// Present value of the setting and its critical step; `null` if the setting has no value.
    pub present: Option<Tried>,
    /// Intervals of values that admit the step.
    pub admitted: Vec<Admitted>,
    /// All values that were evaluated, in increasing order.
    pub tried: Vec<Tried>,
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

/// Smallest critical step for which the given step is safe; the step is a fraction of it.
fn needed(time_step: f64, safety: f64) -> f64 {
    time_step / safety
}

/// Largest number of times that limits are searched for with interpolated steps of finite bodies.
const ROUNDS: usize = 8;
/// Relative error of interpolated steps of finite bodies at a limit.
const RATIO_TOLERANCE: f64 = 1e-8;

/// Ratios of the step of finite bodies to the step of the lattice at some values, in increasing order. They vary slowly between the values.
#[derive(Clone, Debug, PartialEq)]
struct Ratios(Vec<(f64, f64)>);

impl Ratios {
    /// Ratio at a value: interpolated linearly, over the logarithm if the values are positive. Outside of the known values the line through the
    /// nearest two is followed over their distance.
    fn at(&self, value: f64) -> f64 {
        let is_positive = value > 0.0 && self.0.iter().all(|known| known.0 > 0.0);
        let place = |x: f64| if is_positive { x.ln() } else { x };
        let beyond = self.0.partition_point(|known| known.0 < value);
        let first = beyond.saturating_sub(1).min(self.0.len().saturating_sub(2));
        match self.0.get(first..first + 2) {
            Some([a, b]) => {
                let share = (place(value) - place(a.0)) / (place(b.0) - place(a.0));
                let ratio = a.1 * (b.1 / a.1).powf(share.clamp(-1.0, 2.0));
                ratio.min(1.0)
            }
            _ => self.0.first().map_or(1.0, |known| known.1),
        }
    }

    fn is_known(&self, value: f64) -> bool {
        self.0.iter().any(|known| known.0 == value)
    }

    /// Adds the ratio at a value; false if it was known within the tolerance.
    fn learn(&mut self, value: f64, ratio: f64) -> bool {
        let is_new =
            !self.is_known(value) && (self.at(value) / ratio - 1.0).abs() > RATIO_TOLERANCE;
        if is_new {
            let place = self.0.partition_point(|known| known.0 < value);
            self.0.insert(place, (value, ratio));
        }
        is_new
    }
}

/// Waves of the lattice with one value of the setting.
struct Waves {
    problem: Problem,
    /// Problem of the increments that limit the step, if they are stiffer.
    stiffer: Option<Problem>,
    step: f64,
    verdict: Verdict,
    isolated_point: Option<f64>,
}

/// Search for the limits at one state.
struct Search<'a> {
    question: &'a LimitQuestion,
    settings: &'a Settings,
    integrator: Integrator,
    strain: &'a Strain,
    needed: f64,
    /// Ratios of the steps of finite bodies, if these steps are too costly to be computed at every value.
    ratios: Option<Ratios>,
    is_told: &'a (dyn Fn(f64) + Sync),
}

impl Search<'_> {
    fn waves(&self, value: f64) -> Result<Waves, ProblemError> {
        let problem = Problem::new(self.question.settings(self.settings, value)?)?;
        let (analysis, f) = (&*problem.analysis, &self.strain.0);
        let assessment = analysis.assess(f)?;
        let transferred = analysis.transferred(f)?;
        let mut step = self.step(analysis, transferred.as_deref(), &assessment.spectrum)?;
        let stiffer = problem.stiffer_at(f)?;
        if let Some(problem) = &stiffer {
            let stiffer = &*problem.analysis;
            let waves = stiffer.transferred(f)?;
            let of_stiffer = self.step(stiffer, waves.as_deref(), &stiffer.spectrum(f)?)?;
            step = step.min(of_stiffer);
        }
        Ok(Waves {
            step,
            verdict: assessment.verdict,
            isolated_point: transferred.and_then(|waves| waves.isolated_point()),
            stiffer,
            problem,
        })
    }

    /// Step of finite bodies; `None` if it is unknown, and for a study with a body.
    fn finite(&self, waves: &Waves) -> Result<Option<FiniteBodyAnswer>, ProblemError> {
        if self.settings.body.is_some() {
            return Ok(None);
        }
        let lattice = Some(waves.step).filter(|step| step.is_finite());
        let problem = waves.stiffer.as_ref().unwrap_or(&waves.problem);
        let bodies = problem.analysis.finite_bodies(&self.strain.0)?;
        Ok(FiniteBodyAnswer::new(
            problem,
            &bodies,
            self.integrator,
            lattice,
        ))
    }

    /// Ratio of the step of finite bodies to the step of the lattice, if both are positive and finite.
    fn ratio(&self, value: f64) -> Option<f64> {
        let waves = self.waves(value).ok()?;
        let finite = self.finite(&waves).ok()??;
        Some(finite.time_step / waves.step).filter(|ratio| *ratio > 0.0 && ratio.is_finite())
    }

    fn measured(&self, value: f64) -> Result<Tried, ProblemError> {
        let waves = self.waves(value)?;
        let limiting = waves.stiffer.as_ref().unwrap_or(&waves.problem);
        let body = BodyStepAnswer::new(limiting, &self.strain.0, self.integrator)?;
        let finite_body_time_step = match self.ratios {
            Some(_) => None,
            None => self.finite(&waves)?.map(|own| own.time_step),
        };
        let tried = Tried {
            value,
            critical_time_step: waves.step,
            lattice_time_step: waves.step,
            finite_body_time_step,
            is_interpolated: false,
            margin: f64::NAN,
            body,
            verdict: Some(waves.verdict),
            isolated_point_time_step: waves.isolated_point,
            note: None,
            is_refined: false,
        };
        Ok(self.decided(tried))
    }

    /// Result with the smallest of its steps, where the ratios give the steps of finite bodies.
    fn decided(&self, mut tried: Tried) -> Tried {
        if tried.note.is_some() {
            return tried;
        }
        if let Some(ratios) = &self.ratios {
            let finite = ratios.at(tried.value) * tried.lattice_time_step;
            tried.finite_body_time_step = Some(finite).filter(|step| step.is_finite());
            tried.is_interpolated = !ratios.is_known(tried.value);
        }
        let of_body = tried.body.and_then(|body| body.time_step);
        let others = [of_body, tried.finite_body_time_step];
        tried.critical_time_step = others
            .into_iter()
            .flatten()
            .fold(tried.lattice_time_step, f64::min);
        tried.margin = (tried.critical_time_step / self.needed).ln();
        tried
    }

    /// Critical step of an analysis at the state.
    fn step(
        &self,
        analysis: &dyn Analysis,
        transferred: Option<&dyn SteppedWaves>,
        spectrum: &SpectrumSummary<3>,
    ) -> Result<f64, MethodError> {
        let integrator = self.integrator;
        Ok(match transferred {
            Some(waves) => waves.critical_time_step(),
            None if analysis.is_damped() => {
                analysis.critical_time_step(&self.strain.0, integrator)?
            }
            None => undamped_time_step(integrator, spectrum.maximum_omega),
        })
    }

    fn tried(&self, value: f64) -> Tried {
        (self.is_told)(value);
        self.measured(value).unwrap_or_else(|error| Tried {
            value,
            critical_time_step: f64::NAN,
            lattice_time_step: f64::NAN,
            finite_body_time_step: None,
            is_interpolated: false,
            margin: f64::NAN,
            body: None,
            verdict: None,
            isolated_point_time_step: None,
            note: Some(error.to_string()),
            is_refined: false,
        })
    }
}

impl LimitAnswer {
    /// Evaluates all values in parallel, and refines the limits; `step` is the time step as text, with an optional unit, and `is_told` is called with
    /// each value.
    ///
    /// # Errors
    /// [`ProblemError`] when settings or state are invalid, no value can be evaluated, or the key is not used.
    pub fn new(
        settings: &Settings,
        strain: &Strain,
        question: &LimitQuestion,
        step: &str,
        is_told: &(dyn Fn(f64) + Sync),
    ) -> Result<Self, ProblemError> {
        let (present, [low, high]) = question.values_of(settings)?;
        let time_step = LimitQuestion::time_step(step, settings)?;
        let mut search = Search {
            question,
            settings,
            integrator: settings.explicit_integrator()?,
            strain,
            needed: needed(time_step, question.safety),
            ratios: None,
            is_told,
        };
        let typical = present.unwrap_or(middle(low, high));
        let of_typical = search.waves(typical).ok().and_then(|waves| {
            let finite = search.finite(&waves).ok()??;
            Some((waves, finite))
        });
        // Blocks in space and blocks of several kinds of particles take seconds.
        search.ratios = of_typical.as_ref().and_then(|(waves, finite)| {
            let ratio = finite.time_step / waves.step;
            let analysis = &waves.problem.analysis;
            let is_large = waves.problem.dimension() == 3 || analysis.sites() > 1;
            let is_costly = is_large && !finite.proved;
            (is_costly && ratio > 0.0 && ratio.is_finite()).then(|| Ratios(vec![(typical, ratio)]))
        });
        let values = spread([low, high], VALUES);
        let scope = Scope::current();
        let tried = |x| scope.run(|| search.tried(x));
        let mut grid: Vec<Tried> = values.into_par_iter().map(tried).collect();
        let measured = |value| search.measured(value);
        refuse_undefined(&grid, question.key(), present, &measured)?;
        let (mut intervals, mut all) = admitted(grid.clone(), &|value| search.tried(value));
        // Limits with interpolated ratios converge to the limits as the ratios at the limits are added.
        for _ in 0..ROUNDS {
            let Some(mut ratios) = search.ratios.clone() else {
                break;
            };
            let ends = intervals.iter().flat_map(|own| [&own.from, &own.to]);
            let limits = ends.filter(|end| end.kind == EndKind::Limit);
            let known = limits.filter_map(|end| Some((end.value, search.ratio(end.value)?)));
            let is_new = known.fold(false, |is_new, (value, ratio)| {
                ratios.learn(value, ratio) || is_new
            });
            if !is_new {
                break;
            }
            search.ratios = Some(ratios);
            grid = grid.into_iter().map(|own| search.decided(own)).collect();
            (intervals, all) = admitted(grid.clone(), &|value| search.tried(value));
        }
        let problem = question.settings(settings, present.unwrap_or(high));
        let problem = problem.and_then(Problem::new).ok();
        let is_transferred = |problem: &Problem| problem.analysis.is_transferred();
        let present = present.map(|value| search.tried(value));
        // With a present value this is the value of `of_typical`.
        let is_evaluated = present.as_ref().is_some_and(|own| own.note.is_none());
        let finite_bodies = of_typical.filter(|_| is_evaluated).map(|(_, own)| own);
        let body = all.iter().find_map(|one| one.body);
        let notes_on_problem = problem
            .as_ref()
            .map_or_else(Vec::new, |problem| notes(settings, &*problem.material));
        let mut answer = Self {
            key: question.key(),
            unit: settings.unit(question.key),
            time_step,
            safety: question.safety,
            integrator: (!problem.as_ref().is_some_and(is_transferred))
                .then(|| search.integrator.name()),
            deformation_gradient: *strain.0.components(),
            critical_time_step_of: match (body, finite_bodies) {
                (Some(body), _) => format!(
                    "{}, or of the infinite lattice if that is smaller",
                    body.words()
                ),
                (None, Some(finite)) => format!(
                    "finite bodies, or of the infinite lattice if that is smaller ({})",
                    finite.ground
                ),
                (None, None) => LATTICE_NOTE.to_owned(),
            },
            finite_bodies,
            present,
            admitted: intervals,
            tried: all,
            evidence: Evidence::Searched,
            notes: notes_on_problem,
            settings: settings.effective_beside(question.key()),
            is_range_given: question.range.is_some(),
        };
        let alone = answer.isolated_point();
        answer.notes.extend(alone);
        Ok(answer)
    }

    fn needed(&self) -> f64 {
        needed(self.time_step, self.safety)
    }

    fn admitting(&self) -> impl Iterator<Item = &Tried> {
        self.tried.iter().filter(|one| one.is_admitted())
    }

    /// Warning for a step that the waves of a filled body admit but an isolated material point does not.
    fn isolated_point(&self) -> Option<String> {
        let needed = self.needed();
        let (value, step) = self.admitting().find_map(|one| {
            let alone = one.isolated_point_time_step.filter(|step| *step < needed)?;
            Some((one.value, alone))
        })?;
        Some(format!(
            "these steps are stable for waves; points without neighbors on the grid need shorter steps, with {} = {} below {} (see `onset state`)",
            self.key,
            self.value(told(value)),
            self.step(step)
        ))
    }

    /// Note on values that admit the step although their verdict is not stable.
    fn verdicts(&self) -> Option<String> {
        let unstable = |one: &&Tried| one.verdict.is_some_and(|own| own != Verdict::Stable);
        let names: BTreeSet<&str> = self
            .admitting()
            .filter(unstable)
            .filter_map(|one| one.verdict.map(Verdict::name))
            .collect();
        let with = match self.admitting().all(|one| unstable(&one)) {
            true => "all",
            false => "some",
        };
        let names: Vec<&str> = names.into_iter().collect();
        (!names.is_empty()).then(|| {
            format!(
                "The verdict on the state is {} with {with} of these values: the step applies to the waves that do not grow.",
                names.join(" or ")
            )
        })
    }

    /// The varied setting with its results.
    fn varied(&self) -> Varied<'_, Tried> {
        Varied {
            key: self.key,
            unit: self.unit,
            units: self.units(),
            admitted: &self.admitted,
            tried: &self.tried,
            present: self.present.as_ref(),
            is_range_given: self.is_range_given,
        }
    }

    /// Figure of the critical step as a function of the value, with the required step.
    pub fn figure(&self) -> Figure {
        let varied = self.varied();
        let step = |one: &Tried| {
            let step = one.critical_time_step;
            (step.is_finite() && step > 0.0).then_some(step)
        };
        let tried = self.tried.iter();
        let points: Vec<(f64, f64)> = tried
            .filter_map(|one| Some((one.value, step(one)?)))
            .collect();
        let (x, shown) = varied.axis(&points);
        let steps = shown.iter().map(|point| point.1).chain([self.needed()]);
        let label = caption::label(self.units(), "critical time step", "time");
        let y = Axis::log(label, (1e-4, 1.0)).covering(steps);
        let line = Line::new(points).color(palette::BLUE);
        let needed = Rule::horizontal(self.needed()).dashed();
        let panel = Panel::new("", x, y)
            .with(line.named("critical step"))
            .with(needed.named("required critical step"));
        Figure::new(format!("Critical time step over {}", varied.title()))
            .with(varied.marked(panel, step))
            .caption(caption::settings(&self.settings))
    }

    fn units(&self) -> Units {
        self.settings.units()
    }

    /// All evaluated values as CSV.
    pub fn csv(&self) -> String {
        Table::new(&self.tried, self.units())
            .with("value", self.varied().dimension(), |own| own.value)
            .with("critical_time_step", "time", |own| own.critical_time_step)
            .with("lattice_time_step", "time", |own| own.lattice_time_step)
            .with("verdict", "1", |own| own.verdict.map(Verdict::name))
            .with("note", "1", |own| own.note.clone())
            .to_string()
    }

    /// The answer as `limit.csv` and the figure `limit`.
    pub fn files(&self) -> Files {
        vec![
            text("limit.csv", self.csv()),
            picture("limit", self.figure()),
        ]
    }

    fn value(&self, told: String) -> String {
        self.varied().value(told)
    }

    fn step(&self, step: f64) -> String {
        match step {
            f64::INFINITY => "unbounded".to_owned(),
            0.0 => "none".to_owned(),
            _ => self.units().of(told(step), "s"),
        }
    }

    /// Sentence of the answer. Limits are rounded inward, so that the printed value admits the step.
    fn sentence(&self) -> String {
        let step = self.step(self.time_step);
        let critical = match self.safety {
            1.0 => "the critical one".to_owned(),
            safety => format!("{} of the critical one", told(safety)),
        };
        let below = format!("A time step of {step} is below {critical} with");
        let [first, last] = self.varied().ends_told();
        match self.admitted.is_empty() {
            true if self.is_unstable_for_every_step() => format!(
                "Waves without damping are unstable for every time step of {} with every {} from {first} to {last}.",
                self.integrator.unwrap_or_default(),
                self.key
            ),
            true => {
                let steps = self.tried.iter().filter(|one| one.note.is_none());
                let best =
                    steps.max_by(|a, b| a.critical_time_step.total_cmp(&b.critical_time_step));
                let best = best.map_or_else(String::new, |best| {
                    format!(
                        "; the largest critical step is {}, at {}",
                        self.step(best.critical_time_step),
                        self.value(told(best.value))
                    )
                });
                format!("{below} no {} from {first} to {last}{best}.", self.key)
            }
            false => format!("{below} {}.", self.varied().ranges()),
        }
    }

    fn is_unstable_for_every_step(&self) -> bool {
        let mut evaluated = self.tried.iter().filter(|one| one.note.is_none());
        evaluated.all(|one| one.critical_time_step == 0.0)
    }

    /// Sentence on the present value.
    fn present_sentence(&self) -> Option<String> {
        let present = self.present.as_ref()?;
        let value = self.value(told(present.value));
        let step = present.critical_time_step;
        if let Some(note) = &present.note {
            let note = note.lines().next().unwrap_or_default();
            return Some(format!(
                "Its present value {value} cannot be evaluated: {note}."
            ));
        }
        if step.is_infinite() {
            return Some(format!(
                "Its present value is {value}, which does not limit the step."
            ));
        }
        if step == 0.0 {
            return Some(format!(
                "Its present value is {value}, for which no step is stable."
            ));
        }
        let of = match present.lattice_time_step {
            lattice if step < lattice => format!(
                " ({}; infinite lattice {})",
                match present.body {
                    Some(_) => "body",
                    None => "finite bodies",
                },
                self.step(lattice)
            ),
            _ => String::new(),
        };
        Some(format!(
            "Its present value is {value}, with a critical step of {}{of}; the ratio of the given to the critical step is {}.",
            self.step(step),
            told(self.time_step / step)
        ))
    }
}

impl LimitAnswer {
    /// All sentences of the answer.
    fn sentences(&self) -> String {
        let varied = self.varied();
        let others = varied.ends_of_domain().chain(self.verdicts());
        let sentences = [Some(self.sentence()), self.present_sentence()];
        let all: Vec<String> = sentences.into_iter().flatten().chain(others).collect();
        all.join(" ")
    }

    /// Head of the table.
    fn head(&self) -> String {
        let heading = self.varied().heading();
        format!("{heading:>14}  {:>14}  verdict", "critical step")
    }

    /// Row of a value.
    fn row(&self, one: &Tried) -> String {
        let value = told(one.value);
        match (&one.note, one.verdict) {
            (None, Some(verdict)) => {
                let step = self.step(one.critical_time_step);
                let large = match one.is_admitted() {
                    true => "",
                    false => ", step too large",
                };
                format!("{value:>14}  {step:>14}  {}{large}", verdict.name())
            }
            (note, _) => {
                let note = note.as_deref().unwrap_or_default();
                let note = note.lines().next().unwrap_or_default();
                format!("{value:>14}  {note}")
            }
        }
    }

    /// Bodies for which the steps hold, with the step of the lattice for the present value.
    fn of_steps(&self) -> String {
        let Some((_, now)) = self.finite_bodies.as_ref().zip(self.present.as_ref()) else {
            return self.critical_time_step_of.clone();
        };
        let value = self.value(told(now.value));
        let lattice = self.step(now.lattice_time_step);
        match now.critical_time_step < now.lattice_time_step {
            true => format!("finite bodies; the infinite lattice has {lattice} with {value}"),
            false => format!("infinite lattice, with {value} not more than finite bodies"),
        }
    }

    /// Steps of finite bodies with the present value.
    fn of_finite_bodies(&self) -> Option<String> {
        let finite = self.finite_bodies.as_ref()?;
        let now = self.present.as_ref().map_or(f64::NAN, |own| own.value);
        let now = self.value(told(now));
        Some(format!("with {now}: {}", finite.words(self.units())))
    }
}

impl Brief for LimitAnswer {
    fn brief(&self) -> Short {
        let rows = self.varied().rows_near_limits(SHORT_ROWS);
        let rows = rows.into_iter().map(|one| cut(&self.row(one), WIDTH));
        let mut short = Short::new(self.sentence())
            .table([self.head()].into_iter().chain(rows))
            .row(0, "steps", self.of_steps());
        if let Some(present) = self.present_sentence() {
            short = short.row(1, "present", present);
        }
        for sentence in self.varied().ends_of_domain().chain(self.verdicts()) {
            short = short.row(3, "range", sentence);
        }
        short
            .notes(&self.notes)
            .settings("material", self.settings.law())
            .settings("method", self.settings.method())
    }
}

impl fmt::Display for LimitAnswer {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(formatter, "{}\n\n  {}", self.sentences(), self.head())?;
        for one in self.varied().rows() {
            writeln!(formatter, "  {}", self.row(one))?;
        }
        writeln!(
            formatter,
            "\ncritical steps: {}",
            self.critical_time_step_of
        )?;
        if let Some(finite) = self.of_finite_bodies() {
            writeln!(formatter, "finite bodies, {finite}")?;
        }
        for note in &self.notes {
            writeln!(formatter, "\nnote: {note}")?;
        }
        write!(formatter, "\n{}\n{}", self.evidence, self.settings)
    }
}
