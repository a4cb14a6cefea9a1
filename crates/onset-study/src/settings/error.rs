//! Errors of settings: where, what, and what to do.

use super::{Key, Unmet, Value, aliases};
use crate::localization;
use thiserror::Error;

/// Where a setting was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Origin {
    /// On the command line: the argument as typed.
    CommandLine(String),
    /// In a study file.
    File {
        /// Its name.
        name: String,
        /// Line, counted from 1.
        line: usize,
        /// Column, counted from 1.
        column: usize,
    },
    /// In a question that a page has asked, which can be that of a link.
    Question,
    /// Nowhere in particular: a default or a combination.
    Combination,
}

impl Origin {
    /// Whether somebody else than the user can have made the setting.
    pub(super) fn can_be_a_strangers(&self) -> bool {
        matches!(self, Self::File { .. } | Self::Question)
    }

    /// The place as part of a sentence.
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

/// A setting that cannot be accepted.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub struct SettingError {
    /// Where it was made.
    pub origin: Origin,
    /// What is wrong.
    pub message: String,
    /// What to do.
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
    /// An error without a hint.
    pub fn new(origin: Origin, message: impl Into<String>) -> Self {
        Self {
            origin,
            message: message.into(),
            hint: None,
        }
    }

    /// The error for a key that nothing reads.
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
            "{meant}leave `{}` out; it is read with {}",
            key.name,
            key.readers()
        ))
    }

    /// The same with a hint.
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// With other words in the hint.
    pub(crate) fn with_words_of_hint(mut self, words: &str, others: &str) -> Self {
        self.hint = self.hint.map(|hint| hint.replace(words, others));
        self
    }

    /// Names the word nearest to the one typed, where words are expected.
    pub(crate) fn nearest_word(mut self, key: &str, value: &Value, words: &[&'static str]) -> Self {
        if let Value::Word(word) = value
            && key == "material.model"
            && localization::MODELS.contains(&word.as_str())
        {
            return self.hint(format!(
                "`{word}` is a law of `onset localize --model {word}`, which follows its flow to the first band"
            ));
        }
        if let (Value::Word(word), Some(hint)) = (value, &mut self.hint)
            && let Some(nearest) = aliases::nearest_word(key, word, words)
            && words.len() > 1
        {
            hint.push_str(&format!("; did you mean `{nearest}`?"));
        }
        self
    }
}

/// The end of a sentence that lists names: which of them may have been meant, where one is similar to what was typed.
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

/// The most similar of some names, if any is similar.
pub(super) fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    known
        .map(|candidate| (strsim::jaro_winkler(name, candidate), candidate))
        .filter(|(similarity, _)| *similarity > 0.8)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}
