//! Laws given as formulas agree with the laws that they represent, and invalid input is rejected with its position.

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
