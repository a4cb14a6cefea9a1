//! The store in Zarr v3: one array a field, one chunk a tile, no shards, so that nobody ever writes to a file of another.

use super::folder::{Folder, unique};
use super::layout::FORMAT;
use super::occupancy::{Claim, Occupancy};
use super::{Column, Layout, ResultStore, StoreError, Tile, Tiling};
use serde_json::{Map, Value};
use std::ffi::OsString;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zarrs::array::{Array, ArrayError, ArrayMetadata, CodecOptions};
use zarrs::storage::StorageError;

/// The file of the metadata of a store, and of each array in it.
const METADATA: &str = "zarr.json";

/// A field or a coordinate.
#[derive(Debug)]
struct Named {
    name: String,
    array: Array<Folder>,
}

/// A store in a folder.
#[derive(Debug)]
pub struct ZarrStore {
    path: PathBuf,
    folder: Arc<Folder>,
    attributes: Map<String, Value>,
    tiling: Tiling,
    /// The first says that a tile is done.
    fields: Vec<Named>,
    /// Of who writes.
    occupancy: Option<Occupancy>,
}

impl ZarrStore {
    /// Makes a store.
    ///
    /// # Errors
    /// [`StoreError`] when something is there already, or it cannot be written.
    pub fn create(path: &Path, layout: &Layout) -> Result<Self, StoreError> {
        if let Some(group) = examine(path)? {
            return Err(Self::of_group(path, &group)?.in_the_way());
        }
        let building = sibling(path, "creating");
        let made = build(&building, layout).and_then(|()| {
            // Shared from its first moment, so that nobody clears it in between.
            let occupancy = Occupancy::shared(&building.join(METADATA))?;
            // Whoever comes first makes the store; the folders of the others are in its way.
            fs::rename(&building, path)?;
            Ok(occupancy)
        });
        let made = match made {
            Ok(occupancy) => {
                let mut store = Self::of_group(path, &layout.group())?;
                store.occupancy = Some(occupancy);
                Ok(store)
            }
            Err(error) => {
                // What is left of it is cleared by whoever opens the store.
                let _ = fs::remove_dir_all(&building);
                match examine(path)? {
                    Some(group) => Err(Self::of_group(path, &group)?.in_the_way()),
                    None => Err(StoreError::writing(path)(error)),
                }
            }
        };
        clear_siblings(path);
        made
    }

    /// Goes on with a store of the same layout, or makes it.
    ///
    /// # Errors
    /// [`StoreError`] when something else is there, the store holds something else or is damaged, or it cannot be written.
    pub fn resume(path: &Path, layout: &Layout) -> Result<Self, StoreError> {
        match Self::create(path, layout) {
            Err(StoreError::Exists { .. }) => Self::join(path, layout),
            other => other,
        }
    }

    /// Makes a store in the place of another, which is removed when the new one is there.
    ///
    /// # Errors
    /// [`StoreError`] when what is there is not a store of ours, others write to it, or it cannot be written.
    pub fn replace(path: &Path, layout: &Layout) -> Result<Self, StoreError> {
        if examine(path)?.is_none() {
            return Self::create(path, layout);
        }
        let writing = StoreError::writing(path);
        let claim = Occupancy::alone(&path.join(METADATA)).map_err(&writing)?;
        if matches!(claim, Claim::Shared) {
            return Err(StoreError::Occupied {
                path: path.to_owned(),
            });
        }
        let replaced = sibling(path, "replaced");
        fs::rename(path, &replaced).map_err(&writing)?;
        let made = Self::create(path, layout);
        if made.is_err() {
            fs::rename(&replaced, path).map_err(&writing)?;
        } else {
            // What cannot be removed now goes when the store is opened next.
            let _ = fs::remove_dir_all(&replaced);
        }
        made
    }

