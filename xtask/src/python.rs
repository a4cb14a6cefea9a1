//! Python environments for the tasks that need one.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The file in an environment that holds the requirements that were installed last.
const INSTALLED: &str = "installed-requirements.txt";

/// The interpreter of the environment `.venv/<name>`, made when it does not exist, with the packages of a
/// requirements file, which are installed only when the file has changed since.
///
/// The interpreter that makes the environment is `python3`, or the one that the variable `PYTHON` names.
///
/// # Errors
/// What failed, in words, when the requirements cannot be read or a command does not succeed.
pub fn environment(name: &str, requirements: &Path) -> Result<PathBuf, String> {
    let wanted = std::fs::read_to_string(requirements)
        .map_err(|error| format!("cannot read {}: {error}", requirements.display()))?;
    let current = std::env::current_dir()
        .map_err(|error| format!("cannot tell the current folder: {error}"))?;
    let folder = current.join(".venv").join(name);
    let interpreter = if cfg!(windows) {
        folder.join("Scripts").join("python.exe")
    } else {
        folder.join("bin").join("python")
    };
    let installed = folder.join(INSTALLED);
    // Written last: an environment that was left half made is made again.
    if interpreter.exists() && std::fs::read_to_string(&installed).is_ok_and(|text| text == wanted)
    {
        return Ok(interpreter);
    }
    let system = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    eprintln!("== Python environment: {}", folder.display());
    succeed(Command::new(&system).args(["-m", "venv"]).arg(&folder))?;
    succeed(
        Command::new(&interpreter)
            .args(["-m", "pip", "install", "--quiet", "--requirement"])
            .arg(requirements),
    )?;
    std::fs::write(&installed, wanted)
        .map_err(|error| format!("cannot write {}: {error}", installed.display()))?;
    Ok(interpreter)
}

/// Runs a command and waits for its end.
///
/// # Errors
/// That it cannot be run, or how it failed.
pub fn succeed(command: &mut Command) -> Result<(), String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let status = command
        .status()
        .map_err(|error| format!("cannot run {name}: {error}"))?;
    if status.success() {
        Ok(())
    } else {
        Err(format!("{name} failed: {status}"))
    }
}
