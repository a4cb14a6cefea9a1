//! Settings of the time integration.

use super::key::{Key, Kind, key};
use super::needs::{Cases, is, is_not};
use super::{Origin, SettingError, Settings, Value};
use onset::material::Admitted::NotNegative;
use onset::time_step::{ImplicitIntegrator, Integrator, Stepping};

/// Key of the time integrator.
pub(crate) const INTEGRATOR: &str = "time.integrator";
/// Key of the time step of a run.
pub(crate) const RUN_STEP: &str = "time.step";
/// Key of the time stepping scheme of a run.
pub(crate) const RUN_STEPPING: &str = "time.stepping";

const EXPLICIT: usize = Integrator::NAMES.len();

/// Names of all integrators: the explicit ones, then the implicit ones.
const NAMES: [&str; EXPLICIT + ImplicitIntegrator::NAMES.len()] = {
    let mut names = [""; EXPLICIT + ImplicitIntegrator::NAMES.len()];
    let mut n = 0;
    while n < names.len() {
        names[n] = match n < EXPLICIT {
            true => Integrator::NAMES[n],
            false => ImplicitIntegrator::NAMES[n - EXPLICIT],
        };
        n += 1;
    }
    names
};

/// Methods that do not define their time step.
const STEPPED: Cases = &[
    &[is_not("discretization.method", &["material-points"])],
    &[is(
        "discretization.unknowns",
        &["total-lagrangian", "updated"],
    )],
    &[is("discretization.transfer", &["continuous"])],
];

/// Methods that do not define their time step, with the time step of a run.
const STEPPED_RUN: Cases = &[
    &[
        is_not(RUN_STEP, &["0"]),
        is_not("discretization.method", &["material-points"]),
    ],
    &[
        is_not(RUN_STEP, &["0"]),
        is("discretization.unknowns", &["total-lagrangian", "updated"]),
    ],
    &[
        is_not(RUN_STEP, &["0"]),
        is("discretization.transfer", &["continuous"]),
    ],
];

/// Names of the time stepping schemes of codes.
const STEPPINGS: [&str; Stepping::ALL.len()] = {
    let mut names = [""; Stepping::ALL.len()];
    let mut n = 0;
    while n < names.len() {
        names[n] = Stepping::ALL[n].name();
        n += 1;
    }
    names
};

/// Keys of the time integration.
pub(super) const TIME_KEYS: [Key; 3] = [
    key(
        INTEGRATOR,
        Kind::Words(&NAMES),
        "time integrator: its largest stable step is computed, and simulations use it",
    )
    .only_with(STEPPED),
    key(
        RUN_STEP,
        Kind::Number("time", NotNegative),
        "time step of a run with another code, which onset state compares with the largest stable step; 0 for none",
    )
    .only_with(STEPPED),
    key(
        RUN_STEPPING,
        Kind::Words(&STEPPINGS),
        "time stepping of the code of this run, as in onset screen --stepping",
    )
    .only_with(STEPPED_RUN),
];

/// Time step of a run with another code, and its time stepping scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunStep {
    /// Time step of the run, 0 for none; time.
    pub step: f64,
    /// Time stepping scheme of the code.
    pub stepping: Stepping,
}

impl Default for RunStep {
    fn default() -> Self {
        Self {
            step: 0.0,
            stepping: Stepping::VelocityVerlet,
        }
    }
}

/// Time integrator of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeIntegrator {
    /// An explicit integrator, whose step is limited.
    Explicit(Integrator),
    /// An implicit integrator, whose step no stability limits.
    Implicit(ImplicitIntegrator),
}

impl Default for TimeIntegrator {
    fn default() -> Self {
        Self::Explicit(Integrator::KickDriftKick)
    }
}

impl TimeIntegrator {
    /// Returns the integrator with the given name or common alternative name, or `None`.
    pub fn named(name: &str) -> Option<Self> {
        let explicit = Integrator::named(name).map(Self::Explicit);
        explicit.or_else(|| ImplicitIntegrator::named(name).map(Self::Implicit))
    }

    /// Name in study files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Explicit(own) => own.name(),
            Self::Implicit(own) => own.name(),
        }
    }

    /// Explicit integrator; `None` for an implicit one.
    pub fn explicit(self) -> Option<Integrator> {
        match self {
            Self::Explicit(own) => Some(own),
            Self::Implicit(_) => None,
        }
    }
}

impl Settings {
    /// Sets the time integrator by an option of a command.
    ///
    /// # Errors
    /// [`SettingError`] for an unknown name, and if the method defines its step.
    pub fn with_integrator(mut self, name: &str) -> Result<Self, SettingError> {
        let origin = Origin::CommandLine(format!("--integrator {name}"));
        self.set(INTEGRATOR, &Value::Word(name.to_owned()), origin.clone())?;
        self.check_read(&TIME_KEYS[0], origin, &[])?;
        Ok(self)
    }

    /// Integrator that was set; `None` if the default applies.
    pub(crate) fn chosen_integrator(&self) -> Option<TimeIntegrator> {
        self.origin(INTEGRATOR).map(|_| self.integrator)
    }

    /// Name of the integrator that was set, if its steps differ from central differences without damping.
    pub fn integrator_of_other_steps(&self) -> Option<&'static str> {
        let own = self.chosen_integrator()?;
        let reach = Integrator::CentralDifferences.undamped_reach();
        let is_other = own
            .explicit()
            .is_none_or(|own| own.undamped_reach() != reach);
        is_other.then(|| own.name())
    }

    /// Explicit integrator, for answers about its largest stable step.
    ///
    /// # Errors
    /// [`SettingError`] for an implicit integrator.
    pub(crate) fn explicit_integrator(&self) -> Result<Integrator, SettingError> {
        self.integrator.explicit().ok_or_else(|| {
            let origin = self.origin(INTEGRATOR).cloned();
            let name = self.integrator.name();
            SettingError::new(
                origin.unwrap_or(Origin::Combination),
                format!("{name} is implicit: no largest stable step limits it"),
            )
            .hint(format!(
                "set {INTEGRATOR} to an explicit integrator, for example kick-drift-kick; `onset state` describes implicit ones"
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{STEPPINGS, Stepping};

    #[test]
    fn the_schemes_of_runs_have_the_names_of_screen() {
        assert_eq!(STEPPINGS, Stepping::ALL.map(Stepping::name));
    }
}
