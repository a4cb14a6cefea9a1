//! Standing checks on random methods and states.

mod dense;
mod descriptions;
mod methods;
mod named;
mod spectra;
mod transfers;
mod weakest;

#[path = "../shared/hunt.rs"]
mod hunt;
#[path = "../shared/random.rs"]
mod random;
