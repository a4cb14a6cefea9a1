//! Reading of files that a user names: regular files of bounded length, as text.

use onset::cancel::checkpoint;
pub use onset_frames::input::decoded;
use onset_frames::input::regular;
use std::io::{self, Read};
use std::path::Path;

/// Maximum size of a text written by hand, such as a study or a table of particles, in bytes.
pub const MOST_TEXT: u64 = 16 << 20;
/// Maximum size of an output of a simulation, in bytes.
pub const MOST_OUTPUT: u64 = 4 << 30;

/// Reads a whole file of at most `most` bytes. Devices and pipes are refused without being opened, because reading from them may never end.
///
/// # Errors
/// [`io::Error`] if the file cannot be read, is not a regular file, or is too long.
pub fn bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    bounded(regular(path)?, most)
}

/// Reads from a source to its end, up to a limit.
///
/// # Errors
/// [`io::Error`] if the source cannot be read or holds more than `most` bytes.
pub fn bounded(from: impl Read, most: u64) -> io::Result<Vec<u8>> {
    /// Source that is read in parts, with a checkpoint after each part.
    struct InParts<R>(R);
    impl<R: Read> Read for InParts<R> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            checkpoint();
            self.0.read(buffer)
        }
    }
    onset_frames::input::bounded(InParts(from), most)
}

/// Reads a whole text file of at most `most` bytes, without its byte order mark.
///
/// # Errors
/// Fails like [`bytes`], and for a text that is not UTF-8.
pub fn text(path: &Path, most: u64) -> io::Result<String> {
    decoded(bytes(path, most)?)
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
