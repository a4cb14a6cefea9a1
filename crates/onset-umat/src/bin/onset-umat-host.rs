//! Program that runs UMATs without the rest of `onset`, for programs that use the crate but cannot run them themselves.
//!
//! The variable `ONSET_UMAT_HOST` selects this program.

use std::process::ExitCode;

fn main() -> ExitCode {
    onset_umat::serve_if_asked().unwrap_or_else(|| {
        eprintln!("error: this program is started by onset, to run a UMAT");
        ExitCode::from(2)
    })
}
