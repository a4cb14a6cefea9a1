//! Refinement: states are computed where the finding changes or may change, and filled in elsewhere.
//!
//! States on a coarse stride are the corners of cells. A cell is halved where the findings at its corners differ, or where a
//! signed measure is so small at one of them, compared with its change from corner to corner, that its zero may pass through; also
//! where a state that a neighboring cell has computed says otherwise. In the end cells have no states between their corners, or all
//! their states have one finding. A pocket smaller than a cell of the coarse stride, of which no measure tells, can be missed.

use super::record::{Finding, Outcome, Record};
use crate::store::{ravel, unravel};

/// Measures of smaller change are constant: a mode without energy has a measure of zero, to rounding.
const NOISE: f64 = 1e-9;

/// A box of states, both ends included.
#[derive(Clone, Debug)]
struct Cell {
    low: Vec<usize>,
    high: Vec<usize>,
}

impl Cell {
    /// Its states at steps of its edges: the corners. An axis without extent has one.
    fn corners(&self) -> Vec<Vec<usize>> {
        let ends = |(low, high): (&usize, &usize)| {
            if low == high {
                vec![*low]
            } else {
                vec![*low, *high]
            }
        };
        product(&self.low.iter().zip(&self.high).map(ends).collect::<Vec<_>>())
    }

    /// All its states.
    fn states(&self) -> Vec<Vec<usize>> {
        let along = |(low, high): (&usize, &usize)| (*low..=*high).collect();
        product(&self.low.iter().zip(&self.high).map(along).collect::<Vec<_>>())
    }

    /// Whether there are states that are no corners.
    fn is_divisible(&self) -> bool {
        self.low.iter().zip(&self.high).any(|(low, high)| high - low > 1)
    }

    /// Its halves along every axis that can be halved.
    fn halves(&self) -> Vec<Self> {
        let parts = |(low, high): (&usize, &usize)| {
            let middle = low.midpoint(*high);
            if high - low > 1 {
                vec![(*low, middle), (middle, *high)]
            } else {
                vec![(*low, *high)]
            }
        };
        cells(&self.low.iter().zip(&self.high).map(parts).collect::<Vec<_>>())
    }
}

/// All tuples with one element of each list, the last running fastest.
fn product<T: Copy>(lists: &[Vec<T>]) -> Vec<Vec<T>> {
    let shape: Vec<usize> = lists.iter().map(Vec::len).collect();
    let tuple = |index| {
        let place = unravel(index, &shape);
        lists.iter().zip(place).map(|(list, i)| list[i]).collect()
    };
    (0..shape.iter().product()).map(tuple).collect()
}

fn cells(intervals: &[Vec<(usize, usize)>]) -> Vec<Cell> {
    let cell = |ends: Vec<(usize, usize)>| {
        let (low, high) = ends.into_iter().unzip();
        Cell { low, high }
    };
    product(intervals).into_iter().map(cell).collect()
}

/// The cells of a coarse stride. The last state along each axis is a corner, so that the cells fill the tile and no state outside
/// it is needed.
fn coarse(extent: &[usize], stride: usize) -> Vec<Cell> {
    let along = |states: &usize| {
        let last = states - 1;
        let ends = |low: usize| (low, (low + stride).min(last));
        let intervals: Vec<_> = (0..last).step_by(stride).map(ends).collect();
        if intervals.is_empty() {
            vec![(0, 0)]
        } else {
            intervals
        }
    };
    cells(&extent.iter().map(along).collect::<Vec<_>>())
}

/// The states of a tile while it is refined.
struct Tile<'a> {
    extent: &'a [usize],
    records: Vec<Option<Record>>,
}

impl Tile<'_> {
    fn record(&self, place: &[usize]) -> Option<&Record> {
        self.records[ravel(place, self.extent)].as_ref()
    }

    /// The corners of cells that are not computed yet.
    fn missing(&self, cells: &[Cell]) -> Vec<usize> {
        let mut missing: Vec<usize> = cells
            .iter()
            .flat_map(Cell::corners)
            .map(|corner| ravel(&corner, self.extent))
            .filter(|state| self.records[*state].is_none())
            .collect();
        missing.sort_unstable();
        missing.dedup();
        missing
    }

    /// The one finding at all corners, where no boundary can pass between them.
    fn agreed(&self, cell: &Cell) -> Option<Finding> {
        let corners = cell.corners();
        let records: Vec<&Record> = corners
            .iter()
            .filter_map(|corner| self.record(corner))
            .collect();
        let finding = records.first()?.finding;
        let agree = records.iter().all(|record| record.finding == finding);
        (agree && !(0..3).any(|measure| may_vanish(&records, measure))).then_some(finding)
    }

    /// Whether a state that was computed contradicts the corners.
    fn is_contradicted(&self, cell: &Cell, finding: Finding) -> bool {
        cell.states().iter().any(|place| {
            self.record(place)
                .is_some_and(|record| record.finding != finding)
        })
    }
}

/// Whether a measure changes as much from corner to corner as it is away from zero at the nearest.
fn may_vanish(records: &[&Record], measure: usize) -> bool {
    let values = || records.iter().map(|record| record.measures[measure]);
    let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let smallest = values().map(f64::abs).fold(f64::INFINITY, f64::min);
    high - low > NOISE && smallest < high - low
}

/// What is known about every state of a tile. `evaluate` computes states by their numbers in the tile.
///
/// # Errors
/// Those of `evaluate`.
pub(super) fn refine<E>(
    extent: &[usize],
    stride: usize,
    evaluate: impl Fn(&[usize]) -> Result<Vec<Record>, E>,
) -> Result<Vec<Outcome>, E> {
    let mut tile = Tile {
        extent,
        records: vec![None; extent.iter().product()],
    };
    let mut open = coarse(extent, stride.max(1));
    let mut agreed: Vec<(Cell, Finding)> = Vec::new();
    while !open.is_empty() {
        let missing = tile.missing(&open);
        for (state, record) in missing.iter().zip(evaluate(&missing)?) {
            tile.records[*state] = Some(record);
        }
        let mut next = Vec::new();
        for cell in open.into_iter().filter(Cell::is_divisible) {
            match tile.agreed(&cell) {
                Some(finding) => agreed.push((cell, finding)),
                None => next.extend(cell.halves()),
            }
        }
        if next.is_empty() {
            let contradicted;
            (contradicted, agreed) = agreed
                .into_iter()
                .partition(|(cell, finding)| tile.is_contradicted(cell, *finding));
            next.extend(contradicted.iter().flat_map(|(cell, _)| cell.halves()));
        }
        open = next;
    }
    Ok(filled(&tile, &agreed))
}

/// Every state: as computed, or as the corners of its cell.
fn filled(tile: &Tile<'_>, agreed: &[(Cell, Finding)]) -> Vec<Outcome> {
    let computed = |record: &Option<Record>| record.map(Outcome::from);
    let mut outcomes: Vec<Option<Outcome>> = tile.records.iter().map(computed).collect();
    for (cell, finding) in agreed {
        for place in cell.states() {
            outcomes[ravel(&place, tile.extent)].get_or_insert(Outcome {
                finding: *finding,
                record: None,
            });
        }
    }
    let undefined = Outcome {
        finding: Finding::UNDEFINED,
        record: None,
    };
    // Cells fill the tile, so that every state is known.
    outcomes
        .into_iter()
        .map(|outcome| outcome.unwrap_or(undefined))
        .collect()
}
