//! Fidelity of a discretization: agreement of its stability boundary with the material's.

use crate::answers::ProblemError;
use crate::number::{told, vector};
use crate::settings::{Quantity, Study};
use nalgebra::Matrix3;
use onset::cancel::Scope;
use onset::verdict::boundary::{Boundary, Window};
use onset::verdict::fidelity::{Areas, RayOnset, areas, directed_distance, onset_along};
use onset::verdict::{Phase, Probe};
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::TAU;

/// Number of rays from the reference state.
const RAYS: usize = 360;

/// Probe that returns the phase and the measure of a state.
pub(super) type Ask<'a> = &'a (dyn Fn([f64; 2]) -> Result<Probe, ProblemError> + Sync);

/// Fidelity of a discretization over the window of a study.
#[derive(Clone, Debug, Serialize)]
pub struct Fidelity {
    /// Area of the window; all areas are in the product of the units of its axes.
    pub window_area: f64,
    /// Area of the window where the material is strongly elliptic, in the units of its axes.
    pub elliptic_area: f64,
    /// Area where the material is elliptic and the particles are unstable, in the units of the axes.
    pub false_instability_area: f64,
    /// False-instability area as a fraction of the elliptic area; `null` without an elliptic area.
    pub false_instability_share: Option<f64>,
    /// Area where the material is not elliptic and the particles are stable, in the units of the axes.
    pub suppressed_instability_area: f64,
    /// Suppressed-instability area as a fraction of the elliptic area; `null` without an elliptic area.
    pub suppressed_instability_share: Option<f64>,
    /// Area where the discretization is undefined, in the units of the axes.
    pub undefined_area: f64,
    /// Distance between the two boundaries; `null` if either is missing.
    pub hausdorff: Option<Apart>,
    /// Onsets along rays from the reference state; `null` unless the axes are the two stretches and the window contains that state.
    pub rays: Option<Rays>,
}

/// Distance between two boundaries.
#[derive(Clone, Debug, Serialize)]
pub struct Apart {
    /// Hausdorff distance: the larger of the two one-sided distances.
    pub distance: f64,
    /// Largest distance of a point on the material's boundary from the boundary of the discretization.
    pub from_material: f64,
    /// Point on the material's boundary that is farthest from the boundary of the discretization.
    pub from_material_at: [f64; 2],
    /// Largest distance of a point on the boundary of the discretization from the material's boundary.
    pub from_discretization: f64,
    /// Point on the boundary of the discretization that is farthest from the material's boundary.
    pub from_discretization_at: [f64; 2],
    /// Unit of the distances.
    ///
    /// `axes` for the coordinates of the axes; `window` for fractions of the window, if the units of the axes differ.
    pub unit: &'static str,
}

/// Onsets along straight rays of stretches from the reference state.
#[derive(Clone, Debug, Serialize)]
pub struct Rays {
    /// Number of rays, at equal angles.
    pub count: usize,
    /// Number of rays along which both lose stability within the window.
    pub both: usize,
    /// Number of rays along which only the material loses stability.
    pub only_material: usize,
    /// Number of rays along which only the particles lose stability.
    pub only_discretization: usize,
    /// Number of rays along which the discretization becomes undefined before it loses stability.
    pub undefined: usize,
    /// Ray with the largest distance of the onsets, `[sum (lambda_i^num - lambda_i^exact)^2]^(1/2)`, relative to the exact stretch. `null` if no ray has both onsets.
    pub worst: Option<WorstRay>,
    /// Ray with the largest error of the Cauchy stress at onset, relative to the exact stress. `null` if no ray has both onsets.
    pub worst_stress: Option<WorstStress>,
}

/// Ray with the largest distance of onsets.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct WorstRay {
    /// Stretches at the onset of the material.
    pub material: [f64; 2],
    /// Stretches at the onset of the particles.
    pub discretization: [f64; 2],
    /// Distance between the two onsets.
    pub error: f64,
    /// Distance divided by the norm of the stretches at the material's onset.
    pub relative: f64,
}

