//! Branch and bound over the zone.

use super::cell::Cell;
use super::local::{Local, Sign};
use super::pencil::Pencil;
use crate::algebra::Each;
use crate::bloch::settled_along;
use crate::cancel::checkpoint;
use crate::cores::of_each_long;
use nalgebra::SVector;
use std::collections::VecDeque;
use std::iter;

/// Half side of the smallest box that is still divided, in reciprocal vectors.
const SMALLEST_HALF_SIDE: f64 = 1e-9;
/// Minimum number of affordable boxes in one, two and three dimensions. A smaller budget gives no useful bound.
const MINIMUM_BOXES: [usize; 3] = [64, 256, 2048];
/// Ratio of successive gaps that are tried for a remaining box.
const GAP_FACTOR: f64 = 4.0;
/// Work between two comparisons with the smallest known value, in units of [`Pencil::cost`].
const BATCH_WORK: usize = 40_000;
/// Minimum and maximum number of boxes between two comparisons with the smallest known value.
const BATCH_BOXES: [usize; 2] = [16, 256];
/// Work that justifies distribution over the cores, in units of [`Pencil::cost`]: about a millisecond.
const PARALLEL_WORK: usize = 15_000;

/// Result of a cover of the zone.
#[derive(Clone, Copy, Debug)]
pub(in crate::bloch) struct Covered<const D: usize> {
    /// Smallest value of the measure encountered.
    pub(in crate::bloch) lowest: f64,
    /// Wave vector of the smallest value, if it is below the given value; for a long-wave limit, its direction.
    pub(in crate::bloch) wave_vector: Option<SVector<f64, D>>,
    pub(in crate::bloch) is_long_wave: bool,
    /// Lower bound of all values.
    pub(in crate::bloch) bound: f64,
}

/// A measure and the requested accuracy of its minimum.
pub(in crate::bloch) struct Question<'a, const D: usize> {
    /// A value that the measure attains.
    pub(in crate::bloch) known: f64,
    /// Accepted difference between bound and minimum.
    pub(in crate::bloch) gap: f64,
    /// Largest useful difference; a bound that is farther below the minimum is discarded.
    pub(in crate::bloch) widest: f64,
    /// Maximum work, in units of [`Pencil::cost`].
    pub(in crate::bloch) budget: usize,
    /// Evaluates the measure at a wave vector.
    pub(in crate::bloch) value: &'a dyn Fn(&SVector<f64, D>) -> f64,
    /// Descends from a wave vector with a known value to a local minimum.
    #[allow(clippy::type_complexity)]
    pub(in crate::bloch) descended: &'a dyn Fn((f64, SVector<f64, D>)) -> (f64, SVector<f64, D>),
}

/// Covers the zone with boxes in which no value is lower than the smallest known value by more than the gap.
///
/// Boxes without a proof are divided. If the value at the center of a box is lower, a descent from there gives the new smallest value. `None` if the
/// budget is too small for any bound.
pub(super) fn cover<const D: usize>(
    pencil: &Pencil<D>,
    question: &Question<'_, D>,
) -> Option<Covered<D>> {
    let most = question.budget / pencil.cost();
    if most < MINIMUM_BOXES[D - 1] {
        return None;
    }
    let images = pencil.images();
    let mut found = Covered {
        lowest: question.known,
        wave_vector: None,
        is_long_wave: false,
        bound: f64::NEG_INFINITY,
    };
    let cost = |cells: &[Cell<D>]| cells.iter().map(|cell| pencil.cost_on(cell)).sum::<usize>();
    let boxes = pencil.boxes(most);
    // The remaining boxes are examined a second time at the end.
    let (mut left, mut done, mut waiting) = (Vec::new(), 0, cost(&boxes));
    let mut open = VecDeque::from(boxes);
    let at_once = at_once(pencil);
    while !open.is_empty() && done + waiting < question.budget {
        checkpoint();
        let several: Vec<_> = open.drain(..open.len().min(at_once)).collect();
        waiting -= cost(&several);
        let highest = found.lowest - question.gap;
        let test =
            |cell: Cell<D>| (!images.are_before(&cell)).then(|| Tested::at(pencil, cell, highest));
        for tested in on_cores(pencil, several, test).into_iter().flatten() {
            let Tested { cell, bends, .. } = tested;
            done += pencil.cost_on(&cell);
            let divisions = match tested.sign_below(&mut found, pencil, question, highest) {
                Sign::Positive => continue,
                Sign::Lost => 1,
                Sign::Open { divisions } => divisions,
            };
            if cell.half.iter().all(|half| *half < SMALLEST_HALF_SIDE) {
                left.push(cell);
                continue;
            }
            let parts = divided(cell, bends, divisions);
            waiting += cost(&parts);
            open.extend(parts);
        }
    }
    left.extend(open.into_iter().filter(|cell| !images.are_before(cell)));
    found.bound = below(pencil, question, found.lowest, &left);
    Some(found)
}

