//! HDF5 files: frames are the first axis of the data sets, or each file is one frame.
//!
//! The arrays of a body of PySPH are in `particles/NAME/arrays`. The HDF5 library used here does not read numbers in attributes of groups: if no data
//! set has times, the number in the name of a file is its time step.

use super::numpy::{Axes, time_name, without_time};
use super::{Opened, SINGLE_DIGITS, Source, Stamp};
use crate::columns::Plan;
use crate::error::{FrameError, Place, brief};
use crate::frame::Frame;
use crate::input::regular;
use crate::reading::{Quantity, Reading};
use rust_hdf5::{DatatypeMessage, H5Dataset, H5File, Hdf5Error};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

const HINT: &str = "write the file again; it is damaged or of a newer format";
/// Maximum number of data sets in a file.
const MAX_SETS: usize = 10_000;

/// Data set of numbers.
struct Stored {
    /// Path in the file.
    path: String,
    /// Last part of the path, or the whole path if another data set has the same last part.
    name: String,
    shape: Vec<usize>,
    kind: Kind,
    /// Bytes of a number.
    size: usize,
}

/// Type of the numbers in a data set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Float,
    Signed,
    Unsigned,
    /// Truth values, which h5py writes as enumerations of bytes.
    Flag,
}

fn kind_of(set: &H5Dataset) -> Option<Kind> {
    match set.datatype().ok()? {
        DatatypeMessage::FloatingPoint { .. } => Some(Kind::Float),
        DatatypeMessage::FixedPoint { signed: true, .. } => Some(Kind::Signed),
        DatatypeMessage::FixedPoint { .. } => Some(Kind::Unsigned),
        DatatypeMessage::Enum { .. } if set.element_size() == 1 => Some(Kind::Flag),
        _ => None,
    }
}

/// Open file with its columns.
struct Body {
    path: PathBuf,
    file: H5File,
    axes: Axes,
    plan: Plan,
    /// Data set of each column, and whether its first axis numbers the frames.
    columns: Vec<(Stored, bool)>,
}

struct Bodies {
    reading: Reading,
    paths: Vec<PathBuf>,
    /// File and number of each frame in its file.
    frames: Vec<(usize, usize)>,
    open: Option<(usize, Body)>,
}

fn damaged(path: &Path, error: &Hdf5Error) -> FrameError {
    let reason: String = error.to_string().chars().take(120).collect();
    FrameError::wrong(
        Place::file(path),
        format!("a readable HDF5 file ({})", reason.escape_debug()),
        HINT,
    )
}

/// Body of PySPH that contains the array with the given path.
fn body_of(path: &str) -> Option<&str> {
    let (body, array) = path
        .trim_start_matches('/')
        .strip_prefix("particles/")?
        .split_once("/arrays/")?;
    (!body.contains('/') && !array.contains('/')).then_some(body)
}

