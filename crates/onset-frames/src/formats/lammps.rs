//! Text dumps of LAMMPS: `ITEM:` lines, then a row for each atom.

use super::blocks::{self, Head};
use super::{Opened, Stamp};
use crate::columns::Dialect;
use crate::error::{FrameError, Place};
use crate::frame::{Bounds, Frame};
use crate::reading::Reading;
use crate::text::{Lines, words};
use std::path::PathBuf;

const HINT: &str = "give a text dump of the style custom; binary dumps are not supported";

/// Contents of a frame before its particle rows.
#[derive(Default)]
struct Header {
    step: u64,
    time: Option<f64>,
    count: u64,
    bounds: Option<Bounds>,
    names: Vec<String>,
}

/// Opens text dumps, and locates their complete frames.
pub(crate) fn open(paths: &[PathBuf], reading: &Reading) -> Result<Opened, FrameError> {
    blocks::open::<Header>(paths, reading)
}

impl Head for Header {
    const DIALECT: Dialect = Dialect::Lammps;
    const HINT: &'static str = HINT;

    fn read(lines: &mut Lines, frame: usize) -> Result<Option<Self>, FrameError> {
        let mut header = Self::default();
        let mut is_numbered = false;
        loop {
            if !lines.next_whole()? {
                return Ok(None);
            }
            let Some(item) = lines.line().strip_prefix(b"ITEM: ") else {
                if !is_numbered && lines.line().trim_ascii().is_empty() {
                    continue;
                }
                let expected = format!("`ITEM:` of frame {frame}");
                return Err(FrameError::unexpected(
                    lines.place(),
                    expected,
                    lines.line(),
                    HINT,
                ));
            };
            let item = String::from_utf8_lossy(item).into_owned();
            let mut parts = item.split_ascii_whitespace();
            match parts.next() {
                Some("ATOMS") => {
                    header.names = parts.map(str::to_owned).collect();
                    if !is_numbered || header.names.is_empty() {
                        return Err(FrameError::wrong(
                            lines.place(),
                            "`ITEM: NUMBER OF ATOMS` before, and names of columns after `ITEM: ATOMS`",
                            HINT,
                        ));
                    }
                    return Ok(Some(header));
                }
                Some("BOX") => {
                    let flags: Vec<&str> = parts.skip(1).collect();
                    match bounds(lines, &flags)? {
                        Some(bounds) => header.bounds = bounds,
                        None => return Ok(None),
                    }
                }
                name => {
                    let name = name.unwrap_or_default().to_owned();
                    if !lines.next_whole()? {
                        return Ok(None);
                    }
                    let text = String::from_utf8_lossy(lines.line().trim_ascii());
                    let wrong = |expected: &str| {
                        FrameError::unexpected(lines.place(), expected, text.as_bytes(), HINT)
                    };
                    match name.as_str() {
                        "TIMESTEP" => {
                            header.step = text
                                .parse()
                                .map_err(|_| wrong("the number of a time step"))?;
                        }
                        "NUMBER" => {
                            header.count =
                                text.parse().map_err(|_| wrong("the number of atoms"))?;
                            is_numbered = true;
                        }
                        "TIME" => {
                            header.time = Some(text.parse().map_err(|_| wrong("a time"))?);
                        }
                        // `UNITS`, and items of later versions, have one line, which is not used.
                        _ => {}
                    }
                }
            }
        }
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
            step: Some(self.step),
        }
    }

    fn extra(&self) -> Vec<usize> {
        self.images().into_iter().flatten().collect()
    }

    fn finish(
        &self,
        frame: &mut Frame,
        columns: &[usize],
        values: &[Vec<f64>],
    ) -> Result<(), FrameError> {
        let place = frame.source.clone();
        unscale(frame, self, columns, &place)?;
        unwrap(frame, self, columns, &self.images(), values);
        frame.bounds = self.bounds;
        Ok(())
    }
}

impl Header {
    /// Columns of the image flags.
    fn images(&self) -> [Option<usize>; 3] {
        ["ix", "iy", "iz"].map(|name| self.names.iter().position(|own| own == name))
    }
}

