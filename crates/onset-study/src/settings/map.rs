//! How a map is made.

use super::Value;
use serde::Serialize;

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
}

impl Default for MapSettings {
    fn default() -> Self {
        Self {
            adaptive: false,
            refine_from: 16,
            certify: false,
            tolerance: 1e-3,
            tile: 64,
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
            _ => return false,
        }
        true
    }
}
