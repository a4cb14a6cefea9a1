//! The `onset` command: stability of a material and its particle discretization.
//!
//! It converts arguments to a problem and prints the answer. Exit codes:
//!
//! - 0: done.
//! - 1: a claim of the paper differs from its record, a strict audit has findings, a particle code or a motion differs, a motion breaks down, or
//!   a file cannot be written.
//! - 2: the input is wrong.
//! - 3: a verdict is one of `--fail-on`, or the agreement of a particle code or a motion is undecided.
//! - 130: interrupted.

mod arguments;
mod commands;
mod complete;
mod drawing;
#[cfg(feature = "explore")]
mod explore;
mod fail_on;
mod help;
mod interrupt;
mod map;
#[cfg(unix)]
mod memory;
mod patience;
mod printing;
mod threads;

use onset_study::settings::notes_on_settings;
use std::process::ExitCode;

fn main() -> ExitCode {
    // User materials run in a child process of this same program.
    if let Some(code) = onset_umat::serve_if_asked() {
        return code;
    }
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    threads::fit_into_memory();
    let arguments = help::parse();
    printing::begin(arguments.printing);
    if let Err(error) = interrupt::listen() {
        printing::tell(format_args!("error: cannot listen for interrupts: {error}"));
        return ExitCode::from(1);
    }
    let ready = threads::check();
    #[cfg(unix)]
    let ready = ready.and_then(|()| threads::start());
    let outcome = ready.and_then(|()| commands::run(arguments));
    for note in notes_on_settings() {
        printing::tell(format_args!("note: {note}"));
    }
    let ended = match outcome {
        Ok(code) => code,
        Err(failure) => {
            printing::tell(format_args!("error: {}", failure.message));
            ExitCode::from(failure.code)
        }
    };
    printing::end();
    ended
}
