//! Stretches along a loading at which a law is not smooth: steps of the energy, jumps and kinks of the stress.

use super::{LoadingPath, PathEnd, PathState};
use crate::algebra::{Each, sort_by_value};
use crate::material::{FourthOrder, Response};
use nalgebra::Matrix3;
use std::collections::HashMap;

/// Lowest derivative of the energy that jumps: the energy itself, the stress or the tangent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize),
    serde(rename_all = "kebab-case")
)]
pub enum Discontinuity {
    /// The energy itself jumps.
    StepOfEnergy,
    /// The stress jumps: a kink of the energy.
    JumpOfStress,
    /// The tangent jumps: a kink of the stress.
    KinkOfStress,
}

/// Stretch at which the energy, the stress or the tangent jumps. The sign of a jump refers to increasing stretch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kink {
    /// Imposed stretch at the jump.
    pub stretch: f64,
    /// Lowest derivative of the energy that jumps.
    pub kind: Discontinuity,
    /// Norm of the jump of this derivative over all components, relative to the tangent.
    pub jump: f64,
    /// Jump of the energy density. Units of stress.
    pub energy: f64,
    /// Largest component of the jump of the Cauchy stress. Units of stress.
    pub largest_stress: f64,
    /// Jump of the mean Cauchy stress. Units of stress.
    pub mean_stress: f64,
    /// Jump of the second derivative of the energy with respect to `J` at constant isochoric deformation. Units of stress.
    pub bulk_tangent: f64,
    /// Whether the stress drops along the loading: the energy is concave across the kink, so that increments across it do negative work.
    pub is_concave: bool,
    /// Jump of the first Piola-Kirchhoff stress. Units of stress.
    pub(super) first_piola: Matrix3<f64>,
    /// Parameters `ln lambda` of the states on the two sides.
    pub(super) sides: [f64; 2],
}

impl Kink {
    /// Side of the kink that is nearer to the reference configuration, as a parameter `ln lambda`.
    pub(super) fn near_side(&self) -> f64 {
        let [low, high] = self.sides;
        if low.abs() <= high.abs() { low } else { high }
    }
}

/// Smallest reported jumps of energy, stress and tangent, relative to the tangent.
const REPORTED_JUMPS: [f64; 3] = [1e-9, 1e-7, 1e-6];
/// Smoothness test for short intervals: for a smooth quantity the deviation from linearity on half an interval is less than this fraction of the
/// deviation on the whole interval.
const SMOOTH_BEND_RATIO: f64 = 0.6;
/// Smoothness test for short intervals that end in a fold, where a smooth quantity varies as the root of the distance, so that the deviation falls to 0.71 of
/// itself only.
const SMOOTH_BEND_RATIO_AT_FOLD: f64 = 0.8;
/// Number of halvings after which an interval counts as short.
const HALVINGS_UNTIL_SHORT: usize = 4;
/// Final width of the interval around a jump, in `ln lambda`.
const WIDTH: f64 = 1e-12;
/// Step beyond the end of a path, in `ln lambda`.
const STEP_BEYOND_END: f64 = 1e-6;

/// Step beyond a fold, in `ln lambda`, over which a smooth tangent changes by less than the smallest reported jump.
const STEP_BEYOND_FOLD: f64 = 1e-9;

/// Returns the kinks along a loading, at which a law is not smooth, nearest to the reference configuration first.
///
/// Energy, stress `P` and tangent `dP/dF` are examined. Intervals with locally largest third differences are bisected: the half with the larger
/// deviation from linearity is kept. For a smooth quantity this deviation falls to a quarter with each bisection, while it remains constant at a
/// jump. A jump that is small compared with the curvature between two states of the path is overlooked.
///
/// Tension-only fibers, formulas with conditions and tables with corners have kinks. At a kink a law has one-sided wave speeds, and Newton's method
/// can fail. Where the stress jumps, free faces may have no equilibrium; a path that ends for this reason reports the jump at its end.
///
/// ```
/// use onset::criteria::{Discontinuity, Lateral, Loading, LoadingPath, Mode, Range, kinks};
/// use onset::formula::Formula;
/// let law = Formula::parse("10*(I1 - 3 - 2*ln(J)) + 20*(J - 1)^2 + 2*macaulay(J - 1.2)")?.with(&[])?;
/// let loading = Loading { mode: Mode::Hydrostatic, lateral: Lateral::Held };
/// let path = LoadingPath::new(&law, true, loading, &Range::default())?;
/// let [kink] = kinks(&path)[..] else { panic!("one") };
/// assert!(kink.kind == Discontinuity::JumpOfStress && (kink.mean_stress - 2.0).abs() < 1e-9);
/// assert!((kink.stretch.powi(3) - 1.2).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn kinks(path: &LoadingPath<'_>) -> Vec<Kink> {
    path.kinks.get_or_init(|| found(path)).clone()
}

