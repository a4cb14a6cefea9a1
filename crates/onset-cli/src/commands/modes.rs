//! `onset modes`: zero-energy and weakly controlled modes.

use super::{Failure, with_files};
use crate::arguments::ModesArguments;
use crate::printing::print;
use onset_study::modes::{ModesAnswer, ModesQuestion};
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
    let place = arguments.out.as_deref();
    let output = arguments.drawing.output(place, "modes", &["modes.html"])?;
    let answer = ModesAnswer::new(&settings, &question)?;
    let written = match output {
        Some(output) => output.write(&answer.files())?,
        None => Vec::new(),
    };
    let text = with_files(&arguments.detail.text(&answer), &written);
    print(&answer, &text, || answer.csv())
}
