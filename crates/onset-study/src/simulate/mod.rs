//! Predictions seen in motion: a periodic patch of particles, run step by step, beside what its linearized equations say.
//!
//! A [`Question`] says which patch, which wave or noise, how steps are taken and for how long. [`simulate`] runs it with the nonlinear forces of
//! the method ([`onset::motion`]), keeps histories, fields and checkpoints in a folder, and measures the rate of a wave, which it holds against the
//! predicted one in discrete time with the fit and the words of [`verify`](crate::verify).

mod answer;
mod checkpoint;
mod error;
mod fields;
mod page;
mod plan;
mod run;

pub use answer::{Measured, Outcome, SimulateAnswer};
pub use checkpoint::CHECKPOINT;
pub use error::SimulateError;
pub use plan::{Duration, Question, Seeded};
pub use run::{Place, Watch, simulate};

pub use onset::motion::Stepper;
