//! Tables whose first line names the columns: all frames with a time column, or one file for each frame.

use super::{Opened, Source, Stamp};
use crate::columns::{Available, Dialect, Plan};
use crate::error::{FrameError, Place};
use crate::frame::Frame;
use crate::reading::{Quantity, Reading};
use crate::text::{Digits, Lines, Mark, Rows, significant_digits, words};
use std::collections::HashMap;
use std::path::PathBuf;

const HINT: &str =
    "the first line names the columns, for example time,id,x,y; --columns assigns other names";
/// Maximum number of runs of rows with the same time.
const MAX_RUNS: usize = 4_000_000;

/// Consecutive rows of one frame.
#[derive(Clone, Copy, Debug)]
struct Run {
    start: Mark,
    rows: u64,
}

/// Separator of columns; `None` for blanks.
type Separator = Option<u8>;

struct Table {
    reading: Reading,
    paths: Vec<PathBuf>,
    /// File and rows of each frame.
    frames: Vec<(usize, Vec<Run>)>,
    /// Separator and column names of each file.
    heads: Vec<(Separator, Vec<String>)>,
    open: Option<(usize, Lines)>,
    plan: Plan,
    is_shuffled: bool,
}

/// Splits a line at the separator.
fn split(line: &[u8], separator: Separator) -> Box<dyn Iterator<Item = &[u8]> + '_> {
    match separator {
        Some(separator) => Box::new(
            line.split(move |byte| *byte == separator)
                .map(<[u8]>::trim_ascii),
        ),
        None => Box::new(words(line)),
    }
}

fn separator(line: &[u8]) -> Separator {
    [b'\t', b';', b',']
        .into_iter()
        .find(|byte| line.contains(byte))
}

fn names(line: &[u8], separator: Separator) -> Vec<String> {
    let name = |word: &[u8]| {
        let word = String::from_utf8_lossy(word);
        word.trim().trim_matches('"').to_owned()
    };
    split(line, separator).map(name).collect()
}

