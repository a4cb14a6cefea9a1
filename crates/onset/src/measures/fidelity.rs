//! Fidelity of a method to its material in a window of states.

use crate::kinematics::DeformationGradient;
use crate::method::MethodError;
use crate::verdict::{Phase, Survey, Verdict, probe_material};

/// Window of states: a grid of cell centers in the stretches along the first two axes, or along one in one dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateWindow {
    /// Smallest and largest stretch along each axis.
    pub stretches: [f64; 2],
    /// Number of states along each axis.
    pub states: usize,
}

/// Fractions of the states of a window, by the stability of method and material.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Fidelity {
    /// Fraction of states with an unstable method although the material is elliptic.
    pub false_instability: f64,
    /// Fraction of states with a stable method although the material is not elliptic.
    pub suppressed_instability: f64,
    /// Fraction of states with a stable method that has zero-energy modes.
    pub zero_energy: f64,
    /// Fraction of states in which the method is undefined, for example because of too few neighbors, although the law is defined.
    pub undefined: f64,
    /// Fraction of states outside the domain of the law.
    pub outside_law: f64,
    /// Fraction of states with an elliptic material.
    pub elliptic: f64,
}

impl Fidelity {
    /// Fraction of states where the stability of method and material agrees and no mode has zero energy.
    pub fn agreement(&self) -> f64 {
        1.0 - self.false_instability
            - self.suppressed_instability
            - self.zero_energy
            - self.undefined
            - self.outside_law
    }
}

/// Classifies the states of a window by the stability of method and material.
///
/// # Errors
/// [`MethodError`] when a state cannot be evaluated. Lack of support and states outside the domain of the law are not errors; they are counted.
pub fn fidelity<const D: usize>(
    survey: &Survey<'_, D>,
    window: &StateWindow,
) -> Result<Fidelity, MethodError> {
    let [low, high] = window.stretches;
    let n = window.states;
    let stretch = |i: usize| low + (high - low) * (i as f64 + 0.5) / n as f64;
    let rows = if D == 1 { 1 } else { n };
    let share = 1.0 / (n * rows) as f64;
    let mut found = Fidelity::default();
    for row in 0..rows {
        for column in 0..n {
            let second = if D == 1 { 1.0 } else { stretch(row) };
            let f = DeformationGradient::from_stretches([stretch(column), second, 1.0])?;
            if probe_material::<D>(survey.material(), &f)?.0 == Phase::Undefined {
                found.outside_law += share;
                continue;
            }
            match survey.state(&f) {
                Ok(state) => {
                    let is_lost = state.acoustic.has_growing_waves();
                    found.elliptic += if is_lost { 0.0 } else { share };
                    match state.verdict {
                        Verdict::Numerical if !is_lost => found.false_instability += share,
                        Verdict::Suppressed => found.suppressed_instability += share,
                        Verdict::ZeroEnergy => found.zero_energy += share,
                        Verdict::Stable | Verdict::Physical | Verdict::Numerical => {}
                    }
                }
                Err(error) if error.leaves_undefined() => found.undefined += share,
                Err(error) => return Err(error),
            }
        }
    }
    Ok(found)
}
