//! Arrays of VTK files: text, base64 and binary, plain and compressed.

use super::super::numpy::{Kind, Number};
use base64::prelude::{BASE64_STANDARD, Engine as _};
use flate2::read::ZlibDecoder;
use std::io::Read;
use std::ops::Range;

/// Place and encoding of the numbers of an array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Storage {
    /// Numbers written as text.
    Text(Range<usize>),
    /// Base64 with a header.
    Base64(Range<usize>),
    /// Bytes with a header.
    Raw(Range<usize>),
}

/// Properties of a file that all its arrays share.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Encoding {
    pub is_big: bool,
    /// Bytes of each number in a header.
    pub header: usize,
    pub compression: Compression,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compression {
    None,
    Zlib,
}

/// Type of the numbers of an array.
pub(super) fn number(name: &str, is_big: bool) -> Option<Number> {
    let (kind, size) = match name {
        "Float32" => (Kind::Float, 4),
        "Float64" => (Kind::Float, 8),
        "Int8" => (Kind::Signed, 1),
        "Int16" => (Kind::Signed, 2),
        "Int32" => (Kind::Signed, 4),
        "Int64" => (Kind::Signed, 8),
        "UInt8" => (Kind::Unsigned, 1),
        "UInt16" => (Kind::Unsigned, 2),
        "UInt32" => (Kind::Unsigned, 4),
        "UInt64" => (Kind::Unsigned, 8),
        _ => return None,
    };
    Some(Number { kind, size, is_big })
}

/// Decodes at most `most` numbers of an array; `Err` with the expected contents.
pub(super) fn values(
    bytes: &[u8],
    storage: &Storage,
    number: Number,
    encoding: Encoding,
    most: usize,
) -> Result<Vec<f64>, String> {
    let mut values = Vec::new();
    let most_bytes = most.saturating_mul(number.size);
    let block = match storage {
        Storage::Text(range) => {
            let words = bytes[range.clone()].split(u8::is_ascii_whitespace);
            for word in words.filter(|word| !word.is_empty()) {
                let value = std::str::from_utf8(word).ok();
                let value: Option<f64> = value.and_then(|word| word.parse().ok());
                values.push(value.ok_or_else(|| "numbers between blanks".to_owned())?);
                if values.len() > most {
                    return Err(format!("at most {most} numbers"));
                }
            }
            return Ok(values);
        }
        Storage::Base64(range) => {
            let plain = decoded(&bytes[range.clone()]).ok_or("base64 data")?;
            contents(&plain, encoding, most_bytes)?
        }
        Storage::Raw(range) => contents(&bytes[range.clone()], encoding, most_bytes)?,
    };
    if block.len() % number.size != 0 {
        return Err(format!("numbers of {} bytes", number.size));
    }
    values.reserve_exact(block.len() / number.size);
    number.decode(&block, &mut values);
    Ok(values)
}

/// Decodes base64, which may consist of several padded pieces.
fn decoded(text: &[u8]) -> Option<Vec<u8>> {
    let is_letter = |letter: &u8| !letter.is_ascii_whitespace();
    let letters: Vec<u8> = text.iter().copied().filter(is_letter).collect();
    let mut bytes = Vec::with_capacity(letters.len() / 4 * 3);
    for piece in letters.chunk_by(|own, next| *own != b'=' || *next == b'=') {
        BASE64_STANDARD.decode_vec(piece, &mut bytes).ok()?;
    }
    Some(bytes)
}

/// Contents after the header, decompressed; `Err` with the expected contents.
fn contents(bytes: &[u8], encoding: Encoding, most: usize) -> Result<Vec<u8>, String> {
    let cut = || "data of the length in its header".to_owned();
    let header = |n: usize| {
        let at = n.checked_mul(encoding.header).ok_or_else(cut)?;
        let part = at
            .checked_add(encoding.header)
            .and_then(|end| bytes.get(at..end));
        let part = part.ok_or_else(cut)?;
        let digits = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        let number = match encoding.is_big {
            true => part.iter().fold(0, digits),
            false => part.iter().rev().fold(0, digits),
        };
        usize::try_from(number).map_err(|_| cut())
    };
    let too_many = || format!("at most {most} bytes");
    if bytes.is_empty() {
        return Ok(Vec::new());
    }
    if encoding.compression == Compression::None {
        let length = header(0)?;
        if length > most {
            return Err(too_many());
        }
        let end = encoding.header.checked_add(length);
        let data = end.and_then(|end| bytes.get(encoding.header..end));
        return data.map(<[u8]>::to_vec).ok_or_else(cut);
    }
    let (blocks, size, last) = (header(0)?, header(1)?, header(2)?);
    let mut at = blocks
        .checked_add(3)
        .and_then(|numbers| numbers.checked_mul(encoding.header))
        .filter(|start| *start <= bytes.len())
        .ok_or_else(cut)?;
    let mut plain = Vec::new();
    for block in 0..blocks {
        let packed = header(3 + block)?;
        let data = at.checked_add(packed).and_then(|end| bytes.get(at..end));
        let size = match block + 1 == blocks && last > 0 {
            true => last,
            false => size,
        };
        if plain.len().checked_add(size).is_none_or(|all| all > most) {
            return Err(too_many());
        }
        // Memory grows with the data that is there, not with the size that the header claims.
        let before = plain.len();
        let read = ZlibDecoder::new(data.ok_or_else(cut)?)
            .take(size as u64)
            .read_to_end(&mut plain);
        if read.is_err() || plain.len() - before != size {
            return Err("compressed data of the length in its header".to_owned());
        }
        at += packed;
    }
    Ok(plain)
}
