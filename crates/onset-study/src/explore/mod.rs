//! Questions of a page and their answers: the documents of the command, asked one at a time while somebody turns a slider.
//!
//! A [`Question`] is what is written after the command (`--set`, `--stretch`) and a window of states. An [`Explorer`] answers with the
//! documents of `onset ... --json`, made by the same functions. A question can come from anywhere, also from a link that a stranger made: it
//! reads no file, and starts a library only if the user allows it.
//!
//! ```
//! use onset_study::explore::{Explorer, Question};
//! use onset_study::settings::Trust;
//!
//! let explorer = Explorer::new(Trust::default(), None);
//! let question = Question::parse(r#"{"set": ["discretization.method=updated-sph"], "stretch": "1.15,1"}"#)?;
//! let document = explorer.answer("state", &question, &|| false)?;
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
use crate::boundary::{self, Boundaries, BoundaryError, Tracing, Watch};
use crate::json;
use crate::map::MapError;
use crate::settings::{SettingError, Trust};
use known::{Known, States};
use map::Maps;
use onset::bloch::IsEnded;
use serde::Serialize;
use std::fmt::Display;
use std::time::{Duration, Instant};

/// How long the boundaries of a window may take.
const PATIENCE: Duration = Duration::from_secs(20);

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum Refusal {
    /// There is no such question.
    #[error("there is no question `{0}`")]
    Unknown(String),
    /// What was asked is wrong; the text of the command, with its hint.
    #[error("{0}")]
    Input(String),
    /// Nobody waits for the answer any more, or it would take too long.
    #[error("given up: it took too long, or something else was asked")]
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
        match error {
            ProblemError::OutOfTime => Self::GivenUp,
            other => Self::input(other),
        }
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

/// Whether somebody waits for curves.
struct Waiting<'a>(IsEnded<'a>);

impl Watch for Waiting<'_> {
    fn asked(&self, _states: u64) {}

    fn is_ended(&self) -> bool {
        (self.0)()
    }
}

/// What answers the questions of a page.
pub struct Explorer {
    /// Libraries that the user allows.
    trust: Trust,
    /// The map that was opened.
    stored: Option<Stored>,
    /// The states and the maps that were asked for last.
    states: States,
    maps: Maps,
}

impl Explorer {
    /// Answers questions, with the libraries that the user allows, and a map that was opened.
    pub fn new(trust: Trust, stored: Option<Stored>) -> Self {
        Self {
            trust,
            stored,
            states: States::default(),
            maps: Maps::default(),
        }
    }

    /// The document of an answer: that of `onset NAME --json` for `state` and `dispersion`, curves as `onset boundary --out` writes them for
    /// `boundary`, and what a page needs beside them. `is_ended` tells that nobody waits for it any more.
    ///
    /// # Errors
    /// [`Refusal`] with the text of the command.
    pub fn answer(
        &self,
        name: &str,
        question: &Question,
        is_ended: IsEnded<'_>,
    ) -> Result<String, Refusal> {
        match name {
            "catalog" => document(&catalog::catalog()),
            "form" => document(&form::form(question, &self.trust)?),
            "open" => document(&question::opened(&question.text)?),
            "stored" => match &self.stored {
                Some(stored) => document(&stored.shown()?),
                None => Err(Refusal::Input("no stored map was opened".to_owned())),
            },
            "state" => {
                let known = self.states.of(question, &self.trust, is_ended)?;
                let Known {
                    problem,
                    strain,
                    assessment,
                } = &*known;
                document(&StateAnswer::of(problem, strain, assessment, is_ended)?)
            }
            "dispersion" => {
                let known = self.states.of(question, &self.trust, is_ended)?;
                let Known {
                    problem,
                    strain,
                    assessment,
                } = &*known;
                let path = Some(question.path.as_str()).filter(|path| !path.is_empty());
                let diagram = Diagram::of(problem, strain, assessment, path, is_ended)?;
                document(&diagram)
            }
            "directions" => {
                let problem = question.problem(&self.trust)?;
                document(&Directions::new(&problem, &question.strain(&problem)?)?)
            }
            "mode" => {
                let known = self.states.of(question, &self.trust, is_ended)?;
                document(&MovingMode::of(
                    &known.problem,
                    &known.strain,
                    &known.assessment,
                )?)
            }
            "map" => document(&self.maps.shown(question, &self.trust, is_ended)?),
            "boundary" => {
                let study = question.study(&self.trust, map::OF_CURVES)?;
                let tracing = Tracing {
                    until: Some(Instant::now() + PATIENCE),
                    ..Tracing::default()
                };
                let boundaries = Boundaries::of(&study, tracing, &Waiting(is_ended))?;
                document(&boundary::geojson(&boundaries))
            }
            "export" => {
                let text = export::export(question, &self.trust, &self.maps, is_ended)?;
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
