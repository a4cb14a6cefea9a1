//! Simulations of every method, compared with predictions, and their table in the book.

use crate::verify::tested;

/// Table that a page of the book includes.
const TABLE: &str = "book/src/how-to/simulate-table.md";

/// Simulates a stable, an unstable and a zero-energy mode of every method in the comparisons, and writes the table.
///
/// # Errors
/// Description of the failure.
pub fn run() -> Result<(), String> {
    let table = std::env::current_dir()
        .map_err(|error| format!("cannot determine the current folder: {error}"))?
        .join(TABLE);
    tested(
        "motions of all methods",
        "motion::the_table_of_motions_is_computed",
        &[("ONSET_MOTION_TABLE", &table)],
    )
}
