//! Stable time steps of integrators, with and without damping.
//!
//! A wave of the linearized equations `M dv/dt = -K u - C v`, `du/dt = T v` is a small linear system. One step of an integrator multiplies `(u, v)`
//! by the amplification matrix `G(dt)`. A step is stable if no more eigenvalues of `G` lie outside the unit circle than solutions of the equations
//! themselves grow: physical growth does not limit the step, numerical growth does.
//!
//! Methods that filter velocities once per step have a built-in step and no equations in continuous time: [`TransferredWaves`].

mod amplification;
mod implicit;
mod oscillation;
mod runge_kutta;
mod stepping;

pub use amplification::{
    Amplification, critical_time_step, critical_time_step_at, undamped_time_step,
};
pub use implicit::ImplicitIntegrator;
pub use oscillation::Oscillation;
pub use stepping::{Stepping, WaveParts};

pub use crate::bloch::{TransferredWaves, VelocityFilter};

use crate::algebra::Complex;
use runge_kutta::Stages;

/// Explicit integrators of the equations of motion.
///
/// ```
/// use onset::time_step::Integrator;
/// assert_eq!(Integrator::KickDriftKick.name(), "kick-drift-kick");
/// assert_eq!(Integrator::named("leapfrog"), Some(Integrator::CentralDifferences));
/// assert!((Integrator::Rk4.undamped_reach() - 8.0_f64.sqrt()).abs() < 1e-9);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(into = "&'static str", try_from = "String")
)]
pub enum Integrator {
    /// Central differences with velocities at half steps and damping from the last half step: `v+ = v- + dt a(u, v-)`, `u' = u + dt T v+`. Stable up
    /// to `2 / omega` without damping.
    CentralDifferences,
    /// Leapfrog as kick, drift, kick (velocity Verlet): `v+ = v + dt/2 a(u, v)`, `u' = u + dt T v+`, `v' = v+ + dt/2 a(u', v+)`. Stable up to
    /// `2 / omega` without damping.
    KickDriftKick,
    /// Predictor-corrector common in smoothed particle hydrodynamics (Monaghan 1989): half a step to `u*`, `v*`, the acceleration there, then
    /// `v' = v + dt a(u*, v*)`, `u' = u + dt T (v + v') / 2`. Stable up to `2 / omega` without damping.
    PredictorCorrector,
    /// Forward Euler; unstable for every step without damping.
    ForwardEuler,
    /// Heun's method of order two; unstable for every step without damping.
    Heun,
    /// Kutta's method of order three. Stable up to `1.732 / omega` without damping.
    Rk3,
    /// The classical Runge-Kutta method of order four. Stable up to `2.828 / omega` without damping.
    Rk4,
    /// The five-stage, fourth-order method of Carpenter and Kennedy (1994). Stable up to `3.341 / omega` without damping.
    CarpenterKennedy,
    /// RDPK3SpFSAL35, five stages, order three (Ranocha and others 2022). Stable up to `2.739 / omega` without damping.
    Rdpk335,
    /// RDPK3SpFSAL49, nine stages, order four (Ranocha and others 2022). Stable up to `5.030 / omega` without damping.
    Rdpk349,
}

impl Integrator {
    /// All integrators, in the order of tables.
    pub const ALL: [Self; 10] = [
        Self::CentralDifferences,
        Self::KickDriftKick,
        Self::PredictorCorrector,
        Self::ForwardEuler,
        Self::Heun,
        Self::Rk3,
        Self::Rk4,
        Self::CarpenterKennedy,
        Self::Rdpk335,
        Self::Rdpk349,
    ];

    /// Names used in files and on the command line, in the order of [`Integrator::ALL`].
    pub const NAMES: [&str; 10] = [
        "central-differences",
        "kick-drift-kick",
        "predictor-corrector",
        "forward-euler",
        "heun",
        "rk3",
        "rk4",
        "carpenter-kennedy",
        "rdpk3-35",
        "rdpk3-49",
    ];

    /// Returns the integrator with the given name or common alternative name, or `None`.
    pub fn named(name: &str) -> Option<Self> {
        let name = match name {
            "velocity-verlet" => "kick-drift-kick",
            "leapfrog" | "symplectic-euler" => "central-differences",
            "midpoint" => "predictor-corrector",
            "euler" | "explicit-euler" => "forward-euler",
            "rk2" => "heun",
            "runge-kutta-4" | "classical-runge-kutta" => "rk4",
            "rdpk3" => "rdpk3-35",
            other => other,
        };
        Self::ALL.into_iter().find(|own| own.name() == name)
    }

    /// Name used in files and on the command line.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// Stages of a Runge-Kutta method; `None` for integrators that treat positions and velocities differently.
    fn stages(self) -> Option<Stages> {
        match self {
            Self::CentralDifferences | Self::KickDriftKick | Self::PredictorCorrector => None,
            Self::ForwardEuler => Some(runge_kutta::FORWARD_EULER),
            Self::Heun => Some(runge_kutta::HEUN),
            Self::Rk3 => Some(runge_kutta::RK3),
            Self::Rk4 => Some(runge_kutta::RK4),
            Self::CarpenterKennedy => Some(runge_kutta::CARPENTER_KENNEDY),
            Self::Rdpk335 => Some(runge_kutta::RDPK3_35),
            Self::Rdpk349 => Some(runge_kutta::RDPK3_49),
        }
    }

    /// Rows of the Butcher tableau of a Runge-Kutta method, followed by the weights.
    pub(crate) fn tableau(self) -> Option<Vec<Vec<f64>>> {
        self.stages().map(|stages| stages.rows())
    }

    /// Largest `omega dt` for which an undamped oscillation remains bounded; zero if it never does.
    pub fn undamped_reach(self) -> f64 {
        self.stages().map_or(2.0, |stages| {
            runge_kutta::reach(&stages.polynomial(), Complex::i())
        })
    }
}

impl From<Integrator> for &'static str {
    fn from(integrator: Integrator) -> Self {
        integrator.name()
    }
}

impl TryFrom<String> for Integrator {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        Self::named(&name).ok_or_else(|| format!("no integrator is called {name}"))
    }
}
