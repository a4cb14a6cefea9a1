//! The Python package: its wheel, and its tests with the wheel installed.

use crate::python::{environment, succeed};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

/// What makes wheels.
const MAKING: &str = "python/requirements-wheel.txt";
/// What the tests need beside the wheel.
const TESTING: &str = "python/tests/requirements.txt";

/// Makes the wheel of a release in `target/wheels`, and says where it is and how large.
///
/// # Errors
/// What failed, in words.
pub fn run() -> Result<(), String> {
    let wheel = made("wheel", "target/wheels")?;
    let size = std::fs::metadata(&wheel).map_err(|error| error.to_string())?;
    println!(
        "{}: {:.1} MB",
        wheel.display(),
        size.len() as f64 / 1_000_000.0
    );
    Ok(())
}

/// Makes a wheel in the profile of the tests, which share its target folder, installs it into an environment of its own, and runs
/// the tests of the package there, with the command beside it.
///
/// # Errors
/// What failed, in words.
pub fn test() -> Result<(), String> {
    let wheel = made("dev", "target/wheels-dev")?;
    let command = command()?;
    let interpreter = environment("python", Path::new(TESTING))?;
    succeed(
        Command::new(&interpreter)
            .args([
                "-m",
                "pip",
                "install",
                "--quiet",
                "--no-deps",
                "--force-reinstall",
            ])
            .arg(&wheel),
    )?;
    eprintln!("== Python: pytest");
    succeed(
        Command::new(&interpreter)
            .args(["-m", "pytest", "-q", "-p", "no:cacheprovider"])
            // Not in the folder of the package, which is found there without its compiled part.
            .current_dir("python/tests")
            .env("ONSET_COMMAND", &command)
            .env("ONSET_UMAT_HOST", &command),
    )
}

/// The command in the profile of the tests, built together with what the wheel has: one build of what both stand on.
///
/// # Errors
/// What failed, in words.
pub fn command() -> Result<PathBuf, String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let both = ["build", "--package", "onset-cli", "--package", "onset-py"];
    succeed(Command::new(cargo).args(both))?;
    let command = Path::new("target/debug").join(format!("onset{}", std::env::consts::EXE_SUFFIX));
    std::path::absolute(command).map_err(|error| error.to_string())
}

/// Makes a wheel in a profile into a folder; where it is.
fn made(profile: &str, folder: &str) -> Result<PathBuf, String> {
    let interpreter = environment("wheel", Path::new(MAKING))?;
    let since = SystemTime::now();
    succeed(
        Command::new(&interpreter)
            .args(["-m", "maturin", "build", "--profile", profile, "--out"])
            .arg(std::path::absolute(folder).map_err(|error| error.to_string())?)
            .arg("--interpreter")
            .arg(&interpreter)
            .current_dir("python"),
    )?;
    newest(folder, since)
}

/// The wheel in a folder that was made last.
fn newest(folder: &str, since: SystemTime) -> Result<PathBuf, String> {
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{folder}: {error}"))?;
    let wheels = entries.filter_map(|entry| {
        let path = entry.ok()?.path();
        let is_wheel = path.extension().is_some_and(|extension| extension == "whl");
        let made = path.metadata().and_then(|file| file.modified()).ok()?;
        is_wheel.then_some((made, path))
    });
    let newest = wheels.max_by_key(|(made, _)| *made);
    newest
        .filter(|(made, _)| *made >= since)
        .map(|(_, path)| path)
        .ok_or_else(|| format!("no wheel was made in {folder}"))
}
