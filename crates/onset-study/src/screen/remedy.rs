//! Changes of a discretization, each with the time at which waves would become visible for the states of the run.

use super::course::{Course, amplified, crossing, own_rate};
use super::states::States;
use super::{Cause, Question, SAFETY_FACTOR};
use crate::answers::{Problem, stabilization};
use crate::number::{told, told_with};
use crate::settings::{Family, Settings, Value};
use crate::tune::{TuneQuestion, recommended};
use nalgebra::Matrix3;
use onset::kernel::Kernel;
use onset::method::Frame;
use serde::Serialize;
use std::sync::Arc;

/// Multiples of the present coefficient of a stabilization, and values that are tried without a stabilization.
const FACTORS: [f64; 4] = [2.0, 5.0, 10.0, 30.0];
const VALUES: [f64; 4] = [0.05, 0.1, 0.3, 1.0];
/// Coefficients of a stabilization that are tried if `onset tune` recommends none.
const LARGE_VALUES: [f64; 6] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0];
/// Largest number of changes in an answer.
const MAXIMUM_CHANGES: usize = 3;

/// Change of settings that avoids or delays an instability.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Remedy {
    /// Changed settings, as `key=value`.
    pub settings: Vec<String>,
    /// Time at which growing waves are then expected to become visible; `None` if they are not expected within the run.
    pub expected: Option<f64>,
    /// Safe time step with the change; `None` if the step of the run is safe, or not known.
    pub time_step: Option<f64>,
}

impl Remedy {
    /// Description of the change and its effect on the waves of a cause, as a clause.
    pub(super) fn told(&self, cause: Cause) -> String {
        let mut change = self.settings.join(" and ");
        if let Some(step) = self.time_step {
            change += &format!(" and a time step of {}", told_with(step, 2));
        }
        match (cause, self.expected) {
            (Cause::ZeroEnergy, _) => format!("with {change} forces resist all short waves"),
            (_, None) => format!("with {change} no such wave is expected in this run"),
            (_, Some(time)) => format!(
                "{change}: growing waves are expected to become visible at t = {}",
                told(time)
            ),
        }
    }
}

/// Smallest coefficient that leaves no spurious and no weakly controlled mode, as `onset tune` recommends it; `None` if the coefficient cannot do this.
fn tuned(settings: &Settings, key: &str) -> Option<f64> {
    recommended(settings, &TuneQuestion::of(key).ok()?)
}

/// Change to total-Lagrangian SPH, with the penalty of `onset tune`; `None` for other methods than updated SPH.
fn total_lagrangian(settings: &Settings) -> Option<Vec<String>> {
    const KEY: &str = "discretization.penalty";
    if settings.method.method != Family::UpdatedSph {
        return None;
    }
    let method = "discretization.method=total-lagrangian-sph".to_owned();
    let mut other = settings.clone();
    other.assign(&method).ok()?;
    let penalty = tuned(&other, KEY)?;
    Some(vec![method, format!("{KEY}={}", told(penalty))])
}

/// Largest stable step of the body with changed settings, if it changes like the step of the lattice; `None` without a time step.
fn critical_step(problem: &Problem, question: &Question, course: &Course) -> Option<f64> {
    let (stepping, limit) = question.stepping().zip(course.step.as_ref())?;
    let states = States::new(problem, Some(stepping), question.bin);
    let squared = states.evaluate(&Matrix3::identity())?.squared;
    let of_body = limit.body.map_or(1.0, |body| body / limit.lattice);
    Some(stepping.0.critical_step(squared, 0.0) * of_body.min(1.0))
}

/// Safe step of a changed problem, if the step of the run is not safe.
fn safe_step(problem: &Problem, question: &Question, course: &Course) -> Option<f64> {
    let safe = SAFETY_FACTOR * critical_step(problem, question, course)?;
    question.time_step.filter(|step| *step > safe).map(|_| safe)
}

/// Changes after which forces resist all short waves.
pub(super) fn controls(problem: &Problem, question: &Question, course: &Course) -> Vec<Remedy> {
    let settings = &problem.settings;
    let key = stabilization(settings, problem.analysis.sites() == 1);
    let is_control = |change: &[String]| {
        let other = changed(problem, change);
        let weakest = other.and_then(|other| weakest(&other));
        weakest.is_some_and(|own| own >= question.weak)
    };
    let own = key.and_then(|key| {
        let change = |value: f64| vec![format!("{key}={}", told(value))];
        // Codes that regularize the penalty need values beyond the range of `onset tune`.
        let tuned = tuned(settings, key).map(change);
        tuned.or_else(|| {
            LARGE_VALUES
                .map(change)
                .into_iter()
                .find(|own| is_control(own))
        })
    });
    let full = match settings.method.method {
        Family::FiniteElements => Some(vec!["discretization.integration=full".to_owned()]),
        _ => None,
    };
    let changes = [own, full, total_lagrangian(settings)];
    let remedy = |change: Vec<String>| {
        onset::cancel::checkpoint();
        let other = changed(problem, &change).filter(|_| is_control(&change))?;
        Some(Remedy {
            settings: change,
            expected: None,
            time_step: safe_step(&other, question, course),
        })
    };
    changes.into_iter().flatten().filter_map(remedy).collect()
}

/// Relative frequency of the weakest wave; 1 without a weakly controlled wave, `None` if it is not known.
fn weakest(problem: &Problem) -> Option<f64> {
    let weakest = problem.analysis.weakest().ok()?;
    Some(weakest.map_or(1.0, |mode| mode.relative_frequency()))
}

