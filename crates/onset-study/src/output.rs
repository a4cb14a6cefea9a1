//! Output files of commands, which are written all together or not at all.
//!
//! The files are written into a private folder in the target folder, flushed to disk, and renamed once the last file is complete. If a process ends
//! or fails at any time, each file is either the old or the new one. If a file cannot be renamed, the previous files are restored. Whether files can
//! be written is tested before the computation. (The tiles of a store are written one by one: see [`store`](crate::store).)

use crate::figure::{Figure, FigureError, Sheet};
use crate::input;
use onset_umat::PrivateFolder;
use std::borrow::Cow;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use thiserror::Error;

/// Prefix of the private folders in which files are kept until all are complete.
pub(crate) const STAGE: &str = ".onset-unfinished-";

/// File that cannot be written, with the reason.
#[derive(Debug, Error)]
#[error("cannot write {}: {source}{}", path.display(), hint(source))]
pub struct OutputError {
    /// Path of the file or the folder.
    pub path: PathBuf,
    /// Error of the operating system.
    pub source: io::Error,
}

/// Hint for an error of the operating system.
fn hint(error: &io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            "\n  hint: make room and run the command again, or choose another folder; existing files are unchanged"
        }
        ErrorKind::PermissionDenied
        | ErrorKind::ReadOnlyFilesystem
        | ErrorKind::NotADirectory
        | ErrorKind::AlreadyExists
        | ErrorKind::IsADirectory
        | ErrorKind::InvalidFilename => "\n  hint: choose another folder",
        _ => "",
    }
}

/// Files by name, in the order in which they are listed.
pub type Files = Vec<(OsString, Content)>;

/// Content of a file.
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    /// The bytes of the file.
    Bytes(Vec<u8>),
    /// A figure, which is drawn when it is written, as one file for each format. The name has no extension.
    Figure(Box<Figure>),
}

/// Names and contents of the files of one [`Content`].
pub type Drawn<'a> = Vec<(OsString, Cow<'a, [u8]>)>;

impl Content {
    /// Returns the files of a content with a name: one file, or all files of a figure on a sheet.
    ///
    /// # Errors
    /// [`FigureError`] if the figure cannot be drawn.
    pub fn drawn(&self, name: &OsStr, sheet: &Sheet) -> Result<Drawn<'_>, FigureError> {
        match self {
            Self::Bytes(bytes) => Ok(vec![(name.to_owned(), bytes.into())]),
            Self::Figure(figure) => {
                let files = figure.files(name, sheet)?;
                Ok(files
                    .into_iter()
                    .map(|(name, bytes)| (name, bytes.into()))
                    .collect())
            }
        }
    }
}

/// Returns the entry of [`Files`] with a name and a text; writes nothing.
pub fn text(name: impl AsRef<OsStr>, text: impl Into<Vec<u8>>) -> (OsString, Content) {
    (name.as_ref().to_owned(), Content::Bytes(text.into()))
}

/// Returns the entry of [`Files`] with a figure and its name without extension; draws nothing.
pub fn picture(name: impl AsRef<OsStr>, figure: Figure) -> (OsString, Content) {
    (name.as_ref().to_owned(), Content::Figure(Box::new(figure)))
}

/// Folders that were created for files that are not written yet, the innermost first.
static MADE: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn made_for_nothing() -> MutexGuard<'static, Vec<PathBuf>> {
    MADE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all folders that were created for files that are not written yet. For a process that ends without dropping values, as on a signal; no
/// folder can be created afterwards.
pub fn end_all() {
    let made = made_for_nothing();
    for folder in made.iter() {
        // A folder that is not empty is kept.
        let _ = fs::remove_dir(folder);
    }
    std::mem::forget(made);
}

/// Target folder for files that belong together.
#[derive(Debug)]
pub struct Output {
    folder: PathBuf,
    sheet: Sheet,
    /// Base name of the figure, if only the figure is written.
    only: Option<OsString>,
    /// Folders that were created for the output, the innermost first.
    made: Vec<PathBuf>,
}

