//! Text dumps of LAMMPS: `ITEM:` lines, then a row for each atom.

use super::{Opened, Source, Stamp};
use crate::columns::{Available, Dialect, Plan};
use crate::error::{FrameError, Place};
use crate::frame::{Bounds, Frame};
use crate::reading::{Quantity, Reading};
use crate::text::{Digits, Lines, Mark, Rows, words};
use std::path::PathBuf;

const HINT: &str = "give a text dump of the style custom; binary dumps are not read";

/// Contents of a frame before its rows.
#[derive(Default)]
struct Header {
    step: u64,
    time: Option<f64>,
    count: u64,
    bounds: Option<Bounds>,
    names: Vec<String>,
}

struct Dump {
    reading: Reading,
    paths: Vec<PathBuf>,
    /// File, place and number of each frame in its file.
    frames: Vec<(usize, Mark, usize)>,
    open: Option<(usize, Lines)>,
    plan: Plan,
    is_shuffled: bool,
}

pub(crate) fn open(paths: &[PathBuf], reading: &Reading) -> Result<Opened, FrameError> {
    let (mut frames, mut stamps, mut ignored) = (Vec::new(), Vec::new(), Vec::new());
    let mut plan: Option<Plan> = None;
    let mut digits = Digits::default();
    for (file, path) in paths.iter().enumerate() {
        let mut lines = Lines::open(path, reading.limits)?;
        for number in 0.. {
            let mark = lines.mark();
            let Some(header) = header(&mut lines, number)? else {
                if lines.mark() != mark {
                    ignored.push(cut(path, number));
                }
                break;
            };
            if header.count > reading.limits.particles as u64 {
                return Err(too_many(lines.place(), header.count, reading));
            }
            if plan.is_none() {
                let own = planned(&header, reading, &lines.place())?;
                digits.columns = own.columns_of(Quantity::Position);
                plan = Some(own);
            }
            // Rows in all parts of the frame: particles of the same part often have the same coordinates.
            let stride = header.count / Digits::ROWS + 1;
            let mut rest = header.count;
            let mut is_complete = true;
            while is_complete && rest > 0 {
                is_complete = lines.next_whole()?;
                digits.read(words(lines.line()));
                let skipped = (stride - 1).min(rest - 1);
                is_complete = is_complete && lines.skip(skipped)?;
                rest -= 1 + skipped;
            }
            if !is_complete {
                ignored.push(cut(path, number));
                break;
            }
            if frames.len() >= reading.limits.frames {
                return Err(FrameError::refused(
                    lines.place(),
                    format!("more than {} frames", reading.limits.frames),
                    "split the file, or write fewer frames",
                ));
            }
            frames.push((file, mark, number));
            stamps.push(Stamp {
                time: header
                    .time
                    .or_else(|| Some(header.step as f64 * reading.time_step?)),
                step: Some(header.step),
            });
        }
    }
    let Some(plan) = plan else {
        return Err(FrameError::wrong(
            Place::file(&paths[0]),
            "at least one complete frame",
            HINT,
        ));
    };
    let source = Dump {
        reading: reading.clone(),
        paths: paths.to_vec(),
        frames,
        open: None,
        plan: plan.clone(),
        is_shuffled: false,
    };
    Ok(Opened {
        source: Box::new(source),
        stamps,
        plan,
        digits: Some(digits.most).filter(|digits| *digits > 0),
        ignored,
    })
}

fn cut(path: &std::path::Path, frame: usize) -> String {
    format!("{} is cut off in the frame", Place::frame(path, frame))
}

fn too_many(place: Place, count: u64, reading: &Reading) -> FrameError {
    FrameError::refused(
        place,
        format!(
            "{count} particles; the limit is {}",
            reading.limits.particles
        ),
        "give a smaller region of the simulation, or raise the limit",
    )
}

fn planned(header: &Header, reading: &Reading, place: &Place) -> Result<Plan, FrameError> {
    let available = header.names.iter().map(Available::scalar).collect();
    Plan::of(available, reading, Dialect::Lammps, place)
}

/// Reads the lines before the rows, or returns `None` at the end of the file.
fn header(lines: &mut Lines, frame: usize) -> Result<Option<Header>, FrameError> {
    let mut header = Header::default();
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
                        header.count = text.parse().map_err(|_| wrong("the number of atoms"))?;
                        is_numbered = true;
                    }
                    "TIME" => {
                        header.time = Some(text.parse().map_err(|_| wrong("a time"))?);
                    }
                    // UNITS, and items of later versions with one line.
                    _ => {}
                }
            }
        }
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
    // The file has the bounds of the box with its tilted corners.
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

impl Dump {
    fn lines(&mut self, file: usize) -> Result<&mut Lines, FrameError> {
        if self.open.as_ref().is_none_or(|(own, _)| *own != file) {
            let mut lines = Lines::open(&self.paths[file], self.reading.limits)?;
            if self.is_shuffled {
                lines.unpack()?;
            }
            self.open = Some((file, lines));
        }
        match &mut self.open {
            Some((_, lines)) => Ok(lines),
            None => unreachable!("opened above"),
        }
    }
}

impl Source for Dump {
    fn shuffle(&mut self) -> Result<(), FrameError> {
        self.is_shuffled = true;
        self.open = None;
        Ok(())
    }

    fn read(&mut self, frame: usize) -> Result<Frame, FrameError> {
        let (file, mark, number) = self.frames[frame];
        let changed = |place| {
            FrameError::refused(
                place,
                "the file has changed since it was opened",
                "wait until the simulation has ended",
            )
        };
        let lines = self.lines(file)?;
        lines.go_to(mark)?;
        let start = Place {
            line: Some(mark.lines + 1),
            ..Place::frame(lines.path(), number)
        };
        let Some(header) = header(lines, number)? else {
            return Err(changed(start));
        };
        let names = lines.place();
        if !self.plan.is_for_names(&header.names) {
            self.plan = planned(&header, &self.reading, &names)?;
        }
        if header.count > self.reading.limits.particles as u64 {
            return Err(too_many(names, header.count, &self.reading));
        }
        let mut rows = Rows::new(self.plan.wanted());
        let images = ["ix", "iy", "iz"].map(|name| header.names.iter().position(|own| own == name));
        for column in images.into_iter().flatten() {
            rows.want(column);
        }
        let lines = self.lines(file)?;
        for _ in 0..header.count {
            if !lines.next_whole()? {
                return Err(changed(start));
            }
            rows.push(words(lines.line()), || lines.place())?;
        }
        let count = header.count as usize;
        let mut own = self
            .plan
            .frame(&rows.values, count, None)
            .map_err(|expected| FrameError::wrong(start.clone(), expected, HINT))?;
        let columns = self.plan.columns_of(Quantity::Position);
        unscale(&mut own, &header, &columns, &start)?;
        unwrap(&mut own, &header, &columns, &images, &rows.values);
        own.step = Some(header.step);
        own.source = start;
        own.bounds = header.bounds;
        Ok(own)
    }
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

/// Moves wrapped positions into their image, or marks them.
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
