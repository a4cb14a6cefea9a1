//! Checksum that identifies a library.

use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;

/// SHA-256 sum of a file in hexadecimal digits, as printed by `sha256sum`.
///
/// # Errors
/// [`io::Error`] if it cannot be read, or is not a regular file.
pub fn fingerprint(file: &Path) -> io::Result<String> {
    passed_on(opened(file)?, io::sink())
}

/// Copies a file of at most `most` bytes to a new path, and returns the SHA-256 sum of the copy.
#[cfg(unix)]
pub(crate) fn copied(from: &Path, to: &Path, most: u64) -> io::Result<String> {
    let file = opened(from)?;
    if file.metadata()?.len() > most {
        let message = "it is larger than the memory that it may use (material.memory-limit)";
        return Err(io::Error::new(ErrorKind::FileTooLarge, message));
    }
    passed_on(file.take(most), File::create_new(to)?)
}

/// Opens a regular file; refuses pipes and other files that could block.
fn opened(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        options.custom_flags(rustix::fs::OFlags::NONBLOCK.bits() as i32);
    }
    let file = options.read(true).open(path)?;
    match file.metadata()?.is_file() {
        true => Ok(file),
        false => Err(io::Error::new(ErrorKind::InvalidInput, "it is not a file")),
    }
}

/// Writes the input to the output and returns its SHA-256 sum.
fn passed_on(mut from: impl Read, mut to: impl Write) -> io::Result<String> {
    let mut hash = Sha256::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        match from.read(&mut buffer) {
            Ok(0) => return Ok(format!("{:x}", hash.finalize())),
            Ok(count) => {
                hash.update(&buffer[..count]);
                to.write_all(&buffer[..count])?;
            }
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}
