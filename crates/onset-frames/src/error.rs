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
        "{place}: no column {name} for {quantity}\n  hint: the file has {}",
        listed(available, |own| is_similar(own, name), is_word)
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
        "{place}: no positions found\n  hint: name their columns, for example --columns x=NAME or x=NAME1,NAME2; the file has {}",
        listed(available, is_position, |_| false)
    )]
    NoPositions {
        /// Place of the names.
        place: Box<Place>,
        /// Names in the file.
        available: Vec<String>,
    },
    /// File of arrays without an array that is recognized as positions.
    #[error(
        "{place}: no positions found, expected an array of numbers with the shape (particles, D) or (frames, particles, D) and a usual name, such as x or position\n  hint: name it, for example --columns x=NAME; the file has {}",
        listed_arrays(arrays, others)
    )]
    NoArray {
        /// Place of the arrays.
        place: Box<Place>,
        /// Names and shapes of the arrays of numbers in the file.
        arrays: Vec<(String, Vec<usize>)>,
        /// Names of the other contents, which are not arrays of numbers.
        others: Vec<String>,
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
            found: Some(brief(text)),
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

/// Number of characters of foreign text in a message.
const QUOTED: usize = 24;

/// First word of foreign text: at most 24 characters, without control characters. A message quotes no more of a file.
///
/// ```
/// assert_eq!(onset_frames::brief("two words"), "two");
/// assert_eq!(onset_frames::brief(&"a".repeat(100)), "aaaaaaaaaaaaaaaaaaaaaaaa...");
/// ```
pub fn brief(text: &(impl AsRef<[u8]> + ?Sized)) -> String {
    let text = text.as_ref().trim_ascii_start();
    let end = text.iter().position(u8::is_ascii_whitespace);
    let end = end.unwrap_or(text.len()).min(4 * (QUOTED + 1));
    cut(&String::from_utf8_lossy(&text[..end]))
}

/// First 24 characters of foreign text, without control characters; for names with blanks.
pub fn cut(text: &str) -> String {
    let shown = text.chars().take(QUOTED + 1);
    let shown: String = shown.flat_map(char::escape_debug).collect();
    match shown.char_indices().nth(QUOTED) {
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
const LISTED_NAMES: usize = 6;

/// Number of columns, and some of their names: the names that may be the expected ones, then others that may be shown.
fn listed(
    names: &[String],
    is_near: impl Fn(&str) -> bool,
    is_shown: impl Fn(&str) -> bool,
) -> String {
    let near = names.iter().filter(|name| is_near(name));
    let others = names.iter().filter(|name| !is_near(name) && is_shown(name));
    let near = near.chain(others).take(LISTED_NAMES);
    let near: Vec<String> = near.map(|name| format!("`{}`", cut(name))).collect();
    let count = match names.len() {
        1 => "1 column".to_owned(),
        count => format!("{count} columns"),
    };
    match (near.is_empty(), names.len()) {
        (true, _) => count,
        (false, count_of) if near.len() == count_of => format!("{count}, {}", near.join(", ")),
        (false, _) => format!("{count}, among them {}", near.join(", ")),
    }
}

/// Some of the arrays with their shapes, then some of the contents that are not arrays of numbers.
fn listed_arrays(arrays: &[(String, Vec<usize>)], others: &[String]) -> String {
    let shape = |own: &[usize]| match own {
        [] => "one number".to_owned(),
        own => own
            .iter()
            .map(usize::to_string)
            .collect::<Vec<_>>()
            .join(" x "),
    };
    let is_shown = |name: &str| is_word(&name.replace('/', "."));
    let list = |names: Vec<String>, count: usize| match (names.len(), count) {
        (0, count) => format!("{count} with unusual names"),
        (shown, count) if shown < count => {
            format!("{} and {} more", names.join(", "), count - shown)
        }
        _ => names.join(", "),
    };
    let shown = arrays
        .iter()
        .filter(|(name, _)| is_shown(name))
        .take(LISTED_NAMES);
    let shown = shown.map(|(name, own)| format!("`{}` ({})", cut_path(name), shape(own)));
    let mut text = match arrays.len() {
        0 => "no array of numbers".to_owned(),
        count => format!("the arrays {}", list(shown.collect(), count)),
    };
    if !others.is_empty() {
        let shown = others
            .iter()
            .filter(|name| is_shown(name))
            .take(LISTED_NAMES);
        let shown = shown.map(|name| format!("`{}`", cut_path(name)));
        text += &format!(
            "; not arrays of numbers: {}",
            list(shown.collect(), others.len())
        );
    }
    text
}

/// The end of a path in a file, which names its array.
fn cut_path(path: &str) -> String {
    let count = path.chars().count();
    match count > QUOTED {
        true => format!(
            "...{}",
            path.chars().skip(count - QUOTED).collect::<String>()
        ),
        false => path.to_owned(),
    }
}

/// Returns true if a name is one word of letters, digits and the usual signs, as columns have it; other text of a file is not quoted.
fn is_word(name: &str) -> bool {
    let is_usual = |letter: char| letter.is_ascii_alphanumeric() || "_[]().:-".contains(letter);
    !name.is_empty() && name.chars().all(is_usual)
}

/// Returns true if a name may be a coordinate.
pub(crate) fn is_position(name: &str) -> bool {
    let plain = name.to_ascii_lowercase();
    let is_short = plain.len() < 4 && plain.starts_with(['x', 'y', 'z']);
    is_short || ["pos", "coord"].iter().any(|part| plain.contains(part))
}

/// Returns true if two names are equal, or one contains the other, up to case and punctuation.
fn is_similar(own: &str, name: &str) -> bool {
    let plain = |text: &str| -> String {
        let letters = text.chars().filter(|letter| letter.is_alphanumeric());
        letters.flat_map(char::to_lowercase).collect()
    };
    let (own, name) = (plain(own), plain(name));
    let is_part = |part: &str, whole: &str| part.len() > 1 && whole.contains(part);
    own == name || is_part(&own, &name) || is_part(&name, &own)
}
