//! Persistent results: a store of tiles, each written completely or not at all, by one process or several.
//!
//! A [`Layout`] describes a store: dimensions, fields, tiles, attributes. The tile is the unit of work and of writing: a [`ResultStore`] writes the
//! values of all fields on one tile. The first field is written last and marks the tile as finished. [`ZarrStore`] implements the store in Zarr v3,
//! as a folder that xarray opens.

mod chunk;
mod earlier;
mod error;
mod folder;
mod layout;
mod occupancy;
mod replace;
mod tiling;
mod zarr;

pub use error::StoreError;
pub(crate) use layout::LIBRARY;
pub use layout::{Dimension, Field, Kind, Layout};
pub use occupancy::Taken;
pub use tiling::{Tile, Tiling};
pub(crate) use tiling::{ravel, unravel};
pub use zarr::ZarrStore;

/// Values of a field on a tile; components vary fastest, then the first axis.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// Values of a field of flags.
    Flags(Vec<i8>),
    /// Values of a field of numbers.
    Numbers(Vec<f64>),
}

impl Column {
    /// Flags, or an empty slice for numbers.
    pub fn flags(&self) -> &[i8] {
        match self {
            Self::Flags(flags) => flags,
            Self::Numbers(_) => &[],
        }
    }

    /// Numbers, or an empty slice for flags.
    pub fn numbers(&self) -> &[f64] {
        match self {
            Self::Flags(_) => &[],
            Self::Numbers(numbers) => numbers,
        }
    }
}

/// Storage of results, tile by tile.
pub trait ResultStore: Sync {
    /// Division of the states into tiles.
    fn tiling(&self) -> &Tiling;

    /// Returns true if a tile is finished.
    ///
    /// # Errors
    /// [`StoreError`] if the store cannot be read.
    fn is_done(&self, tile: usize) -> Result<bool, StoreError>;

    /// Reserves a tile, so that other processes compute other tiles meanwhile; `None` if another process holds it.
    ///
    /// # Errors
    /// [`StoreError`] if the store cannot be written.
    fn take(&self, tile: usize) -> Result<Option<Taken>, StoreError>;

    /// Writes all fields of a tile, in the order of the layout, and thereby marks it as finished.
    ///
    /// # Errors
    /// [`StoreError`] if a file cannot be written.
    fn write(&self, tile: usize, columns: Vec<Column>) -> Result<(), StoreError>;

    /// Values of a field on a tile, or `None` if they are not computed yet.
    ///
    /// # Errors
    /// [`StoreError`] if the field does not exist, or its chunk cannot be read or is damaged.
    fn read(&self, field: &str, tile: usize) -> Result<Option<Column>, StoreError>;
}
