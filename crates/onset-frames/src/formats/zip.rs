//! Members of a ZIP archive, stored or deflated.

use crate::error::{FrameError, Place};
use crate::input::regular;
use flate2::Crc;
use flate2::bufread::DeflateDecoder;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Maximum size of the list of members, in bytes.
const MAX_LIST: u64 = 64 << 20;
/// Largest compression ratio of deflate.
pub(super) const MOST_RATIO: u64 = 1032;

/// Member of an archive.
#[derive(Clone, Debug)]
pub(super) struct Member {
    pub name: String,
    is_deflated: bool,
    header: u64,
    packed: u64,
    /// Size of the contents.
    pub size: u64,
    checksum: u32,
}

/// Reader of the contents of a member; at the end of the contents it fails if the checksum is wrong.
struct Checked<R> {
    from: R,
    left: u64,
    sum: Crc,
    expected: u32,
}

impl<R: Read> Read for Checked<R> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let most = usize::try_from(self.left).unwrap_or(usize::MAX);
        let most = most.min(to.len());
        let count = self.from.read(&mut to[..most])?;
        self.sum.update(&to[..count]);
        self.left -= count as u64;
        if self.left == 0 && self.sum.sum() != self.expected {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                "the checksum of an array is wrong: the file is damaged",
            ));
        }
        Ok(count)
    }
}

fn damaged(path: &Path) -> FrameError {
    FrameError::wrong(
        Place::file(path),
        "a complete ZIP archive, as numpy.savez writes it",
        "write the file again; it is damaged or cut off",
    )
}

fn number(bytes: &[u8], at: usize, size: usize) -> Option<u64> {
    let bytes = bytes.get(at..at.checked_add(size)?)?;
    Some(
        bytes
            .iter()
            .rev()
            .fold(0, |sum, byte| sum << 8 | u64::from(*byte)),
    )
}

/// Lists the members of an archive.
pub(super) fn members(path: &Path) -> Result<Vec<Member>, FrameError> {
    let failed = |error| FrameError::unreadable(path, error);
    let mut file = regular(path).map_err(failed)?;
    let length = file.metadata().map_err(failed)?.len();
    let list = list(&mut file, length).map_err(failed)?;
    let list = list.ok_or_else(|| damaged(path))?;
    let mut members = Vec::new();
    let mut rest = &list[..];
    while rest.len() >= 46 && rest.starts_with(b"PK\x01\x02") {
        let (member, next) = member(rest, length).ok_or_else(|| damaged(path))?;
        let member = member.map_err(|what| {
            FrameError::refused(Place::file(path), what, "write the file with numpy.savez")
        })?;
        members.push(member);
        rest = next;
    }
    Ok(members)
}

/// Central directory of an archive.
fn list(file: &mut File, length: u64) -> io::Result<Option<Vec<u8>>> {
    // The end of the archive may be followed by a comment.
    let tail = length.min(66_000);
    let end = read_at(file, length - tail, tail)?;
    let Some(place) = end.windows(4).rposition(|bytes| bytes == b"PK\x05\x06") else {
        return Ok(None);
    };
    let record = &end[place..];
    let (mut size, mut start) = (number(record, 12, 4), number(record, 16, 4));
    let locator = place.checked_sub(20).map(|start| &end[start..place]);
    if let Some(locator) = locator.filter(|bytes| bytes.starts_with(b"PK\x06\x07")) {
        let at = number(locator, 8, 8).unwrap_or(u64::MAX);
        if at > length.saturating_sub(56) {
            return Ok(None);
        }
        let record = read_at(file, at, 56)?;
        (size, start) = (number(&record, 40, 8), number(&record, 48, 8));
    }
    match (size, start) {
        (Some(size), Some(start))
            if size <= MAX_LIST && start.checked_add(size).is_some_and(|end| end <= length) =>
        {
            Ok(Some(read_at(file, start, size)?))
        }
        _ => Ok(None),
    }
}

fn read_at(file: &mut File, at: u64, size: u64) -> io::Result<Vec<u8>> {
    file.seek(SeekFrom::Start(at))?;
    let mut bytes = Vec::new();
    file.take(size).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads an entry of the central directory; returns it with the remaining directory.
fn member(entry: &[u8], length: u64) -> Option<(Result<Member, String>, &[u8])> {
    let short = |at| number(entry, at, 2);
    let (name, extra, comment) = (short(28)?, short(30)?, short(32)?);
    let name_end = 46 + name as usize;
    let extra_end = name_end + extra as usize;
    let text = String::from_utf8_lossy(entry.get(46..name_end)?).into_owned();
    let mut wide = entry.get(name_end..extra_end)?;
    let rest = entry.get(extra_end + comment as usize..)?;
    let (mut size, mut packed, mut header) = (
        number(entry, 24, 4)?,
        number(entry, 20, 4)?,
        number(entry, 42, 4)?,
    );
    while let (Some(kind), Some(bytes)) = (number(wide, 0, 2), number(wide, 2, 2)) {
        let field = wide.get(4..4 + bytes as usize)?;
        if kind == 1 {
            let mut at = 0;
            for value in [&mut size, &mut packed, &mut header] {
                if *value == 0xffff_ffff {
                    *value = number(field, at, 8)?;
                    at += 8;
                }
            }
        }
        wide = &wide[4 + bytes as usize..];
    }
    if header.checked_add(packed)? > length {
        return None;
    }
    let method = short(10)?;
    let shown = crate::error::brief(&text);
    let member = match (short(8)? & 1, method) {
        (1, _) => Err(format!("`{shown}` is encrypted")),
        (_, 0) if size != packed => return None,
        (_, 8) if size > packed.saturating_mul(MOST_RATIO) => return None,
        (_, 0 | 8) => Ok(Member {
            name: text,
            is_deflated: method == 8,
            header,
            packed,
            size,
            checksum: number(entry, 16, 4)? as u32,
        }),
        _ => Err(format!("`{shown}` has compression method {method}")),
    };
    Some((member, rest))
}

impl Member {
    /// Reader of the contents.
    pub(super) fn open(&self, path: &Path) -> Result<Box<dyn Read + Send>, FrameError> {
        let failed = |error| FrameError::unreadable(path, error);
        let mut file = regular(path).map_err(failed)?;
        let header = read_at(&mut file, self.header, 30).map_err(failed)?;
        let (Some(name), Some(extra)) = (number(&header, 26, 2), number(&header, 28, 2)) else {
            return Err(damaged(path));
        };
        if !header.starts_with(b"PK\x03\x04") {
            return Err(damaged(path));
        }
        let start = self.header + 30 + name + extra;
        file.seek(SeekFrom::Start(start)).map_err(failed)?;
        let packed = BufReader::with_capacity(1 << 16, file.take(self.packed));
        let from: Box<dyn Read + Send> = match self.is_deflated {
            true => Box::new(BufReader::new(DeflateDecoder::new(packed))),
            false => Box::new(packed),
        };
        Ok(Box::new(Checked {
            from,
            left: self.size,
            sum: Crc::new(),
            expected: self.checksum,
        }))
    }
}
