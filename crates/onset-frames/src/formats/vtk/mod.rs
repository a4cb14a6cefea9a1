//! Files of VTK in XML: unstructured grids and polygonal data, whole or in pieces, and collections with times.

mod data;
mod xml;

use super::numpy::{Number, without_time};
use super::{Opened, SINGLE_DIGITS, Source, Stamp};
use crate::columns::{Available, Dialect, Plan, Support};
use crate::error::{FrameError, Place, brief};
use crate::frame::{Cells, Frame};
use crate::input::{bounded, regular};
use crate::reading::{Quantity, Reading};
use crate::text::head;
use data::{Compression, Encoding, Storage, values};
use std::path::{Path, PathBuf};
use xml::Tag;

const HINT: &str = "give .vtu or .vtp files, or a .pvd file that lists them; meshio and ParaView convert other formats";
/// Vertex in the numbering of VTK.
const VERTEX: u8 = 1;
/// Number of bytes at the beginning of a file that are searched for the time before the whole file is read.
const HEAD: u64 = 1 << 16;
/// Maximum number of files that contain the pieces of one frame.
const MAX_PARTS: usize = 10_000;

/// Role of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Section {
    Field,
    PointData,
    CellData,
    Points,
    Cells,
    Other,
}

/// Array before its numbers are read.
#[derive(Clone, Debug)]
struct Array {
    name: String,
    section: Section,
    components: usize,
    number: Number,
    storage: Storage,
}

/// Piece of a grid.
#[derive(Clone, Debug, Default)]
struct Piece {
    points: usize,
    cells: usize,
    arrays: Vec<Array>,
}

/// Contents of a file before its numbers are read.
#[derive(Debug, Default)]
struct Document {
    pieces: Vec<Piece>,
    field: Vec<Array>,
    /// Files of the pieces of a parallel file.
    sources: Vec<PathBuf>,
    /// Files of a collection with their times.
    collection: Vec<(Option<f64>, PathBuf)>,
    encoding: Option<Encoding>,
    /// Whether the file is complete, and a list contains only files.
    is_whole: bool,
}

fn read_file(path: &Path, reading: &Reading) -> Result<Vec<u8>, FrameError> {
    let bytes = regular(path).and_then(|file| bounded(file, reading.limits.bytes));
    bytes.map_err(|error| FrameError::unreadable(path, error))
}

/// Arrays that are stored after the grid, with their offsets in the data.
struct Appended {
    /// Piece (`None` for the field data) and number of the array.
    owner: (Option<usize>, usize),
    offset: usize,
}

fn wrong(path: &Path, bytes: &[u8], at: usize, expected: &str) -> FrameError {
    let line = 1 + bytes[..at.min(bytes.len())]
        .iter()
        .filter(|byte| **byte == b'\n')
        .count();
    FrameError::wrong(Place::line(path, line as u64), expected, HINT)
}

