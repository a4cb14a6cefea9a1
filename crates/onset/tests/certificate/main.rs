//! Certificates: what is proved is true, and what is true is nearly always proved.

#[allow(dead_code, reason = "shared with the tests of the discretization")]
#[path = "../discretization/choices.rs"]
mod choices;
mod covers;
mod known;
mod random;
