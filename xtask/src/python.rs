//! Python environments for tasks that need them.

use std::path::{Path, PathBuf};
use std::process::Command;

/// File in an environment with the requirements of the last installation.
const INSTALLED: &str = "installed-requirements.txt";

/// Interpreter of the environment `.venv/<name>`, which is created if missing.
///
/// The packages of the requirements file are installed if the file has changed. The environment is created with `python3`, or with the interpreter in
/// the variable `PYTHON`.
///
/// # Errors
/// Description of the failure, if the requirements cannot be read or a command fails.
pub fn environment(name: &str, requirements: &Path) -> Result<PathBuf, String> {
    let wanted = std::fs::read_to_string(requirements)
        .map_err(|error| format!("cannot read {}: {error}", requirements.display()))?;
    let current = std::env::current_dir()
        .map_err(|error| format!("cannot determine the current folder: {error}"))?;
    let folder = current.join(".venv").join(name);
    let interpreter = interpreter_in(&folder);
    let installed = folder.join(INSTALLED);
    // This file is written last, so that an incomplete environment is created again.
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

/// Interpreter of the environment `.venv/<name>`, if the environment exists.
pub fn interpreter(name: &str) -> Option<PathBuf> {
    let folder = std::path::absolute(Path::new(".venv").join(name)).ok()?;
    Some(interpreter_in(&folder)).filter(|path| path.exists())
}

fn interpreter_in(folder: &Path) -> PathBuf {
    if cfg!(windows) {
        folder.join("Scripts").join("python.exe")
    } else {
        folder.join("bin").join("python")
    }
}

/// Runs a command and waits for its end.
///
/// # Errors
/// Description of the failure to run it, or its exit status.
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
