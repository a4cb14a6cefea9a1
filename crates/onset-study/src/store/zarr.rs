//! Store in Zarr v3: one array per field and one chunk per tile, without shards, so that no two processes write to the same file.
//!
//! Files are validated when read: metadata must have the form that onset writes, and chunks record their position.

use super::chunk::{self, Label};
use super::earlier;
use super::folder::{self, Folder, PARTIAL};
use super::layout::{self, FORMAT, FORMAT_VERSION, IDENTITY};
use super::occupancy::{Claim, Occupancy, Taken};
use super::replace::Contents;
use super::{Column, Layout, ResultStore, StoreError, Tile, Tiling};
use crate::output::STAGE;
use onset_umat::PrivateFolder;
use serde_json::{Map, Value};
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// File name of the metadata of a store, and of each array in it.
pub(super) const METADATA: &str = "zarr.json";
/// Largest size of metadata that is read, in bytes; studies with long texts have about ten thousand.
const MAX_METADATA_BYTES: u64 = 16 << 20;
/// Largest number of values in a chunk: a tile with the largest edge, with three components.
const MAX_CHUNK_VALUES: usize = 4 << 20;

/// Array according to its metadata.
#[derive(Clone, Debug)]
struct Array {
    name: String,
    shape: Vec<usize>,
    chunk: Vec<usize>,
    is_flags: bool,
    is_coordinate: bool,
}

impl Array {
    /// Array described by metadata, or `None` if they do not have the form that onset writes.
    fn of(name: &str, metadata: &Value) -> Option<Self> {
        let sizes = |value: &Value| -> Option<Vec<usize>> {
            let size = |value: &Value| {
                usize::try_from(value.as_u64()?)
                    .ok()
                    .filter(|size| *size > 0)
            };
            value.as_array()?.iter().map(size).collect()
        };
        let shape = sizes(&metadata["shape"])?;
        let chunk = sizes(&metadata["chunk_grid"]["configuration"]["chunk_shape"])?;
        let names = metadata["dimension_names"].as_array()?.iter();
        let names: Vec<&str> = names.map(Value::as_str).collect::<Option<_>>()?;
        let kind = metadata["data_type"].as_str()?;
        let values = chunk
            .iter()
            .try_fold(1_usize, |all, size| all.checked_mul(*size))?;
        let is_coordinate = names == [name];
        let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "-_.".contains(letter);
        let is_sound = name.chars().all(is_plain)
            && name.starts_with(|letter: char| letter.is_ascii_alphanumeric())
            && ["int8", "float64"].contains(&kind)
            && (1..=4).contains(&shape.len())
            && shape.len() == chunk.len()
            && shape.len() == names.len()
            && values <= MAX_CHUNK_VALUES;
        let (fill, attributes) = (&metadata["fill_value"], &metadata["attributes"]);
        let written = layout::array(
            &shape,
            &chunk,
            &names,
            kind,
            fill.clone(),
            attributes.clone(),
        );
        (is_sound && written == *metadata).then(|| Self {
            name: name.to_owned(),
            is_flags: kind == "int8",
            shape,
            chunk,
            is_coordinate,
        })
    }

    /// Path of a chunk in the store.
    fn key(&self, chunk: &[usize]) -> String {
        let numbers: Vec<String> = chunk.iter().map(usize::to_string).collect();
        format!("{}/c/{}", self.name, numbers.join("/"))
    }

    /// Number of values in a chunk.
    fn values(&self) -> usize {
        self.chunk.iter().product()
    }
}

/// Store of results in a folder.
#[derive(Debug)]
pub struct ZarrStore {
    path: PathBuf,
    folder: Folder,
    attributes: Map<String, Value>,
    identity: String,
    tiling: Tiling,
    /// Fields of the store; the first field marks a tile as finished.
    fields: Vec<Array>,
    /// Lock of a writing process.
    occupancy: Option<Occupancy>,
}

