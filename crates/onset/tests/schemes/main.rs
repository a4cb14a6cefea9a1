//! Discretizations by their forces: one battery that each passes, and closed forms.

mod battery;
mod kernels;
mod springs;

#[path = "../shared/random.rs"]
mod random;
