//! Properties of lattices, shape functions and dynamical matrices for any admissible input.

mod bases;
mod cells;
mod choices;
mod errors;
mod lattices;
mod mirror;
mod quadratures;
mod search;
mod shape_functions;
mod survey;
mod theorem;
mod waves;

#[path = "../shared/hunt.rs"]
mod hunt;
#[path = "../shared/random.rs"]
#[allow(dead_code, reason = "rotations are for others")]
mod random;
