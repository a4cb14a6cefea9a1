//! Answers to single questions: a state, a dispersion relation, a path. Serializable, and readable.

mod certificate;
mod diagram;
mod dispersion;
mod mode;
mod next;
mod notes;
mod path;
mod problem;
mod sentence;
mod state;
mod summary;
mod zone_path;

pub use certificate::{CertificateAnswer, ProofAnswer, WitnessAnswer};
pub use diagram::{Corner, CriticalWave, DensityOfStates, Diagram};
pub use dispersion::{DispersionAnswer, Waves};
pub use notes::{notes, notes_on_law, notes_on_method};
pub use path::{CrossingAnswer, DiscretizationOnset, MaterialOnset, PathAnswer};
pub use problem::{Problem, ProblemError, Strain};
pub use state::{ComplexNumber, DiscretizationAnswer, MaterialAnswer, StateAnswer};
pub use summary::{AxisSummary, StudySummary};

/// Calls a function that is generic in the dimension with the dimension of an arrangement.
macro_rules! in_dimension_of {
    ($problem:expr, $function:ident($($argument:expr),*)) => {
        match $problem.settings.dimension() {
            1 => $function::<1>($($argument),*),
            2 => $function::<2>($($argument),*),
            _ => $function::<3>($($argument),*),
        }
    };
}
pub(crate) use in_dimension_of;
