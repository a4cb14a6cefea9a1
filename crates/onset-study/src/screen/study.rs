//! Study file of the decisive state of a run, for other commands.

use super::ScreenAnswer;
use crate::answers::{Problem, assigned};
use crate::shell::quoted;
use std::fmt::Write;
use toml::{Table, Value};

/// Components of a deformation gradient in the dimensions of a problem, as `--deformation-gradient` reads them.
pub(super) fn gradient(f: &[[f64; 3]; 3], dimension: usize) -> String {
    let components = f[..dimension].iter().flat_map(|row| &row[..dimension]);
    let told: Vec<String> = components.map(|x| format!("{x:.5}")).collect();
    told.join(",")
}

/// Command that repeats the judgment of a state; `None` for laws that no command can name.
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

/// Stretches and rotation of a symmetric gradient without shear out of the plane, as the keys of `[state]`.
fn state(u: &[[f64; 3]; 3]) -> Option<Table> {
    if u[0][2] != 0.0 || u[1][2] != 0.0 {
        return None;
    }
    let (mean, half) = (0.5 * (u[0][0] + u[1][1]), 0.5 * (u[0][0] - u[1][1]));
    let apart = half.hypot(u[0][1]);
    // U = R^T diag(mean + apart, mean - apart) R.
    let rotation = -0.5 * u[0][1].atan2(half);
    let entries = [
        ("stretch-1", mean + apart),
        ("stretch-2", mean - apart),
        ("stretch-3", u[2][2]),
        ("rotation", if apart == 0.0 { 0.0 } else { rotation }),
    ];
    let entries = entries.map(|(name, number)| (name.to_owned(), Value::Float(number)));
    Some(entries.into_iter().collect())
}

/// Study with law, method and decisive state; `None` without such a state.
pub(super) fn study(answer: &ScreenAnswer, problem: &Problem) -> Option<String> {
    let event = answer.first.as_ref()?;
    let command = command(problem, &event.f)?;
    let mut tables = Table::new();
    for set in assigned(&problem.settings, None) {
        let (key, text) = set.split_once('=')?;
        let (section, name) = key.split_once('.')?;
        let table = tables
            .entry(section)
            .or_insert_with(|| Value::Table(Table::new()));
        table.as_table_mut()?.insert(name.to_owned(), value(text));
    }
    if let Some(state) = state(&event.f) {
        tables.insert("state".to_owned(), Value::Table(state));
    }
    let mut text = String::new();
    let _ = writeln!(text, "# {}\n# {command}\n", answer.sentence);
    text.push_str(&toml::to_string(&tables).ok()?);
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::state;
    use crate::settings::StateSettings;

    #[test]
    fn stretches_and_rotation_restore_the_gradient() {
        for u in [
            [[1.2, 0.1, 0.0], [0.1, 0.9, 0.0], [0.0, 0.0, 1.05]],
            [[0.8, -0.3, 0.0], [-0.3, 1.4, 0.0], [0.0, 0.0, 1.0]],
            [[1.1, 0.0, 0.0], [0.0, 1.1, 0.0], [0.0, 0.0, 1.1]],
        ] {
            let table = state(&u).expect("no shear out of the plane");
            let number = |name: &str| table[name].as_float().expect("a number");
            let settings = StateSettings {
                stretches: [
                    number("stretch-1"),
                    number("stretch-2"),
                    number("stretch-3"),
                ],
                rotation: number("rotation"),
                ..StateSettings::default()
            };
            let found = *settings.deformation().expect("a state").components();
            for (found, given) in found.as_flattened().iter().zip(u.as_flattened()) {
                assert!((found - given).abs() < 1e-12, "{found} {given}");
            }
        }
    }
}
