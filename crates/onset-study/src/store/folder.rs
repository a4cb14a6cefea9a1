//! Files of a store, each written completely or not at all.
//!
//! A file is written under a unique name in the folder `.partial` and then renamed. Readers therefore find only complete files, even if processes are
//! killed or write simultaneously. The same folder contains the locks of tiles in progress. Writes are not synchronized to the disk: after a power
//! failure a chunk may be truncated, which its checksum detects.

use super::occupancy::Taken;
use std::fs::{self, File};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// Name of the folder for files in progress, and for locks.
pub(super) const PARTIAL: &str = ".partial";

/// Folder with the files of a store.
#[derive(Debug)]
pub(super) struct Folder {
    root: PathBuf,
}

/// Name that is unique across processes, machines and calls.
pub(super) fn unique() -> String {
    static COUNT: AtomicU64 = AtomicU64::new(0);
    static RANDOM: LazyLock<u64> = LazyLock::new(|| RandomState::new().build_hasher().finish());
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    format!("{}-{:016x}-{count}", std::process::id(), *RANDOM)
}

impl Folder {
    pub(super) fn new(root: &Path) -> Self {
        Self {
            root: root.to_owned(),
        }
    }

    /// Path of a file.
    pub(super) fn path(&self, key: &str) -> PathBuf {
        self.root.join(key)
    }

    /// Reads a complete file of at most `most` bytes, or returns `None` if it does not exist.
    pub(super) fn read(&self, key: &str, most: u64) -> io::Result<Option<Vec<u8>>> {
        read(&self.path(key), most)
    }

    /// Writes a file, replacing an existing one.
    pub(super) fn write(&self, key: &str, bytes: &[u8]) -> io::Result<()> {
        let partial = self.path(PARTIAL).join(unique());
        let written = within_parent(&partial, || {
            self.check_inside(&partial)?;
            fill(&partial, bytes)
        })
        .and_then(|()| {
            let path = self.path(key);
            within_parent(&path, || {
                self.check_inside(&path)?;
                fs::rename(&partial, &path)
            })
        });
        if written.is_err() {
            // A failure is ignored: the next process with exclusive access clears the file.
            let _ = fs::remove_file(&partial);
        }
        written
    }

    /// Acquires the lock on a file until it is dropped; `None` if another process holds it.
    pub(super) fn take(&self, key: &str) -> io::Result<Option<Taken>> {
        let lock = self.path(key);
        within_parent(&lock, || {
            self.check_inside(&lock)?;
            Taken::by(&lock)
        })
    }

