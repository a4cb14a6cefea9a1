//! Verdicts in plain English.

use super::mode::{critical_mode, finite_wave_vector};
use crate::methods::Discretized;
use crate::settings::{Family, word_of};
use nalgebra::SVector;
use onset::bloch::Stability;
use onset::continuum::Ellipticity;
use onset::kinematics::DeformationGradient;
use onset::method::{Discretization, Frame};
use onset::verdict::{Assessment, Verdict};

/// A gradient norm below which a discretization that is not deficient is called weak.
const WEAK: f64 = 0.05;

/// The sentence of a state of which a proof says another thing than the search.
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

/// The sentence of an assessment; `in_space` tells of waves of the material in all directions.
pub(super) fn of<const D: usize>(
    method: &Discretized<D>,
    assessment: &Assessment<D>,
    in_space: Ellipticity,
    f: &DeformationGradient,
) -> String {
    let spectrum = &assessment.spectrum;
    let mode = critical_mode(assessment);
    let k = method.spatial(f, &finite_wave_vector(mode));
    let wave = wave(&k);
    let growth = growth(spectrum.growth_rate());
    let tension = if assessment.material.mean_stress() >= 0.0 {
        "tensile"
    } else {
        "compressive"
    };
    match assessment.verdict {
        Verdict::Stable => {
            let weak = if !spectrum.softest.is_long_wave && assessment.gradient_norm < WEAK {
                format!(
                    " The softest mode, {wave}, is weak: its gradients are {:.2} % of what they should be.",
                    100.0 * assessment.gradient_norm.max(0.0).sqrt()
                )
            } else {
                String::new()
            };
            match assessment.material.ellipticity() {
                Ellipticity::Undecided => format!(
                    "Stable as far as the particles go: none of their plane waves grows. Of the material it is undecided: its smallest \
                     acoustic eigenvalue is zero to rounding, as that of a fluid, which bears no shear.{weak}"
                ),
                _ => format!(
                    "Stable: the material is strongly elliptic{} and no plane wave of the particles grows.{weak}",
                    in_plane(in_space)
                ),
            }
        }
        Verdict::Material => format!(
            "Unstable, and rightly so: the material itself has lost ellipticity, for waves along N = {}, and the \
             particles follow it; their fastest mode, {wave}, {growth}.",
            vector(assessment.material.minimum.direction.as_slice())
        ),
        Verdict::RankDeficient => {
            let frame = method.kernel().map(|method| method.discretization().frame);
            let when = match frame {
                Some(Frame::Lagrangian) => "at any state",
                _ => "at this state",
            };
            let which = if mode.is_long_wave {
                let along = method.spatial(f, &mode.wave_vector).normalize();
                format!("even long waves along {} have", vector(along.as_slice()))
            } else {
                format!("a wave of {wave} has")
            };
            format!(
                "Not usable as it is although the material is stable: the quadrature is rank-deficient, {which} no energy, \
                 {when}."
            )
        }
        Verdict::Kernel if spectrum.flutters && spectrum.lowest.omega_squared.re >= 0.0 => format!(
            "Unstable although the material is stable: flutter of the kernel ({tension} mean stress), {wave}, {growth}."
        ),
        Verdict::Kernel if assessment.material.ellipticity().is_lost() => format!(
            "Unstable, but not as the material is: the material has lost ellipticity, while the particles are stable \
             for long waves and unstable by the method's own {tension} instability, {wave}, {growth}."
        ),
        Verdict::Kernel => format!(
            "Unstable although the material is stable: {tension} instability of the kernel, {wave}, {growth}."
        ),
        Verdict::Missed => format!(
            "Stable although the material is not: it has lost ellipticity for waves along N = {}, and the particles \
             do not show it.",
            vector(assessment.material.minimum.direction.as_slice())
        ),
    }
}

/// What to add where waves of the material that the discretization does not have say another thing.
fn in_plane(in_space: Ellipticity) -> &'static str {
    match in_space {
        Ellipticity::Elliptic => "",
        Ellipticity::Undecided => " for waves in the plane (undecided for waves out of it)",
        Ellipticity::Lost => " for waves in the plane (not for waves out of it)",
    }
}

fn wave<const D: usize>(k: &SVector<f64, D>) -> String {
    let norm = k.norm();
    if norm == 0.0 {
        "infinitely long waves".to_owned()
    } else {
        let direction = k / norm;
        format!(
            "wavelength {} along {}",
            number(std::f64::consts::TAU / norm),
            vector(direction.as_slice())
        )
    }
}

fn growth(rate: f64) -> String {
    if rate > 0.0 {
        format!("grows e-fold in {} time units", number(1.0 / rate))
    } else {
        "grows the faster the shorter the wave".to_owned()
    }
}

/// A number with four decimals, or with an exponent where these would not show it.
pub(super) fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) {
        format!("{value:.4}")
    } else {
        format!("{value:.4e}")
    }
}

/// A method of another family than the kernel methods.
pub(super) fn family(family: Family, discretization: &Discretization) -> String {
    let arrangement = match family {
        Family::FiniteElements => String::new(),
        _ => format!(", {} arrangement", discretization.arrangement.name()),
    };
    let spacing = number(discretization.spacing);
    format!("{}{arrangement}, spacing {spacing}", word_of(&family))
}

/// A vector with four decimals.
pub(super) fn vector(components: &[f64]) -> String {
    let largest = components
        .iter()
        .fold(0.0_f64, |largest, component| largest.max(component.abs()));
    let one = |component: &f64| {
        number(if component.abs() < 5e-5 * largest {
            0.0
        } else {
            *component
        })
    };
    format!(
        "({})",
        components.iter().map(one).collect::<Vec<_>>().join(", ")
    )
}

/// A discretization in a line.
pub(super) fn settings(d: &Discretization) -> String {
    let mut words = vec![
        word_of(&d.arrangement),
        word_of(&d.quadrature),
        word_of(&d.approximation),
        word_of(&d.kernel),
        format!("D_mx {}", d.support),
        word_of(&d.frame),
    ];
    if d.frame == Frame::Eulerian {
        words.push(format!("{} lattice", word_of(&d.lattice)));
        words.push(format!("{} support", word_of(&d.support_size)));
        words.push(format!("{} linearization", word_of(&d.linearization)));
    }
    words.push(format!("{} background", word_of(&d.background)));
    words.join(", ")
}
