//! Arrays of NumPy: `.npz` archives and single `.npy` files.
//!
//! Frames are the first axis of arrays, or each file is one frame. Arrays of objects are pickled programs; they are refused without being read.

use super::zip::{Member, members};
use super::{Opened, Source, Stamp};
use crate::columns::{Available, Dialect, Plan, Support};
use crate::error::{FrameError, Place, brief, is_position};
use crate::frame::Frame;
use crate::input::regular;
use crate::reading::{Quantity, Reading};
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

const HINT: &str = "save plain arrays with numpy.savez";
/// Maximum number of arrays in a file.
const MAX_ARRAYS: usize = 1000;

/// Type of the numbers in an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Number {
    pub kind: Kind,
    pub size: usize,
    pub is_big: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Float,
    Signed,
    Unsigned,
}

impl Number {
    /// Appends the numbers in a slice of bytes whose length is a multiple of their size.
    pub(super) fn decode(self, bytes: &[u8], to: &mut Vec<f64>) {
        macro_rules! each {
            ($type:ty) => {
                for item in bytes.chunks_exact(size_of::<$type>()) {
                    let Ok(item) = item.try_into() else { continue };
                    to.push(match self.is_big {
                        true => <$type>::from_be_bytes(item),
                        false => <$type>::from_le_bytes(item),
                    } as f64);
                }
            };
        }
        match (self.kind, self.size) {
            (Kind::Float, 4) => each!(f32),
            (Kind::Float, _) => each!(f64),
            (Kind::Signed, 1) => each!(i8),
            (Kind::Signed, 2) => each!(i16),
            (Kind::Signed, 4) => each!(i32),
            (Kind::Signed, _) => each!(i64),
            (Kind::Unsigned, 1) => each!(u8),
            (Kind::Unsigned, 2) => each!(u16),
            (Kind::Unsigned, 4) => each!(u32),
            (Kind::Unsigned, _) => each!(u64),
        }
    }

    /// Type of a description such as `<f8`.
    fn described(text: &str) -> Option<Self> {
        let mut letters = text.chars();
        let is_big = match letters.next()? {
            '<' | '|' | '=' => false,
            '>' => true,
            _ => return None,
        };
        let kind = match letters.next()? {
            'f' => Kind::Float,
            'i' => Kind::Signed,
            'u' | 'b' => Kind::Unsigned,
            _ => return None,
        };
        let size: usize = letters.as_str().parse().ok()?;
        let is_known = match kind {
            Kind::Float => matches!(size, 4 | 8),
            _ => matches!(size, 1 | 2 | 4 | 8),
        };
        is_known.then_some(Self { kind, size, is_big })
    }
}

/// Names and types of arrays that cannot be read.
type Others = Vec<(String, String)>;

/// Array in a file.
#[derive(Clone, Debug)]
struct Array {
    name: String,
    /// Member of the archive, or `None` for an `.npy` file.
    member: Option<Member>,
    number: Number,
    is_fortran: bool,
    shape: Vec<usize>,
}

fn open_array(path: &Path, member: Option<&Member>) -> Result<Box<dyn Read + Send>, FrameError> {
    match member {
        Some(member) => member.open(path),
        None => {
            let file = regular(path).map_err(|error| FrameError::unreadable(path, error))?;
            Ok(Box::new(BufReader::new(file)))
        }
    }
}

/// Reads exactly this number of bytes; memory is allocated only for data that exist.
fn exactly(from: &mut dyn Read, count: u64, path: &Path) -> Result<Vec<u8>, FrameError> {
    let mut bytes = Vec::new();
    let read = from.take(count).read_to_end(&mut bytes);
    read.map_err(|error| FrameError::unreadable(path, error))?;
    match bytes.len() as u64 == count {
        true => Ok(bytes),
        false => Err(FrameError::wrong(
            Place::file(path),
            "a complete array",
            "write the file again; it is damaged or cut off",
        )),
    }
}

/// Type of the numbers of an array, whether the first index varies fastest, and its shape.
type Described = (Number, bool, Vec<usize>);

