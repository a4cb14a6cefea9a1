//! Losses and recoveries of stability along a path of deformations.

use super::Survey;
use super::change::{Knot, Narrowed, narrow};
use super::probe::{Phase, Probe, probe_material};
use crate::algebra::{Each, lowest_between, sort_by_value};
use crate::kinematics::{DeformationGradient, DeformationPath, KinematicsError};
use crate::material::Hyperelastic;
use crate::method::MethodError;
use thiserror::Error;

/// Number of intervals in which a path is sampled. Local minima of the stability measure within an interval are followed even if both ends are in the
/// same phase.
const INTERVALS: usize = 256;
/// Number of halvings of the first and the last interval toward the ends of the path.
const HALVINGS: i32 = 24;
/// Length of the bracket of a crossing, in path parameters.
const CROSSING_BRACKET: f64 = 1e-15;
/// Accuracy of a local minimum, as a fraction of the interval.
const DIP_TOLERANCE: f64 = 1e-7;

/// Change of phase along a path, bracketed by two parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Phase before the crossing.
    pub from: Phase,
    /// Phase after the crossing.
    pub to: Phase,
    /// Last parameter known to be in the phase `from`.
    pub before: f64,
    /// First parameter known to be in the phase `to`.
    pub behind: f64,
}

impl Crossing {
    /// Parameter in the unstable phase, at which the critical mode can be evaluated. If neither phase or both phases are unstable, it is the
    /// parameter `behind`.
    pub fn witness(&self) -> f64 {
        if self.from.is_unstable() && !self.to.is_unstable() {
            self.before
        } else {
            self.behind
        }
    }

    /// Parameter of the crossing: the midpoint of its bracket.
    pub fn parameter(&self) -> f64 {
        0.5 * (self.before + self.behind)
    }
}

/// Phase at the start of a path and all changes of phase along it.
#[derive(Clone, Debug, PartialEq)]
pub struct PathScan {
    /// Phase at the start of the path.
    pub start: Phase,
    /// Crossings by increasing parameter.
    pub crossings: Vec<Crossing>,
}

/// First instability of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Onset {
    /// The path starts in an unstable state.
    AtStart,
    /// Stability is lost at a crossing.
    At(Crossing),
}

impl PathScan {
    /// Phase that begins at an onset: divergence or flutter.
    pub fn phase_behind(&self, onset: &Onset) -> Phase {
        match onset {
            Onset::AtStart => self.start,
            Onset::At(crossing) => crossing.to,
        }
    }

    /// Returns the first instability, or `None` if no state of the path is unstable.
    pub fn onset(&self) -> Option<Onset> {
        if self.start.is_unstable() {
            return Some(Onset::AtStart);
        }
        self.crossings
            .iter()
            .find(|crossing| crossing.to.is_unstable())
            .copied()
            .map(Onset::At)
    }
}

/// Error at a state of a path.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PathError {
    /// The path leaves the set of admissible deformations.
    #[error("the path leaves the admissible deformations at s = {parameter}: {source}")]
    Kinematics {
        /// Path parameter of the state.
        parameter: f64,
        /// Error at this state.
        source: KinematicsError,
    },
    /// The method or the material cannot be evaluated, for a reason other than an undefined state.
    #[error("at s = {parameter}: {source}")]
    Method {
        /// Path parameter of the state.
        parameter: f64,
        /// Error at this state.
        source: MethodError,
    },
}

/// Finds all losses and recoveries of strong ellipticity along a path, for perturbations in `D` dimensions.
///
/// ```
/// use onset::kinematics::{DeformationGradient, StraightPath};
/// use onset::material::ModifiedMooneyRivlin;
/// use onset::verdict::scan_material;
/// let end = DeformationGradient::from_stretches([1.0, 3.0, 1.0])?;
/// let path = StraightPath::new(DeformationGradient::identity(), end)?;
/// let scan = scan_material::<2>(&ModifiedMooneyRivlin::default(), &path)?;
/// assert!((1.0 + 2.0 * scan.crossings[0].parameter() - 2.754613297216).abs() < 1e-10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PathError`] when a state of the path cannot be evaluated.
pub fn scan_material<const D: usize>(
    material: &dyn Hyperelastic,
    path: &dyn DeformationPath,
) -> Result<PathScan, PathError> {
    scan_states(path, |f| Ok(probe_material::<D>(material, f)?))
}

