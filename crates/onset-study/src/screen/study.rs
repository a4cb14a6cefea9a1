//! Study file of the decisive state of a run, for other commands.

use super::ScreenAnswer;
use crate::answers::{Problem, assigned};
use crate::shell::quoted;
use toml::{Table, Value};

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

/// Study with law, method and decisive state; `None` without such a state.
pub(super) fn study(answer: &ScreenAnswer, problem: &Problem) -> Option<String> {
    let event = answer.first.as_ref()?;
    if problem.settings.material.is_handed() {
        return None;
    }
    let mut tables = Table::new();
    for set in assigned(&problem.settings, None) {
        let (key, text) = set.split_once('=')?;
        let (section, name) = key.split_once('.')?;
        let table = tables
            .entry(section)
            .or_insert_with(|| Value::Table(Table::new()));
        table.as_table_mut()?.insert(name.to_owned(), value(text));
    }
    let f = gradient(&event.f, problem.dimension());
    let head = format!(
        "# {}\n#\n# onset state first.toml --deformation-gradient={f}\n# onset simulate first.toml --deformation-gradient={f} --mode critical\n",
        answer.sentence
    );
    Some(head + "\n" + &toml::to_string(&tables).ok()?)
}
