//! The dynamical matrix against brute force: the nonlinear internal forces of a periodic patch of
//! particles, differentiated numerically. Nothing of the crate's assembly is used for the forces: lattice,
//! weights, shape functions and stresses are written again, another way.

mod brute;
mod eulerian;
mod lagrangian;
mod law;
mod linearizations;