    /// Opens a store to read it.
    ///
    /// # Errors
    /// [`StoreError`] when there is none, or it is damaged.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        let group = examine(path)?.ok_or_else(|| StoreError::Missing {
            path: path.to_owned(),
        })?;
        Self::of_group(path, &group)
    }

    /// The attributes of the whole.
    pub fn attributes(&self) -> &Map<String, Value> {
        &self.attributes
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The names of the fields; the first says that a tile is done.
    pub fn fields(&self) -> impl Iterator<Item = &str> {
        self.fields.iter().map(|field| field.name.as_str())
    }

    /// How many tiles are done.
    ///
    /// # Errors
    /// [`StoreError`] when that cannot be read.
    pub fn done(&self) -> Result<usize, StoreError> {
        let mut done = 0;
        for tile in 0..self.tiling.tiles() {
            done += usize::from(self.is_done(tile)?);
        }
        Ok(done)
    }

    fn join(path: &Path, layout: &Layout) -> Result<Self, StoreError> {
        let occupancy =
            Occupancy::shared(&path.join(METADATA)).map_err(StoreError::reading(path))?;
        let group = examine(path)?.ok_or_else(|| StoreError::Missing {
            path: path.to_owned(),
        })?;
        let expected = layout.group();
        let found = fs::read(path.join(METADATA)).map_err(StoreError::reading(path))?;
        if found != text(&expected).as_bytes() {
            return Err(StoreError::OtherStudy {
                path: path.to_owned(),
                difference: difference(&group, &expected),
            });
        }
        let mut store = Self::of_group(path, &expected)?;
        store.check_arrays(layout)?;
        store.occupancy = Some(occupancy);
        clear_siblings(path);
        Ok(store)
    }

    /// Checks the metadata of each array, and the coordinates.
    fn check_arrays(&self, layout: &Layout) -> Result<(), StoreError> {
        for (name, metadata) in layout.arrays() {
            let key = format!("{name}/{METADATA}");
            let path = self.folder.path(&key);
            let found = self
                .folder
                .read(&key)
                .map_err(StoreError::reading(&path))?
                .unwrap_or_default();
            if found != text(&metadata).as_bytes() {
                let reason = "it does not say what onset has written".to_owned();
                return Err(StoreError::Damaged { path, reason });
            }
        }
        for (name, values) in layout.coordinates() {
            let array = array(&self.folder, &name, layout)
                .map_err(|error| self.damaged(&format!("{name}/{METADATA}"), error.to_string()))?;
            let key = array.chunk_key(&[0]).as_str().to_owned();
            if self.column(&array, &[0])? != Some(values) {
                return Err(self.damaged(&key, "it does not hold the coordinates".to_owned()));
            }
        }
        Ok(())
    }

    /// The error for a store that is in the way.
    fn in_the_way(&self) -> StoreError {
        match self.done() {
            Ok(done) => StoreError::Exists {
                path: self.path.clone(),
                done,
                tiles: self.tiling.tiles(),
            },
            Err(error) => error,
        }
    }

    /// The store that the metadata of the whole tell of.
    fn of_group(path: &Path, group: &Value) -> Result<Self, StoreError> {
        let damaged = |reason: String| StoreError::Damaged {
            path: path.join(METADATA),
            reason,
        };
        let folder = Arc::new(Folder::new(path));
        let arrays = group
            .pointer("/consolidated_metadata/metadata")
            .and_then(Value::as_object)
            .ok_or_else(|| damaged("it does not tell of the arrays".to_owned()))?;
        let mut fields = Vec::new();
        for (name, metadata) in arrays {
            let is_coordinate =
                metadata["dimension_names"] == Value::from([name.as_str()].as_slice());
            if !is_coordinate {
                let array = array_of(&folder, name, metadata)
                    .map_err(|error| damaged(error.to_string()))?;
                fields.push(Named {
                    name: name.clone(),
                    array,
                });
            }
        }
        let tiling = fields
            .first()
            .and_then(|mark| tiling(&mark.array))
            .ok_or_else(|| damaged("it does not tell of tiles".to_owned()))?;
        let attributes = group["attributes"].as_object().cloned().unwrap_or_default();
        Ok(Self {
            path: path.to_owned(),
            folder,
            attributes,
            tiling,
            fields,
            occupancy: None,
        })
    }

    fn damaged(&self, key: &str, reason: String) -> StoreError {
        StoreError::Damaged {
            path: self.folder.path(key),
            reason,
        }
    }

    /// The chunk of a tile in an array.
    fn chunk(&self, array: &Array<Folder>, tile: usize) -> Vec<u64> {
        let mut chunk: Vec<u64> = self
            .tiling
            .position(tile)
            .iter()
            .map(|index| *index as u64)
            .collect();
        chunk.resize(array.dimensionality(), 0);
        chunk
    }

    /// The values of a chunk, those beyond the edge of the map included.
    fn column(&self, array: &Array<Folder>, chunk: &[u64]) -> Result<Option<Column>, StoreError> {
        let read = if is_flags(array) {
            array
                .retrieve_chunk_if_exists::<Vec<i8>>(chunk)
                .map(|values| values.map(Column::Flags))
        } else {
            array
                .retrieve_chunk_if_exists::<Vec<f64>>(chunk)
                .map(|values| values.map(Column::Numbers))
        };
        read.map_err(|error| self.failure("read", array, chunk, error))
    }

    fn failure(
        &self,
        action: &'static str,
        array: &Array<Folder>,
        chunk: &[u64],
        error: ArrayError,
    ) -> StoreError {
        let path = self.folder.path(array.chunk_key(chunk).as_str());
        match error {
            ArrayError::StorageError(StorageError::IOError(error)) => StoreError::Machine {
                action,
                path,
                source: io::Error::new(error.kind(), error),
            },
            other => StoreError::Damaged {
                path,
                reason: other.to_string(),
            },
        }
    }
}

