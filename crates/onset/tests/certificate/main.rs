//! Certificates: what is proved is true, and what is true is nearly always proved.

#[path = "../discretization/choices.rs"]
mod choices;
mod covers;
mod known;
mod random;
