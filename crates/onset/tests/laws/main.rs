//! Tests of every law, and of the numbers, states and directions used with laws.

mod directions;
mod ellipticity;
mod energy;
mod equations_of_state;
mod extremes;
mod intervals;
mod lanes;
mod library;
mod mullins;
mod numbers;
mod plane_stress;
#[path = "../shared/random.rs"]
mod random;
mod rates;
mod relaxation;
mod stretches;
mod table;