impl Drop for ZarrStore {
    /// The last who writes clears what killed processes have left.
    fn drop(&mut self) {
        let Some(occupancy) = self.occupancy.take() else {
            return;
        };
        drop(occupancy);
        match Occupancy::alone(&self.path.join(METADATA)) {
            Ok(Claim::Alone(_)) => self.folder.clear(),
            Ok(Claim::Unknown) => self.folder.clear_if_empty(),
            Ok(Claim::Shared) | Err(_) => {}
        }
    }
}

impl ResultStore for ZarrStore {
    fn tiling(&self) -> &Tiling {
        &self.tiling
    }

    fn is_done(&self, tile: usize) -> Result<bool, StoreError> {
        let Some(mark) = self.fields.first() else {
            return Ok(false);
        };
        let chunk = self.chunk(&mark.array, tile);
        let path = self.folder.path(mark.array.chunk_key(&chunk).as_str());
        fs::exists(&path).map_err(StoreError::reading(&path))
    }

    fn write(&self, tile: usize, columns: Vec<Column>) -> Result<(), StoreError> {
        let place = self.tiling.at(tile);
        // Chunks that hold nothing but the fill value are written too: of a tile that is done, a chunk that is absent is lost.
        let options = CodecOptions::default()
            .with_concurrent_target(1)
            .with_store_empty_chunks(true);
        for (field, column) in self.fields.iter().zip(columns).rev() {
            let chunk = self.chunk(&field.array, tile);
            let written = match column {
                Column::Flags(flags) => {
                    let padded = self.padded(&place, &flags, -1);
                    field.array.store_chunk_opt(&chunk, padded, &options)
                }
                Column::Numbers(numbers) => {
                    let padded = self.padded(&place, &numbers, f64::NAN);
                    field.array.store_chunk_opt(&chunk, padded, &options)
                }
            };
            written.map_err(|error| self.failure("write", &field.array, &chunk, error))?;
        }
        Ok(())
    }

    fn read(&self, field: &str, tile: usize) -> Result<Option<Column>, StoreError> {
        let Some(Named { array, .. }) = self.fields.iter().find(|named| named.name == field) else {
            return Err(StoreError::NoField {
                path: self.path.clone(),
                field: field.to_owned(),
                known: self.fields().map(str::to_owned).collect(),
            });
        };
        if !self.is_done(tile)? {
            return Ok(None);
        }
        let chunk = self.chunk(array, tile);
        let Some(column) = self.column(array, &chunk)? else {
            let key = array.chunk_key(&chunk);
            return Err(self.damaged(
                key.as_str(),
                "it is missing, though its tile is done".to_owned(),
            ));
        };
        let place = self.tiling.at(tile);
        Ok(Some(match column {
            Column::Flags(flags) => Column::Flags(self.cut(&place, &flags)),
            Column::Numbers(numbers) => Column::Numbers(self.cut(&place, &numbers)),
        }))
    }
}

