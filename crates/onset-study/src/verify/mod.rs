//! Acceptance tests for particle codes: a predicted plane wave is run in an external code and measured.
//!
//! A [`Case`] is one wave of one homogeneous state: a deck for the code, which seeds the wave as velocities, and the prediction of the linearized
//! equations for the same study. Deck and prediction follow from the same [`Problem`](crate::answers::Problem). A [`Code`] describes one particle
//! code: its *dialect* (the choices that it fixes, with its deviations from the papers), its time integration, how its decks are written and how its
//! output is read. The output is projected on the wave; the rates of the record are fitted, with their uncertainty, and compared with the rates
//! predicted in discrete time.

mod block;
mod case;
mod code;
mod codes;
mod error;
mod fit;
mod judgment;
mod law;
mod prediction;
mod record;
mod run;

pub use block::Block;
pub use case::{CASE_FILE, Case, Question};
pub use code::{Code, Deck, Program, Settled};
pub use codes::{CODES, Codes, named};
pub use error::VerifyError;
pub use fit::{Fit, FitError, fitted, fitted_alone};
pub(crate) use judgment::compared;
pub use judgment::{Judgment, Outcome, judge, read};
pub use prediction::{Prediction, Rate};
pub use record::{Projector, Record};
pub use run::run;

pub use onset::time_step::Stepping;
