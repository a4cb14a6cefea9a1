//! Branch and bound over the zone.

use super::cell::Cell;
use super::local::{Local, Sign};
use super::pencil::Pencil;
use crate::algebra::{Each, settled_along};
use crate::bloch::IsEnded;
use crate::cores::of_each_long;
use nalgebra::SVector;
use std::collections::VecDeque;
use std::iter;

/// Half sides below which a box is not divided further.
const SMALLEST: f64 = 1e-9;
/// Boxes that must be affordable, in one to three dimensions: with fewer nothing is bounded that one would want to know.
const FEWEST: [usize; 3] = [64, 256, 2048];
/// How much the gap is enlarged each time for a box that is left.
const WIDER: f64 = 4.0;
/// Work between two looks at what is known, in units of [`Pencil::cost`], and how many boxes that is, at least and at most; and work that is worth
/// distributing: a millisecond.
const AT_ONCE: usize = 40_000;
const BOXES_AT_ONCE: [usize; 2] = [16, 256];
const DISTRIBUTED: usize = 15_000;

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
    /// What is not told from the minimum, and what nobody wants to be told any more: a bound that is farther below is none.
    pub(in crate::bloch) gap: f64,
    pub(in crate::bloch) widest: f64,
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
    if most < FEWEST[D - 1] {
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
    let at_once = at_once(pencil);
    // What is open at the end is looked at once more.
    while !open.is_empty() && looked + open.len() < most {
        if (question.is_ended)() {
            return Some(found);
        }
        let several = open.drain(..open.len().min(at_once)).collect();
        let highest = found.lowest - question.gap;
        let sign = |cell: Cell<D>| {
            let local = pencil.on(&cell);
            let sign = local.sign(highest);
            (cell, local, sign)
        };
        for (cell, local, mut sign) in on_cores(pencil, several, sign) {
            looked += 1;
            if sign == Sign::Lost && found.lowest - question.gap < highest {
                sign = local.sign(found.lowest - question.gap);
            }
            if sign == Sign::Lost && found.is_lowered(pencil, question, &cell) {
                sign = local.sign(found.lowest - question.gap);
            }
            if sign == Sign::Positive {
                continue;
            }
            match cell.half.iter().all(|half| *half < SMALLEST) {
                true => left.push(cell),
                false => open.extend(halves(&cell, &local)),
            }
        }
    }
    left.extend(open);
    found.bound = below(pencil, question, found.lowest, &left);
    Some(found)
}

impl<const D: usize> Covered<D> {
    /// Goes downhill from the middle of a box; whether that leads below what is known.
    fn is_lowered(
        &mut self,
        pencil: &Pencil<D>,
        question: &Question<'_, D>,
        cell: &Cell<D>,
    ) -> bool {
        let k = cell.wave_vector(pencil.reciprocal());
        let value = (question.value)(&k);
        let is_long_wave = value >= self.lowest && cell.has_limit();
        let (value, k) = match is_long_wave {
            true => long_wave(pencil, &k),
            false => (question.descended)((value, k)),
        };
        let is_lower = value < self.lowest;
        if is_lower {
            (self.lowest, self.wave_vector, self.is_long_wave) = (value, Some(k), is_long_wave);
        }
        is_lower
    }
}

/// How many boxes are compared with the same value.
fn at_once<const D: usize>(pencil: &Pencil<D>) -> usize {
    let [least, most] = BOXES_AT_ONCE;
    (AT_ONCE / pencil.cost()).clamp(least, most)
}

/// Work on several boxes, on all cores where it takes longer than to distribute it.
fn on_cores<const D: usize, R: Send>(
    pencil: &Pencil<D>,
    cells: Vec<Cell<D>>,
    work: impl Fn(Cell<D>) -> R + Sync,
) -> Vec<R> {
    of_each_long(cells.len() * pencil.cost() > DISTRIBUTED, cells, work)
}

/// The softest limit of long waves downhill from a direction.
fn long_wave<const D: usize>(
    pencil: &Pencil<D>,
    direction: &SVector<f64, D>,
) -> (f64, SVector<f64, D>) {
    let limit = |k: &SVector<f64, D>| pencil.limit_along(k);
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
fn below<const D: usize>(
    pencil: &Pencil<D>,
    question: &Question<'_, D>,
    lowest: f64,
    left: &[Cell<D>],
) -> f64 {
    let mut gap = question.gap;
    for several in left.chunks(at_once(pencil)) {
        if (question.is_ended)() {
            return f64::NEG_INFINITY;
        }
        let wider = iter::successors(Some(gap), |gap| Some(gap * WIDER));
        let gaps: Vec<f64> = wider.take_while(|gap| *gap <= question.widest).collect();
        let needed = |cell: Cell<D>| {
            let local = pencil.on(&cell);
            let is_seen = |gap: &f64| local.sign(lowest - gap) == Sign::Positive;
            gaps.iter().position(is_seen).unwrap_or(gaps.len())
        };
        let most = on_cores(pencil, several.to_vec(), needed).into_iter().max();
        match gaps.get(most.unwrap_or(0)) {
            Some(needed) => gap = *needed,
            None => return f64::NEG_INFINITY,
        }
    }
    lowest - gap
}
