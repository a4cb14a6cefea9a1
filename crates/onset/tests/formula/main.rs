//! Laws that are typed as a formula: that they are the laws they say, and that everything else is refused with its place.

mod agreement;
mod conditions;
mod domain;
mod fuzzed;
mod hostile;
#[path = "../shared/hunt.rs"]
mod hunt;
mod language;
mod library;
#[path = "../shared/random.rs"]
mod random;
mod refusals;
mod standing;
mod states;
mod trees;
