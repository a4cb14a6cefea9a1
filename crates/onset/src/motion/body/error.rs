//! Errors in the setup of a body, and the particle at which its motion ends.

use crate::method::MethodError;
use crate::real::plain;
use thiserror::Error;

/// Error in the setup of a body.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BodyError {
    /// The method or the law cannot be evaluated.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// The method does not support bodies.
    #[error("this method does not support bodies with free faces")]
    NoBodies,
    /// The forces on the particles have no tangent at arbitrary positions.
    #[error("this method has no tangent for particles at arbitrary positions")]
    NoTangent,
    /// The stress of a particle, its derivative or its deformation gradient is undefined.
    #[error(
        "particle {particle} at {position:?} has no stress: the law is undefined there, or its neighbors do not determine a deformation gradient"
    )]
    NoStress {
        /// Number of the particle.
        particle: usize,
        /// Position of the particle; length.
        position: Vec<f64>,
    },
    /// An element does not have the shape of the mesh of the method.
    #[error("element {element} has {nodes} nodes; the mesh of the method has elements of {needed}")]
    OtherElement {
        /// Number of the element.
        element: usize,
        /// Number of its nodes.
        nodes: usize,
        /// Number of nodes of an element of the method.
        needed: usize,
    },
    /// The tangent of the body takes too much memory or time.
    #[error("the tangent of a body of {particles} particles is too large")]
    TooLarge {
        /// Number of particles of the body.
        particles: usize,
    },
    /// The iteration for the lowest modes did not converge.
    #[error("the lowest modes do not converge")]
    NotConverged,
    /// The contact would have no effect or no stiffness; with the reason.
    #[error("body.contact cannot be used: {0}")]
    NoContact(&'static str),
    /// The shape contains no particles.
    #[error("the body has no particles")]
    Empty,
    /// The body has more particles than the engine supports.
    #[error("the body would have {particles} particles; at most {limit} are supported")]
    TooMany {
        /// Number of particles of the body.
        particles: usize,
        /// Largest number of particles.
        limit: usize,
    },
    /// A number of a shape, a particle, a contact or a grip is outside of its admissible range.
    #[error("{what} is {}; expected {expected}", plain(*value))]
    Number {
        /// Description of the number.
        what: String,
        /// Value given by the user.
        value: f64,
        /// Description of the admissible values.
        expected: &'static str,
    },
    /// Two particles have the same position.
    #[error("particles {first} and {second} are both at {position:?}")]
    Coincident {
        /// Number of the first particle.
        first: usize,
        /// Number of the second particle.
        second: usize,
        /// Common reference position; length.
        position: Vec<f64>,
    },
    /// The neighbors of a particle do not determine a deformation gradient.
    #[error(
        "particle {particle} at {position:?} has {neighbors} neighbor(s), which do not determine its deformation gradient"
    )]
    Lonely {
        /// Number of the particle.
        particle: usize,
        /// Reference position of the particle; length.
        position: Vec<f64>,
        /// Number of its neighbors.
        neighbors: usize,
    },
    /// A grip holds no particle.
    #[error("grip {grip} holds no particle: its box from {low:?} to {high:?} is empty")]
    EmptyGrip {
        /// Number of the grip, from 1.
        grip: usize,
        /// Lower corner of the box of the grip; length.
        low: Vec<f64>,
        /// Upper corner of the box; length.
        high: Vec<f64>,
    },
    /// A particle lies in two grips.
    #[error("particle {particle} at {position:?} is in the grips {first} and {second}")]
    HeldTwice {
        /// Number of the particle.
        particle: usize,
        /// Reference position of the particle; length.
        position: Vec<f64>,
        /// Number of one grip, from 1.
        first: usize,
        /// Number of the other grip, from 1.
        second: usize,
    },
}

/// Particle at which the motion ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Lost {
    /// The stress at this particle is undefined.
    Strained(usize),
    /// This particle is about to pass through a particle of another piece.
    Passing(usize),
}