    /// Checks that no link in the existing part of a path leads out of the folder.
    fn check_inside(&self, path: &Path) -> io::Result<()> {
        let root = match fs::canonicalize(&self.root) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
            root => root?,
        };
        for folder in path.ancestors().skip(1) {
            let Ok(within) = folder.strip_prefix(&self.root) else {
                break;
            };
            match fs::canonicalize(folder) {
                Ok(real) if real == root.join(within) => return Ok(()),
                Ok(_) => return Err(io::Error::other("a link leads out of the store")),
                // This part of the path does not exist yet.
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Removes files that killed processes have left. Requires exclusive access to the store.
    pub(super) fn clear(&self) {
        // A failure is ignored: leftover files do no harm.
        let _ = fs::remove_dir_all(self.path(PARTIAL));
    }

    /// Removes the folder of files in progress if it is empty; it is created again on demand.
    pub(super) fn clear_if_empty(&self) {
        let _ = fs::remove_dir(self.path(PARTIAL));
    }
}

/// Applies an action to a path, creating the parent folder if it is missing.
fn within_parent<T>(path: &Path, action: impl Fn() -> io::Result<T>) -> io::Result<T> {
    match action() {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            path.parent().map_or(Ok(()), fs::create_dir_all)?;
            action()
        }
        done => done,
    }
}

fn fill(path: &Path, bytes: &[u8]) -> io::Result<()> {
    File::create_new(path)?.write_all(bytes)
}

/// Reads a complete file of at most `most` bytes, or returns `None` if it does not exist. Pipes and other special files are not opened.
pub(super) fn read(path: &Path, most: u64) -> io::Result<Option<Vec<u8>>> {
    let too_long = || io::Error::new(ErrorKind::InvalidData, "it is longer than possible");
    match fs::metadata(path) {
        Ok(found) if !found.is_file() => {
            return Err(io::Error::new(ErrorKind::InvalidData, "it is not a file"));
        }
        Ok(found) if found.len() > most => return Err(too_long()),
        Ok(_) => {}
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error),
    }
    let mut bytes = Vec::new();
    File::open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        return Err(too_long());
    }
    Ok(Some(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_written_next_to_unfinished_files_without_leftovers() {
        let root = std::env::temp_dir().join(format!("onset-folder-{}", unique()));
        let folder = Folder::new(&root);
        let leftover = root.join(PARTIAL).join("killed");
        fs::create_dir_all(root.join(PARTIAL)).expect("a folder");
        fs::write(&leftover, "half").expect("a file");
        folder.write("a/c/0/0", b"one").expect("written");
        folder.write("a/c/0/0", b"two").expect("replaced");
        assert_eq!(
            folder.read("a/c/0/0", 3).expect("read"),
            Some(b"two".to_vec())
        );
        let partial = || fs::read_dir(root.join(PARTIAL)).map(Iterator::count).ok();
        assert_eq!(partial(), Some(1), "only what another has left");
        folder.clear();
        assert_eq!(partial(), None);
        fs::remove_dir_all(root).expect("removable");
    }

    #[test]
    #[cfg(unix)]
    fn links_out_of_the_folder_are_not_followed_and_only_regular_files_are_read() {
        use std::os::unix::fs::symlink;
        let root = std::env::temp_dir().join(format!("onset-folder-{}", unique()));
        let outside = std::env::temp_dir().join(format!("onset-outside-{}", unique()));
        fs::create_dir_all(root.join("a")).expect("a folder");
        fs::create_dir_all(outside.join("0")).expect("a folder");
        symlink(&outside, root.join("a/c")).expect("a link");
        let folder = Folder::new(&root);
        assert!(folder.write("a/c/0/0", b"one").is_err());
        assert!(folder.write("a/c/new", b"one").is_err());
        assert!(folder.write("a/c/1/new", b"one").is_err());
        assert_eq!(fs::read_dir(&outside).expect("a folder").count(), 1);
        assert_eq!(
            fs::read_dir(outside.join("0")).expect("a folder").count(),
            0
        );
        folder.write("a/d/0", b"one").expect("written");
        assert!(folder.read("a/d/0", 2).is_err(), "too long");
        assert!(folder.read("a/d", 100).is_err(), "a folder");
        symlink("/dev/zero", root.join("a/zero")).expect("a link");
        assert!(folder.read("a/zero", 100).is_err(), "a device");
        symlink(outside.join("new"), root.join("a/lock")).expect("a link");
        assert!(folder.take("a/lock").is_err(), "a link to nowhere");
        assert!(folder.take("a/c").is_err(), "a folder");
        assert!(folder.take("a/c/lock").is_err(), "outside");
        assert_eq!(fs::read_dir(&outside).expect("a folder").count(), 1);
        assert!(folder.take("a/d/lock").expect("a lock").is_some());
        for folder in [root, outside] {
            fs::remove_dir_all(folder).expect("removable");
        }
    }

    #[test]
    fn a_failed_write_leaves_the_previous_file_and_no_leftovers() {
        let root = std::env::temp_dir().join(format!("onset-folder-{}", unique()));
        let folder = Folder::new(&root);
        folder.write("a", b"one").expect("written");
        assert!(folder.write("a/b", b"two").is_err(), "a file is in the way");
        assert_eq!(folder.read("a", 3).expect("read"), Some(b"one".to_vec()));
        assert_eq!(
            fs::read_dir(root.join(PARTIAL)).map(Iterator::count).ok(),
            Some(0)
        );
        fs::remove_dir_all(root).expect("removable");
    }
}
