//! Reading of files that a user names: regular files of bounded length, as text.

use onset::cancel::checkpoint;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Maximum size of a text written by hand, such as a study or a table of particles, in bytes.
pub const MOST_TEXT: u64 = 16 << 20;
/// Maximum size of an output of a simulation, in bytes.
pub const MOST_OUTPUT: u64 = 4 << 30;

/// Reads a whole file of at most `most` bytes. Devices and pipes are refused without being opened, because reading them may never end.
///
/// # Errors
/// [`io::Error`] if the file cannot be read, is not a regular file, or is too long.
pub fn bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let found = fs::metadata(path)?;
    if found.is_dir() {
        return Err(io::Error::new(ErrorKind::IsADirectory, "it is a folder"));
    }
    if !found.is_file() {
        return Err(invalid(
            "it is a pipe or a device, not a regular file".to_owned(),
        ));
    }
    bounded(File::open(path)?, most)
}

/// Reads from a source to its end.
///
/// # Errors
/// [`io::Error`] if the source cannot be read or holds more than `most` bytes.
pub fn bounded(from: impl Read, most: u64) -> io::Result<Vec<u8>> {
    /// A source whose parts are read between checkpoints.
    struct InParts<R>(R);
    impl<R: Read> Read for InParts<R> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            checkpoint();
            self.0.read(buffer)
        }
    }
    let mut bytes = Vec::new();
    InParts(from).take(most + 1).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > most {
        true => Err(invalid(format!("it has more than {} MiB", most >> 20))),
        false => Ok(bytes),
    }
}

/// Reads a whole text file of at most `most` bytes, without its byte order mark.
///
/// # Errors
/// Fails like [`bytes`], and for a text that is not UTF-8.
pub fn text(path: &Path, most: u64) -> io::Result<String> {
    decoded(bytes(path, most)?)
}

/// Decodes UTF-8 with or without a byte order mark.
///
/// # Errors
/// [`io::Error`] with the line of the first byte that is not UTF-8, or with the name of another encoding.
pub fn decoded(mut bytes: Vec<u8>) -> io::Result<String> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(invalid("it is UTF-16; save it as UTF-8".to_owned()));
    }
    if bytes.starts_with(b"\xef\xbb\xbf") {
        bytes.drain(..3);
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        let line = 1 + valid.iter().filter(|byte| **byte == b'\n').count();
        invalid(format!("line {line} is not UTF-8 text"))
    })
}

fn invalid(why: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, why)
}

#[cfg(test)]
mod tests {
    use super::{bytes, decoded, text};
    use std::path::Path;

    #[test]
    fn a_byte_order_mark_is_dropped_and_other_encodings_are_refused_by_name() {
        let read = |bytes: &[u8]| decoded(bytes.to_vec()).map_err(|error| error.to_string());
        assert_eq!(read(b"\xef\xbb\xbfx,y\r\n"), Ok("x,y\r\n".to_owned()));
        assert_eq!(
            read(b"\xff\xfex\0"),
            Err("it is UTF-16; save it as UTF-8".to_owned())
        );
        assert_eq!(
            read(b"one\ntwo\xff"),
            Err("line 2 is not UTF-8 text".to_owned())
        );
    }

    #[test]
    fn endless_devices_and_long_files_are_refused() {
        let refused = |path: &str| {
            bytes(Path::new(path), 100)
                .expect_err("refused")
                .to_string()
        };
        #[cfg(unix)]
        assert!(refused("/dev/zero").contains("not a regular file"));
        assert_eq!(refused("src/input.rs"), "it has more than 0 MiB");
        assert!(text(Path::new("src"), 100).is_err());
    }
}
