//! Series of frames: recognition of the format, order in time, and reading.

use crate::columns::{ColumnUse, Plan};
use crate::error::{FrameError, brief};
use crate::formats::{Source, Stamp, hdf5, lammps, numpy, table, vtk, xyz};
use crate::frame::Frame;
use crate::input::{MARK, other_encoding};
use crate::reading::{Quantity, Reading};
use crate::text::head;
use std::cmp::Ordering;
use std::fmt;
use std::path::{Path, PathBuf};

/// Format of files, recognized from their contents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Text dump of LAMMPS.
    Lammps,
    /// Unstructured grids, polygonal data and collections of VTK in XML.
    Vtk,
    /// Arrays of NumPy, one file or an archive of several.
    Numpy,
    /// Data sets of HDF5.
    Hdf5,
    /// Blocks of particles in extended XYZ.
    Xyz,
    /// Table with names of columns.
    Table,
}

impl Format {
    /// Returns the name of the format, as used in messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lammps => "LAMMPS dump",
            Self::Vtk => "VTK XML",
            Self::Numpy => "NumPy arrays",
            Self::Hdf5 => "HDF5",
            Self::Xyz => "extended XYZ",
            Self::Table => "table",
        }
    }

    /// Recognizes the format of a file.
    fn of(path: &Path) -> Result<Self, FrameError> {
        let start = head(path, 512)?;
        let text = start.strip_prefix(MARK).unwrap_or(&start);
        let text = text.trim_ascii_start();
        let refused = |what: &str, hint: &str| {
            let place = crate::error::Place::file(path);
            Err(FrameError::refused(place, what, hint))
        };
        let no_text = "save it as UTF-8";
        match text {
            _ if other_encoding(&start) == Some("UTF-16") => refused("it is UTF-16", no_text),
            _ if other_encoding(&start) == Some("UTF-32") => refused("it is UTF-32", no_text),
            [] => refused("the file is empty", "give an output file of a simulation"),
            _ if text.starts_with(b"\x93NUMPY") || text.starts_with(b"PK\x03\x04") => {
                Ok(Self::Numpy)
            }
            _ if text.starts_with(b"<") => Ok(Self::Vtk),
            _ if text.contains(&b'\r') && !text.contains(&b'\n') && !text.contains(&0) => refused(
                "the lines end with carriage returns",
                "save the file with line feeds",
            ),
            _ if text.starts_with(b"ITEM:") => Ok(Self::Lammps),
            _ if text.starts_with(b"# vtk DataFile") => refused(
                "the file has the legacy format of VTK",
                "convert it to .vtu, for example with meshio or ParaView",
            ),
            _ if start.starts_with(b"\x89HDF\r\n\x1a\n") => Ok(Self::Hdf5),
            _ if start.starts_with(b"\x28\xb5\x2f\xfd") => refused(
                "the file is compressed with zstd",
                "decompress it, or compress it with gzip",
            ),
            _ if text.contains(&0) || start.starts_with(b"\x80") => refused(
                "the file is binary, of an unknown format",
                "known formats: LAMMPS text dump, VTK XML, NumPy arrays without pickle, HDF5, extended XYZ, CSV",
            ),
            _ if xyz::is_start(text) => Ok(Self::Xyz),
            _ => Ok(Self::Table),
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// Properties of the files that were recognized when they were opened.
#[derive(Clone, Debug, PartialEq)]
pub struct Recognized {
    /// Format of the files.
    pub format: Format,
    /// Files named by the user, with wildcards expanded.
    pub files: Vec<PathBuf>,
    /// Number of frames that will be read; `None` if it is unknown before they are read.
    pub frames: Option<usize>,
    /// Columns of the first frame with their use.
    pub columns: Vec<ColumnUse>,
    /// Significant digits of positions: as written in text, 7 for numbers of 32 bits, `None` for numbers of 64 bits.
    pub digits: Option<u32>,
    /// Descriptions of contents that are skipped, as clauses.
    pub ignored: Vec<String>,
    /// Assumptions about contents, as clauses.
    pub assumed: Vec<String>,
}

/// Frames of particles in order of time.
pub struct Series {
    source: Box<dyn Source>,
    recognized: Recognized,
    /// Frames of the source in order of time, with their times.
    frames: Vec<(usize, Stamp)>,
    next: usize,
    /// Whether displacements are added to the positions in the file, which are reference positions.
    is_reference: bool,
}

impl fmt::Debug for Series {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Series")
            .field("recognized", &self.recognized)
            .field("next", &self.next)
            .finish_non_exhaustive()
    }
}

impl Series {
    /// Opens the files of a series. The last part of a path may contain the wildcards `*` and `?`.
    ///
    /// # Errors
    /// [`FrameError`] for files that cannot be read, of an unknown format, or without positions.
    pub fn open(paths: &[PathBuf], reading: &Reading) -> Result<Self, FrameError> {
        let mut files = Vec::new();
        for path in paths {
            expand(path, &mut files)?;
        }
        if files.len() > reading.limits.frames {
            return Err(FrameError::Request {
                what: format!("more than {} files", reading.limits.frames),
                hint: "name fewer files".to_owned(),
            });
        }
        let Some(first) = files.first() else {
            return Err(FrameError::Request {
                what: "no files".to_owned(),
                hint: "name the output files of a simulation".to_owned(),
            });
        };
        let format = Format::of(first)?;
        for path in &files[1..] {
            let own = Format::of(path)?;
            if own != format {
                return Err(FrameError::Request {
                    what: format!(
                        "{} has the format {format}, {} the format {own}",
                        first.display(),
                        path.display()
                    ),
                    hint: "name files of one format".to_owned(),
                });
            }
        }
        files.sort_by(|a, b| natural(a, b));
        let files = of_one_body(files, reading)?;
        let opened = match format {
            Format::Lammps => lammps::open(&files, reading),
            Format::Vtk => vtk::open(&files, reading),
            Format::Numpy => numpy::open(&files, reading),
            Format::Hdf5 => hdf5::open(&files, reading),
            Format::Xyz => xyz::open(&files, reading),
            Format::Table => table::open(&files, reading),
        }?;
        let mut ignored = opened.ignored;
        let mut source = opened.source;
        let frames = ordered(&opened.stamps, &mut ignored);
        let frames: Vec<(usize, Stamp)> =
            reading.frames.of(frames.len()).map(|n| frames[n]).collect();
        if frames.is_empty() {
            return Err(FrameError::Request {
                what: format!("no frame out of {} is left", opened.stamps.len()),
                hint: "choose another range of frames".to_owned(),
            });
        }
        if frames.windows(2).any(|pair| pair[0].0 > pair[1].0) {
            source.shuffle()?;
        }
        let mut series = Self {
            source,
            recognized: Recognized {
                format,
                files,
                frames: Some(frames.len()),
                columns: opened.plan.listed(),
                digits: opened.digits,
                ignored,
                assumed: Vec::new(),
            },
            frames,
            next: 0,
            is_reference: false,
        };
        series.find_reference(&opened.plan)?;
        Ok(series)
    }

    /// Format, columns and other properties.
    pub fn recognized(&self) -> &Recognized {
        &self.recognized
    }

    /// Checks the part of a file after the last frame that was read, for readers that end early. Only formats with checksums read it.
    ///
    /// # Errors
    /// [`FrameError`] if a checksum is wrong or the file cannot be read.
    pub fn check_rest(&mut self) -> Result<(), FrameError> {
        self.source.check_rest()
    }

    /// Returns to the first frame.
    pub fn rewind(&mut self) {
        self.next = 0;
    }

    /// Times and steps of the frames, in order.
    pub fn times(&self) -> impl ExactSizeIterator<Item = (Option<f64>, Option<u64>)> {
        self.frames
            .iter()
            .map(|(_, stamp)| (stamp.time, stamp.step))
    }

    /// Reads a frame by its number in order of time.
    ///
    /// # Errors
    /// [`FrameError`] for a frame that cannot be read, or a number beyond the last.
    pub fn frame(&mut self, number: usize) -> Result<Frame, FrameError> {
        let Some((place, stamp)) = self.frames.get(number).copied() else {
            return Err(FrameError::Request {
                what: format!("no frame {number}; there are {}", self.frames.len()),
                hint: "frames are numbered from 0".to_owned(),
            });
        };
        let mut frame = self.source.read(place)?;
        frame.time = stamp.time.or(frame.time);
        frame.step = stamp.step.or(frame.step);
        if self.is_reference {
            let reference = std::mem::take(&mut frame.position);
            let moved = reference.iter().zip(frame.displacement.iter().flatten());
            frame.position = moved
                .map(|(x, u)| std::array::from_fn(|axis| x[axis] + u[axis]))
                .collect();
            frame.reference = Some(reference);
        }
        Ok(frame)
    }

    /// Determines whether the positions in the file are reference positions: they do not move, and the file has displacements.
    fn find_reference(&mut self, plan: &Plan) -> Result<(), FrameError> {
        let given = |quantity| {
            let list = &self.recognized.columns;
            list.iter()
                .any(|own| own.quantity == Some(quantity) && own.is_given)
        };
        let is_possible = !plan.columns_of(Quantity::Displacement).is_empty()
            && !plan.columns_of(Quantity::Position).is_empty()
            && plan.columns_of(Quantity::Reference).is_empty()
            && !given(Quantity::Position);
        if !is_possible {
            return Ok(());
        }
        let first = self.frame(0)?;
        let last = self.frame(self.frames.len() - 1)?;
        self.is_reference = first.position == last.position;
        self.recognized.assumed.push(match self.is_reference {
            true => "positions are reference positions, because they are the same in the first and the last frame; displacements are added".to_owned(),
            false => "positions are current positions, because they move; displacements are subtracted for reference positions".to_owned(),
        });
        Ok(())
    }
}

impl Iterator for Series {
    type Item = Result<Frame, FrameError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.next >= self.frames.len() {
            return None;
        }
        let frame = self.frame(self.next);
        self.next = match frame {
            Ok(_) => self.next + 1,
            Err(_) => self.frames.len(),
        };
        Some(frame)
    }
}

