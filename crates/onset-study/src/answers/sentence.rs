//! Sentences that state and explain a verdict.

use super::mode::{critical_mode, finite_wave_vector};
use super::notes::is_unstressed;
use super::problem::Problem;
use super::remedy::remedy;
use super::state::{SpaceAnswer, WeakestModeAnswer, list};
use super::stiffer::band;
use crate::compare::percent;
use crate::number::{told, vector};
use crate::settings::{Family, Units};
use nalgebra::SVector;
use onset::bloch::Stability;
use onset::continuum::{AcousticMinimum, Ellipticity};
use onset::kinematics::DeformationGradient;
use onset::method::Frame;
use onset::verdict::{Assessment, Mechanism, Verdict, ZeroEnergyWave};

/// Squared frequency ratio that is zero to rounding.
const RATIO_ROUNDING: f64 = 1e-9;

/// Sentence for a state whose proof contradicts the search.
pub(super) fn of_correction(
    searched: (Verdict, Stability),
    proved: (Verdict, Stability),
) -> String {
    let words = |(verdict, stability): (Verdict, Stability)| match stability {
        Stability::Flutter => format!("`{}` by flutter", verdict.name()),
        _ => format!("`{}`", verdict.name()),
    };
    format!(
        "The search over the zone says {}, but the proof corrects it: the verdict is {}. Numbers of the discretization below are \
         those of the search.",
        words(searched),
        words(proved)
    )
}

/// Sentence for an assessment. `in_3d` describes the material for waves in all directions; it is `None` for a sheet in plane stress.
pub(super) fn of(
    problem: &Problem,
    assessment: &Assessment<3>,
    in_3d: Option<&SpaceAnswer>,
    weakest: Option<&WeakestModeAnswer>,
    f: &DeformationGradient,
    units: Units,
) -> String {
    let (analysis, settings) = (&*problem.analysis, &problem.settings);
    let family = settings.method.method;
    let along = |direction: &SVector<f64, 3>| vector(&list(analysis.dimension(), direction));
    let spectrum = &assessment.spectrum;
    let mode = critical_mode(assessment);
    let k = analysis.spatial(f, &finite_wave_vector(mode));
    let wave = match mode.is_long_wave || k.norm() > 0.0 {
        true => wave(&k, along, units),
        // This case needs cells with several particles.
        false => "particles of a cell moving relative to each other (k = 0)".to_owned(),
    };
    let is_delayed = settings.material.is_relaxed();
    let growth = growth(spectrum.growth_rate(), is_delayed, units);
    let minimum = &assessment.material.minimum;
    let is_undecided = assessment.material.ellipticity == Ellipticity::Undecided;
    let although = match is_undecided {
        true => "",
        false => " although the material is stable",
    };
    let undecided = match is_undecided {
        true => " The material is undecided: its smallest acoustic eigenvalue is zero to rounding.",
        false => "",
    };
    match assessment.verdict {
        Verdict::Stable => {
            let weak = match weakest {
                Some(answer) if answer.relative_frequency < answer.weak => {
                    let wave = self::wave(&answer.mode.wave_vector, along, units);
                    match answer.mode.relative_frequency_squared < -RATIO_ROUNDING {
                        true => {
                            format!(" In the reference configuration a mode grows, though: {wave}.")
                        }
                        false => format!(
                            " Weakly controlled: in the reference configuration a wave ({wave}) has {} of the frequency of the material's slowest wave, less than {}.",
                            percent(answer.relative_frequency),
                            percent(answer.weak)
                        ),
                    }
                }
                _ => String::new(),
            };
            match assessment.material.ellipticity {
                Ellipticity::Undecided => format!(
                    "Stable: all omega^2 of the discretization are real and nonnegative. The material is undecided: its smallest acoustic eigenvalue is \
                     zero to rounding, as for a fluid, which has no shear stiffness.{weak}"
                ),
                Ellipticity::Lost => format!(
                    "Stable: no plane wave of the material grows{}, and all omega^2 of the discretization are real and nonnegative. The material is not \
                     strongly elliptic, though: g . Q(N) g < 0 for some g and N, which makes no wave grow where the tangent has no major symmetry.{weak}",
                    in_plane(in_3d)
                ),
                Ellipticity::Elliptic => format!(
                    "Stable: the material is strongly elliptic{}, and all omega^2 of the discretization are real and nonnegative.{weak}",
                    in_plane(in_3d)
                ),
            }
        }
        Verdict::Physical => match band(problem, assessment, f) {
            Some(band) => format!(
                "Unstable, as the material is: {}, and {band}, {growth}.",
                lost(minimum)
            ),
            None => format!(
                "Unstable, as the material is: {}, for waves along N = {}, and the discretization follows; fastest mode: {wave}, {growth}.",
                lost(minimum),
                along(&minimum.critical_direction())
            ),
        },
        Verdict::ZeroEnergy => {
            let which = if mode.is_long_wave {
                let direction = analysis.spatial(f, &mode.wave_vector).normalize();
                format!("long waves along {}", along(&direction))
            } else {
                wave
            };
            let vanishes = match family {
                Family::Kernel | Family::FiniteElements => {
                    "strain vanishes at all quadrature points"
                }
                _ => "discrete strain vanishes",
            };
            let is_lagrangian = assessment.gradient_norm.is_some()
                && settings.discretization.frame == Frame::Lagrangian;
            let unseen = if let Some(ZeroEnergyWave::Alternating { count, resisted }) =
                assessment.zero_energy
            {
                let resisted = match resisted {
                    0 => "No force resists these waves",
                    all if all == count => "Only the stress of this state resists these waves",
                    _ => {
                        "The stress of this state resists some of these waves, and no force resists the others"
                    }
                };
                format!(
                    "The {vanishes} where neighbors alternate. {resisted}; the softest other wave: {which}."
                )
            } else if is_lagrangian {
                format!("The {vanishes} for a wave ({which}), at any state.")
            } else if spectrum.softest.scaled > spectrum.tolerance {
                format!(
                    "The {vanishes} for a wave ({which}). Only the stress of this state resists it."
                )
            } else {
                format!("The {vanishes} for a wave ({which}).")
            };
            let remedy = remedy(problem, f);
            format!(
                "Not usable without stabilization{although}: zero-energy modes. {unseen}{undecided}{remedy}"
            )
        }
        Verdict::Numerical => {
            let is_unstressed = is_unstressed(&*problem.material, f);
            let instability = instability(assessment, culprit(family), is_unstressed);
            match minimum.has_growing_waves() {
                true => format!(
                    "Unstable, but not as the material is: {}, while the discretization is stable at \
                     long wavelengths; numerical instability: {instability}, {wave}, {growth}.",
                    lost(minimum)
                ),
                false => format!("Unstable{although}: {instability}, {wave}, {growth}.{undecided}"),
            }
        }
        Verdict::Suppressed => format!(
            "Stable although the material is not: {}, for waves along N = {}, which the discretization suppresses.",
            lost(minimum),
            along(&minimum.critical_direction())
        ),
    }
}

