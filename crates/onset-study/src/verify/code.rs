//! Description of a particle code: dialect, time integration, decks and output.

use super::{Case, Projector, Record, VerifyError};
use crate::answers::Problem;
use crate::output::Files;
use onset::kinematics::DeformationGradient;
use onset::time_step::Stepping;
use serde::Serialize;
use std::path::Path;

/// Choice that a code fixes: a key of the settings with its value, and the deviation from the published method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Settled {
    /// Key of the settings.
    pub key: &'static str,
    /// Value of the key.
    pub value: &'static str,
    /// Deviation from the publication, or an empty string.
    pub deviation: &'static str,
}

impl Settled {
    /// Choice without a deviation from the publication.
    pub const fn exactly(key: &'static str, value: &'static str) -> Self {
        Self::deviating(key, value, "")
    }

    /// Choice with a deviation from the publication.
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

/// Program that runs decks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Program {
    /// Usual name of the executable.
    pub name: &'static str,
    /// Command-line arguments, relative to the folder of the deck.
    pub arguments: &'static [&'static str],
    /// Instructions for installing the program.
    pub install: &'static str,
}

/// Case, problem and state, the input of a deck.
pub struct Deck<'a> {
    /// Case whose deck is written.
    pub case: &'a Case,
    /// Material and method of the case.
    pub problem: &'a Problem,
    /// Deformation gradient of the homogeneous state.
    pub f: &'a DeformationGradient,
}

/// Particle code whose waves can be verified.
pub trait Code: Sync {
    /// Name of the code on the command line.
    fn name(&self) -> &'static str;

    /// Title of the code in a few words.
    fn title(&self) -> &'static str;

    /// Choices that the code fixes.
    fn dialect(&self) -> &'static [Settled];

    /// Other deviations from the expected behavior, one sentence each.
    fn remarks(&self) -> &'static [&'static str];

    /// Returns true if blocks are periodic.
    ///
    /// If not, the rim of a block is held, and the core is measured before waves from the rim arrive.
    fn is_periodic(&self) -> bool;

    /// Width of the rim of a block, in units of the interaction range at the state; `None` for a periodic block.
    ///
    /// # Errors
    /// [`VerifyError::Refused`] for a problem beyond the capabilities of the code.
    fn rim(
        &self,
        _problem: &Problem,
        _f: &DeformationGradient,
    ) -> Result<Option<f64>, VerifyError> {
        Ok((!self.is_periodic()).then_some(1.0))
    }

    /// Largest relative difference of the rates that counts as agreement.
    fn tolerance(&self) -> f64;

    /// Time integration of the code for a material at a state.
    ///
    /// # Errors
    /// [`VerifyError::Refused`] for a problem beyond the capabilities of the code.
    fn stepping(&self, problem: &Problem, f: &DeformationGradient)
    -> Result<Stepping, VerifyError>;

    /// Files of a deck, without the case file.
    ///
    /// # Errors
    /// [`VerifyError::Refused`] for a problem beyond the capabilities of the code.
    fn deck(&self, deck: &Deck<'_>) -> Result<Files, VerifyError>;

    /// Program that runs the deck, or `None` if only the user knows it.
    fn program(&self) -> Option<Program>;

    /// Name of the output file.
    fn output(&self) -> &'static str;

    /// Reads an output and projects it on the wave.
    ///
    /// # Errors
    /// [`VerifyError::Output`] for an output that does not belong to the case.
    fn read(
        &self,
        path: &Path,
        text: &str,
        projector: Projector<'_>,
    ) -> Result<Record, VerifyError>;
}
