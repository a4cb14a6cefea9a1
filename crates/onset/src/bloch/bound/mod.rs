//! Lower bounds of a measure over the whole zone, by branch and bound on boxes of wave vectors.
//!
//! A search finds a small value; a bound proves that no smaller value exists. If the Hermitian part of `D(k) - mu c^2 |k|_h^2 M` is positive definite
//! for all wave vectors, no scaled measure is below `mu`. For Hermitian equations the converse holds too. The proof on one box has these steps:
//!
//! 1. The matrix is written as a Taylor polynomial of third order and a remainder, which the fourth derivatives and the range of the forces bound
//!    (`sum`, `phase`, `jet`).
//! 2. Soft eigenvectors are rotated with the stiff ones to which they are coupled, which leaves a polynomial of the soft vectors alone
//!    (`polynomial`).
//! 3. Its Bernstein coefficients, or a decomposition into a sum of squares, show that this polynomial is positive definite on the box.
//!
//! Boxes without this proof are halved until the bound is within a gap of the smallest known value (`cover`). Only one box of each class of symmetric
//! boxes is examined (`images`). The bound holds up to rounding errors, which the gap covers; there is no interval arithmetic.

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
use crate::bloch::settled;
use crate::lattice::BravaisLattice;
use nalgebra::SVector;
use pencil::Pencil;

/// Accepted difference between the bound and the minimum of a measure, relative to the scale of the measure. It is well above rounding.
pub(super) const GAP: f64 = 4e-7;
/// Largest useful difference between the bound and the minimum, relative to the scale of the measure. Lower bounds are discarded.
pub(super) const WIDEST_GAP: f64 = 0.1;
/// Maximum work for the bound of the scaled measure, in units of [`Pencil::cost`]: about two seconds of one core.
pub(super) const BUDGET: usize = 25_000_000;

/// Divisor of the budget if only the Hermitian part is bounded, whose bound may be far below the measure.
const PART_BUDGET_DIVISOR: usize = 4;
/// Accepted relative difference if only the Hermitian part is bounded; more digits would be useless.
const PART_GAP: f64 = 1e-4;
/// First steps of descents, as a fraction of the reciprocal vectors.
const DESCENT_STEP: f64 = 0.02;

/// Covers the zone of a system; `None` if its equations allow no bound.
pub(super) fn cover_system<const D: usize>(
    system: &WaveSystem<D>,
    measure: Measure,
    lattice: &BravaisLattice<D>,
    question: &Question<'_, D>,
) -> Option<Covered<D>> {
    let pencil = Pencil::of_system(system, measure, lattice)?;
    cover(&pencil, system.is_hermitian(), question)
}

/// Covers the zone of a dynamical matrix; `None` if it allows no bound.
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

/// Bounds the measure by the smallest eigenvalue of the Hermitian part, which no real part of an eigenvalue is below (Bendixson). This eigenvalue is
/// not a value of the measure, so that no wave vector is returned.
fn by_hermitian_part<const D: usize>(
    pencil: &Pencil<D>,
    question: &Question<'_, D>,
) -> Option<Covered<D>> {
    let value = |k: &SVector<f64, D>| pencil.at(k);
    let values = |all: &[SVector<f64, D>]| all.iter().map(value).collect();
    let scale = question.known.abs().max(1.0);
    let steps = pencil.reciprocal() * DESCENT_STEP;
    let part = cover::cover(
        pencil,
        &Question {
            known: question.known,
            gap: PART_GAP * scale + question.gap,
            widest: WIDEST_GAP * scale,
            budget: question.budget / PART_BUDGET_DIVISOR,
            value: &value,
            descended: &|start| settled(&values, start, &steps),
        },
    )?;
    Some(Covered {
        lowest: question.known,
        wave_vector: None,
        is_long_wave: false,
        bound: part.bound.min(question.known),
    })
}