/// Reads the header of an array, and leaves the reader at its data. The inner error is the description of an unsupported type, for example of text or of
/// complex numbers.
fn header(
    from: &mut dyn Read,
    name: &str,
    size: u64,
    path: &Path,
) -> Result<Result<Described, String>, FrameError> {
    let wrong = || {
        FrameError::wrong(
            Place::file(path),
            format!("an array in `{}`", brief(name)),
            HINT,
        )
    };
    let start = exactly(from, 8, path)?;
    if !start.starts_with(b"\x93NUMPY") {
        return Err(wrong());
    }
    let wide = if start[6] >= 2 { 4 } else { 2 };
    let length = exactly(from, wide, path)?;
    let length = length
        .iter()
        .rev()
        .fold(0, |sum, byte| sum << 8 | u64::from(*byte));
    if length > 1 << 16 {
        return Err(wrong());
    }
    let text = exactly(from, length, path)?;
    let text = String::from_utf8_lossy(&text);
    let after = |key: &str| {
        let (_, rest) = text.split_once(key)?;
        Some(rest.trim_start().strip_prefix(':')?.trim_start())
    };
    let described = after("'descr'").ok_or_else(wrong)?;
    let Some(described) = described.strip_prefix('\'') else {
        return Err(FrameError::refused(
            Place::file(path),
            format!("`{}` has records", brief(name)),
            "save each field as a separate array",
        ));
    };
    let described = described.split('\'').next().unwrap_or_default();
    if described.contains('O') {
        return Err(FrameError::refused(
            Place::file(path),
            format!(
                "`{}` holds pickled objects, which are programs and are not loaded",
                brief(name)
            ),
            "write HDF5, or save plain arrays with numpy.savez",
        ));
    }
    let Some(number) = Number::described(described) else {
        return Ok(Err(brief(described)));
    };
    let is_fortran = after("'fortran_order'")
        .ok_or_else(wrong)?
        .starts_with("True");
    let shape = after("'shape'").and_then(|rest| rest.strip_prefix('('));
    let shape = shape
        .and_then(|rest| rest.split_once(')'))
        .ok_or_else(wrong)?
        .0;
    let axes = shape
        .split(',')
        .map(str::trim)
        .filter(|axis| !axis.is_empty());
    let shape: Result<Vec<usize>, _> = axes.map(str::parse).collect();
    let shape = shape.map_err(|_| wrong())?;
    let bytes = shape.iter().try_fold(number.size as u64, |bytes, axis| {
        bytes.checked_mul(*axis as u64)
    });
    if bytes != size.checked_sub(8 + wide + length) || shape.len() > 8 {
        return Err(wrong());
    }
    Ok(Ok((number, is_fortran, shape)))
}

/// Lists the numerical arrays of a file, and the names and types of other arrays; notes on these are added to `ignored`.
fn arrays(path: &Path, ignored: &mut Vec<String>) -> Result<(Vec<Array>, Others), FrameError> {
    let mut head = [0; 2];
    let failed = |error| FrameError::unreadable(path, error);
    let mut file = regular(path).map_err(failed)?;
    let length = file.metadata().map_err(failed)?.len();
    file.read_exact(&mut head).map_err(failed)?;
    let members = match &head == b"PK" {
        true => members(path)?.into_iter().map(Some).collect(),
        false => vec![None],
    };
    if members.len() > MAX_ARRAYS {
        return Err(FrameError::refused(
            Place::file(path),
            format!("more than {MAX_ARRAYS} arrays"),
            "save the frames as the first axis of one array",
        ));
    }
    let (mut arrays, mut others) = (Vec::new(), Vec::new());
    for member in members {
        let name = match &member {
            Some(member) => member.name.trim_end_matches(".npy").to_owned(),
            None => "position".to_owned(),
        };
        let size = member.as_ref().map_or(length, |member| member.size);
        let mut from = open_array(path, member.as_ref())?;
        match header(&mut *from, &name, size, path)? {
            Ok((number, is_fortran, shape)) => arrays.push(Array {
                name,
                member,
                number,
                is_fortran,
                shape,
            }),
            Err(described) => {
                ignored.push(format!(
                    "the type {described} of `{}` is not supported",
                    brief(&name)
                ));
                others.push((name, described));
            }
        }
    }
    Ok((arrays, others))
}

/// Meaning of the axes of arrays. HDF5 data sets use the same meanings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axes {
    /// Array over frames, particles and components.
    Series { frames: usize, particles: usize },
    /// Array over particles and components, for one frame.
    Single { particles: usize },
}

impl Axes {
    /// Number of components of an array, and whether it has an axis of frames; `None` for an array that does not fit.
    pub(super) fn of(self, shape: &[usize]) -> Option<(&[usize], bool)> {
        match (self, shape) {
            (Self::Series { frames, particles }, [f, n, rest @ ..])
                if *f == frames && *n == particles =>
            {
                Some((rest, true))
            }
            (Self::Series { particles, .. } | Self::Single { particles }, [n, rest @ ..])
                if *n == particles =>
            {
                Some((rest, false))
            }
            _ => None,
        }
    }

