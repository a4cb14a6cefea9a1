//! Adaptive refinement: states are computed near boundaries of the finding, and filled in elsewhere.
//!
//! The states of a coarse grid are the corners of cells. A cell is halved if the findings at its corners differ, or if the signed measures indicate
//! that a boundary may pass between corners with the same finding. It is also halved if a state computed for a neighboring cell contradicts its
//! corners. In the end all states of a cell are corners, or all have the same finding. A pocket smaller than a cell of the coarse grid can be missed
//! if no measure indicates it.

use super::record::{Finding, Outcomes, Record};
use crate::store::{ravel, unravel};
use onset::bloch::Stability;
use std::ops::Range;

/// Largest change of a measure that counts as constant: the measure of a zero-energy mode is zero to rounding.
const MEASURE_NOISE: f64 = 1e-9;

/// Number of states over which measures are smooth. Shorter cells are halved only if they are nearer to a boundary.
const SMOOTH_STATES: usize = 4;

/// Box of states, both ends included.
#[derive(Clone, Debug)]
struct Cell {
    low: Vec<usize>,
    high: Vec<usize>,
}

impl Cell {
    /// Corners of the cell; an axis without extent has a single end.
    fn corners(&self) -> Vec<Vec<usize>> {
        let ends = |(low, high): (&usize, &usize)| {
            if low == high {
                vec![*low]
            } else {
                vec![*low, *high]
            }
        };
        product(
            &self
                .low
                .iter()
                .zip(&self.high)
                .map(ends)
                .collect::<Vec<_>>(),
        )
    }

    /// States of the cell as index ranges in the tile: rows along the fastest axis.
    fn rows(&self, extent: &[usize]) -> impl Iterator<Item = Range<usize>> {
        let last = extent.len() - 1;
        let length = self.high[last] - self.low[last] + 1;
        let along = |(low, high): (&usize, &usize)| (*low..=*high).collect();
        let others = self.low.iter().zip(&self.high).take(last).map(along);
        let starts = product(&others.collect::<Vec<Vec<usize>>>());
        let first = self.low[last];
        starts.into_iter().map(move |mut place| {
            place.push(first);
            let start = ravel(&place, extent);
            start..start + length
        })
    }

    /// Returns true if the cell has states that are not corners.
    fn is_divisible(&self) -> bool {
        self.low
            .iter()
            .zip(&self.high)
            .any(|(low, high)| high - low > 1)
    }

    /// Longest edge of the cell, in states.
    fn span(&self) -> usize {
        let edges = self.low.iter().zip(&self.high);
        edges.map(|(low, high)| high - low).max().unwrap_or(0)
    }

    /// Halves of the cell along every axis that can be halved.
    fn halves(&self) -> Vec<Self> {
        let parts = |(low, high): (&usize, &usize)| {
            let middle = low.midpoint(*high);
            if high - low > 1 {
                vec![(*low, middle), (middle, *high)]
            } else {
                vec![(*low, *high)]
            }
        };
        cells(
            &self
                .low
                .iter()
                .zip(&self.high)
                .map(parts)
                .collect::<Vec<_>>(),
        )
    }
}

/// All tuples with one element from each list, the last element varying fastest.
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

/// Cells of a coarse grid. The last state along each axis is a corner, so that the cells cover exactly the states of the tile.
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

/// States of a tile during refinement.
struct Tile<'a> {
    extent: &'a [usize],
    /// Number of the record for each state, or [`NOT_COMPUTED`] if it is not computed.
    numbers: Vec<u32>,
    records: Vec<(usize, Record)>,
}

/// Marker for a state without a record.
const NOT_COMPUTED: u32 = u32::MAX;

impl<'a> Tile<'a> {
    fn new(extent: &'a [usize]) -> Self {
        Self {
            extent,
            numbers: vec![NOT_COMPUTED; extent.iter().product()],
            records: Vec::new(),
        }
    }

    fn insert(&mut self, state: usize, record: Record) {
        self.numbers[state] = self.records.len() as u32;
        self.records.push((state, record));
    }

    fn record(&self, place: &[usize]) -> Option<&Record> {
        self.known(self.numbers[ravel(place, self.extent)])
    }

    fn known(&self, number: u32) -> Option<&Record> {
        self.records.get(number as usize).map(|(_, record)| record)
    }

    /// Corners of the cells that are not computed yet.
    fn missing(&self, cells: &[Cell]) -> Vec<usize> {
        let mut missing: Vec<usize> = cells
            .iter()
            .flat_map(Cell::corners)
            .map(|corner| ravel(&corner, self.extent))
            .filter(|state| self.numbers[*state] == NOT_COMPUTED)
            .collect();
        missing.sort_unstable();
        missing.dedup();
        missing
    }

