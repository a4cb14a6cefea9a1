//! Directions on the sphere: a search for the minimum, and a bound that shows whether it is global.
//!
//! The search descends from the best of some directions. Its result is compared with the bound by null Lagrangians ([`polyconvexity`]), which holds
//! for all directions together and is usually attained. If it is not attained, the sphere is divided into triangles ([`cover`]) until all of them are
//! proved to be above the smallest value, or the budget is exhausted.

mod asymmetric;
mod cover;
mod descent;
mod form;
mod polyconvexity;

pub(super) use asymmetric::fluttering_direction;
pub(crate) use cover::{Cover, cover, exceeds, octants};
pub(crate) use descent::Wave;
pub(crate) use form::Form;
pub(crate) use polyconvexity::bound;

use super::asymmetry;
use crate::algebra::sort_by_value;
use crate::real::Real;
use cover::lower_bound;
use descent::{descended, slowest};
use nalgebra::SMatrix;

/// Vector in three-dimensional space.
pub(crate) type Axes<R> = [R; 3];

/// Largest gap between the smallest value and a bound that counts as closed, in units of the largest component.
const RESOLUTION: f64 = 1e-10;
/// Largest number of triangles on the sphere. If the lowest waves have the same speed along a whole curve of directions, no number suffices: the gap
/// decreases only with the square of the size of the triangles along the curve.
const BUDGET: usize = 4_000;
/// Largest number of covers that may lead to a lower value.
const COVERS: usize = 20;
/// Tolerance for the symmetry of the blocks of a stiffness of magnitude one.
const SYMMETRIC: f64 = 1e-13;
/// Number of directions at which descents start.
const STARTS: usize = 1;

/// Minimum of a stiffness of magnitude one.
pub(super) struct Minimum {
    pub(super) direction: Axes<f64>,
    /// Eigenpair of the symmetric acoustic tensor; `None` without major symmetry, where the eigenvalue may be complex.
    pub(super) eigenpair: Option<(f64, Axes<f64>)>,
    /// Lower bound of the real parts in all directions.
    pub(super) bound: f64,
}

/// Blocks `T_JL` of a stiffness, each with rows `i` and columns `k`.
type Blocks<const D: usize> = [[SMatrix<f64, D, D>; D]; D];

/// Minimum over all directions. The bound and the search for lower values extend only to the level `below`.
pub(super) fn minimum<const D: usize>(blocks: &Blocks<D>, below: f64) -> Minimum {
    let form = symmetric_part(blocks);
    if asymmetry(blocks) > SYMMETRIC {
        return asymmetric::minimum(blocks, &form, below);
    }
    let (wave, bound) = symmetric_minimum(&form, below);
    Minimum {
        direction: wave.direction,
        eigenpair: Some((wave.eigenvalue, wave.polarization)),
        bound,
    }
}

fn symmetric_part<const D: usize>(blocks: &Blocks<D>) -> Form<f64> {
    Form::from_fn(|i, j, k, l| 0.5 * (blocks[j][l][(i, k)] + blocks[j][l][(k, i)]))
}

/// Slowest wave of a form of magnitude one, with a lower bound of all eigenvalues. If no eigenvalue is lower than `below`, the bound is at least that
/// level.
pub(crate) fn symmetric_minimum(form: &Form<f64>, below: f64) -> (Wave, f64) {
    let is_orthotropic = form.is_orthotropic();
    let mut wave = found(form, is_orthotropic);
    let level = |wave: &Wave| (wave.eigenvalue - RESOLUTION).min(below);
    let lower = |wave: Wave, direction: &Axes<f64>| {
        let next = descended(form, slowest(form, direction));
        if next.eigenvalue < wave.eigenvalue - 4.0 * f64::EPSILON {
            next
        } else {
            wave
        }
    };
    let at_once = bound(form, level(&wave) + 0.01 * RESOLUTION);
    let mut bound = at_once.level;
    if bound < level(&wave) {
        wave = lower(wave, &at_once.suggestion);
    }
    for _ in 0..COVERS {
        let level = level(&wave);
        if bound >= level {
            break;
        }
        match cover(octants(is_orthotropic), BUDGET, |triangle| {
            exceeds(form, level, triangle)
        }) {
            Cover::Above => bound = level,
            Cover::Fails(direction) => wave = lower(wave, &direction),
            Cover::Open(triangles) => {
                bound = bound.max(lower_bound(form, &triangles, level));
                break;
            }
        }
    }
    (wave, bound.min(wave.eigenvalue))
}

/// Best wave found by descents from the lowest of evenly spread directions.
fn found(form: &Form<f64>, is_orthotropic: bool) -> Wave {
    let mut starts: Vec<Wave> = spread(is_orthotropic).map(|n| slowest(form, &n)).collect();
    // Values that differ by rounding only keep their order, with the axes first.
    sort_by_value(&mut starts, |start| (start.eigenvalue * 1e14).round());
    let mut best = starts[0];
    for start in starts.into_iter().take(STARTS) {
        let wave = descended(form, start);
        if wave.eigenvalue < best.eigenvalue - 4.0 * f64::EPSILON {
            best = wave;
        }
    }
    best
}

/// Directions over half the sphere, or over one octant if the coordinate planes are mirror planes; the axes first.
fn spread(is_orthotropic: bool) -> impl Iterator<Item = Axes<f64>> {
    const SIDE: i32 = 4;
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let least = if is_orthotropic { 0 } else { -SIDE };
    let between = (least..=SIDE)
        .flat_map(move |i| (least..=SIDE).map(move |j| (i, j, SIDE - i.abs() - j.abs())));
    // Keep one of two opposite directions. The axes are already included.
    let is_kept = |&(i, j, k): &(i32, i32, i32)| {
        (k > 0 || (k == 0 && i > 0)) && [i, j, k].into_iter().filter(|x| *x != 0).count() > 1
    };
    let direction = |(i, j, k): (i32, i32, i32)| [i, j, k].map(f64::from);
    axes.into_iter()
        .chain(between.filter(is_kept).map(direction))
}

pub(crate) fn dot<R: Real>(a: &Axes<R>, b: &Axes<R>) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
