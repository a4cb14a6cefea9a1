//! Files that commands write: all of them whole, or none of them.
//!
//! They are written into a private folder beside their places, forced to the disk, and renamed when the last is there: whenever a
//! process ends, and whatever goes wrong, each file is the old one or the new one. Where one cannot be renamed, those before it are
//! put back. That they can be written is tried before the work. (The tiles of a store are written one by one: see [`store`](crate::store).)

use onset_umat::PrivateFolder;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use thiserror::Error;

/// How the names of the folders begin in which files wait for each other.
pub(crate) const STAGE: &str = ".onset-unfinished-";

/// A file that cannot be written, and why.
#[derive(Debug, Error)]
#[error("cannot write {}: {source}{}", path.display(), hint(source))]
pub struct OutputError {
    /// The file or the folder.
    pub path: PathBuf,
    /// What the operating system says.
    pub source: io::Error,
}

/// What can be done about it.
fn hint(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            "\n  hint: make room and run the command again, or choose another folder; the files that were there are as they were"
        }
        ErrorKind::PermissionDenied
        | ErrorKind::ReadOnlyFilesystem
        | ErrorKind::NotADirectory
        | ErrorKind::AlreadyExists
        | ErrorKind::IsADirectory
        | ErrorKind::InvalidFilename => "\n  hint: choose another place",
        _ => "",
    }
}

/// Files by name, in the order in which they are told.
pub type Files = Vec<(OsString, Vec<u8>)>;

/// A text as a file.
pub fn text(name: impl AsRef<OsStr>, text: impl Into<Vec<u8>>) -> (OsString, Vec<u8>) {
    (name.as_ref().to_owned(), text.into())
}

/// Folders that were made for files that are not there yet, the innermost first.
static MADE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn made_for_nothing() -> MutexGuard<'static, Vec<PathBuf>> {
    MADE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all folders that were made for files that are not there yet. For a process that is about to end where values are not
/// dropped, as on a signal; it can make none afterwards.
pub fn end_all() {
    let made = made_for_nothing();
    for folder in made.iter() {
        // It stays where it is not empty.
        let _ = fs::remove_dir(folder);
    }
    std::mem::forget(made);
}

/// A place for files that belong together.
#[derive(Debug)]
pub struct Output {
    folder: PathBuf,
    /// Folders that were made for it, the innermost first.
    made: Vec<PathBuf>,
}

impl Output {
    /// Makes a folder where it is missing, and tries whether files of some names can be written there.
    ///
    /// # Errors
    /// [`OutputError`] with what is in the way.
    pub fn at<S: AsRef<OsStr>>(folder: &Path, names: &[S]) -> Result<Self, OutputError> {
        let output = {
            let mut all = made_for_nothing();
            let made = missing(folder);
            let created = fs::create_dir_all(folder);
            all.extend(made.iter().cloned());
            let output = Self {
                folder: folder.to_owned(),
                made,
            };
            // What was made of it is removed, which asks for the list again.
            drop(all);
            created.map_err(failed(folder))?;
            output
        };
        let stage = output.stage()?;
        for name in names {
            output.prepare(&stage, name.as_ref(), b"")?;
        }
        Ok(output)
    }

    /// Writes files, replacing those that are there; returns their paths. A link in the place of one is replaced, not followed.
    ///
    /// # Errors
    /// [`OutputError`] with the first that cannot be written. The others are then as they were, as far as the file system knows hard
    /// links and does not fail again.
    pub fn write(mut self, files: &Files) -> Result<Vec<PathBuf>, OutputError> {
        let stage = self.stage()?;
        let mut prepared = Vec::with_capacity(files.len());
        for (name, bytes) in files {
            prepared.push(self.prepare(&stage, name, bytes)?);
        }
        let mut placed = Vec::with_capacity(prepared.len());
        for (from, to) in &prepared {
            let before = Before::of(to, &stage, placed.len());
            if let Err(error) = fs::rename(from, to) {
                placed.into_iter().rev().for_each(Before::put_back);
                return Err(failed(to)(error));
            }
            placed.push(before);
        }
        made_for_nothing().retain(|folder| !self.made.contains(folder));
        self.made.clear();
        // The names, too, shall outlive a loss of power. Systems that do not know how to are no reason to fail.
        let _ = File::open(&self.folder).and_then(|folder| folder.sync_all());
        Ok(prepared.into_iter().map(|(_, to)| to).collect())
    }

    fn stage(&self) -> Result<PrivateFolder, OutputError> {
        PrivateFolder::new(&self.folder, STAGE).map_err(failed(&self.folder))
    }

    /// Writes a file that waits for the others; where it is, and where it belongs.
    fn prepare(
        &self,
        stage: &PrivateFolder,
        name: &OsStr,
        bytes: &[u8],
    ) -> Result<(PathBuf, PathBuf), OutputError> {
        let (from, to) = (stage.path().join(name), self.folder.join(name));
        let in_the_way = match fs::symlink_metadata(&to) {
            Ok(found) if found.is_dir() => Err(ErrorKind::IsADirectory.into()),
            Ok(found) if found.is_file() && found.permissions().readonly() => Err(io::Error::new(
                ErrorKind::PermissionDenied,
                "it is protected against writing",
            )),
            Ok(found) => Ok(found.is_file().then(|| found.permissions())),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        };
        in_the_way
            .and_then(|permissions| {
                let mut file = File::create_new(&from)?;
                file.write_all(bytes)?;
                // Whoever could not read the old file shall not read the new one.
                permissions.map_or(Ok(()), |permissions| file.set_permissions(permissions))?;
                file.sync_all()
            })
            .map_err(failed(&to))?;
        Ok((from, to))
    }
}

