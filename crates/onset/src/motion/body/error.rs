//! What is wrong with a body, and where its motion ends.

use crate::method::MethodError;
use thiserror::Error;

/// Why there is no body.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BodyError {
    /// The method or the law.
    #[error(transparent)]
    Method(#[from] MethodError),
    /// The method has no bodies.
    #[error("this method has no bodies")]
    NoBodies,
    /// A contact that would have no effect, or no stiffness: why.
    #[error("there is no contact: {0}")]
    NoContact(&'static str),
    /// A shape without particles.
    #[error("the body has no particles")]
    Empty,
    /// More particles than the engine numbers.
    #[error("the body would have {particles} particles; at most {limit} are run")]
    TooMany {
        /// How many there would be.
        particles: usize,
        /// How many there may be.
        limit: usize,
    },
    /// A number of a shape, a particle or a grip is not what it must be.
    #[error("{what} is {value:?}; expected {expected}")]
    Number {
        /// Which, in words.
        what: String,
        /// Its value.
        value: f64,
        /// What is admitted, in words.
        expected: &'static str,
    },
    /// Two particles at one place.
    #[error("particles {first} and {second} are both at {position:?}")]
    Coincident {
        /// The number of one.
        first: usize,
        /// That of the other.
        second: usize,
        /// Where they are; length.
        position: Vec<f64>,
    },
    /// A particle whose neighbors do not determine a deformation gradient.
    #[error(
        "particle {particle} at {position:?} has {neighbors} neighbor(s), which do not determine its deformation gradient"
    )]
    Lonely {
        /// Its number.
        particle: usize,
        /// Where it is; length.
        position: Vec<f64>,
        /// How many neighbors it has.
        neighbors: usize,
    },
    /// A grip that holds nothing.
    #[error("grip {grip} holds no particle: none is between {low:?} and {high:?}")]
    EmptyGrip {
        /// Which, counted from 1.
        grip: usize,
        /// The lower corner of its box; length.
        low: Vec<f64>,
        /// The upper one.
        high: Vec<f64>,
    },
    /// A particle in two grips.
    #[error("particle {particle} at {position:?} is in the grips {first} and {second}")]
    HeldTwice {
        /// Its number.
        particle: usize,
        /// Where it is; length.
        position: Vec<f64>,
        /// One grip, counted from 1.
        first: usize,
        /// The other one.
        second: usize,
    },
}

/// The particle at which the motion ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Lost {
    /// About it there is no stress.
    Strained(usize),
    /// It is about to pass through one of another piece.
    Passing(usize),
}
