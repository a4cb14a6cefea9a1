//! Which values of a setting admit a given time step: the largest modulus, the smallest spacing or density, the largest penalty.
//!
//! The step of a simulation is often given, by other parts of it or by what it may cost. The critical step of a state is looked at on a grid of
//! values, and where it becomes that of the simulation is found by secants between halvings.

mod answer;

pub use answer::{Admitted, End, EndKind, LimitAnswer, Tried};

pub use onset::time_step::Integrator;

use crate::answers::ProblemError;
use crate::settings::{
    KEYS, Key, Kind, Origin, STEP_OF_RATES, SettingError, Settings, Value, units, unknown_key,
};

/// Values that are looked at before limits are refined.
const VALUES: usize = 25;
/// How far below and above its present value a setting is looked at unless a range is given.
const REACH: f64 = 1e6;

/// The time step, as a value with a unit.
static TIME_STEP: Key = Key {
    name: "--time-step",
    kind: Kind::Positive("time"),
    meaning: "the time step that must be stable",
    read_with: &[],
};

/// Which setting is varied, and which time step must be stable.
#[derive(Clone, Debug, PartialEq)]
pub struct LimitQuestion {
    key: &'static Key,
    /// As typed, with a unit or without.
    step: String,
    range: Option<[f64; 2]>,
    safety: f64,
    integrator: Integrator,
}

impl LimitQuestion {
    /// A setting by its key, and a time step as typed.
    ///
    /// # Errors
    /// [`SettingError`] when there is no such key, or it takes no number.
    pub fn new(name: &str, step: &str) -> Result<Self, SettingError> {
        let origin = || Origin::CommandLine(name.to_owned());
        let Some(key) = Key::named(name) else {
            let numbers = KEYS.iter().filter(|key| key.is_varied());
            return Err(unknown_key(name, numbers.map(|key| key.name), origin()));
        };
        if !key.is_varied() {
            let message = format!("`{name}` cannot be varied: it takes {}", key.expects());
            return Err(SettingError::new(origin(), message)
                .hint("give a number of [material] or [discretization], for example material.young or discretization.spacing"));
        }
        if key.name == STEP_OF_RATES {
            let message =
                format!("`{name}` is a time step itself: the critical one does not depend on it");
            return Err(SettingError::new(origin(), message)
                .hint("vary what the critical step depends on, for example material.young or discretization.spacing"));
        }
        Ok(Self {
            key,
            step: step.to_owned(),
            range: None,
            safety: 1.0,
            integrator: Integrator::KickDriftKick,
        })
    }

    /// Between two values.
    pub fn between(mut self, range: Option<(f64, f64)>) -> Self {
        self.range = range.map(|(low, high)| [low, high]);
        self
    }

    /// With a step that is at most this share of the critical one.
    pub fn with_safety(mut self, safety: f64) -> Self {
        self.safety = safety;
        self
    }

    /// With the critical step of an integrator.
    pub fn with_integrator(mut self, integrator: Integrator) -> Self {
        self.integrator = integrator;
        self
    }

    /// The name of the setting.
    pub fn key(&self) -> &'static str {
        self.key.name
    }

    /// How many values are looked at, before limits are refined.
    pub fn values(&self) -> usize {
        VALUES
    }

    /// Refuses a key that method and law do not read.
    fn check(&self, settings: &Settings) -> Result<(), SettingError> {
        settings.check_read(self.key, Origin::CommandLine(self.key.name.to_owned()), &[])
    }

    /// The time step in the units of the settings.
    fn time_step(&self, settings: &Settings) -> Result<f64, SettingError> {
        let origin = Origin::CommandLine(format!("--time-step {}", self.step));
        let typed = Value::typed(&self.step, Some(TIME_STEP.kind));
        let measured = units::converted(&TIME_STEP, &typed, &origin)?;
        if measured.is_some() && !settings.units().are_si() {
            let message = "the time step has a unit, and the settings have none".to_owned();
            return Err(SettingError::new(origin, message).hint(
                "give the step in the units of the settings, as a number, or units to all of them",
            ));
        }
        let step = measured.unwrap_or(typed);
        match step.number().filter(|_| TIME_STEP.kind.accepts(&step)) {
            Some(step) => Ok(step),
            None => Err(
                SettingError::new(origin, format!("a time step cannot be {step}"))
                    .hint("expected a positive number, for example --time-step 1e-4"),
            ),
        }
    }

    /// The range that is looked at about the present value.
    fn range(&self, present: Option<f64>) -> Result<[f64; 2], SettingError> {
        if let Some(range) = self.range {
            return Ok(range);
        }
        let present = present.filter(|value| *value > 0.0);
        present
            .map(|value| [value / REACH, (value * REACH).min(f64::MAX)])
            .ok_or_else(|| {
                let origin = Origin::CommandLine(self.key.name.to_owned());
                let message = format!(
                    "`{}` has no positive value about which others could be looked at",
                    self.key.name
                );
                SettingError::new(origin, message)
                    .hint("name the values to look at with --range LOW,HIGH")
            })
    }

    /// The settings with another value, which is measured as the others are.
    fn settings(&self, settings: &Settings, value: f64) -> Result<Settings, ProblemError> {
        let mut changed = settings.clone();
        let unit = settings.unit(self.key);
        let value = unit.map_or(Value::Number(value), |unit| {
            Value::Word(format!("{value:e} {unit}"))
        });
        changed.set(self.key.name, &value, Origin::Combination)?;
        // What is read with some values of the setting is not without effect.
        changed.check(&[self.key.name])?;
        Ok(changed)
    }
}