/// Reads the tags of a file. With `is_head` the file may be truncated.
fn document(path: &Path, bytes: &[u8], is_head: bool) -> Result<Document, FrameError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut own = Document::default();
    let mut section = Section::Other;
    let mut in_piece = false;
    let mut appended: Vec<Appended> = Vec::new();
    let mut has_others = false;
    let mut at = 0;
    loop {
        let tag = match xml::next(bytes, at) {
            Ok(Some(tag)) => tag,
            Ok(None) => break,
            Err(_) if is_head => break,
            Err(place) => return Err(wrong(path, bytes, place, "a complete tag of XML")),
        };
        // Only blanks and comments are allowed between the tags of a list.
        let between = &bytes[at..tag.place.start];
        let text = between.iter().find(|byte| !byte.is_ascii_whitespace());
        has_others |= text.is_some_and(|byte| *byte != b'<');
        at = tag.place.end;
        let fail = |expected: &str| wrong(path, bytes, tag.place.start, expected);
        if tag.is_end {
            match tag.name.as_str() {
                "VTKFile" => own.is_whole = true,
                "Piece" => in_piece = false,
                "FieldData" | "PointData" | "CellData" | "Points" | "Cells" | "Verts" | "Lines"
                | "Polys" | "Strips" => section = Section::Other,
                _ => {}
            }
            continue;
        }
        has_others |= !["VTKFile", "Collection", "DataSet"].contains(&tag.name.as_str());
        match tag.name.as_str() {
            "VTKFile" => own.encoding = Some(encoding(&tag, path)?),
            "ImageData"
            | "RectilinearGrid"
            | "StructuredGrid"
            | "vtkMultiBlockDataSet"
            | "HyperTreeGrid" => {
                return Err(FrameError::refused(
                    Place::file(path),
                    format!("the file has a `{}`", brief(&tag.name)),
                    HINT,
                ));
            }
            "Piece" => {
                if let Some(source) = tag.get("Source") {
                    own.sources.push(folder.join(source));
                } else if !tag.is_empty {
                    let points = tag.number("NumberOfPoints");
                    own.pieces.push(Piece {
                        points: points.ok_or_else(|| fail("the number of points"))?,
                        cells: tag.number("NumberOfCells").unwrap_or(0),
                        arrays: Vec::new(),
                    });
                    in_piece = true;
                }
                if own.sources.len() > MAX_PARTS || own.pieces.len() > MAX_PARTS {
                    return Err(fail("fewer pieces"));
                }
            }
            "DataSet" => {
                let file = tag
                    .get("file")
                    .ok_or_else(|| fail("`file` of a data set"))?;
                let time = match tag.get("timestep") {
                    Some(text) => {
                        let time: Option<f64> = text.trim().parse().ok();
                        let time = time.filter(|time| time.is_finite());
                        Some(time.ok_or_else(|| fail("a number as `timestep`"))?)
                    }
                    None => None,
                };
                own.collection.push((time, folder.join(file)));
            }
            _ if tag.is_empty && tag.name != "DataArray" => {}
            "FieldData" => section = Section::Field,
            "PointData" => section = Section::PointData,
            "CellData" => section = Section::CellData,
            "Points" => section = Section::Points,
            "Cells" => section = Section::Cells,
            "Verts" | "Lines" | "Polys" | "Strips" => section = Section::Other,
            "DataArray" => {
                let Some(encoding) = own.encoding else {
                    return Err(fail("`VTKFile` before data"));
                };
                let is_used = section == Section::Field || in_piece && section != Section::Other;
                let kind = tag.get("type").unwrap_or_default();
                let Some(number) = data::number(kind, encoding.is_big).filter(|_| is_used) else {
                    continue;
                };
                let rest = &bytes[at..];
                let length = match tag.is_empty {
                    true => 0,
                    false => match rest.iter().position(|byte| *byte == b'<') {
                        Some(length) => length,
                        None if is_head => break,
                        None => return Err(fail("an end of `DataArray`")),
                    },
                };
                let range = at..at + length;
                let list = match section {
                    Section::Field => &mut own.field,
                    _ => match own.pieces.last_mut() {
                        Some(piece) => &mut piece.arrays,
                        None => continue,
                    },
                };
                let count = list.len();
                let storage = match tag.get("format").unwrap_or("ascii") {
                    "ascii" => Storage::Text(range),
                    "binary" => Storage::Base64(range),
                    "appended" => {
                        let offset = tag.number("offset");
                        let piece = (section != Section::Field).then(|| own.pieces.len() - 1);
                        appended.push(Appended {
                            owner: (piece, count),
                            offset: offset.ok_or_else(|| fail("`offset` of appended data"))?,
                        });
                        Storage::Raw(0..0)
                    }
                    _ => return Err(fail("the format ascii, binary or appended")),
                };
                let components = tag.number("NumberOfComponents").unwrap_or(1).clamp(1, 64);
                let array = Array {
                    name: tag.get("Name").unwrap_or_default().to_owned(),
                    section,
                    components,
                    number,
                    storage,
                };
                let list = match section {
                    Section::Field => &mut own.field,
                    _ => match own.pieces.last_mut() {
                        Some(piece) => &mut piece.arrays,
                        None => continue,
                    },
                };
                list.push(array);
            }
            "AppendedData" => {
                place_appended(&mut own, appended, bytes, &tag)
                    .ok_or_else(|| fail("appended data that begin with `_`, within the file"))?;
                return Ok(own);
            }
            _ => {}
        }
    }
    if !is_head && !appended.is_empty() {
        return Err(wrong(path, bytes, bytes.len(), "appended data"));
    }
    if own.encoding.is_none() {
        return Err(wrong(path, bytes, 0, "`VTKFile`"));
    }
    // A damaged tag of a list hides a file.
    own.is_whole &= own.collection.is_empty() || !has_others;
    if !is_head && !own.is_whole && own.collection.is_empty() {
        return Err(wrong(path, bytes, bytes.len(), "the end of `VTKFile`"));
    }
    Ok(own)
}

