//! Readers of the formats, one for each.

mod blocks;
pub(crate) mod hdf5;
pub(crate) mod lammps;
pub(crate) mod numpy;
pub(crate) mod table;
pub(crate) mod vtk;
pub(crate) mod xyz;
mod zip;

use crate::columns::Plan;
use crate::error::FrameError;
use crate::frame::Frame;

/// Significant digits of numbers with 32 bits.
const SINGLE_DIGITS: u32 = 7;

/// Time of a frame, known before the frame is read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Stamp {
    pub time: Option<f64>,
    pub step: Option<u64>,
}

/// Files of one format, opened.
pub(crate) struct Opened {
    pub source: Box<dyn Source>,
    /// Frames in the order of the files.
    pub stamps: Vec<Stamp>,
    /// Columns of the first frame.
    pub plan: Plan,
    /// Significant digits of positions; `None` for binary numbers of double precision.
    pub digits: Option<u32>,
    /// Descriptions of contents that are skipped.
    pub ignored: Vec<String>,
}

/// Reader of the frames of one format.
pub(crate) trait Source: Send {
    /// Reads a frame by its number in the order of the files.
    fn read(&mut self, frame: usize) -> Result<Frame, FrameError>;

    /// Reads the rest of open data whose checksum is known only at their end, and compares it.
    fn check_rest(&mut self) -> Result<(), FrameError> {
        Ok(())
    }

    /// Prepares for reading frames in any order.
    fn shuffle(&mut self) -> Result<(), FrameError> {
        Ok(())
    }
}
