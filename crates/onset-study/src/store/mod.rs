//! Results that survive: a store of tiles, written one by one, by one process or several, and never half.
//!
//! A [`Layout`] says what a store holds: dimensions, fields, tiles, attributes. The tile is the unit of work and of writing:
//! a [`ResultStore`] writes the values of all fields on one tile, that of the first field last, which is what says that the
//! tile is done. [`ZarrStore`] is one in Zarr v3, a folder that xarray opens.

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

/// The values of a field, component running fastest, then the first axis.
#[derive(Clone, Debug, PartialEq)]
pub enum Column {
    /// Values of a field of flags.
    Flags(Vec<i8>),
    /// Values of a field of numbers.
    Numbers(Vec<f64>),
}

impl Column {
    /// The flags; nothing for numbers.
    pub fn flags(&self) -> &[i8] {
        match self {
            Self::Flags(flags) => flags,
            Self::Numbers(_) => &[],
        }
    }

    /// The numbers; nothing for flags.
    pub fn numbers(&self) -> &[f64] {
        match self {
            Self::Flags(_) => &[],
            Self::Numbers(numbers) => numbers,
        }
    }
}

/// Where results are kept, tile by tile.
pub trait ResultStore: Sync {
    /// How the states are cut into tiles.
    fn tiling(&self) -> &Tiling;

    /// Whether a tile is done.
    ///
    /// # Errors
    /// [`StoreError`] when that cannot be read.
    fn is_done(&self, tile: usize) -> Result<bool, StoreError>;

    /// Takes a tile, so that others who work on the same store compute other ones meanwhile; `None` where somebody else has it.
    ///
    /// # Errors
    /// [`StoreError`] when the store cannot be written.
    fn take(&self, tile: usize) -> Result<Option<Taken>, StoreError>;

    /// Writes all fields of a tile, in the order of the layout. Afterwards it is done; before, it is not.
    ///
    /// # Errors
    /// [`StoreError`] when a file cannot be written.
    fn write(&self, tile: usize, columns: Vec<Column>) -> Result<(), StoreError>;

    /// The values of a field on a tile; `None` where they are still to be computed.
    ///
    /// # Errors
    /// [`StoreError`] when there is no such field, or its chunk cannot be read or is damaged.
    fn read(&self, field: &str, tile: usize) -> Result<Option<Column>, StoreError>;
}
