//! The paper from end to end: its figures, its claims, and a report.

mod boundary;
mod claims;
mod figures;
mod report;

pub use claims::{Claim, ClaimVerdict};
pub use report::Report;

use crate::answers::ProblemError;
use crate::figure::FigureError;
use crate::settings::{SettingError, Study};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why the paper cannot be reproduced.
#[derive(Debug, Error)]
pub enum ReproduceError {
    /// A computation failed.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// A study file of the paper is wrong.
    #[error(transparent)]
    Study(#[from] SettingError),
    /// A figure cannot be written.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// A file cannot be written.
    #[error("cannot write {path}: {source}")]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

/// How many steps [`run`] reports.
pub const STEPS: usize = figures::ALL.len() + claims::ALL.len();

/// Computes every figure and checks every claim, and writes figures, data and an HTML report into a folder.
/// `progress` is told the name of each step when it is done.
///
/// # Errors
/// [`ReproduceError`] when something cannot be computed or written.
pub fn run(out: &Path, progress: &dyn Fn(&str)) -> Result<Report, ReproduceError> {
    std::fs::create_dir_all(out).map_err(|source| ReproduceError::Write {
        path: out.to_owned(),
        source,
    })?;
    let mut drawn = Vec::new();
    for figure in figures::ALL {
        let plate = (figure.make)()?;
        plate.figure.write(out, figure.name)?;
        for (name, table) in &plate.tables {
            write(&out.join(format!("{name}.csv")), table)?;
        }
        drawn.push((
            figure.name.to_owned(),
            plate.figure.title.clone(),
            plate.figure.caption.clone(),
        ));
        progress(figure.name);
    }
    let mut checked = Vec::new();
    for claim in claims::ALL {
        checked.push(claim()?);
        progress(checked.last().map_or("", |claim| claim.id));
    }
    let report = Report {
        claims: checked,
        figures: drawn,
    };
    write(&out.join("report.html"), &report.html())?;
    write(&out.join("claims.csv"), &report.csv())?;
    Ok(report)
}

fn write(path: &Path, text: &str) -> Result<(), ReproduceError> {
    std::fs::write(path, text).map_err(|source| ReproduceError::Write {
        path: path.to_owned(),
        source,
    })
}

/// A study of the paper, as committed in `studies/`.
macro_rules! study {
    ($name:literal) => {
        $crate::settings::Study::parse(
            concat!("studies/", $name, ".toml"),
            include_str!(concat!(
                env!("CARGO_MANIFEST_DIR"),
                "/../../studies/",
                $name,
                ".toml"
            )),
        )
    };
}
use study;

/// The type of a study constructor, so that lists of them read well.
type StudyResult = Result<Study, SettingError>;