/// Result of the test of one box.
struct Tested<const D: usize> {
    cell: Cell<D>,
    bends: [f64; D],
    sign: Sign,
    /// Polynomials of a box whose center has a lower value; a smaller known value can change the sign.
    local: Option<Local<D>>,
}

impl<const D: usize> Tested<D> {
    fn at(pencil: &Pencil<D>, cell: Cell<D>, highest: f64) -> Self {
        let local = pencil.on(&cell);
        let sign = local.sign(highest);
        Self {
            cell,
            bends: local.bends,
            sign,
            local: (sign == Sign::Lost).then_some(local),
        }
    }

    /// Sign of the box relative to the smallest value, including values found in the meantime and by a descent from its center.
    fn sign_below(
        &self,
        found: &mut Covered<D>,
        pencil: &Pencil<D>,
        question: &Question<'_, D>,
        highest: f64,
    ) -> Sign {
        let Some(local) = &self.local else {
            return self.sign;
        };
        let sign = |found: &Covered<D>| local.sign(found.lowest - question.gap);
        let mut own = self.sign;
        if found.lowest - question.gap < highest {
            own = sign(found);
        }
        if own == Sign::Lost && found.is_lowered(pencil, question, &self.cell) {
            own = sign(found);
        }
        own
    }
}

impl<const D: usize> Covered<D> {
    /// Descends from the center of a box, and returns true if this lowers the smallest known value.
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

/// Number of boxes that are compared with the same smallest value.
fn at_once<const D: usize>(pencil: &Pencil<D>) -> usize {
    let [least, most] = BATCH_BOXES;
    (BATCH_WORK / pencil.cost()).clamp(least, most)
}

/// Applies `work` to several boxes, on all cores if it takes longer than their distribution.
fn on_cores<const D: usize, R: Send>(
    pencil: &Pencil<D>,
    cells: Vec<Cell<D>>,
    work: impl Fn(Cell<D>) -> R + Sync,
) -> Vec<R> {
    of_each_long(cells.len() * pencil.cost() > PARALLEL_WORK, cells, work)
}

/// Smallest long-wave limit found by descent from a direction.
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
    let limits = |all: &[SVector<f64, D>]| all.iter().map(limit).collect();
    let (value, direction) = settled_along(&limits, start, &steps);
    (value, direction.normalize())
}

/// Halves a box `divisions` times, each time along the variable whose second derivatives contribute most.
fn divided<const D: usize>(cell: Cell<D>, mut bends: [f64; D], divisions: usize) -> Vec<Cell<D>> {
    let mut parts = vec![cell];
    for _ in 0..divisions {
        let mut widest = 0;
        for a in 1..D {
            if bends[a] > bends[widest] {
                widest = a;
            }
        }
        bends[widest] *= 0.25;
        let halves = |cell: Cell<D>| {
            [-0.5, 0.5].each(|side| {
                let mut part = cell;
                part.half[widest] *= 0.5;
                part.middle[widest] += side * cell.half[widest];
                part
            })
        };
        parts = parts.into_iter().flat_map(halves).collect();
    }
    parts
}

/// Lower bound of all values, including the values in the remaining boxes.
fn below<const D: usize>(
    pencil: &Pencil<D>,
    question: &Question<'_, D>,
    lowest: f64,
    left: &[Cell<D>],
) -> f64 {
    let mut gap = question.gap;
    for several in left.chunks(at_once(pencil)) {
        checkpoint();
        let wider = iter::successors(Some(gap), |gap| Some(gap * GAP_FACTOR));
        let gaps: Vec<f64> = wider.take_while(|gap| *gap <= question.widest).collect();
        let needed = |cell: Cell<D>| {
            let local = pencil.on(&cell);
            let is_seen = |gap: &f64| local.sign(lowest - gap) == Sign::Positive;
            gaps.partition_point(|gap| !is_seen(gap))
        };
        let most = on_cores(pencil, several.to_vec(), needed).into_iter().max();
        match gaps.get(most.unwrap_or(0)) {
            Some(needed) => gap = *needed,
            None => return f64::NEG_INFINITY,
        }
    }
    lowest - gap
}