/// What was at the place of a file before it came there.
enum Before<'a> {
    Nothing(&'a Path),
    /// A file, which has another name until all are renamed.
    Kept(&'a Path, PathBuf),
    /// A file that can have no other name: on some file systems none can.
    Gone,
}

impl<'a> Before<'a> {
    fn of(place: &'a Path, stage: &PrivateFolder, number: usize) -> Self {
        // No file has such a name: theirs have none that begins with a blank.
        let kept = stage.path().join(format!(" {number}"));
        match fs::hard_link(place, &kept) {
            Ok(()) => Self::Kept(place, kept),
            Err(error) if error.kind() == ErrorKind::NotFound => Self::Nothing(place),
            Err(_) => Self::Gone,
        }
    }

    /// Nothing more can be done where that fails too.
    fn put_back(self) {
        let _ = match self {
            Self::Nothing(place) => fs::remove_file(place),
            Self::Kept(place, kept) => fs::rename(kept, place),
            Self::Gone => Ok(()),
        };
    }
}

impl Drop for Output {
    /// Folders that were made for nothing are removed.
    fn drop(&mut self) {
        if self.made.is_empty() {
            return;
        }
        let mut all = made_for_nothing();
        for folder in &self.made {
            // It stays where it is not empty.
            let _ = fs::remove_dir(folder);
        }
        all.retain(|folder| !self.made.contains(folder));
    }
}

/// Writes files into a folder that is made where it is missing; returns their paths.
///
/// # Errors
/// As for [`Output::at`] and [`Output::write`].
pub fn write(folder: &Path, files: &Files) -> Result<Vec<PathBuf>, OutputError> {
    Output::at::<&str>(folder, &[])?.write(files)
}

/// The folders of a path that are not there, the innermost first.
fn missing(folder: &Path) -> Vec<PathBuf> {
    let all = folder
        .ancestors()
        .filter(|path| !path.as_os_str().is_empty());
    all.take_while(|path| fs::symlink_metadata(path).is_err())
        .map(Path::to_owned)
        .collect()
}

fn failed(path: &Path) -> impl Fn(io::Error) -> OutputError + use<> {
    let path = path.to_owned();
    move |source| OutputError {
        path: path.clone(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(words: &[(&str, &str)]) -> Files {
        words.iter().map(|(name, word)| text(name, *word)).collect()
    }

    fn names(folder: &Path) -> Vec<OsString> {
        let entries = fs::read_dir(folder).expect("a folder");
        let mut names: Vec<OsString> = entries
            .map(|entry| entry.expect("one").file_name())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn files_are_written_together_or_not_at_all() {
        let place = PrivateFolder::new(&std::env::temp_dir(), "onset-output-").expect("a folder");
        let folder = place.path().join("a/b");
        let paths = write(&folder, &files(&[("one", "1"), ("two", "2")])).expect("written");
        assert_eq!(paths, [folder.join("one"), folder.join("two")]);
        fs::create_dir(folder.join("three")).expect("a folder in the way");
        let refused = [
            files(&[("one", "new"), ("three", "3")]),
            files(&[("one", "new"), (&"n".repeat(300), "4")]),
        ];
        for files in refused {
            let last = files[1].0.clone();
            let error = Output::at(&folder, &[&last]).expect_err("told before the work");
            assert_eq!(error.path, folder.join(&last));
            assert!(error.to_string().contains("hint"), "{error}");
            assert!(write(&folder, &files).is_err());
            assert_eq!(fs::read_to_string(folder.join("one")).expect("kept"), "1");
            assert_eq!(names(&folder), ["one", "three", "two"]);
        }
    }

    #[test]
    fn a_folder_is_made_for_files_only() {
        let place = PrivateFolder::new(&std::env::temp_dir(), "onset-output-").expect("a folder");
        let folder = place.path().join("a/b");
        drop(Output::at(&folder, &["one"]).expect("a place"));
        assert_eq!(names(place.path()), [""; 0]);
    }

    #[test]
    #[cfg(unix)]
    fn what_is_protected_stays_so_and_links_are_not_followed() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let place = PrivateFolder::new(&std::env::temp_dir(), "onset-output-").expect("a folder");
        let at = |name: &str| place.path().join(name);
        for (name, mode) in [("private", 0o600), ("protected", 0o444), ("victim", 0o644)] {
            fs::write(at(name), "old").expect("a file");
            fs::set_permissions(at(name), fs::Permissions::from_mode(mode)).expect("permissions");
        }
        symlink(at("victim"), at("link")).expect("a link");
        write(place.path(), &files(&[("private", "new"), ("link", "new")])).expect("written");
        let mode = fs::metadata(at("private"))
            .expect("a file")
            .permissions()
            .mode();
        assert_eq!(mode & 0o777, 0o600);
        assert_eq!(fs::read_to_string(at("victim")).expect("a file"), "old");
        assert_eq!(fs::read_to_string(at("link")).expect("a file"), "new");
        let error = Output::at(place.path(), &["protected"]).expect_err("protected");
        assert!(error.to_string().contains("protected"), "{error}");
    }
}
