//! Branch and bound over the zone.

use super::cell::Cell;
use super::local::{Local, Sign};
use super::pencil::Pencil;
use crate::algebra::{Each, settled_along};
use crate::bloch::IsEnded;
use nalgebra::SVector;
use std::collections::VecDeque;

/// Half sides below which a box is not divided further.
const SMALLEST: f64 = 1e-9;
/// Boxes that must be affordable: with fewer nothing is bounded.
const FEWEST: usize = 64;
/// How often the gap is enlarged by [`WIDER`] for a box that is left, at most.
const WIDENINGS: usize = 40;
const WIDER: f64 = 4.0;

/// What a cover of the zone has found.
#[derive(Clone, Copy, Debug)]
pub(in crate::bloch) struct Covered<const D: usize> {
    /// The smallest value met, and its wave vector where it is below that given; of the limit of long waves a direction.
    pub(in crate::bloch) lowest: f64,
    pub(in crate::bloch) wave_vector: Option<SVector<f64, D>>,
    pub(in crate::bloch) is_long_wave: bool,
    /// No value is below it.
    pub(in crate::bloch) bound: f64,
}

/// A measure with its minima sought.
pub(in crate::bloch) struct Question<'a, const D: usize> {
    /// A value that is attained.
    pub(in crate::bloch) known: f64,
    /// What is not told from the minimum.
    pub(in crate::bloch) gap: f64,
    /// How much work is done, at most, in units of [`Pencil::cost`].
    pub(in crate::bloch) budget: usize,
    /// The value at a wave vector.
    pub(in crate::bloch) value: &'a dyn Fn(&SVector<f64, D>) -> f64,
    /// A bottom downhill from a wave vector with a value.
    #[allow(clippy::type_complexity)]
    pub(in crate::bloch) descended: &'a dyn Fn((f64, SVector<f64, D>)) -> (f64, SVector<f64, D>),
    /// Whether nobody waits for it any more.
    pub(in crate::bloch) is_ended: IsEnded<'a>,
}

/// Covers the zone with boxes in each of which no value is lower than the smallest met by more than a gap: those of which this is
/// not seen are divided. Where the middle of a box is lower, the bottom from there is the smallest value. `None` where the work that is
/// allowed is too little for any bound.
pub(super) fn cover<const D: usize>(
    pencil: &Pencil<D>,
    question: &Question<'_, D>,
) -> Option<Covered<D>> {
    let most = question.budget / pencil.cost();
    if most < FEWEST {
        return None;
    }
    let mut found = Covered {
        lowest: question.known,
        wave_vector: None,
        is_long_wave: false,
        bound: f64::NEG_INFINITY,
    };
    let mut open: VecDeque<Cell<D>> = pencil.boxes(most).into();
    let (mut left, mut looked) = (Vec::new(), 0);
    while let Some(cell) = open.pop_front() {
        if (question.is_ended)() {
            return Some(found);
        }
        let local = pencil.on(&cell);
        looked += 1;
        let mut sign = local.sign(found.lowest - question.gap);
        if sign == Sign::Lost {
            let k = cell.wave_vector(pencil.reciprocal());
            let value = (question.value)(&k);
            let limit = (value >= found.lowest && cell.has_limit()).then(|| long_wave(pencil, &k));
            let lower = match limit {
                Some(limit) => (limit, true),
                None => ((question.descended)((value, k)), false),
            };
            if lower.0.0 < found.lowest {
                (found.lowest, found.wave_vector) = (lower.0.0, Some(lower.0.1));
                found.is_long_wave = lower.1;
                sign = local.sign(found.lowest - question.gap);
            }
        }
        if sign == Sign::Positive {
            continue;
        }
        if looked >= most || cell.half.iter().all(|half| *half < SMALLEST) {
            left.push((cell, local));
            if looked >= most {
                left.extend(open.drain(..).map(|cell| (cell, pencil.on(&cell))));
            }
            continue;
        }
        open.extend(halves(&cell, &local));
    }
    found.bound = below(found.lowest, question.gap, &left);
    Some(found)
}

/// The softest limit of long waves downhill from a direction.
fn long_wave<const D: usize>(
    pencil: &Pencil<D>,
    direction: &SVector<f64, D>,
) -> (f64, SVector<f64, D>) {
    let limit = |k: &SVector<f64, D>| match pencil.limit_along(k) {
        value if value.is_finite() => value,
        _ => f64::INFINITY,
    };
    let start = (limit(direction), *direction);
    // A step along the direction itself changes nothing.
    let scale = direction.norm() / pencil.reciprocal().norm();
    let steps: Vec<SVector<f64, D>> = pencil
        .reciprocal()
        .column_iter()
        .map(|b| b - direction * (direction.dot(&b) / direction.norm_squared()))
        .map(|across| across * (0.1 * scale))
        .collect();
    let (value, direction) = settled_along(&limit, start, &steps);
    (value, direction.normalize())
}

/// The two halves of a box, divided where the second derivatives do most.
fn halves<const D: usize>(cell: &Cell<D>, local: &Local<D>) -> [Cell<D>; 2] {
    let mut widest = 0;
    for a in 1..D {
        if local.bends[a] > local.bends[widest] {
            widest = a;
        }
    }
    [-0.5, 0.5].each(|side| {
        let mut part = *cell;
        part.half[widest] *= 0.5;
        part.middle[widest] += side * cell.half[widest];
        part
    })
}

/// What no value is below, in boxes that are left too.
fn below<const D: usize>(lowest: f64, gap: f64, left: &[(Cell<D>, Local<D>)]) -> f64 {
    let (mut gap, mut widened) = (gap, 0);
    for (_, local) in left {
        while local.sign(lowest - gap) != Sign::Positive {
            gap *= WIDER;
            widened += 1;
            if widened > WIDENINGS {
                return f64::NEG_INFINITY;
            }
        }
    }
    lowest - gap
}
