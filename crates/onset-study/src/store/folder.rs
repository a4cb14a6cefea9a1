//! The files of a store: written whole or not at all.
//!
//! A file is written under a name of its own in the folder `.partial` and renamed to its place, so that whoever reads a
//! file reads all of it, whenever a process ends and however many write at once. Nothing is forced to the disk: after a loss
//! of power a chunk may be cut short, which its checksum tells.

use std::fs::{self, File};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};
use zarrs::storage::byte_range::ByteRangeIterator;
use zarrs::storage::{
    Bytes, MaybeBytesIterator, OffsetBytesIterator, ReadableStorageTraits, StorageError, StoreKey,
    StorePrefix, WritableStorageTraits,
};

/// Where files are that are being written.
const PARTIAL: &str = ".partial";

/// A folder of files.
#[derive(Debug)]
pub(super) struct Folder {
    root: PathBuf,
}

/// A name that no other process uses, here or on another machine, nor this one again.
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

    /// The path of a file.
    pub(super) fn path(&self, key: &str) -> PathBuf {
        self.root.join(key)
    }

    /// A whole file, if it is there.
    pub(super) fn read(&self, key: &str) -> io::Result<Option<Vec<u8>>> {
        match fs::read(self.path(key)) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Writes a file, replacing what is there.
    pub(super) fn write(&self, key: &str, bytes: &[u8]) -> io::Result<()> {
        let partial = self.path(PARTIAL).join(unique());
        let written = within_parent(&partial, || fill(&partial, bytes)).and_then(|()| {
            let path = self.path(key);
            within_parent(&path, || fs::rename(&partial, &path))
        });
        if written.is_err() {
            // Nothing more can be done about it; whoever has the store for itself clears it.
            let _ = fs::remove_file(&partial);
        }
        written
    }

    /// Removes what killed processes have left. Only for who has the store for itself.
    pub(super) fn clear(&self) {
        // What cannot be removed does no harm.
        let _ = fs::remove_dir_all(self.path(PARTIAL));
    }

    /// Removes the folder of files that are being written where there are none. Whoever needs it makes it again.
    pub(super) fn clear_if_empty(&self) {
        let _ = fs::remove_dir(self.path(PARTIAL));
    }
}

/// Does something with a path, making its folder where that is missing.
fn within_parent(path: &Path, action: impl Fn() -> io::Result<()>) -> io::Result<()> {
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

impl ReadableStorageTraits for Folder {
    fn get_partial_many<'a>(
        &'a self,
        key: &StoreKey,
        byte_ranges: ByteRangeIterator<'a>,
    ) -> Result<MaybeBytesIterator<'a>, StorageError> {
        let Some(bytes) = self.read(key.as_str())? else {
            return Ok(None);
        };
        let bytes = Bytes::from(bytes);
        Ok(Some(Box::new(byte_ranges.map(move |range| {
            let range = range.to_range_usize(bytes.len() as u64);
            if range.start <= range.end && range.end <= bytes.len() {
                Ok(bytes.slice(range))
            } else {
                Err(StorageError::Other("a range beyond the end".to_owned()))
            }
        }))))
    }

    fn size_key(&self, key: &StoreKey) -> Result<Option<u64>, StorageError> {
        match fs::metadata(self.path(key.as_str())) {
            Ok(metadata) => Ok(Some(metadata.len())),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    fn supports_get_partial(&self) -> bool {
        false
    }
}

impl WritableStorageTraits for Folder {
    fn set(&self, key: &StoreKey, value: Bytes) -> Result<(), StorageError> {
        Ok(self.write(key.as_str(), &value)?)
    }

    fn set_partial_many(&self, _: &StoreKey, _: OffsetBytesIterator) -> Result<(), StorageError> {
        Err(StorageError::Unsupported(
            "files are written whole".to_owned(),
        ))
    }

    fn erase(&self, _: &StoreKey) -> Result<(), StorageError> {
        Err(StorageError::Unsupported(
            "nothing is erased from a store".to_owned(),
        ))
    }

    fn erase_prefix(&self, _: &StorePrefix) -> Result<(), StorageError> {
        Err(StorageError::Unsupported(
            "nothing is erased from a store".to_owned(),
        ))
    }

    fn supports_set_partial(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_written_beside_what_others_write_and_leaves_nothing() {
        let root = std::env::temp_dir().join(format!("onset-folder-{}", unique()));
        let folder = Folder::new(&root);
        let leftover = root.join(PARTIAL).join("killed");
        fs::create_dir_all(root.join(PARTIAL)).expect("a folder");
        fs::write(&leftover, "half").expect("a file");
        folder.write("a/c/0/0", b"one").expect("written");
        folder.write("a/c/0/0", b"two").expect("replaced");
        assert_eq!(folder.read("a/c/0/0").expect("read"), Some(b"two".to_vec()));
        let partial = || fs::read_dir(root.join(PARTIAL)).map(Iterator::count).ok();
        assert_eq!(partial(), Some(1), "only what another has left");
        folder.clear();
        assert_eq!(partial(), None);
        fs::remove_dir_all(root).expect("removable");
    }

    #[test]
    fn a_failed_write_leaves_nothing_and_what_was_there() {
        let root = std::env::temp_dir().join(format!("onset-folder-{}", unique()));
        let folder = Folder::new(&root);
        folder.write("a", b"one").expect("written");
        assert!(folder.write("a/b", b"two").is_err(), "a file is in the way");
        assert_eq!(folder.read("a").expect("read"), Some(b"one".to_vec()));
        assert_eq!(
            fs::read_dir(root.join(PARTIAL)).map(Iterator::count).ok(),
            Some(0)
        );
        fs::remove_dir_all(root).expect("removable");
    }
}
