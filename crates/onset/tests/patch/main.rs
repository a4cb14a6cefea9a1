//! The dynamical matrix, compared with brute force: the nonlinear internal forces of a periodic patch of particles, differentiated numerically. The
//! forces are independent of the crate's assembly: lattice, weights, shape functions and stresses are implemented a second time in a different way.

mod brute;
mod eulerian;
mod lagrangian;
mod law;
mod linearizations;
