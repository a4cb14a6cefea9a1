//! Acceptance tests for particle codes: a predicted wave, run in a code that somebody else wrote, and measured.
//!
//! A [`Case`] is one wave of one homogeneous state: a deck for the code, which seeds the wave as velocities, and what the linearized equations
//! of the same study say of it. Deck and prediction come from the same [`Problem`](crate::answers::Problem). A [`Code`] is what is known of
//! one particle code: its *dialect* (the choices that it makes, with its deviations from the papers), how it takes a time step, how a deck of it
//! is written and its output read. What is read is projected on the wave; the rates of the record are fitted, with their uncertainty, and held
//! against those predicted in discrete time.

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
