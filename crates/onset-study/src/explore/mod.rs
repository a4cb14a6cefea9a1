//! Questions of a page and their answers: the documents of the command, computed while the user moves a slider.
//!
//! A [`Question`] contains the arguments of a command (`--set`, `--stretch`) and a window of states. An [`Explorer`] returns the documents of `onset
//! ... --json`, built by the same functions. Questions are not trusted, since a link may come from anyone: they read no files, and load a library
//! only if the user allows it.
//!
//! ```
//! use onset_study::explore::{Explorer, Question};
//! use onset_study::settings::Trust;
//!
//! let explorer = Explorer::new(Trust::default(), None);
//! let question = Question::parse(r#"{"set": ["discretization.method=updated-sph"], "stretch": "1.15,1"}"#)?;
//! let document = explorer.answer("state", &question)?;
//! assert!(document.contains("\"verdict\": \"numerical\""));
//! # Ok::<(), onset_study::explore::Refusal>(())
//! ```

mod catalog;
mod export;
mod form;
mod known;
mod map;
mod question;
mod stored;
mod zoo;

pub use question::{Question, Window};
pub use stored::Stored;
pub use zoo::{Entry, entries};

use crate::answers::{Diagram, Directions, MovingMode, ProblemError, StateAnswer};
use crate::boundary::{self, Boundaries, BoundaryError, Tracing};
use crate::json;
use crate::map::MapError;
use crate::settings::{SettingError, Trust};
use known::{Known, States};
use map::Maps;
use onset::cancel::{Scope, checkpoint, unless};
use serde::Serialize;
use std::fmt::Display;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Time limit for the boundaries of a window.
const PATIENCE: Duration = Duration::from_secs(20);
/// Interval between checks of the time and of the connection.
const CHECK_INTERVAL: Duration = Duration::from_millis(50);
/// Longest piece of work between two checkpoints: eigenvectors of a cell of about a hundred particles.
const LAST_PIECE: Duration = Duration::from_secs(2);

/// Reason why a request has no answer.
#[derive(Debug, thiserror::Error)]
pub enum Refusal {
    /// Unknown name of a request.
    #[error("there is no request `{0}`")]
    Unknown(String),
    /// Invalid input, with the message and the hint of the command.
    #[error("{0}")]
    Input(String),
    /// Request that exceeded the time limit.
    #[error("cancelled: the computation took longer than {} s", PATIENCE.as_secs())]
    GivenUp,
}

impl Refusal {
    fn input(error: impl Display) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<SettingError> for Refusal {
    fn from(error: SettingError) -> Self {
        Self::input(error)
    }
}

impl From<ProblemError> for Refusal {
    fn from(error: ProblemError) -> Self {
        Self::input(error)
    }
}

impl From<BoundaryError> for Refusal {
    fn from(error: BoundaryError) -> Self {
        match error {
            BoundaryError::Problem(error) => error.into(),
            other => Self::input(other),
        }
    }
}

impl From<MapError> for Refusal {
    fn from(error: MapError) -> Self {
        Self::input(error)
    }
}

/// Runs a computation in a separate thread with the time limit [`PATIENCE`]; returns `None` after it. A computation that is late ends at its next
/// checkpoint.
fn in_time<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Option<T> {
    let start = Instant::now();
    let is_over = move || start.elapsed() >= PATIENCE - LAST_PIECE;
    let scope = Scope::current();
    let (done, answer) = channel();
    let computing = move || {
        // The receiver of a late answer is gone.
        let _ = done.send(scope.run(|| unless(is_over, work)));
    };
    thread::Builder::new().spawn(computing).ok()?;
    loop {
        let outcome = answer.recv_timeout(CHECK_INTERVAL);
        checkpoint();
        match outcome {
            Ok(answer) => return answer,
            Err(RecvTimeoutError::Timeout) if start.elapsed() < PATIENCE => {}
            Err(_) => return None,
        }
    }
}

/// Server of the interactive page: answers questions, and keeps recent states and maps.
pub struct Explorer {
    /// Libraries that the user allows.
    trust: Trust,
    /// Map opened by the user.
    stored: Option<Stored>,
    /// Caches of recent states and maps.
    states: States,
    maps: Maps,
}

impl Explorer {
    /// Creates an explorer with the libraries that the user allows, and a map opened by the user.
    pub fn new(trust: Trust, stored: Option<Stored>) -> Self {
        Self {
            trust,
            stored,
            states: States::default(),
            maps: Maps::default(),
        }
    }

    /// Document that answers a question.
    ///
    /// `state` and `dispersion` return the documents of `onset NAME --json`, and `boundary` returns curves as in the files of `onset boundary --out`.
    /// Other names return further data for the page.
    ///
    /// # Errors
    /// [`Refusal`] with the message of the command.
    pub fn answer(&self, name: &str, question: &Question) -> Result<String, Refusal> {
        match name {
            "catalog" => document(&catalog::catalog()),
            "form" => document(&form::form(question, &self.trust)?),
            "open" => document(&question::opened(&question.text)?),
            "stored" => match &self.stored {
                Some(stored) => document(&stored.shown()?),
                None => Err(Refusal::Input("no stored map was opened".to_owned())),
            },
            "state" => {
                let known = self.states.of(question, &self.trust)?;
                let Known {
                    problem,
                    strain,
                    assessment,
                } = &*known;
                document(&StateAnswer::of(problem, strain, assessment)?)
            }
            "dispersion" => {
                let known = self.states.of(question, &self.trust)?;
                let Known {
                    problem,
                    strain,
                    assessment,
                } = &*known;
                let path = Some(question.path.as_str()).filter(|path| !path.is_empty());
                let diagram = Diagram::of(problem, strain, assessment, path)?;
                document(&diagram)
            }
            "directions" => {
                let problem = question.problem(&self.trust)?;
                document(&Directions::new(&problem, &question.strain(&problem)?)?)
            }
            "mode" => {
                let known = self.states.of(question, &self.trust)?;
                document(&MovingMode::of(
                    &known.problem,
                    &known.strain,
                    &known.assessment,
                )?)
            }
            "map" => document(&self.maps.shown(question, &self.trust)?),
            "boundary" => {
                let study = question.study(&self.trust, map::CURVE_STATES)?;
                let traced = in_time(move || Boundaries::of(&study, Tracing::default(), &()));
                let boundaries = traced.ok_or(Refusal::GivenUp)??;
                document(&boundary::geojson(&boundaries))
            }
            "export" => {
                let text = export::export(question, &self.trust, &self.maps)?;
                document(&serde_json::json!({ "text": text }))
            }
            other => Err(Refusal::Unknown(other.to_owned())),
        }
    }
}

fn document(answer: &impl Serialize) -> Result<String, Refusal> {
    json::document(answer).map_err(Refusal::input)
}

#[cfg(test)]
mod tests;
