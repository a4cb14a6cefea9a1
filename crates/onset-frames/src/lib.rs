//! Frames of particles, streamed from the output files of simulation codes.
//!
//! A [`Series`] is opened from one or more files. It recognizes the format from the contents. The names of columns identify positions, velocities,
//! deformation gradients and stresses, unless a [`Reading`] assigns them. The series yields one [`Frame`] after the other in order of time. At most two
//! frames are in memory.
//!
//! Files are not trusted: sizes are bounded by the length of the file before memory is reserved, lines have a maximum length, pipes and devices are
//! not opened, and an error quotes at most one word of a file.
//!
//! | format | recognized by |
//! |---|---|
//! | LAMMPS text dump | `ITEM:` in the first line |
//! | VTK XML (`.vtu`, `.vtp`, `.pvtu`, `.pvtp`, `.pvd`) | `<VTKFile` |
//! | NumPy (`.npz`, `.npy`) | signature |
//! | extended XYZ (`.xyz`) | number of particles in the first line |
//! | table (`.csv`, `.tsv`) | any other text |
//!
//! Text may be compressed with gzip.

mod columns;
mod error;
mod formats;
mod frame;
pub mod input;
mod reading;
mod series;
mod text;

pub use columns::{ColumnUse, Support};
pub use error::{FrameError, Place, brief, cut};
pub use frame::{Bounds, Cells, Frame, Order};
pub use reading::{FrameRange, Limits, Quantity, Reading};
pub use series::{Format, Recognized, Series, told_repeats};
