//! Licences, sources and advisories of all crates that are linked: `cargo deny`, by the rules in `deny.toml`.

use crate::python::{environment, succeed};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The package of the tool, where it is not installed.
const PACKAGE: &str = "xtask/deny.txt";

/// Sees to the tool: that of the system, or one in an environment.
///
/// # Errors
/// What cannot be had, in words.
pub fn tool() -> Result<PathBuf, String> {
    let own = Command::new("cargo-deny").arg("--version").output();
    if own.is_ok_and(|output| output.status.success()) {
        return Ok(PathBuf::from("cargo-deny"));
    }
    let interpreter = environment("deny", Path::new(PACKAGE))?;
    let name = format!("cargo-deny{}", std::env::consts::EXE_SUFFIX);
    Ok(interpreter.with_file_name(name))
}

/// Checks what needs no network: licences, sources, versions and bans.
///
/// # Errors
/// What failed, in words.
pub fn check(tool: &Path) -> Result<(), String> {
    eprintln!("== dependencies: cargo deny");
    checked(tool, &["licenses", "sources", "bans"])
}

/// Checks the advisories of the database on this machine; `None` if `cargo deny fetch` has not fetched one.
pub fn advisories(tool: &Path) -> Option<Result<(), String>> {
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| Some(std::env::home_dir()?.join(".cargo")))?;
    let mut databases = std::fs::read_dir(home.join("advisory-dbs")).ok()?.flatten();
    databases.find(|entry| entry.path().join("crates").is_dir())?;
    Some(checked(tool, &["advisories"]))
}

fn checked(tool: &Path, what: &[&str]) -> Result<(), String> {
    let settings = [
        "--offline",
        "--all-features",
        "--log-level",
        "error",
        "check",
    ];
    succeed(Command::new(tool).args(settings).args(what))
}