impl Output {
    /// Creates a folder if it is missing, and tests whether files with the given names can be written there.
    ///
    /// # Errors
    /// [`OutputError`] with the file or folder that prevents writing.
    pub fn at<S: AsRef<OsStr>>(folder: &Path, names: &[S]) -> Result<Self, OutputError> {
        let output = {
            let mut all = made_for_nothing();
            let made = missing(folder);
            let created = fs::create_dir_all(folder);
            all.extend(made.iter().cloned());
            let output = Self {
                folder: folder.to_owned(),
                sheet: Sheet::default(),
                only: None,
                made,
            };
            // On an error `output` is dropped and removes the new folders, which locks the list.
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

    /// Sets the sheet of the figures.
    pub fn on(mut self, sheet: Sheet) -> Self {
        self.sheet = sheet;
        self
    }

    /// Writes only the figure, under this base name.
    pub fn only(mut self, name: &OsStr) -> Self {
        self.only = Some(name.to_owned());
        self
    }

    /// Writes files, replacing existing ones; returns their paths. An existing link is replaced, not followed.
    ///
    /// # Errors
    /// [`OutputError`] as [`Batch::finish`].
    pub fn write(self, files: &Files) -> Result<Vec<PathBuf>, OutputError> {
        let mut batch = self.begin()?;
        batch.add_all(files)?;
        batch.finish()
    }

    /// Begins to write files one by one.
    ///
    /// # Errors
    /// [`OutputError`] if the folder cannot be written.
    pub fn begin(self) -> Result<Batch, OutputError> {
        let stage = self.stage()?;
        Ok(Batch {
            output: self,
            stage,
            prepared: Vec::new(),
        })
    }

    fn stage(&self) -> Result<PrivateFolder, OutputError> {
        PrivateFolder::new(&self.folder, STAGE).map_err(failed(&self.folder))
    }

    /// Writes a file into the private folder; returns its path there and the final path.
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
                // Users without access to the old file must not have access to the new file.
                permissions.map_or(Ok(()), |permissions| file.set_permissions(permissions))?;
                file.sync_all()
            })
            .map_err(failed(&to))?;
        Ok((from, to))
    }
}

/// Files that are written one by one and moved to their folder together at the end.
#[derive(Debug)]
pub struct Batch {
    output: Output,
    stage: PrivateFolder,
    /// Paths in the private folder, with the final paths.
    prepared: Vec<(PathBuf, PathBuf)>,
}

impl Batch {
    /// Writes a file into the private folder.
    ///
    /// # Errors
    /// [`OutputError`] if it cannot be written.
    pub fn add(&mut self, name: impl AsRef<OsStr>, bytes: &[u8]) -> Result<(), OutputError> {
        if self.output.only.is_none() {
            let both = self.output.prepare(&self.stage, name.as_ref(), bytes)?;
            self.prepared.push(both);
        }
        Ok(())
    }

    /// Draws the figures and writes all files into the private folder.
    ///
    /// # Errors
    /// [`OutputError`] if a figure cannot be drawn or a file not be written.
    pub fn add_all(&mut self, files: &Files) -> Result<(), OutputError> {
        for (name, content) in files {
            let name = match (&self.output.only, content) {
                (None, _) => name,
                (Some(only), Content::Figure(_)) => only,
                (Some(_), Content::Bytes(_)) => continue,
            };
            let drawn = content.drawn(name, &self.output.sheet);
            let place = self.output.folder.join(name);
            for (name, bytes) in drawn.map_err(|error| failed(&place)(io::Error::other(error)))? {
                let both = self.output.prepare(&self.stage, &name, &bytes)?;
                self.prepared.push(both);
            }
        }
        Ok(())
    }

    /// Removes a file that was added.
    pub(crate) fn remove(&mut self, name: &str) {
        let path = self.stage.path().join(name);
        self.prepared.retain(|(from, _)| *from != path);
        // The private folder is removed with its contents at the end.
        let _ = fs::remove_file(path);
    }

    /// Text of a file of an earlier run in the target folder; `None` if it cannot be read.
    pub(crate) fn earlier(&self, name: &str) -> Option<String> {
        let path = self.output.folder.join(name);
        let bytes = input::bytes(&path, input::MOST_OUTPUT).ok()?;
        String::from_utf8(bytes).ok()
    }