/// Reads the three lines of a box: `None` at the end of the file, `Some(None)` for a box of general vectors.
fn bounds(lines: &mut Lines, flags: &[&str]) -> Result<Option<Option<Bounds>>, FrameError> {
    let mut rows = [[0.0; 4]; 3];
    for row in &mut rows {
        if !lines.next_whole()? {
            return Ok(None);
        }
        let mut count = 0;
        for (value, word) in row.iter_mut().zip(words(lines.line())) {
            let number = std::str::from_utf8(word)
                .ok()
                .and_then(|word| word.parse().ok());
            *value = number.ok_or_else(|| {
                FrameError::unexpected(lines.place(), "the bounds of the box", word, HINT)
            })?;
            count += 1;
        }
        if count < 2 {
            return Err(FrameError::wrong(
                lines.place(),
                "two bounds of the box",
                HINT,
            ));
        }
    }
    if flags.contains(&"abc") {
        return Ok(Some(None));
    }
    let tilt = match flags.contains(&"xy") {
        true => rows.map(|row| row[2]),
        false => [0.0; 3],
    };
    let [xy, xz, yz] = tilt;
    let least = |list: &[f64]| list.iter().copied().fold(0.0, f64::min);
    let most = |list: &[f64]| list.iter().copied().fold(0.0, f64::max);
    let (mut low, mut high) = (rows.map(|row| row[0]), rows.map(|row| row[1]));
    // The bounds in the file enclose the tilted box.
    low[0] -= least(&[xy, xz, xy + xz]);
    high[0] -= most(&[xy, xz, xy + xz]);
    low[1] -= least(&[yz]);
    high[1] -= most(&[yz]);
    let boundary = flags.len().saturating_sub(3);
    let periodic = std::array::from_fn(|axis| flags.get(boundary + axis) == Some(&"pp"));
    Ok(Some(Some(Bounds {
        low,
        high,
        tilt,
        periodic,
    })))
}

/// Converts scaled coordinates to lengths in the box.
fn unscale(
    frame: &mut Frame,
    header: &Header,
    columns: &[usize],
    place: &Place,
) -> Result<(), FrameError> {
    let is_scaled = |column: &usize| {
        let name = header.names[*column].as_str();
        ["xs", "ys", "zs", "xsu", "ysu", "zsu"].contains(&name)
    };
    if !columns.iter().any(is_scaled) {
        return Ok(());
    }
    let bounds = header
        .bounds
        .filter(|_| columns.iter().all(is_scaled) && columns.len() == 3);
    let Some(bounds) = bounds else {
        return Err(FrameError::refused(
            place.clone(),
            "scaled coordinates without a box of three axes, or not for all axes",
            "write x y z or xu yu zu",
        ));
    };
    for position in &mut frame.position {
        let vector = bounds.vector(*position);
        *position = std::array::from_fn(|axis| bounds.low[axis] + vector[axis]);
    }
    Ok(())
}

/// Moves wrapped positions to their unwrapped image, or marks them as wrapped.
fn unwrap(
    frame: &mut Frame,
    header: &Header,
    columns: &[usize],
    images: &[Option<usize>; 3],
    values: &[Vec<f64>],
) {
    let is_unwrapped = |column: &usize| header.names[*column].ends_with('u');
    let Some(bounds) = header.bounds.filter(|_| !columns.iter().all(is_unwrapped)) else {
        return;
    };
    let axes = (0..columns.len().min(3)).filter(|axis| bounds.periodic[*axis]);
    frame.may_be_wrapped = axes.clone().any(|axis| images[axis].is_none());
    if frame.may_be_wrapped || axes.clone().next().is_none() {
        return;
    }
    for (item, position) in frame.position.iter_mut().enumerate() {
        let mut image = [0.0; 3];
        for axis in axes.clone() {
            image[axis] = images[axis].map_or(0.0, |column| values[column][item]);
        }
        let vector = bounds.vector(image);
        for axis in 0..3 {
            position[axis] += vector[axis];
        }
    }
}
