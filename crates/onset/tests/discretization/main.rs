//! Lattices, shape functions and dynamical matrices by their properties, on any admissible input.

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
