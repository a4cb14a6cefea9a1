//! Errors of files and of requests for columns.

use crate::reading::Quantity;
use std::fmt;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// File, line and frame of an error.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Path of the file.
    pub file: PathBuf,
    /// Line in a text, from 1; `None` for binary formats.
    pub line: Option<u64>,
    /// Number of the frame in its file, from 0; `None` for errors of the whole file.
    pub frame: Option<usize>,
}

impl Place {
    pub(crate) fn file(file: &Path) -> Self {
        Self {
            file: file.to_owned(),
            line: None,
            frame: None,
        }
    }

    pub(crate) fn line(file: &Path, line: u64) -> Self {
        Self {
            line: Some(line),
            ..Self::file(file)
        }
    }

    pub(crate) fn frame(file: &Path, frame: usize) -> Self {
        Self {
            frame: Some(frame),
            ..Self::file(file)
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", self.file.display())?;
        if let Some(frame) = self.frame {
            write!(formatter, ", frame {frame}")?;
        }
        if let Some(line) = self.line {
            write!(formatter, ", line {line}")?;
        }
        Ok(())
    }
}

/// Reason why frames cannot be read.
#[derive(Debug, Error)]
pub enum FrameError {
    /// File that cannot be opened or read.
    #[error("{}: {source}", path.display())]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system or of the compression.
        source: std::io::Error,
    },
    /// Contents that do not follow the format.
    #[error("{place}: expected {expected}{}\n  hint: {hint}", quoted(.found.as_deref()))]
    Wrong {
        /// Place of the error.
        place: Box<Place>,
        /// Description of the expected contents.
        expected: String,
        /// First word of the contents, shortened.
        found: Option<String>,
        /// Remedy for the user.
        hint: String,
    },
    /// Valid contents that are not supported, or that exceed a limit.
    #[error("{place}: {what}\n  hint: {hint}")]
    Refused {
        /// Place of the contents.
        place: Box<Place>,
        /// Reason, as a clause.
        what: String,
        /// Remedy for the user.
        hint: String,
    },
    /// Requested column that the file does not have.
    #[error(
        "{place}: no column {name} for {quantity}\n  hint: the columns are {}",
        listed(available)
    )]
    NoColumn {
        /// Place of the names.
        place: Box<Place>,
        /// Quantity that the column was requested for.
        quantity: Quantity,
        /// Name that the user requested.
        name: String,
        /// Names in the file.
        available: Vec<String>,
    },
    /// File without columns that are recognized as positions.
    #[error(
        "{place}: no positions found\n  hint: name their columns, for example --columns x=NAME or x=NAME1,NAME2; the columns are {}",
        listed(available)
    )]
    NoPositions {
        /// Place of the names.
        place: Box<Place>,
        /// Names in the file.
        available: Vec<String>,
    },
    /// Request that does not match any file.
    #[error("{what}\n  hint: {hint}")]
    Request {
        /// Error in the request, as a sentence.
        what: String,
        /// Remedy for the user.
        hint: String,
    },
}

impl FrameError {
    pub(crate) fn unreadable(path: &Path, source: std::io::Error) -> Self {
        Self::Unreadable {
            path: path.to_owned(),
            source,
        }
    }

    pub(crate) fn wrong(place: Place, expected: impl Into<String>, hint: &str) -> Self {
        Self::Wrong {
            place: Box::new(place),
            expected: expected.into(),
            found: None,
            hint: hint.to_owned(),
        }
    }

    /// Like [`FrameError::wrong`], with the first word of `text`.
    pub(crate) fn unexpected(
        place: Place,
        expected: impl Into<String>,
        text: &[u8],
        hint: &str,
    ) -> Self {
        Self::Wrong {
            place: Box::new(place),
            expected: expected.into(),
            found: Some(word(text)),
            hint: hint.to_owned(),
        }
    }

    pub(crate) fn refused(place: Place, what: impl Into<String>, hint: &str) -> Self {
        Self::Refused {
            place: Box::new(place),
            what: what.into(),
            hint: hint.to_owned(),
        }
    }
}

/// First word of foreign text: at most 24 characters, without control characters.
pub(crate) fn word(text: &[u8]) -> String {
    let text = text.trim_ascii_start();
    let end = text.iter().position(u8::is_ascii_whitespace);
    let end = end.unwrap_or(text.len()).min(96);
    let shown = String::from_utf8_lossy(&text[..end]);
    let shown: String = shown.chars().flat_map(char::escape_debug).collect();
    match shown.char_indices().nth(24) {
        Some((cut, _)) => format!("{}...", &shown[..cut]),
        None => shown,
    }
}

fn quoted(word: Option<&str>) -> String {
    match word {
        Some("") => ", found an empty line".to_owned(),
        Some(word) => format!(", found `{word}`"),
        None => String::new(),
    }
}

/// Number of names listed in an error.
const LISTED_NAMES: usize = 40;

fn listed(names: &[String]) -> String {
    let shown = names.iter().take(LISTED_NAMES);
    let shown: Vec<String> = shown.map(|name| word(name.as_bytes())).collect();
    match names.len().saturating_sub(LISTED_NAMES) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}