/// Ray with the largest error of stress.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct WorstStress {
    /// Stretches at the onset of the material.
    pub material: [f64; 2],
    /// Stretches at the onset of the particles.
    pub discretization: [f64; 2],
    /// Frobenius norm of the difference of the Cauchy stresses; stress.
    pub error: f64,
    /// Error divided by the norm of the stress at the material's onset.
    pub relative: f64,
}

/// Traced boundaries of a study.
pub(super) struct Traced<'a> {
    pub(super) study: &'a Study,
    pub(super) window: Window,
    pub(super) boundaries: [&'a Boundary; 2],
}

impl Fidelity {
    pub(super) fn of(
        traced: &Traced<'_>,
        probes: [Ask<'_>; 2],
        cauchy: &(dyn Fn([f64; 2]) -> Result<Matrix3<f64>, ProblemError> + Sync),
    ) -> Result<Self, ProblemError> {
        let phases = |at: [f64; 2]| -> Result<[Phase; 2], ProblemError> {
            Ok([probes[0](at)?.0, probes[1](at)?.0])
        };
        let areas: Areas = areas(traced.window, traced.boundaries, &phases)?;
        let share = |share: f64| (areas.elliptic > 0.0).then_some(share);
        Ok(Self {
            window_area: areas.window,
            elliptic_area: areas.elliptic,
            false_instability_area: areas.false_instability,
            false_instability_share: share(areas.false_share()),
            suppressed_instability_area: areas.suppressed_instability,
            suppressed_instability_share: share(areas.suppressed_share()),
            undefined_area: areas.undefined,
            hausdorff: apart(traced),
            rays: rays(traced, probes, cauchy)?,
        })
    }
}

fn apart(traced: &Traced<'_>) -> Option<Apart> {
    let [first, second] = traced.study.plane();
    let is_common = first.unit() == second.unit();
    let size = if is_common {
        [1.0; 2]
    } else {
        traced.window.size()
    };
    let lines = |boundary: &Boundary| -> Vec<Vec<[f64; 2]>> {
        let scaled = |point: [f64; 2]| [point[0] / size[0], point[1] / size[1]];
        let curves = boundary.of_stability();
        curves
            .map(|curve| curve.points().map(scaled).collect())
            .collect()
    };
    let [material, particles] = traced.boundaries.map(lines);
    let extent = if is_common {
        let [width, height] = traced.window.size();
        width.max(height)
    } else {
        1.0
    };
    let there = directed_distance(&material, &particles, 1e-9 * extent)?;
    let back = directed_distance(&particles, &material, 1e-9 * extent)?;
    let place = |at: [f64; 2]| [at[0] * size[0], at[1] * size[1]];
    Some(Apart {
        distance: there.distance.max(back.distance),
        from_material: there.distance,
        from_material_at: place(there.at),
        from_discretization: back.distance,
        from_discretization_at: place(back.at),
        unit: if is_common { "axes" } else { "window" },
    })
}

/// Returns true if the axes are the two stretches and the window contains the reference state.
fn has_rays(traced: &Traced<'_>) -> bool {
    let [first, second] = traced.study.plane();
    let names = [first.quantity, second.quantity];
    let holds = |range: (f64, f64)| (range.0..=range.1).contains(&1.0);
    let stretches = [Quantity::Stretch(1), Quantity::Stretch(2)];
    let is_plane = names == stretches || names == [stretches[1], stretches[0]];
    is_plane
        && traced.study.state.stretches[2] == 1.0
        && traced.study.state.shear == 0.0
        && holds(first.range)
        && holds(second.range)
}

fn rays(
    traced: &Traced<'_>,
    probes: [Ask<'_>; 2],
    cauchy: &(dyn Fn([f64; 2]) -> Result<Matrix3<f64>, ProblemError> + Sync),
) -> Result<Option<Rays>, ProblemError> {
    if !has_rays(traced) {
        return Ok(None);
    }
    let along = |n: usize| -> Result<([f64; 2], [RayOnset; 2]), ProblemError> {
        // Angles are offset by half a step, so that no ray follows the edge of the window.
        let (sine, cosine) = (TAU * (n as f64 + 0.5) / RAYS as f64).sin_cos();
        let ray = ([1.0, 1.0], [cosine, sine]);
        let onset = |of: usize| onset_along(traced.window, traced.boundaries[of], probes[of], ray);
        Ok(([cosine, sine], [onset(0)?, onset(1)?]))
    };
    let scope = Scope::current();
    let onsets: Vec<([f64; 2], [RayOnset; 2])> = (0..RAYS)
        .into_par_iter()
        .map(|n| scope.run(|| along(n)))
        .collect::<Result<_, _>>()?;
    let mut rays = Rays {
        count: RAYS,
        both: 0,
        only_material: 0,
        only_discretization: 0,
        undefined: 0,
        worst: None,
        worst_stress: None,
    };
    for (direction, found) in onsets {
        let at = |s: f64| [1.0 + s * direction[0], 1.0 + s * direction[1]];
        let lost = found.map(|onset| match onset {
            RayOnset::AtStart => Some(0.0),
            RayOnset::At(s) => Some(s),
            RayOnset::Undefined(_) | RayOnset::None => None,
        });
        rays.undefined += usize::from(matches!(found[1], RayOnset::Undefined(_)));
        match lost {
            [Some(exact), Some(computed)] => {
                rays.both += 1;
                rays.compare(at(exact), at(computed), cauchy)?;
            }
            [Some(_), None] => rays.only_material += 1,
            [None, Some(_)] => rays.only_discretization += 1,
            [None, None] => {}
        }
    }
    Ok(Some(rays))
}

impl Rays {
    fn compare(
        &mut self,
        material: [f64; 2],
        discretization: [f64; 2],
        cauchy: &(dyn Fn([f64; 2]) -> Result<Matrix3<f64>, ProblemError> + Sync),
    ) -> Result<(), ProblemError> {
        let error = (material[0] - discretization[0]).hypot(material[1] - discretization[1]);
        let relative = error / material[0].hypot(material[1]);
        if self.worst.is_none_or(|worst| relative > worst.relative) {
            self.worst = Some(WorstRay {
                material,
                discretization,
                error,
                relative,
            });
        }
        let (exact, computed) = (cauchy(material)?, cauchy(discretization)?);
        let error = (computed - exact).norm();
        let relative = error / exact.norm();
        if self
            .worst_stress
            .is_none_or(|worst| relative > worst.relative)
        {
            self.worst_stress = Some(WorstStress {
                material,
                discretization,
                error,
                relative,
            });
        }
        Ok(())
    }
}

fn percent(share: Option<f64>) -> String {
    share.map_or_else(
        || "no elliptic area".to_owned(),
        |share| format!("{:.3} % of the elliptic area", 100.0 * share),
    )
}

impl std::fmt::Display for Fidelity {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(
            formatter,
            "False instability: area {} ({}). Suppressed instability: area {} ({}).",
            told(self.false_instability_area),
            percent(self.false_instability_share),
            told(self.suppressed_instability_area),
            percent(self.suppressed_instability_share),
        )?;
        if self.undefined_area > 0.0 {
            writeln!(
                formatter,
                "The discretization is undefined on {:.3} % of the window.",
                100.0 * self.undefined_area / self.window_area
            )?;
        }
        if let Some(apart) = &self.hausdorff {
            writeln!(
                formatter,
                "Hausdorff distance of the boundaries: {}{} (from the material {}, from the discretization {}).",
                told(apart.distance),
                if apart.unit == "window" {
                    " of the window"
                } else {
                    ""
                },
                told(apart.from_material),
                told(apart.from_discretization),
            )?;
        }
        let Some(rays) = &self.rays else {
            return Ok(());
        };
        if let (Some(worst), Some(stress)) = (&rays.worst, &rays.worst_stress) {
            writeln!(
                formatter,
                "Along {} of {} rays from the reference state both lose stability: stretches at the onset differ by at most {} % \
                 ({} instead of {}), Cauchy stresses by at most {} %.",
                rays.both,
                rays.count,
                told(100.0 * worst.relative),
                vector(&worst.discretization),
                vector(&worst.material),
                told(100.0 * stress.relative),
            )?;
        }
        if rays.only_material + rays.only_discretization > 0 {
            writeln!(
                formatter,
                "Along {} rays only the material loses stability within the window, along {} only the discretization.",
                rays.only_material, rays.only_discretization
            )?;
        }
        Ok(())
    }
}
