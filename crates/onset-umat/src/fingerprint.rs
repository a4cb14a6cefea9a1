//! What tells one library from another.

use sha2::{Digest, Sha256};
use std::fs::File;
use std::io;
use std::path::Path;

/// The SHA-256 of a file, in hexadecimal digits, as `sha256sum` prints it.
///
/// # Errors
/// [`io::Error`] when it cannot be read.
pub fn fingerprint(file: &Path) -> io::Result<String> {
    let mut hash = Sha256::new();
    io::copy(&mut File::open(file)?, &mut hash)?;
    Ok(format!("{:x}", hash.finalize()))
}
