//! The Python package: its wheel, and its tests with the installed wheel.

use crate::python::{environment, succeed};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

/// Requirements for building wheels.
const BUILD_REQUIREMENTS: &str = "python/requirements-wheel.txt";
/// Interpreters without a global lock, used if installed. The stable ABI excludes them, so that each needs a separate wheel.
const FREE_THREADED: [&str; 2] = ["python3.14t", "python3.15t"];
/// Options for small release wheels; identical functions are merged if the linker of the toolchain supports it.
const SMALL_WHEEL_OPTIONS: &[&str] = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
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
/// Requirements of the tests, in addition to the wheel.
const TEST_REQUIREMENTS: &str = "python/tests/requirements.txt";

/// Builds the release wheels in `target/wheels`, and prints their paths and sizes.
///
/// One wheel serves all interpreters with a global lock, and each interpreter without a global lock needs a separate wheel.
///
/// # Errors
/// Description of the failure.
pub fn run() -> Result<(), String> {
    let unlocked = FREE_THREADED.into_iter().map(Path::new);
    let unlocked = unlocked.filter(|name| is_installed(name)).map(Some);
    for interpreter in std::iter::once(None).chain(unlocked) {
        let wheel = made("wheel", "target/wheels", interpreter)?;
        let making = environment("wheel", Path::new(BUILD_REQUIREMENTS))?;
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

/// Returns true if an interpreter can be run.
fn is_installed(interpreter: &Path) -> bool {
    Command::new(interpreter)
        .arg("--version")
        .output()
        .is_ok_and(|output| output.status.success())
}

/// Builds a wheel in the profile of the tests, installs it into a separate environment, and runs the tests of the package.
///
/// The tests also use the command of the same build.
///
/// # Errors
/// Description of the failure.
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
            // A test that waits forever fails and prints its stack.
            .args(["--numprocesses", "auto", "--timeout", "900"])
            // The tests run outside the folder of the package, which would be imported without its compiled part.
            .current_dir("python/tests")
            .env("ONSET_COMMAND", &command)
            .env("ONSET_UMAT_HOST", &command),
    )
}

/// Prepares the environments for building and testing wheels, and returns their interpreters.
///
/// # Errors
/// Description of the failure.
pub fn environments() -> Result<[PathBuf; 2], String> {
    Ok([
        environment("wheel", Path::new(BUILD_REQUIREMENTS))?,
        environment("python", Path::new(TEST_REQUIREMENTS))?,
    ])
}

/// Command with the profile and the features of the tests, which have usually built it already.
///
/// # Errors
/// Description of the failure.
pub fn command() -> Result<PathBuf, String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let of_tests = ["build", "--workspace", "--all-features", "--bins"];
    succeed(Command::new(cargo).args(of_tests))?;
    let command = Path::new("target/debug").join(format!("onset{}", std::env::consts::EXE_SUFFIX));
    std::path::absolute(command).map_err(|error| error.to_string())
}

/// Builds a wheel for an interpreter, by default for all interpreters with a global lock, and returns its path.
fn made(profile: &str, folder: &str, interpreter: Option<&Path>) -> Result<PathBuf, String> {
    let making = environment("wheel", Path::new(BUILD_REQUIREMENTS))?;
    let licenses = [
        "python/licenses.py",
        "python/licenses/THIRD-PARTY.txt",
        "onset-py",
    ];
    succeed(Command::new(&making).args(licenses))?;
    let since = SystemTime::now();
    succeed(
        Command::new(&making)
            .args(["-m", "maturin", "build", "--profile", profile, "--out"])
            .arg(std::path::absolute(folder).map_err(|error| error.to_string())?)
            .arg("--interpreter")
            .arg(interpreter.unwrap_or(&making))
            .args(if profile == "wheel" {
                SMALL_WHEEL_OPTIONS
            } else {
                &[]
            })
            .current_dir("python"),
    )?;
    newest(folder, since)
}

/// Most recent wheel in a folder.
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
