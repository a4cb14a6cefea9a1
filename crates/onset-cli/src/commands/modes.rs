//! `onset modes`: zero-energy and weakly controlled modes.

use super::{Failure, with_files};
use crate::arguments::ModesArguments;
use crate::printing::print;
use onset_study::modes::{ModesAnswer, ModesQuestion};
use onset_study::output::Output;
use std::process::ExitCode;

/// Computes the spurious modes of a method.
pub fn modes(arguments: &ModesArguments) -> Result<ExitCode, Failure> {
    let settings = arguments.problem.settings()?;
    let question = ModesQuestion {
        weak: arguments.weak.share,
        cells: usize::from(arguments.cells),
        amplitude: arguments.amplitude,
        is_exported: arguments.out.is_some(),
    };
    let output = arguments.out.as_deref();
    let names = ["modes.svg", "modes.png", "modes.html"];
    let output = output.map(|out| Output::at(out, &names)).transpose()?;
    let answer = ModesAnswer::new(&settings, &question)?;
    let written = match output {
        Some(output) => output.write(&answer.files().map_err(Failure::machine)?)?,
        None => Vec::new(),
    };
    print(&answer, &with_files(&answer, &written), None)
}