/// Frames in order of time, or of steps if some frames have no time; a frame whose time occurred before is skipped. `ignored` receives notes on frames
/// in another order and on repeated times.
fn ordered(stamps: &[Stamp], ignored: &mut Vec<String>) -> Vec<(usize, Stamp)> {
    let mut frames: Vec<(usize, Stamp)> = stamps.iter().copied().enumerate().collect();
    let by_time = stamps.iter().all(|own| own.time.is_some());
    let by_step = stamps.iter().all(|own| own.step.is_some());
    let compare = |a: &Stamp, b: &Stamp| match (by_time, by_step) {
        (true, _) => {
            let [a, b] = [a, b].map(|own| own.time.unwrap_or_default());
            a.partial_cmp(&b).unwrap_or_else(|| a.total_cmp(&b))
        }
        (false, true) => a.step.cmp(&b.step),
        (false, false) => Ordering::Less,
    };
    if by_time || by_step {
        let is_before = |pair: &[Stamp]| compare(&pair[1], &pair[0]) == Ordering::Less;
        match stamps.windows(2).filter(|pair| is_before(pair)).count() {
            0 => {}
            count => ignored.push(format!(
                "the frames are not in order of {}, which decreases {}: they are sorted",
                if by_time { "time" } else { "steps" },
                match count {
                    1 => "once".to_owned(),
                    count => format!("{count} times"),
                }
            )),
        }
        frames.sort_by(|(_, a), (_, b)| compare(a, b));
        let count = frames.len();
        // A time that is not a number is an error of its frame, and repeats no other time.
        let is_number = |own: &Stamp| own.time.is_none_or(|time| !time.is_nan());
        frames.dedup_by(|(_, b), (_, a)| compare(a, b) == Ordering::Equal && is_number(a));
        ignored.extend(told_repeats(count - frames.len()));
    }
    frames
}

