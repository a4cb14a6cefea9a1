//! Prose of docs, comments, messages and pages: patterns that read wrong, broken links of pages, and spelling.

use crate::python::{environment, succeed};
use std::path::Path;
use std::process::Command;

/// Requirements with the spelling checker, whose words are in `typos.toml`.
const REQUIREMENTS: &str = "xtask/english/requirements.txt";

/// Lists the places in the given files or folders. Without any, fails if a file has more places than `allowed.txt` grants, a broken link or a misspelled
/// word.
///
/// # Errors
/// Description of the failure.
pub fn check(names: &[String]) -> Result<(), String> {
    eprintln!("== prose, links and spelling");
    let interpreter = environment("english", Path::new(REQUIREMENTS))?;
    let script = |name: &str| {
        let mut command = Command::new(&interpreter);
        command.arg(format!("xtask/english/{name}.py"));
        command
    };
    succeed(script("check").args(names))?;
    if !names.is_empty() {
        return Ok(());
    }
    succeed(&mut script("links"))?;
    let typos = format!("typos{}", std::env::consts::EXE_SUFFIX);
    succeed(Command::new(interpreter.with_file_name(typos)).args(["--format", "brief"]))
}
