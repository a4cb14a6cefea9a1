//! The page of `onset explore`: built from its sources, and tested in a real browser.

use crate::npm::packages;
use crate::python::succeed;
use crate::wheel;
use std::path::Path;
use std::process::Command;

/// Folder of the sources.
const FOLDER: &str = "crates/onset-cli/page";

/// Factor on time limits for tests on machines with other load.
const SHARED_MACHINE_PATIENCE: u32 = 20;

/// Builds the page into the folder that the program embeds, and tests it.
///
/// # Errors
/// Description of the failure.
pub fn run() -> Result<(), String> {
    tools()?;
    succeed(&mut npm(&["run", "check"]))?;
    succeed(&mut npm(&["run", "build"]))?;
    driven(1)
}

/// Tests the page, and checks that its built files agree with its sources.
///
/// # Errors
/// Description of the failure.
pub fn test() -> Result<(), String> {
    tools()?;
    succeed(&mut npm(&["run", "check"]))?;
    let again = Path::new("target/page");
    // Files of an earlier build must not hide missing files.
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
                "{}/{} differs from the build of its sources: cargo xtask page",
                built.display(),
                name.to_string_lossy()
            ));
        }
    }
    driven(SHARED_MACHINE_PATIENCE)
}

/// Installs the tools that build and test the page.
///
/// # Errors
/// Description of the missing tool.
pub fn tools() -> Result<(), String> {
    packages(Path::new(FOLDER))
}

fn npm(arguments: &[&str]) -> Command {
    crate::npm::npm(Path::new(FOLDER), arguments)
}

/// Tests the page in a browser, with the command built by the tests. `patience` is a factor on its time limits.
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
