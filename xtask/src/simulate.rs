//! Every method in motion beside its prediction, and the table of the book.

use std::process::Command;

/// The table, which a page of the book includes.
const TABLE: &str = "book/src/how-to/simulate-table.md";

/// Runs a stable, an unstable and a zero-energy mode of every method of the comparisons, and writes the table.
///
/// # Errors
/// What failed, in words.
pub fn run() -> Result<(), String> {
    let table = std::env::current_dir()
        .map_err(|error| format!("cannot tell the current folder: {error}"))?
        .join(TABLE);
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let status = Command::new(cargo)
        .args(["test", "--package", "onset-cli", "--all-features"])
        .args(["--test", "verify", "motion::the_table_of_motions"])
        .args(["--", "--nocapture"])
        .env("ONSET_MOTION_TABLE", table)
        .status()
        .map_err(|error| format!("cannot run cargo: {error}"))?;
    match status.success() {
        true => Ok(()),
        false => Err("motions of all methods: failed".to_owned()),
    }
}
