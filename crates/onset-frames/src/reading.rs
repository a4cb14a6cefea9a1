//! Choices of the user: columns, frames, limits.

use crate::error::FrameError;
use std::fmt;
use std::str::FromStr;

/// Choices of the user; columns that are not named are guessed.
#[derive(Clone, Debug, Default)]
pub struct Reading {
    /// Columns of quantities: one name of a vector or matrix, or the names of its components in order.
    ///
    /// A stress has three components (xx, yy, xy), four (xx, yy, zz, xy) or six (xx, yy, zz, xy, xz, yz). Components of a gradient are listed row by row.
    pub columns: Vec<(Quantity, Vec<String>)>,
    /// Length of a time step, for formats that store the step number. `None` to read frames with a step but without a time.
    pub time_step: Option<f64>,
    /// Frames to be read.
    pub frames: FrameRange,
    /// Group of an HDF5 file, or name of an array of particles; `None` for the usual group of a code, and the array with the most particles.
    pub group: Option<String>,
    /// Limits of the sizes of files and frames.
    pub limits: Limits,
}

impl Reading {
    /// Adds the columns of a list such as `x=xu,yu F=c_F time=t`, separated by blanks or semicolons, or by commas before `NAME=`.
    ///
    /// # Errors
    /// [`FrameError::Request`] for an unknown quantity or an empty name.
    pub fn with_columns(mut self, list: &str) -> Result<Self, FrameError> {
        let words = list.split([',', ';', ' ']).map(str::trim);
        for word in words.filter(|word| !word.is_empty()) {
            let (quantity, name) = match word.split_once('=') {
                Some((quantity, name)) => (Some(quantity.parse::<Quantity>()?), name),
                None => (None, word),
            };
            if let Some(quantity) = quantity {
                if self.columns.iter().any(|(own, _)| *own == quantity) {
                    return Err(FrameError::Request {
                        what: format!("the columns of {quantity} are named twice"),
                        hint: "list the names of a quantity after one `=`".to_owned(),
                    });
                }
                self.columns.push((quantity, Vec::new()));
            }
            match self.columns.last_mut() {
                Some((_, names)) if !name.is_empty() => names.push(name.to_owned()),
                _ => {
                    return Err(FrameError::Request {
                        what: "a column without a quantity or a name".to_owned(),
                        hint: format!("write QUANTITY=NAME,...; quantities: {}", Quantity::words()),
                    });
                }
            }
        }
        Ok(self)
    }
}

/// Quantity that a column contains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Position of a particle at the time of the frame.
    Position,
    /// Position in the reference configuration.
    Reference,
    /// Current minus reference position.
    Displacement,
    /// Velocity of a particle.
    Velocity,
    /// Deformation gradient of a particle or cell.
    Gradient,
    /// Cauchy stress of a particle or cell.
    Stress,
    /// Density at the time of the frame.
    Density,
    /// Number of a particle, identical in all frames.
    Identity,
    /// Type or material of a particle.
    Kind,
    /// Particles with prescribed motion (nonzero).
    Held,
    /// Time of a frame.
    Time,
    /// Volume of a particle.
    Volume,
    /// Mass of a particle.
    Mass,
}

impl Quantity {
    /// All quantities, in the order in which columns are guessed.
    pub const ALL: [Self; 13] = [
        Self::Position,
        Self::Reference,
        Self::Displacement,
        Self::Velocity,
        Self::Gradient,
        Self::Stress,
        Self::Density,
        Self::Identity,
        Self::Kind,
        Self::Held,
        Self::Time,
        Self::Volume,
        Self::Mass,
    ];

    /// Word in lists of columns.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Position => "x",
            Self::Reference => "X",
            Self::Displacement => "u",
            Self::Velocity => "v",
            Self::Gradient => "F",
            Self::Stress => "stress",
            Self::Density => "density",
            Self::Identity => "id",
            Self::Kind => "type",
            Self::Held => "held",
            Self::Time => "time",
            Self::Volume => "volume",
            Self::Mass => "mass",
        }
    }

    fn words() -> String {
        Self::ALL.map(Self::word).join(", ")
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.word())
    }
}

impl FromStr for Quantity {
    type Err = FrameError;

    fn from_str(word: &str) -> Result<Self, FrameError> {
        let long = match word {
            "position" => Some(Self::Position),
            "reference" => Some(Self::Reference),
            "displacement" => Some(Self::Displacement),
            "velocity" => Some(Self::Velocity),
            "gradient" => Some(Self::Gradient),
            "kind" => Some(Self::Kind),
            _ => Self::ALL.into_iter().find(|own| own.word() == word),
        };
        long.ok_or_else(|| FrameError::Request {
            what: format!("unknown quantity `{}`", crate::error::brief(word)),
            hint: format!("quantities: {}", Self::words()),
        })
    }
}

/// Range of frames, like a slice in Python: from `first` up to but not including `end`, in steps of `every`; negative numbers count from the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    /// Number of the first frame to be read; `None` for the first frame of the run.
    pub first: Option<i64>,
    /// Number of the first frame after the range; `None` to read to the end of the run.
    pub end: Option<i64>,
    /// Step, at least 1.
    pub every: usize,
}

impl Default for FrameRange {
    fn default() -> Self {
        Self {
            first: None,
            end: None,
            every: 1,
        }
    }
}

impl FrameRange {
    /// Numbers of the frames out of `count`.
    pub fn of(self, count: usize) -> impl Iterator<Item = usize> {
        let place = |bound: Option<i64>, default: usize| match bound {
            None => default,
            Some(bound) if bound < 0 => {
                count.saturating_sub(usize::try_from(bound.unsigned_abs()).unwrap_or(usize::MAX))
            }
            Some(bound) => usize::try_from(bound).unwrap_or(usize::MAX).min(count),
        };
        (place(self.first, 0)..place(self.end, count)).step_by(self.every.max(1))
    }
}

impl FromStr for FrameRange {
    type Err = FrameError;

    fn from_str(text: &str) -> Result<Self, FrameError> {
        let wrong = || {
            FrameError::Request {
            what: format!("`{}` is not a range of frames", crate::error::brief(text)),
            hint: "write FIRST:END, FIRST:END:EVERY, or :END; END is not included, and negative numbers count from the end".to_owned(),
        }
        };
        let mut parts = text.split(':');
        let mut bound = || match parts.next().map(str::trim) {
            None | Some("") => Ok(None),
            Some(word) => word.parse::<i64>().map(Some).map_err(|_| wrong()),
        };
        let (first, end, every) = (bound()?, bound()?, bound()?);
        let every = usize::try_from(every.unwrap_or(1)).map_err(|_| wrong())?;
        if parts.next().is_some() || every == 0 || !text.contains(':') {
            return Err(wrong());
        }
        Ok(Self { first, end, every })
    }
}

/// Limits of sizes, as a protection against damaged and malicious files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Maximum number of particles in a frame.
    pub particles: usize,
    /// Maximum size of a file that is read as a whole, in bytes.
    pub bytes: u64,
    /// Maximum size of a decompressed text, in bytes.
    pub text: u64,
    /// Maximum number of files and of frames.
    pub frames: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            particles: 20_000_000,
            bytes: 4 << 30,
            text: 256 << 30,
            frames: 1_000_000,
        }
    }
}
