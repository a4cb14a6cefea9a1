//! Table of a comparison, as text and as CSV.

use super::row::{Measured, Row, SHORT_WAVELENGTH, WAVELENGTHS};
use super::thresholds::Thresholds;
use crate::answers::{Evidence, LATTICE_NOTE};
use crate::csv;
use crate::number::counted;
use crate::settings::CompareSettings;
use onset::measures::{Extent, Load, StretchOnset};
use serde::Serialize;

/// Measures of all methods in a comparison.
#[derive(Clone, Debug, Serialize)]
pub struct Table {
    /// Title of the comparison.
    pub title: String,
    /// Notes on the law.
    pub notes: Vec<String>,
    /// Name of the law.
    pub material: String,
    /// Number of space dimensions.
    pub dimension: usize,
    /// Options of the comparison.
    pub options: CompareSettings,
    /// Limits of the recommendation.
    pub thresholds: Thresholds,
    /// Evidence for verdicts and onsets: `searched`.
    pub evidence: Evidence,
    /// Rows of the methods, in the order of the file.
    pub rows: Vec<Row>,
}

/// Column of the table: its short head, its meaning, and the cell of a method.
pub(super) struct Column {
    pub(super) head: String,
    /// Head of the column in the CSV file.
    pub(super) name: String,
    pub(super) meaning: String,
    pub(super) cell: Box<dyn Fn(&Measured) -> String>,
    /// Unrounded value of a cell, for the CSV file.
    pub(super) number: Box<dyn Fn(&Measured) -> f64>,
    /// Cell of the material itself.
    pub(super) material: String,
    /// Whether the short table has this column.
    pub(super) is_in_short: bool,
}

/// Cell of the material for a measure that only methods have.
const NOT_OF_MATERIAL: &str = "-";

impl Column {
    /// Width of the head and of the cells of the material and all methods.
    pub(super) fn width(&self, rows: &[Row]) -> usize {
        let measured = rows.iter().filter_map(|row| row.measured.as_ref().ok());
        let cells = measured.map(|m| (self.cell)(m).chars().count());
        let own = [&self.head, &self.material].map(|text| text.chars().count());
        cells.chain(own).max().unwrap_or(0)
    }

    /// Includes the column in the short table as well.
    fn in_short(self) -> Self {
        Self {
            is_in_short: true,
            ..self
        }
    }
}

fn column(
    head: impl Into<String>,
    name: impl Into<String>,
    meaning: impl Into<String>,
    number: impl Fn(&Measured) -> f64 + Clone + 'static,
    shown: impl Fn(f64) -> String + 'static,
) -> Column {
    let of_cell = number.clone();
    Column {
        head: head.into(),
        name: name.into(),
        meaning: meaning.into(),
        cell: Box::new(move |measured| shown(of_cell(measured))),
        number: Box::new(number),
        material: NOT_OF_MATERIAL.to_owned(),
        is_in_short: false,
    }
}

