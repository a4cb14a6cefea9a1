//! What has been found of the states that were asked about last. The sentence, the mode and the dispersion of a state, which a page asks for at the
//! same time, stand on one assessment; and states of one material and method on what these are made of.

use super::{Question, Refusal};
use crate::answers::{Problem, ProblemError, Strain};
use crate::settings::Trust;
use onset::bloch::IsEnded;
use onset::verdict::Assessment;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// How many states are remembered.
const REMEMBERED: usize = 8;

/// A state, assessed.
pub(super) struct Known {
    pub(super) problem: Arc<Problem>,
    pub(super) strain: Strain,
    pub(super) assessment: Assessment<3>,
}

/// The place of a state, which the first who asks fills, while others wait for it.
struct Place {
    set: Vec<String>,
    stretch: String,
    known: Mutex<Option<Arc<Known>>>,
}

/// The states that were asked about last.
#[derive(Default)]
pub(super) struct States(Mutex<Vec<Arc<Place>>>);

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl States {
    /// The state of a question, assessed.
    pub(super) fn of(
        &self,
        question: &Question,
        trust: &Trust,
        is_ended: IsEnded<'_>,
    ) -> Result<Arc<Known>, Refusal> {
        let place = self.place(question);
        let mut known = locked(&place.known);
        if let Some(known) = &*known {
            return Ok(Arc::clone(known));
        }
        // Whoever has filled the place for nobody has left it empty.
        if is_ended() {
            return Err(Refusal::GivenUp);
        }
        let problem = match self.problem(question) {
            Some(problem) => problem,
            None => Arc::new(question.problem(trust)?),
        };
        let strain = question.strain(&problem)?;
        let assessment = problem.analysis.assess_unless(&strain.0, is_ended);
        let found = Arc::new(Known {
            assessment: assessment.map_err(ProblemError::from)?,
            problem,
            strain,
        });
        // A library can be another one the next time.
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
        let extra = places.len().saturating_sub(REMEMBERED);
        places.drain(..extra);
        place
    }

    /// Material and method of another state of which both are the same.
    fn problem(&self, question: &Question) -> Option<Arc<Problem>> {
        let places = locked(&self.0);
        let alike = places.iter().filter(|own| own.set == question.set);
        alike
            .filter_map(|own| {
                // One that is about to be filled is not waited for.
                let known = own.known.try_lock().ok()?;
                Some(Arc::clone(&known.as_ref()?.problem))
            })
            .next()
    }
}
