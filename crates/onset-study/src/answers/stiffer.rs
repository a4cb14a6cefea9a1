//! Disturbances of a state that are stiffer than its tangent, and the band in which flow localizes.
//!
//! A state that flows is stiffer against disturbances that unload it, and a state that has relaxed is stiffer against fast ones.

use super::finite_body::FiniteBodyAnswer;
use super::mode::{critical_mode, finite_wave_vector};
use super::problem::{Problem, ProblemError};
use super::state::{list, named};
use crate::number::{told, told_with, vector};
use crate::settings::Units;
use nalgebra::{SVector, SymmetricEigen};
use onset::analysis::FiniteBodyOscillations;
use onset::kinematics::DeformationGradient;
use onset::material::Viscoelastic;
use onset::method::MethodError;
use onset::time_step::Integrator;
use onset::verdict::{Assessment, Mechanism, Verdict};
use serde::Serialize;

/// Verdict on a state with the tangent of its stiffer increments.
///
/// These are the increments that unload a state that flows, with the elastic tangent, or the increments of a relaxed state that are faster than
/// relaxation, with the instantaneous tangent. Their waves are faster than the waves of the state itself and limit the time step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StifferAnswer {
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

/// Growth of waves in a state that has relaxed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RelaxationAnswer {
    /// The state for disturbances that are faster than relaxation, with the instantaneous tangent.
    pub fast: StifferAnswer,
    /// Growth rate of the fastest growing wave while the material relaxes; zero if no wave grows, `null` in plane stress with damping or flutter. 1/time.
    pub growth_rate: Option<f64>,
    /// Reference wave vector of the fastest growing wave, zero if no wave grows; 1/length.
    pub wave_vector: Vec<f64>,
    /// Wave vector of the fastest growing wave in the deformed lattice; 1/length.
    pub spatial_wave_vector: Vec<f64>,
}

impl RelaxationAnswer {
    /// Computes the growth with relaxation; `None` unless the state has relaxed.
    pub(super) fn new(
        problem: &Problem,
        disturbed: Option<&StifferAnswer>,
        f: &DeformationGradient,
    ) -> Result<Option<Self>, ProblemError> {
        let law = problem.settings.material.relaxed();
        let Some((law, fast)) = law.map_err(MethodError::from)?.zip(disturbed) else {
            return Ok(None);
        };
        let fastest = match problem.material.dimension() {
            3 => Some(problem.analysis.relaxing(f, &law)?.fastest()),
            _ => growth_of_sheet(problem, &law, f)?,
        };
        let k = fastest.as_ref().map_or(&[][..], |(_, k)| k);
        let k = SVector::from_fn(|i, _| k.get(i).copied().unwrap_or(0.0));
        Ok(Some(Self {
            fast: fast.clone(),
            growth_rate: fastest.map(|(rate, _)| rate),
            wave_vector: list(problem.dimension(), &k),
            spatial_wave_vector: list(problem.dimension(), &problem.analysis.spatial(f, &k)),
        }))
    }

    /// Text of the answer in one line.
    pub(super) fn words(&self, units: Units) -> String {
        let growth = match self.growth_rate {
            Some(rate) if rate > 0.0 => {
                let grows = match self.fast.growth_rate > 0.0 {
                    true => "grows",
                    false => "grows only as stress relaxes",
                };
                format!(
                    "; a wave {grows}, at the rate {}, k = {}",
                    units.of(told(rate), "1/s"),
                    units.of(vector(&self.wave_vector), "1/m")
                )
            }
            _ => String::new(),
        };
        format!("before relaxation {}{growth}", self.fast.words(units))
    }
}

/// Relative accuracy of the growth rate of a sheet, and number of decades below the rate of the relaxed state in which it is searched for.
const RATE_ACCURACY: f64 = 1e-7;
const DECADES: i32 = 24;