    /// Common finding of all corners, or `None` if a boundary may pass between them.
    fn agreed(&self, cell: &Cell, longest: usize) -> Option<Finding> {
        let corners = cell.corners();
        let records: Vec<&Record> = corners
            .iter()
            .filter_map(|corner| self.record(corner))
            .collect();
        let finding = records.first()?.finding;
        let agree = records.iter().all(|record| record.finding == finding);
        let span = cell.span();
        let nearness = span as f64 / longest.min(SMOOTH_STATES) as f64;
        (agree && !may_change(&records, finding, nearness.min(1.0))).then_some(finding)
    }

    /// Returns true if a computed state in the cell contradicts its corners.
    fn is_contradicted(&self, cell: &Cell, finding: Finding) -> bool {
        let differs = |number: &u32| {
            let known = self.known(*number);
            known.is_some_and(|record| record.finding != finding)
        };
        cell.rows(self.extent)
            .any(|row| self.numbers[row].iter().any(differs))
    }

    /// All states of the tile, either computed or filled in from the corners of the cell.
    fn filled(mut self, agreed: &[(Cell, Finding)]) -> Outcomes {
        // Cells fill the tile, so every state has a finding.
        let mut findings = vec![Finding::UNDEFINED; self.numbers.len()];
        for (cell, finding) in agreed {
            for row in cell.rows(self.extent) {
                findings[row].fill(*finding);
            }
        }
        for (state, record) in &self.records {
            findings[*state] = record.finding;
        }
        self.records.sort_unstable_by_key(|(state, _)| *state);
        Outcomes {
            findings,
            computed: self.records,
        }
    }
}

/// Returns true if a boundary may pass between states with the same finding.
///
/// Each measure vanishes on some boundary, but only relevant boundaries count. Stable particles lose stability where the scaled minimum vanishes, and
/// their verdict changes with ellipticity. For unstable particles the verdict is physical if the material is not elliptic and long waves of the
/// particles grow too.
fn may_change(records: &[&Record], finding: Finding, nearness: f64) -> bool {
    let [acoustic, scaled, long_wave] =
        [0, 1, 2].map(|measure| Signs::of(records, measure, nearness));
    let is_stable = finding.stability == Some(Stability::Stable);
    scaled.may_differ()
        || if is_stable {
            acoustic.may_differ()
        } else {
            let may_be_material = acoustic.negative && long_wave.negative;
            may_be_material && (acoustic.positive || long_wave.positive)
        }
}

/// Signs that a measure may have in a cell.
#[derive(Clone, Copy)]
struct Signs {
    negative: bool,
    positive: bool,
}

impl Signs {
    /// Signs at the corners, or both signs if the measure is close to zero.
    ///
    /// A measure is close to zero if it is within `nearness` times its change between corners. The error of linear interpolation is proportional to
    /// the square of the cell size, and the change is proportional to the cell size; `nearness` may therefore decrease with the cell size.
    fn of(records: &[&Record], measure: usize, nearness: f64) -> Self {
        let values = || records.iter().map(|record| record.measures[measure]);
        let low = values().fold(f64::INFINITY, f64::min);
        let high = values().fold(f64::NEG_INFINITY, f64::max);
        let smallest = values().map(f64::abs).fold(f64::INFINITY, f64::min);
        let may_vanish = high - low > MEASURE_NOISE && smallest < nearness * (high - low);
        Self {
            negative: low < -MEASURE_NOISE || may_vanish,
            positive: high > MEASURE_NOISE || may_vanish,
        }
    }

    fn may_differ(self) -> bool {
        self.negative && self.positive
    }
}

