//! `onset modes`: waves that a method does not resist.

use super::{Failure, named, print_json, print_text};
use crate::arguments::ModesArguments;
use onset_study::modes::{ModesAnswer, ModesQuestion};
use onset_study::output::Output;
use std::process::ExitCode;

/// The spurious modes of a method.
pub fn modes(arguments: &ModesArguments) -> Result<ExitCode, Failure> {
    let settings = arguments.problem.settings()?;
    let question = ModesQuestion {
        weak: arguments.weak,
        cells: usize::from(arguments.cells),
        amplitude: arguments.amplitude,
    };
    let output = arguments.out.as_deref();
    let names = ["modes.svg", "modes.png", "modes.html"];
    let output = output.map(|out| Output::at(out, &names)).transpose()?;
    let answer = ModesAnswer::new(&settings, &question)?;
    let written = match output {
        Some(output) => named(&output.write(&answer.files().map_err(Failure::machine)?)?),
        None => Vec::new(),
    };
    if arguments.problem.json {
        return print_json(&answer);
    }
    let mut text = answer.to_string();
    if let [first, .., last] = &written[..] {
        text.push_str(&format!(
            "\nwrote {} files, {first} to {last}",
            written.len()
        ));
    }
    print_text(text.trim_end())
}
