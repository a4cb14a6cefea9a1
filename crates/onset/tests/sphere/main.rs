//! Smallest acoustic eigenvalue over all directions in three dimensions: search, bounds and proofs.

mod crystals;
mod forms;
mod laws;
mod proofs;
#[path = "../shared/random.rs"]
mod random;
mod scans;