impl ZarrStore {
    /// The runs of values that a tile and its chunk have in common: first value in the tile, in the chunk, and length.
    fn runs(&self, tile: &Tile, components: usize) -> impl Iterator<Item = [usize; 3]> + use<> {
        let (extent, chunk) = (tile.extent.clone(), self.tiling.tile.clone());
        let length = extent.last().copied().unwrap_or(0);
        let rows = tile.states().checked_div(length).unwrap_or(0);
        (0..rows).map(move |row| {
            let place = super::tiling::unravel(row * length, &extent);
            let in_chunk = super::tiling::ravel(&place, &chunk);
            [row * length, in_chunk, length].map(|states| states * components)
        })
    }

    /// The values of a tile in a whole chunk.
    fn padded<T: Copy>(&self, tile: &Tile, values: &[T], fill: T) -> Vec<T> {
        let components = values.len() / tile.states().max(1);
        let mut padded = vec![fill; self.tiling.tile.iter().product::<usize>() * components];
        for [from, to, length] in self.runs(tile, components) {
            padded[to..to + length].copy_from_slice(&values[from..from + length]);
        }
        padded
    }

    /// The values of a tile out of a whole chunk.
    fn cut<T: Copy>(&self, tile: &Tile, chunk: &[T]) -> Vec<T> {
        let components = chunk.len() / self.tiling.tile.iter().product::<usize>().max(1);
        let mut values = Vec::with_capacity(tile.states() * components);
        for [_, from, length] in self.runs(tile, components) {
            values.extend_from_slice(&chunk[from..from + length]);
        }
        values
    }
}

/// The metadata of the store at a place; `None` where there is nothing, or an empty folder.
fn examine(path: &Path) -> Result<Option<Value>, StoreError> {
    let reading = StoreError::reading(path);
    let nothing =
        |error: &io::Error| matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory);
    match fs::symlink_metadata(path) {
        Err(error) if nothing(&error) => return Ok(None),
        Err(error) => return Err(reading(error)),
        Ok(_) => {}
    }
    let not_a_store = || StoreError::NotAStore {
        path: path.to_owned(),
    };
    if !path.is_dir() {
        return Err(not_a_store());
    }
    let metadata = path.join(METADATA);
    let bytes = match fs::read(&metadata) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == ErrorKind::NotFound => {
            if [".zgroup", ".zarray", ".zmetadata"]
                .iter()
                .any(|name| path.join(name).exists())
            {
                return Err(StoreError::Foreign {
                    path: path.to_owned(),
                });
            }
            let is_empty = fs::read_dir(path).map_err(&reading)?.next().is_none();
            return if is_empty {
                Ok(None)
            } else {
                Err(not_a_store())
            };
        }
        Err(error) => return Err(StoreError::reading(&metadata)(error)),
    };
    let group: Value = serde_json::from_slice(&bytes).map_err(|error| StoreError::Damaged {
        path: metadata,
        reason: error.to_string(),
    })?;
    if group["attributes"].get(FORMAT).is_none() {
        return Err(StoreError::Foreign {
            path: path.to_owned(),
        });
    }
    Ok(Some(group))
}

/// Writes a store without tiles.
fn build(path: &Path, layout: &Layout) -> io::Result<()> {
    let folder = Arc::new(Folder::new(path));
    for (name, metadata) in layout.arrays() {
        folder.write(&format!("{name}/{METADATA}"), text(&metadata).as_bytes())?;
    }
    for (name, column) in layout.coordinates() {
        let array = array(&folder, &name, layout).map_err(io::Error::other)?;
        match column {
            Column::Flags(flags) => array.store_chunk(&[0], flags),
            Column::Numbers(numbers) => array.store_chunk(&[0], numbers),
        }
        .map_err(|error| match error {
            ArrayError::StorageError(StorageError::IOError(error)) => {
                io::Error::new(error.kind(), error)
            }
            other => io::Error::other(other),
        })?;
    }
    folder.write(METADATA, text(&layout.group()).as_bytes())?;
    folder.clear();
    Ok(())
}

