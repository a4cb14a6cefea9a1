//! The page of `onset explore`: built from its sources, and driven by a real browser.

use crate::npm::packages;
use crate::python::succeed;
use crate::wheel;
use std::path::Path;
use std::process::Command;

/// Where its sources are.
const FOLDER: &str = "crates/onset-cli/page";

/// How much longer answers may take where tests run, on machines that do other work beside.
const SHARED: u32 = 20;

/// Builds the page into the folder that the program embeds, and tests it.
///
/// # Errors
/// What failed, in words.
pub fn run() -> Result<(), String> {
    tools()?;
    succeed(&mut npm(&["run", "check"]))?;
    succeed(&mut npm(&["run", "build"]))?;
    driven(1)
}

/// Tests the page, whose built files must be what its sources build.
///
/// # Errors
/// What failed, in words.
pub fn test() -> Result<(), String> {
    tools()?;
    succeed(&mut npm(&["run", "check"]))?;
    let again = Path::new("target/page");
    // What an earlier build has left must not stand for what this one makes.
    let _ = std::fs::remove_dir_all(again);
    let place = std::path::absolute(again).map_err(|error| error.to_string())?;
    succeed(
        Command::new("node")
            .args(["build.mjs"])
            .arg(&place)
            .current_dir(FOLDER),
    )?;
    let built = Path::new(FOLDER).join("dist");
    for file in std::fs::read_dir(&place).map_err(|error| error.to_string())? {
        let name = file.map_err(|error| error.to_string())?.file_name();
        let read = |folder: &Path| std::fs::read(folder.join(&name)).unwrap_or_default();
        if read(&place) != read(&built) {
            return Err(format!(
                "{}/{} is not what the sources build: cargo xtask page",
                built.display(),
                name.to_string_lossy()
            ));
        }
    }
    driven(SHARED)
}

/// Sees to what the page is built and tested with.
///
/// # Errors
/// What cannot be had, in words.
pub fn tools() -> Result<(), String> {
    packages(Path::new(FOLDER))
}

fn npm(arguments: &[&str]) -> Command {
    crate::npm::npm(Path::new(FOLDER), arguments)
}

/// Drives the page of the program in the profile of the tests with a browser, which may take so many times the time that the page is to
/// take.
fn driven(patience: u32) -> Result<(), String> {
    let command = wheel::command()?;
    eprintln!("== page: a browser");
    let patience = std::env::var("ONSET_PATIENCE").unwrap_or_else(|_| patience.to_string());
    succeed(
        npm(&["test"])
            .env("ONSET_COMMAND", command)
            .env("ONSET_PATIENCE", patience),
    )
}
