//! Temporary folders of a process: private, removed when it ends, or later by another process if it was killed.

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use tempfile::TempDir;

/// Number of attempts if other processes create folders at the same place.
const MAX_ATTEMPTS: usize = 8;

/// Existing folders, each with the process that created it.
static OWN: Mutex<Vec<(u32, PathBuf)>> = Mutex::new(Vec::new());

/// Temporary folder with an unguessable name, accessible to its user only.
///
/// The folder is removed when this value is dropped, or by [`end_all`](crate::end_all). Folders left by killed processes are removed by the next
/// process that creates one at the same place.
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
    /// Process that created the folder; a forked process must not remove it.
    maker: u32,
    /// Lock that marks the folder as used while this process lives. On a file system without locks, leftover folders remain.
    _lock: Option<File>,
}

impl PrivateFolder {
    /// Creates a folder in `parent`; no other files there may start with `prefix`.
    ///
    /// # Errors
    /// [`io::Error`] if it cannot be created.
    pub fn new(parent: &Path, prefix: &str) -> io::Result<Self> {
        sweep(parent, prefix);
        for _ in 0..MAX_ATTEMPTS {
            // The lock is held meanwhile, so that `remove_all` misses no folder.
            let mut own = own();
            let folder = made(parent, prefix)?;
            let lock = File::open(folder.path()).ok();
            let is_taken = lock.as_ref().is_some_and(|lock| {
                matches!(lock.try_lock_shared(), Err(TryLockError::WouldBlock))
            });
            // Another process may have removed the folder before it was locked.
            if !is_taken && folder.path().is_dir() {
                let maker = std::process::id();
                own.push((maker, folder.path().to_owned()));
                return Ok(Self {
                    folder,
                    maker,
                    _lock: lock,
                });
            }
        }
        Err(io::Error::other("another process removes its folders"))
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

impl Drop for PrivateFolder {
    fn drop(&mut self) {
        let path = self.folder.path();
        // The lock is held meanwhile, so that the process does not end in between.
        let mut own = own();
        if self.maker == std::process::id() {
            drop(fs::remove_dir_all(path));
        }
        own.retain(|(_, other)| other != path);
        drop(own);
        self.folder.disable_cleanup(true);
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

/// Removes all folders of this process, which cannot create any afterwards; for the end of the process.
pub(crate) fn remove_all() {
    let own = own();
    let maker = std::process::id();
    for (_, folder) in own.iter().filter(|(other, _)| *other == maker) {
        // Another thread may still write into it. A failure is ignored: the content has no further use.
        let is_removed = || fs::remove_dir_all(folder).is_ok() || !folder.exists();
        let _ = (0..MAX_ATTEMPTS).any(|_| is_removed());
    }
    std::mem::forget(own);
}

/// Removes unlocked folders with the prefix that processes of the same user have left.
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
                // A failure is ignored. Links are removed and not followed.
                drop(fs::remove_dir_all(&path));
            }
        }
    }
}

/// Returns true if the path is a folder, not a link, of the user of this process.
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
    fn a_folder_is_private_and_only_leftovers_of_killed_processes_are_removed() {
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
