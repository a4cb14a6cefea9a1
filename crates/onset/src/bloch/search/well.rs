//! Local minima of a function on a periodic grid, and their refinement.

use crate::algebra::{Each, array_of};
use crate::lattice::grid_coordinates;
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Returns true if no neighbor on the periodic grid is lower. The first half of the grid is known.
pub(crate) fn is_well<const D: usize>(values: &[f64], index: usize, n: usize) -> bool {
    values[index].is_finite() && !has_neighbor::<D>(values, index, n, |other| other < values[index])
}

/// Returns true if a neighbor on the periodic grid has a finite value with a property. The first half of the grid is known.
pub(crate) fn has_neighbor<const D: usize>(
    values: &[f64],
    index: usize,
    n: usize,
    has_property: impl Fn(f64) -> bool,
) -> bool {
    let mut around = neighbors::<D>(index, n, values.len()).map(|other| values[other]);
    around.any(|other| other.is_finite() && has_property(other))
}

/// Largest ratio of the squared difference of two branches at a point near their crossing to its largest value around the point.
///
/// If branches cross within 0.6 grid steps along each axis, the ratio is `(0.6/1.6)^2 = 0.14`.
pub(super) const CROSSING_RATIO: f64 = 0.15;

/// Returns true if two branches may cross near a point of the periodic grid, judging by the square of their difference, or are a complex pair there.
pub(crate) fn is_near_crossing<const D: usize>(squares: &[f64], index: usize, n: usize) -> bool {
    let own = squares[index];
    own <= 0.0 || has_neighbor::<D>(squares, index, n, |other| own <= CROSSING_RATIO * other)
}

/// Neighbors of a point on the periodic grid. Only the first `known` points are returned, and the others are replaced by their opposites.
pub(crate) fn neighbors<const D: usize>(
    index: usize,
    n: usize,
    known: usize,
) -> impl Iterator<Item = usize> {
    let coordinates = grid_coordinates::<D>(index, n);
    let flat = move |coordinates: &[usize; D]| coordinates.iter().fold(0, |sum, c| sum * n + c);
    // Most points have all neighbors within the grid, at fixed distances in its list.
    let farthest = flat(&[1; D]);
    let is_inside = coordinates.iter().all(|c| (1..n - 1).contains(c)) && index + farthest < known;
    // Divisions dominate the cost.
    let wrapped = move |c: usize| if c < n { c } else { c - n };
    let around = coordinates.each(|c| [wrapped(c + n - 1), c, wrapped(c + 1)]);
    let count = 3_usize.pow(D as u32);
    // The middle neighbor is the point itself.
    let others = (0..count).filter(move |neighbor| *neighbor != count / 2);
    others
        .map(move |neighbor| {
            let steps = grid_coordinates::<D>(neighbor, 3);
            if is_inside {
                return index + flat(&steps) - farthest;
            }
            let beside: [usize; D] = array_of(|i| around[i][steps[i]]);
            match flat(&beside) {
                place if place < known => place,
                _ => flat(&beside.each(|c| wrapped(n - c))),
            }
        })
        .filter(move |place| *place < known)
}

/// Largest number of rounds of the refinement of a minimum.
const ROUNDS: usize = 64;

/// Refines a local minimum. Each round takes either a Newton step with finite differences, which is a descent step even at negative curvature, or the
/// best point of the stencil. The steps shrink once the minimum is within the stencil. `at` evaluates several points at a time; `steps` are the
/// initial steps, as columns.
pub(crate) fn settled<const D: usize>(
    at: &impl Fn(&[SVector<f64, D>]) -> Vec<f64>,
    start: (f64, SVector<f64, D>),
    steps: &SMatrix<f64, D, D>,
) -> (f64, SVector<f64, D>) {
    let columns: [SVector<f64, D>; D] = array_of(|i| steps.column(i).into());
    settled_along(at, start, &columns)
}