/// Reason why the material is unstable.
fn lost(minimum: &AcousticMinimum<3>) -> &'static str {
    match minimum.only_flutters() {
        true => "its acoustic tensor has complex eigenvalues (flutter)",
        false => "it has lost strong ellipticity",
    }
}

/// Name of a numerical instability: mechanism and origin.
fn instability(assessment: &Assessment<3>, culprit: &str, is_unstressed: bool) -> String {
    let sign = Mechanism::of(
        Stability::Divergence,
        false,
        assessment.material.mean_stress,
    );
    match assessment.mechanism().unwrap_or(sign) {
        Mechanism::Flutter if is_unstressed => format!("flutter of the {culprit} (without stress)"),
        Mechanism::Flutter => format!("flutter of the {culprit} ({} mean stress)", sign.name()),
        Mechanism::Tensile | Mechanism::Compressive if is_unstressed => {
            format!("instability of the {culprit} without stress")
        }
        mechanism => format!("{} instability of the {culprit}", mechanism.name()),
    }
}

/// Origin of a numerical instability.
fn culprit(family: Family) -> &'static str {
    match family {
        Family::Kernel | Family::TotalLagrangianSph | Family::UpdatedSph => "kernel",
        Family::FiniteElements => "elements",
        Family::Peridynamics => "bonds between particles",
        Family::MaterialPoints => "material points on their grid",
        Family::Conforming => "discretization",
    }
}

/// Restriction of a statement on the material if waves out of the plane behave differently.
fn in_plane(in_3d: Option<&SpaceAnswer>) -> &'static str {
    if in_3d.is_some_and(|in_3d| in_3d.flutter.is_some()) {
        return " for in-plane perturbations (others flutter)";
    }
    match in_3d.map(|in_3d| in_3d.growth) {
        None | Some(Ellipticity::Elliptic) => "",
        Some(Ellipticity::Undecided) => {
            " for in-plane perturbations (undecided for out-of-plane ones)"
        }
        Some(Ellipticity::Lost) => " for in-plane perturbations (not for out-of-plane ones)",
    }
}

fn wave(k: &SVector<f64, 3>, along: impl Fn(&SVector<f64, 3>) -> String, units: Units) -> String {
    let norm = k.norm();
    if norm == 0.0 {
        "infinitely long waves".to_owned()
    } else {
        format!(
            "wavelength {} along {}",
            units.of(told(std::f64::consts::TAU / norm), "m"),
            along(&(k / norm))
        )
    }
}

fn growth(rate: f64, is_delayed: bool, units: Units) -> String {
    if rate > 0.0 && is_delayed {
        format!(
            "growth rate {} without the delay by relaxation",
            units.of(told(rate), "1/s")
        )
    } else if rate > 0.0 {
        format!(
            "growth rate {}, e-folding time {}",
            units.of(told(rate), "1/s"),
            units.of(told(1.0 / rate), "s")
        )
    } else {
        "growth rate unbounded as the wavelength tends to zero".to_owned()
    }
}
