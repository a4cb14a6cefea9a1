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

/// Byte order mark of UTF-8.
pub(crate) const MARK: &[u8] = b"\xef\xbb\xbf";

/// Name of an encoding other than UTF-8, from the first bytes of a text: its byte order mark, or zeros between the letters.
pub fn other_encoding(start: &[u8]) -> Option<&'static str> {
    match start {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => Some("UTF-32"),
        [1..=255, 0, 0, 0, 1..=255, 0, 0, 0, ..] | [0, 0, 0, 1..=255, 0, 0, 0, 1..=255, ..] => {
            Some("UTF-32")
        }
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Some("UTF-16"),
        [1..=255, 0, 1..=255, 0, 1..=255, 0, ..] | [0, 1..=255, 0, 1..=255, 0, 1..=255, ..] => {
            Some("UTF-16")
        }
        _ => None,
    }
}

/// Description of a file that is not text, from its first bytes, with what to do.
fn other_format(start: &[u8]) -> Option<&'static str> {
    const FORMATS: &[(&[u8], &str)] = &[
        (
            b"PK\x03\x04",
            "a ZIP archive, such as a spreadsheet (xlsx, ods); save the sheet as CSV",
        ),
        (
            b"\xd0\xcf\x11\xe0",
            "a spreadsheet or document of Office (xls, doc); save it as CSV",
        ),
        (b"%PDF", "a PDF document; save its table as CSV"),
        (b"\x1f\x8b", "compressed by gzip; decompress it"),
        (b"\x89HDF", "an HDF5 file; save its table as CSV"),
        (b"\x93NUMPY", "a NumPy file; save its array as CSV"),
    ];
    let known = FORMATS.iter().find(|(first, _)| start.starts_with(first));
    known.map(|(_, name)| *name)
}

/// Decodes UTF-8 with or without a byte order mark. Carriage returns that end all lines are replaced by line feeds.
///
/// # Errors
/// [`io::Error`] with the line of the first byte that is not UTF-8 text, or with the name of another encoding or format.
pub fn decoded(mut bytes: Vec<u8>) -> io::Result<String> {
    if let Some(format) = other_format(&bytes) {
        return Err(invalid(format!("it is {format}")));
    }
    if let Some(encoding) = other_encoding(&bytes) {
        return Err(invalid(format!("it is {encoding}; save it as UTF-8")));
    }
    if bytes.starts_with(MARK) {
        bytes.drain(..MARK.len());
    }
    let line_of = |before: &[u8]| 1 + before.iter().filter(|byte| **byte == b'\n').count();
    if let Some(at) = bytes.iter().position(|byte| *byte == 0) {
        let line = line_of(&bytes[..at]);
        return Err(invalid(format!(
            "line {line} has a zero byte, which is not text"
        )));
    }
    if bytes.contains(&b'\r') && !bytes.contains(&b'\n') {
        for byte in bytes.iter_mut().filter(|byte| **byte == b'\r') {
            *byte = b'\n';
        }
    }
    String::from_utf8(bytes).map_err(|error| {
        let line = line_of(&error.as_bytes()[..error.utf8_error().valid_up_to()]);
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
        for (bytes, encoding) in [
            (&b"\xff\xfex\0\0\0"[..], "UTF-16"),
            (b"x\0,\0y\0\n\0", "UTF-16"),
            (b"\0x\0,\0y\0\n", "UTF-16"),
            (b"\xff\xfe\0\0x\0\0\0", "UTF-32"),
            (b"\0\0\xfe\xff\0\0\0x", "UTF-32"),
            (b"x\0\0\0,\0\0\0", "UTF-32"),
        ] {
            let told = format!("it is {encoding}; save it as UTF-8");
            assert_eq!(read(bytes), Err(told), "{bytes:?}");
        }
        for (bytes, format) in [
            (&b"PK\x03\x04\x14\0"[..], "a ZIP archive"),
            (b"\xd0\xcf\x11\xe0\xa1\xb1", "a spreadsheet or document"),
            (b"%PDF-1.4\n", "a PDF document"),
            (b"\x1f\x8b\x08", "compressed by gzip"),
        ] {
            let error = read(bytes).expect_err("not text");
            assert!(error.starts_with(&format!("it is {format}")), "{error}");
        }
        assert_eq!(read(b"x,y\r1,2\r"), Ok("x,y\n1,2\n".to_owned()));
        assert_eq!(
            read(b"one\ntwo\n\0\0"),
            Err("line 3 has a zero byte, which is not text".to_owned())
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
