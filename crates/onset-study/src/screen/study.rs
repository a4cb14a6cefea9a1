//! Study file of the decisive state of a run, for other commands.

use super::{Cause, Question, ScreenAnswer};
use crate::answers::{Problem, assigned};
use crate::number::told_with;
use crate::settings::{RUN_STEP, RUN_STEPPING};
use crate::shell::quoted;
use toml::{Table, Value};

/// Largest shear of a state that counts as stretched along the axes.
const LARGEST_SHEAR: f64 = 0.01;

/// Components of a deformation gradient in the dimensions of a problem, as `--deformation-gradient` reads them.
pub(super) fn gradient(f: &[[f64; 3]; 3], dimension: usize) -> String {
    let components = f[..dimension].iter().flat_map(|row| &row[..dimension]);
    let told: Vec<String> = components.map(|x| format!("{x:.5}")).collect();
    told.join(",")
}

/// Command that repeats the assessment of a state; `None` for laws that no command can name.
pub(super) fn command(problem: &Problem, f: &[[f64; 3]; 3]) -> Option<String> {
    if problem.settings.material.is_handed() {
        return None;
    }
    let sets = assigned(&problem.settings, None);
    let sets = sets
        .iter()
        .map(|set| format!(" --set {}", quoted(set.as_ref())));
    Some(format!(
        "onset state --deformation-gradient={}{}",
        gradient(f, problem.dimension()),
        sets.collect::<String>()
    ))
}

/// Value of an assignment in a study file.
fn value(text: &str) -> Value {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    if let Ok(is) = text.parse::<bool>() {
        return Value::Boolean(is);
    }
    if let Ok(whole) = text.parse::<i64>() {
        return Value::Integer(whole);
    }
    if let Some(number) = number(text) {
        return Value::Float(number);
    }
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    match numbers {
        Some(numbers) => Value::Array(numbers.into_iter().map(Value::Float).collect()),
        None => Value::String(text.to_owned()),
    }
}

/// Stretches along the axes, if a gradient has no others, and the out-of-plane stretch of a state in the plane is 1.
fn stretches(f: &[[f64; 3]; 3], dimension: usize) -> Option<String> {
    let is_small = |i: usize, j: usize| i == j || f[i][j].abs() < LARGEST_SHEAR;
    let is_along = (0..3).all(|i| (0..3).all(|j| is_small(i, j)));
    let all = (0..dimension).map(|i| format!("{:.5}", f[i][i]));
    is_along.then(|| all.collect::<Vec<_>>().join(","))
}

/// Comments at the head of the study: the sentence, and the commands that examine the state.
fn head(answer: &ScreenAnswer, problem: &Problem, question: &Question, wave: &[f64]) -> String {
    let mut lines = vec![answer.sentence.clone(), String::new()];
    let dimension = problem.dimension();
    let (f, of_axes) = answer
        .first
        .as_ref()
        .map_or_else(Default::default, |event| {
            (
                gradient(&event.f, dimension),
                stretches(&event.f, dimension),
            )
        });
    let scheme = question.stepping();
    let scheme = scheme.map(|(own, step)| format!(" --time-step {step} --stepping {}", own.name()));
    let scheme = scheme.unwrap_or_default();
    lines.push(format!("onset state first.toml --deformation-gradient={f}"));
    match (&answer.time_step, answer.cause) {
        (Some(limit), Cause::TimeStep) => {
            lines.push(format!(
                "The step of the run is the cause: in continuous time the state is stable. Settings of the run:{scheme}"
            ));
            let critical = told_with(limit.decisive(), 4);
            lines.push(match limit.body {
                Some(_) => format!(
                    "Largest stable step of the body {critical}, of the infinite lattice {}.",
                    told_with(limit.lattice, 4)
                ),
                None => format!("Largest stable step of the infinite lattice {critical}."),
            });
        }
        _ => lines.push(format!(
            "onset simulate first.toml --deformation-gradient={f} --mode critical"
        )),
    }
    if let Some(stretches) = of_axes.filter(|_| !wave.is_empty()) {
        let k: Vec<String> = wave.iter().map(|k| format!("{k:.5}")).collect();
        // The decks of codes have no viscosity; the general protocol admits it.
        lines.push(format!(
            "onset verify deck first.toml --code plain --stretch {stretches} --wave-vector={}{scheme} --out deck",
            k.join(",")
        ));
        if problem.settings.method.viscosity != 0.0 {
            lines.push(
                "The decks of other codes have no viscosity: add --set discretization.viscosity=0 for --code pysph and others."
                    .to_owned(),
            );
        }
    }
    lines
        .iter()
        .map(|line| format!("# {line}").trim_end().to_owned() + "\n")
        .collect()
}

/// Study with law, method and decisive state; `None` without such a state.
pub(super) fn study(
    answer: &ScreenAnswer,
    problem: &Problem,
    question: &Question,
    wave: &[f64],
) -> Option<String> {
    answer.first.as_ref()?;
    if problem.settings.material.is_handed() {
        return None;
    }
    let mut tables = Table::new();
    let mut settings = assigned(&problem.settings, None);
    if let Some((stepping, step)) = question.stepping() {
        let step = problem.settings.units().of(step, "s");
        settings.push(format!("{RUN_STEP}={step}"));
        settings.push(format!("{RUN_STEPPING}={}", stepping.name()));
    }
    for set in settings {
        let (key, text) = set.split_once('=')?;
        let (section, name) = key.split_once('.')?;
        let table = tables
            .entry(section)
            .or_insert_with(|| Value::Table(Table::new()));
        table.as_table_mut()?.insert(name.to_owned(), value(text));
    }
    let head = head(answer, problem, question, wave);
    Some(head + "\n" + &toml::to_string(&tables).ok()?)
}
