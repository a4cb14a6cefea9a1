//! Where stability is lost, and regained, along a path of deformations.

use super::Survey;
use super::change::{Knot, Narrowed, narrow};
use super::probe::{Phase, Probe, probe_material};
use crate::algebra::{Each, lowest_between, sort_by_value};
use crate::kinematics::{DeformationGradient, DeformationPath, KinematicsError};
use crate::material::Hyperelastic;
use crate::method::MethodError;
use thiserror::Error;

/// Intervals in which a path is first looked at. Within an interval, dips of the stability measure that
/// do not change its sign at the ends are followed too.
const INTERVALS: usize = 256;
/// How often the first and the last interval are halved towards their ends.
const HALVINGS: i32 = 24;
/// How near to each other the parameters on both sides of a crossing are.
const CLOSE: f64 = 1e-15;
/// How near to the bottom of a dip is sought, in parts of the interval.
const DIP: f64 = 1e-7;

/// A change of phase between two parameters of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Phase before.
    pub from: Phase,
    /// Phase behind.
    pub to: Phase,
    /// The last parameter known to be in the phase `from`.
    pub before: f64,
    /// The first parameter known to be in the phase `to`.
    pub behind: f64,
}

impl Crossing {
    /// A parameter that lies in the unstable phase (or else behind the crossing), at which the critical mode
    /// can be evaluated.
    pub fn witness(&self) -> f64 {
        if self.from.is_unstable() && !self.to.is_unstable() {
            self.before
        } else {
            self.behind
        }
    }

    /// The parameter of the crossing, the middle of its bracket.
    pub fn parameter(&self) -> f64 {
        0.5 * (self.before + self.behind)
    }
}

/// All changes of phase along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct PathScan {
    /// Phase at the start.
    pub start: Phase,
    /// Crossings by increasing parameter.
    pub crossings: Vec<Crossing>,
}

/// The first instability of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Onset {
    /// The start is unstable already.
    AtStart,
    /// At a crossing.
    At(Crossing),
}

impl PathScan {
    /// The phase behind an onset: how it is unstable.
    pub fn phase_behind(&self, onset: &Onset) -> Phase {
        match onset {
            Onset::AtStart => self.start,
            Onset::At(crossing) => crossing.to,
        }
    }

    /// The first instability, if there is one.
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

/// Why a path cannot be followed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PathError {
    /// It leaves the admissible deformations.
    #[error("the path leaves the admissible deformations at s = {parameter}: {source}")]
    Kinematics {
        /// The parameter.
        parameter: f64,
        /// What is wrong there.
        source: KinematicsError,
    },
    /// The method or the material fails there for a reason that is no change of stability.
    #[error("at s = {parameter}: {source}")]
    Method {
        /// The parameter.
        parameter: f64,
        /// What is wrong there.
        source: MethodError,
    },
}

/// All losses and returns of strong ellipticity along a path, for perturbations in `D` dimensions.
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

/// All losses and returns of the stability of a discretization along a path.
///
/// # Errors
/// [`PathError`] when a state cannot be evaluated for another reason than its support.
pub fn scan_discretization<const D: usize>(
    survey: &Survey<'_, D>,
    path: &dyn DeformationPath,
) -> Result<PathScan, PathError> {
    scan_states(path, |f| survey.probe(f))
}

/// All changes of phase along a path, from the answers to its states.
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

/// Where a path is first looked at: at equal distances, and between the first two and the last two of them
/// ever nearer to the ends, since on a long path the change of stability is often near an end.
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
            // A stable stretch can dip below zero between the knots, an unstable one rise above.
            // It is followed when its bottom can be that far below the middle, by the slopes beside it.
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

/// A parameter with another phase than that in the middle of an interval, met on the way to where `sign * measure` is smallest.
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
    let tolerance = DIP * (around[2] - around[0]);
    lowest_between(at, around, sign * measure, tolerance)
        .err()
        .transpose()
}

/// Down to neighboring floating-point parameters, or 1e-15 apart. A third phase met on the way splits the bracket.
fn refine(
    probe: &impl Fn(f64) -> Result<Probe, PathError>,
    before: Knot,
    behind: Knot,
    crossings: &mut Vec<Crossing>,
) -> Result<(), PathError> {
    match narrow(probe, (before, behind), CLOSE)? {
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
