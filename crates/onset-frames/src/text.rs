//! Lines of text files, plain or compressed.

use crate::error::{FrameError, Place};
use crate::input::{MARK, regular};
use crate::reading::Limits;
use flate2::bufread::MultiGzDecoder;
use std::fs::File;
use std::io::{self, BufRead, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Maximum length of a line, in bytes.
const MAX_LINE: usize = 1 << 20;

/// Position of a line in the decompressed text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Mark {
    pub offset: u64,
    /// Number of lines before.
    pub lines: u64,
}

enum Stream {
    Plain(BufReader<File>),
    Packed(Box<dyn BufRead + Send>),
}

/// Reader of lines, which can return to an earlier place.
pub(crate) struct Lines {
    path: PathBuf,
    stream: Stream,
    mark: Mark,
    line: Vec<u8>,
    /// Returns true if the last line ends with a line feed.
    is_whole: bool,
    limits: Limits,
}

/// Text of a regular file, decompressed.
fn open(path: &Path) -> io::Result<Stream> {
    let mut file = BufReader::with_capacity(1 << 16, regular(path)?);
    Ok(match file.fill_buf()? {
        [0x1f, 0x8b, ..] => Stream::Packed(Box::new(BufReader::new(MultiGzDecoder::new(file)))),
        _ => Stream::Plain(file),
    })
}

/// First bytes of a file, decompressed.
pub(crate) fn head(path: &Path, most: u64) -> Result<Vec<u8>, FrameError> {
    let read = || {
        let mut bytes = Vec::new();
        let outcome = match open(path)? {
            Stream::Plain(from) => from.take(most).read_to_end(&mut bytes),
            Stream::Packed(from) => from.take(most).read_to_end(&mut bytes),
        };
        match outcome {
            // A file that is still being written may end anywhere.
            Err(error) if error.kind() != ErrorKind::UnexpectedEof => Err(error),
            _ => Ok(bytes),
        }
    };
    read().map_err(|error| FrameError::unreadable(path, error))
}

