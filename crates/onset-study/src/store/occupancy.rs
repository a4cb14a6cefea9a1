//! Who writes to a store: several who share it, or one who has it for itself; and who of the several computes which tile.
//!
//! Locks, on the store's `zarr.json` and on a file for each tile that is being computed. They end with the process however that ends.

use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How long a store may be had by one for itself.
const PATIENCE: Duration = Duration::from_secs(3);

/// A lock on a store, until dropped.
#[derive(Debug)]
pub(super) struct Occupancy {
    _file: File,
}

/// What comes of the wish to have a store for oneself.
#[derive(Debug)]
pub(super) enum Claim {
    /// Nobody else writes to it, until the lock is dropped.
    Alone(#[allow(dead_code, reason = "held, not read")] Occupancy),
    /// Others write to it.
    Shared,
    /// The file system knows no locks.
    Unknown,
}

impl Occupancy {
    /// Shares the store with others. Who of ours has it for itself clears or replaces it, in a moment, which is waited for; `None`
    /// where somebody keeps it longer. Where the file system knows no locks, the store is shared all the same.
    pub(super) fn shared(metadata: &Path) -> io::Result<Option<Self>> {
        let file = File::open(metadata)?;
        let begin = Instant::now();
        while let Err(TryLockError::WouldBlock) = file.try_lock_shared() {
            if begin.elapsed() > PATIENCE {
                return Ok(None);
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        Ok(Some(Self { _file: file }))
    }

    /// Tries to have the store for itself.
    pub(super) fn alone(metadata: &Path) -> io::Result<Claim> {
        let file = File::open(metadata)?;
        Ok(match file.try_lock() {
            Ok(()) => Claim::Alone(Self { _file: file }),
            Err(TryLockError::WouldBlock) => Claim::Shared,
            Err(TryLockError::Error(_)) => Claim::Unknown,
        })
    }
}

/// A tile that is being computed here and, where the file system knows locks, nowhere else, until dropped.
#[derive(Debug)]
pub struct Taken {
    lock: PathBuf,
    _file: File,
}

impl Taken {
    /// Tries to take a tile by the lock on a file, which is made; `None` where somebody else has it. What is no file, such as a link or a pipe, is not opened.
    pub(super) fn by(lock: &Path) -> io::Result<Option<Self>> {
        match fs::symlink_metadata(lock) {
            Ok(found) if !found.is_file() => return Err(io::Error::other("it is no file")),
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let file = File::options()
            .write(true)
            .create(true)
            .truncate(false)
            .open(lock)?;
        if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
            return Ok(None);
        }
        Ok(Some(Self {
            lock: lock.to_owned(),
            _file: file,
        }))
    }
}

impl Drop for Taken {
    /// Somebody may have opened the file before and lock it after, while a third one makes it again: then both compute the tile, unless it is done.
    fn drop(&mut self) {
        // What cannot be removed, and the file of who was killed, goes when the store is next written to its end.
        let _ = fs::remove_file(&self.lock);
    }
}
