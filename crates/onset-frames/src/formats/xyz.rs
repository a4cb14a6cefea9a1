//! Extended XYZ: for each frame the number of particles, a line of `KEY=VALUE`, and a row for each particle.

use super::blocks::{self, Head};
use super::{Opened, Stamp};
use crate::columns::Dialect;
use crate::error::FrameError;
use crate::frame::{Bounds, Frame};
use crate::reading::Reading;
use crate::text::Lines;
use std::path::PathBuf;

const HINT: &str =
    "the line after the number of particles has Properties=species:S:1:pos:R:3:... and Time=...";
/// Columns of a file without properties.
const PLAIN: &str = "species:S:1:pos:R:3";
/// Maximum number of columns of one property.
const MAX_COMPONENTS: usize = 64;

/// Contents of a frame before its particle rows.
struct Header {
    count: u64,
    time: Option<f64>,
    step: Option<u64>,
    bounds: Option<Bounds>,
    names: Vec<String>,
}

/// Returns true for a line with one whole number, followed by a text without the markers of other formats.
pub(crate) fn is_start(text: &[u8]) -> bool {
    let mut lines = text.split(|byte| *byte == b'\n');
    let is_count = |line: &[u8]| {
        let line = line.trim_ascii();
        !line.is_empty() && line.iter().all(u8::is_ascii_digit)
    };
    lines.next().is_some_and(is_count) && lines.next().is_some_and(|line| !is_count(line))
}

/// Pairs of a line `KEY=VALUE KEY="VALUE WITH BLANKS" ...`.
fn pairs(line: &str) -> Vec<(String, String)> {
    let mut pairs = Vec::new();
    let mut rest = line.trim_start();
    while let Some((key, after)) = rest.split_once('=') {
        // Words without a value may precede the key.
        let key = key.split_ascii_whitespace().last().unwrap_or_default();
        let (value, next) = match after.strip_prefix(['"', '\'']) {
            Some(quoted) => {
                let mark = after.chars().next().unwrap_or('"');
                quoted.split_once(mark).unwrap_or((quoted, ""))
            }
            None => after.split_once([' ', '\t']).unwrap_or((after, "")),
        };
        pairs.push((key.to_ascii_lowercase(), value.to_owned()));
        rest = next;
    }
    pairs
}

/// Names of the columns of `NAME:TYPE:NUMBER:...`; names of text columns begin with `text:`.
fn names(properties: &str) -> Option<Vec<String>> {
    let parts: Vec<&str> = properties.split(':').collect();
    let mut names = Vec::new();
    for part in parts.chunks(3) {
        let [name, kind, count] = part else {
            return None;
        };
        let count: usize = count.trim().parse().ok()?;
        if count > MAX_COMPONENTS {
            return None;
        }
        let endings: &[&str] = match count {
            2 | 3 => &["x", "y", "z"][..count],
            9 => &["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"],
            _ => &[],
        };
        for n in 0..count {
            names.push(match (*kind, count, endings.get(n)) {
                ("S" | "L", ..) => format!("text:{name}"),
                (_, 1, _) => (*name).to_owned(),
                (.., Some(ending)) => format!("{name}_{ending}"),
                (.., None) => format!("{name}_{}", n + 1),
            });
        }
    }
    Some(names)
}

/// Box of an orthogonal lattice at the origin.
fn bounds(lattice: &str, periodic: Option<&str>) -> Option<Bounds> {
    let numbers = lattice.split_ascii_whitespace().map(str::parse::<f64>);
    let numbers: Vec<f64> = numbers.collect::<Result<_, _>>().ok()?;
    let [a, _, _, _, b, _, _, _, c] = numbers[..] else {
        return None;
    };
    let sides: f64 = numbers.iter().map(|x| x.abs()).sum();
    let is_orthogonal = sides == a.abs() + b.abs() + c.abs();
    let flags: Vec<&str> = periodic
        .unwrap_or("T T T")
        .split_ascii_whitespace()
        .collect();
    is_orthogonal.then(|| Bounds {
        high: [a, b, c],
        periodic: std::array::from_fn(|axis| {
            flags
                .get(axis)
                .is_some_and(|flag| flag.starts_with(['T', 't', '1']))
        }),
        ..Bounds::default()
    })
}

