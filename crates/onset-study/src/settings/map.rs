//! Settings of a map.

use super::Value;
use serde::{Serialize, Serializer};

/// Numbers of a state that a map can store, by their names in the store.
pub const OUTPUTS: &[&str] = &[
    "acoustic_minimum",
    "acoustic_direction",
    "scaled_minimum",
    "wave_vector",
    "lowest_omega_squared",
    "growth_rate",
    "critical_time_step",
];

/// Set of [`OUTPUTS`] that a map stores.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outputs([bool; OUTPUTS.len()]);

impl Outputs {
    /// Set with the given names; `None` if a name is unknown.
    fn of<S: AsRef<str>>(names: &[S]) -> Option<Self> {
        let mut chosen = [false; OUTPUTS.len()];
        for name in names {
            let place = OUTPUTS.iter().position(|output| *output == name.as_ref())?;
            chosen[place] = true;
        }
        Some(Self(chosen))
    }

    fn names(self) -> impl Iterator<Item = &'static str> {
        let chosen = OUTPUTS.iter().zip(self.0).filter(|(_, chosen)| *chosen);
        chosen.map(|(name, _)| *name)
    }

    /// Returns true if a field is stored. The flag `long_wave` is stored with the wave vector; fields that are not outputs are always stored.
    pub fn hold(self, field: &str) -> bool {
        let name = if field == "long_wave" {
            "wave_vector"
        } else {
            field
        };
        !OUTPUTS.contains(&name) || self.names().any(|output| output == name)
    }
}

impl Serialize for Outputs {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.names())
    }
}

/// Settings of a map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct MapSettings {
    /// Whether states are refined only where the verdict changes.
    pub adaptive: bool,
    /// Coarsest stride of the refinement, in states; a power of two, at most `tile`.
    pub refine_from: usize,
    /// Whether stability and instability are proved.
    pub certify: bool,
    /// Largest distance from the boundary of a certified state that may stay undecided, in the dimensionless measure of stability.
    pub tolerance: f64,
    /// Number of states along an edge of a tile.
    pub tile: usize,
    /// Numbers that are stored in addition to verdict and stability.
    pub outputs: Outputs,
}

impl Default for MapSettings {
    fn default() -> Self {
        Self {
            adaptive: false,
            refine_from: 16,
            certify: false,
            tolerance: 1e-3,
            tile: 64,
            outputs: Outputs([true; OUTPUTS.len()]),
        }
    }
}

impl MapSettings {
    /// Sets the value under a name; returns false if the name is unknown or the value is of a wrong kind.
    pub fn set(&mut self, name: &str, value: &Value) -> bool {
        match (name, value) {
            ("adaptive", Value::Switch(on)) => self.adaptive = *on,
            ("refine-from", Value::Number(number)) => self.refine_from = *number as usize,
            ("certify", Value::Switch(on)) => self.certify = *on,
            ("tolerance", Value::Number(number)) => self.tolerance = *number,
            ("tile", Value::Number(number)) => self.tile = *number as usize,
            ("outputs", Value::Words(names)) => match Outputs::of(names) {
                Some(outputs) => self.outputs = outputs,
                None => return false,
            },
            _ => return false,
        }
        true
    }
}