fn found(path: &LoadingPath<'_>) -> Vec<Kink> {
    let compression = path.compression.iter().skip(1).rev();
    let states: Vec<&PathState> = compression.chain(&path.tension).collect();
    let mut found = Vec::new();
    let mut at = once(|s| path.at(s));
    for order in 0..REPORTED_JUMPS.len() {
        for n in suspects(&states, order) {
            let ends = [states[n].clone(), states[n + 1].clone()];
            found.extend(
                narrowed(path, &mut at, order, ends).and_then(|[low, high]| {
                    let sides = [low.parameter, high.parameter];
                    between(&low.response, &high.response, &low.rate, sides)
                }),
            );
        }
    }
    found.extend(at_end(path, &path.tension, &path.tension_end, 1.0));
    found.extend(at_end(path, &path.compression, &path.compression_end, -1.0));
    sort_by_value(&mut found, |kink| kink.stretch);
    found.dedup_by(|a, b| (a.stretch.ln() - b.stretch.ln()).abs() < 1e-9);
    sort_by_value(&mut found, |kink| kink.stretch.ln().abs());
    found
}

/// Components of the energy, the stress or the tangent, with their reference magnitude from the tangent.
fn quantity(response: &Response, order: usize) -> (Vec<f64>, f64) {
    let stiffness = size(&response.tangent);
    let length = response.deformation.matrix().norm();
    match order {
        0 => (vec![response.energy], stiffness * length * length),
        1 => (
            response.first_piola.iter().copied().collect(),
            stiffness * length,
        ),
        _ => {
            let tangent = components().map(|at| response.tangent[at]);
            (tangent.collect(), stiffness)
        }
    }
}