/// Advances to the next line that is neither empty nor a comment.
fn next_row(lines: &mut Lines) -> Result<bool, FrameError> {
    while lines.next()? {
        let line = lines.line().trim_ascii();
        if !line.is_empty() && !line.starts_with(b"#") {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Reads the names of the columns from the first line, or from the comment before the numbers. Leaves the reader at the first row.
fn head(lines: &mut Lines) -> Result<(Separator, Vec<String>), FrameError> {
    let mut comment: Option<Vec<u8>> = None;
    let mut mark = lines.mark();
    while lines.next()? {
        let line = lines
            .line()
            .strip_prefix(b"\xef\xbb\xbf")
            .unwrap_or(lines.line());
        let line = line.trim_ascii();
        if let Some(text) = line.strip_prefix(b"#") {
            comment = Some(text.trim_ascii().to_vec());
        } else if !line.is_empty() {
            let separator = separator(line);
            let is_row = split(line, separator).all(|word| significant_digits(word).is_some());
            if !is_row {
                return Ok((separator, names(line, separator)));
            }
            let count = split(line, separator).count();
            let named = comment.map(|text| names(&text, self::separator(&text)));
            return match named.filter(|names| names.len() == count) {
                Some(names) => {
                    lines.go_to(mark)?;
                    Ok((separator, names))
                }
                None => Err(FrameError::unexpected(
                    lines.place(),
                    "the names of columns",
                    line,
                    HINT,
                )),
            };
        }
        mark = lines.mark();
    }
    Err(FrameError::wrong(
        lines.place(),
        "a line with the names of columns",
        HINT,
    ))
}

fn planned(names: &[String], reading: &Reading, place: &Place) -> Result<Plan, FrameError> {
    let available = names.iter().map(Available::scalar).collect();
    Plan::of(available, reading, Dialect::Plain, place)
}

pub(crate) fn open(paths: &[PathBuf], reading: &Reading) -> Result<Opened, FrameError> {
    let mut table = Table {
        reading: reading.clone(),
        paths: paths.to_vec(),
        frames: Vec::new(),
        heads: Vec::new(),
        open: None,
        plan: Plan::default(),
        is_shuffled: false,
    };
    let (mut stamps, mut ignored, mut first) = (Vec::new(), Vec::new(), None);
    let mut digits = Digits::default();
    let mut runs = 0;
    for (file, path) in paths.iter().enumerate() {
        let mut lines = Lines::open(path, reading.limits)?;
        let (separator, names) = head(&mut lines)?;
        let plan = planned(&names, reading, &lines.place())?;
        digits.columns = plan.columns_of(Quantity::Position);
        let time = plan.columns_of(Quantity::Time).first().copied();
        let mut known: HashMap<u64, usize> = HashMap::new();
        // Frame and time of the last row.
        let mut current: Option<(usize, f64)> = None;
        let mut start = lines.mark();
        while next_row(&mut lines)? {
            let line = lines.line();
            if !lines.is_whole() && split(line, separator).count() < names.len() {
                ignored.push(format!("{} is cut off", lines.place()));
                break;
            }
            let value = match time {
                Some(column) => {
                    let word = split(line, separator).nth(column).unwrap_or_default();
                    let value = std::str::from_utf8(word).ok();
                    let value = value.and_then(|word| word.parse::<f64>().ok());
                    let value = value.filter(|value| value.is_finite());
                    value.ok_or_else(|| {
                        FrameError::unexpected(lines.place(), "a time", word, HINT)
                    })?
                }
                None => 0.0,
            };
            let is_same = current.is_some_and(|(_, own)| own == value);
            if !is_same {
                let count = table.frames.len();
                let frame = *known.entry((value + 0.0).to_bits()).or_insert(count);
                if frame == count {
                    table.frames.push((file, Vec::new()));
                    stamps.push(Stamp {
                        time: time.map(|_| value),
                        step: None,
                    });
                }
                runs += 1;
                if runs > MAX_RUNS || count >= reading.limits.frames {
                    return Err(FrameError::refused(
                        lines.place(),
                        "too many changes of the time from row to row",
                        "sort the rows by time",
                    ));
                }
                current = Some((frame, value));
                table.frames[frame].1.push(Run { start, rows: 0 });
            }
            if let Some((frame, _)) = current
                && let Some(run) = table.frames[frame].1.last_mut()
            {
                run.rows += 1;
                if run.rows % Digits::STRIDE == 1 {
                    digits.read(split(lines.line(), separator));
                }
            }
            start = lines.mark();
        }
        table.heads.push((separator, names));
        first.get_or_insert(plan);
    }
    let Some(plan) = first.filter(|_| !table.frames.is_empty()) else {
        return Err(FrameError::wrong(
            Place::file(&paths[0]),
            "at least one row",
            HINT,
        ));
    };
    table.plan = plan.clone();
    table.is_shuffled = table.frames.iter().any(|(_, runs)| runs.len() > 1);
    Ok(Opened {
        source: Box::new(table),
        stamps,
        plan,
        digits: Some(digits.most).filter(|digits| *digits > 0),
        ignored,
    })
}

impl Source for Table {
    fn shuffle(&mut self) -> Result<(), FrameError> {
        self.is_shuffled = true;
        self.open = None;
        Ok(())
    }

    fn read(&mut self, frame: usize) -> Result<Frame, FrameError> {
        let (file, runs) = &self.frames[frame];
        let path = &self.paths[*file];
        let (separator, names) = &self.heads[*file];
        let mut lines = match self.open.take() {
            Some((own, lines)) if own == *file => lines,
            _ => {
                let mut lines = Lines::open(path, self.reading.limits)?;
                if self.is_shuffled {
                    lines.unpack()?;
                }
                lines
            }
        };
        if !self.plan.is_for_names(names) {
            self.plan = planned(names, &self.reading, &Place::file(path))?;
        }
        let rows: u64 = runs.iter().map(|run| run.rows).sum();
        if rows > self.reading.limits.particles as u64 {
            return Err(FrameError::refused(
                Place::file(path),
                format!(
                    "{rows} particles in a frame; the limit is {}",
                    self.reading.limits.particles
                ),
                "name the column of the time with --columns time=NAME",
            ));
        }
        let mut values = Rows::new(self.plan.wanted());
        for run in runs {
            lines.go_to(run.start)?;
            for _ in 0..run.rows {
                if !next_row(&mut lines)? {
                    return Err(FrameError::refused(
                        lines.place(),
                        "the file has changed since it was opened",
                        "wait until the simulation has ended",
                    ));
                }
                values.push(split(lines.line(), *separator), || lines.place())?;
            }
        }
        let place = Place {
            line: runs.first().map(|run| run.start.lines + 1),
            ..Place::file(path)
        };
        let mut read = self
            .plan
            .frame(&values.values, rows as usize, None)
            .map_err(|expected| FrameError::wrong(place.clone(), expected, HINT))?;
        if let (Some(again), Some(id)) = (runs.get(1), read.doubled().first()) {
            let again = Place {
                line: Some(again.start.lines + 1),
                ..Place::file(path)
            };
            return Err(FrameError::refused(
                again,
                format!(
                    "a time that was already written begins again, with particle {id} a second time"
                ),
                "a run that was restarted repeats times: keep the rows of one of both runs",
            ));
        }
        read.source = place;
        self.open = Some((*file, lines));
        Ok(read)
    }
}