/// The array of a name in a layout.
fn array(folder: &Arc<Folder>, name: &str, layout: &Layout) -> Result<Array<Folder>, ArrayError> {
    let metadata = layout.arrays().into_iter().find(|(other, _)| other == name);
    array_of(
        folder,
        name,
        &metadata.map(|(_, metadata)| metadata).unwrap_or_default(),
    )
}

fn array_of(
    folder: &Arc<Folder>,
    name: &str,
    metadata: &Value,
) -> Result<Array<Folder>, ArrayError> {
    let metadata: ArrayMetadata = serde_json::from_value(metadata.clone())
        .map_err(|error| ArrayError::Other(format!("array {name}: {error}")))?;
    Array::new_with_metadata(folder.clone(), &format!("/{name}"), metadata)
        .map_err(|error| ArrayError::Other(format!("array {name}: {error}")))
}

fn is_flags(array: &Array<Folder>) -> bool {
    *array.data_type() == zarrs::array::data_type::int8()
}

/// The tiles that the chunks of an array are.
fn tiling(array: &Array<Folder>) -> Option<Tiling> {
    let first = vec![0; array.dimensionality()];
    let tile = array.chunk_shape_usize(&first).ok()?;
    let shape = array
        .shape()
        .iter()
        .map(|states| *states as usize)
        .collect();
    Some(Tiling { shape, tile })
}

/// A place beside a path for what is not yet or no longer at it.
fn sibling(path: &Path, what: &str) -> PathBuf {
    let mut name = siblings(path, what);
    name.push(unique());
    path.with_file_name(name)
}

fn siblings(path: &Path, what: &str) -> OsString {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{what}-"));
    name
}

/// Removes what processes that were killed while they made or replaced a store have left beside it. Whoever is still making
/// one finds that the store is there already.
fn clear_siblings(path: &Path) {
    let folder = path
        .parent()
        .filter(|parent| !parent.as_os_str().is_empty());
    let Ok(entries) = fs::read_dir(folder.unwrap_or(Path::new("."))) else {
        return;
    };
    let prefixes = ["creating", "replaced"].map(|what| siblings(path, what));
    for entry in entries.flatten() {
        let name = entry.file_name();
        let is_left = prefixes.iter().any(|prefix| {
            name.as_encoded_bytes()
                .starts_with(prefix.as_encoded_bytes())
        });
        if is_left && path.join(METADATA).exists() {
            // What cannot be removed does no harm.
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

/// The text of metadata. The order of keys is that of the layout, so that the same layout is the same bytes.
fn text(metadata: &Value) -> String {
    format!("{metadata:#}\n")
}

/// The first thing in which the metadata of two stores differ.
fn difference(found: &Value, expected: &Value) -> String {
    let attributes = |group: &Value| group["attributes"].as_object().cloned().unwrap_or_default();
    let (found, expected) = (attributes(found), attributes(expected));
    let differing = expected
        .iter()
        .find(|(name, value)| found.get(*name) != Some(value));
    match differing {
        Some((name, Value::String(asked))) => {
            let stored = found.get(name).and_then(Value::as_str).unwrap_or_default();
            line_difference(name, stored, asked)
        }
        Some((name, asked)) => {
            let stored = found.get(name).unwrap_or(&Value::Null);
            format!("`{name}` is {stored} there and {asked} here")
        }
        None => "its axes or fields are others".to_owned(),
    }
}

fn line_difference(name: &str, stored: &str, asked: &str) -> String {
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    let (stored, asked) = (lines(stored), lines(asked));
    let count = stored.len().max(asked.len());
    let line = |lines: &[String], index: usize| lines.get(index).cloned().unwrap_or_default();
    let first = (0..count)
        .find(|index| line(&stored, *index) != line(&asked, *index))
        .unwrap_or(0);
    let place = if count > 1 {
        format!("line {} of `{name}`", first + 1)
    } else {
        format!("`{name}`")
    };
    format!(
        "{place} is `{}` there and `{}` here",
        line(&stored, first),
        line(&asked, first)
    )
}