/// Intervals between neighboring states in which a quantity may jump: intervals with locally largest third differences, and the outermost two.
fn suspects(states: &[&PathState], order: usize) -> Vec<usize> {
    let Some(last) = states.len().checked_sub(2) else {
        return Vec::new();
    };
    let values = states.iter().map(|state| quantity(&state.response, order));
    let values: Vec<(Vec<f64>, f64)> = values.collect();
    let place = |n: usize| states[n].parameter;
    let bend = |n: usize| -> Vec<f64> {
        let part = (place(n) - place(n - 1)) / (place(n + 1) - place(n - 1));
        let line = values[n - 1].0.iter().zip(&values[n + 1].0);
        let line = line.map(|(a, b)| a + (b - a) * part);
        values[n].0.iter().zip(line).map(|(x, y)| x - y).collect()
    };
    let bends: Vec<Vec<f64>> = (1..=last).map(bend).collect();
    // Sizes of the third differences; entry n belongs to the interval between the states n + 1 and n + 2.
    let third: Vec<f64> = bends
        .windows(2)
        .map(|two| distance(&two[0], &two[1]))
        .collect();
    let stands_out = |n: usize| {
        let of = |n: usize| third.get(n).copied().unwrap_or(0.0);
        let beside = if n == 0 { 0.0 } else { of(n - 1) } + of(n + 1);
        of(n) >= SMOOTH_BEND_RATIO * beside && of(n) > REPORTED_JUMPS[order] * values[n + 1].1
    };
    let inner = (0..third.len()).filter(|n| stands_out(*n)).map(|n| n + 1);
    let mut all: Vec<usize> = inner.chain([0, last]).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// Narrows the interval between two states to the jump of a quantity; `None` if the quantity is smooth.
fn narrowed(
    path: &LoadingPath<'_>,
    at: &mut impl FnMut(f64) -> Option<PathState>,
    order: usize,
    mut ends: [PathState; 2],
) -> Option<[PathState; 2]> {
    let mut middle = halfway(at, &ends)?;
    let mut whole = bend(&ends, &middle, order);
    let mut halvings = 0;
    let width = path.resolved(WIDTH);
    while ends[1].parameter - ends[0].parameter > width {
        let [low, high] = ends;
        let halves = [[low, middle.clone()], [middle, high]];
        let first = halfway(at, &halves[0])?;
        let second = halfway(at, &halves[1])?;
        let bends = [
            bend(&halves[0], &first, order),
            bend(&halves[1], &second, order),
        ];
        let [low, high] = halves;
        (ends, middle) = match bends[0] > bends[1] {
            true => (low, first),
            false => (high, second),
        };
        let larger = bends[0].max(bends[1]);
        halvings += 1;
        let ratio = match ends.iter().any(|end| path.is_fold(end.parameter)) {
            true => SMOOTH_BEND_RATIO_AT_FOLD,
            false => SMOOTH_BEND_RATIO,
        };
        let is_smooth = halvings > HALVINGS_UNTIL_SHORT && larger < ratio * whole;
        if is_smooth || larger <= 0.25 * REPORTED_JUMPS[order] * quantity(&middle.response, order).1
        {
            return None;
        }
        whole = larger;
    }
    Some(ends)
}

/// State between two others, near their middle. States without a tangent are avoided.
fn halfway(
    at: &mut impl FnMut(f64) -> Option<PathState>,
    ends: &[PathState; 2],
) -> Option<PathState> {
    let [low, high] = ends.each_ref().map(|end| end.parameter);
    let parts = [0.5, 0.4, 0.6].into_iter();
    parts.map(|part| low + (high - low) * part).find_map(at)
}

/// States, each computed once: the searches for jumps of the energy, the stress and the tangent meet in the same places.
fn once(state: impl Fn(f64) -> Option<PathState>) -> impl FnMut(f64) -> Option<PathState> {
    let mut known = HashMap::new();
    move |s: f64| {
        let found = known.entry(s.to_bits()).or_insert_with(|| state(s));
        found.clone()
    }
}

/// Difference between a quantity at an intermediate state and the linear interpolation between its neighbors.
fn bend(ends: &[PathState; 2], middle: &PathState, order: usize) -> f64 {
    let [low, high] = ends.each_ref().map(|end| end.parameter);
    let part = (middle.parameter - low) / (high - low);
    let of = |state: &PathState| quantity(&state.response, order).0;
    let line: Vec<f64> = of(&ends[0])
        .iter()
        .zip(&of(&ends[1]))
        .map(|(a, b)| a + (b - a) * part)
        .collect();
    distance(&of(middle), &line)
}

/// Jump of the stress, step of the energy or, at a fold, kink of the stress, at which a path with free faces ends.
fn at_end(path: &LoadingPath<'_>, states: &[PathState], end: &PathEnd, sense: f64) -> Option<Kink> {
    let (step, kinds): (f64, &[Discontinuity]) = match end {
        _ if path.is_incompressible() => return None,
        PathEnd::NoState { .. } => (
            STEP_BEYOND_END,
            &[Discontinuity::StepOfEnergy, Discontinuity::JumpOfStress],
        ),
        PathEnd::Fold { .. } => (STEP_BEYOND_FOLD, &[Discontinuity::KinkOfStress]),
        _ => return None,
    };
    let last = states.last()?;
    let beyond = last.response.deformation.matrix() + last.rate * (step * sense);
    let mut there = path.respond(&beyond)?;
    let step = beyond - last.response.deformation.matrix();
    // The path ends at the jump itself, so that the tangent beyond it applies to the whole step.
    let along = there.tangent.contracted(&step);
    // What remains of the changes are the jumps. The stress may jump anywhere within the step, so that the work of the step lies between the works of
    // the two stresses.
    there.first_piola -= along;
    let curved = 0.5 * along.dot(&step);
    let works = [&last.response, &there].map(|side| side.first_piola.dot(&step) + curved);
    let risen = there.energy - last.response.energy;
    there.energy -= risen
        .max(works[0].min(works[1]))
        .min(works[0].max(works[1]));
    there.deformation = last.response.deformation;
    let sides = [last.parameter; 2];
    let kink = match sense > 0.0 {
        true => between(&last.response, &there, &last.rate, sides),
        false => between(&there, &last.response, &last.rate, sides),
    };
    kink.filter(|kink| kinds.contains(&kink.kind))
}

/// Jump between two states that are almost equal; `rate` is the rate of the deformation gradient along the loading.
fn between(low: &Response, high: &Response, rate: &Matrix3<f64>, sides: [f64; 2]) -> Option<Kink> {
    let jumps = [0, 1, 2].each(|order: usize| {
        let ((a, scale), (b, other)) = (quantity(low, order), quantity(high, order));
        distance(&a, &b) / scale.max(other)
    });
    let order = (0..3).find(|order| jumps[*order] > REPORTED_JUMPS[*order])?;
    let middle = 0.5 * (sides[0] + sides[1]);
    let stress = high.cauchy() - low.cauchy();
    let first_piola = high.first_piola - low.first_piola;
    Some(Kink {
        stretch: if middle.abs() < WIDTH {
            1.0
        } else {
            middle.exp()
        },
        kind: [
            Discontinuity::StepOfEnergy,
            Discontinuity::JumpOfStress,
            Discontinuity::KinkOfStress,
        ][order],
        jump: jumps[order],
        energy: high.energy - low.energy,
        largest_stress: stress.amax(),
        mean_stress: stress.trace() / 3.0,
        bulk_tangent: bulk_tangent(high) - bulk_tangent(low),
        is_concave: order == 1 && first_piola.dot(rate) < 0.0,
        first_piola,
        sides,
    })
}

/// Bulk tangent `d^2 W / dJ^2 = (F : A : F - 2 P : F) / (9 J^2)` at constant isochoric deformation.
pub(super) fn bulk_tangent(response: &Response) -> f64 {
    let f = response.deformation.matrix();
    let along = components().map(|at @ (i, j, k, l)| f[(i, j)] * response.tangent[at] * f[(k, l)]);
    let jacobian = response.deformation.jacobian();
    (along.sum::<f64>() - 2.0 * response.first_piola.dot(&f)) / (9.0 * jacobian * jacobian)
}

fn components() -> impl Iterator<Item = (usize, usize, usize, usize)> {
    (0..81).map(|n| (n / 27, n / 9 % 3, n / 3 % 3, n % 3))
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b).powi(2));
    squares.sum::<f64>().sqrt()
}

fn size(a: &FourthOrder) -> f64 {
    components().map(|at| a[at].powi(2)).sum::<f64>().sqrt()
}
