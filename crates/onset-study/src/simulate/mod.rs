//! Simulations: a periodic patch of particles, run step by step and compared with its linearized equations.
//!
//! A [`Question`] specifies the patch, the wave or noise, the time integration and the duration. [`simulate`] runs it with the nonlinear forces of
//! the method ([`onset::motion`]) and keeps histories, fields and checkpoints in a folder. It measures the rate of a wave and compares it with the
//! predicted rate in discrete time, with the fit and the outcomes of [`verify`](crate::verify). A [`BodyQuestion`] describes a body with free
//! surfaces and grips; its rates are not predicted. [`run_body`] runs it with the same kinds of output.

mod answer;
mod body;
mod checkpoint;
mod error;
mod figure;
mod page;
mod patch;
mod picture;
mod plan;
mod run;
mod states;

pub use answer::{Measured, Outcome, SimulateAnswer};
pub use body::{BodyAnswer, BodyQuestion, run_body};
pub use checkpoint::CHECKPOINT;
pub use error::SimulateError;
pub use patch::simulate;
pub use plan::{Duration, Pace, Question, Seeded};
pub use run::{Place, Watch};

pub use onset::motion::Stepper;