    pub(super) const fn particles(self) -> usize {
        match self {
            Self::Series { particles, .. } | Self::Single { particles } => particles,
        }
    }

    pub(super) const fn frames(self) -> usize {
        match self {
            Self::Series { frames, .. } => frames,
            Self::Single { .. } => 1,
        }
    }

    /// Finds the meaning of the axes that gives positions with the largest number of components, then the meaning that uses the largest number of
    /// arrays.
    ///
    /// Returns this meaning with the plan and the arrays of its columns.
    pub(super) fn guess(
        arrays: &[(&str, &[usize])],
        times: Option<usize>,
        reading: &Reading,
        place: &Place,
    ) -> Result<(Self, Plan, Vec<usize>), FrameError> {
        let mut candidates: Vec<Self> = Vec::new();
        for (_, shape) in arrays {
            if let [frames, particles, ..] = **shape
                && times.is_none_or(|times| times == frames)
            {
                candidates.push(Self::Series { frames, particles });
            }
        }
        for (_, shape) in arrays {
            if let [particles, ..] = **shape
                && times.is_none_or(|times| times == 1)
            {
                candidates.push(Self::Single { particles });
            }
        }
        candidates.dedup();
        candidates.truncate(64);
        let mut most = (0, 0);
        let mut best: Option<(Self, Plan, Vec<usize>)> = None;
        let mut failure = None;
        for axes in candidates {
            let mut fitting = Vec::new();
            let mut available = Vec::new();
            for (n, (name, shape)) in arrays.iter().enumerate() {
                let Some((rest, _)) = axes.of(shape) else {
                    continue;
                };
                let components = rest
                    .iter()
                    .try_fold(1usize, |all, axis| all.checked_mul(*axis));
                let Some(components) = components.filter(|count| (1..=64).contains(count)) else {
                    continue;
                };
                fitting.push(n);
                available.push(Available {
                    name: (*name).to_owned(),
                    components,
                    is_matrix: rest.len() == 2 && rest[0] == rest[1],
                    support: Support::Points,
                });
            }
            match Plan::of(available, reading, Dialect::Plain, place) {
                Ok(plan) => {
                    let score = (plan.dimensions(), fitting.len());
                    if score > most {
                        most = score;
                        best = Some((axes, plan, fitting));
                    }
                }
                Err(error) => failure = Some(error),
            }
        }
        match (best, failure) {
            (Some(found), _) => Ok(found),
            (None, Some(error @ FrameError::NoColumn { .. })) => Err(error),
            _ => Err(FrameError::NoArray {
                place: Box::new(place.clone()),
                arrays: arrays
                    .iter()
                    .map(|(name, shape)| ((*name).to_owned(), shape.to_vec()))
                    .collect(),
                others: Vec::new(),
            }),
        }
    }
}

/// Returns the name of the array of times, from the user or from a list of usual names.
pub(super) fn time_name<'a>(
    names: impl Iterator<Item = &'a str> + Clone,
    reading: &Reading,
) -> Option<usize> {
    let given = reading
        .columns
        .iter()
        .find(|(quantity, _)| *quantity == Quantity::Time);
    let mut names = names.clone();
    match given {
        Some((_, list)) => names.position(|name| list.first().is_some_and(|own| own == name)),
        None => names.position(|name| matches!(name, "time" | "times" | "t" | "Time")),
    }
}

/// Choices without the time column, which array formats read themselves.
pub(super) fn without_time(reading: &Reading) -> Reading {
    let mut own = reading.clone();
    own.columns
        .retain(|(quantity, _)| *quantity != Quantity::Time);
    own
}

/// Open file with its arrays.
struct Archive {
    path: PathBuf,
    axes: Axes,
    plan: Plan,
    /// Array of each column.
    columns: Vec<Stream>,
}

/// Array that is read frame by frame.
struct Stream {
    array: Array,
    has_frames: bool,
    open: Option<(usize, Box<dyn Read + Send>)>,
    /// Whole array, if it is stored column by column.
    whole: Option<Vec<f64>>,
}

struct Archives {
    reading: Reading,
    paths: Vec<PathBuf>,
    /// File and number of each frame in its file.
    frames: Vec<(usize, usize)>,
    open: Option<(usize, Archive)>,
}

