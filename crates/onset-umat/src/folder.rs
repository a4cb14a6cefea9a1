//! Folders of a process's own: private, removed at its end, swept by the next one where it had no chance to do so.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use tempfile::TempDir;

/// How often a place is tried where others make folders too.
const TRIES: usize = 8;

/// Folders, each with the process that made it.
static OWN: Mutex<Vec<(u32, PathBuf)>> = Mutex::new(Vec::new());

/// A folder with a name that nobody can guess, which its user alone can enter. It is removed with this value, or by
/// [`end_all`](crate::end_all); what a killed process has left is removed by the next that makes one at the same place.
///
/// ```
/// use onset_umat::PrivateFolder;
/// let folder = PrivateFolder::new(&std::env::temp_dir(), "onset-example-")?;
/// let path = folder.path().to_owned();
/// std::fs::write(path.join("notes"), "short-lived")?;
/// drop(folder);
/// assert!(!path.exists());
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Debug)]
pub struct PrivateFolder {
    folder: TempDir,
    /// The process that made it; a fork of that one must not remove it.
    maker: u32,
    /// Tells others, as long as this process lives, that the folder is in use. Where a file system knows no locks, nothing is swept.
    _lock: Option<File>,
}

impl PrivateFolder {
    /// Makes a folder in another, with a name that begins in a way that is used for nothing else.
    ///
    /// # Errors
    /// [`io::Error`] when it cannot be made.
    pub fn new(parent: &Path, prefix: &str) -> io::Result<Self> {
        sweep(parent, prefix);
        for _ in 0..TRIES {
            let folder = made(parent, prefix)?;
            let lock = File::open(folder.path()).ok();
            let is_taken = lock.as_ref().is_some_and(|lock| {
                matches!(lock.try_lock_shared(), Err(TryLockError::WouldBlock))
            });
            // Somebody who sweeps may have come between making and locking.
            if !is_taken && folder.path().is_dir() {
                let maker = std::process::id();
                own().push((maker, folder.path().to_owned()));
                return Ok(Self {
                    folder,
                    maker,
                    _lock: lock,
                });
            }
        }
        Err(io::Error::other("its folders are removed by somebody else"))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

impl Drop for PrivateFolder {
    fn drop(&mut self) {
        let path = self.folder.path();
        own().retain(|(_, other)| other != path);
        if self.maker != std::process::id() {
            self.folder.disable_cleanup(true);
        }
    }
}

fn own() -> std::sync::MutexGuard<'static, Vec<(u32, PathBuf)>> {
    OWN.lock().unwrap_or_else(PoisonError::into_inner)
}

fn made(parent: &Path, prefix: &str) -> io::Result<TempDir> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).rand_bytes(12);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o700));
    }
    builder.tempdir_in(parent)
}

/// Removes all folders that this process has. Afterwards it can make none: this is for its end.
pub(crate) fn remove_all() {
    let own = own();
    let maker = std::process::id();
    for (_, folder) in own.iter().filter(|(other, _)| *other == maker) {
        // Whatever is left there is worth nothing.
        drop(fs::remove_dir_all(folder));
    }
    std::mem::forget(own);
}

/// Removes the folders with a prefix that processes of the same user have left: those that nobody holds a lock on.
fn sweep(parent: &Path, prefix: &str) {
    let Ok(entries) = fs::read_dir(parent) else {
        return;
    };
    for entry in entries.flatten() {
        let name = entry.file_name();
        if name.as_encoded_bytes().starts_with(prefix.as_bytes()) && is_ours(&entry.path()) {
            let path = entry.path();
            let Ok(handle) = File::open(&path) else {
                continue;
            };
            if handle.try_lock().is_ok() {
                // What cannot be removed does no harm. Links in it, or in its place, are removed, not followed.
                drop(fs::remove_dir_all(&path));
            }
        }
    }
}

/// Whether a path is a folder, and no link to one, of the user whose process this is.
#[cfg(unix)]
fn is_ours(path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    fs::symlink_metadata(path)
        .is_ok_and(|found| found.is_dir() && found.uid() == rustix::process::geteuid().as_raw())
}

#[cfg(not(unix))]
fn is_ours(_: &Path) -> bool {
    false
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    #[test]
    fn a_folder_is_private_and_what_a_killed_process_left_is_swept_but_nothing_else() {
        let place = TempDir::new().expect("a folder");
        let at = |name: &str| place.path().join(name);
        fs::create_dir(at("x-left")).expect("a folder");
        fs::write(at("x-left").join("fort.7"), "left").expect("a file");
        fs::create_dir(at("other")).expect("a folder");
        fs::write(at("x-file"), "no folder").expect("a file");
        symlink(at("other"), at("x-link")).expect("a link");
        let first = PrivateFolder::new(place.path(), "x-").expect("a folder");
        let second = PrivateFolder::new(place.path(), "x-").expect("a folder");
        assert!(first.path().is_dir(), "in use");
        let mode = fs::metadata(second.path()).expect("a folder").permissions();
        assert_eq!(mode.mode() & 0o777, 0o700);
        assert!(!at("x-left").exists());
        for kept in ["other", "x-file", "x-link"] {
            assert!(at(kept).exists(), "{kept}");
        }
        let paths = [first.path().to_owned(), second.path().to_owned()];
        drop((first, second));
        assert!(paths.iter().all(|path| !path.exists()));
    }
}
