//! The paper from end to end: its figures, its claims, and a report.

mod boundary;
mod claims;
mod figures;
mod report;

pub use claims::{Claim, ClaimVerdict};
pub use report::Report;

use crate::answers::ProblemError;
use crate::figure::FigureError;
use crate::output::{Output, OutputError, text};
use crate::settings::{SettingError, Study};
use onset::method::MethodError;
use std::path::Path;
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
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl From<MethodError> for ReproduceError {
    fn from(error: MethodError) -> Self {
        Self::Problem(error.into())
    }
}

/// How many steps [`run`] reports.
pub const STEPS: usize = figures::ALL.len() + claims::ALL.len();

/// Computes every figure and checks every claim, and writes figures, data and an HTML report into a folder, all of them when the
/// last is there. `progress` is told the name of each step when it is done.
///
/// # Errors
/// [`ReproduceError`] when something cannot be computed or written; that the folder cannot be is told before the work.
pub fn run(out: &Path, progress: &dyn Fn(&str)) -> Result<Report, ReproduceError> {
    let output = Output::at(out, &[REPORT, CLAIMS])?;
    let (mut drawn, mut files) = (Vec::new(), Vec::new());
    for figure in figures::ALL {
        let plate = (figure.make)()?;
        files.extend(plate.figure.files(figure.name)?);
        for (name, table) in plate.tables {
            files.push(text(format!("{name}.csv"), table));
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
    files.push(text(REPORT, report.html()));
    files.push(text(CLAIMS, report.csv()));
    output.write(&files)?;
    Ok(report)
}

/// The page with all figures and claims.
const REPORT: &str = "report.html";
/// The table of all claims.
const CLAIMS: &str = "claims.csv";

/// A study of the paper; the folder `studies/` of the repository links to it.
macro_rules! study {
    ($name:literal) => {
        $crate::settings::Study::parse(
            concat!("studies/", $name, ".toml"),
            include_str!(concat!("studies/", $name, ".toml")),
        )
    };
}
use study;

/// The type of a study constructor, so that lists of them read well.
type StudyResult = Result<Study, SettingError>;
