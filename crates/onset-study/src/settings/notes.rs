//! Notes on accepted settings.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

static NOTES: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

/// Returns the notes on settings that were read since the last call, each once: renamed keys, and keys that the command does not use.
pub fn notes_on_settings() -> Vec<String> {
    let mut notes = NOTES.lock().unwrap_or_else(PoisonError::into_inner);
    std::mem::take(&mut *notes).into_iter().collect()
}

pub(super) fn note(note: String) {
    let mut notes = NOTES.lock().unwrap_or_else(PoisonError::into_inner);
    notes.insert(note);
}
