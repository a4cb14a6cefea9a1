//! Choices of material points without zero-energy modes, tried at the state.

use super::problem::Problem;
use crate::settings::{Family, Velocities};
use onset::kinematics::DeformationGradient;
use onset::verdict::Verdict;
use std::sync::Arc;

/// Settings that leave no zero-energy modes at a state, as text; `None` for methods with a stabilization, which is tuned, and where nothing that was tried works.
///
/// Velocities of points that the grid does not resolve are kept by FLIP, and removed by the affine transfer; a cell with one point has modes of the grid
/// that this point does not resolve.
pub(super) fn remedy(problem: &Problem, f: &DeformationGradient) -> Option<String> {
    let settings = &problem.settings;
    let method = &settings.method;
    if method.method != Family::MaterialPoints {
        return None;
    }
    let affine = format!("discretization.transfer={}", Velocities::Apic.name());
    let points = "discretization.points-per-side=2".to_owned();
    let candidates = [
        vec![affine.clone()],
        vec![points.clone()],
        vec![affine, points],
    ];
    let is_remedy = |assignments: &&Vec<String>| {
        let mut changed = settings.clone();
        assignments.iter().all(|own| changed.assign(own).is_ok())
            && Problem::with_law(changed, Arc::clone(&problem.material))
                .is_ok_and(|own| has_none(&own, f))
    };
    let found = candidates.iter().find(is_remedy);
    found.map(|assignments| assignments.join(" and "))
}

fn has_none(problem: &Problem, f: &DeformationGradient) -> bool {
    let assessed = problem.analysis.assess(f);
    assessed.is_ok_and(|own| own.verdict != Verdict::ZeroEnergy)
}
