//! Settings of material points without zero-energy modes, tested at the state.

use super::problem::Problem;
use crate::settings::{Family, Velocities};
use onset::kinematics::DeformationGradient;
use onset::verdict::Verdict;
use std::sync::Arc;

/// Sentences on the settings that remove all zero-energy modes at a state; empty for methods with a stabilization, which can be tuned, and if no
/// tested setting succeeds.
///
/// FLIP preserves velocities of points that the grid does not resolve. With a FLIP fraction below one they decay, and the affine transfer removes
/// them. A cell with one point has modes of the grid that this point does not resolve.
pub(super) fn remedy(problem: &Problem, f: &DeformationGradient) -> String {
    let settings = &problem.settings;
    let method = &settings.method;
    if method.method != Family::MaterialPoints {
        return String::new();
    }
    let is_flip = method.transfer == Velocities::Flip;
    let share = "discretization.flip-share=0.99".to_owned();
    let affine = format!("discretization.transfer={}", Velocities::Apic.name());
    let points = "discretization.points-per-side=2".to_owned();
    let is_remedy = |assignments: &[String]| {
        let mut changed = settings.clone();
        assignments.iter().all(|own| changed.assign(own).is_ok())
            && Problem::with_law(changed, Arc::clone(&problem.material))
                .is_ok_and(|own| has_none(&own, f))
    };
    let transfers = [Some(&share).filter(|_| is_flip), Some(&affine)];
    let transfers = transfers.into_iter().flatten().cloned();
    let transfers: Vec<String> = transfers
        .filter(|own| is_remedy(std::slice::from_ref(own)))
        .collect();
    let found = match transfers.is_empty() {
        false => transfers.join(" or "),
        true => {
            let candidates = [vec![points.clone()], vec![affine, points]];
            let found = candidates.into_iter().find(|own| is_remedy(own));
            found.map_or_else(String::new, |own| own.join(" and "))
        }
    };
    let known = match is_flip {
        true => " FLIP codes run with these modes, which the grid does not resolve.",
        false => "",
    };
    match found.as_str() {
        "" => known.to_owned(),
        found => format!(" With {found} no wave has zero energy at this state.{known}"),
    }
}

fn has_none(problem: &Problem, f: &DeformationGradient) -> bool {
    let assessed = problem.analysis.assess(f);
    assessed.is_ok_and(|own| own.verdict != Verdict::ZeroEnergy)
}