impl Lines {
    pub(crate) fn open(path: &Path, limits: Limits) -> Result<Self, FrameError> {
        let stream = open(path).map_err(|error| FrameError::unreadable(path, error))?;
        Ok(Self {
            path: path.to_owned(),
            stream,
            mark: Mark::default(),
            line: Vec::new(),
            is_whole: true,
            limits,
        })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Position of the next line.
    pub(crate) fn mark(&self) -> Mark {
        self.mark
    }

    /// Position of the last line.
    pub(crate) fn place(&self) -> Place {
        Place::line(&self.path, self.mark.lines)
    }

    /// Last line, without its end.
    pub(crate) fn line(&self) -> &[u8] {
        &self.line
    }

    /// Returns true if the last line ends with a line feed.
    pub(crate) fn is_whole(&self) -> bool {
        self.is_whole
    }

    fn reader(&mut self) -> &mut dyn BufRead {
        match &mut self.stream {
            Stream::Plain(from) => from,
            Stream::Packed(from) => from,
        }
    }

    fn failed(&self, error: io::Error) -> FrameError {
        FrameError::unreadable(&self.path, error)
    }

    /// Number of bytes of `outcome`; a truncated compressed file ends where it is truncated.
    fn count<T: Default>(&self, outcome: io::Result<T>) -> Result<T, FrameError> {
        match outcome {
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(T::default()),
            outcome => outcome.map_err(|error| self.failed(error)),
        }
    }

    fn advance(&mut self, bytes: u64, lines: u64) -> Result<(), FrameError> {
        self.mark.offset += bytes;
        self.mark.lines += lines;
        if self.mark.offset > self.limits.text {
            return Err(FrameError::refused(
                self.place(),
                format!("the text has more than {} MiB", self.limits.text >> 20),
                "split the file, or write fewer frames",
            ));
        }
        Ok(())
    }

    /// Reads the next line; false at the end of the file.
    pub(crate) fn next(&mut self) -> Result<bool, FrameError> {
        let mut line = std::mem::take(&mut self.line);
        line.clear();
        let outcome = self
            .reader()
            .take(MAX_LINE as u64 + 1)
            .read_until(b'\n', &mut line);
        self.count(outcome)?;
        let bytes = line.len();
        self.is_whole = line.last() == Some(&b'\n');
        if self.mark.offset == 0 && line.starts_with(MARK) {
            line.drain(..MARK.len());
        }
        self.line = line;
        self.advance(bytes as u64, u64::from(bytes > 0))?;
        if bytes > MAX_LINE {
            return Err(FrameError::refused(
                self.place(),
                format!("the line has more than {} KiB", MAX_LINE >> 10),
                "give an output file of a simulation in one of the known formats",
            ));
        }
        while self
            .line
            .last()
            .is_some_and(|byte| matches!(byte, b'\n' | b'\r'))
        {
            self.line.pop();
        }
        Ok(bytes > 0)
    }

    /// Reads the next line if it is complete; a file that is still being written may end within a number.
    pub(crate) fn next_whole(&mut self) -> Result<bool, FrameError> {
        Ok(self.next()? && self.is_whole)
    }

    /// Skips complete lines; returns false if there are fewer lines.
    pub(crate) fn skip(&mut self, lines: u64) -> Result<bool, FrameError> {
        for _ in 0..lines {
            let outcome = self.reader().skip_until(b'\n');
            let bytes = self.count(outcome)?;
            if bytes == 0 {
                return Ok(false);
            }
            self.advance(bytes as u64, 1)?;
        }
        Ok(true)
    }

    /// Moves to a position in this file.
    pub(crate) fn go_to(&mut self, mark: Mark) -> Result<(), FrameError> {
        if mark.offset < self.mark.offset && matches!(self.stream, Stream::Packed(_)) {
            self.stream = open(&self.path).map_err(|error| self.failed(error))?;
            self.mark = Mark::default();
        }
        let ahead = mark.offset.wrapping_sub(self.mark.offset);
        let outcome = match &mut self.stream {
            Stream::Plain(from) => from.seek_relative(ahead as i64),
            Stream::Packed(from) => io::copy(&mut from.take(ahead), &mut io::sink()).map(|_| ()),
        };
        self.count(outcome)?;
        self.mark = mark;
        Ok(())
    }

    /// Decompresses the text into a temporary file, so that it can be read in any order.
    pub(crate) fn unpack(&mut self) -> Result<(), FrameError> {
        if matches!(self.stream, Stream::Plain(_)) {
            return Ok(());
        }
        self.go_to(Mark::default())?;
        let most = self.limits.text;
        let copied = match &mut self.stream {
            Stream::Plain(_) => Ok(None),
            Stream::Packed(from) => tempfile::tempfile().and_then(|mut file| {
                let outcome = io::copy(&mut from.take(most), &mut file);
                if let Err(error) = outcome
                    && error.kind() != ErrorKind::UnexpectedEof
                {
                    return Err(error);
                }
                file.seek(SeekFrom::Start(0))?;
                Ok(Some(file))
            }),
        };
        if let Some(file) = copied.map_err(|error| self.failed(error))? {
            self.stream = Stream::Plain(BufReader::new(file));
            self.mark = Mark::default();
        }
        Ok(())
    }
}

/// Number of significant digits of a decimal number, or `None` for another word.
pub(crate) fn significant_digits(word: &[u8]) -> Option<u32> {
    let mantissa = word.split(|byte| matches!(byte, b'e' | b'E')).next()?;
    let mut digits = 0;
    for byte in mantissa {
        match byte {
            b'0' if digits == 0 => {}
            b'0'..=b'9' => digits += 1,
            b'.' | b'-' | b'+' => {}
            _ => return None,
        }
    }
    Some(digits)
}

/// Rows of numbers of a table; only columns in use are parsed.
pub(crate) struct Rows {
    wanted: Vec<bool>,
    /// Values of each column; empty for unused columns.
    pub values: Vec<Vec<f64>>,
}

impl Rows {
    pub(crate) fn new(wanted: Vec<bool>) -> Self {
        Self {
            values: vec![Vec::new(); wanted.len()],
            wanted,
        }
    }

    /// Parses a further column.
    pub(crate) fn want(&mut self, column: usize) {
        self.wanted[column] = true;
    }

    /// Adds the numbers of a row to the columns.
    pub(crate) fn push<'a>(
        &mut self,
        words: impl Iterator<Item = &'a [u8]>,
        place: impl Fn() -> Place,
    ) -> Result<(), FrameError> {
        let hint = "each line has one number for each column, with a decimal point";
        let mut count = 0;
        for word in words {
            if self.wanted.get(count) == Some(&true) {
                let number = std::str::from_utf8(word)
                    .ok()
                    .and_then(|word| word.parse().ok());
                let number = number.ok_or_else(|| {
                    FrameError::unexpected(
                        place(),
                        format!("a number in column {}", count + 1),
                        word,
                        hint,
                    )
                })?;
                self.values[count].push(number);
            }
            count += 1;
        }
        match count == self.wanted.len() {
            true => Ok(()),
            false => Err(FrameError::wrong(
                place(),
                format!("{} columns, found {count}", self.wanted.len()),
                hint,
            )),
        }
    }
}

/// Iterates over the words separated by blanks.
pub(crate) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
}

/// Largest number of significant digits in the given columns, from some rows of each frame.
#[derive(Default)]
pub(crate) struct Digits {
    pub columns: Vec<usize>,
    pub most: u32,
}

impl Digits {
    /// Number of rows of a frame that are read, if the total number is known.
    pub(crate) const ROWS: u64 = 64;
    /// Distance between the rows that are read, if the total number is unknown.
    pub(crate) const STRIDE: u64 = 7;

    pub(crate) fn read<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>) {
        for (column, word) in words.enumerate() {
            if self.columns.contains(&column) {
                self.most = self.most.max(significant_digits(word).unwrap_or(0));
            }
        }
    }
}
