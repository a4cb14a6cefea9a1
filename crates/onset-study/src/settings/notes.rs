//! What is to be told about settings that are accepted.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

static NOTES: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

/// What is to be told of the settings that have been read since this was asked last, each once: earlier names, and what the question does not read.
pub fn notes_on_settings() -> Vec<String> {
    let mut notes = NOTES.lock().unwrap_or_else(PoisonError::into_inner);
    std::mem::take(&mut *notes).into_iter().collect()
}

pub(super) fn note(note: String) {
    let mut notes = NOTES.lock().unwrap_or_else(PoisonError::into_inner);
    notes.insert(note);
}