fn encoding(tag: &Tag, path: &Path) -> Result<Encoding, FrameError> {
    let compression = match tag.get("compressor").unwrap_or_default() {
        "" => Compression::None,
        "vtkZLibDataCompressor" => Compression::Zlib,
        other => {
            return Err(FrameError::refused(
                Place::file(path),
                format!("compressed by `{}`", brief(other)),
                "write the file with zlib or without compression",
            ));
        }
    };
    Ok(Encoding {
        is_big: tag.get("byte_order") == Some("BigEndian"),
        header: match tag.get("header_type") {
            Some("UInt64") => 8,
            _ => 4,
        },
        compression,
    })
}

/// Sets the ranges of appended arrays: each ends where the next begins.
fn place_appended(
    own: &mut Document,
    appended: Vec<Appended>,
    bytes: &[u8],
    tag: &Tag,
) -> Option<()> {
    let rest = bytes.get(tag.place.end..)?;
    let skipped = rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
    if rest[skipped] != b'_' {
        return None;
    }
    let start = tag.place.end + skipped + 1;
    let is_raw = tag.get("encoding") == Some("raw");
    let end = match is_raw {
        true => bytes.len(),
        false => {
            start
                + bytes[start..]
                    .iter()
                    .position(|byte| *byte == b'<')
                    .unwrap_or(bytes.len() - start)
        }
    };
    let mut offsets: Vec<usize> = appended.iter().map(|own| own.offset).collect();
    offsets.sort_unstable();
    for Appended { owner, offset } in appended {
        let first = start.checked_add(offset).filter(|first| *first <= end)?;
        // Several arrays may share one offset.
        let next = offsets[offsets.partition_point(|own| *own <= offset)..].first();
        let last = next.map_or(end, |next| start.saturating_add(*next).min(end));
        let storage = match is_raw {
            true => Storage::Raw(first..last),
            false => Storage::Base64(first..last),
        };
        let list = match owner.0 {
            None => &mut own.field,
            Some(piece) => &mut own.pieces.get_mut(piece)?.arrays,
        };
        list.get_mut(owner.1)?.storage = storage;
    }
    Some(())
}

/// Time in the field data of a file.
fn time_of(own: &Document, bytes: &[u8], reading: &Reading) -> Option<f64> {
    let given = reading
        .columns
        .iter()
        .find(|(quantity, _)| *quantity == Quantity::Time)
        .and_then(|(_, names)| names.first());
    let is_time = |name: &str| match given {
        Some(given) => name == given,
        None => ["TimeValue", "time", "time_value"]
            .iter()
            .any(|own| own.eq_ignore_ascii_case(name)),
    };
    let array = own.field.iter().find(|array| is_time(&array.name))?;
    let list = values(bytes, &array.storage, array.number, own.encoding?, 1).ok()?;
    list.first().copied().filter(|time| time.is_finite())
}

struct Grids {
    reading: Reading,
    /// Files of each frame.
    frames: Vec<Vec<PathBuf>>,
    plan: Plan,
}

/// Values of a frame by columns, with its cells.
#[derive(Default)]
struct Values {
    columns: Vec<Vec<f64>>,
    points: usize,
    cells: Cells,
}

