//! Answers to single questions: a state, a dispersion relation, a path. All can be serialized and printed.

mod certificate;
mod course;
mod diagram;
mod directions;
mod discrete_time;
mod dispersion;
mod evidence;
mod finite_body;
mod mode;
mod mode_name;
mod moving;
mod next;
mod notes;
mod path;
mod problem;
mod sentence;
mod state;
mod summary;
mod zone_path;

pub use certificate::{CertificateAnswer, ProofAnswer, WitnessAnswer};
pub use course::{Course, LoadingOfPath, PathSample, PathSamples};
pub use diagram::{Corner, CriticalWave, DensityOfStates, Diagram};
pub use directions::Directions;
pub use discrete_time::DiscreteTimeAnswer;
pub use dispersion::{DispersionAnswer, Waves};
pub use evidence::Evidence;
pub(crate) use finite_body::hint_on_body;
pub use finite_body::{BodyStepAnswer, FiniteBodyAnswer, OF_LATTICE};
pub use moving::{MovingMode, MovingParticle};
pub(crate) use next::assigned;
pub use notes::{moduli, notes, notes_on_law, notes_on_method};
pub(crate) use notes::{notes_on_patch, zero_energy};
pub use path::{CrossingAnswer, DiscretizationOnset, MaterialOnset, PathAnswer};
pub use problem::{Extent, Problem, ProblemError, Strain, numbers};
pub use state::{ComplexNumber, DiscretizationAnswer, MaterialAnswer, StateAnswer};
pub use summary::{AxisSummary, StudySummary};
