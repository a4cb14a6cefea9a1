//! Access of processes to a store: shared or exclusive, and the reservation of tiles.
//!
//! Access is controlled by locks on `zarr.json` and on a file for each tile in progress. The operating system releases them when a process ends.

use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest wait for another process with exclusive access.
const MAX_WAIT: Duration = Duration::from_secs(3);

/// Lock on a store, held until dropped.
#[derive(Debug)]
pub(super) struct Occupancy {
    _file: File,
}

/// Result of a request for exclusive access.
#[derive(Debug)]
pub(super) enum Claim {
    /// Exclusive access until the lock is dropped.
    Alone(#[allow(dead_code, reason = "held, not read")] Occupancy),
    /// Access is shared with other processes.
    Shared,
    /// The file system does not support locks.
    Unknown,
}

impl Occupancy {
    /// Acquires shared access to the store, or `None` if another process keeps it exclusively for longer than a few seconds.
    ///
    /// Other processes of onset hold exclusive access only briefly, to clear or replace a store. Access is granted if the file system does not
    /// support locks.
    pub(super) fn shared(metadata: &Path) -> io::Result<Option<Self>> {
        let file = File::open(metadata)?;
        let begin = Instant::now();
        while let Err(TryLockError::WouldBlock) = file.try_lock_shared() {
            if begin.elapsed() > MAX_WAIT {
                return Ok(None);
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        Ok(Some(Self { _file: file }))
    }

    /// Requests exclusive access to the store.
    pub(super) fn alone(metadata: &Path) -> io::Result<Claim> {
        let file = File::open(metadata)?;
        Ok(match file.try_lock() {
            Ok(()) => Claim::Alone(Self { _file: file }),
            Err(TryLockError::WouldBlock) => Claim::Shared,
            Err(TryLockError::Error(_)) => Claim::Unknown,
        })
    }
}

/// Reservation of a tile until dropped.
///
/// Other processes do not compute the tile while it is reserved, unless the file system does not support locks.
#[derive(Debug)]
pub struct Taken {
    lock: PathBuf,
    _file: File,
}

impl Taken {
    /// Reserves a tile by creating and locking a file; `None` if another process holds it. Links, pipes and other special files are not opened.
    pub(super) fn by(lock: &Path) -> io::Result<Option<Self>> {
        match fs::symlink_metadata(lock) {
            Ok(found) if !found.is_file() => return Err(io::Error::other("it is not a file")),
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
    /// Removes the lock file.
    ///
    /// A process may lock the removed file while another process creates it again: both then compute the tile, unless it is finished.
    fn drop(&mut self) {
        // A failure is ignored. Leftover lock files, also of killed processes, are removed when the last writer closes the store.
        let _ = fs::remove_file(&self.lock);
    }
}
