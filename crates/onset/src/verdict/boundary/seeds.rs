//! Seeds of boundary curves: segments with a change of phase.

use super::line::{Field, Found, Sides};
use super::plane::{Point, distance, minus, plus, unit};
use super::{Crossing, Fineness, Window, rank};
use crate::algebra::{Each, lowest_between};
use crate::verdict::change::Knot;
use crate::verdict::{Phase, Probe};

/// Accuracy of a local minimum along a line, as a fraction of the line, and the number of evaluations of a search in the plane.
const DIP: f64 = 2e-6;
const PLANE_STEPS: usize = 160;

/// Segment with a change of phase: its two ends.
pub(super) type Seed = ((Point, Probe), (Point, Probe));

/// Nodes of the grid of seeds. The first parameter varies fastest.
pub fn grid_points(window: Window, fineness: &Fineness) -> Vec<[f64; 2]> {
    let grid = Grid::new(fineness);
    (0..grid.len())
        .map(|n| window.point(grid.node(n)))
        .collect()
}

/// Grid of seeds in units of the window.
#[derive(Clone, Copy)]
struct Grid {
    columns: usize,
    rows: usize,
}

impl Grid {
    fn new(fineness: &Fineness) -> Self {
        let [columns, rows] = fineness.cells.each(|cells| cells.max(2) + 1);
        Self { columns, rows }
    }

    fn len(self) -> usize {
        self.columns * self.rows
    }

    fn node(self, index: usize) -> Point {
        let along = |n: usize, count: usize| n as f64 / (count - 1) as f64;
        [
            along(index % self.columns, self.columns),
            along(index / self.columns, self.rows),
        ]
    }
}

/// Returns all segments with a change of phase: edges of the grid with different phases at their ends, and local minima.
pub(super) fn seeds<E>(
    field: &Field<'_, E>,
    fineness: &Fineness,
    probes: &[Probe],
) -> Result<Vec<Seed>, E> {
    let grid = Grid::new(fineness);
    let knot = |index: usize| (grid.node(index), probes[index]);
    let mut seeds = Vec::new();
    for index in 0..grid.len() {
        let (column, row) = (index % grid.columns, index / grid.columns);
        let mut edges = Vec::new();
        if column + 1 < grid.columns {
            edges.push(index + 1);
        }
        if row + 1 < grid.rows {
            edges.push(index + grid.columns);
        }
        for other in edges {
            if probes[index].0 != probes[other].0 {
                seeds.push((knot(index), knot(other)));
            }
        }
    }
    for index in 0..grid.len() {
        let (column, row) = (index % grid.columns, index / grid.columns);
        let inner = [
            (column > 0 && column + 1 < grid.columns, 1),
            (row > 0 && row + 1 < grid.rows, grid.columns),
        ];
        for (is_inner, step) in inner {
            if is_inner {
                let line = [index - step, index, index + step].map(knot);
                seeds.extend(dip_along(field, line)?);
            }
        }
        if let Some(seed) = dip_in_plane(field, grid, probes, index)? {
            seeds.push(seed);
        }
    }
    Ok(seeds)
}

/// Sign for which `sign * measure` decreases towards the other phase; `None` if the measure does not predict a change.
fn sign(phase: Phase) -> Option<f64> {
    match phase {
        Phase::Stable => Some(1.0),
        Phase::Unstable => Some(-1.0),
        Phase::Flutter | Phase::Undefined => None,
    }
}

/// Searches for a change of phase between three nodes of one phase.
///
/// The search starts if the measure of the middle node is a minimum and the slopes on both sides permit a change of sign.
fn dip_along<E>(
    field: &Field<'_, E>,
    [left, middle, right]: [(Point, Probe); 3],
) -> Result<Vec<Seed>, E> {
    let own = middle.1.0;
    let (true, Some(sign)) = (left.1.0 == own && right.1.0 == own, sign(own)) else {
        return Ok(Vec::new());
    };
    let (down, up) = (
        sign * (left.1.1 - middle.1.1),
        sign * (right.1.1 - middle.1.1),
    );
    if !(down >= 0.0 && up >= 0.0 && sign * middle.1.1 <= down.max(up)) {
        return Ok(Vec::new());
    }
    let along = minus(right.0, left.0);
    let place = |x: f64| plus(left.0, x, along);
    let at = |x: f64| match field.at(place(x)) {
        Ok(Some(found)) if found.0 == own => Ok(sign * found.1),
        Ok(found) => Err(Ok(found.map(|found| (place(x), found)))),
        Err(error) => Err(Err(error)),
    };
    let met = lowest_between(at, [0.0, 0.5, 1.0], sign * middle.1.1, DIP).err();
    let other = met.transpose()?.flatten();
    Ok(other.map_or_else(Vec::new, |other| vec![(left, other), (other, right)]))
}

