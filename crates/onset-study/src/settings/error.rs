//! Errors of settings, with their place, their cause and a hint.

use super::{Key, Unmet, Value, aliases};
use thiserror::Error;

/// Place at which a setting was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Argument on the command line, as typed.
    CommandLine(String),
    /// Position in a study file.
    File {
        /// Name of the file.
        name: String,
        /// Line, counted from 1.
        line: usize,
        /// Column, counted from 1.
        column: usize,
    },
    /// Request of the browser page, possibly through a link from another person.
    Question,
    /// No particular place: a default or a combination of settings.
    Combination,
}

impl Origin {
    /// Returns true if another person may have made the setting.
    pub(super) fn can_be_a_strangers(&self) -> bool {
        matches!(self, Self::File { .. } | Self::Question)
    }

    /// Place as part of a sentence.
    pub(super) fn place(&self) -> String {
        match self {
            Self::CommandLine(argument) => argument.clone(),
            Self::File { line, column, .. } => format!("line {line}, column {column}"),
            Self::Question | Self::Combination => "another place".to_owned(),
        }
    }
}

impl std::fmt::Display for Origin {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::CommandLine(argument) => write!(formatter, "{argument}: "),
            Self::File { name, line, column } => write!(formatter, "{name}:{line}:{column}: "),
            Self::Question | Self::Combination => Ok(()),
        }
    }
}

/// Setting that cannot be accepted.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub struct SettingError {
    /// Place of the setting.
    pub origin: Origin,
    /// Description of the error.
    pub message: String,
    /// Suggestion for the user; `None` without a suggestion.
    pub hint: Option<String>,
}

impl std::fmt::Display for SettingError {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{}{}", self.origin, self.message)?;
        match &self.hint {
            Some(hint) => write!(formatter, "\n  hint: {hint}"),
            None => Ok(()),
        }
    }
}

impl SettingError {
    /// Creates an error without a hint.
    pub fn new(origin: Origin, message: impl Into<String>) -> Self {
        Self {
            origin,
            message: message.into(),
            hint: None,
        }
    }

    /// Error for a key that has no effect.
    pub(super) fn unread(key: &Key, unmet: &Unmet, origin: Origin) -> Self {
        let value = match &unmet.value {
            Value::Word(word) => word.clone(),
            other => other.to_string(),
        };
        let message = format!(
            "`{}` has no effect: {} is {value}",
            key.name, unmet.need.key
        );
        let meant = aliases::counterpart(key.name, &value)
            .map_or_else(String::new, |other| format!("did you mean `{other}`? Or "));
        Self::new(origin, message).hint(format!(
            "{meant}omit `{}`; it is used only with {}",
            key.name,
            key.readers()
        ))
    }

    /// Adds a hint to the error.
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// Replaces words in the hint.
    pub(crate) fn with_words_of_hint(mut self, words: &str, others: &str) -> Self {
        self.hint = self.hint.map(|hint| hint.replace(words, others));
        self
    }

    /// Adds the most similar word to the message, if words are expected.
    pub(crate) fn nearest_word(mut self, key: &str, value: &Value, words: &[&'static str]) -> Self {
        if let (Value::Word(word), Some(hint)) = (value, &mut self.hint)
            && let Some(nearest) = aliases::nearest_word(key, word, words)
            && words.len() > 1
        {
            hint.push_str(&format!("; did you mean `{nearest}`?"));
        }
        self
    }
}

/// Suffix for a message with the most similar name, or an empty string.
///
/// ```
/// use onset_study::settings::did_you_mean;
/// assert_eq!(did_you_mean("uniaxal", ["uniaxial", "planar"]), "; did you mean `uniaxial`?");
/// assert_eq!(did_you_mean("torsion", ["uniaxial", "planar"]), "");
/// ```
pub fn did_you_mean<'a>(typed: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let typed = typed.trim().to_ascii_lowercase();
    nearest(&typed, names.into_iter())
        .map_or_else(String::new, |meant| format!("; did you mean `{meant}`?"))
}

/// Returns true if a name is the beginning or the end of another, in whole words between hyphens, in the same section.
fn is_part(name: &str, other: &str) -> bool {
    let [(section, own), (of_other, all)] =
        [name, other].map(|name| name.rsplit_once('.').unwrap_or(("", name)));
    let is_end = all
        .strip_suffix(own)
        .is_some_and(|rest| rest.ends_with('-'));
    let is_beginning = all
        .strip_prefix(own)
        .is_some_and(|rest| rest.starts_with('-'));
    section == of_other && (is_end || is_beginning)
}

/// The most similar name, or `None` without a similar one.
pub(super) fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let known: Vec<&str> = known.collect();
    // A name that lacks a word at its beginning or its end, if it can be only one.
    let mut longer = known.iter().filter(|other| is_part(name, other));
    if let (Some(only), None) = (longer.next(), longer.next()) {
        return Some(only);
    }
    known
        .into_iter()
        .map(|candidate| (strsim::jaro_winkler(name, candidate), candidate))
        .filter(|(similarity, _)| *similarity > 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}
