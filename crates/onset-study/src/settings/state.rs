//! Deformation of a state: stretches, shear, and the angle of the lattice relative to the load.

use super::Value;
use onset::kinematics::{DeformationGradient, KinematicsError};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

/// Deformation given by stretches, shear and rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StateSettings {
    /// Stretches along the two axes of the plane, and out of it.
    pub stretches: [f64; 3],
    /// Amount of shear in the plane.
    pub shear: f64,
    /// Angle of the lattice relative to the load; radians.
    pub rotation: f64,
}

impl Default for StateSettings {
    fn default() -> Self {
        Self {
            stretches: [1.0; 3],
            shear: 0.0,
            rotation: 0.0,
        }
    }
}

/// Serializes the values under the names of the keys.
impl Serialize for StateSettings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(5))?;
        for name in ["stretch-1", "stretch-2", "stretch-3", "shear", "rotation"] {
            map.serialize_entry(name, &self.value(name))?;
        }
        map.end()
    }
}

impl StateSettings {
    fn target(&mut self, name: &str) -> Option<&mut f64> {
        match name {
            "stretch-1" => Some(&mut self.stretches[0]),
            "stretch-2" => Some(&mut self.stretches[1]),
            "stretch-3" => Some(&mut self.stretches[2]),
            "shear" => Some(&mut self.shear),
            "rotation" => Some(&mut self.rotation),
            _ => None,
        }
    }

    /// Returns the value under a name; `None` if the name is unknown.
    pub fn value(&self, name: &str) -> Option<f64> {
        let mut copy = *self;
        copy.target(name).copied()
    }

    /// Sets the value under a name; returns false if the name is unknown or the value is not a number.
    pub fn set(&mut self, name: &str, value: &Value) -> bool {
        match (self.target(name), value) {
            (Some(target), Value::Number(number)) => {
                *target = *number;
                true
            }
            _ => false,
        }
    }

    /// Returns the deformation gradient `F = R^T U R`. Dimensionless.
    ///
    /// In the plane `U = [[1, shear], [0, 1]] diag(stretch-1, stretch-2)`, out of it `stretch-3`. `R` is the rotation by the angle of the lattice
    /// relative to the load.
    ///
    /// # Errors
    /// [`KinematicsError`] when a stretch is not positive, or the deformation is too extreme.
    pub fn deformation(&self) -> Result<DeformationGradient, KinematicsError> {
        let [first, second, third] = self.stretches;
        // Checks the stretches one by one; exact without shear and rotation.
        let stretched = DeformationGradient::from_stretches(self.stretches)?;
        if self.shear == 0.0 && self.rotation == 0.0 {
            return Ok(stretched);
        }
        let u = [[first, self.shear * second], [0.0, second]];
        let (sine, cosine) = self.rotation.sin_cos();
        let r = [[cosine, -sine], [sine, cosine]];
        let turned = |i: usize, j: usize| {
            let term = |m: usize, n: usize| r[m][i] * u[m][n] * r[n][j];
            term(0, 0) + term(0, 1) + term(1, 0) + term(1, 1)
        };
        let plane = [[turned(0, 0), turned(0, 1)], [turned(1, 0), turned(1, 1)]];
        DeformationGradient::plane_strain(plane, third)
    }
}

#[cfg(test)]
mod tests {
    use super::StateSettings;
    use onset::kinematics::DeformationGradient;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};

    fn components(state: StateSettings) -> [[f64; 3]; 3] {
        *state.deformation().expect("admissible").components()
    }

    #[test]
    fn rotating_the_lattice_by_90_degrees_exchanges_the_stretches() {
        let state = StateSettings {
            stretches: [1.3, 0.8, 1.1],
            rotation: FRAC_PI_2,
            ..StateSettings::default()
        };
        let (turned, expected) = (components(state), [0.8, 1.3, 1.1]);
        for i in 0..3 {
            for j in 0..3 {
                let expected = if i == j { expected[i] } else { 0.0 };
                assert!((turned[i][j] - expected).abs() < 1e-15, "{turned:?}");
            }
        }
    }

    #[test]
    fn rotating_the_lattice_changes_neither_volume_nor_principal_stretches() {
        let state = StateSettings {
            stretches: [1.3, 0.8, 1.1],
            shear: 0.4,
            rotation: 0.0,
        };
        let turned = StateSettings {
            rotation: FRAC_PI_3,
            ..state
        };
        let (a, b) = (components(state), components(turned));
        assert_eq!(a, [[1.3, 0.4 * 0.8, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 1.1]]);
        assert!((a[0][0] - b[0][0]).abs() > 0.1);
        let (a, b) = (state.deformation(), turned.deformation());
        let (a, b) = (a.expect("admissible"), b.expect("admissible"));
        assert!((a.jacobian() - b.jacobian()).abs() < 1e-15);
        for (a, b) in a.principal_stretches().iter().zip(b.principal_stretches()) {
            assert!((a - b).abs() < 1e-14);
        }
        // `R^T U R`: a load along the first axis of the lattice, rotated by the angle.
        let pulled = StateSettings {
            stretches: [2.0, 1.0, 1.0],
            rotation: FRAC_PI_3,
            ..StateSettings::default()
        };
        let (c, s) = (0.5, 0.75_f64.sqrt());
        let f = components(pulled);
        assert!((f[0][0] - (1.0 + c * c)).abs() < 1e-15);
        assert!((f[0][1] + c * s).abs() < 1e-15, "{f:?}");
    }

    #[test]
    fn stretches_are_exact_without_shear_and_rotation() {
        let state = StateSettings {
            stretches: [0.1, 0.3, 0.7],
            ..StateSettings::default()
        };
        let exact = DeformationGradient::from_stretches([0.1, 0.3, 0.7]);
        assert_eq!(state.deformation(), exact);
    }
}
