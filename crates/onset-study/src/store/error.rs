//! Errors of a store, with their remedies.

use crate::shell::quoted_file;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Reason why results cannot be written or read.
#[derive(Debug, Error)]
pub enum StoreError {
    /// Path that exists and is not a store.
    #[error(
        "{} exists and is not a store of results\n  hint: choose another folder with --out; only stores of onset are ever replaced",
        path.display()
    )]
    NotAStore {
        /// Path of the store.
        path: PathBuf,
    },
    /// Path that does not exist.
    #[error("there is no store at {}\n  hint: `onset map FILE --out {}` creates a store", path.display(), quoted_file(path))]
    Missing {
        /// Path of the store.
        path: PathBuf,
    },
    /// Zarr store that was not written by onset.
    #[error(
        "{} is a Zarr store that onset did not write\n  hint: choose another folder with --out; only stores of onset are ever replaced",
        path.display()
    )]
    Foreign {
        /// Path of the store.
        path: PathBuf,
    },
    /// Existing store, without a choice to resume or overwrite it.
    #[error(
        "{} exists, with {done} of {tiles} tiles complete\n  hint: {}",
        path.display(),
        if done == tiles { "it is complete; --overwrite starts afresh" }
        else { "--resume continues it, --overwrite starts afresh" }
    )]
    Exists {
        /// Path of the store.
        path: PathBuf,
        /// Number of finished tiles.
        done: usize,
        /// Number of all tiles.
        tiles: usize,
    },
    /// Store of another study.
    #[error(
        "{} contains another study: {difference}\n  hint: choose another folder with --out, or replace the store with --overwrite",
        path.display()
    )]
    OtherStudy {
        /// Path of the store.
        path: PathBuf,
        /// First difference between the studies.
        difference: String,
    },
    /// Store to be replaced while another process writes to it.
    #[error("{} is being written by another process\n  hint: wait until it ends, or interrupt it and continue with --resume; --overwrite starts afresh", path.display())]
    Occupied {
        /// Path of the store.
        path: PathBuf,
    },
    /// Store locked exclusively by another process.
    #[error(
        "{} is in use by another process, which holds a lock on its zarr.json\n  hint: wait until it ends; `lsof {}` shows the process",
        path.display(),
        quoted_file(&path.join("zarr.json"))
    )]
    Locked {
        /// Path of the store.
        path: PathBuf,
    },
    /// Store of another format version.
    #[error(
        "{} is a store of format {found}; this version of onset reads format {expected}\n  hint: use the version that wrote it, or \
         start afresh with --overwrite",
        path.display()
    )]
    Format {
        /// Path of the store.
        path: PathBuf,
        /// Version of the store.
        found: String,
        /// Version that this program reads.
        expected: u32,
    },
    /// Foreign file in a store to be replaced.
    #[error(
        "{} is in the store and was not written by onset\n  hint: move it elsewhere; then --overwrite replaces the store",
        path.display()
    )]
    NotOurs {
        /// Path of the foreign file.
        path: PathBuf,
    },
    /// Link in place of a store to be replaced.
    #[error(
        "{} is a link; links are not replaced\n  hint: name the store itself with --out {}",
        path.display(),
        quoted_file(target)
    )]
    Link {
        /// Path of the link.
        path: PathBuf,
        /// Target of the link.
        target: PathBuf,
    },
    /// Path that cannot be replaced by renaming a folder.
    #[error(
        "{} is the current folder, which a store cannot replace\n  hint: choose a folder for the store with --out, for \
         example --out map.zarr",
        path.display()
    )]
    CurrentFolder {
        /// Path of the store.
        path: PathBuf,
    },
    /// File with invalid content.
    #[error("{} is damaged: {reason}\n  hint: {}", path.display(), damage_hint(path))]
    Damaged {
        /// Path of the file.
        path: PathBuf,
        /// Reason why the content is invalid.
        reason: String,
    },
    /// Field that the store does not have.
    #[error("{} has no field `{field}`\n  hint: its fields are {}", path.display(), known.join(", "))]
    NoField {
        /// Path of the store.
        path: PathBuf,
        /// Name of the requested field.
        field: String,
        /// Names of the existing fields.
        known: Vec<String>,
    },
    /// File that cannot be read or written.
    #[error("cannot {action} {}: {source}{}", path.display(), hint(source))]
    Machine {
        /// Failed action, `read` or `write`.
        action: &'static str,
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
}

impl StoreError {
    pub(super) fn reading(path: &Path) -> impl Fn(io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| match source.kind() {
            // The file differs from the written one.
            ErrorKind::InvalidData => Self::Damaged {
                path: path.clone(),
                reason: source.to_string(),
            },
            _ => Self::Machine {
                action: "read",
                path: path.clone(),
                source,
            },
        }
    }

    pub(super) fn writing(path: &Path) -> impl Fn(io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| Self::Machine {
            action: "write",
            path: path.clone(),
            source,
        }
    }

    /// Returns true for an error in the request, false for damaged files and failures of the machine.
    pub fn is_input(&self) -> bool {
        !matches!(self, Self::Machine { .. } | Self::Damaged { .. })
    }
}

fn hint(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            "\n  hint: make room, then resume with --resume; completed tiles are kept"
        }
        ErrorKind::PermissionDenied
        | ErrorKind::ReadOnlyFilesystem
        | ErrorKind::NotADirectory
        | ErrorKind::AlreadyExists
        | ErrorKind::NotFound => "\n  hint: choose a folder that can be written with --out",
        _ => "",
    }
}

/// Remedy for a damaged file.
///
/// A chunk of results can be computed again. Metadata and coordinates are written only when the store is created; only chunks of coordinates have a
/// single dimension (`c/0`).
fn damage_hint(path: &Path) -> &'static str {
    let is_coordinate = path.parent().is_some_and(|folder| folder.ends_with("c"));
    if path.ends_with("zarr.json") || is_coordinate {
        "restore it from a copy, or start again in another folder with --out"
    } else {
        "to compute the tile again, remove the file of the same number in `verdict`, then use --resume"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_disk_is_reported_with_a_hint() {
        for kind in [
            ErrorKind::StorageFull,
            ErrorKind::QuotaExceeded,
            ErrorKind::FileTooLarge,
        ] {
            let error = StoreError::writing(Path::new("map.zarr/verdict/c/0/0"))(kind.into());
            let message = error.to_string();
            assert!(
                message.starts_with("cannot write map.zarr/verdict/c/0/0: "),
                "{message}"
            );
            assert!(
                message.contains("make room") && message.contains("--resume"),
                "{message}"
            );
            assert!(!error.is_input());
        }
    }
}
