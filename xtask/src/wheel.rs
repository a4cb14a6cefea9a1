//! The Python package: its wheel, and its tests with the wheel installed.

use crate::python::{environment, succeed};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

/// What makes wheels.
const MAKING: &str = "python/requirements-wheel.txt";
/// Interpreters without a global lock, where they are installed: the stable interface leaves them out, and each needs a wheel of its own.
const FREE_THREADED: [&str; 2] = ["python3.14t", "python3.15t"];
/// A wheel of a release is small; functions of the same instructions are one, where the linker of the toolchain can do that.
const SMALL: &[&str] = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    &[
        "--compression-level",
        "9",
        "--",
        "-C",
        "link-arg=-Wl,--icf=all",
    ]
} else {
    &["--compression-level", "9"]
};
/// What the tests need beside the wheel.
const TESTING: &str = "python/tests/requirements.txt";

/// Makes the wheels of a release in `target/wheels`, one for all interpreters with a global lock and one for each without, and says
/// where they are and how large.
///
/// # Errors
/// What failed, in words.
pub fn run() -> Result<(), String> {
    let unlocked = FREE_THREADED.into_iter().map(Path::new);
    let unlocked = unlocked.filter(|name| is_installed(name)).map(Some);
    for interpreter in std::iter::once(None).chain(unlocked) {
        let wheel = made("wheel", "target/wheels", interpreter)?;
        let making = environment("wheel", Path::new(MAKING))?;
        succeed(Command::new(making).arg("python/smaller.py").arg(&wheel))?;
        let size = std::fs::metadata(&wheel).map_err(|error| error.to_string())?;
        println!(
            "{}: {:.1} MB",
            wheel.display(),
            size.len() as f64 / 1_000_000.0
        );
    }
    Ok(())
}

/// Whether an interpreter can be run.
fn is_installed(interpreter: &Path) -> bool {
    Command::new(interpreter)
        .arg("--version")
        .output()
        .is_ok_and(|output| output.status.success())
}

/// Makes a wheel in the profile of the tests, which share its target folder, installs it into an environment of its own, and runs
/// the tests of the package there, with the command beside it.
///
/// # Errors
/// What failed, in words.
pub fn test() -> Result<(), String> {
    let [_, interpreter] = environments()?;
    let wheel = made("dev", "target/wheels-dev", None)?;
    let command = command()?;
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
            .args(["--numprocesses", "auto"])
            // Not in the folder of the package, which is found there without its compiled part.
            .current_dir("python/tests")
            .env("ONSET_COMMAND", &command)
            .env("ONSET_UMAT_HOST", &command),
    )
}

/// Sees to the environments in which wheels are made and tested: their interpreters.
///
/// # Errors
/// What failed, in words.
pub fn environments() -> Result<[PathBuf; 2], String> {
    Ok([
        environment("wheel", Path::new(MAKING))?,
        environment("python", Path::new(TESTING))?,
    ])
}

/// The command in the profile and with the features of the tests, which have built it if they have run.
///
/// # Errors
/// What failed, in words.
pub fn command() -> Result<PathBuf, String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let of_tests = ["build", "--workspace", "--all-features", "--bins"];
    succeed(Command::new(cargo).args(of_tests))?;
    let command = Path::new("target/debug").join(format!("onset{}", std::env::consts::EXE_SUFFIX));
    std::path::absolute(command).map_err(|error| error.to_string())
}

/// Makes a wheel for an interpreter, by default that of all with a global lock, in a profile, into a folder; where it is.
fn made(profile: &str, folder: &str, interpreter: Option<&Path>) -> Result<PathBuf, String> {
    let making = environment("wheel", Path::new(MAKING))?;
    let licences = [
        "python/licences.py",
        "python/licenses/THIRD-PARTY.txt",
        "onset-py",
    ];
    succeed(Command::new(&making).args(licences))?;
    let since = SystemTime::now();
    succeed(
        Command::new(&making)
            .args(["-m", "maturin", "build", "--profile", profile, "--out"])
            .arg(std::path::absolute(folder).map_err(|error| error.to_string())?)
            .arg("--interpreter")
            .arg(interpreter.unwrap_or(&making))
            .args(if profile == "wheel" { SMALL } else { &[] })
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
