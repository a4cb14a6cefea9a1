//! Reproduction of the paper: its figures, its claims, and a report.

mod boundary;
mod claims;
mod figures;
mod report;

pub use claims::{Claim, ClaimVerdict};
pub use report::Report;

use crate::answers::ProblemError;
use crate::figure::Sheet;
use crate::output::{Output, OutputError, picture, text};
use crate::settings::{SettingError, Study};
use onset::method::MethodError;
use std::path::Path;
use thiserror::Error;

/// Reason why the paper cannot be reproduced.
#[derive(Debug, Error)]
pub enum ReproduceError {
    /// Error in a computation of the paper.
    #[error(transparent)]
    Problem(#[from] ProblemError),
    /// Invalid study file of the paper.
    #[error(transparent)]
    Study(#[from] SettingError),
    /// File that cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl From<MethodError> for ReproduceError {
    fn from(error: MethodError) -> Self {
        Self::Problem(error.into())
    }
}

/// Number of steps that [`run`] reports.
pub const STEP_COUNT: usize = figures::ALL.len() + claims::ALL.len();

/// Computes every figure, checks every claim, and writes figures, data and an HTML report into a folder.
///
/// Files are written after all computations, figures on the given sheet. `progress` receives the name of each finished step.
///
/// # Errors
/// [`ReproduceError`] if something cannot be computed or written; an unusable folder is reported before the computations.
pub fn run(out: &Path, sheet: Sheet, progress: &dyn Fn(&str)) -> Result<Report, ReproduceError> {
    let output = Output::at(out, &[REPORT, CLAIMS])?.on(sheet);
    let (mut drawn, mut files) = (Vec::new(), Vec::new());
    for figure in figures::ALL {
        let plate = (figure.make)()?;
        for (name, table) in plate.tables {
            files.push(text(format!("{name}.csv"), table));
        }
        drawn.push((
            figure.name.to_owned(),
            plate.figure.title.clone(),
            plate.figure.caption.clone(),
        ));
        files.push(picture(figure.name, plate.figure));
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

/// File name of the page with all figures and claims.
const REPORT: &str = "report.html";
/// File name of the table of all claims.
const CLAIMS: &str = "claims.csv";

/// Study of the paper; the folder `studies/` of the repository contains a link to it.
macro_rules! study {
    ($name:literal) => {
        $crate::settings::Study::parse(
            concat!("studies/", $name, ".toml"),
            include_str!(concat!("studies/", $name, ".toml")),
        )
    };
}
use study;

/// Result of a study constructor, for readable lists of studies.
type StudyResult = Result<Study, SettingError>;