/// Growth rate of the fastest wave of a sheet or bar while the material relaxes, with its wave vector; `None` with damping or flutter.
///
/// The thickness follows the disturbance, so that the tangent is not a sum over the terms of the series. The rate is the root of
/// `s^2 + omega^2(s) = 0`, where `omega^2(s)` is the lowest value over the zone for the tangent of disturbances `exp(s t)`, which increases with `s`.
fn growth_of_sheet(
    problem: &Problem,
    law: &Viscoelastic,
    f: &DeformationGradient,
) -> Result<Option<(f64, Vec<f64>)>, ProblemError> {
    let settings = &problem.settings;
    let assessed = |rate: f64| {
        let parts = law.terms().iter().fold([0.0; 2], |sums, term| {
            let lag = rate * term.time / (1.0 + rate * term.time);
            [sums[0] + term.shear * lag, sums[1] + term.bulk * lag]
        });
        let own = settings
            .material
            .in_dimension(law.disturbed(parts), settings.dimension());
        let own = Problem::with_law(settings.clone(), own.map_err(MethodError::from)?)?;
        Ok::<_, ProblemError>(own.analysis.assess(f)?.spectrum)
    };
    let at_rest = assessed(0.0)?;
    if problem.analysis.is_damped() || at_rest.flutters {
        return Ok(None);
    }
    let elastic = at_rest.growth_rate();
    if elastic == 0.0 {
        return Ok(Some((0.0, Vec::new())));
    }
    let residual = |rate: f64| {
        let spectrum = assessed(rate)?;
        let (lowest, softest) = (spectrum.lowest, spectrum.softest);
        let mode = match softest.omega_squared.re < lowest.omega_squared.re {
            true => softest,
            false => lowest,
        };
        let omega_squared = match mode.omega_squared.re < 0.0 {
            true => mode.omega_squared.re,
            // A pocket of long waves that the search does not resolve: dispersion limits their growth to about this rate.
            false if !spectrum.is_stable() => -(softest.scaled * spectrum.maximum_omega).powi(2),
            false => 0.0,
        };
        Ok::<_, ProblemError>((rate * rate + omega_squared, mode))
    };
    // The rate of the relaxed state bounds the rate, unless overstress has a negative stiffness.
    let mut high = elastic;
    while residual(high)?.0 < 0.0 && high.is_finite() {
        high *= 2.0;
    }
    let mut found = None;
    for _ in 0..DECADES {
        let low = 0.1 * high;
        let (value, mode) = residual(low)?;
        if value < 0.0 {
            found = Some((low, mode));
            break;
        }
        high = low;
    }
    let Some((mut low, mut mode)) = found else {
        return Ok(Some((0.0, Vec::new())));
    };
    // Bisection: the value is small above the root and may be large below it.
    while high - low > RATE_ACCURACY * high {
        let middle = 0.5 * (low + high);
        let (value, own) = residual(middle)?;
        match value < 0.0 {
            true => (low, mode) = (middle, own),
            false => high = middle,
        }
    }
    let k = finite_wave_vector(&mode);
    Ok(Some((low, k.iter().copied().collect())))
}

impl StifferAnswer {
    /// Answer for the stiffer increments of a state, from its assessment with their tangent.
    pub(super) fn new(
        problem: &Problem,
        assessment: &Assessment<3>,
        bodies: Option<&FiniteBodyOscillations>,
    ) -> Self {
        let spectrum = &assessment.spectrum;
        let step = Some(spectrum.critical_time_step()).filter(|step| step.is_finite());
        Self {
            verdict: assessment.verdict,
            mechanism: assessment.mechanism(),
            growth_rate: spectrum.growth_rate(),
            maximum_omega: spectrum.maximum_omega,
            critical_time_step: step,
            finite_bodies: bodies.and_then(|bodies| {
                FiniteBodyAnswer::new(problem, bodies, Integrator::CentralDifferences, step)
            }),
        }
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
        format!("{verdict}{growth}")
    }
}

/// Returns true if flow localizes at a state: the material of a law that flows is unstable.
pub(super) fn localizes(problem: &Problem, assessment: &Assessment<3>) -> bool {
    assessment.verdict == Verdict::Physical && problem.settings.material.model.yields()
}

/// Band in which flow localizes at a state: the part of the sentence after the loss of ellipticity; `None` if it does not localize.
pub(super) fn band(
    problem: &Problem,
    assessment: &Assessment<3>,
    f: &DeformationGradient,
) -> Option<String> {
    if !localizes(problem, assessment) {
        return None;
    }
    let material = &assessment.material;
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
                "the fastest growing wave has a wavelength of {} spacings, here {}",
                told_with(length / spacing, 3),
                units.of(told(length), "m"),
            )
        }
        false => "no wave grows fastest".to_owned(),
    };
    Some(format!(
        "flow localizes into bands with the normal {}, {} degrees from the axis of the largest principal stress. The law has no length, so the spacing \
         sets the width of the bands, and results do not converge under refinement: {width}",
        vector(&list(problem.dimension(), &normal)),
        told((angle * 10.0).round() / 10.0)
    ))
}

/// Note on what sets the width of bands of localized flow.
pub(super) const WIDTH_OF_BANDS: &str = "a law with a length (nonlocal or gradient), viscosity or a fixed nonlocal horizon would set the width of the bands";