fn archive(
    path: &Path,
    reading: &Reading,
    ignored: &mut Vec<String>,
) -> Result<(Archive, Vec<Stamp>), FrameError> {
    let place = Place::file(path);
    let (arrays, unreadable) = arrays(path, ignored)?;
    let time = time_name(arrays.iter().map(|own| own.name.as_str()), reading);
    let time = time.map(|n| &arrays[n]).filter(|own| own.shape.len() <= 1);
    let times = match time {
        Some(array) => {
            let count = array.shape.first().copied().unwrap_or(1);
            if count > reading.limits.frames {
                return Err(FrameError::refused(
                    place,
                    format!("more than {} frames", reading.limits.frames),
                    "write fewer frames",
                ));
            }
            let mut stream = Stream::new(array.clone(), false);
            Some(stream.all(path, reading)?)
        }
        None => None,
    };
    let others: Vec<&Array> = arrays
        .iter()
        .filter(|own| time.is_none_or(|time| time.name != own.name))
        .collect();
    let shapes: Vec<(&str, &[usize])> = others
        .iter()
        .map(|own| (own.name.as_str(), own.shape.as_slice()))
        .collect();
    let own = without_time(reading);
    let guessed = Axes::guess(&shapes, times.as_ref().map(Vec::len), &own, &place);
    let (axes, plan, fitting) = guessed.map_err(|error| {
        let wanted = reading.columns.iter().flat_map(|(_, names)| names);
        let wanted: Vec<&str> = wanted.map(String::as_str).collect();
        let is_wanted = |name: &str| match error {
            FrameError::NoColumn { .. } => wanted.contains(&name),
            FrameError::NoArray { .. } => is_position(name) || wanted.contains(&name),
            _ => false,
        };
        match unreadable.iter().find(|(name, _)| is_wanted(name)) {
            Some((name, described)) => FrameError::refused(
                place.clone(),
                format!("the type {described} of `{}` is not supported", brief(name)),
                "save numbers of 32 or 64 bits, for example array.astype(float)",
            ),
            None => error,
        }
    })?;
    if axes.particles() > reading.limits.particles || axes.frames() > reading.limits.frames {
        return Err(FrameError::refused(
            place,
            format!("{} particles in {} frames", axes.particles(), axes.frames()),
            "write a smaller region or fewer frames",
        ));
    }
    for (n, own) in others.iter().enumerate() {
        if !fitting.contains(&n) {
            ignored.push(format!(
                "`{}` has other axes than frames, particles, components",
                brief(&own.name)
            ));
        }
    }
    let columns = fitting.iter().map(|n| {
        let array = others[*n].clone();
        let has_frames = axes
            .of(&array.shape)
            .is_some_and(|(_, has_frames)| has_frames);
        Stream::new(array, has_frames)
    });
    let archive = Archive {
        path: path.to_owned(),
        axes,
        plan,
        columns: columns.collect(),
    };
    let stamps = (0..axes.frames()).map(|frame| Stamp {
        time: times.as_ref().and_then(|times| times.get(frame).copied()),
        step: None,
    });
    let stamps = stamps.collect();
    Ok((archive, stamps))
}

pub(crate) fn open(paths: &[PathBuf], reading: &Reading) -> Result<Opened, FrameError> {
    let (mut frames, mut stamps, mut ignored) = (Vec::new(), Vec::new(), Vec::new());
    let mut first: Option<(usize, Archive)> = None;
    for (file, path) in paths.iter().enumerate() {
        let mut own = Vec::new();
        let (archive, times) = archive(path, reading, &mut own)?;
        if file == 0 {
            ignored = own;
            first = Some((0, archive));
        }
        frames.extend((0..times.len()).map(|frame| (file, frame)));
        stamps.extend(times);
    }
    let Some((_, archive)) = &first else {
        return Err(FrameError::Request {
            what: "no files".to_owned(),
            hint: HINT.to_owned(),
        });
    };
    let plan = archive.plan.clone();
    let position = plan.columns_of(Quantity::Position);
    let is_single = position
        .iter()
        .any(|column| archive.columns[*column].array.number.size < 8);
    Ok(Opened {
        source: Box::new(Archives {
            reading: reading.clone(),
            paths: paths.to_vec(),
            frames,
            open: first,
        }),
        stamps,
        plan,
        digits: is_single.then_some(super::SINGLE_DIGITS),
        ignored,
    })
}

impl Stream {
    fn new(array: Array, has_frames: bool) -> Self {
        Self {
            array,
            has_frames,
            open: None,
            whole: None,
        }
    }

