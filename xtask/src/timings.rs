//! Build times of the workspace.

use std::fs::File;
use std::process::{Command, Stdio};
use std::time::{Instant, SystemTime};

/// File of a law; every module above the materials depends on it.
const LAW: &str = "crates/onset/src/material/laws/gent.rs";
/// Root of the crate that reads studies.
const STUDY: &str = "crates/onset-study/src/lib.rs";

/// Build whose duration is measured.
struct Build {
    /// Name of the build.
    name: &'static str,
    /// File that is touched before the build.
    touched: Option<&'static str>,
    arguments: &'static [&'static str],
}

const COMMAND: &[&str] = &["build", "--release", "--package", "onset-cli"];
const TESTS: &[&str] = &["test", "--workspace", "--all-features", "--no-run"];
const LIBRARY: &[&str] = &["build", "--package", "onset-study", "--all-features"];

/// Builds in the order in which they share a target folder.
const BUILDS: &[Build] = &[
    Build {
        name: "the command, from nothing",
        touched: None,
        arguments: COMMAND,
    },
    Build {
        name: "the command, after a change of one law",
        touched: Some(LAW),
        arguments: COMMAND,
    },
    Build {
        name: "the command, after a change of `onset-study`",
        touched: Some(STUDY),
        arguments: COMMAND,
    },
    Build {
        name: "all tests, from nothing",
        touched: None,
        arguments: TESTS,
    },
    Build {
        name: "all tests, after a change of one law",
        touched: Some(LAW),
        arguments: TESTS,
    },
    Build {
        name: "`onset-study` for tests, after a change in it",
        touched: Some(STUDY),
        arguments: LIBRARY,
    },
];

/// Times the builds in a separate, initially empty target folder, and prints the table.
///
/// # Errors
/// Description of the failure.
pub fn run() -> Result<(), String> {
    let target = "target/timings";
    if let Err(error) = std::fs::remove_dir_all(target)
        && error.kind() != std::io::ErrorKind::NotFound
    {
        return Err(format!("cannot empty {target}: {error}"));
    }
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    println!("| build, on {cores} core(s) | seconds |\n|---|---|");
    for build in BUILDS {
        if let Some(file) = build.touched {
            touch(file).map_err(|error| format!("cannot touch {file}: {error}"))?;
        }
        println!("| {} | {:.0} |", build.name, seconds(build, target)?);
    }
    Ok(())
}

fn touch(file: &str) -> std::io::Result<()> {
    let file = File::options().append(true).open(file)?;
    file.set_modified(SystemTime::now())
}

fn seconds(build: &Build, target: &str) -> Result<f64, String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let mut command = Command::new(cargo);
    command
        .args(build.arguments)
        .env("CARGO_TARGET_DIR", target)
        .stderr(Stdio::null());
    let start = Instant::now();
    let status = command.status().map_err(|error| error.to_string())?;
    if status.success() {
        Ok(start.elapsed().as_secs_f64())
    } else {
        Err(format!("cargo {} failed", build.arguments.join(" ")))
    }
}