impl Table {
    /// Columns of the table after the names of the methods.
    pub(super) fn columns(&self) -> Vec<Column> {
        let mut columns = vec![
            Column {
                head: "zero modes".to_owned(),
                name: "zero_modes".to_owned(),
                meaning: "wave vectors with zero-energy modes, of k and -k one; * where they fill lines or more of the zone, >= where not all \
                          of it could be searched"
                    .to_owned(),
                cell: Box::new(|m| {
                    let least = if m.zero_modes_complete { "" } else { ">= " };
                    let more = if m.zero_extent > Some(Extent::Point) { "*" } else { "" };
                    format!("{least}{}{more}", m.zero_modes)
                }),
                number: Box::new(|m| m.zero_modes as f64),
                material: NOT_OF_MATERIAL.to_owned(),
                is_in_short: true,
            },
            column(
                "weakest",
                "weakest",
                "lowest frequency relative to the slowest wave of the material",
                |m| m.weakest,
                |x| format!("{x:.3}"),
            ),
        ];
        for count in WAVELENGTHS {
            let own = column(
                format!("disp. {count:.0}"),
                format!("dispersion_{count:.0}"),
                format!("largest error of a frequency at {count:.0} points per wavelength"),
                move |m| m.dispersion_at(count),
                percent,
            );
            columns.push(match count == SHORT_WAVELENGTH {
                true => own.in_short(),
                false => own,
            });
        }
        columns.push(column(
            "long waves",
            "long_wave_error",
            "consistency error: largest error of the long-wavelength moduli",
            |m| m.long_wave_error,
            percent,
        ));
        for load in Load::ALL
            .into_iter()
            .filter(|load| load.is_possible(self.dimension))
        {
            let onset = move |m: &Measured| {
                let mut known = m.onsets.iter();
                known.find(|pair| pair.load == load).map(|pair| pair.method)
            };
            columns.push(Column {
                head: short(load).to_owned(),
                name: format!("onset_{}", load.name().replace(' ', "_")),
                meaning: format!(
                    "imposed stretch at which stability is lost in {}",
                    load.title(self.dimension)
                ),
                cell: Box::new(move |m| onset(m).map_or_else(String::new, told)),
                number: Box::new(move |m| {
                    onset(m).and_then(StretchOnset::stretch).unwrap_or(f64::NAN)
                }),
                material: self
                    .material_onset_of(load)
                    .map_or_else(|| NOT_OF_MATERIAL.to_owned(), told),
                is_in_short: load.is_tension(),
            });
        }
        columns.extend([
            column(
                "false",
                "false_instability",
                "fraction of the states of the window that are unstable although the material is elliptic",
                |m| m.fidelity.false_instability,
                percent,
            )
            .in_short(),
            column(
                "suppressed", "suppressed_instability",
                "fraction of the states of the window that are stable although the material is not elliptic",
                |m| m.fidelity.suppressed_instability,
                percent,
            ),
            column(
                "undefined",
                "undefined",
                "fraction of the states of the window in which the law is defined and the method is not: too few neighbors",
                |m| m.fidelity.undefined,
                percent,
            ),
            column(
                "Courant",
                "courant",
                format!("critical time step times speed of sound divided by the particle spacing; {LATTICE_NOTE}"),
                |m| m.courant,
                |x| format!("{x:.3}"),
            )
            .in_short(),
            column(
                "neighbors",
                "neighbors",
                "number of particles or nodes that contribute to the force on one of them; for kernel methods and material points the neighbors of all points of a cell, per particle or node",
                |m| m.neighbors,
                |x| format!("{x:.0}"),
            ),
        ]);
        let has_body = |row: &Row| row.measured.as_ref().is_ok_and(|m| m.body.is_some());
        if self.rows.iter().any(has_body) {
            columns.push(column(
                "body",
                "body_courant",
                "Courant number of the body of the study",
                |m| m.body_courant.unwrap_or(f64::NAN),
                |x| match x.is_finite() {
                    true => format!("{x:.3}"),
                    false => "-".to_owned(),
                },
            ));
        }
        columns
    }

    /// Onset of the material along a loading; equal in all rows, and `None` if it was not computed.
    pub(super) fn material_onset_of(&self, load: Load) -> Option<StretchOnset> {
        let mut pairs = self
            .rows
            .iter()
            .filter_map(|row| row.measured.as_ref().ok())
            .flat_map(|measured| &measured.onsets);
        pairs
            .find(|pair| pair.load == load)
            .map(|pair| pair.material)
    }

    /// Table as CSV, with empty cells for missing numbers.
    pub fn csv(&self) -> String {
        let units = self.rows.first().map(|row| row.settings.units());
        let table = csv::Table::new(&self.rows, units.unwrap_or_default());
        let table = table.with("method", "1", |row| row.name.as_str());
        let table = self.columns().iter().fold(table, |table, column| {
            table.with(&column.name, "1", |row| {
                let number = (column.number)(row.measured.as_ref().ok()?);
                number.is_finite().then_some(number)
            })
        });
        table
            .with("zero_modes_complete", "1", |row| {
                row.measured.as_ref().ok().map(|m| m.zero_modes_complete)
            })
            .with("note", "1", |row| row.measured.as_ref().err().cloned())
            .to_string()
    }

