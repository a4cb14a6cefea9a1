//! Cache of recent states.
//!
//! A page requests the sentence, the mode and the dispersion of a state simultaneously; they share one assessment. States with the same material and
//! method share the problem.

use super::{Question, Refusal};
use crate::answers::{Problem, ProblemError, Strain};
use crate::settings::Trust;
use onset::cancel::checkpoint;
use onset::verdict::Assessment;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Number of cached states.
const CACHED_STATES: usize = 8;

/// Assessment of a state, with its problem.
pub(super) struct Known {
    pub(super) problem: Arc<Problem>,
    pub(super) strain: Strain,
    pub(super) assessment: Assessment<3>,
}

/// Cache entry of a state. The first request fills it while other requests wait.
struct Place {
    set: Vec<String>,
    stretch: String,
    known: Mutex<Option<Arc<Known>>>,
}

/// Cache of recent states.
#[derive(Default)]
pub(super) struct States(Mutex<Vec<Arc<Place>>>);

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl States {
    /// Assessed state of a question.
    pub(super) fn of(&self, question: &Question, trust: &Trust) -> Result<Arc<Known>, Refusal> {
        let place = self.place(question);
        let mut known = locked(&place.known);
        if let Some(known) = &*known {
            return Ok(Arc::clone(known));
        }
        checkpoint();
        let problem = match self.problem(question) {
            Some(problem) => problem,
            None => Arc::new(question.problem(trust)?),
        };
        let strain = question.strain(&problem)?;
        let assessment = problem.analysis.assess(&strain.0);
        let found = Arc::new(Known {
            assessment: assessment.map_err(ProblemError::from)?,
            problem,
            strain,
        });
        // A library may have changed by the next request.
        if !found.problem.settings.material.is_library() {
            *known = Some(Arc::clone(&found));
        }
        Ok(found)
    }

    fn place(&self, question: &Question) -> Arc<Place> {
        let mut places = locked(&self.0);
        let is_same =
            |own: &&Arc<Place>| own.set == question.set && own.stretch == question.stretch;
        if let Some(place) = places.iter().find(is_same) {
            return Arc::clone(place);
        }
        let place = Arc::new(Place {
            set: question.set.clone(),
            stretch: question.stretch.clone(),
            known: Mutex::default(),
        });
        places.push(Arc::clone(&place));
        let extra = places.len().saturating_sub(CACHED_STATES);
        places.drain(..extra);
        place
    }

    /// Problem of another cached state with the same material and method.
    fn problem(&self, question: &Question) -> Option<Arc<Problem>> {
        let places = locked(&self.0);
        let alike = places.iter().filter(|own| own.set == question.set);
        alike
            .filter_map(|own| {
                // Entries that are still being filled are skipped.
                let known = own.known.try_lock().ok()?;
                Some(Arc::clone(&known.as_ref()?.problem))
            })
            .next()
    }
}
