//! The core, as it would run in a page without a server.

use crate::python::succeed;
use std::path::Path;
use std::process::Command;

/// Programs of a browser.
const TARGET: &str = "wasm32-unknown-unknown";

/// Whether the toolchain has the standard library of such programs.
///
/// # Errors
/// What to do, in words, where it has not.
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

/// That the core compiles for it, unchanged.
///
/// # Errors
/// That it does not.
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
