//! Errors that end a motion.

use crate::kinematics::DeformationGradient;
use crate::material::Hyperelastic;
use crate::method::MethodError;
use std::fmt;
use thiserror::Error;

/// End of a motion: the time, the particle and its state.
#[derive(Clone, Debug, Error, PartialEq)]
pub struct Fault {
    /// Time at which the motion ends.
    pub time: f64,
    /// Number of steps taken.
    pub step: u64,
    /// Number of the particle.
    pub particle: usize,
    /// Position of the particle in the reference configuration; length.
    pub position: Vec<f64>,
    /// Displacement of the particle from the homogeneous state; length.
    pub displacement: Vec<f64>,
    /// Velocity of the particle; length/time.
    pub velocity: Vec<f64>,
    /// Deformation gradient with the smallest determinant among the points around the particle, row by row.
    pub deformation: Vec<f64>,
    /// Reason for the end of the motion.
    pub ground: Ground,
}

/// Reason why a motion ends.
#[derive(Clone, Debug, PartialEq)]
pub enum Ground {
    /// The material is inverted: the determinant of a deformation gradient is not positive.
    Inverted,
    /// The stress is undefined, and the law gives no further reason.
    OutsideDomain,
    /// The particle is closer than half a spacing to a particle of another piece and would pass through it.
    Overlapping,
    /// The method has no forces in the state, or the law has no stress.
    Method(MethodError),
    /// A number is infinite or NaN.
    NotFinite,
}

impl Ground {
    /// Returns the reason why the stress is undefined at a deformation gradient.
    pub(crate) fn without_stress(material: &dyn Hyperelastic, f: &DeformationGradient) -> Self {
        match material.response(f) {
            _ if f.determinant() <= 0.0 => Self::Inverted,
            Err(error) => Self::Method(error.into()),
            Ok(_) => Self::OutsideDomain,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match &self.ground {
            Ground::Inverted => "the material around it is inverted".to_owned(),
            Ground::OutsideDomain => "the law is not defined there".to_owned(),
            Ground::Overlapping => {
                "it is closer than half a spacing to a particle of another piece and would pass through it: the contact is too soft, or the pieces approach too fast".to_owned()
            }
            Ground::Method(error) => error.to_string(),
            Ground::NotFinite => "its motion is infinite or not a number".to_owned(),
        };
        write!(
            formatter,
            "the motion ends at time {:e}, after {} steps, at particle {}: {what}\n  reference position {:?}, displacement {:?}, velocity {:?}",
            self.time, self.step, self.particle, self.position, self.displacement, self.velocity
        )?;
        if !self.deformation.is_empty() {
            write!(formatter, "\n  deformation gradient {:?}", self.deformation)?;
        }
        Ok(())
    }
}
