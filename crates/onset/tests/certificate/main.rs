//! Certificates: every proof is correct, and nearly every state is proved.

#[allow(dead_code, reason = "shared with the tests of the discretization")]
#[path = "../discretization/choices.rs"]
mod choices;
mod covers;
mod known;
mod random;
