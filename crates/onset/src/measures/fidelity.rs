//! How faithful a method is to its material over a window of states.

use crate::kinematics::DeformationGradient;
use crate::method::MethodError;
use crate::verdict::{Phase, Survey, Verdict, probe_material};

/// A window of states: stretches along the first two axes (one in one dimension), cell-centered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateWindow {
    /// Smallest and largest stretch.
    pub stretches: [f64; 2],
    /// States along an axis.
    pub states: usize,
}

/// Shares of the states of a window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Fidelity {
    /// Unstable though the material is elliptic.
    pub false_instability: f64,
    /// Stable though the material is not elliptic.
    pub suppressed_instability: f64,
    /// Stable, but with zero-energy modes.
    pub zero_energy: f64,
    /// Defined by the law, but not by the method: too few neighbors.
    pub undefined: f64,
    /// Outside of the law's domain.
    pub outside_law: f64,
    /// Elliptic.
    pub elliptic: f64,
}

impl Fidelity {
    /// The share of the states on which material and method agree.
    pub fn agreement(&self) -> f64 {
        1.0 - self.false_instability
            - self.suppressed_instability
            - self.undefined
            - self.outside_law
    }
}

/// Shares of the states of a window on which method and material differ.
///
/// # Errors
/// [`MethodError`] when a state cannot be evaluated for another reason than its support or the law's domain.
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
