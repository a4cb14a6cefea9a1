//! Proof that a law is stable at all states of a range, by interval arithmetic.
//!
//! The range is divided into cells. On a cell the deciding numbers (leading minors of Drucker's matrix, Bernstein coefficients of the elliptic forms)
//! are enclosed by their mean-value form, `f(middle) + f'(cell) (cell - middle)`, whose overestimation is of second order in the size of the cell. A
//! cell in which a number may be negative is halved; an unstable state ends the proof.

use crate::moduli::{Criterion, cubic, quadratic};
use crate::range::{Numbers, Patch, Worst};
use crate::sums::Enclosed;
use onset::cancel::checkpoint;
use onset::real::{Dual, Interval, Real};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Outcome of the proof that a law is stable at all states of a range.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Proof {
    /// No state of the range is unstable.
    Proved {
        /// Number of cells of the range; 0 if the law is convex at all states.
        cells: usize,
    },
    /// An unstable state was found.
    Refuted {
        /// State with its criterion and value.
        worst: Worst,
    },
    /// The states of the range were sampled and found stable; the proof needs more cells than allowed, or is not available for the law.
    Sampled,
}

/// Largest number of cells.
const CELLS: usize = 20_000;
/// Number with derivatives with respect to the parameters of a patch.
type Slope = Dual<2, Interval>;
/// Largest number of subdivisions of the triangle of directions, for one form and for all cells together.
const MOST_PARTS: usize = 5_000;
const ALL_PARTS: usize = 300_000;
/// Rounding error of the coefficients of a part, relative to the largest coefficient.
const ROUNDING_FRACTION: f64 = 1e-14;
/// Proves that the criteria are positive on all patches.
pub(crate) fn prove(law: &Numbers<'_>, patches: &[Patch]) -> Proof {
    if law.family.is_compressible() {
        return Proof::Sampled;
    }
    let criteria: Vec<Criterion> = (law.criteria.iter().copied())
        .filter(|own| !law.family.is_convex(*own, law.constants))
        .collect();
    if criteria.is_empty() {
        return Proof::Proved { cells: 0 };
    }
    let law = &Numbers {
        criteria: &criteria,
        ..*law
    };
    let shear = law.shear_modulus();
    let mut cells = 0;
    let used = AtomicUsize::new(0);
    for patch in patches {
        let dimension = patch.axes.len();
        let ends = |a: usize| match a < dimension {
            true => [patch.low[a], patch.high[a]],
            false => [0.0; 2],
        };
        let mut level = vec![[ends(0), ends(1)]];
        while !level.is_empty() {
            checkpoint();
            level.retain(|cell| !(patch.ordered && is_outside(patch, cell)));
            cells += level.len();
            if cells > CELLS || used.load(Relaxed) > ALL_PARTS {
                return Proof::Sampled;
            }
            let open: Vec<_> = level
                .into_par_iter()
                .filter(|cell| !is_stable(law, patch, cell, &used))
                .collect();
            level = Vec::with_capacity(2 * open.len());
            for cell in open {
                let middle = cell.map(|[a, b]| 0.5 * (a + b));
                let logs = patch.logs(&middle[..dimension]);
                if !patch.ordered || logs.is_sorted_by(|a, b| a >= b) {
                    let worst = law.worst_at(logs, shear);
                    if worst.value <= 0.0 {
                        return Proof::Refuted { worst };
                    }
                }
                let axis = usize::from(cell[1][1] - cell[1][0] > cell[0][1] - cell[0][0]);
                let [a, b] = cell[axis];
                for half in [[a, middle[axis]], [middle[axis], b]] {
                    let mut part = cell;
                    part[axis] = half;
                    level.push(part);
                }
            }
        }
    }
    Proof::Proved { cells }
}

