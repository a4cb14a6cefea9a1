//! Directions on the sphere: a search for the minimum, and a bound that shows whether it is the global one.
//!
//! The search goes down from the best of some directions. What it finds is compared with the bound by null Lagrangians
//! ([`polyconvexity`]), which holds for all directions at once and is usually attained. Where it is not, the sphere is
//! divided into triangles ([`cover`]) until all of them are above the value found, or the budget is exhausted.

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

/// A vector in space.
pub(crate) type Axes<R> = [R; 3];

/// How far below the value found a bound counts as the same, in units of the largest component.
const RESOLUTION: f64 = 1e-10;
/// Triangles of the sphere at most. Where the lowest waves have one speed along a whole curve of directions no number is enough: the bound stays below the value by the
/// square of the size of the triangles along the curve.
const BUDGET: usize = 4_000;
/// Covers that may find something lower.
const COVERS: usize = 20;
/// Blocks of a stiffness of magnitude one that differ by no more than this from symmetric ones are symmetric.
const SYMMETRIC: f64 = 1e-13;
/// Directions to go down from.
const STARTS: usize = 1;

/// The minimum of a stiffness of magnitude one.
pub(super) struct Minimum {
    pub(super) direction: Axes<f64>,
    /// Of the symmetric acoustic tensor; without major symmetry the eigenvalue may be complex.
    pub(super) eigenpair: Option<(f64, Axes<f64>)>,
    /// No direction has a smaller real part.
    pub(super) bound: f64,
}

/// The blocks `T_JL` of a stiffness, each with rows `i` and columns `k`.
type Blocks<const D: usize> = [[SMatrix<f64, D, D>; D]; D];

/// The minimum over all directions. That nothing is lower than it is shown, and looked for, below a level only.
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

/// The direction of the lowest real part that is found by going down from some directions, without a bound.
pub(super) fn descended_direction<const D: usize>(blocks: &Blocks<D>) -> Axes<f64> {
    if asymmetry(blocks) > SYMMETRIC {
        return asymmetric::descended_direction(blocks);
    }
    let form = symmetric_part(blocks);
    found(&form, form.is_orthotropic()).direction
}

fn symmetric_part<const D: usize>(blocks: &Blocks<D>) -> Form<f64> {
    Form::from_fn(|i, j, k, l| 0.5 * (blocks[j][l][(i, k)] + blocks[j][l][(k, i)]))
}

/// The slowest wave of a form of magnitude one, and a lower bound of all eigenvalues, at least the level below which it is asked for
/// where none is lower.
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

/// The best that is found by going down from the lowest of evenly spread directions.
fn found(form: &Form<f64>, is_orthotropic: bool) -> Wave {
    let mut starts: Vec<Wave> = spread(is_orthotropic).map(|n| slowest(form, &n)).collect();
    // What differs by rounding only stays in order: the axes first.
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

/// Directions over half the sphere, or where the coordinate planes are mirrors over one octant; the axes first.
fn spread(is_orthotropic: bool) -> impl Iterator<Item = Axes<f64>> {
    const SIDE: i32 = 4;
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let least = if is_orthotropic { 0 } else { -SIDE };
    let between = (least..=SIDE)
        .flat_map(move |i| (least..=SIDE).map(move |j| (i, j, SIDE - i.abs() - j.abs())));
    // Of opposite directions one; the axes are there already.
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