/// Sequences of changes, from the smallest to the largest change; in each sequence the first change that helps is reported.
fn ladders(problem: &Problem) -> Vec<Vec<Vec<String>>> {
    let settings = &problem.settings;
    let mut ladders = Vec::new();
    if let Some(key) = stabilization(settings, problem.analysis.sites() == 1) {
        let now = match settings.value(key) {
            Some(Value::Number(now)) => now,
            _ => 0.0,
        };
        let least = tuned(settings, key).unwrap_or(0.0);
        let values = match now.max(least) {
            0.0 => VALUES.to_vec(),
            from => [1.0]
                .into_iter()
                .chain(FACTORS)
                .map(|factor| factor * from)
                .filter(|value| *value > now)
                .collect(),
        };
        let rung = |value: &f64| vec![format!("{key}={}", told(*value))];
        ladders.push(values.iter().map(rung).collect());
    }
    match settings.method.method {
        Family::UpdatedSph => {
            ladders.extend(total_lagrangian(settings).map(|change| vec![change]));
            let others = Kernel::ALL.into_iter();
            let others = others.filter(|kernel| *kernel != settings.discretization.kernel);
            let rung = |kernel: Kernel| vec![format!("discretization.kernel={}", kernel.name())];
            ladders.push(others.map(rung).collect());
        }
        Family::Kernel if settings.discretization.frame == Frame::Eulerian => {
            ladders.push(vec![vec!["discretization.frame=lagrangian".to_owned()]]);
        }
        Family::FiniteElements => {
            ladders.push(vec![vec!["discretization.integration=full".to_owned()]]);
        }
        _ => {}
    }
    ladders
}

/// Changed settings with the law of a problem; `None` if they are inconsistent.
fn changed(problem: &Problem, change: &[String]) -> Option<Problem> {
    let mut settings = problem.settings.clone();
    for assignment in change {
        settings.assign(assignment).ok()?;
    }
    Problem::with_law(settings, Arc::clone(&problem.material)).ok()
}

/// States with the largest growth in a run, extrapolated at the mean rate of loading after the first short waves.
fn loading(course: &Course) -> Vec<(f64, Matrix3<f64>)> {
    let grown = course.grown.as_ref().map(|(event, _)| event.window[1]);
    let observed = course.observed.as_ref().map(|event| event.window[1]);
    let end = grown
        .into_iter()
        .chain(observed)
        .fold(f64::INFINITY, f64::min);
    let mut leading: Vec<(f64, Matrix3<f64>)> = course.leading.clone();
    let sound = leading.iter().filter(|(time, _)| *time <= end).count();
    let (Some((start, from)), Some((last, to))) = (
        leading.first().copied(),
        sound.checked_sub(1).map(|n| leading[n]),
    ) else {
        return leading;
    };
    if last > start {
        let rate = (to - from) / (last - start);
        leading.truncate(sound);
        let later = course.moments.iter().map(|moment| moment.time);
        let later = later.filter(|time| *time > last);
        leading.extend(later.map(|time| (time, to + rate * (time - last))));
    }
    leading
}

/// Time at which waves of a problem become visible in the states with the largest growth in a run, in bins of a given width; `None` if a state is not
/// defined.
pub(super) fn expected(
    problem: &Problem,
    question: &Question,
    course: &Course,
    bin: f64,
) -> Option<Option<f64>> {
    let mut states = States::new(problem, question.stepping(), bin);
    let keys: Vec<(f64, [i32; 6])> = loading(course)
        .iter()
        .map(|(time, u)| (*time, states.key(u)))
        .collect();
    states.ask(keys.iter().map(|(_, key)| *key));
    let (mut integral, mut before) = (0.0_f64, None::<(f64, f64)>);
    let mut last_amplitude = course.seed;
    for (time, key) in keys {
        let rate = own_rate(states.of(&key)?);
        if let Some((since, last)) = before {
            integral = (integral + 0.5 * (last + rate) * (time - since)).max(0.0);
        }
        let amplitude = amplified(course.seed, integral);
        if amplitude > question.threshold {
            let crossed = before.map_or(time, |(since, _)| {
                let share = crossing(last_amplitude, amplitude, question.threshold);
                since + share.clamp(0.0, 1.0) * (time - since)
            });
            return Some(Some(crossed));
        }
        last_amplitude = amplitude;
        before = Some((time, rate));
    }
    Some(None)
}

/// Changes after which the waves of the discretization become visible clearly later than `now`, or not at all.
pub(super) fn remedies(
    problem: &Problem,
    question: &Question,
    course: &Course,
    now: f64,
) -> Vec<Remedy> {
    let start = course.leading.first().map_or(0.0, |(time, _)| *time);
    let mut found = Vec::new();
    for ladder in ladders(problem) {
        let mut best: Option<Remedy> = None;
        for change in ladder {
            onset::cancel::checkpoint();
            let Some(other) = changed(problem, &change) else {
                continue;
            };
            // Another kernel must not control short waves less.
            let is_weaker = || {
                let (own, now) = (weakest(&other), weakest(problem));
                own < now && own < Some(question.weak)
            };
            if change[0].starts_with("discretization.kernel=") && is_weaker() {
                continue;
            }
            let Some(expected) = expected(&other, question, course, question.bin) else {
                continue;
            };
            let is_later = expected.is_none_or(|time| time - start > 1.2 * (now - start));
            let is_better = match &best {
                None => is_later,
                Some(own) => expected.is_none_or(|time| own.expected.is_some_and(|own| time > own)),
            };
            if is_better {
                best = Some(Remedy {
                    settings: change,
                    expected,
                    time_step: safe_step(&other, question, course),
                });
            }
            if expected.is_none() {
                break;
            }
        }
        found.extend(best);
    }
    found.truncate(MAXIMUM_CHANGES);
    found
}