/// Returns true if no state of a cell has its strains in descending order.
fn is_outside(patch: &Patch, cell: &[[f64; 2]; 2]) -> bool {
    let parameter = |a: usize| Interval::new(cell[a][0], cell[a][1]);
    let logs = logs_of(patch, [parameter(0), parameter(1)]);
    (logs[0] - logs[1]).high < 0.0 || (logs[1] - logs[2]).high < 0.0
}

fn logs_of<R: Real>(patch: &Patch, at: [R; 2]) -> [R; 3] {
    std::array::from_fn(|i| {
        let parts = patch.axes.iter().zip(at);
        parts.fold(R::constant(0.0), |sum, (axis, t)| sum + t * axis[i])
    })
}

/// Numbers that decide on stability at the states of a cell, on the whole cell or at its middle.
struct Deciding<R> {
    drucker: [R; 2],
    trace: [R; 6],
    determinant: [R; 10],
}

fn is_stable(law: &Numbers<'_>, patch: &Patch, cell: &[[f64; 2]; 2], used: &AtomicUsize) -> bool {
    let whole = cell.map(|[a, b]| Interval::new(a, b));
    let middle = whole.map(|own| Interval::point(own.midpoint()));
    let on_cell = deciding(law, patch, Slope::variables(whole));
    let at_middle = deciding(law, patch, middle);
    let offsets: [Interval; 2] = std::array::from_fn(|a| whole[a] - middle[a]);
    // On an axis without extent the slope may be unbounded; its product with the zero offset would be undefined.
    let axes: Vec<usize> = (0..2).filter(|a| cell[*a][0] < cell[*a][1]).collect();
    // Bound at a corner. The smallest bound over all corners is a lower bound on the whole cell.
    let bound = |corner: usize, on_cell: &Slope, at_middle: &Interval| {
        let mut sum = *at_middle;
        for a in &axes {
            let slope = on_cell.gradient[*a];
            let end = Interval::point(cell[*a][corner >> a & 1]) - middle[*a];
            sum = sum + end * slope.midpoint() - offsets[*a].abs() * slope.radius();
        }
        if sum.low.is_nan() {
            f64::NEG_INFINITY
        } else {
            sum.low
        }
    };
    law.criteria.iter().all(|criterion| match criterion {
        Criterion::Drucker => (0..2).all(|n| {
            let (on_cell, at_middle) = (&on_cell.drucker[n], &at_middle.drucker[n]);
            on_cell.value.low > 0.0 || (0..4).all(|corner| bound(corner, on_cell, at_middle) > 0.0)
        }),
        Criterion::StrongEllipticity => (0..4).all(|corner| {
            let trace: [f64; 6] =
                std::array::from_fn(|n| bound(corner, &on_cell.trace[n], &at_middle.trace[n]));
            let determinant: [f64; 10] = std::array::from_fn(|n| {
                bound(corner, &on_cell.determinant[n], &at_middle.determinant[n])
            });
            is_elliptic(trace, determinant, used)
        }),
    })
}

/// Returns true if both forms are positive for all directions.
fn is_elliptic(mut trace: [f64; 6], mut determinant: [f64; 10], used: &AtomicUsize) -> bool {
    // Scales of the axes that make the form 1 at the corners.
    let units = |form: &[f64], degree: f64| -> Option<[f64; 3]> {
        let corners = form.iter().take(3).all(|own| *own > 0.0);
        corners.then(|| std::array::from_fn(|a| form[a].powf(-1.0 / degree)))
    };
    let (Some(u), Some(v)) = (units(&trace, 2.0), units(&determinant, 3.0)) else {
        return false;
    };
    for a in 0..3 {
        for b in a..3 {
            trace[quadratic(a, b)] *= u[a] * u[b];
            for c in b..3 {
                determinant[cubic(a, b, c)] *= v[a] * v[b] * v[c];
            }
        }
    }
    is_positive(trace, quadratic_halves, used) && is_positive(determinant, cubic_halves, used)
}

