//! File format of a chunk: little-endian values, compressed by gzip, with a CRC-32C of the compressed bytes.
//!
//! The header of a gzip stream has room for a name and a comment, which Zarr readers ignore. They record the path of the chunk and the identity of
//! its map, so that a misplaced chunk is detected.

use super::Column;
use super::layout::GZIP_LEVEL;
use flate2::Compression;
use flate2::GzBuilder;
use flate2::bufread::GzDecoder;
use std::io::{self, Read, Write};

/// Position of a chunk in a store.
#[derive(Clone, Copy, Debug)]
pub(super) struct Label<'a> {
    /// Path of the chunk in the store.
    pub(super) key: &'a str,
    /// Identity of the map (see [`Layout::identity`](super::Layout)).
    pub(super) identity: &'a str,
}

/// Number of values converted to bytes at a time.
const BATCH_VALUES: usize = 1024;
/// Length of the checksum; bytes.
const CHECKSUM_BYTES: usize = 4;

/// Encodes a chunk as bytes.
pub(super) fn encode(values: &Column, label: Label<'_>) -> io::Result<Vec<u8>> {
    let header = GzBuilder::new().filename(label.key).comment(label.identity);
    let mut gzip = header.write(Vec::new(), Compression::new(GZIP_LEVEL));
    // Small groups of values stay in the cache.
    let mut raw = [0; 8 * BATCH_VALUES];
    match values {
        Column::Flags(flags) => {
            for some in flags.chunks(raw.len()) {
                for (byte, flag) in raw.iter_mut().zip(some) {
                    *byte = flag.cast_unsigned();
                }
                gzip.write_all(&raw[..some.len()])?;
            }
        }
        Column::Numbers(numbers) => {
            for some in numbers.chunks(BATCH_VALUES) {
                for (bytes, number) in raw.as_chunks_mut().0.iter_mut().zip(some) {
                    *bytes = number.to_le_bytes();
                }
                gzip.write_all(&raw[..8 * some.len()])?;
            }
        }
    }
    let mut bytes = gzip.finish()?;
    bytes.extend(crc32c::crc32c(&bytes).to_le_bytes());
    Ok(bytes)
}

/// Upper bound on the compressed size of `raw` bytes; incompressible data grow by a few bytes per block.
pub(super) fn largest(raw: usize) -> u64 {
    (raw + raw / 64 + 4096) as u64
}

/// Decodes `count` flags or numbers of a chunk.
///
/// # Errors
/// The reason why the chunk is invalid, as text.
pub(super) fn decode(
    bytes: &[u8],
    is_flags: bool,
    count: usize,
    label: Label<'_>,
) -> Result<Column, String> {
    let size = bytes.len().checked_sub(CHECKSUM_BYTES);
    let (body, sum) = bytes.split_at(size.ok_or("it is cut short: it has no checksum")?);
    if sum != crc32c::crc32c(body).to_le_bytes() {
        return Err("its checksum does not match its content".to_owned());
    }
    let expected = if is_flags { count } else { 8 * count };
    let mut gzip = GzDecoder::new(body);
    check(&gzip, label)?;
    let mut raw = Vec::new();
    // One extra byte detects an oversized chunk; no more is unpacked, so that a forged size does no harm.
    let read = Read::by_ref(&mut gzip)
        .take(expected as u64 + 1)
        .read_to_end(&mut raw);
    read.map_err(|error| format!("it cannot be unpacked: {error}"))?;
    if raw.len() != expected || !gzip.into_inner().is_empty() {
        return Err(format!("it does not hold {expected} bytes of values"));
    }
    Ok(if is_flags {
        Column::Flags(raw.into_iter().map(u8::cast_signed).collect())
    } else {
        let numbers = raw.as_chunks().0.iter();
        Column::Numbers(numbers.map(|bytes| f64::from_le_bytes(*bytes)).collect())
    })
}

/// Checks that the label in a chunk agrees with its position.
fn check(gzip: &GzDecoder<&[u8]>, label: Label<'_>) -> Result<(), String> {
    let word =
        |bytes: Option<&[u8]>| String::from_utf8_lossy(bytes.unwrap_or_default()).into_owned();
    let header = gzip.header().ok_or("it is not compressed by gzip")?;
    let (key, identity) = (word(header.filename()), word(header.comment()));
    if key != label.key {
        return Err(format!("it is marked as another chunk, `{}`", plain(&key)));
    }
    if identity != label.identity {
        return Err("it is marked as a chunk of another map".to_owned());
    }
    Ok(())
}

fn plain(text: &str) -> String {
    text.chars()
        .filter(|letter| !letter.is_control())
        .take(80)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LABEL: Label<'_> = Label {
        key: "verdict/c/0/3",
        identity: "0123",
    };

    #[test]
    fn a_chunk_is_restored_at_its_position_and_refused_at_another() {
        let flags = Column::Flags(vec![-1, 0, 1, 127, -128]);
        let numbers = Column::Numbers(vec![0.1, -0.0, f64::INFINITY, 1e-310]);
        for (column, is_flags, count) in [(flags, true, 5), (numbers, false, 4)] {
            let bytes = encode(&column, LABEL).expect("bytes");
            assert_eq!(decode(&bytes, is_flags, count, LABEL), Ok(column));
            let others = [
                Label {
                    key: "verdict/c/3/0",
                    ..LABEL
                },
                Label {
                    identity: "4567",
                    ..LABEL
                },
            ];
            for other in others {
                let error = decode(&bytes, is_flags, count, other).expect_err("another");
                assert!(error.contains("another"), "{error}");
            }
            for wrong in [0, 1, count - 1, count + 1, 1 << 40] {
                assert!(decode(&bytes, is_flags, wrong, LABEL).is_err());
            }
        }
    }

    #[test]
    fn every_changed_byte_and_every_truncation_is_detected() {
        let column = Column::Numbers((0..100).map(f64::from).collect());
        let bytes = encode(&column, LABEL).expect("bytes");
        for n in 0..bytes.len() {
            assert!(decode(&bytes[..n], false, 100, LABEL).is_err(), "{n}");
            let mut flipped = bytes.clone();
            flipped[n] ^= 0x10;
            assert!(decode(&flipped, false, 100, LABEL).is_err(), "{n}");
        }
    }

    /// Forged chunks with a valid checksum and label.
    #[test]
    fn an_oversized_chunk_is_not_unpacked() {
        let zeros = Column::Flags(vec![0; 1 << 26]);
        let bytes = encode(&zeros, LABEL).expect("bytes");
        assert!(bytes.len() < 1 << 20);
        assert!(decode(&bytes, true, 64, LABEL).is_err());
        // A second gzip stream after the first, which some readers would accept.
        let column = Column::Flags(vec![7; 64]);
        let mut twice = encode(&column, LABEL).expect("bytes");
        twice.truncate(twice.len() - CHECKSUM_BYTES);
        twice.extend_from_within(..);
        twice.extend(crc32c::crc32c(&twice).to_le_bytes());
        assert!(decode(&twice, true, 64, LABEL).is_err());
    }
}
