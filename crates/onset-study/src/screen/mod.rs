//! Screening of a run of another code: the particle that first became unstable, the time, and whether the material, the discretization or the time
//! step is the cause.
//!
//! A [`Run`] is read from output files, or given as arrays. For each particle and frame the deformation gradient follows from the positions. Its state
//! has a smallest acoustic eigenvalue and a fastest-growing wave. The integral of the growth rate over time, from the short waves at the start, gives
//! the amplitude that is expected. It is compared with the short waves in the positions. The largest stable step refers to the body and to the scheme
//! of the code.

mod actual;
mod agreement;
mod answer;
mod checks;
mod course;
mod files;
mod input;
mod neighborhoods;
mod records;
mod remedy;
mod rigid;
mod states;
mod study;

pub(crate) use agreement::cauchy_stress;
pub(crate) use course::neighborhood_radius;
pub(crate) use neighborhoods::Neighborhoods;
pub(crate) use states::{States, without_rotation};

pub use actual::{Actual, BodyModeAnswer, ModeKind};
pub use answer::{Cause, ScreenAnswer};
pub use checks::{Missing, ScreenChecks, missing};
pub use course::{Event, Moment, Snapshot, StepLimit};
pub use files::ScreenFiles;
pub use input::{Held, Recording, Reference, Region, Source};
pub use onset::time_step::Stepping;
pub use onset_frames::{FrameRange, told_repeats};
pub use remedy::Remedy;

use crate::answers::ProblemError;
use crate::number::counted;
use crate::output::OutputError;
use onset::verdict::WEAK_WAVE_RATIO;
use onset_frames::FrameError;
use thiserror::Error;

/// Default threshold for the amplitude of short waves; spacings.
pub const THRESHOLD: f64 = 0.05;
/// Recommended fraction of the largest stable step; it allows for the stiffening of a body by loads and disorder.
const SAFETY_FACTOR: f64 = 0.9;
/// Default width of the bins of stretch.
pub const BIN: f64 = 0.001;

/// Time stepping scheme of a code and alternative names for it, as `--stepping` reads them; `None` for other names.
pub fn stepping_named(name: &str) -> Option<Stepping> {
    let own = match name {
        "central-differences" | "leapfrog" | "symplectic-euler" | "kick-drift-kick" => {
            Stepping::VelocityVerlet.name()
        }
        other => other,
    };
    Stepping::ALL
        .into_iter()
        .find(|stepping| stepping.name() == own)
}

/// End of the error for a run with too few frames: the fault that ended the reading, and a hint.
fn too_few(why: Option<&str>) -> String {
    match why {
        Some(why) => {
            format!(". {why}\n  hint: correct the frame, or choose frames with --frames FIRST:END")
        }
        None => "\n  hint: give all output files of the run, or a wildcard".to_owned(),
    }
}

/// Time integration of the code, and thresholds.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// Time step of the code; `None` for runs whose step is not assessed.
    pub time_step: Option<f64>,
    /// Time integration of the code.
    pub stepping: Stepping,
    /// Smallest amplitude of observed short waves; spacings.
    pub threshold: f64,
    /// Amplitude of the waves when growth begins, in spacings; `None` for the short waves in the files.
    pub seed: Option<f64>,
    /// Width of the bins of stretch in which particles share a state. The expected time is also computed with twice this width.
    pub bin: f64,
    /// Time at whose nearest frame the lowest modes of the body are found; `None` for no modes.
    pub actual: Option<f64>,
    /// Largest frequency of a weakly controlled wave, relative to the slowest wave of the material.
    pub weak: f64,
}

impl Default for Question {
    fn default() -> Self {
        Self {
            time_step: None,
            stepping: Stepping::VelocityVerlet,
            threshold: THRESHOLD,
            seed: None,
            bin: BIN,
            actual: None,
            weak: WEAK_WAVE_RATIO,
        }
    }
}

impl ScreenError {
    /// Adds the fault that ended the frames of arrays.
    fn because(self, fault: Option<&str>) -> Self {
        match self {
            Self::TooFewFrames { count, why: None } => Self::TooFewFrames {
                count,
                why: fault.map(str::to_owned),
            },
            other => other,
        }
    }
}

impl Question {
    fn stepping(&self) -> Option<(Stepping, f64)> {
        self.time_step.map(|step| (self.stepping, step))
    }
}

/// Particles of a run in the reference configuration.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// Reference positions; length. Components beyond the dimensions are zero.
    pub reference: Vec<[f64; 3]>,
    /// Reference volumes, length^D; `None` for the square or cube of the spacing.
    pub volumes: Option<Vec<f64>>,
    /// Particles whose motion is prescribed.
    pub held: Vec<bool>,
    /// Nodes of each element; `None` if states are evaluated in the particles.
    pub cells: Option<Vec<Vec<usize>>>,
    /// Rounding of positions in the file; length.
    pub rounding: f64,
    /// Box that contains the particles to be assessed; `None` for all particles.
    pub region: Option<Region>,
}

impl Run {
    /// Median distance of nearest neighbors in the reference configuration; length.
    pub fn spacing(&self, dimension: usize) -> f64 {
        input::spacing(&self.reference, dimension)
    }
}

/// Positions of the particles at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Time of the frame.
    pub time: f64,
    /// Current positions, in the order of the reference positions; length.
    pub x: Vec<[f64; 3]>,
    /// Velocities of the particles; length/time. `None` if the code provides none.
    pub velocity: Option<Vec<[f64; 3]>>,
    /// Deformation gradients F_iJ of the particles or elements, row by row, as provided by the code; `None` if it provides none.
    pub gradient: Option<Vec<[f64; 9]>>,
    /// Cauchy stresses xx, yy, zz, xy, xz, yz of the particles or elements, as provided by the code; `None` if it provides none.
    pub stress: Option<Vec<[f64; 6]>>,
    /// Components of the stresses that the code provides.
    pub stress_given: [bool; 6],
}

/// Reasons why a run cannot be screened.
#[derive(Debug, Error)]
pub enum ScreenError {
    /// A file cannot be read.
    #[error(transparent)]
    Frames(#[from] FrameError),
    /// Law or method cannot be evaluated.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// The reference state cannot be evaluated.
    #[error(
        "the law or the method is not defined in the reference configuration\n  hint: try `onset state --stretch 1,1` with the same settings"
    )]
    Reference,
    /// The run and the settings are inconsistent, or a frame does not belong to the run.
    #[error("{what}\n  hint: {hint}")]
    Run {
        /// Description of the fault and its location.
        what: String,
        /// Remedy for the user.
        hint: String,
    },
    /// The run has fewer than two frames.
    #[error("the run has {}; growth needs at least two{}", counted(*count, "frame"), too_few(why.as_deref()))]
    TooFewFrames {
        /// Number of frames that were read.
        count: usize,
        /// Fault that ended the reading; `None` if all frames were read.
        why: Option<String>,
    },
    /// Results cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}