fn deciding<R: Enclosed>(law: &Numbers<'_>, patch: &Patch, at: [R; 2]) -> Deciding<R> {
    let moduli = law.family.moduli(law.constants, logs_of(patch, at));
    let (trace, determinant) = moduli.elliptic_forms();
    Deciding {
        drucker: moduli.isochoric_minors(),
        trace,
        determinant,
    }
}

/// Returns true if a form is positive on a triangle, because its Bernstein coefficients on the triangle or on parts of it are positive.
fn is_positive<const N: usize>(
    form: [f64; N],
    halves: fn(&[f64; N], usize) -> [[f64; N]; 2],
    used: &AtomicUsize,
) -> bool {
    // Rounding error of the halvings.
    let least = ROUNDING_FRACTION * form.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let mut open = vec![form];
    for _ in 0..MOST_PARTS {
        let Some(part) = open.pop() else {
            return true;
        };
        if part.iter().all(|own| *own > least) {
            continue;
        }
        // The first three coefficients are values at the corners.
        if !part[..3].iter().all(|own| *own > least) {
            return false;
        }
        if used.fetch_add(1, Relaxed) > ALL_PARTS {
            return false;
        }
        // Three halvings, one per edge.
        let mut parts = vec![part];
        for edge in 0..3 {
            parts = parts.iter().flat_map(|own| halves(own, edge)).collect();
        }
        open.extend(parts);
    }
    open.is_empty()
}

/// Ends of the edge opposite to a corner.
fn ends_of(edge: usize) -> (usize, usize) {
    ((edge + 1) % 3, (edge + 2) % 3)
}

/// Bernstein coefficients on the two halves of a triangle that is cut at the middle of an edge: values of the polar form, in which the mean of both
/// ends of the edge replaces one corner.
fn quadratic_halves(form: &[f64; 6], edge: usize) -> [[f64; 6]; 2] {
    let (p, q) = ends_of(edge);
    [q, p].map(|moved| {
        let mut part = [0.0; 6];
        for a in 0..3 {
            for b in a..3 {
                let places = [a, b].map(|own| if own == moved { [p, q] } else { [own, own] });
                let sum: f64 = (0..4)
                    .map(|n| form[quadratic(places[0][n & 1], places[1][n >> 1])])
                    .sum();
                part[quadratic(a, b)] = sum / 4.0;
            }
        }
        part
    })
}

/// Indices of the coefficients whose mean is one coefficient on a half of a triangle, with their number.
type Means = [(usize, [usize; 8]); 10];

/// Means for all halvings of a triangle: by the edge that is cut, and by the half.
static CUBIC_MEANS: LazyLock<[[Means; 2]; 3]> = LazyLock::new(|| {
    std::array::from_fn(|edge| {
        let (p, q) = ends_of(edge);
        [q, p].map(|moved| {
            let mut means: Means = [(0, [0; 8]); 10];
            for a in 0..3 {
                for b in a..3 {
                    for c in b..3 {
                        let (count, places) = &mut means[cubic(a, b, c)];
                        // A moved corner replaces both ends of the edge.
                        let ends = |own: usize| match own == moved {
                            true => vec![p, q],
                            false => vec![own],
                        };
                        for a in ends(a) {
                            for b in ends(b) {
                                for c in ends(c) {
                                    places[*count] = cubic(a, b, c);
                                    *count += 1;
                                }
                            }
                        }
                    }
                }
            }
            means
        })
    })
});

fn cubic_halves(form: &[f64; 10], edge: usize) -> [[f64; 10]; 2] {
    let means = &CUBIC_MEANS[edge];
    let mut halves = [[0.0; 10]; 2];
    for (half, means) in halves.iter_mut().zip(means) {
        for (part, (count, places)) in half.iter_mut().zip(means) {
            let mut sum = 0.0;
            for place in &places[..*count] {
                sum += form[*place];
            }
            *part = sum / *count as f64;
        }
    }
    halves
}
