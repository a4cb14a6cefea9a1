//! A state that flows, for disturbances that unload it, and the band in which flow localizes.

use super::finite_body::FiniteBodyAnswer;
use super::mode::{critical_mode, finite_wave_vector};
use super::problem::{Problem, ProblemError};
use super::state::{list, named};
use crate::number::{told, told_below, vector};
use crate::settings::Units;
use nalgebra::{SVector, SymmetricEigen};
use onset::kinematics::DeformationGradient;
use onset::verdict::{Assessment, Mechanism, Verdict};
use serde::Serialize;

/// Verdict on a state that flows, with the elastic tangent of increments that unload it.
///
/// The verdict of the state itself has the tangent of loading that continues. Unloading is stiffer, so its waves are faster and limit the time step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UnloadingAnswer {
    /// The origin of the first instability.
    pub verdict: Verdict,
    /// The mechanism of a numerical instability; `null` for other verdicts.
    pub mechanism: Option<Mechanism>,
    /// Growth rate of the fastest growing mode; zero when stable. 1/time.
    pub growth_rate: f64,
    /// Largest frequency over the zone; rad/time.
    pub maximum_omega: f64,
    /// Critical time step of undamped central differences; `null` if no mode oscillates.
    pub critical_time_step: Option<f64>,
    /// Time step for finite bodies; `null` if it is unknown.
    pub finite_bodies: Option<FiniteBodyAnswer>,
}

impl UnloadingAnswer {
    /// Assesses the state; `None` if it does not flow.
    pub(super) fn new(
        problem: &Problem,
        f: &DeformationGradient,
    ) -> Result<Option<Self>, ProblemError> {
        if !problem.unloads(f)? {
            return Ok(None);
        }
        let problem = problem.unloading()?;
        let assessment = problem.analysis.assess(f)?;
        let spectrum = &assessment.spectrum;
        let step = Some(spectrum.critical_time_step()).filter(|step| step.is_finite());
        Ok(Some(Self {
            verdict: assessment.verdict,
            mechanism: assessment.mechanism(),
            growth_rate: spectrum.growth_rate(),
            maximum_omega: spectrum.maximum_omega,
            critical_time_step: step,
            finite_bodies: FiniteBodyAnswer::new(&problem, f, step)?,
        }))
    }

    /// Text of the answer in one line.
    pub(super) fn words(&self, units: Units) -> String {
        let verdict = named(self.verdict, self.mechanism);
        let growth = match self.growth_rate > 0.0 {
            true => {
                let rate = told(self.growth_rate);
                format!(", growth rate {}", units.of(rate, "1/s"))
            }
            false => String::new(),
        };
        let time = |step: f64| units.of(told_below(step), "s");
        let steps = [
            self.critical_time_step
                .map(|step| format!("{} (central differences, infinite lattice)", time(step))),
            self.finite_bodies
                .as_ref()
                .map(|body| format!("{} (finite bodies)", time(body.time_step))),
        ];
        let steps: Vec<String> = steps.into_iter().flatten().collect();
        let steps = match steps.is_empty() {
            true => String::new(),
            false => format!("; time step below {}", steps.join(", ")),
        };
        format!("{verdict}{growth}{steps}")
    }
}

/// Note on the band in which a law that yields localizes; `None` for other laws and verdicts.
pub(super) fn band(
    problem: &Problem,
    assessment: &Assessment<3>,
    f: &DeformationGradient,
) -> Option<String> {
    let material = &assessment.material;
    if assessment.verdict != Verdict::Physical || !problem.settings.material.model.yields() {
        return None;
    }
    let units = problem.settings.units();
    // Normals transform with F^-T.
    let direction = material.minimum.critical_direction();
    let inverse = f.matrix().try_inverse()?;
    let normal: SVector<f64, 3> = (inverse.transpose() * direction).normalize();
    let stress = SymmetricEigen::new(material.response.cauchy());
    let largest = stress.eigenvectors.column(stress.eigenvalues.imax());
    let angle = normal.dot(&largest).abs().min(1.0).acos().to_degrees();
    let mode = critical_mode(assessment);
    let k = problem
        .analysis
        .spatial(f, &finite_wave_vector(mode))
        .norm();
    let width = match k > 0.0 {
        true => {
            let length = std::f64::consts::TAU / k;
            let spacing = problem.settings.discretization.spacing;
            format!(
                "here the fastest wave has the length {}, {} spacings, for any spacing",
                units.of(told(length), "m"),
                told(length / spacing)
            )
        }
        false => "here no wave is the fastest".to_owned(),
    };
    Some(format!(
        "flow localizes into a band with the normal {}, {} degrees from the axis of the largest principal stress; the law has no length, so that the \
         width of the band is that of the method and no refinement converges: {width}; a law with a length (nonlocal or gradient), viscosity or a fixed \
         nonlocal horizon sets a width",
        vector(&list(problem.dimension(), &normal)),
        told((angle * 10.0).round() / 10.0)
    ))
}
