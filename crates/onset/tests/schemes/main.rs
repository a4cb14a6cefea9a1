//! Discretizations by their forces: one battery that each passes, and closed forms.

mod battery;
mod classical;
mod kernels;
mod sph;
mod springs;
mod stabilization;

#[path = "../shared/random.rs"]
mod random;
