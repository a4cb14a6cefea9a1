//! What can be wrong with a store, and what to do about it.

use crate::shell::quoted_file;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why results cannot be written or read.
#[derive(Debug, Error)]
pub enum StoreError {
    /// Something else is at the place.
    #[error(
        "{} exists and is not a store of results\n  hint: choose another folder with --out; only stores of onset are ever replaced",
        path.display()
    )]
    NotAStore {
        /// The place.
        path: PathBuf,
    },
    /// Nothing is at the place.
    #[error("there is no store at {}\n  hint: `onset map FILE --out {}` makes one", path.display(), quoted_file(path))]
    Missing {
        /// The place.
        path: PathBuf,
    },
    /// A Zarr store that others have written.
    #[error(
        "{} is a Zarr store that onset did not write\n  hint: choose another folder with --out; only stores of onset are ever replaced",
        path.display()
    )]
    Foreign {
        /// The place.
        path: PathBuf,
    },
    /// A store is there, and nothing was said about what to do with it.
    #[error(
        "{} exists, with {done} of {tiles} tiles done\n  hint: {}",
        path.display(),
        if done == tiles { "it is complete; --overwrite computes it anew" }
        else { "--resume resumes it, --overwrite starts afresh" }
    )]
    Exists {
        /// The place.
        path: PathBuf,
        /// Tiles that are done.
        done: usize,
        /// All tiles.
        tiles: usize,
    },
    /// The store holds something else.
    #[error(
        "{} holds another study: {difference}\n  hint: choose another folder with --out, or replace the store with --overwrite",
        path.display()
    )]
    OtherStudy {
        /// The place.
        path: PathBuf,
        /// The first thing that differs.
        difference: String,
    },
    /// Another process writes to the store that is to be replaced.
    #[error("{} is being written by another process\n  hint: let it end, or interrupt it; then --overwrite", path.display())]
    Occupied {
        /// The place.
        path: PathBuf,
    },
    /// Another process keeps the store to itself.
    #[error(
        "{} is kept by another process, which holds a lock on its zarr.json\n  hint: let it end; `lsof {}` tells which it is",
        path.display(),
        quoted_file(&path.join("zarr.json"))
    )]
    Locked {
        /// The place.
        path: PathBuf,
    },
    /// A store of another version.
    #[error(
        "{} is a store of format {found}; this version of onset reads format {expected}\n  hint: use the version that wrote it, or \
         compute it anew with --overwrite",
        path.display()
    )]
    Format {
        /// The place.
        path: PathBuf,
        /// What it says.
        found: String,
        /// What is read.
        expected: u32,
    },
    /// Something in a store that is to be replaced is not ours.
    #[error(
        "{} is in the store and was not written by onset\n  hint: move it elsewhere; then --overwrite replaces the store",
        path.display()
    )]
    NotOurs {
        /// The file.
        path: PathBuf,
    },
    /// A store that is to be replaced is elsewhere.
    #[error(
        "{} is a link, and no link is replaced\n  hint: name the store itself with --out {}",
        path.display(),
        quoted_file(target)
    )]
    Link {
        /// The link.
        path: PathBuf,
        /// Where it leads.
        target: PathBuf,
    },
    /// A place that cannot become a folder by renaming.
    #[error(
        "{} is the current folder, which a store cannot take the place of\n  hint: choose a folder for the store with --out, for \
         example --out map.zarr",
        path.display()
    )]
    CurrentFolder {
        /// The place.
        path: PathBuf,
    },
    /// A file does not hold what it should.
    #[error("{} is damaged: {reason}\n  hint: {}", path.display(), damage_hint(path))]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A field that the store does not have.
    #[error("{} has no field `{field}`\n  hint: its fields are {}", path.display(), known.join(", "))]
    NoField {
        /// The place.
        path: PathBuf,
        /// The field.
        field: String,
        /// The fields that it has.
        known: Vec<String>,
    },
    /// A file cannot be read or written.
    #[error("cannot {action} {}: {source}{}", path.display(), hint(source))]
    Machine {
        /// To read or to write.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
}

impl StoreError {
    pub(super) fn reading(path: &Path) -> impl Fn(io::Error) -> Self + use<> {
        let path = path.to_owned();
        move |source| match source.kind() {
            // What is there is not what was written there.
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

    /// Whether what was asked for is wrong, and not the machine.
    pub fn is_input(&self) -> bool {
        !matches!(self, Self::Machine { .. } | Self::Damaged { .. })
    }
}

fn hint(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            "\n  hint: make room, then resume with --resume; the tiles that are done are safe"
        }
        ErrorKind::PermissionDenied
        | ErrorKind::ReadOnlyFilesystem
        | ErrorKind::NotADirectory
        | ErrorKind::AlreadyExists
        | ErrorKind::NotFound => "\n  hint: choose a folder that can be written with --out",
        _ => "",
    }
}

/// A chunk of results can be computed again; metadata and coordinates (which alone have one dimension: `c/0`) are written
/// with the store.
fn damage_hint(path: &Path) -> &'static str {
    let is_coordinate = path.parent().is_some_and(|folder| folder.ends_with("c"));
    if path.ends_with("zarr.json") || is_coordinate {
        "restore it from a copy, or begin anew in another folder with --out"
    } else {
        "to have the tile computed again, remove the file of the same number in `verdict`, then --resume"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_disk_is_told_with_what_to_do() {
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
