//! Packages of npm for tasks that need them.

use crate::python::succeed;
use std::path::Path;
use std::process::Command;

/// Name of the npm executable.
const NPM: &str = if cfg!(windows) { "npm.cmd" } else { "npm" };

/// Installs the packages of the lock file in a folder, unless it is unchanged since the last installation.
///
/// # Errors
/// Description of the missing tool.
pub fn packages(folder: &Path) -> Result<(), String> {
    let found = Command::new(NPM).arg("--version").output();
    if !found.is_ok_and(|output| output.status.success()) {
        return Err("npm, which comes with Node.js, is not there".to_owned());
    }
    let lock = folder.join("package-lock.json");
    let wanted = std::fs::read(&lock).map_err(|error| format!("{}: {error}", lock.display()))?;
    let mark = folder.join("node_modules/installed-lock.json");
    if std::fs::read(&mark).is_ok_and(|installed| installed == wanted) {
        return Ok(());
    }
    eprintln!("== {}: npm ci", folder.display());
    succeed(&mut npm(folder, &["ci", "--no-audit", "--no-fund"]))?;
    std::fs::write(&mark, wanted).map_err(|error| format!("{}: {error}", mark.display()))
}

/// Command that runs npm in a folder.
pub fn npm(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(NPM);
    command.args(arguments).current_dir(folder);
    command
}
