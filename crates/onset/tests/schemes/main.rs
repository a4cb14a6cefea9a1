//! Discretizations by their forces: one battery that each passes, and closed forms.

mod battery;
mod material_point;
mod peridynamics;
mod springs;

#[path = "../shared/random.rs"]
mod random;
