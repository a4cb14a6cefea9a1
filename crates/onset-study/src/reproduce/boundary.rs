//! Stability boundaries as curves, by bisection along straight paths.

use crate::answers::ProblemError;
use onset::analysis::{Analysis, scan_material_in};
use onset::kinematics::{DeformationGradient, StraightPath};
use onset::material::Hyperelastic;
use onset::verdict::{Onset, PathScan};
use rayon::prelude::*;

/// Plane-strain state with the given principal stretches.
pub fn state(a: f64, b: f64) -> Result<DeformationGradient, ProblemError> {
    Ok(DeformationGradient::from_stretches([a, b, 1.0])?)
}

/// First onset between two states, as a fraction of the path; `None` without an onset.
pub fn onset(scan: &PathScan) -> Option<f64> {
    scan.onset().map(|onset| match onset {
        Onset::AtStart => 0.0,
        Onset::At(crossing) => crossing.parameter(),
    })
}

/// Boundary of strong ellipticity.
///
/// For each first stretch, lists all second stretches between the limits where ellipticity is lost or regained.
pub fn material_boundary(
    material: &dyn Hyperelastic,
    firsts: &[f64],
    (low, high): (f64, f64),
) -> Result<Vec<(f64, f64)>, ProblemError> {
    let along = |&first: &f64| {
        let path = StraightPath::new(state(first, low)?, state(first, high)?)?;
        let scan = scan_material_in(2, material, &path)?;
        let second = |parameter: f64| low + parameter * (high - low);
        Ok(scan
            .crossings
            .iter()
            .map(|crossing| (first, second(crossing.parameter())))
            .collect::<Vec<_>>())
    };
    let lists: Result<Vec<Vec<_>>, ProblemError> = firsts.par_iter().map(along).collect();
    Ok(lists?.into_iter().flatten().collect())
}

/// First onsets of material and discretization along a straight path of principal stretches, as stretch ratios along it.
pub fn onsets(
    method: &dyn Analysis,
    material: &dyn Hyperelastic,
    from: [f64; 2],
    to: [f64; 2],
) -> Result<[Option<f64>; 2], ProblemError> {
    let path = StraightPath::new(state(from[0], from[1])?, state(to[0], to[1])?)?;
    Ok([
        onset(&scan_material_in(2, material, &path)?),
        onset(&method.scan(&path)?),
    ])
}
