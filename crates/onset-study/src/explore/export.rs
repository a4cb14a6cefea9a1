//! Export of a question in other forms, and of its map as files.

use super::map::{LEVELS, Maps};
use super::{Question, Refusal, in_time, map};
use crate::answers::assigned;
use crate::boundary::{Boundaries, Tracing};
use crate::plot::figure_of;
use crate::settings::{Settings, Trust};
use crate::shell::quoted;
use onset::cancel::checkpoint;

/// Reserved words of Python among the names of parameters.
const RESERVED_WORDS: [&str; 2] = ["lambda", "yield"];

/// Exports the question, or its map, as `toml`, `command`, `python`, `svg` or `csv`.
pub(super) fn export(question: &Question, trust: &Trust, maps: &Maps) -> Result<String, Refusal> {
    match question.form.as_str() {
        "toml" => Ok(question.study(trust, map::FINEST_STATES)?.document()),
        "command" => Ok(command(question, &question.settings(trust)?)),
        "python" => Ok(python(question, &question.settings(trust)?)),
        "csv" => Ok(maps.domain(question, trust, LEVELS)?.csv()),
        "svg" => {
            let domain = maps.domain(question, trust, LEVELS)?;
            let study = question.study(trust, map::CURVE_STATES)?;
            let traced = in_time(move || Boundaries::of(&study, Tracing::default(), &()));
            let boundaries = traced.and_then(Result::ok);
            checkpoint();
            Ok(figure_of(&domain, boundaries.as_ref()).to_svg())
        }
        other => Err(Refusal::Input(format!(
            "there is no format `{other}`\n  hint: expected toml, command, python, svg or csv"
        ))),
    }
}

/// Question as a command line.
fn command(question: &Question, settings: &Settings) -> String {
    let set = assigned(settings, None);
    let set = set
        .iter()
        .map(|own| format!(" --set {}", quoted(own.as_ref())));
    format!(
        "onset state --stretch {}{}",
        quoted(question.stretch.as_ref()),
        set.collect::<String>()
    )
}

/// Question as a Python call.
fn python(question: &Question, settings: &Settings) -> String {
    let all = assigned(settings, None);
    let of = |section: &str, first: &str| -> String {
        let mut arguments = Vec::new();
        for assignment in &all {
            let (name, value) = assignment.split_once('=').unwrap_or((assignment, ""));
            let Some(own) = name.strip_prefix(section) else {
                continue;
            };
            if own == first {
                arguments.insert(0, literal(value));
            } else {
                let mut keyword = own.replace('-', "_");
                if RESERVED_WORDS.contains(&own) {
                    keyword.push('_');
                }
                arguments.push(format!("{keyword}={}", literal(value)));
            }
        }
        arguments.join(", ")
    };
    format!(
        "import onset\n\nmaterial = onset.Material({})\nmethod = onset.Method({})\nanswer = onset.state(material, method, stretch=({},))\nprint(answer)\n",
        of("material.", "model"),
        of("discretization.", "method"),
        question.stretch
    )
}

/// Python literal of a value: a number, or a text with the escapes of JSON.
fn literal(value: &str) -> String {
    match value.parse::<f64>() {
        Ok(number) if number.is_finite() => value.to_owned(),
        _ => serde_json::Value::from(value).to_string(),
    }
}
