//! Stable steps of bodies whose largest eigenvalues of stiffness and damping are known.

use super::{Integrator, Stepping, undamped_time_step};

/// Bounds of the oscillations of a body: the largest eigenvalues of stiffness and damping, divided by the masses.
///
/// The two matrices need not have common eigenvectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    /// Largest eigenvalue of the stiffness; 1/time^2.
    pub squared: f64,
    /// Largest eigenvalue of the damping; 1/time.
    pub damping: f64,
}

/// Root of `s^2 + 2 s = 1`, where `(1 + s^2)/(1 + s)` has its minimum `2 s`.
const WORST: f64 = std::f64::consts::SQRT_2 - 1.0;
/// Number of halvings of the interval that contains a critical step.
const HALVINGS: usize = 60;

impl Oscillation {
    /// Bounds below the bounds of every body.
    pub const NONE: Self = Self {
        squared: f64::NEG_INFINITY,
        damping: f64::NEG_INFINITY,
    };

    /// Larger bounds of two bodies.
    pub(crate) fn or(self, other: Self) -> Self {
        Self {
            squared: self.squared.max(other.squared),
            damping: self.damping.max(other.damping),
        }
    }

    /// Largest step at which all oscillations within the bounds remain bounded; time. Infinite if nothing oscillates, zero if no step is stable, and `None`
    /// if damping changes the limit of the integrator by an unknown factor.
    ///
    /// A wave of central differences satisfies `(z - 1)^2 + (z - 1) c dt + z w^2 dt^2 = 0`. At `z = -1` the limit is `w^2 dt^2 + 2 c dt = 4`. A wave of
    /// kick, drift, kick satisfies `(z - 1)^2/(1 + s) + (z - 1)(1 - s) + z w^2 dt^2/2 = 0` with `s = 1 - c dt/2`. Its limits are `c dt = 4` and
    /// `w^2 dt^2 = 4 (1 + s^2)/(1 + s)`. The latter is least at `s = sqrt(2) - 1`: moderate damping reduces the step by nine percent at most. The
    /// coefficients of both equations are symmetric matrices, so that the Rayleigh quotients of a mode satisfy them. The smallest limit of any damping up
    /// to the largest one is therefore a bound. The predictor-corrector has the limits `w^2 dt^2 = 4 - 2 c dt + c^2 dt^2` and `c dt = 2`, which are
    /// not below the limit of central differences.
    pub fn critical_time_step(self, integrator: Integrator) -> Option<f64> {
        let Self { squared, damping } = self;
        let undamped = undamped_time_step(integrator, squared.max(0.0).sqrt());
        if damping <= 0.0 {
            return Some(undamped);
        }
        match integrator {
            Integrator::CentralDifferences | Integrator::PredictorCorrector => {
                Some(Stepping::VelocityVerlet.critical_step(squared, damping))
            }
            Integrator::KickDriftKick => {
                let is_stable = |step: f64| {
                    let s = (1.0 - 0.5 * damping * step).max(WORST);
                    squared * step * step <= 4.0 * (1.0 + s * s) / (1.0 + s)
                };
                let (mut low, mut high) = (0.0, undamped.min(4.0 / damping));
                if is_stable(high) {
                    return Some(high);
                }
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (low + high);
                    match is_stable(middle) {
                        true => low = middle,
                        false => high = middle,
                    }
                }
                Some(low)
            }
            _ => None,
        }
    }
}
