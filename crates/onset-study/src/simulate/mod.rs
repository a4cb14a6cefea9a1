//! Predictions seen in motion: a periodic patch of particles, run step by step, beside what its linearized equations say.
//!
//! A [`Question`] says which patch, which wave or noise, how steps are taken and for how long. [`simulate`] runs it with the nonlinear forces of
//! the method ([`onset::motion`]), keeps histories, fields and checkpoints in a folder, and measures the rate of a wave, which it holds against the
//! predicted one in discrete time with the fit and the words of [`verify`](crate::verify). A [`BodyQuestion`] is about a body with free surfaces and
//! grips, for which no rate is predicted: [`run_body`] runs it, and keeps it in the same way.

mod answer;
mod body;
mod checkpoint;
mod error;
mod fields;
mod page;
mod patch;
mod picture;
mod plan;
mod run;

pub use answer::{Measured, Outcome, SimulateAnswer};
pub use body::{BodyAnswer, BodyQuestion, run_body};
pub use checkpoint::CHECKPOINT;
pub use error::SimulateError;
pub use patch::simulate;
pub use plan::{Duration, Pace, Question, Seeded};
pub use run::{Place, Watch};

pub use onset::motion::Stepper;