/// Searches for an island of another phase between the lines of the grid, near a node with a local minimum of the measure.
///
/// The search moves along the coordinates with decreasing steps.
fn dip_in_plane<E>(
    field: &Field<'_, E>,
    grid: Grid,
    probes: &[Probe],
    index: usize,
) -> Result<Option<Seed>, E> {
    let own = probes[index].0;
    let Some(sign) = sign(own) else {
        return Ok(None);
    };
    let (column, row) = (index % grid.columns, index / grid.columns);
    let value = sign * probes[index].1;
    let mut steepest = 0.0_f64;
    for other_row in row.saturating_sub(1)..=(row + 1).min(grid.rows - 1) {
        for other_column in column.saturating_sub(1)..=(column + 1).min(grid.columns - 1) {
            let other = probes[other_row * grid.columns + other_column];
            if other.0 != own || sign * other.1 < value {
                return Ok(None);
            }
            steepest = steepest.max(sign * other.1 - value);
        }
    }
    if value > steepest {
        return Ok(None);
    }
    let start = (grid.node(index), probes[index]);
    let (mut at, mut best) = (start.0, value);
    let mut step = [
        0.5 / (grid.columns - 1) as f64,
        0.5 / (grid.rows - 1) as f64,
    ];
    let mut spent = 0;
    while spent < PLANE_STEPS && step[0].max(step[1]) > 1e-7 {
        let mut improved = false;
        for (i, direction) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
            let mut trial = at;
            trial[i] += direction * step[i];
            let Some(found) = field.at(trial)? else {
                continue;
            };
            spent += 1;
            if found.0 != own {
                return Ok(Some((start, (trial, found))));
            }
            if sign * found.1 < best {
                (at, best, improved) = (trial, sign * found.1, true);
            }
        }
        if !improved {
            step = step.map(|size| 0.5 * size);
        }
    }
    Ok(None)
}

/// Returns the changes of phase on a seed. A third phase in between splits the seed.
pub(super) fn crossings<E>(
    field: &Field<'_, E>,
    fineness: &Fineness,
    seed: Seed,
) -> Result<Vec<Crossing>, E> {
    let mut found = Vec::new();
    let mut open = vec![seed];
    while let Some((a, b)) = open.pop() {
        let size = distance(a.0, b.0);
        if a.1.0 == b.1.0 || size <= 1e-12 {
            continue;
        }
        let (left, right) = if rank(a.1.0) < rank(b.1.0) {
            (a, b)
        } else {
            (b, a)
        };
        let along = unit(minus(left.0, right.0));
        let origin = right.0;
        // The exact end without rounding: it may lie on the edge of the window.
        let line = |x: f64| {
            if x == size {
                left.0
            } else {
                plus(origin, x, along)
            }
        };
        let knots: (Knot, Knot) = ((size, left.1), (0.0, right.1));
        let change = field.narrow(&line, knots, fineness.bracket)?;
        if let (Some((x, accuracy)), Found::Change(left, right)) = (change.place(), &change) {
            found.push(Crossing {
                at: line(x),
                along,
                sides: Sides {
                    left: left.1.0,
                    right: right.1.0,
                },
                accuracy,
            });
        } else if found.len() + open.len() < 8 {
            let middle = plus(origin, 0.5 * size, along);
            if let Some(probe) = field.at(middle)? {
                open.push((a, (middle, probe)));
                open.push(((middle, probe), b));
            }
        }
    }
    Ok(found)
}