/// Finds all losses and recoveries of stability of a discretization along a path.
///
/// # Errors
/// [`PathError`] when a state cannot be evaluated. States without support are not errors, but [`Phase::Undefined`].
pub fn scan_discretization<const D: usize>(
    survey: &Survey<'_, D>,
    path: &dyn DeformationPath,
) -> Result<PathScan, PathError> {
    scan_states(path, |f| survey.probe(f))
}

fn scan_states(
    path: &dyn DeformationPath,
    probe: impl Fn(&DeformationGradient) -> Result<Probe, MethodError>,
) -> Result<PathScan, PathError> {
    scan(&|s| {
        let f = path.at(s).map_err(|source| PathError::Kinematics {
            parameter: s,
            source,
        })?;
        probe(&f).map_err(|source| PathError::Method {
            parameter: s,
            source,
        })
    })
}

/// Parameters at which a path is sampled.
///
/// They are equidistant, with a geometric refinement toward both ends, because on a long path stability often changes near an end.
fn parameters() -> Vec<f64> {
    let equal = (0..=INTERVALS).map(|n| n as f64 / INTERVALS as f64);
    let near: Vec<f64> = (1..=HALVINGS)
        .map(|n| 0.5_f64.powi(n) / INTERVALS as f64)
        .collect();
    let mut all: Vec<f64> = equal
        .chain(near.iter().copied())
        .chain(near.iter().map(|s| 1.0 - s))
        .collect();
    all.sort_by(f64::total_cmp);
    all
}

fn scan(probe: &impl Fn(f64) -> Result<Probe, PathError>) -> Result<PathScan, PathError> {
    let parameters = parameters();
    let parameter = |n: usize| parameters[n];
    let probes: Vec<Probe> = parameters
        .iter()
        .map(|s| probe(*s))
        .collect::<Result<_, _>>()?;
    let mut knots: Vec<Knot> = parameters.iter().copied().zip(probes.clone()).collect();
    for n in 1..parameters.len() - 1 {
        let [left, middle, right] = [probes[n - 1], probes[n], probes[n + 1]];
        if left.0 == middle.0 && middle.0 == right.0 && middle.0 != Phase::Undefined {
            // In a stable interval the measure can be negative between the samples, and in an unstable one positive. The extremum is located if the
            // slopes on both sides permit a change of sign.
            let sign = if middle.0 == Phase::Unstable {
                -1.0
            } else {
                1.0
            };
            let (down, up) = (sign * (left.1 - middle.1), sign * (right.1 - middle.1));
            if down >= 0.0 && up >= 0.0 && sign * middle.1 <= down.max(up) {
                let around = [n - 1, n, n + 1].each(parameter);
                knots.extend(change_in_dip(probe, middle, sign, around)?);
            }
        }
    }
    sort_by_value(&mut knots, |item| item.0);
    let mut crossings = Vec::new();
    for pair in knots.windows(2) {
        if pair[0].1.0 != pair[1].1.0 {
            refine(probe, pair[0], pair[1], &mut crossings)?;
        }
    }
    Ok(PathScan {
        start: probes[0].0,
        crossings,
    })
}

/// Searches for the minimum of `sign * measure` in an interval. Returns the first parameter whose phase differs from the phase in the middle.
fn change_in_dip(
    probe: &impl Fn(f64) -> Result<Probe, PathError>,
    (own, measure): Probe,
    sign: f64,
    around: [f64; 3],
) -> Result<Option<Knot>, PathError> {
    let at = |s: f64| match probe(s) {
        Ok(found) if found.0 == own => Ok(sign * found.1),
        Ok(found) => Err(Ok((s, found))),
        Err(error) => Err(Err(error)),
    };
    let tolerance = DIP_TOLERANCE * (around[2] - around[0]);
    lowest_between(at, around, sign * measure, tolerance)
        .err()
        .transpose()
}

/// Narrows a change of phase to a bracket of length 1e-15, or to neighboring floating-point parameters. A third phase in between splits the bracket.
fn refine(
    probe: &impl Fn(f64) -> Result<Probe, PathError>,
    before: Knot,
    behind: Knot,
    crossings: &mut Vec<Crossing>,
) -> Result<(), PathError> {
    match narrow(probe, (before, behind), CROSSING_BRACKET)? {
        Narrowed::Change(before, behind) => crossings.push(Crossing {
            from: before.1.0,
            to: behind.1.0,
            before: before.0,
            behind: behind.0,
        }),
        Narrowed::Third(middle) => {
            refine(probe, before, middle, crossings)?;
            refine(probe, middle, behind, crossings)?;
        }
    }
    Ok(())
}
