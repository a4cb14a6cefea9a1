//! Settings of the time integration.

use super::key::{Key, Kind, key};
use super::needs::{Cases, is, is_not};
use super::{Origin, SettingError, Settings, Value};
use onset::time_step::{ImplicitIntegrator, Integrator};

/// Key of the time integrator.
pub(crate) const INTEGRATOR: &str = "time.integrator";

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

/// Keys of the time integration.
pub(super) const TIME_KEYS: [Key; 1] = [key(
    INTEGRATOR,
    Kind::Words(&NAMES),
    "time integrator: its largest stable step is computed, and simulations use it",
)
.only_with(STEPPED)];

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