/// Data sets with numbers, and the open file; `others` receives the data sets without numbers.
fn stored(
    path: &Path,
    reading: &Reading,
    ignored: &mut Vec<String>,
    others: &mut Vec<String>,
) -> Result<(H5File, Vec<Stored>), FrameError> {
    let failed = |error: Hdf5Error| damaged(path, &error);
    drop(regular(path).map_err(|error| FrameError::unreadable(path, error))?);
    let file = H5File::options().no_locking().open(path).map_err(failed)?;
    let names = file.dataset_names();
    if names.len() > MAX_SETS {
        return Err(FrameError::refused(
            Place::file(path),
            format!("more than {MAX_SETS} data sets"),
            "write the frames as the first axis of one data set",
        ));
    }
    let mut sets = Vec::new();
    for own in names {
        let set = file.dataset(&own).map_err(failed)?;
        match kind_of(&set) {
            Some(kind) => sets.push(Stored {
                shape: set.shape(),
                kind,
                size: set.element_size(),
                name: String::new(),
                path: own,
            }),
            None => {
                ignored.push(format!("`{}` holds no numbers", brief(&own)));
                others.push(own);
            }
        }
    }
    // One body of PySPH: the chosen one, or the one with the most particles.
    let mut bodies: BTreeMap<String, usize> = BTreeMap::new();
    for own in &sets {
        if let Some(body) = body_of(&own.path) {
            let most = bodies.entry(body.to_owned()).or_default();
            *most = (*most).max(own.shape.first().copied().unwrap_or(0));
        }
    }
    let group = reading.group.as_deref();
    let chosen = group.filter(|name| bodies.contains_key(*name));
    let largest = bodies.iter().max_by_key(|(_, count)| **count);
    let chosen = chosen.or(largest.map(|(name, _)| name.as_str()));
    if let Some(chosen) = chosen {
        sets.retain(|own| body_of(&own.path) == Some(chosen));
        let others = bodies.keys().filter(|name| *name != chosen);
        ignored.extend(others.map(|name| format!("the particles `{}`", brief(name))));
    }
    let short = |path: &str| path.rsplit('/').next().unwrap_or(path).to_owned();
    let mut times: HashMap<String, usize> = HashMap::new();
    for own in &sets {
        *times.entry(short(&own.path)).or_default() += 1;
    }
    let given: Vec<&String> = reading.columns.iter().flat_map(|(_, own)| own).collect();
    for own in &mut sets {
        let name = short(&own.path);
        let is_named = given.contains(&&own.path);
        own.name = match times[&name] == 1 && !is_named {
            true => name,
            false => own.path.clone(),
        };
    }
    Ok((file, sets))
}

/// Number in the name of a file, the time step of its frame.
fn step_of(path: &Path) -> Option<u64> {
    let stem = path.file_stem()?.to_string_lossy().into_owned();
    let start = stem.rfind(|letter: char| !letter.is_ascii_digit());
    stem[start.map_or(0, |place| {
        place + stem[place..].chars().next().map_or(1, char::len_utf8)
    })..]
        .parse()
        .ok()
}

/// Part of a data set, row by row.
fn numbers(
    file: &H5File,
    path: &Path,
    set: &Stored,
    starts: &[usize],
    counts: &[usize],
) -> Result<Vec<f64>, FrameError> {
    let failed = |error: Hdf5Error| damaged(path, &error);
    let open = file.dataset(&set.path).map_err(failed)?;
    let values: Result<Vec<f64>, Hdf5Error> = match set.kind {
        Kind::Float => open.read_numeric_slice_as(starts, counts),
        Kind::Signed => open
            .read_numeric_slice_as::<i64>(starts, counts)
            .map(|all| all.into_iter().map(|x| x as f64).collect()),
        Kind::Unsigned => open
            .read_numeric_slice_as::<u64>(starts, counts)
            .map(|all| all.into_iter().map(|x| x as f64).collect()),
        Kind::Flag => open
            .read_slice::<i8>(starts, counts)
            .map(|all| all.into_iter().map(f64::from).collect()),
    };
    let values = values.map_err(failed)?;
    match values.len() == counts.iter().product::<usize>() {
        true => Ok(values),
        false => Err(FrameError::wrong(
            Place::file(path),
            format!("complete values of `{}`", brief(&set.path)),
            HINT,
        )),
    }
}

