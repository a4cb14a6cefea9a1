//! Discretizations by their forces: general checks for every scheme, and closed forms.

mod amplification;
mod battery;
mod bonds;
mod chains;
mod classical;
mod conforming;
mod dialects;
mod elements;
mod kernels;
mod material_point;
mod non_hourglass;
mod peridynamics;
mod spacing;
mod sph;
mod springs;
mod stabilization;
mod states;
mod transfer;
mod transferred;
mod upwinding;

#[path = "../shared/random.rs"]
mod random;
