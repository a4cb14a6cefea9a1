//! Every method in motion beside its prediction, and the table of the book.

use crate::verify::tested;

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
    tested(
        "motions of all methods",
        "motion::the_table_of_motions",
        &[("ONSET_MOTION_TABLE", &table)],
    )
}