/// Refines a local minimum within the space spanned by some initial steps.
pub(crate) fn settled_along<const D: usize>(
    at: &impl Fn(&[SVector<f64, D>]) -> Vec<f64>,
    start: (f64, SVector<f64, D>),
    steps: &[SVector<f64, D>],
) -> (f64, SVector<f64, D>) {
    let count = steps.len();
    if count == 0 {
        return start;
    }
    let mut best = start;
    let mut size = 0.5;
    for _ in 0..ROUNDS {
        if size <= 1e-6 {
            break;
        }
        let (before, center) = best;
        // Largest weight of the best point: if it is one, the point lies at the edge of the stencil, and the minimum may be beyond.
        let mut moved = 0.0;
        let mut ask = |places: &[Vec<f64>]| -> Vec<f64> {
            let moved_by = |weights: &Vec<f64>| -> SVector<f64, D> {
                let both = steps.iter().zip(weights);
                both.map(|(step, weight)| step * (weight * size)).sum()
            };
            let points: Vec<SVector<f64, D>> =
                places.iter().map(|own| center + moved_by(own)).collect();
            let values = at(&points);
            for ((weights, k), value) in places.iter().zip(points).zip(&values) {
                if *value < best.0 {
                    best = (*value, k);
                    moved = weights.iter().map(|x| x.abs()).fold(0.0, f64::max);
                }
            }
            values
        };
        let place = |of: &dyn Fn(usize) -> f64| (0..count).map(of).collect::<Vec<f64>>();
        let beside = |n: usize| {
            let side = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
            place(&|j| if j == n / 2 { side } else { 0.0 })
        };
        let beside: Vec<_> = (0..2 * count).map(beside).collect();
        let values = ask(&beside);
        let (mut gradient, mut hessian) = (DVector::zeros(count), DMatrix::zeros(count, count));
        for (i, pair) in values.chunks_exact(2).enumerate() {
            gradient[i] = 0.5 * (pair[0] - pair[1]);
            hessian[(i, i)] = pair[0] + pair[1] - 2.0 * before;
        }
        let pairs: Vec<[usize; 2]> = (0..count)
            .flat_map(|i| (0..i).map(move |j| [i, j]))
            .collect();
        let corner = |[i, j]: [usize; 2], side: f64| {
            place(&|l| match l {
                _ if l == i => 1.0,
                _ if l == j => side,
                _ => 0.0,
            })
        };
        let corners = pairs
            .iter()
            .flat_map(|pair| [1.0, -1.0].map(|side| corner(*pair, side)));
        let values = ask(&corners.collect::<Vec<_>>());
        for ([i, j], ends) in pairs.into_iter().zip(values.chunks_exact(2)) {
            let mixed = 0.5 * (ends[0] - ends[1]) - gradient[j];
            hessian[(i, j)] = mixed;
            hessian[(j, i)] = mixed;
        }
        if let Some(step) = downhill(hessian, &gradient) {
            let bounded = 2.0 / step.amax().max(2.0);
            ask(&[place(&|i| bounded * step[i])]);
        }
        size *= match moved {
            0.0 => 0.25,
            near if near < 1.0 => 0.5,
            _ => 1.0,
        };
    }
    best
}

/// Newton step with the magnitudes of the curvatures, so that it leads along a valley and not up to a ridge.
fn downhill(hessian: DMatrix<f64>, gradient: &DVector<f64>) -> Option<DVector<f64>> {
    let is_finite = hessian.iter().chain(gradient).all(|x| x.is_finite());
    let eigen =
        nalgebra::SymmetricEigen::try_new(is_finite.then_some(hessian)?, f64::EPSILON, 100)?;
    let mut step = DVector::zeros(gradient.len());
    for (curvature, axis) in eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter())
    {
        step -= axis * (axis.dot(gradient) / curvature.abs());
    }
    step.iter().all(|x| x.is_finite()).then_some(step)
}
