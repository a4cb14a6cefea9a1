//! The smallest acoustic eigenvalue over all directions in three dimensions: what is found, what bounds it, what is proved.

mod crystals;
mod forms;
mod laws;
mod proofs;
#[path = "../shared/random.rs"]
mod random;
mod scans;
