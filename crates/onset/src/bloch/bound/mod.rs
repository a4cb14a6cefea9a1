//! Lower bounds over the whole zone: branch and bound on boxes of wave vectors.
//!
//! A search finds a small value; a bound says that there is none smaller. Where the Hermitian part of `D(k) - mu c^2 |k|_h^2 M` is positive definite
//! for all wave vectors, no scaled measure is below `mu`; of Hermitian equations the converse holds too. On a box this matrix is a polynomial of
//! third order and a rest that derivatives of the fourth order and the range of the forces bound. Soft vectors turn with the stiff ones to which they are
//! coupled; coefficients in Bernstein's basis, or a sum of squares, tell whether the polynomial is positive definite. Boxes of which this is not seen are
//! halved, until the bound is within a gap of the smallest value. Of boxes that symmetries of the lattice map to each other one is looked at.

mod cell;
mod cover;
mod images;
mod jet;
mod local;
mod pencil;
mod phase;
mod polynomial;
mod sum;

pub(super) use cover::{Covered, Question};
pub(super) use pencil::Measure;

use super::{DynamicalMatrix, WaveSystem};
use crate::algebra::settled;
use crate::lattice::BravaisLattice;
use nalgebra::SVector;
use pencil::Pencil;

/// What is not told from the minimum of a measure, over the scale of the measure.
pub(super) const GAP: f64 = 4e-7;
/// A bound that is farther from the minimum is none.
pub(super) const WIDEST: f64 = 0.1;
/// Work for a bound of the scaled measure, at most, in units of its cost: two seconds of one core.
pub(super) const BUDGET: usize = 25_000_000;

/// The same where only the Hermitian part is bounded, which may be far below: a share of the work, and no more digits than one wants.
const PART_SHARE: usize = 4;
const PART_GAP: f64 = 1e-4;
/// First steps downhill, over the reciprocal vectors.
const STEP: f64 = 0.02;

/// Covers the zone of a system; `None` where its equations allow no bound.
pub(super) fn cover_system<const D: usize>(
    system: &WaveSystem<D>,
    measure: Measure,
    lattice: &BravaisLattice<D>,
    question: &Question<'_, D>,
) -> Option<Covered<D>> {
    let pencil = Pencil::of_system(system, measure, lattice)?;
    cover(&pencil, system.is_hermitian(), question)
}

/// Covers the zone of a dynamical matrix; `None` where it allows no bound.
pub(super) fn cover_matrix<const D: usize>(
    matrix: &DynamicalMatrix<D>,
    measure: Measure,
    lattice: &BravaisLattice<D>,
    question: &Question<'_, D>,
) -> Option<Covered<D>> {
    let pencil = Pencil::of_matrix(matrix, measure, lattice)?;
    cover(&pencil, matrix.is_hermitian(), question)
}

fn cover<const D: usize>(
    pencil: &Pencil<D>,
    is_hermitian: bool,
    question: &Question<'_, D>,
) -> Option<Covered<D>> {
    match is_hermitian {
        true => cover::cover(pencil, question),
        false => by_hermitian_part(pencil, question),
    }
}

/// No real part is below the smallest eigenvalue of the Hermitian part (Bendixson), which is bounded in its place. That is no value of the
/// measure: none is found.
fn by_hermitian_part<const D: usize>(
    pencil: &Pencil<D>,
    question: &Question<'_, D>,
) -> Option<Covered<D>> {
    let value = |k: &SVector<f64, D>| pencil.at(k);
    let scale = question.known.abs().max(1.0);
    let steps = pencil.reciprocal() * STEP;
    let part = cover::cover(
        pencil,
        &Question {
            known: question.known,
            gap: PART_GAP * scale + question.gap,
            widest: WIDEST * scale,
            budget: question.budget / PART_SHARE,
            value: &value,
            descended: &|start| settled(&value, start, &steps),
            is_ended: question.is_ended,
        },
    )?;
    Some(Covered {
        lowest: question.known,
        wave_vector: None,
        is_long_wave: false,
        bound: part.bound.min(question.known),
    })
}