    /// Moves all files to their folder like [`Self::finish`], and then removes files of an earlier run that have not been replaced. If only a figure is
    /// written, nothing is removed.
    ///
    /// # Errors
    /// [`OutputError`] as [`Self::finish`].
    pub(crate) fn finish_without(self, old: &[String]) -> Result<Vec<PathBuf>, OutputError> {
        let folder = self.output.folder.clone();
        let is_whole = self.output.only.is_none();
        let paths = self.finish()?;
        let old = old
            .iter()
            .filter(|_| is_whole)
            .map(|name| folder.join(name));
        for path in old.filter(|path| !paths.contains(path)) {
            // The results are complete. An old file that cannot be removed is not listed in the new collection.
            let _ = fs::remove_file(path);
        }
        Ok(paths)
    }

    /// Moves all files to their folder, replacing existing ones; returns their paths. An existing link is replaced, not followed.
    ///
    /// # Errors
    /// [`OutputError`] with the first file that cannot be written. The other files are then restored, provided that the file system supports hard
    /// links and does not fail again.
    pub fn finish(mut self) -> Result<Vec<PathBuf>, OutputError> {
        let mut placed = Vec::with_capacity(self.prepared.len());
        for (from, to) in &self.prepared {
            let before = Before::of(to, &self.stage, placed.len());
            if let Err(error) = fs::rename(from, to) {
                placed.into_iter().rev().for_each(Before::put_back);
                return Err(failed(to)(error));
            }
            placed.push(before);
        }
        let made = std::mem::take(&mut self.output.made);
        made_for_nothing().retain(|folder| !made.contains(folder));
        // The directory entries should survive a loss of power too. Systems without this function are not a reason to fail.
        let _ = File::open(&self.output.folder).and_then(|folder| folder.sync_all());
        Ok(self.prepared.iter().map(|(_, to)| to.clone()).collect())
    }
}

/// Previous content at the path of a file.
enum Before<'a> {
    Nothing(&'a Path),
    /// Existing file, kept under another name until all files are renamed.
    Kept(&'a Path, PathBuf),
    /// Existing file that could not be kept under a second name, because the file system has no hard links.
    Gone,
}

impl<'a> Before<'a> {
    fn of(place: &'a Path, stage: &PrivateFolder, number: usize) -> Self {
        // The name cannot collide with a staged file, because their names do not begin with a blank.
        let kept = stage.path().join(format!(" {number}"));
        match fs::hard_link(place, &kept) {
            Ok(()) => Self::Kept(place, kept),
            Err(error) if error.kind() == ErrorKind::NotFound => Self::Nothing(place),
            Err(_) => Self::Gone,
        }
    }

    /// Restores the previous content. If this fails as well, nothing more can be done.
    fn put_back(self) {
        let _ = match self {
            Self::Nothing(place) => fs::remove_file(place),
            Self::Kept(place, kept) => fs::rename(kept, place),
            Self::Gone => Ok(()),
        };
    }
}

impl Drop for Output {
    /// Removes folders that were created but not used.
    fn drop(&mut self) {
        if self.made.is_empty() {
            return;
        }
        let mut all = made_for_nothing();
        for folder in &self.made {
            // A folder that is not empty is kept.
            let _ = fs::remove_dir(folder);
        }
        all.retain(|folder| !self.made.contains(folder));
    }
}

/// Folders of a path that do not exist, the innermost first.
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

    fn write(folder: &Path, files: &Files) -> Result<Vec<PathBuf>, OutputError> {
        Output::at::<&str>(folder, &[])?.write(files)
    }

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
    fn a_folder_is_created_only_if_files_are_written() {
        let place = PrivateFolder::new(&std::env::temp_dir(), "onset-output-").expect("a folder");
        let folder = place.path().join("a/b");
        drop(Output::at(&folder, &["one"]).expect("a place"));
        assert_eq!(names(place.path()), [""; 0]);
    }

    #[test]
    #[cfg(unix)]
    fn permissions_are_kept_and_links_are_not_followed() {
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
