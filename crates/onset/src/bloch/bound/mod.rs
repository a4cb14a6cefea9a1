//! Lower bounds over the whole zone: branch and bound on boxes of wave vectors.
//!
//! A search finds a small value; a bound says that there is none smaller. `D(k) - mu c^2 |k|_h^2 M` is positive definite for all
//! wave vectors if and only if no scaled measure is below `mu`. On a box this matrix is a polynomial of second order and a rest
//! that the range of the forces bounds, and a sum of squares tells whether the polynomial is positive definite. Boxes of which this
//! is not seen are halved, until the bound is within a gap of the smallest value.

mod cell;
mod cover;
mod jet;
mod local;
mod pencil;
mod phase;
mod squares;
mod sum;

pub(super) use cover::{Covered, Question};
pub(super) use pencil::Measure;

use super::{DynamicalMatrix, WaveSystem};
use crate::lattice::BravaisLattice;
use pencil::Pencil;

/// What is not told from the minimum of a measure, over the scale of the measure.
pub(super) const GAP: f64 = 4e-7;
/// Work for a bound of the scaled measure, at most: some tenths of a second.
pub(super) const BUDGET: usize = 4_000_000;

/// Covers the zone of a system; `None` where its equations allow no bound.
pub(super) fn cover_system<const D: usize>(
    system: &WaveSystem<D>,
    measure: Measure,
    lattice: &BravaisLattice<D>,
    question: &Question<'_, D>,
) -> Option<Covered<D>> {
    let pencil = Pencil::of_system(system, measure, lattice)?;
    cover::cover(&pencil, question)
}

/// Covers the zone of a dynamical matrix; `None` where it allows no bound.
pub(super) fn cover_matrix<const D: usize>(
    matrix: &DynamicalMatrix<D>,
    measure: Measure,
    lattice: &BravaisLattice<D>,
    question: &Question<'_, D>,
) -> Option<Covered<D>> {
    let pencil = Pencil::of_matrix(matrix, measure, lattice)?;
    cover::cover(&pencil, question)
}