    /// Notes on the law, and on methods with their names.
    pub(super) fn all_notes(&self) -> Vec<String> {
        let of_rows = self.rows.iter().flat_map(|row| {
            let named = |note: &String| format!("{}: {note}", row.name);
            row.notes.iter().map(named)
        });
        self.notes.iter().cloned().chain(of_rows).collect()
    }

    /// Headings of the columns with their meanings.
    pub(super) fn legend(&self) -> Vec<(String, String)> {
        let columns = self.columns().into_iter();
        columns
            .map(|column| (column.head, column.meaning))
            .collect()
    }
}

impl std::fmt::Display for Table {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let columns = self.columns();
        let names = self.rows.iter().map(|row| row.name.chars().count());
        let width = names.max().unwrap_or(0).max(MATERIAL.len());
        let widths: Vec<usize> = columns
            .iter()
            .map(|column| column.width(&self.rows))
            .collect();
        if !self.title.is_empty() {
            writeln!(formatter, "{}", self.title)?;
        }
        writeln!(
            formatter,
            "material {}, {}\n",
            self.material,
            counted(self.dimension, "dimension")
        )?;
        write!(formatter, "{:width$}", "method")?;
        for (column, width) in columns.iter().zip(&widths) {
            write!(formatter, "  {:>width$}", column.head)?;
        }
        write!(formatter, "\n{MATERIAL:width$}")?;
        for (column, width) in columns.iter().zip(&widths) {
            write!(formatter, "  {:>width$}", column.material)?;
        }
        writeln!(formatter)?;
        for row in &self.rows {
            write!(formatter, "{:width$}", row.name)?;
            match &row.measured {
                Ok(measured) => {
                    for (column, width) in columns.iter().zip(&widths) {
                        write!(formatter, "  {:>width$}", (column.cell)(measured))?;
                    }
                    writeln!(formatter)?;
                }
                Err(why) => writeln!(formatter, "  {}", why.lines().next().unwrap_or_default())?,
            }
        }
        writeln!(formatter)?;
        for (head, meaning) in self.legend() {
            writeln!(formatter, "  {head:<10}  {meaning}")?;
        }
        for note in self.all_notes() {
            writeln!(formatter, "\nnote: {note}")?;
        }
        if let Some(first) = self.rows.first() {
            writeln!(
                formatter,
                "\n{:<width$}  {}",
                "material",
                first.settings.law()
            )?;
        }
        for row in &self.rows {
            writeln!(formatter, "{:<width$}  {}", row.name, row.settings.method())?;
        }
        writeln!(formatter, "\n{}", self.evidence)
    }
}

/// Name of the row of the material itself.
pub(super) const MATERIAL: &str = "the material";

/// Head of the column of a loading.
pub(super) fn short(load: Load) -> &'static str {
    match load {
        Load::UniaxialStrainTension => "uni. +",
        Load::UniaxialStrainCompression => "uni. -",
        Load::EquibiaxialStrainTension => "equi. +",
        Load::EquibiaxialStrainCompression => "equi. -",
    }
}

/// Formats an onset as text.
pub(super) fn told(onset: StretchOnset) -> String {
    match onset {
        StretchOnset::AtRest => "at F = 1".to_owned(),
        StretchOnset::At(stretch) => format!("{stretch:.4}"),
        StretchOnset::NotBefore(end) if end > 1.0 => format!("> {end}"),
        StretchOnset::NotBefore(end) => format!("< {end}"),
        StretchOnset::Undefined(stretch) => format!("undef. {stretch:.3}"),
    }
}

/// Formats a fraction or an error in percent.
pub(super) fn percent(share: f64) -> String {
    match 100.0 * share {
        percent if !percent.is_finite() => "-".to_owned(),
        percent if percent < 1e-6 => "0 %".to_owned(),
        percent if percent < 0.01 => format!("{percent:.0e} %"),
        percent => format!("{percent:.2} %"),
    }
}