/// Opens files of extended XYZ.
pub(crate) fn open(paths: &[PathBuf], reading: &Reading) -> Result<Opened, FrameError> {
    blocks::open::<Header>(paths, reading)
}

impl Head for Header {
    const DIALECT: Dialect = Dialect::Plain;
    const HINT: &'static str = HINT;

    fn read(lines: &mut Lines, _number: usize) -> Result<Option<Self>, FrameError> {
        loop {
            if !lines.next_whole()? {
                return Ok(None);
            }
            if !lines.line().trim_ascii().is_empty() {
                break;
            }
        }
        let text = lines
            .line()
            .strip_prefix(b"\xef\xbb\xbf")
            .unwrap_or(lines.line());
        let count = std::str::from_utf8(text).ok();
        let count = count.and_then(|text| text.trim().parse::<u64>().ok());
        let count = count.ok_or_else(|| {
            FrameError::unexpected(lines.place(), "the number of particles", lines.line(), HINT)
        })?;
        if !lines.next_whole()? {
            return Ok(None);
        }
        let text = String::from_utf8_lossy(lines.line()).into_owned();
        let pairs = pairs(&text);
        let value = |name: &str| {
            let found = pairs.iter().find(|(key, _)| key == name);
            found.map(|(_, value)| value.as_str())
        };
        let properties = value("properties").unwrap_or(PLAIN);
        let names = names(properties).ok_or_else(|| {
            FrameError::unexpected(
                lines.place(),
                "Properties=NAME:TYPE:NUMBER:...",
                properties.as_bytes(),
                HINT,
            )
        })?;
        let time = value("time").and_then(|time| time.trim().parse::<f64>().ok());
        let step = ["step", "timestep"].into_iter().find_map(value);
        Ok(Some(Header {
            count,
            time: time.filter(|time| time.is_finite()),
            step: step.and_then(|step| step.trim().parse().ok()),
            bounds: value("lattice").and_then(|lattice| bounds(lattice, value("pbc"))),
            names,
        }))
    }

    fn count(&self) -> u64 {
        self.count
    }

    fn names(&self) -> &[String] {
        &self.names
    }

    fn stamp(&self) -> Stamp {
        Stamp {
            time: self.time,
            step: self.step,
        }
    }

    fn finish(
        &self,
        frame: &mut Frame,
        _columns: &[usize],
        _values: &[Vec<f64>],
    ) -> Result<(), FrameError> {
        let bounds = self.bounds.as_ref();
        frame.may_be_wrapped = bounds.is_some_and(|own| own.periodic.contains(&true));
        frame.bounds = self.bounds;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::{bounds, is_start, names, pairs};

    #[test]
    fn the_properties_key_names_the_columns() {
        let found = names("species:S:1:pos:R:3:F:R:9:id:I:1").expect("properties");
        assert_eq!(
            found[..5],
            ["text:species", "pos_x", "pos_y", "pos_z", "F_xx"]
        );
        assert_eq!(found.last().map(String::as_str), Some("id"));
        assert!(names("pos:R").is_none() && names("pos:R:99999999").is_none());
    }

    #[test]
    fn values_with_blanks_are_quoted() {
        let line = "Lattice=\"1 0 0 0 2 0 0 0 3\" flag Properties=pos:R:3 Time=2.5 pbc='T F F'";
        let found = pairs(line);
        assert_eq!(found[0].1, "1 0 0 0 2 0 0 0 3");
        assert_eq!(found[2], ("time".to_owned(), "2.5".to_owned()));
        let bounds = bounds(&found[0].1, Some(&found[3].1)).expect("a box");
        assert_eq!(bounds.high, [1.0, 2.0, 3.0]);
        assert_eq!(bounds.periodic, [true, false, false]);
    }

    #[test]
    fn a_frame_begins_with_a_count_and_a_line_of_properties() {
        assert!(is_start(b"12\nProperties=pos:R:3\n"));
        assert!(!is_start(b"1\n2\n") && !is_start(b"x,y\n1,2\n") && !is_start(b"12"));
    }
}
