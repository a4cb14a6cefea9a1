//! Removal of a store, limited to the files that onset has written.

use super::folder::PARTIAL;
use super::zarr::METADATA;
use serde_json::Value;
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Entry of a store.
enum Place {
    File,
    Folder(Vec<(PathBuf, Place)>),
}

/// Folders and files of a store that its metadata describe.
pub(super) struct Contents(Vec<(PathBuf, Place)>);

impl Contents {
    /// Lists everything in a store with the given metadata. The inner error is the first foreign file.
    pub(super) fn of(store: &Path, group: &Value) -> io::Result<Result<Self, PathBuf>> {
        let arrays = group.pointer("/consolidated_metadata/metadata");
        let arrays = arrays.and_then(Value::as_object);
        let depth = |name: &OsStr| {
            let array = arrays?.get(name.to_str()?)?;
            Some(array["shape"].as_array()?.len())
        };
        let root = |name: &OsStr| match name.to_str() {
            Some(METADATA) => Some(Rule::File),
            Some(PARTIAL) => Some(Rule::Partial),
            _ => depth(name).map(Rule::Array),
        };
        Ok(look(store, &root)?.map(Self))
    }

    /// Removes the listed entries, without links and newer files.
    pub(super) fn remove(self, store: &Path) -> io::Result<()> {
        remove(store, self.0)
    }
}

/// Rule for the permitted entries of a folder.
#[derive(Clone, Copy)]
enum Rule {
    File,
    /// Unfinished files of the folder `.partial`.
    Partial,
    /// Array with the given number of dimensions.
    Array(usize),
    /// Folders nested to the given depth, with the chunks at the deepest level.
    Chunks(usize),
}

impl Rule {
    /// Rule for an entry of a folder under this rule.
    fn of_entry(self, name: &OsStr) -> Option<Self> {
        let name = name.to_str()?;
        let is_number = !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_digit());
        match self {
            Self::File => None,
            Self::Partial => Some(Self::File),
            Self::Array(_) if name == METADATA => Some(Self::File),
            Self::Array(dimensions) if name == "c" => Some(Self::Chunks(dimensions)),
            Self::Chunks(1) if is_number => Some(Self::File),
            Self::Chunks(depth) if is_number && depth > 1 => Some(Self::Chunks(depth - 1)),
            Self::Array(_) | Self::Chunks(_) => None,
        }
    }
}

type Entries = Vec<(PathBuf, Place)>;

fn look(
    folder: &Path,
    rule: &dyn Fn(&OsStr) -> Option<Rule>,
) -> io::Result<Result<Entries, PathBuf>> {
    let mut entries = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let (path, kind) = (entry.path(), entry.file_type()?);
        let place = match rule(&entry.file_name()) {
            Some(Rule::File) if kind.is_file() => Place::File,
            Some(inner @ (Rule::Partial | Rule::Array(_) | Rule::Chunks(_))) if kind.is_dir() => {
                match look(&path, &|name| inner.of_entry(name))? {
                    Ok(entries) => Place::Folder(entries),
                    Err(stranger) => return Ok(Err(stranger)),
                }
            }
            _ => return Ok(Err(path)),
        };
        entries.push((PathBuf::from(entry.file_name()), place));
    }
    Ok(Ok(entries))
}

fn remove(folder: &Path, entries: Entries) -> io::Result<()> {
    for (name, place) in entries {
        let path = folder.join(name);
        match place {
            Place::File => fs::remove_file(&path)?,
            Place::Folder(entries) => remove(&path, entries)?,
        }
    }
    fs::remove_dir(folder)
}