impl ZarrStore {
    /// Creates a store without tiles.
    ///
    /// # Errors
    /// [`StoreError`] if the path exists or the store cannot be written.
    pub fn create(path: &Path, layout: &Layout) -> Result<Self, StoreError> {
        let place = &place(path)?;
        if let Some(group) = examine(path)? {
            return Err(Self::of_group(path, &group)?.in_the_way());
        }
        refuse_current_folder(path, place)?;
        let writing = StoreError::writing(path);
        let folder = parent(place);
        fs::create_dir_all(folder).map_err(&writing)?;
        let stage = PrivateFolder::new(folder, STAGE).map_err(&writing)?;
        let building = stage.path().join("store");
        let made = build(&building, layout).and_then(|()| {
            // The store is marked as occupied before it gets its name, so that no other process clears it in between.
            let occupancy = Occupancy::shared(&building.join(METADATA))?;
            // If several processes create the store, the first rename succeeds and the others fail.
            fs::rename(&building, place)?;
            Ok(occupancy)
        });
        match made {
            Ok(occupancy) => {
                let mut store = Self::of_group(path, &layout.group())?;
                store.occupancy = occupancy;
                Ok(store)
            }
            Err(error) => match examine(path)? {
                Some(group) => Err(Self::of_group(path, &group)?.in_the_way()),
                None => Err(writing(error)),
            },
        }
    }

    /// Resumes a store with the same layout, or creates it.
    ///
    /// # Errors
    /// [`StoreError`] if the path is not such a store, the store is damaged, or it cannot be written.
    pub fn resume(path: &Path, layout: &Layout) -> Result<Self, StoreError> {
        match Self::create(path, layout) {
            Err(StoreError::Exists { .. }) => Self::join(path, layout),
            other => other,
        }
    }

    /// Replaces a store. The previous store is removed only after the new store is complete.
    ///
    /// # Errors
    /// [`StoreError`] if the path is not a store of onset or contains foreign files, other processes write to it, or it cannot be written.
    pub fn replace(path: &Path, layout: &Layout) -> Result<Self, StoreError> {
        let place = &place(path)?;
        let Some(group) = examine_any(path)? else {
            return Self::create(path, layout);
        };
        if fs::symlink_metadata(path).is_ok_and(|found| found.is_symlink()) {
            return Err(StoreError::Link {
                path: path.to_owned(),
                target: place.clone(),
            });
        }
        refuse_current_folder(path, place)?;
        let writing = StoreError::writing(path);
        let claim = Occupancy::alone(&place.join(METADATA)).map_err(&writing)?;
        if matches!(claim, Claim::Shared) {
            return Err(StoreError::Occupied {
                path: path.to_owned(),
            });
        }
        let contents = Contents::of(place, &group)
            .map_err(StoreError::reading(path))?
            .map_err(|stranger| StoreError::NotOurs { path: stranger })?;
        let stage = PrivateFolder::new(parent(place), STAGE).map_err(&writing)?;
        let building = stage.path().join("store");
        build(&building, layout).map_err(&writing)?;
        let occupancy = Occupancy::shared(&building.join(METADATA)).map_err(&writing)?;
        exchange(&building, place).map_err(&writing)?;
        if contents.remove(&building).is_err() {
            // Another process has created a file in the meantime: it is kept under another name.
            let left = format!("onset-left-{}", folder::unique());
            fs::rename(&building, place.with_file_name(left)).map_err(&writing)?;
        }
        let mut store = Self::of_group(path, &layout.group())?;
        store.occupancy = occupancy;
        Ok(store)
    }

