//! One battery for every law, and for the numbers, states and directions that laws are made of and seen in.

mod directions;
mod ellipticity;
mod energy;
mod equations_of_state;
mod extremes;
mod intervals;
mod lanes;
mod library;
mod numbers;
mod plane_stress;
#[path = "../shared/random.rs"]
mod random;
mod rates;
mod stretches;
mod table;