pub(crate) fn open(paths: &[PathBuf], reading: &Reading) -> Result<Opened, FrameError> {
    let (mut frames, mut stamps) = (Vec::<Vec<PathBuf>>::new(), Vec::<Stamp>::new());
    let mut ignored = Vec::new();
    for path in paths {
        let start = head(path, HEAD)?;
        let mut own = document(path, &start, true)?;
        let is_short = (start.len() as u64) < HEAD;
        let is_list = !own.collection.is_empty() || !own.sources.is_empty();
        let mut time = time_of(&own, &start, reading);
        let is_later = own
            .field
            .iter()
            .any(|array| array.storage == Storage::Raw(0..0));
        if !is_short && (is_list || own.pieces.is_empty() || time.is_none() && is_later) {
            let bytes = read_file(path, reading)?;
            own = document(path, &bytes, false)?;
            time = time_of(&own, &bytes, reading);
        }
        if own.collection.is_empty() {
            frames.push(vec![path.clone()]);
            stamps.push(Stamp { time, step: None });
        } else if !own.is_whole {
            ignored.push(format!(
                "{} is cut off or damaged: some of the files that it lists are skipped",
                path.display()
            ));
        }
        for (time, file) in own.collection {
            // Parts of one frame have the same time.
            match (stamps.last(), frames.last_mut()) {
                (Some(last), Some(parts)) if last.time == time && time.is_some() => {
                    parts.push(file);
                    if parts.len() > MAX_PARTS {
                        return Err(FrameError::wrong(
                            Place::file(path),
                            "fewer parts of a frame",
                            HINT,
                        ));
                    }
                }
                _ => {
                    frames.push(vec![file]);
                    stamps.push(Stamp { time, step: None });
                }
            }
        }
        if frames.len() > reading.limits.frames {
            return Err(FrameError::refused(
                Place::file(path),
                format!("more than {} frames", reading.limits.frames),
                "list fewer frames",
            ));
        }
    }
    let Some(first) = frames.first().and_then(|parts| parts.first()) else {
        return Err(FrameError::wrong(
            Place::file(&paths[0]),
            "a list of files",
            HINT,
        ));
    };
    let own = without_time(reading);
    let (first, bytes, parsed) = grid(first, reading, 0)?;
    let Some(piece) = parsed.pieces.iter().find(|piece| piece.points > 0) else {
        return Err(FrameError::wrong(
            Place::file(&first),
            "a grid with points",
            HINT,
        ));
    };
    drop(bytes);
    let plan = Plan::of(available(piece), &own, Dialect::Vtk, &Place::file(&first))?;
    if piece
        .arrays
        .iter()
        .any(|array| array.name == "vtkGhostType")
    {
        ignored.push(
            "`vtkGhostType`: points and cells that several pieces share are counted in each"
                .to_owned(),
        );
    }
    let is_single = piece
        .arrays
        .iter()
        .any(|array| array.section == Section::Points && array.number.size < 8);
    Ok(Opened {
        source: Box::new(Grids {
            reading: own,
            frames,
            plan: plan.clone(),
        }),
        stamps,
        plan,
        digits: is_single.then_some(SINGLE_DIGITS),
        ignored,
    })
}

/// First grid of a file, which may be stored in the file of a piece.
fn grid(
    path: &Path,
    reading: &Reading,
    depth: usize,
) -> Result<(PathBuf, Vec<u8>, Document), FrameError> {
    let bytes = read_file(path, reading)?;
    let own = document(path, &bytes, false)?;
    match own.sources.first() {
        Some(source) if depth == 0 => grid(source, reading, 1),
        _ => Ok((path.to_owned(), bytes, own)),
    }
}

/// Columns of a piece: the points, then data of points and cells.
fn available(piece: &Piece) -> Vec<Available> {
    let of = |array: &Array| {
        let support = match array.section {
            Section::Points | Section::PointData => Support::Points,
            Section::CellData => Support::Cells,
            _ => return None,
        };
        Some(Available {
            name: match array.section {
                Section::Points => "Points".to_owned(),
                _ => array.name.clone(),
            },
            components: array.components,
            is_matrix: false,
            support,
        })
    };
    let of_points = |array: &&Array| array.section == Section::Points;
    let points = piece.arrays.iter().filter(of_points).take(1);
    let others = piece.arrays.iter().filter(|array| !of_points(array));
    points.chain(others).filter_map(of).collect()
}

impl Grids {
    /// Adds the pieces of a file.
    fn add(&mut self, path: &Path, to: &mut Values, depth: usize) -> Result<(), FrameError> {
        let bytes = read_file(path, &self.reading)?;
        let own = document(path, &bytes, false)?;
        if !own.sources.is_empty() && depth == 0 {
            for source in &own.sources {
                self.add(source, to, 1)?;
            }
            return Ok(());
        }
        let Some(encoding) = own.encoding else {
            return Ok(());
        };
        for piece in own.pieces.iter().filter(|piece| piece.points > 0) {
            self.add_piece(path, &bytes, piece, encoding, to)?;
        }
        Ok(())
    }