    /// Opens a store for reading.
    ///
    /// # Errors
    /// [`StoreError`] if it does not exist or is damaged.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        place(path)?;
        let group = examine_to_read(path)?.ok_or_else(|| StoreError::Missing {
            path: path.to_owned(),
        })?;
        Self::of_group(path, &group)
    }

    /// Attributes of the store.
    pub fn attributes(&self) -> &Map<String, Value> {
        &self.attributes
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names of the fields; the first field marks a tile as finished.
    pub fn fields(&self) -> impl Iterator<Item = &str> {
        self.fields.iter().map(|field| field.name.as_str())
    }

    /// Number of finished tiles. Counts the existing chunks, for any number of tiles in the metadata.
    ///
    /// # Errors
    /// [`StoreError`] if the store cannot be read.
    pub fn done(&self) -> Result<usize, StoreError> {
        let Some(mark) = self.fields.first() else {
            return Ok(0);
        };
        let chunks = self.folder.path(&format!("{}/c", mark.name));
        files_below(&chunks, &self.tiling.grid()).map_err(StoreError::reading(&chunks))
    }

    /// Checks that a store agrees with a layout, apart from its attributes.
    ///
    /// # Errors
    /// [`StoreError::Damaged`] if it does not.
    pub fn check(&self, layout: &Layout) -> Result<(), StoreError> {
        let group = examine_to_read(&self.path)?.unwrap_or_default();
        let expected = layout.group();
        // The identity covers names of keys, which have changed since the previous format.
        let is_other = earlier::arrays(&group) != earlier::arrays(&expected)
            || !earlier::is_of(&group) && self.identity != layout.identity;
        if is_other {
            let reason = "its arrays do not match its study".to_owned();
            return Err(self.damaged(METADATA, reason));
        }
        self.check_coordinates(layout)
    }

    fn join(path: &Path, layout: &Layout) -> Result<Self, StoreError> {
        let place = &place(path)?;
        let metadata = place.join(METADATA);
        let occupancy = Occupancy::shared(&metadata).map_err(StoreError::reading(path))?;
        let occupancy = occupancy.ok_or_else(|| StoreError::Locked {
            path: path.to_owned(),
        })?;
        let group = examine(path)?.ok_or_else(|| StoreError::Missing {
            path: path.to_owned(),
        })?;
        let expected = layout.group();
        let found =
            folder::read(&metadata, MAX_METADATA_BYTES).map_err(StoreError::reading(path))?;
        if found.as_deref() != Some(text(&expected).as_bytes()) {
            return Err(StoreError::OtherStudy {
                path: path.to_owned(),
                difference: difference(&group, &expected),
            });
        }
        let mut store = Self::of_group(path, &expected)?;
        store.check_arrays(layout)?;
        store.check_coordinates(layout)?;
        store.occupancy = Some(occupancy);
        // Clears leftovers of other processes next to the store.
        drop(PrivateFolder::new(parent(place), STAGE));
        Ok(store)
    }

    /// Checks the metadata of each array.
    fn check_arrays(&self, layout: &Layout) -> Result<(), StoreError> {
        for (name, metadata) in layout.arrays() {
            let key = format!("{name}/{METADATA}");
            let found = self.folder.read(&key, MAX_METADATA_BYTES);
            let found = found.map_err(StoreError::reading(&self.folder.path(&key)))?;
            if found.as_deref() != Some(text(&metadata).as_bytes()) {
                return Err(self.damaged(
                    &key,
                    "it differs from the metadata that onset wrote".to_owned(),
                ));
            }
        }
        Ok(())
    }

    /// Checks the coordinates along every dimension.
    fn check_coordinates(&self, layout: &Layout) -> Result<(), StoreError> {
        let arrays = layout.arrays();
        for (name, values) in layout.coordinates() {
            let metadata = arrays.iter().find(|(other, _)| *other == name);
            let array = metadata.and_then(|(_, metadata)| Array::of(&name, metadata));
            let found = match &array {
                Some(array) => self.column(array, &[0])?,
                None => None,
            };
            if found != Some(values) {
                let key = format!("{name}/c/0");
                return Err(self.damaged(&key, "it does not contain the coordinates".to_owned()));
            }
        }
        Ok(())
    }

    /// Error for an existing store.
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

    /// Store described by the metadata in its root file.
    fn of_group(path: &Path, group: &Value) -> Result<Self, StoreError> {
        let damaged = |reason: String| StoreError::Damaged {
            path: path.join(METADATA),
            reason,
        };
        let arrays = group
            .pointer("/consolidated_metadata/metadata")
            .and_then(Value::as_object)
            .ok_or_else(|| damaged("it does not list the arrays".to_owned()))?;
        let mut fields = Vec::new();
        for (name, metadata) in arrays {
            let array = Array::of(name, metadata)
                .ok_or_else(|| damaged("it lists arrays that onset does not write".to_owned()))?;
            if !array.is_coordinate {
                fields.push(array);
            }
        }
        let tiling =
            tiling(&fields).ok_or_else(|| damaged("it does not define tiles".to_owned()))?;
        let attributes = group["attributes"].as_object().cloned().unwrap_or_default();
        let identity = attributes.get(IDENTITY).and_then(Value::as_str);
        Ok(Self {
            path: path.to_owned(),
            folder: Folder::new(path),
            identity: identity.unwrap_or_default().to_owned(),
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

    /// Path of the chunk of a tile in an array.
    fn chunk(&self, array: &Array, tile: usize) -> String {
        let mut chunk = self.tiling.position(tile);
        chunk.resize(array.shape.len(), 0);
        array.key(&chunk)
    }

    /// Values of a chunk, including those beyond the edge of the map.
    fn column(&self, array: &Array, chunk: &[usize]) -> Result<Option<Column>, StoreError> {
        self.values(array, &array.key(chunk))
    }

    fn values(&self, array: &Array, key: &str) -> Result<Option<Column>, StoreError> {
        let size = if array.is_flags { 1 } else { 8 };
        let read = self.folder.read(key, chunk::largest(size * array.values()));
        let Some(bytes) = read.map_err(StoreError::reading(&self.folder.path(key)))? else {
            return Ok(None);
        };
        let label = Label {
            key,
            identity: &self.identity,
        };
        let column = chunk::decode(&bytes, array.is_flags, array.values(), label);
        column.map(Some).map_err(|reason| self.damaged(key, reason))
    }
}

impl Drop for ZarrStore {
    /// Removes the files left by killed processes, if this is the last writer.
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
        let path = self.folder.path(&self.chunk(mark, tile));
        fs::exists(&path).map_err(StoreError::reading(&path))
    }

    fn take(&self, tile: usize) -> Result<Option<Taken>, StoreError> {
        let lock = format!("{PARTIAL}/tile-{tile}");
        let taken = self.folder.take(&lock);
        taken.map_err(StoreError::writing(&self.folder.path(&lock)))
    }

    fn write(&self, tile: usize, columns: Vec<Column>) -> Result<(), StoreError> {
        let place = self.tiling.at(tile);
        // Chunks with fill values only are written too, because a missing chunk of a finished tile counts as lost.
        for (field, column) in self.fields.iter().zip(columns).rev() {
            let key = self.chunk(field, tile);
            let padded = match column {
                whole if place.extent == self.tiling.tile => whole,
                Column::Flags(flags) => Column::Flags(self.padded(&place, &flags, -1)),
                Column::Numbers(numbers) => {
                    Column::Numbers(self.padded(&place, &numbers, f64::NAN))
                }
            };
            let label = Label {
                key: &key,
                identity: &self.identity,
            };
            chunk::encode(&padded, label)
                .and_then(|bytes| self.folder.write(&key, &bytes))
                .map_err(StoreError::writing(&self.folder.path(&key)))?;
        }
        Ok(())
    }

    fn read(&self, field: &str, tile: usize) -> Result<Option<Column>, StoreError> {
        let Some(array) = self.fields.iter().find(|array| array.name == field) else {
            return Err(StoreError::NoField {
                path: self.path.clone(),
                field: field.to_owned(),
                known: self.fields().map(str::to_owned).collect(),
            });
        };
        if !self.is_done(tile)? {
            return Ok(None);
        }
        let key = self.chunk(array, tile);
        let Some(column) = self.values(array, &key)? else {
            return Err(self.damaged(
                &key,
                "it is missing, although its tile is complete".to_owned(),
            ));
        };
        let place = self.tiling.at(tile);
        Ok(Some(match column {
            whole if place.extent == self.tiling.tile => whole,
            Column::Flags(flags) => Column::Flags(self.cut(&place, &flags)),
            Column::Numbers(numbers) => Column::Numbers(self.cut(&place, &numbers)),
        }))
    }
}

impl ZarrStore {
    /// Contiguous values common to a tile and its chunk: first value in the tile, first value in the chunk, and length.
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

    /// Pads the values of a tile to a whole chunk.
    fn padded<T: Copy>(&self, tile: &Tile, values: &[T], fill: T) -> Vec<T> {
        let components = values.len() / tile.states().max(1);
        let mut padded = vec![fill; self.tiling.tile.iter().product::<usize>() * components];
        for [from, to, length] in self.runs(tile, components) {
            padded[to..to + length].copy_from_slice(&values[from..from + length]);
        }
        padded
    }

    /// Extracts the values of a tile from a whole chunk.
    fn cut<T: Copy>(&self, tile: &Tile, chunk: &[T]) -> Vec<T> {
        let components = chunk.len() / self.tiling.tile.iter().product::<usize>().max(1);
        let mut values = Vec::with_capacity(tile.states() * components);
        for [_, from, length] in self.runs(tile, components) {
            values.extend_from_slice(&chunk[from..from + length]);
        }
        values
    }
}

/// Canonical path of a store; the future path if it does not exist.
fn place(path: &Path) -> Result<PathBuf, StoreError> {
    if let Ok(place) = fs::canonicalize(path) {
        return Ok(place);
    }
    let place = std::path::absolute(path).map_err(StoreError::reading(path))?;
    recover(&place);
    Ok(place)
}

/// Parent folder of a path.
fn parent(place: &Path) -> &Path {
    place.parent().unwrap_or(place)
}

/// Refuses to replace the current folder, which would invalidate the working directory of this process and its parent.
fn refuse_current_folder(path: &Path, place: &Path) -> Result<(), StoreError> {
    let current = std::env::current_dir().and_then(fs::canonicalize);
    if current.is_ok_and(|current| current == place) || place.parent().is_none() {
        return Err(StoreError::CurrentFolder {
            path: path.to_owned(),
        });
    }
    Ok(())
}

/// Exchanges two folders, atomically if the system supports it.
fn exchange(new: &Path, old: &Path) -> io::Result<()> {
    #[cfg(target_os = "linux")]
    {
        use rustix::fs::{CWD, RenameFlags, renameat_with};
        if renameat_with(CWD, new, CWD, old, RenameFlags::EXCHANGE).is_ok() {
            return Ok(());
        }
    }
    let aside = aside(old);
    fs::rename(old, &aside)?;
    let renamed = fs::rename(new, old);
    let (from, to) = match renamed {
        Ok(()) => (&*aside, new),
        Err(_) => (&*aside, old),
    };
    fs::rename(from, to)?;
    renamed
}

/// Temporary path of a replaced store, on systems without an atomic exchange.
fn aside(place: &Path) -> PathBuf {
    use sha2::{Digest, Sha256};
    let name = place.file_name().unwrap_or_default();
    let sum = format!("{:x}", Sha256::digest(name.as_encoded_bytes()));
    place.with_file_name(format!(".onset-replaced-{}", &sum[..32]))
}

/// Restores a store if the process was killed between the two steps of an exchange.
fn recover(place: &Path) {
    if fs::symlink_metadata(place).is_err() {
        // Usually there is nothing to restore.
        let _ = fs::rename(aside(place), place);
    }
}

/// Metadata of the store at a path; `None` if the path does not exist or is an empty folder.
fn examine(path: &Path) -> Result<Option<Value>, StoreError> {
    let group = examine_any(path)?;
    of_format(path, &group)?;
    Ok(group)
}

/// Metadata of a store that is only read, which may have the previous format.
fn examine_to_read(path: &Path) -> Result<Option<Value>, StoreError> {
    let group = examine_any(path)?;
    if !group.as_ref().is_some_and(earlier::is_of) {
        of_format(path, &group)?;
    }
    Ok(group)
}

/// Checks that a store has the current format.
fn of_format(path: &Path, group: &Option<Value>) -> Result<(), StoreError> {
    match group.as_ref().map(|group| &group["attributes"][FORMAT]) {
        Some(format) if *format != FORMAT_VERSION => Err(StoreError::Format {
            path: path.to_owned(),
            found: format.to_string().chars().take(20).collect(),
            expected: FORMAT_VERSION,
        }),
        _ => Ok(()),
    }
}

/// Metadata of the store at a path, in any version of the format.
fn examine_any(path: &Path) -> Result<Option<Value>, StoreError> {
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
    let Some(bytes) =
        folder::read(&metadata, MAX_METADATA_BYTES).map_err(StoreError::reading(&metadata))?
    else {
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
    let folder = Folder::new(path);
    fs::create_dir_all(path)?;
    for (name, metadata) in layout.arrays() {
        folder.write(&format!("{name}/{METADATA}"), text(&metadata).as_bytes())?;
    }
    for (name, column) in layout.coordinates() {
        let key = format!("{name}/c/0");
        let label = Label {
            key: &key,
            identity: &layout.identity,
        };
        folder.write(&key, &chunk::encode(&column, label)?)?;
    }
    folder.write(METADATA, text(&layout.group()).as_bytes())?;
    folder.clear();
    Ok(())
}

/// Tiling given by the chunks of the fields, which must all agree.
fn tiling(fields: &[Array]) -> Option<Tiling> {
    let mark = fields.first()?;
    let dimensions = mark.shape.len();
    let is_alike = |field: &Array| {
        let vector = field
            .shape
            .get(dimensions..)
            .is_some_and(|more| more.len() <= 1);
        vector
            && field.shape[..dimensions] == mark.shape
            && field.chunk[..dimensions] == mark.chunk
            && field.shape[dimensions..] == field.chunk[dimensions..]
    };
    let is_countable = mark
        .shape
        .iter()
        .try_fold(1_usize, |all, size| all.checked_mul(*size));
    (mark.is_flags && fields.iter().all(is_alike) && is_countable.is_some()).then(|| Tiling {
        shape: mark.shape.clone(),
        tile: mark.chunk.clone(),
    })
}

/// Counts files in nested folders whose names are numbers below the given limits.
fn files_below(folder: &Path, grid: &[usize]) -> io::Result<usize> {
    let Some((end, deeper)) = grid.split_first() else {
        return Ok(1);
    };
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(0),
        entries => entries?,
    };
    let mut files = 0;
    for entry in entries {
        let entry = entry?;
        let name = entry.file_name();
        let number = name.to_str().and_then(|name| {
            let number = name.parse::<usize>().ok()?;
            (number.to_string() == name).then_some(number)
        });
        if number.is_some_and(|number| number < *end) {
            files += files_below(&entry.path(), deeper)?;
        }
    }
    Ok(files)
}

/// Text of metadata. Keys are in the order of the layout, so that equal layouts give identical bytes.
fn text(metadata: &Value) -> String {
    format!("{metadata:#}\n")
}

/// First difference between the metadata of two stores.
fn difference(found: &Value, expected: &Value) -> String {
    let attributes = |group: &Value| group["attributes"].as_object().cloned().unwrap_or_default();
    let (found, expected) = (attributes(found), attributes(expected));
    // Titles follow from other differences, and are compared last.
    let differing = expected
        .iter()
        .filter(|(name, value)| found.get(*name) != Some(value))
        .min_by_key(|(name, _)| *name == "title");
    let stored = |name: &str| found.get(name).and_then(Value::as_str).unwrap_or("none");
    match differing {
        Some((name, Value::String(asked))) => {
            let stored = stored(name);
            match layout::MEANINGS.iter().find(|(known, _)| known == name) {
                Some((_, meaning)) => format!("{meaning} (`{stored}` there, `{asked}` here)"),
                None => line_difference(name, stored, asked),
            }
        }
        Some((name, asked)) => {
            let stored = found.get(name).unwrap_or(&Value::Null);
            format!("`{name}` is {stored} there and {asked} here")
        }
        None => "its axes or fields differ".to_owned(),
    }
}

fn line_difference(name: &str, stored: &str, asked: &str) -> String {
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    let (stored, asked) = (lines(stored), lines(asked));
    let count = stored.len().max(asked.len());
    let line = |lines: &[String], index: usize| lines.get(index).cloned().unwrap_or_default();
    let first = (0..count)
        .filter(|index| line(&stored, *index) != line(&asked, *index))
        .min_by_key(|index| line(&asked, *index).starts_with("title = "))
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
