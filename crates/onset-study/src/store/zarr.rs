//! The store in Zarr v3: one array a field, one chunk a tile, no shards, so that nobody ever writes to a file of another.
//!
//! What is read is not trusted: metadata must be what onset writes, and chunks say themselves where they belong.

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

/// The file of the metadata of a store, and of each array in it.
pub(super) const METADATA: &str = "zarr.json";
/// The most bytes of metadata that are read; those of a study with long texts have some ten thousand.
const MOST_METADATA: u64 = 16 << 20;
/// The most values in a chunk: a tile of the largest edge, with three components.
const MOST_VALUES: usize = 4 << 20;

/// An array as its metadata tell.
#[derive(Clone, Debug)]
struct Array {
    name: String,
    shape: Vec<usize>,
    chunk: Vec<usize>,
    is_flags: bool,
    is_coordinate: bool,
}

impl Array {
    /// The array that metadata tell of, if they are such as onset writes.
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
            && values <= MOST_VALUES;
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

    /// The path of a chunk in the store.
    fn key(&self, chunk: &[usize]) -> String {
        let numbers: Vec<String> = chunk.iter().map(usize::to_string).collect();
        format!("{}/c/{}", self.name, numbers.join("/"))
    }

    /// Values in a chunk.
    fn values(&self) -> usize {
        self.chunk.iter().product()
    }
}

/// A store in a folder.
#[derive(Debug)]
pub struct ZarrStore {
    path: PathBuf,
    folder: Folder,
    attributes: Map<String, Value>,
    identity: String,
    tiling: Tiling,
    /// The first says that a tile is done.
    fields: Vec<Array>,
    /// Of who writes.
    occupancy: Option<Occupancy>,
}

impl ZarrStore {
    /// Makes a store.
    ///
    /// # Errors
    /// [`StoreError`] when something is there already, or it cannot be written.
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
            // Shared from its first moment, so that nobody clears it in between.
            let occupancy = Occupancy::shared(&building.join(METADATA))?;
            // Whoever comes first makes the store; the folders of the others are in its way.
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

