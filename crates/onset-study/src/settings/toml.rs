//! Values of TOML files, with their positions.

use super::{Key, Kind, Origin, SettingError, Value, unknown_key};
use std::borrow::Cow;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

pub(super) type Entry<'a, 'i> = (&'a Spanned<Cow<'i, str>>, &'a Spanned<DeValue<'i>>);

/// File with its name; positions in it are origins of settings.
pub(super) struct File<'t> {
    pub(super) name: &'t str,
    text: &'t str,
    /// Offset of each line except the first.
    line_starts: Vec<usize>,
    /// Offsets of the bytes that do not begin a character.
    continuations: Vec<usize>,
}

impl<'t> File<'t> {
    pub(super) fn new(name: &'t str, text: &'t str) -> Self {
        let places = |chosen: fn(u8) -> bool| -> Vec<usize> {
            let bytes = text.bytes().enumerate();
            bytes
                .filter_map(|(at, byte)| chosen(byte).then_some(at))
                .collect()
        };
        Self {
            name,
            text,
            line_starts: places(|byte| byte == b'\n')
                .into_iter()
                .map(|at| at + 1)
                .collect(),
            continuations: places(|byte| byte & 0xc0 == 0x80),
        }
    }

    /// Parses the whole file as a table.
    ///
    /// # Errors
    /// [`SettingError`] when the file is not valid TOML.
    pub(super) fn table(&self) -> Result<Spanned<DeTable<'t>>, SettingError> {
        DeTable::parse(self.text).map_err(|error| {
            let offset = error.span().map_or(0, |span| span.start);
            let message = error.message().to_owned();
            let hint = match message.as_str() {
                "duplicate key" => {
                    "a key may occur only once in its section, and a section only once in the file"
                }
                _ => "expected TOML: lines `key = value` below `[section]`, texts in quotes",
            };
            SettingError::new(self.at(offset), message).hint(hint)
        })
    }

    pub(super) fn at(&self, offset: usize) -> Origin {
        let offset = offset.min(self.text.len());
        let line = self.line_starts.partition_point(|start| *start <= offset);
        let start = line
            .checked_sub(1)
            .map_or(0, |before| self.line_starts[before]);
        let continuations = |end: usize| self.continuations.partition_point(|at| *at < end);
        Origin::File {
            name: self.name.to_owned(),
            line: line + 1,
            column: offset - start - (continuations(offset) - continuations(start)) + 1,
        }
    }

    pub(super) fn of<T>(&self, spanned: &Spanned<T>) -> Origin {
        self.at(spanned.span().start)
    }
}

/// Returns the entries of a table in the order of the file, so that the first error is reported first.
pub(super) fn in_order<'a, 'i>(table: &'a DeTable<'i>) -> Vec<Entry<'a, 'i>> {
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    entries
}

/// Reads the keys of a section in the order of the file, and passes each to `put`. `names` are the known names, for suggestions.
///
/// # Errors
/// [`SettingError`] for an unknown key, a value of a wrong kind, and any error of `put`.
pub(super) fn read_keys<'n>(
    file: &File<'_>,
    section: &str,
    table: &DeTable<'_>,
    names: impl Iterator<Item = &'n str> + Clone,
    mut put: impl FnMut(&'static Key, &Value, Origin) -> Result<(), SettingError>,
) -> Result<(), SettingError> {
    for (key, value) in in_order(table) {
        let name = format!("{section}.{}", key.get_ref());
        let is_measure = scalar(value.get_ref()).is_some_and(|value| value.is_measure());
        let Some(known) = Key::for_setting(&name, is_measure) else {
            return Err(unknown_key(&name, names, file.of(key)));
        };
        put(known, &typed(known, value, file)?, file.of(value))?;
    }
    Ok(())
}

/// Converts a value to the kind that the key expects.
///
/// # Errors
/// [`SettingError`] for dates, tables, and unexpected lists.
pub(super) fn typed(
    known: &Key,
    value: &Spanned<DeValue<'_>>,
    file: &File<'_>,
) -> Result<Value, SettingError> {
    let typed = match known.kind {
        Kind::Numbers(..) => list(value.get_ref()).map(Value::Numbers),
        Kind::Subset(_) => words(value.get_ref()).map(Value::Words),
        _ => scalar(value.get_ref()),
    };
    typed.ok_or_else(|| {
        let message = format!("`{}` cannot be {}", known.name, described(value.get_ref()));
        let hint = format!("expected {} ({})", known.expects(), known.meaning);
        SettingError::new(file.of(value), message).hint(hint)
    })
}

/// A value that a key can accept; `None` for dates, lists and tables.
pub(super) fn scalar(value: &DeValue<'_>) -> Option<Value> {
    match value {
        DeValue::String(word) => Some(Value::Word(word.to_string())),
        DeValue::Boolean(on) => Some(Value::Switch(*on)),
        DeValue::Float(float) => float.as_str().parse().ok().map(Value::Number),
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix())
            .ok()
            .map(|integer| Value::Number(integer as f64)),
        _ => None,
    }
}

/// A list of numbers; `None` for anything else.
pub(super) fn list(value: &DeValue<'_>) -> Option<Vec<f64>> {
    match value {
        DeValue::Array(items) => items
            .iter()
            .map(|item| scalar(item.get_ref())?.number())
            .collect(),
        _ => None,
    }
}

/// A list of words; `None` for anything else.
pub(super) fn words(value: &DeValue<'_>) -> Option<Vec<String>> {
    let DeValue::Array(items) = value else {
        return None;
    };
    let word = |item: &Spanned<DeValue<'_>>| match item.get_ref() {
        DeValue::String(word) => Some(word.to_string()),
        _ => None,
    };
    items.iter().map(word).collect()
}

/// A value as a message shows it.
pub(super) fn described(value: &DeValue<'_>) -> String {
    match value {
        DeValue::Datetime(date) => format!("the date {date}"),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
        DeValue::Integer(integer) => onset_frames::brief(&integer.to_string()),
        other => scalar(other).map_or_else(String::new, |value| value.brief()),
    }
}