    /// All numbers of the array, in the order of rows.
    fn all(&mut self, path: &Path, reading: &Reading) -> Result<Vec<f64>, FrameError> {
        let count: usize = self.array.shape.iter().product();
        let bytes = (count * self.array.number.size) as u64;
        if bytes > reading.limits.bytes {
            return Err(FrameError::refused(
                Place::file(path),
                format!(
                    "`{}` is too large for Fortran order",
                    brief(&self.array.name)
                ),
                "save numpy.ascontiguousarray of the array",
            ));
        }
        let mut from = self.data(path)?;
        let bytes = exactly(&mut *from, bytes, path)?;
        let mut values = Vec::with_capacity(count);
        self.array.number.decode(&bytes, &mut values);
        if self.array.is_fortran && self.array.shape.len() > 1 {
            values = by_rows(&values, &self.array.shape);
        }
        Ok(values)
    }

    /// Reader at the first number.
    fn data(&self, path: &Path) -> Result<Box<dyn Read + Send>, FrameError> {
        let member = self.array.member.as_ref();
        let mut from = open_array(path, member)?;
        let length = match member {
            Some(member) => member.size,
            None => {
                let data = std::fs::metadata(path);
                data.map_err(|error| FrameError::unreadable(path, error))?
                    .len()
            }
        };
        let _ = header(&mut *from, &self.array.name, length, path)?;
        Ok(from)
    }

    fn frame(
        &mut self,
        frame: usize,
        path: &Path,
        reading: &Reading,
    ) -> Result<Vec<f64>, FrameError> {
        let axes = &self.array.shape[usize::from(self.has_frames)..];
        let count: usize = axes.iter().product();
        let frame = if self.has_frames { frame } else { 0 };
        if self.array.is_fortran && self.array.shape.len() > 1 {
            let whole = match self.whole.take() {
                Some(whole) => whole,
                None => self.all(path, reading)?,
            };
            let values = whole[frame * count..][..count].to_vec();
            self.whole = Some(whole);
            return Ok(values);
        }
        let bytes = (count * self.array.number.size) as u64;
        let (at, mut from) = match self.open.take() {
            Some((at, from)) if at <= frame => (at, from),
            _ => (0, self.data(path)?),
        };
        let skipped = bytes.saturating_mul((frame - at) as u64);
        std::io::copy(&mut (&mut from).take(skipped), &mut std::io::sink())
            .map_err(|error| FrameError::unreadable(path, error))?;
        let bytes = exactly(&mut *from, bytes, path)?;
        self.open = Some((frame + 1, from));
        let mut values = Vec::with_capacity(count);
        self.array.number.decode(&bytes, &mut values);
        Ok(values)
    }
}

/// Reorders an array that is stored column by column.
fn by_rows(values: &[f64], shape: &[usize]) -> Vec<f64> {
    let mut strides = vec![1; shape.len()];
    for axis in 1..shape.len() {
        strides[axis] = strides[axis - 1] * shape[axis - 1];
    }
    let mut index = vec![0; shape.len()];
    let mut rows = Vec::with_capacity(values.len());
    for _ in 0..values.len() {
        let place: usize = index
            .iter()
            .zip(&strides)
            .map(|(i, stride)| i * stride)
            .sum();
        rows.push(values[place]);
        for axis in (0..shape.len()).rev() {
            index[axis] += 1;
            if index[axis] < shape[axis] {
                break;
            }
            index[axis] = 0;
        }
    }
    rows
}

impl Source for Archives {
    fn read(&mut self, frame: usize) -> Result<Frame, FrameError> {
        let (file, number) = self.frames[frame];
        let path = &self.paths[file];
        let mut own = match self.open.take() {
            Some((open, archive)) if open == file => archive,
            _ => archive(path, &self.reading, &mut Vec::new())?.0,
        };
        let wanted = own.plan.wanted();
        let mut columns = Vec::with_capacity(wanted.len());
        for (stream, is_wanted) in own.columns.iter_mut().zip(wanted) {
            columns.push(match is_wanted {
                true => stream.frame(number, &own.path, &self.reading)?,
                false => Vec::new(),
            });
        }
        let place = Place::frame(path, number);
        let mut read = own
            .plan
            .frame(&columns, own.axes.particles(), None)
            .map_err(|expected| FrameError::wrong(place.clone(), expected, HINT))?;
        read.source = place;
        self.open = Some((file, own));
        Ok(read)
    }

    fn check_rest(&mut self) -> Result<(), FrameError> {
        let Some((_, own)) = &mut self.open else {
            return Ok(());
        };
        let Archive { path, columns, .. } = own;
        // Frames that are read later are read from the start.
        for (_, mut from) in columns.iter_mut().filter_map(|stream| stream.open.take()) {
            std::io::copy(&mut from, &mut std::io::sink())
                .map_err(|error| FrameError::unreadable(path, error))?;
        }
        Ok(())
    }
}
