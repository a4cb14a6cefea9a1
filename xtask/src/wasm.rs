//! Check that the core compiles for a page without a server.

use crate::python::succeed;
use std::path::Path;
use std::process::Command;

/// Compilation target of programs in a browser.
const TARGET: &str = "wasm32-unknown-unknown";

/// Returns true if the toolchain contains the standard library of the target.
///
/// # Errors
/// Instructions for the user, if the toolchain does not contain the library.
pub fn tools() -> Result<(), String> {
    let output = Command::new("rustc")
        .args(["--print", "target-libdir", "--target", TARGET])
        .output()
        .map_err(|error| format!("cannot run rustc: {error}"))?;
    let folder = String::from_utf8_lossy(&output.stdout);
    match output.status.success() && Path::new(folder.trim()).is_dir() {
        true => Ok(()),
        false => Err(format!(
            "The target {TARGET} is not installed: rustup target add {TARGET}"
        )),
    }
}

/// Checks that the core compiles unchanged for the target.
///
/// # Errors
/// Description of the failure.
pub fn check() -> Result<(), String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    eprintln!("== the core in a browser: cargo check --target {TARGET}");
    succeed(Command::new(cargo).args([
        "check",
        "--package",
        "onset",
        "--features",
        "serde",
        "--target",
        TARGET,
    ]))
}