    fn add_piece(
        &mut self,
        path: &Path,
        bytes: &[u8],
        piece: &Piece,
        encoding: Encoding,
        to: &mut Values,
    ) -> Result<(), FrameError> {
        let place = || Place::file(path);
        let limit = self.reading.limits.particles;
        let points = to.points.saturating_add(piece.points);
        let cells = to.cells.len().saturating_add(piece.cells);
        if points > limit || cells > limit {
            return Err(FrameError::refused(
                place(),
                format!("{points} points and {cells} cells in a frame; the limit is {limit}"),
                "give a smaller region of the simulation",
            ));
        }
        let columns = available(piece);
        if to.columns.is_empty() {
            if !self.plan.is_for(&columns) {
                self.plan = Plan::of(columns, &self.reading, Dialect::Vtk, &place())?;
            }
            to.columns = vec![Vec::new(); self.plan.available().len()];
        } else if !self.plan.is_for(&columns) {
            return Err(FrameError::wrong(
                place(),
                "the same arrays in all pieces of a frame",
                HINT,
            ));
        }
        let read = |array: &Array, most: usize| {
            values(bytes, &array.storage, array.number, encoding, most).map_err(|expected| {
                let name = brief(&array.name);
                FrameError::wrong(place(), format!("{expected} in `{name}`"), HINT)
            })
        };
        let wanted = self.plan.wanted();
        for (n, is_wanted) in wanted.into_iter().enumerate() {
            let own = &self.plan.available()[n];
            let is_points = n == 0 && own.name == "Points";
            let array = piece
                .arrays
                .iter()
                .find(|array| match (is_points, own.support) {
                    (true, _) => array.section == Section::Points,
                    (false, Support::Points) => {
                        array.section == Section::PointData && array.name == own.name
                    }
                    (false, Support::Cells) => {
                        array.section == Section::CellData && array.name == own.name
                    }
                });
            let Some(array) = array.filter(|_| is_wanted) else {
                continue;
            };
            let count = match own.support {
                Support::Points => piece.points,
                Support::Cells => piece.cells,
            };
            let count = count.saturating_mul(own.components);
            let list = read(array, count)?;
            if list.len() != count {
                let name = brief(&own.name);
                return Err(FrameError::wrong(
                    place(),
                    format!("{count} numbers in `{name}`, found {}", list.len()),
                    HINT,
                ));
            }
            to.columns[n].extend(list);
        }
        let of_cells = |name: &str| {
            let mut arrays = piece.arrays.iter();
            arrays.find(|array| array.section == Section::Cells && array.name == name)
        };
        if let (Some(connectivity), Some(offsets), Some(shapes)) = (
            of_cells("connectivity"),
            of_cells("offsets"),
            of_cells("types"),
        ) {
            let ends = read(offsets, piece.cells)?;
            let shapes = read(shapes, piece.cells)?;
            // A cell has at most a few tens of points; polyhedra with more are not needed.
            let connectivity = read(connectivity, piece.cells.saturating_mul(64))?;
            let fits = connect(to, piece, &connectivity, &ends, &shapes);
            fits.ok_or_else(|| {
                FrameError::wrong(place(), "cells between the points of the piece", HINT)
            })?;
        }
        to.points = points;
        Ok(())
    }
}

/// Adds the cells of a piece.
fn connect(
    to: &mut Values,
    piece: &Piece,
    connectivity: &[f64],
    ends: &[f64],
    shapes: &[f64],
) -> Option<()> {
    if ends.len() != piece.cells || shapes.len() != piece.cells {
        return None;
    }
    let (first, start) = (to.points, to.cells.connectivity.len());
    for point in connectivity {
        let is_point = *point >= 0.0 && *point < piece.points as f64;
        to.cells
            .connectivity
            .push(is_point.then(|| first + *point as usize)?);
    }
    let mut before = 0.0;
    for (end, shape) in ends.iter().zip(shapes) {
        if !(*end >= before && *end <= connectivity.len() as f64) {
            return None;
        }
        before = *end;
        to.cells.ends.push(start + *end as usize);
        to.cells.shapes.push(*shape as u8);
    }
    (before == connectivity.len() as f64).then_some(())
}

impl Source for Grids {
    fn read(&mut self, frame: usize) -> Result<Frame, FrameError> {
        let parts = self.frames[frame].clone();
        let mut read = Values::default();
        for path in &parts {
            self.add(path, &mut read, 0)?;
        }
        let place = parts
            .first()
            .map(|path| Place::file(path))
            .unwrap_or_default();
        if read.points == 0 {
            return Err(FrameError::wrong(place, "a grid with points", HINT));
        }
        let has_data = self.plan.has_cells();
        let is_grid = read.cells.shapes.iter().any(|shape| *shape != VERTEX);
        let cells = Some(read.cells).filter(|_| is_grid || has_data);
        let mut own = self
            .plan
            .frame(&read.columns, read.points, cells)
            .map_err(|expected| FrameError::wrong(place.clone(), expected, HINT))?;
        own.source = place;
        Ok(own)
    }
}
