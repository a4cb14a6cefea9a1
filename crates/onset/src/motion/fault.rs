//! Why a motion ends.

use crate::kinematics::DeformationGradient;
use crate::material::Hyperelastic;
use crate::method::MethodError;
use std::fmt;
use thiserror::Error;

/// A motion that cannot go on: when, which particle, and where that is.
#[derive(Clone, Debug, Error, PartialEq)]
pub struct Fault {
    /// Time.
    pub time: f64,
    /// Steps that were taken.
    pub step: u64,
    /// The number of the particle.
    pub particle: usize,
    /// Where it is in the reference state; length.
    pub position: Vec<f64>,
    /// How far it has moved from the homogeneous state; length.
    pub displacement: Vec<f64>,
    /// Its velocity; length/time.
    pub velocity: Vec<f64>,
    /// Of the points that see it the deformation gradient with the smallest determinant, rows one after the other.
    pub deformation: Vec<f64>,
    /// Why.
    pub ground: Ground,
}

/// Why a motion cannot go on.
#[derive(Clone, Debug, PartialEq)]
pub enum Ground {
    /// The material is turned inside out: the determinant of a deformation gradient is not positive.
    Inverted,
    /// There is no stress about it, and the law does not say why.
    OutsideDomain,
    /// It is nearer than half a spacing to a particle of another piece: it would pass through.
    Overlapping,
    /// The method has no forces there, or the law no stress.
    Method(MethodError),
    /// A number beyond all numbers, or none.
    NotFinite,
}

impl Ground {
    /// Why there is no stress at a deformation gradient.
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
            Ground::Inverted => "the material about it is inverted".to_owned(),
            Ground::OutsideDomain => "the law is not defined there".to_owned(),
            Ground::Overlapping => {
                "it is nearer than half a spacing to a particle of another piece, and would pass through it: the contact is too soft, or the pieces meet too fast".to_owned()
            }
            Ground::Method(error) => error.to_string(),
            Ground::NotFinite => "its motion is beyond all numbers".to_owned(),
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
