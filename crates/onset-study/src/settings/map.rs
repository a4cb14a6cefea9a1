//! How a map is made.

use super::Value;
use onset::time_step::Integrator;
use serde::{Serialize, Serializer};

/// The numbers of a state that a map can hold, by their names in the store.
pub const OUTPUTS: &[&str] = &[
    "acoustic_minimum",
    "acoustic_direction",
    "scaled_minimum",
    "wave_vector",
    "lowest_omega_squared",
    "growth_rate",
    "critical_time_step",
];

/// Some of [`OUTPUTS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outputs([bool; OUTPUTS.len()]);

impl Outputs {
    /// Those with the given names; `None` when there is none with one of them.
    fn of<S: AsRef<str>>(names: &[S]) -> Option<Self> {
        let mut chosen = [false; OUTPUTS.len()];
        for name in names {
            let place = OUTPUTS.iter().position(|output| *output == name.as_ref())?;
            chosen[place] = true;
        }
        Some(Self(chosen))
    }

    /// Their names.
    fn names(self) -> impl Iterator<Item = &'static str> {
        let chosen = OUTPUTS.iter().zip(self.0).filter(|(_, chosen)| *chosen);
        chosen.map(|(name, _)| *name)
    }

    /// Whether a field is stored: the flag that belongs to the wave vector with it, what is no output always.
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

/// How a map is made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub struct MapSettings {
    /// Refine only where the verdict changes.
    pub adaptive: bool,
    /// Coarsest stride of the refinement, in states; a power of two, at most `tile`.
    pub refine_from: usize,
    /// Prove what is stable and what is not.
    pub certify: bool,
    /// How far from the boundary a certified state may stay undecided; in the dimensionless measure of stability.
    pub tolerance: f64,
    /// States along an edge of a tile.
    pub tile: usize,
    /// The integrator whose critical time step is stored.
    pub integrator: Integrator,
    /// The numbers that are stored, beside verdict and stability.
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
            integrator: Integrator::CentralDifferences,
            outputs: Outputs([true; OUTPUTS.len()]),
        }
    }
}

impl MapSettings {
    /// Sets the value under a name; tells whether there is one that takes such a value.
    pub fn set(&mut self, name: &str, value: &Value) -> bool {
        match (name, value) {
            ("adaptive", Value::Switch(on)) => self.adaptive = *on,
            ("refine-from", Value::Number(number)) => self.refine_from = *number as usize,
            ("certify", Value::Switch(on)) => self.certify = *on,
            ("tolerance", Value::Number(number)) => self.tolerance = *number,
            ("tile", Value::Number(number)) => self.tile = *number as usize,
            ("integrator", value) => match value.word() {
                Some(integrator) => self.integrator = integrator,
                None => return false,
            },
            ("outputs", Value::Words(names)) => match Outputs::of(names) {
                Some(outputs) => self.outputs = outputs,
                None => return false,
            },
            _ => return false,
        }
        true
    }
}
