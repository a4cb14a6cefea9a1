//! Regular files of bounded length, and text.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Opens a regular file. Devices and pipes are refused without being opened, because reading from them may never end.
///
/// # Errors
/// [`io::Error`] if the file cannot be opened or is not a regular file.
pub fn regular(path: &Path) -> io::Result<File> {
    let found = fs::metadata(path)?;
    if found.is_dir() {
        return Err(io::Error::new(ErrorKind::IsADirectory, "it is a folder"));
    }
    if !found.is_file() {
        return Err(invalid(
            "it is a pipe or a device, not a regular file".to_owned(),
        ));
    }
    File::open(path)
}

/// Reads from a source to its end, up to a limit.
///
/// # Errors
/// [`io::Error`] if the source cannot be read or holds more than `most` bytes.
pub fn bounded(from: impl Read, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > most {
        true => Err(invalid(format!("it has more than {} MiB", most >> 20))),
        false => Ok(bytes),
    }
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
    use super::{bounded, decoded, regular};
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
        #[cfg(unix)]
        {
            let refused = regular(Path::new("/dev/zero")).expect_err("refused");
            assert!(refused.to_string().contains("not a regular file"));
        }
        let own = regular(Path::new("src/input.rs")).expect("a regular file");
        let refused = bounded(own, 100).expect_err("too long");
        assert_eq!(refused.to_string(), "it has more than 0 MiB");
        assert!(regular(Path::new("src")).is_err());
    }
}
