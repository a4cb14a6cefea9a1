//! Smallest stabilization coefficient that removes the spurious modes of a method without masking the instability of the material.
//!
//! If the coefficient is too small, zero-energy modes remain. If it is too large, the method stays stable where the material does not, or needs tiny
//! time steps. The coefficient is evaluated on a grid of values, and the smallest sufficient value is refined by bisection.

mod answer;

pub(crate) use answer::recommended;
pub use answer::{Dependence, Tried, TuneAnswer};

use crate::compare::Thresholds;
use crate::range::spread;
use crate::settings::{Key, STEP_OF_RATES, Settings, Value, unknown_key_of};
use crate::settings::{Origin, SettingError};

/// Number of values on the grid.
const VALUES: usize = 13;
/// Default range of the coefficient.
const RANGE: (f64, f64) = (0.0, 1.0);
/// Default range of the stretches for which verdicts are compared.
const STRETCHES: (f64, f64) = (0.7, 1.5);

/// Coefficient to tune, with its range.
#[derive(Clone, Debug, PartialEq)]
pub struct TuneQuestion {
    key: &'static Key,
    range: [f64; 2],
    stretches: [f64; 2],
    thresholds: Thresholds,
}

impl TuneQuestion {
    /// Creates the question with the default ranges and thresholds.
    ///
    /// # Errors
    /// [`SettingError`] when the key does not exist or is not a number.
    pub fn of(name: &str) -> Result<Self, SettingError> {
        Self::new(name, RANGE, STRETCHES)
    }

    /// Parses the key of the coefficient, the range of its values, and the range of stretches for which verdicts are compared.
    ///
    /// # Errors
    /// [`SettingError`] when the key does not exist or is not a number.
    pub fn new(name: &str, range: (f64, f64), stretches: (f64, f64)) -> Result<Self, SettingError> {
        let origin = || Origin::CommandLine(name.to_owned());
        let is_coefficient = |key: &Key| key.parts().0 == "discretization" && key.unit().is_some();
        let Some(key) = Key::named(name) else {
            return Err(unknown_key_of(name, is_coefficient, origin()));
        };
        if !is_coefficient(key) {
            let message = match key.parts().0 {
                "discretization" => {
                    format!("`{name}` is not a coefficient: it takes {}", key.expects())
                }
                section => {
                    format!(
                        "`{name}` is not a coefficient of the method: it is one of the {section}"
                    )
                }
            };
            let hint = match (key.parts().0, key.words()) {
                ("discretization", [_, ..]) => format!(
                    "`onset compare --vary {name}` compares its values; `onset tune` takes a key with a number, for example discretization.penalty"
                ),
                _ => "give a key of [discretization] that takes a number, for example discretization.penalty".to_owned(),
            };
            return Err(SettingError::new(origin(), message).hint(hint));
        }
        if key.name == STEP_OF_RATES {
            let message =
                format!("`{name}` is not a coefficient: it is the time step for growth rates");
            return Err(SettingError::new(origin(), message)
                .hint("give a coefficient of the method, for example discretization.flip-share"));
        }
        if stretches.0 <= 0.0 {
            let message = format!(
                "--stretches begins at {}; stretches are positive",
                stretches.0
            );
            return Err(
                SettingError::new(origin(), message).hint("for example --stretches 0.7,1.5")
            );
        }
        Ok(Self {
            key,
            range: [range.0, range.1],
            stretches: [stretches.0, stretches.1],
            thresholds: Thresholds::default(),
        })
    }

    /// Replaces the thresholds for sufficient and masking values.
    pub fn with_thresholds(mut self, thresholds: Thresholds) -> Self {
        self.thresholds = thresholds;
        self
    }

    /// Checks that the method uses the coefficient.
    ///
    /// # Errors
    /// [`SettingError`] with the settings under which the coefficient is used.
    pub fn check(&self, settings: &Settings) -> Result<(), SettingError> {
        settings.check_read(self.key, Origin::CommandLine(self.key.name.to_owned()), &[])
    }

    /// Returns the key of the coefficient.
    pub fn key(&self) -> &'static str {
        self.key.name
    }

    /// Returns the values of the grid.
    pub fn values(&self) -> Vec<f64> {
        spread(self.range, VALUES)
    }

    /// Sets a value of the coefficient.
    fn settings(&self, settings: &Settings, value: f64) -> Result<Settings, SettingError> {
        let mut changed = settings.clone();
        changed.set(self.key.name, &Value::Number(value), Origin::Combination)?;
        Ok(changed)
    }
}