    /// Makes a store in the place of another, which stays there until the new one is whole, and is then removed.
    ///
    /// # Errors
    /// [`StoreError`] when what is there is not a store of ours or holds something that is not, others write to it, or it cannot be
    /// written.
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
            // Somebody has put something there since: it is left where it can be found.
            let left = format!("onset-left-{}", folder::unique());
            fs::rename(&building, place.with_file_name(left)).map_err(&writing)?;
        }
        let mut store = Self::of_group(path, &layout.group())?;
        store.occupancy = occupancy;
        Ok(store)
    }

    /// Opens a store to read it.
    ///
    /// # Errors
    /// [`StoreError`] when there is none, or it is damaged.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        place(path)?;
        let group = examine_to_read(path)?.ok_or_else(|| StoreError::Missing {
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

    /// How many tiles are done. Only what is there is looked at, however many the metadata tell of.
    ///
    /// # Errors
    /// [`StoreError`] when that cannot be read.
    pub fn done(&self) -> Result<usize, StoreError> {
        let Some(mark) = self.fields.first() else {
            return Ok(0);
        };
        let chunks = self.folder.path(&format!("{}/c", mark.name));
        files_below(&chunks, &self.tiling.grid()).map_err(StoreError::reading(&chunks))
    }

    /// Checks that a store holds what a layout says, attributes apart.
    ///
    /// # Errors
    /// [`StoreError::Damaged`] where it does not.
    pub fn check(&self, layout: &Layout) -> Result<(), StoreError> {
        let group = examine_to_read(&self.path)?.unwrap_or_default();
        let expected = layout.group();
        let is_other = match earlier::is_of(&group) {
            // The names of keys are among what makes the identity.
            true => earlier::arrays(&group) != earlier::arrays(&expected),
            false => {
                group["consolidated_metadata"] != expected["consolidated_metadata"]
                    || self.identity != layout.identity
            }
        };
        if is_other {
            let reason = "its arrays are not those of its study".to_owned();
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
        let found = folder::read(&metadata, MOST_METADATA).map_err(StoreError::reading(path))?;
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
        // Clears what others have left beside it.
        drop(PrivateFolder::new(parent(place), STAGE));
        Ok(store)
    }

    /// Checks the metadata of each array.
    fn check_arrays(&self, layout: &Layout) -> Result<(), StoreError> {
        for (name, metadata) in layout.arrays() {
            let key = format!("{name}/{METADATA}");
            let found = self.folder.read(&key, MOST_METADATA);
            let found = found.map_err(StoreError::reading(&self.folder.path(&key)))?;
            if found.as_deref() != Some(text(&metadata).as_bytes()) {
                return Err(self.damaged(&key, "it does not say what onset has written".to_owned()));
            }
        }
        Ok(())
    }

    /// Checks the coordinates.
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
        let arrays = group
            .pointer("/consolidated_metadata/metadata")
            .and_then(Value::as_object)
            .ok_or_else(|| damaged("it does not tell of the arrays".to_owned()))?;
        let mut fields = Vec::new();
        for (name, metadata) in arrays {
            let array = Array::of(name, metadata).ok_or_else(|| {
                damaged("it tells of arrays that onset does not write".to_owned())
            })?;
            if !array.is_coordinate {
                fields.push(array);
            }
        }
        let tiling =
            tiling(&fields).ok_or_else(|| damaged("it does not tell of tiles".to_owned()))?;
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

    /// The path of the chunk of a tile in an array.
    fn chunk(&self, array: &Array, tile: usize) -> String {
        let mut chunk = self.tiling.position(tile);
        chunk.resize(array.shape.len(), 0);
        array.key(&chunk)
    }

    /// The values of a chunk, those beyond the edge of the map included.
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
        // Chunks that hold nothing but the fill value are written too: of a tile that is done, a chunk that is absent is lost.
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
            return Err(self.damaged(&key, "it is missing, though its tile is done".to_owned()));
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

/// Where a store is, links followed; where it will be, when nothing is there.
fn place(path: &Path) -> Result<PathBuf, StoreError> {
    if let Ok(place) = fs::canonicalize(path) {
        return Ok(place);
    }
    let place = std::path::absolute(path).map_err(StoreError::reading(path))?;
    recover(&place);
    Ok(place)
}

/// The folder that a place is in.
fn parent(place: &Path) -> &Path {
    place.parent().unwrap_or(place)
}

/// No folder can be put in the place of the one that we, and who has called us, are in.
fn refuse_current_folder(path: &Path, place: &Path) -> Result<(), StoreError> {
    let current = std::env::current_dir().and_then(fs::canonicalize);
    if current.is_ok_and(|current| current == place) || place.parent().is_none() {
        return Err(StoreError::CurrentFolder {
            path: path.to_owned(),
        });
    }
    Ok(())
}

/// Puts a folder in the place of another, and that one in its place: at once, where the system can.
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

/// Where a store waits that is being replaced, where that takes two steps.
fn aside(place: &Path) -> PathBuf {
    use sha2::{Digest, Sha256};
    let name = place.file_name().unwrap_or_default();
    let sum = format!("{:x}", Sha256::digest(name.as_encoded_bytes()));
    place.with_file_name(format!(".onset-replaced-{}", &sum[..32]))
}

/// Puts a store back that was being replaced when the process was killed between two steps.
fn recover(place: &Path) {
    if fs::symlink_metadata(place).is_err() {
        // Usually there is none.
        let _ = fs::rename(aside(place), place);
    }
}

/// The metadata of the store at a place; `None` where there is nothing, or an empty folder.
fn examine(path: &Path) -> Result<Option<Value>, StoreError> {
    let group = examine_any(path)?;
    of_format(path, &group)?;
    Ok(group)
}

/// The same for a store that is read, which may be of the format before.
fn examine_to_read(path: &Path) -> Result<Option<Value>, StoreError> {
    let group = examine_any(path)?;
    if !group.as_ref().is_some_and(earlier::is_of) {
        of_format(path, &group)?;
    }
    Ok(group)
}

/// That a store is of this format.
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

/// The same for a store of any version.
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
        folder::read(&metadata, MOST_METADATA).map_err(StoreError::reading(&metadata))?
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

/// The tiles that the chunks of fields are: the same of all of them.
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

/// How many files are in folders of folders whose names are numbers below given ones.
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

/// The text of metadata. The order of keys is that of the layout, so that the same layout is the same bytes.
fn text(metadata: &Value) -> String {
    format!("{metadata:#}\n")
}

/// The first thing in which the metadata of two stores differ.
fn difference(found: &Value, expected: &Value) -> String {
    let attributes = |group: &Value| group["attributes"].as_object().cloned().unwrap_or_default();
    let (found, expected) = (attributes(found), attributes(expected));
    // Titles follow from what else differs.
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
        None => "its axes or fields are others".to_owned(),
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
