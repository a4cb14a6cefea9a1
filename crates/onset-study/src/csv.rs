//! Tables of answers as CSV: a line of names, with units in brackets if the values have units, and one line for each row.
//!
//! Numbers have the fewest digits that read back exactly; missing numbers are empty cells.

use crate::number::exact;
use crate::settings::Units;
use std::fmt;
use std::path::PathBuf;

/// Cell of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell(String);

impl From<f64> for Cell {
    fn from(number: f64) -> Self {
        match number.is_nan() {
            true => Self(String::new()),
            // Adding zero turns a negative zero into a positive one.
            false => Self(exact(number + 0.0)),
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self(quoted(text))
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self(quoted(&text))
    }
}

impl<C: Into<Self>> From<Option<C>> for Cell {
    fn from(value: Option<C>) -> Self {
        value.map_or(Self(String::new()), Into::into)
    }
}

macro_rules! plain {
    ($($kind:ty),*) => {$(
        impl From<$kind> for Cell {
            fn from(value: $kind) -> Self {
                Self(value.to_string())
            }
        }
    )*};
}

plain!(u32, u64, usize, bool);

/// A text as a cell, quoted if needed. An apostrophe is prepended to texts that a spreadsheet would interpret as a formula.
fn quoted(text: &str) -> String {
    let line = text.replace(['\n', '\r'], " ");
    let is_formula = line.trim_start().starts_with([
        '=', '+', '-', '@', '\t', '\u{ff1d}', '\u{ff0b}', '\u{ff0d}', '\u{ff20}',
    ]);
    let safe = if is_formula { format!("'{line}") } else { line };
    if is_formula || safe.contains(['"', ',', ';', '\t']) {
        format!("\"{}\"", safe.replace('"', "\"\""))
    } else {
        safe
    }
}

/// Table of items, one row for each. The columns are added one by one; `Display` writes the table as CSV.
///
/// ```
/// use onset_study::csv::Table;
/// use onset_study::settings::Units;
/// let table = Table::new(&[1.0, 0.1256], Units::Si)
///     .with("stress", "stress", |value| *value)
///     .with("ratio", "1", |value| 2.0 * value);
/// assert_eq!(table.to_string(), "stress [Pa],ratio\n1,2\n0.1256,0.2512\n");
/// ```
#[derive(Clone, Debug)]
pub struct Table<'a, T> {
    items: &'a [T],
    units: Units,
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl<'a, T> Table<'a, T> {
    /// Creates the table of some items, in the units of an answer, without columns.
    pub fn new(items: &'a [T], units: Units) -> Self {
        Self {
            items,
            units,
            names: Vec::new(),
            rows: vec![Vec::new(); items.len()],
        }
    }

    /// Adds a column with a name, the dimension of its numbers (`1` without dimension), and the cell of an item.
    pub fn with<C: Into<Cell>>(
        mut self,
        name: impl AsRef<str>,
        dimension: &'static str,
        cell: impl Fn(&'a T) -> C,
    ) -> Self {
        self.names
            .push(quoted(&self.units.head(name.as_ref(), dimension)));
        for (item, row) in self.items.iter().zip(&mut self.rows) {
            row.push(cell(item).into().0);
        }
        self
    }

    /// Adds the columns `NAME_1`, `NAME_2`, ... of numbers in a list.
    pub fn each<C: Into<Cell>>(
        self,
        name: &str,
        count: usize,
        dimension: &'static str,
        cell: impl Fn(&'a T, usize) -> C,
    ) -> Self {
        (0..count).fold(self, |table, n| {
            table.with(format!("{name}_{}", n + 1), dimension, |item| cell(item, n))
        })
    }

    /// Adds the nine columns of a tensor, by rows: `F11`, `F12`, ..., `F33`.
    pub fn tensor(
        self,
        letter: &str,
        dimension: &'static str,
        of: impl Fn(&'a T) -> &'a [[f64; 3]; 3],
    ) -> Self {
        (0..9).fold(self, |table, n| {
            let (i, j) = (n / 3, n % 3);
            let name = format!("{letter}{}{}", i + 1, j + 1);
            table.with(name, dimension, |item| of(item)[i][j])
        })
    }
}

impl<T> fmt::Display for Table<'_, T> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(formatter, "{}", self.names.join(","))?;
        self.rows
            .iter()
            .try_for_each(|row| writeln!(formatter, "{}", row.join(",")))
    }
}

/// Table of written files.
pub fn of_files(files: &[PathBuf]) -> String {
    Table::new(files, Units::Own)
        .with("file", "1", |file| file.display().to_string())
        .to_string()
}

#[cfg(test)]
mod tests {
    use super::{Cell, Table};
    use crate::settings::Units;

    #[test]
    fn csv_cells_are_quoted_and_never_formulas() {
        let text = |text: &str| Cell::from(text).0;
        assert_eq!(text("SPH"), "SPH");
        assert_eq!(text("a, \"b\"\nc"), "\"a, \"\"b\"\" c\"");
        for start in ["=", "+", "-", "@", "\t=", " =", "\n=", "\r="] {
            let cell = text(&format!("{start}cmd|' /C calc'!A0"));
            assert!(cell.starts_with("\"'"), "{cell}");
        }
    }

    #[test]
    fn numbers_in_cells_are_short_and_read_back_exactly() {
        let numbers = [
            (1.0, "1"),
            (-0.0, "0"),
            (0.1256, "0.1256"),
            (0.1 + 0.2, "0.30000000000000004"),
            (6.02e23, "6.02e23"),
            (1e-7, "1e-7"),
            (f64::INFINITY, "inf"),
            (f64::NAN, ""),
        ];
        for (number, expected) in numbers {
            let cell = Cell::from(number).0;
            assert_eq!(cell, expected);
            assert!(cell.is_empty() || cell.parse() == Ok(number), "{cell}");
        }
    }

    #[test]
    fn a_table_without_rows_has_its_names_and_units() {
        let table = |units| {
            Table::<f64>::new(&[], units)
                .with("note", "1", |_| "")
                .each("wave_vector", 2, "1/length", |_, _| 0.0)
                .with("angle", "deg", |_| 0.0)
                .to_string()
        };
        assert_eq!(
            table(Units::Own),
            "note,wave_vector_1,wave_vector_2,angle [deg]\n"
        );
        assert_eq!(
            table(Units::Si),
            "note,wave_vector_1 [1/m],wave_vector_2 [1/m],angle [deg]\n"
        );
    }
}
