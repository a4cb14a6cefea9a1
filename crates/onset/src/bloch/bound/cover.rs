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
    let images = pencil.images();
    let mut found = Covered {
        lowest: question.known,
        wave_vector: None,
        is_long_wave: false,
        bound: f64::NEG_INFINITY,
    };
    let cost = |cells: &[Cell<D>]| cells.iter().map(|cell| pencil.cost_on(cell)).sum::<usize>();
    let boxes = pencil.boxes(most);
    // What is open at the end is looked at once more.
    let (mut left, mut done, mut waiting) = (Vec::new(), 0, cost(&boxes));
    let mut open = VecDeque::from(boxes);
    let at_once = at_once(pencil);
    while !open.is_empty() && done + waiting < question.budget {
        if (question.is_ended)() {
            return Some(found);
        }
        let several: Vec<_> = open.drain(..open.len().min(at_once)).collect();
        waiting -= cost(&several);
        let highest = found.lowest - question.gap;
        let look =
            |cell: Cell<D>| (!images.are_before(&cell)).then(|| Looked::at(pencil, cell, highest));
        for seen in on_cores(pencil, several, look).into_iter().flatten() {
            let Looked { cell, bends, .. } = seen;
            done += pencil.cost_on(&cell);
            let divisions = match seen.sign_below(&mut found, pencil, question, highest) {
                Sign::Positive => continue,
                Sign::Lost => 1,
                Sign::Open { divisions } => divisions,
            };
            if cell.half.iter().all(|half| *half < SMALLEST) {
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

/// What is seen of a box.
struct Looked<const D: usize> {
    cell: Cell<D>,
    bends: [f64; D],
    sign: Sign,
    /// Where the sign may change as soon as a smaller value is met.
    local: Option<Local<D>>,
}

impl<const D: usize> Looked<D> {
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

    /// The sign after what has been met since, and what is met downhill from here.
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

/// The parts of a box that is halved several times, each time where the second derivatives do most.
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