/// Computes and fills in all states of a tile. `evaluate` computes states by their numbers in the tile.
///
/// # Errors
/// Errors of `evaluate`.
pub(super) fn refine<E>(
    extent: &[usize],
    stride: usize,
    evaluate: impl Fn(&[usize]) -> Result<Vec<Record>, E>,
) -> Result<Outcomes, E> {
    let mut tile = Tile::new(extent);
    let mut open = coarse(extent, stride.max(1));
    // A small tile has no cells of the full stride.
    let longest = open.iter().map(Cell::span).max().unwrap_or(1).max(1);
    let mut agreed: Vec<(Cell, Finding)> = Vec::new();
    while !open.is_empty() {
        let missing = tile.missing(&open);
        for (state, record) in missing.iter().zip(evaluate(&missing)?) {
            tile.insert(*state, record);
        }
        let mut next = Vec::new();
        for cell in open.into_iter().filter(Cell::is_divisible) {
            match tile.agreed(&cell, longest) {
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
    Ok(tile.filled(&agreed))
}

#[cfg(test)]
mod tests {
    use super::*;
    use onset::verdict::Verdict;
    use std::cell::Cell as Count;
    use std::convert::Infallible;

    /// State of a material that is elliptic where `measure` is positive, with particles whose stability agrees.
    fn faithful(measure: f64) -> Record {
        let (verdict, stability) = if measure >= 0.0 {
            (Verdict::Stable, Stability::Stable)
        } else {
            (Verdict::Physical, Stability::Divergence)
        };
        Record {
            finding: Finding {
                verdict: Some(verdict),
                stability: Some(stability),
            },
            measures: [measure; 3],
            ..Record::UNDEFINED
        }
    }

    /// Refines a tile whose records depend only on the position, compares it with a full computation, and returns the fraction of computed states.
    fn refined(extent: &[usize], stride: usize, record: impl Fn(&[usize]) -> Record) -> f64 {
        let count = Count::new(0);
        let evaluate = |states: &[usize]| {
            count.set(count.get() + states.len());
            let at = |state: &usize| record(&unravel(*state, extent));
            Ok::<_, Infallible>(states.iter().map(at).collect())
        };
        let Ok(outcomes) = refine(extent, stride, evaluate);
        for (state, finding) in outcomes.findings.iter().enumerate() {
            let place = unravel(state, extent);
            assert_eq!(*finding, record(&place).finding, "{place:?}");
        }
        for (state, computed) in &outcomes.computed {
            let expected = record(&unravel(*state, extent));
            assert_eq!(computed.finding, expected.finding, "{state}");
        }
        assert_eq!(outcomes.computed.len(), count.get());
        assert!(outcomes.computed.is_sorted_by(|a, b| a.0 < b.0));
        count.get() as f64 / outcomes.findings.len() as f64
    }

    /// Signed distance from a ball, in states.
    fn ball(place: &[usize], center: f64, radius: f64) -> f64 {
        let squares = place.iter().map(|i| (*i as f64 - center).powi(2));
        squares.sum::<f64>().sqrt() - radius
    }

    #[test]
    fn a_closed_boundary_is_found_with_a_fraction_of_the_states() {
        for radius in [0.0, 3.0, 9.5, 20.0, 60.0] {
            let circle = |place: &[usize]| faithful(ball(place, 31.3, radius));
            let fraction = refined(&[64, 61], 16, circle);
            assert!(fraction < 0.35, "{fraction}");
            let sphere = |place: &[usize]| faithful(ball(place, 15.7, radius / 2.0));
            refined(&[32, 33, 29], 16, sphere);
        }
    }

    #[test]
    fn cost_grows_with_the_length_of_the_boundary() {
        let fraction = |states: usize| {
            let center = states as f64 / 2.0;
            let record = |place: &[usize]| faithful(ball(place, center, center / 2.0));
            refined(&[states, states], states / 4, record)
        };
        let (coarse, fine) = (fraction(64), fraction(256));
        assert!(
            fine < coarse / 3.0,
            "{coarse} of 64^2 states, {fine} of 256^2"
        );
    }

    #[test]
    fn tiles_of_any_shape_are_filled() {
        let circle = |place: &[usize]| faithful(ball(place, 5.0, 4.0));
        for extent in [[1, 1], [1, 17], [2, 16], [17, 33], [16, 16], [3, 40]] {
            for stride in [1, 2, 4, 16, 64] {
                refined(&extent, stride, circle);
            }
        }
    }

    #[test]
    fn a_boundary_without_measures_is_traced_from_cell_to_cell() {
        // A wedge of undefined states, wider than a coarse cell only at one side.
        let wedge = |place: &[usize]| {
            let (row, column) = (place[0] as f64, place[1] as f64);
            if (row - 20.0).abs() < 0.45 * column {
                Record::UNDEFINED
            } else {
                faithful(1.0)
            }
        };
        assert!(refined(&[64, 64], 16, wedge) < 0.5);
    }

    #[test]
    fn a_measure_that_is_zero_to_rounding_is_not_a_boundary() {
        let record = |place: &[usize]| {
            let rounding = if place[0].is_multiple_of(2) {
                1e-17
            } else {
                -1e-17
            };
            let measures = [1.0, rounding, rounding];
            Record {
                measures,
                ..faithful(1.0)
            }
        };
        assert!(refined(&[64, 64], 16, record) < 0.01);
    }

    #[test]
    fn an_irrelevant_measure_causes_no_refinement() {
        // Numerical instability everywhere, in a material that is elliptic on one side.
        let record = |place: &[usize]| Record {
            finding: Finding {
                verdict: Some(Verdict::Numerical),
                stability: Some(Stability::Divergence),
            },
            measures: [ball(place, 31.3, 20.0), -1.0, 1.0],
            ..Record::UNDEFINED
        };
        assert!(refined(&[64, 64], 16, record) < 0.01);
    }
}