/// Note on skipped frames that repeat the time of another frame; `None` without such frames.
pub fn told_repeats(count: usize) -> Option<String> {
    match count {
        0 => None,
        1 => Some("a frame that repeats the time of another frame is skipped".to_owned()),
        _ => Some(format!(
            "{count} frames that repeat the time of another frame are skipped"
        )),
    }
}

/// Compares names, with the numbers in them compared by value.
fn natural(a: &Path, b: &Path) -> Ordering {
    let parts = |path: &Path| {
        let text = path.to_string_lossy().into_owned();
        let mut parts: Vec<(String, u128)> = vec![(String::new(), 0)];
        let mut is_number = false;
        for letter in text.chars() {
            let digit = letter.to_digit(10);
            if is_number && digit.is_none() {
                parts.push((String::new(), 0));
            }
            is_number = digit.is_some();
            if let Some((word, number)) = parts.last_mut() {
                match digit {
                    Some(digit) => *number = number.saturating_mul(10).saturating_add(digit.into()),
                    None => word.push(letter),
                }
            }
        }
        (parts, text)
    };
    parts(a).cmp(&parts(b))
}

/// Name of a file without its last number, which counts frames.
fn stem(path: &Path) -> String {
    let name = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    // The 5 of `.hdf5` is not the number of a frame, unlike the 5 of `dump.5`.
    let has_letters = |ending: &str| ending.contains(|letter: char| letter.is_alphabetic());
    let counted = name.rfind('.').filter(|dot| has_letters(&name[*dot..]));
    let counted = &name[..counted.unwrap_or(name.len())];
    let Some(end) = counted.rfind(|letter: char| letter.is_ascii_digit()) else {
        return name;
    };
    let start = name[..end].rfind(|letter: char| !letter.is_ascii_digit());
    let start = start.map_or(0, |place| {
        place + name[place..].chars().next().map_or(1, char::len_utf8)
    });
    format!("{}*{}", &name[..start], &name[end + 1..])
}

