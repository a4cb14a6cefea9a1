//! What is known of a particle code.

use super::{Case, Projector, Record, VerifyError};
use crate::answers::Problem;
use crate::output::Files;
use onset::kinematics::DeformationGradient;
use onset::time_step::Stepping;
use serde::Serialize;
use std::path::Path;

/// A choice that a code has made: a key of the settings with its value, and how it deviates from what was published.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Settled {
    /// The key.
    pub key: &'static str,
    /// Its value.
    pub value: &'static str,
    /// The deviation; empty where there is none.
    pub deviation: &'static str,
}

impl Settled {
    /// As it was published.
    pub const fn exactly(key: &'static str, value: &'static str) -> Self {
        Self::deviating(key, value, "")
    }

    /// With a deviation.
    pub const fn deviating(
        key: &'static str,
        value: &'static str,
        deviation: &'static str,
    ) -> Self {
        Self {
            key,
            value,
            deviation,
        }
    }
}

/// A program that runs decks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Program {
    /// Its usual name.
    pub name: &'static str,
    /// Its arguments, in the folder of the deck.
    pub arguments: &'static [&'static str],
    /// How it is installed.
    pub install: &'static str,
}

/// A case with what it was made of, as decks need it.
pub struct Deck<'a> {
    /// The case.
    pub case: &'a Case,
    /// Material and method.
    pub problem: &'a Problem,
    /// The state.
    pub f: &'a DeformationGradient,
}

/// A particle code.
pub trait Code: Sync {
    /// The word on the command line.
    fn name(&self) -> &'static str;

    /// What it is, in a few words.
    fn title(&self) -> &'static str;

    /// Its dialect.
    fn dialect(&self) -> &'static [Settled];

    /// What else deviates from what one would expect of it, a sentence each.
    fn remarks(&self) -> &'static [&'static str];

    /// Whether blocks are periodic; otherwise their rims are held, and they are read in their cores before waves from the rims arrive.
    fn is_periodic(&self) -> bool;

    /// How wide the rim of the block of a material at a state is, in distances that particles see each other from; none of a periodic block.
    ///
    /// # Errors
    /// [`VerifyError::Refused`] for what the code cannot compute.
    fn rim(
        &self,
        _problem: &Problem,
        _f: &DeformationGradient,
    ) -> Result<Option<f64>, VerifyError> {
        Ok((!self.is_periodic()).then_some(1.0))
    }

    /// What relative difference of the rates counts as agreement.
    fn tolerance(&self) -> f64;

    /// How it takes a time step with a material at a state.
    ///
    /// # Errors
    /// [`VerifyError::Refused`] for what the code cannot compute.
    fn stepping(&self, problem: &Problem, f: &DeformationGradient)
    -> Result<Stepping, VerifyError>;

    /// The files of a deck, without the case.
    ///
    /// # Errors
    /// [`VerifyError::Refused`] for what the code cannot compute.
    fn deck(&self, deck: &Deck<'_>) -> Result<Files, VerifyError>;

    /// What runs the deck; `None` where only the user knows.
    fn program(&self) -> Option<Program>;

    /// The output that is read.
    fn output(&self) -> &'static str;

    /// Reads an output.
    ///
    /// # Errors
    /// [`VerifyError::Output`] for one that is not of the case.
    fn read(
        &self,
        path: &Path,
        text: &str,
        projector: Projector<'_>,
    ) -> Result<Record, VerifyError>;
}
