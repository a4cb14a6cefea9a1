//! The known particle codes, one file each.

mod lammps;
mod lammps_peri;
mod lammps_smd_tlsph;
mod lammps_smd_ulsph;
mod plain;
mod pysph;

use super::{Code, Settled, VerifyError};
use crate::csv::Table;
use crate::settings::Units;
use serde::Serialize;
use std::fmt;

/// All codes that can be verified.
pub const CODES: [&dyn Code; 6] = [
    &lammps_smd_tlsph::TotalSmd,
    &lammps_smd_ulsph::PLAIN,
    &lammps_smd_ulsph::CORRECTED,
    &lammps_peri::Peri,
    &pysph::PySph,
    &plain::Plain,
];

/// Code with the given name.
///
/// # Errors
/// [`VerifyError::Unknown`] if no code has this name.
pub fn named(name: &str) -> Result<&'static dyn Code, VerifyError> {
    let found = CODES.into_iter().find(|code| code.name() == name);
    found.ok_or_else(|| VerifyError::Unknown {
        name: name.to_owned(),
        known: CODES.map(|code| code.name()).to_vec(),
    })
}

/// List of the codes with their dialects.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Codes(pub Vec<ListedCode>);

/// Entry of a code in the list.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ListedCode {
    /// Name on the command line.
    pub name: &'static str,
    /// Title of the code.
    pub title: &'static str,
    /// Whether blocks are periodic.
    pub is_periodic: bool,
    /// Choices that the code fixes.
    pub dialect: &'static [Settled],
    /// Other deviations, one sentence each.
    pub remarks: &'static [&'static str],
}

impl Codes {
    /// The codes as CSV, one row for each.
    pub fn csv(&self) -> String {
        Table::new(&self.0, Units::Own)
            .with("name", "1", |own| own.name)
            .with("title", "1", |own| own.title)
            .with("is_periodic", "1", |own| own.is_periodic)
            .to_string()
    }

    /// List of all codes.
    pub fn all() -> Self {
        let listed = |code: &dyn Code| ListedCode {
            name: code.name(),
            title: code.title(),
            is_periodic: code.is_periodic(),
            dialect: code.dialect(),
            remarks: code.remarks(),
        };
        Self(CODES.into_iter().map(listed).collect())
    }
}

impl fmt::Display for Codes {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (n, code) in self.0.iter().enumerate() {
            if n > 0 {
                writeln!(formatter, "\n")?;
            }
            write!(formatter, "{}: {}", code.name, code.title)?;
            for choice in code.dialect {
                write!(formatter, "\n  {} = {}", choice.key, choice.value)?;
                if !choice.deviation.is_empty() {
                    write!(formatter, "\n    {}", choice.deviation)?;
                }
            }
            for remark in code.remarks {
                write!(formatter, "\n  {remark}")?;
            }
        }
        Ok(())
    }
}
