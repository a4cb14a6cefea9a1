//! Boundaries of stability as curves, found by bisection along straight paths.

use crate::answers::ProblemError;
use onset::analysis::{Analysis, scan_material_in};
use onset::kinematics::{DeformationGradient, StraightPath};
use onset::material::Hyperelastic;
use onset::verdict::{Onset, PathScan};
use rayon::prelude::*;

/// A plane-strain state of principal stretches.
pub fn state(a: f64, b: f64) -> Result<DeformationGradient, ProblemError> {
    Ok(DeformationGradient::from_stretches([a, b, 1.0])?)
}

/// The first onset between two states, as a fraction of the path; `None` when there is none.
pub fn onset(scan: &PathScan) -> Option<f64> {
    scan.onset().map(|onset| match onset {
        Onset::AtStart => 0.0,
        Onset::At(crossing) => crossing.parameter(),
    })
}

/// The boundary of strong ellipticity: for each first stretch, all second stretches between two limits at which
/// ellipticity is lost or regained.
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

/// First onset of the material and of a discretization along a straight path of principal stretches, as the
/// stretch ratio along it.
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
