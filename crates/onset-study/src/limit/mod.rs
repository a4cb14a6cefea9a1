//! Limits of a setting for a given time step: the largest modulus, the smallest spacing or density, the largest penalty.
//!
//! The step of a simulation is often prescribed by other parts of it or by cost. The critical step of a state is evaluated on a grid of values. The
//! values at which it equals the required step are found by secant steps with interposed bisection. Instead of a step, the stability of all states in
//! a window of stretches can be required.

mod answer;
mod interval;
mod keeps;
mod varied;

pub use answer::{LimitAnswer, Tried};
pub use interval::{Admitted, End, EndKind};
pub use keeps::{KeepsAnswer, Kept};
pub use onset::time_step::Integrator;

use crate::answers::ProblemError;
use crate::settings::{
    Key, Kind, Origin, STEP_OF_RATES, SettingError, Settings, Value, units, unknown_key_of,
};

/// Number of grid values that are evaluated before limits are refined.
const VALUES: usize = 25;
/// Largest number of rows of the table in a short answer.
const SHORT_ROWS: usize = 5;
/// Ratio of the ends of the default range to the present value of the setting.
const DEFAULT_RANGE_RATIO: f64 = 1e6;

/// Default window of the stretches of states that must be stable.
pub const USUAL_STRETCHES: (f64, f64) = (0.7, 1.5);

/// Key of the time step, a value with a unit.
static TIME_STEP: Key = Key {
    name: "--time-step",
    kind: Kind::Number("time", crate::settings::Admitted::Positive),
    meaning: "the time step that must be stable",
    read_with: &[],
};

/// Setting to vary, with the options of the search.
#[derive(Clone, Debug, PartialEq)]
pub struct LimitQuestion {
    key: &'static Key,
    range: Option<[f64; 2]>,
    safety: f64,
}

impl LimitQuestion {
    /// Parses the name of the key to vary.
    ///
    /// # Errors
    /// [`SettingError`] when the key does not exist or is not a number.
    pub fn new(name: &str) -> Result<Self, SettingError> {
        let origin = || Origin::CommandLine(name.to_owned());
        let Some(key) = Key::named(name) else {
            return Err(unknown_key_of(name, Key::is_varied, origin()));
        };
        if !key.is_varied() {
            let message = format!("`{name}` cannot be varied: it takes {}", key.expects());
            return Err(SettingError::new(origin(), message)
                .hint("give a number of [material] or [discretization], for example material.young or discretization.spacing"));
        }
        if key.name == STEP_OF_RATES {
            let message = format!(
                "`{name}` is a time step itself: the critical time step does not depend on it"
            );
            return Err(SettingError::new(origin(), message)
                .hint("vary a setting that affects the critical step, for example material.young or discretization.spacing"));
        }
        Ok(Self {
            key,
            range: None,
            safety: 1.0,
        })
    }

    /// Restricts the values to a range.
    pub fn between(mut self, range: Option<(f64, f64)>) -> Self {
        self.range = range.map(|(low, high)| [low, high]);
        self
    }

    /// Sets the maximum ratio of the step to the critical step.
    pub fn with_safety(mut self, safety: f64) -> Self {
        self.safety = safety;
        self
    }

    /// Returns the key of the setting.
    pub fn key(&self) -> &'static str {
        self.key.name
    }

    /// Returns the number of grid values that are evaluated before limits are refined.
    pub fn values(&self) -> usize {
        VALUES
    }

    /// Present value of the setting, and the range of values.
    ///
    /// # Errors
    /// [`ProblemError`] for a key that method and law do not use, or that cannot have its present value, and without a range.
    fn values_of(&self, settings: &Settings) -> Result<(Option<f64>, [f64; 2]), ProblemError> {
        let origin = Origin::CommandLine(self.key.name.to_owned());
        settings.check_read(self.key, origin, &[])?;
        let present = settings.value(self.key.name);
        let present = present.and_then(|value| value.number());
        let range = self.range(present)?;
        if let Some(present) = present {
            self.settings(settings, present)?;
        }
        Ok((present, range))
    }

    /// Converts a time step, as typed with or without a unit, to the units of the settings.
    fn time_step(step: &str, settings: &Settings) -> Result<f64, SettingError> {
        let origin = Origin::CommandLine(format!("--time-step {step}"));
        let typed = Value::typed(step, Some(TIME_STEP.kind));
        let measured = units::converted(&TIME_STEP, &typed, &origin)?;
        if measured.is_some() && !settings.units().are_si() {
            let message = "the time step has a unit, but the settings have no units".to_owned();
            return Err(SettingError::new(origin, message).hint(
                "give the step as a number in the units of the settings, or give units to all settings",
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

    /// Range of values: as requested, or around the present value by default.
    fn range(&self, present: Option<f64>) -> Result<[f64; 2], SettingError> {
        if let Some(range) = self.range {
            return Ok(range);
        }
        let present = present.filter(|value| *value > 0.0);
        present
            .map(|value| {
                let ends = [value / DEFAULT_RANGE_RATIO, value * DEFAULT_RANGE_RATIO];
                match self.key.kind.limits() {
                    Some([least, most]) => ends.map(|end| end.clamp(least, most)),
                    None => ends,
                }
            })
            .ok_or_else(|| {
                let origin = Origin::CommandLine(self.key.name.to_owned());
                let message = format!(
                    "the value of `{}` is not positive, so that no range can be centered on it",
                    self.key.name
                );
                SettingError::new(origin, message)
                    .hint("set the range of values with --range LOW,HIGH")
            })
    }

    /// Settings with another value of the varied key, which are checked.
    fn settings(&self, settings: &Settings, value: f64) -> Result<Settings, ProblemError> {
        let mut changed = settings.clone();
        let unit = settings.unit(self.key);
        let value = unit.map_or(Value::Number(value), |unit| {
            Value::Word(format!("{value:e} {unit}"))
        });
        changed.set(self.key.name, &value, Origin::Combination)?;
        // A key that is used with only some of its values must not be reported as unused.
        changed.check(&[self.key.name])?;
        Ok(changed)
    }
}
