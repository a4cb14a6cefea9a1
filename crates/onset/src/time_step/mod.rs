//! Time steps: which are stable, for which integrator, with and without damping.
//!
//! A wave of the linearized equations `M dv/dt = -K u - C v`, `du/dt = T v` is a small linear system; one step of an integrator
//! multiplies `(u, v)` by the amplification matrix `G(dt)`. A step is stable when no more eigenvalues of `G` are outside of the unit
//! circle than solutions of the equations themselves grow: what grows anyway needs no step, what does not must not.
//!
//! Methods that filter velocities once a step have steps of their own, and no equations in continuous time: [`TransferredWaves`].

mod amplification;
mod stepping;
mod transferred;
mod zone;

pub use amplification::{
    Amplification, critical_time_step, critical_time_step_at, critical_time_step_unless,
};
pub use stepping::{Stepping, WaveParts};
pub use transferred::TransferredWaves;

/// Explicit integrators.
///
/// ```
/// use onset::time_step::Integrator;
/// assert_eq!(Integrator::ALL.len(), 3);
/// assert_eq!(Integrator::KickDriftKick.name(), "kick-drift-kick");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "kebab-case")
)]
pub enum Integrator {
    /// Central differences with velocities at half steps, damping from the last half step: `v+ = v- + dt a(u, v-)`,
    /// `u' = u + dt T v+`. Stable up to `2 / omega` without damping.
    CentralDifferences,
    /// Leapfrog as kick, drift, kick (velocity Verlet): `v+ = v + dt/2 a(u, v)`, `u' = u + dt T v+`, `v' = v+ + dt/2 a(u', v+)`.
    /// Stable up to `2 / omega` without damping.
    KickDriftKick,
    /// The predictor-corrector usual in smoothed particle hydrodynamics (Monaghan 1989): half a step to `u*`, `v*`, the
    /// acceleration there, then `v' = v + dt a(u*, v*)`, `u' = u + dt T (v + v') / 2`. Stable up to `2 / omega` without
    /// damping.
    PredictorCorrector,
}

impl Integrator {
    /// All of them.
    pub const ALL: [Self; 3] = [
        Self::CentralDifferences,
        Self::KickDriftKick,
        Self::PredictorCorrector,
    ];

    /// The one with a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|own| own.name() == name)
    }

    /// The word used in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::CentralDifferences => "central-differences",
            Self::KickDriftKick => "kick-drift-kick",
            Self::PredictorCorrector => "predictor-corrector",
        }
    }
}