fn body(
    path: &Path,
    reading: &Reading,
    ignored: &mut Vec<String>,
) -> Result<(Body, Vec<Stamp>), FrameError> {
    let place = Place::file(path);
    let mut others = Vec::new();
    let (file, mut sets) = stored(path, reading, ignored, &mut others)?;
    let time = time_name(sets.iter().map(|own| own.name.as_str()), reading);
    let time = time.filter(|n| sets[*n].shape.len() <= 1);
    let times = match time.map(|n| sets.remove(n)) {
        None => None,
        Some(set) => {
            let count = set.shape.first().copied().unwrap_or(1);
            if count > reading.limits.frames {
                return Err(FrameError::refused(
                    place,
                    format!("more than {} frames", reading.limits.frames),
                    "write fewer frames",
                ));
            }
            let starts = vec![0; set.shape.len()];
            Some(numbers(&file, path, &set, &starts, &set.shape)?)
        }
    };
    let shapes: Vec<(&str, &[usize])> = sets
        .iter()
        .map(|own| (own.name.as_str(), own.shape.as_slice()))
        .collect();
    let own = without_time(reading);
    let guessed = Axes::guess(&shapes, times.as_ref().map(Vec::len), &own, &place);
    let (axes, plan, fitting) = guessed.map_err(|error| match error {
        FrameError::NoArray { place, arrays, .. } => FrameError::NoArray {
            place,
            arrays,
            others,
        },
        error => error,
    })?;
    if axes.particles() > reading.limits.particles || axes.frames() > reading.limits.frames {
        return Err(FrameError::refused(
            place,
            format!("{} particles in {} frames", axes.particles(), axes.frames()),
            "write a smaller region or fewer frames",
        ));
    }
    let mut columns = Vec::new();
    for (n, set) in sets.into_iter().enumerate() {
        match axes.of(&set.shape).filter(|_| fitting.contains(&n)) {
            Some((_, has_frames)) => columns.push((set, has_frames)),
            None => ignored.push(format!(
                "`{}` has other axes than frames, particles, components",
                brief(&set.name)
            )),
        }
    }
    let step = match axes {
        Axes::Single { .. } if times.is_none() => step_of(path),
        _ => None,
    };
    let stamp = |frame: usize| Stamp {
        time: times
            .as_ref()
            .and_then(|times| times.get(frame).copied())
            .or_else(|| Some(step? as f64 * reading.time_step?)),
        step,
    };
    let stamps = (0..axes.frames()).map(stamp).collect();
    let body = Body {
        path: path.to_owned(),
        file,
        axes,
        plan,
        columns,
    };
    Ok((body, stamps))
}

pub(crate) fn open(paths: &[PathBuf], reading: &Reading) -> Result<Opened, FrameError> {
    let (mut frames, mut stamps, mut ignored) = (Vec::new(), Vec::new(), Vec::new());
    let mut first: Option<Body> = None;
    for (number, path) in paths.iter().enumerate() {
        let mut own = Vec::new();
        let (body, times) = body(path, reading, &mut own)?;
        frames.extend((0..times.len()).map(|frame| (number, frame)));
        stamps.extend(times);
        if first.is_none() {
            (first, ignored) = (Some(body), own);
        }
    }
    let Some(body) = first else {
        return Err(FrameError::Request {
            what: "no files".to_owned(),
            hint: "name the output files of a simulation".to_owned(),
        });
    };
    let plan = body.plan.clone();
    let position = plan.columns_of(Quantity::Position);
    let is_single = position.iter().any(|n| body.columns[*n].0.size < 8);
    Ok(Opened {
        source: Box::new(Bodies {
            reading: reading.clone(),
            paths: paths.to_vec(),
            frames,
            open: Some((0, body)),
        }),
        stamps,
        plan,
        digits: is_single.then_some(SINGLE_DIGITS),
        ignored,
    })
}

impl Source for Bodies {
    fn read(&mut self, frame: usize) -> Result<Frame, FrameError> {
        let (number, frame) = self.frames[frame];
        let own = match self.open.take() {
            Some((open, body)) if open == number => body,
            _ => body(&self.paths[number], &self.reading, &mut Vec::new())?.0,
        };
        let mut columns = Vec::new();
        for ((set, has_frames), is_wanted) in own.columns.iter().zip(own.plan.wanted()) {
            let (mut starts, mut counts) = (vec![0; set.shape.len()], set.shape.clone());
            if *has_frames {
                (starts[0], counts[0]) = (frame, 1);
            }
            columns.push(match is_wanted {
                true => numbers(&own.file, &own.path, set, &starts, &counts)?,
                false => Vec::new(),
            });
        }
        let place = Place::frame(&own.path, frame);
        let mut read = own
            .plan
            .frame(&columns, own.axes.particles(), None)
            .map_err(|expected| FrameError::wrong(place.clone(), expected, HINT))?;
        read.source = place;
        self.open = Some((number, own));
        Ok(read)
    }
}