/// Files of the group that the user chose. Files whose names differ in more than a number belong to several bodies.
fn of_one_body(files: Vec<PathBuf>, reading: &Reading) -> Result<Vec<PathBuf>, FrameError> {
    let stems = |files: &[PathBuf]| {
        let mut stems: Vec<String> = files.iter().map(|path| stem(path)).collect();
        stems.sort();
        stems.dedup();
        stems
    };
    if stems(&files).len() < 2 {
        return Ok(files);
    }
    let group = reading.group.as_deref().unwrap_or_default();
    let chosen: Vec<PathBuf> = files
        .iter()
        .filter(|path| stem(path).contains(group))
        .cloned()
        .collect();
    match stems(&chosen).as_slice() {
        [_] => Ok(chosen),
        several => Err(FrameError::Request {
            what: format!("files of {} bodies or runs", stems(&files).len()),
            hint: match several {
                [first, second, ..] => format!(
                    "name the files of one, or choose it by a part of its name: {}, {}",
                    brief(first),
                    brief(second)
                ),
                _ => "no file has the chosen group in its name".to_owned(),
            },
        }),
    }
}

/// Adds the files that match a path with wildcards in its last part.
fn expand(path: &Path, files: &mut Vec<PathBuf>) -> Result<(), FrameError> {
    let name = path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    if !name.contains(['*', '?']) || path.exists() {
        files.push(path.to_owned());
        return Ok(());
    }
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let failed = |error| FrameError::unreadable(folder, error);
    let before = files.len();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        let own = entry.file_name().to_string_lossy().into_owned();
        if fits(&name, &own) {
            files.push(path.with_file_name(entry.file_name()));
        }
    }
    match files.len() == before {
        true => Err(FrameError::Request {
            what: format!("no file fits {}", path.display()),
            hint: "check the folder and the pattern".to_owned(),
        }),
        false => Ok(()),
    }
}

/// Returns true if a name fits a pattern; the work is bounded by the product of the lengths.
fn fits(pattern: &str, name: &str) -> bool {
    let name: Vec<char> = name.chars().collect();
    // Lengths of the prefixes of the name that match the part of the pattern before the current character.
    let mut reached = vec![false; name.len() + 1];
    reached[0] = true;
    for letter in pattern.chars() {
        let mut next = vec![false; name.len() + 1];
        for place in 0..=name.len() {
            if !reached[place] {
                continue;
            }
            match letter {
                '*' => next[place..].fill(true),
                _ => {
                    if name
                        .get(place)
                        .is_some_and(|own| letter == '?' || *own == letter)
                    {
                        next[place + 1] = true;
                    }
                }
            }
        }
        reached = next;
    }
    reached[name.len()]
}

#[cfg(test)]
mod tests {
    use super::{Stamp, fits, natural, ordered, stem};
    use std::path::{Path, PathBuf};

    #[test]
    fn a_time_that_is_not_a_number_repeats_no_other_time() {
        for (times, count) in [
            ([0.0, f64::NAN, 1.0], 3),
            ([0.0, f64::NAN, f64::NAN], 3),
            ([0.0, 1.0, 1.0], 2),
        ] {
            let stamps = times.map(|time| Stamp {
                time: Some(time),
                step: None,
            });
            let mut ignored = Vec::new();
            assert_eq!(ordered(&stamps, &mut ignored).len(), count, "{times:?}");
            let is_told = ignored.iter().any(|note| note.contains("repeats the time"));
            assert_eq!(is_told, count == 2, "{times:?}: {ignored:?}");
        }
    }

    #[test]
    fn wildcards_match_any_letters() {
        assert!(fits("dump.*.gz", "dump.100.gz"));
        assert!(fits("f???.vtu", "f001.vtu"));
        assert!(!fits("f?.vtu", "f01.vtu"));
        assert!(!fits("dump.*", "log.lammps"));
    }

    #[test]
    fn file_names_are_sorted_by_their_numbers() {
        let mut names: Vec<PathBuf> = ["f10.vtu", "f9.vtu", "f100.vtu"].map(PathBuf::from).into();
        names.sort_by(|a, b| natural(a, b));
        assert_eq!(names, ["f9.vtu", "f10.vtu", "f100.vtu"].map(PathBuf::from));
    }

    #[test]
    fn the_last_number_of_a_file_name_counts_frames() {
        assert_eq!(stem(Path::new("a2/plate3_000120.vtp")), "plate3_*.vtp");
        assert_eq!(stem(Path::new("é7")), "é*");
        assert_eq!(stem(Path::new("run.dump")), "run.dump");
    }
}
