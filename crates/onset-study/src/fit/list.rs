//! Lists of tests in TOML: tables in other files with their loadings, and tables of numbers.

use super::input::{Opened, TableError, mode_in};
use onset_fit::Mode;
use std::fmt::Write;
use std::path::Path;
use toml::{Spanned, Table, Value};

const HINT: &str = "each [[tests]] has `file = \"uniaxial.csv\"`, or `mode = \"uniaxial\"` and the columns of a table, such as stretch = [1.1, 1.2]";

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    tests: Vec<Spanned<Table>>,
}

/// Returns true for the name of a list of tests.
pub(super) fn is_list(path: &Path) -> bool {
    let ending = path.extension();
    ending.is_some_and(|own| own.eq_ignore_ascii_case("toml"))
}

/// Tests of a list, in its order.
///
/// # Errors
/// [`TableError`] with the line of a test that is not described by a file or by columns of numbers.
pub(super) fn tests<'a>(path: &Path, text: &str) -> Result<Vec<Opened<'a>>, TableError> {
    let refused = |offset: usize, message: String| TableError::Line {
        path: path.to_owned(),
        row: "line",
        line: text[..offset.min(text.len())].matches('\n').count() + 1,
        message,
        hint: HINT.to_owned(),
    };
    let list: List = toml::from_str(text).map_err(|error| {
        let offset = error.span().map_or(0, |span| span.start);
        refused(offset, error.message().to_owned())
    })?;
    let mut all = Vec::new();
    for (n, test) in list.tests.into_iter().enumerate() {
        let place = test.span().start;
        let wrong = |message: String| refused(place, format!("test {}: {message}", n + 1));
        let mut columns = test.into_inner();
        let mut word = |key: &str| match columns.remove(key) {
            None => Ok(None),
            Some(Value::String(word)) => Ok(Some(word)),
            Some(_) => Err(wrong(format!("`{key}` is not a text in quotes"))),
        };
        let (file, mode) = (word("file")?, word("mode")?);
        let weight = match columns.remove("weight") {
            None => None,
            Some(Value::Float(weight)) if weight > 0.0 && weight.is_finite() => Some(weight),
            Some(Value::Integer(weight)) if weight > 0 => Some(weight as f64),
            Some(_) => return Err(wrong("`weight` is not a positive number".to_owned())),
        };
        let known = |mode: &str| {
            mode_in(mode).ok_or_else(|| {
                let names = Mode::ALL.map(Mode::name).join(", ");
                wrong(format!(
                    "the loading `{mode}` is not known; expected {names}"
                ))
            })
        };
        let mode = mode.as_deref().map(known).transpose()?;
        let opened = match (file, mode) {
            (Some(file), mode) => {
                if let Some(key) = columns.keys().next() {
                    return Err(wrong(format!(
                        "the keys `file` and `{key}` exclude each other, because the file has the columns"
                    )));
                }
                let folder = path.parent().unwrap_or(Path::new(""));
                let opened = Opened::file(&folder.join(file), mode);
                opened.map_err(|error| wrong(format!("cannot read {error}")))?
            }
            (None, None) => return Err(wrong("it has neither a file nor a loading".to_owned())),
            (None, Some(mode)) => Opened {
                path: format!("{}, test {}", path.display(), n + 1).into(),
                text: table(&columns).map_err(wrong)?,
                mode: Some(mode),
                is_file: false,
                arrays: None,
                weight: None,
            },
        };
        all.push(Opened { weight, ..opened });
    }
    match all.is_empty() {
        true => Err(refused(0, "the list has no tests".to_owned())),
        false => Ok(all),
    }
}

/// Columns of numbers as a table with a header.
fn table(columns: &Table) -> Result<String, String> {
    let mut cells: Vec<(&str, Vec<String>)> = Vec::new();
    for (name, values) in columns {
        let number = |value: &Value| match value {
            Value::Float(number) => Some(*number),
            Value::Integer(number) => Some(*number as f64),
            _ => None,
        };
        let values: Option<Option<Vec<f64>>> = values
            .as_array()
            .map(|all| all.iter().map(number).collect());
        let Some(Some(values)) = values else {
            return Err(format!("`{name}` is not a list of numbers"));
        };
        cells.push((name, values.iter().map(f64::to_string).collect()));
    }
    joined(&cells)
}

/// Columns of cells as the text of a table with a header.
///
/// # Errors
/// Message about the first column with another number of cells than the column before it.
pub(super) fn joined<S: AsRef<str>>(columns: &[(S, Vec<String>)]) -> Result<String, String> {
    let rows = columns.first().map_or(0, |(_, cells)| cells.len());
    if let Some((name, own)) = columns.iter().find(|(_, own)| own.len() != rows) {
        return Err(format!(
            "`{}` has {} numbers, and the column before it {rows}",
            name.as_ref(),
            own.len()
        ));
    }
    let plain = |text: &str| text.replace([';', '\n', '\r'], " ");
    let names: Vec<String> = columns
        .iter()
        .map(|(name, _)| plain(name.as_ref()))
        .collect();
    let mut text = names.join(";") + "\n";
    for row in 0..rows {
        let cells: Vec<String> = columns.iter().map(|(_, own)| plain(&own[row])).collect();
        let _ = writeln!(text, "{}", cells.join(";"));
    }
    Ok(text)
}
