//! Prose of docs, comments, messages and pages, checked against patterns that read wrong.

use crate::python::{environment, succeed};
use std::path::Path;
use std::process::Command;

/// Lists the places in the given files or folders; without any, fails if a file has more places than it is granted.
///
/// # Errors
/// Description of the failure.
pub fn check(names: &[String]) -> Result<(), String> {
    eprintln!("== prose");
    let requirements = Path::new("crates/onset-cli/tests/python/requirements.txt");
    let interpreter = environment("test", requirements)?;
    succeed(
        Command::new(interpreter)
            .arg("xtask/english/check.py")
            .args(names),
    )
}
